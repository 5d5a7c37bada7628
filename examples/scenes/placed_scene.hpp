// A scene with all its groups as hierarchies of one type: groups that are placed in others become instances.
#pragma once

#include <algorithm>
#include <chrono>
#include <functional>
#include <glm/vec2.hpp>
#include <memory>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "farfield/banded_viewer.hpp"
#include "farfield/build.hpp"
#include "farfield/build/build_progress.hpp"
#include "farfield/executor.hpp"
#include "farfield/renderer/coverage_renderer.hpp"
#include "farfield/renderer/hierarchical_z_renderer.hpp"
#include "farfield/renderer/painter_renderer.hpp"
#include "farfield/renderer/z_buffer_renderer.hpp"
#include "farfield/viewer.hpp"
#include "scenes/built_scene.hpp"
#include "scenes/how_drawn.hpp"
#include "scenes/looked_at.hpp"
#include "scenes/object.hpp"
#include "scenes/scene.hpp"

namespace farfield::scenes {

/// Colors of scenes have their light baked in, so stand-ins are made and everything is drawn without one. What is
/// placed and places nothing itself may have another type of hierarchy, `Inner`, with its partition as it is by
/// default.
template <class Hierarchy, class Inner = Hierarchy>
class PlacedScene final : public BuiltScene {
  public:
    static constexpr bool has_inner = !std::is_same_v<Hierarchy, Inner>;
    using ObjectOfScene = Object<Hierarchy, Inner>;
    using Triangle = VertexColoredTriangle;
    using Partition = typename Hierarchy::partition_type;
    using Approximation = typename Hierarchy::approximation_type;
    using CostModel = typename Hierarchy::cost_model_type;
    /// Given how many primitives a group has.
    using PartitionFor = std::function<Partition(std::size_t)>;

    PlacedScene(const Scene& scene, const PartitionFor& partition_for, Approximation approximation, CostModel cost = {},
                SceneProgress progress = {})
        : progress_(std::move(progress)), groups_(scene.groups.size()) {
        for (const auto& group : scene.groups)
            all_primitives_ += double(group.triangles.size() + group.placements.size());
        for (std::size_t g = 0; g < groups_.size(); ++g) {
            Group& group = groups_[g];
            // Triangles are copied, since each variant puts them into its own order.
            if (!scene.groups[g].placements.empty()) {
                group.objects = objects_of(scene.groups[g]);
                build(group.hierarchy, group.objects, partition_for(group.objects.size()), approximation, cost);
            } else {
                group.triangles = scene.groups[g].triangles;
                if constexpr (has_inner) {
                    if (g + 1 < groups_.size()) {
                        build(group.inner, group.triangles, typename Inner::partition_type{}, approximation, cost);
                        continue;
                    }
                }
                build(group.hierarchy, group.triangles, partition_for(group.triangles.size()), approximation, cost);
            }
        }
    }

    std::optional<PickedInScene> pick(const View& view, glm::dvec2 pixel) const override {
        const Group& root = groups_.back();
        if (root.objects.empty()) return picked(root.hierarchy, root.triangles, view, pixel);
        return picked(root.hierarchy, root.objects, view, pixel);
    }

    std::unique_ptr<SceneViewer> viewer(const RendererChoice& choice) const override {
        switch (choice.kind) {
            case RendererKind::hierarchical_z:
                return frames<HierarchicalZRenderer>(choice);
            case RendererKind::painter:
                return frames<PainterRenderer>(choice);
            case RendererKind::coverage:
                if constexpr (DrawableWith<Hierarchy, Triangle, StrictCoverageRenderer>) {
                    if (facts_.keeps_strict_order) return frames<StrictCoverageRenderer>(choice);
                }
                return frames<CoverageRenderer>(choice);
            case RendererKind::opengl:  // it models what the z-buffer does, and is behind AnyRenderer
            case RendererKind::z_buffer:
                break;
        }
        return frames<ZBufferRenderer>(choice);
    }

    /// What is in the way of drawing such a scene, to be read after the renderer's name; empty: nothing, but for the
    /// order that its hierarchies may turn out not to keep.
    static std::string_view obstacle(RendererKind kind) {
        switch (kind) {
            case RendererKind::hierarchical_z:
                return obstacle_for<HierarchicalZRenderer>();
            case RendererKind::painter:
                return obstacle_for<PainterRenderer>();
            case RendererKind::coverage:
                return obstacle_for<CoverageRenderer>();
            case RendererKind::opengl:
            case RendererKind::z_buffer:
                break;
        }
        return obstacle_for<ZBufferRenderer>();
    }

  private:
    struct Group {
        std::vector<Triangle> triangles;     ///< all of a group without placements
        std::vector<ObjectOfScene> objects;  ///< all of any other
        Hierarchy hierarchy;
        std::conditional_t<has_inner, Inner, std::monostate> inner;  ///< of placed triangles, instead

        const Inner& of_triangles() const {
            if constexpr (has_inner) {
                return inner;
            } else {
                return hierarchy;
            }
        }
    };

    template <class P, class Renderer>
    class Frames final : public SceneViewer {
      public:
        Frames(const Hierarchy& hierarchy, const std::vector<P>& primitives, const RendererChoice& choice)
            : hierarchy_(hierarchy),
              renderer_(make_renderer(choice, Renderer::facts.needs_ordering == OrderGuarantee::primitives)),
              viewer_(hierarchy, std::span<const P>(primitives), renderer_) {}
        FrameStats frame(const View& view) override { return viewer_.frame(view); }
        FrameStats frame_within(const FrameBudget& budget, const View& view) override {
            return viewer_.frame(view, budget, refinement_);
        }
        std::vector<MeasuredFrame> measured(std::span<const View> views, const FramePriceOptions& options) override {
            return measure_frames(viewer_, views, options);
        }
        Image how_drawn(const View& view) override {
            viewer_.select(view, selection_);
            return scenes::how_drawn(viewer_, selection_, [this]() -> const Image& { return image(); });
        }
        const Image* from_outside(const View* from) override {
            if (from == nullptr) return renderer_.any().from_outside();
            const LocalView local(*from, hierarchy_.origin(), hierarchy_.bounds());
            return renderer_.any().from_outside(&local);
        }
        std::vector<CellOutline> cells(const View& view, std::size_t most, bool wants_outside) override {
            viewer_.select(view, selection_);
            auto outlines = outlines_of(
                selection_, most, [&]([[maybe_unused]] const auto& entered, [[maybe_unused]] const Subtree& subtree) {
                    if constexpr (tells_hidden_after_frames) {
                        renderer_.set_view(entered.view);
                        return renderer_.hidden(subtree.cell, CellId{entered.path, subtree.node});
                    } else {
                        return false;
                    }
                });
            if (!wants_outside) return outlines;
            viewer_.select(twice_as_wide(view), selection_);
            add_outlines_outside(selection_, view, most, outlines);
            return outlines;
        }
        const Image& image() const override { return renderer_.image(); }
        unsigned texture() const override { return renderer_.any().texture(); }
        std::uint64_t sent_bytes() const override { return renderer_.any().sent_bytes(); }
        const CoverageWork* work() const override { return renderer_.any().work(); }
        const CoverageWorkImage* work_map() const override { return renderer_.any().work_map(); }

      private:
        /// Coverage masks have tiled a background over all that was vacant by then.
        static constexpr bool tells_hidden_after_frames = Renderer::facts.answers_hidden &&
                                                          !std::is_same_v<Renderer, CoverageRenderer> &&
                                                          !std::is_same_v<Renderer, StrictCoverageRenderer>;

        const Hierarchy& hierarchy_;
        RendererLike<Renderer> renderer_;
        Viewer<Hierarchy, P, RendererLike<Renderer>> viewer_;
        Selection<Hierarchy, P> selection_;
        Refinement refinement_;
    };

    /// One picture on several threads. A viewer of all of it is made for those that ask what is drawn how.
    template <class P, class Renderer>
    class BandedFrames final : public SceneViewer {
      public:
        BandedFrames(const Hierarchy& hierarchy, const std::vector<P>& primitives, const RendererChoice& choice)
            : hierarchy_(hierarchy),
              primitives_(primitives),
              choice_(choice),
              executor_(choice.threads),
              viewer_(hierarchy, std::span<const P>(primitives), bands_a_thread * choice.threads, [&](std::size_t) {
                  return RendererLike<Renderer>(
                      make_renderer(choice, Renderer::facts.needs_ordering == OrderGuarantee::primitives));
              }) {}
        FrameStats frame(const View& view) override {
            const FrameStats stats = viewer_.frame(view, executor_);
            work_ = {};
            for (std::size_t i = 0; i < viewer_.drawn_bands(); ++i) {
                if (const CoverageWork* work = viewer_.renderer(i).any().work()) work_ += *work;
            }
            return stats;
        }
        Image how_drawn(const View& view) override { return whole().how_drawn(view); }
        std::vector<CellOutline> cells(const View& view, std::size_t most, bool wants_outside) override {
            whole().frame(view);  // which cells are hidden is known to whoever draws
            return whole().cells(view, most, wants_outside);
        }
        const Image& image() const override { return viewer_.image(); }
        const CoverageWork* work() const override {
            return viewer_.renderer(0).any().work() != nullptr ? &work_ : nullptr;
        }

      private:
        static constexpr std::size_t bands_a_thread = 4;

        Frames<P, Renderer>& whole() {
            if (!whole_) whole_ = std::make_unique<Frames<P, Renderer>>(hierarchy_, primitives_, choice_);
            return *whole_;
        }

        const Hierarchy& hierarchy_;
        const std::vector<P>& primitives_;
        RendererChoice choice_;
        ThreadExecutor executor_;
        BandedViewer<Hierarchy, P, RendererLike<Renderer>> viewer_;
        CoverageWork work_;
        std::unique_ptr<Frames<P, Renderer>> whole_;
    };

    template <class Renderer>
    static constexpr std::string_view obstacle_for() {
        if (Hierarchy::ordering < Renderer::facts.needs_ordering) return "needs primitives in strict order";
        if (Approximation::facts.stands_in && !Renderer::facts.draws_faces) return "does not draw stand-ins";
        if (Approximation::facts.caches_images && !Renderer::facts.keeps_images) return "keeps no images";
        return {};
    }

    template <class Renderer>
    std::unique_ptr<SceneViewer> frames(const RendererChoice& choice) const {
        if constexpr (DrawableWith<Hierarchy, Triangle, Renderer>) {
            const Group& root = groups_.back();
            if (root.objects.empty()) return frames_of<Renderer>(root.hierarchy, root.triangles, choice);
            return frames_of<Renderer>(root.hierarchy, root.objects, choice);
        } else {
            throw std::invalid_argument("the renderer " + std::string(name_of(choice.kind)) + " " +
                                        std::string(obstacle_for<Renderer>()));
        }
    }

    template <class Renderer, class P>
    static std::unique_ptr<SceneViewer> frames_of(const Hierarchy& hierarchy, const std::vector<P>& primitives,
                                                  const RendererChoice& choice) {
        if (choice.threads > 1) {
            if (choice.kind == RendererKind::opengl) throw std::invalid_argument("one thread has the OpenGL context");
            if constexpr (caches_images<Hierarchy>) {
                throw std::invalid_argument("images are kept by one viewer on one thread: take --threads 1");
            } else {
                return std::make_unique<BandedFrames<P, Renderer>>(hierarchy, primitives, choice);
            }
        }
        return std::make_unique<Frames<P, Renderer>>(hierarchy, primitives, choice);
    }

    std::vector<ObjectOfScene> objects_of(const scenes::Group& group) const {
        std::vector<ObjectOfScene> objects;
        objects.reserve(group.triangles.size() + group.placements.size());
        for (const Triangle& t : group.triangles) objects.push_back({t});
        for (const auto& placement : group.placements) {
            const Group& inner = groups_[placement.group];
            const Similarity to_parent(placement.to_parent);
            // Nothing has no bounding box, and is not placed.
            if (!inner.objects.empty()) {
                objects.push_back({Instance<Hierarchy, ObjectOfScene>{&inner.hierarchy, inner.objects, to_parent}});
            } else if (!inner.triangles.empty()) {
                objects.push_back({Instance<Inner, Triangle>{&inner.of_triangles(), inner.triangles, to_parent}});
            }
        }
        return objects;
    }

    template <class P>
    static std::optional<PickedInScene> picked(const Hierarchy& hierarchy, const std::vector<P>& primitives,
                                               const View& view, glm::dvec2 pixel) {
        return picked_in_scene(hierarchy, std::span<const P>(primitives), view, pixel);
    }

    /// Of a group's build, whose two phases take about as long; told in parts of all groups.
    ProgressCallback progress_of(std::size_t primitives) {
        if (!progress_) return {};
        const double before = built_primitives_ / all_primitives_, own = double(primitives) / all_primitives_;
        built_primitives_ += double(primitives);
        return [this, before, own](const BuildProgress& p) {
            const double done = p.total > 0 ? double(p.done) / double(p.total) : 0;
            return progress_(before + own * 0.5 * (done + (p.phase == BuildPhase::splitting ? 0 : 1)));
        };
    }

    template <class H, class P>
    void build(H& hierarchy, std::vector<P>& primitives, const typename H::partition_type& partition,
               const Approximation& approximation, const CostModel& cost) {
        const auto begin = std::chrono::steady_clock::now();
        const BuildOptions<H> options{.partition = partition,
                                      .approximation = approximation,
                                      .cost_model = cost,
                                      .progress = progress_of(primitives.size())};
        if constexpr (H::assignment == Assignment::unique) {
            hierarchy = build_in_place<H>(primitives, options);
        } else {
            hierarchy = farfield::build<H>(primitives, options);
        }
        const bool is_first = facts_.cells == 0;
        facts_.seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
        facts_.bytes += hierarchy.bytes();
        facts_.cells += hierarchy.nodes().size();
        facts_.levels = std::max(facts_.levels, hierarchy.report().levels);
        facts_.cells_over_piece_budget += hierarchy.report().cells_over_piece_budget;
        facts_.keeps_strict_order = (is_first || facts_.keeps_strict_order) && hierarchy.keeps_strict_order();
    }

    SceneProgress progress_;
    double all_primitives_ = 0, built_primitives_ = 0;
    std::vector<Group> groups_;  ///< never resized: instances point into it
};

}  // namespace farfield::scenes
