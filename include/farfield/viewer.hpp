// One viewer's frames over one hierarchy. All that lives across frames lives here; hierarchies never change.
//
// frame/descent.hpp chooses the cut. A frame draws it as it is found, in one pass; select() keeps it
// instead (frame/selection.hpp), and draw() draws what was kept.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <ranges>
#include <span>
#include <stdexcept>
#include <type_traits>
#include <vector>

#include "farfield/composition.hpp"
#include "farfield/fail.hpp"
#include "farfield/frame/descent.hpp"
#include "farfield/frame/draw_now.hpp"
#include "farfield/frame/draw_queue.hpp"
#include "farfield/frame/frame_budget.hpp"
#include "farfield/frame/image_chooser.hpp"
#include "farfield/frame/image_maker.hpp"
#include "farfield/frame/instance_stack.hpp"
#include "farfield/frame/selection.hpp"
#include "farfield/frame/source_table.hpp"
#include "farfield/missing_hooks.hpp"
#include "farfield/primitive_source.hpp"
#include "farfield/spatial_hierarchy.hpp"
#include "farfield/view.hpp"
#include "farfield/view/local_view.hpp"

namespace farfield {

/// Whether viewers keep images of the hierarchy's cells, and of those of instances that do so too.
template <class H>
inline constexpr bool caches_images = H::approximation_type::facts.caches_images;

namespace detail {
/// What a viewer keeps from frame to frame where it keeps images.
template <class R>
struct ViewerImages {
    ViewerImages(R& renderer, SourceTable<R>& sources) : maker(renderer, sources) {}

    ImageMaker<R> maker;
    std::vector<glm::dvec3> expected;   ///< eyes of frames to come
    std::vector<glm::vec3> known_path;  ///< the same, as ExpectedPath has it
    glm::dvec3 eye{0};                  ///< the last frame's
    glm::dvec3 step{0};                 ///< how it had moved
    std::uint32_t steady_frames = 0;    ///< for so many it has moved alike
    bool has_eye = false;
};
struct NoImages {
    template <class... Ignored>
    explicit NoImages(Ignored&...) {}
};

/// What a viewer keeps of its hierarchy: a reference, or a copy of one whose uses are counted.
template <class H>
using HeldHierarchy = std::conditional_t<PagedAtRunTime<H>, H, const H&>;

/// The time during which a frame walks a hierarchy.
template <class H>
class FrameOf {
  public:
    FrameOf(const H& hierarchy, [[maybe_unused]] const View& view) : hierarchy_(hierarchy) {
        if constexpr (PagedAtRunTime<H>) {
            hierarchy_.begin_frame();
            hierarchy_.look_ahead(view);
        }
    }
    ~FrameOf() {
        if constexpr (PagedAtRunTime<H>) hierarchy_.end_frame();
    }
    FrameOf(const FrameOf&) = delete;
    FrameOf& operator=(const FrameOf&) = delete;

  private:
    const H& hierarchy_;
};

/// A range that is about to go, and what it holds with it.
template <class Range>
concept OwningTemporary =
    !std::is_lvalue_reference_v<Range> && std::ranges::range<Range> && !std::ranges::borrowed_range<Range>;
}  // namespace detail

/// Borrows hierarchy, primitives and renderer, which outlive it. Not to be used by two threads at once; many viewers
/// may share a hierarchy. Frames do not allocate once buffers have grown to what the scene needs.
template <class H, class P, class R>
class Viewer {
    static_assert(detail::check_drawable<H, P, R>());
    static_assert(
        !PagedAtRunTime<H> || detail::DrawsChangingSources<R>,
        "farfield: the hierarchy lies in pages, which needs a renderer with `draws_changing_sources`, or without "
        "`keeps_sources`");

  public:
    /// Throws std::invalid_argument if the span is not the one (by count; for hierarchies from files also by bounds)
    /// that the hierarchy, or an instance in it, was built from; or if the renderer needs polygons in strict order and
    /// one of them does not keep it.
    Viewer(const H& hierarchy, PrimitiveSpan<P> primitives, R& renderer)
        : hierarchy_(hierarchy),
          primitives_(primitives),
          renderer_(renderer),
          sources_(renderer),
          queue_(renderer, stats_),
          images_(renderer, sources_) {
        sources_.add_all(hierarchy_, primitives);
    }
    /// A viewer of what lies in pages: it takes a copy, and the renderer draws from wherever pages come to lie.
    Viewer(const H& hierarchy, R& renderer) requires PagedAtRunTime<H>
        : Viewer(hierarchy, hierarchy.primitives(), renderer) {}
    /// A viewer of the same with a renderer of its own: for another thread, or a part of the picture. It checks nothing
    /// again, and what the other has uploaded is shared where the renderers' facts say that they can. Throws
    /// std::invalid_argument if stand-ins have another light than this renderer.
    Viewer(const Viewer& other, R& renderer)
        : hierarchy_(other.hierarchy_),
          primitives_(other.primitives_),
          renderer_(renderer),
          sources_(renderer),
          queue_(renderer, stats_),
          images_(renderer, sources_) {
        // What lies in pages is another copy, by which nothing is known yet.
        if (PagedAtRunTime<H> || !sources_.add_all_of(other.sources_)) sources_.add_all(hierarchy_, primitives_);
    }
    /// What is borrowed must outlive the viewer, as what is made in the call does not.
    Viewer(const H&&, PrimitiveSpan<P>, R&) = delete;
    template <detail::OwningTemporary Range>
    Viewer(const H&, Range&&, R&) = delete;
    Viewer(const Viewer&) = delete;
    Viewer& operator=(const Viewer&) = delete;

    /// Draws into the renderer. Throws only what the renderer's begin_frame throws, for memory, and std::logic_error if
    /// the renderer says that it is gone. Whatever was thrown, the next frame is as if there had been no other.
    FrameStats frame(const View& view) {
        const LocalView local = outermost(view);
        const detail::FrameOf<H> frame(hierarchy_, view);
        begin(local, view);
        if constexpr (caches_images<H>) {
            draw_with_images(local, view);
            return end();
        }
        const AsTheyAre tint;
        detail::DrawNow<R> sink(renderer_, queue_, tint);
        detail::Descent<R, decltype(sink)> descent(sources_, instances_, stats_, sink, deposits_);
        descent.enter(hierarchy_, primitives_, local, 0);
        return end();
    }

    /// Tells where the eye will be after the next frame, one place a frame, where that is known: images are then made
    /// for as long as they will serve ("If the view trajectory is known to us in advance, we can simply search along
    /// the trajectory", Shade et al. 1996, section 3). It counts for the next frame; without it the last motion goes
    /// on.
    void expect(std::span<const glm::dvec3> eyes) requires caches_images<H> {
        images_.expected.assign(eyes.begin(), eyes.end());
    }
    /// Frees all images. What is drawn next is as if there had been no frame before.
    void forget_images() requires caches_images<H> {
        images_.maker.free_all();
        images_.has_eye = false;
        images_.step = {};
        images_.steady_frames = 0;
    }

    /// Keeps what frame() would draw without images if nothing hid anything. The renderer is not touched. Throws for
    /// memory alone. What lies in pages may be gone when it is drawn, and is not selected.
    Selection<H, P> select(const View& view) requires(!PagedAtRunTime<H>) {
        Selection<H, P> selection;
        select(view, selection);
        return selection;
    }
    /// Selects into the memory that a selection has already.
    void select(const View& view, Selection<H, P>& selection) requires(!PagedAtRunTime<H>) {
        const LocalView local = outermost(view);
        selection.select(hierarchy_, primitives_, view, local, traversal_order<H, R>,
                         [&](detail::SelectionSink& sink, FrameStats& stats) {
                             detail::Descent<R, detail::SelectionSink> descent(sources_, instances_, stats, sink,
                                                                               deposits(view));
                             descent.enter(hierarchy_, primitives_, local, 0);
                         });
    }

    /// Says what cannot be done.
    void select(const View&, auto&&...) requires PagedAtRunTime<H> {
        static_assert(
            !PagedAtRunTime<H>,
            "farfield: what lies in pages may be gone when a selection is drawn, and is not selected: draw it "
            "by frame(view)");
    }
    FrameStats frame(const View&, const FrameBudget&, auto&&...) requires PagedAtRunTime<H> {
        static_assert(!PagedAtRunTime<H>,
                      "farfield: a budget is spent on cells that can be looked up at any time, and those in pages may "
                      "be gone: draw by frame(view), with a tolerance");
        return {};
    }

    /// Draws the best that a budget pays for, without images; see frame/frame_budget.hpp. The refinement is this
    /// viewer's own. Throws what frame() throws, and std::invalid_argument for a budget that is none.
    FrameStats frame(const View& view, const FrameBudget& budget, Refinement& refinement) requires(!PagedAtRunTime<H>) {
        const LocalView local = outermost(view);
        refinement.refine(hierarchy_, primitives_, local, budget, splat_limit_px_);
        begin(local, view);
        const AsTheyAre tint;
        detail::DrawNow<R> sink(renderer_, queue_, tint);
        descend_within(refinement, local, stats_, sink, deposits_);
        return end();
    }
    /// Selects it, into memory that both keep from frame to frame.
    void select(const View& view, const FrameBudget& budget, Refinement& refinement,
                Selection<H, P>& selection) requires(!PagedAtRunTime<H>) {
        const LocalView local = outermost(view);
        refinement.refine(hierarchy_, primitives_, local, budget, splat_limit_px_);
        selection.select(hierarchy_, primitives_, view, local, traversal_order<H, R>,
                         [&](detail::SelectionSink& sink, FrameStats& stats) {
                             descend_within(refinement, local, stats, sink, deposits(view));
                         });
    }

    /// Draws a selection, which may be another viewer's, with another renderer, over the same hierarchy and primitives;
    /// every stand-in in the color that tint(Subtree) gives, if there is one. Throws std::invalid_argument if it is
    /// over others, or in an order that this renderer does not take, and what frame() throws.
    template <class Tint = AsTheyAre>
    FrameStats draw(const Selection<H, P>& selection, const Tint& tint = {}) {
        if (selection.hierarchy() != &hierarchy_ || selection.primitives().data() != primitives_.data()) {
            detail::fail<std::invalid_argument>(
                "farfield::Viewer: the selection is over another hierarchy or other primitives");
        }
        if (traversal_order<H, R> != VisitOrder::any && selection.order() != traversal_order<H, R>) {
            detail::fail<std::invalid_argument>(
                "farfield::Viewer: the selection is not in the order that the renderer needs");
        }
        const LocalView& local = selection.views().front();
        ask_renderer();
        begin(local, selection.view());
        detail::DrawNow<R, Tint> sink(renderer_, queue_, tint);
        selection.walk(detail::DrawSelected<R, decltype(sink)>{sources_, sink, deposits_});
        const FrameStats& selecting = selection.stats();
        stats_.approximations = selecting.approximations;
        stats_.instances = selecting.instances;
        for (int i = 0; i < FrameStats::max_levels; ++i) {
            stats_.approximations_by_level[i] = selecting.approximations_by_level[i];
        }
        return end();
    }

  private:
    LocalView outermost(const View& view) {
        ask_renderer();
        const bool has_splats = R::facts.draws_splats && sources_.have_stand_ins();
        LocalView local(view, hierarchy_.origin(), hierarchy_.bounds(), has_splats ? view.tolerance_px : 0.0f);
        local.splat_limit_px = splat_limit_px_;
        return local;
    }
    /// What it said last goes on when it is gone: views are still selected then.
    void ask_renderer() {
        if (!sources_.has_renderer()) return;
        splat_limit_px_ = queue_.splat_limit_px();
        if constexpr (R::facts.deposits_primitives) deposits_primitives_ = renderer_.deposits_primitives();
    }

    template <class Sink>
    void descend_within(const Refinement& refinement, const LocalView& local, FrameStats& stats, Sink& sink,
                        bool deposits) {
        if (refinement.is_complete()) {
            detail::Descent<R, Sink> descent(sources_, instances_, stats, sink, deposits);
            descent.enter(hierarchy_, primitives_, local, 0);
        } else {
            using Cut = detail::WithinBudget;
            detail::Descent<R, Sink, Cut> descent(sources_, instances_, stats, sink, deposits, refinement.cut());
            descent.enter(hierarchy_, primitives_, local, 0);
        }
    }

    void begin(const LocalView& local, const View& view) {
        sources_.check_renderer("farfield::Viewer");
        stats_ = {};
        queue_.begin_frame();
        renderer_.begin_frame(local);
        deposits_ = deposits(view);
    }

    /// A tolerance of 0 means every primitive as it is, and so does an error that is as large as point sampling's.
    bool deposits(const View& view) const {
        return deposits_primitives_ && view.tolerance_px > 0 && !view.wanted.is_point_sampling();
    }

    /// Chooses and makes images, then draws with them (Shade et al. 1996, section 2: two traversals).
    void draw_with_images(const LocalView& local, const View& view) {
        auto& maker = images_.maker;
        detail::ExpectedPath path;
        const auto along_axes = [&](glm::dvec3 way) {
            const glm::vec3 w(way);
            return glm::vec3(glm::dot(w, local.right), glm::dot(w, local.up), glm::dot(w, local.forward));
        };
        images_.known_path.clear();
        for (const glm::dvec3& eye : images_.expected) images_.known_path.push_back(along_axes(eye - view.camera.eye));
        images_.expected.clear();
        path.known = images_.known_path;
        if (images_.has_eye) {
            const glm::dvec3 step = view.camera.eye - images_.eye, change = step - images_.step;
            const bool is_steady = glm::dot(change, change) <= 0.0625 * glm::dot(step, step);
            images_.steady_frames = is_steady ? std::min(images_.steady_frames + 1, path.farthest) : 0;
            images_.step = step;
            path.step = along_axes(step);
            path.steady_frames = images_.steady_frames;
        }
        images_.eye = view.camera.eye;
        images_.has_eye = true;
        stats_.images_made = maker.update(hierarchy_, primitives_, local, path, instances_, deposits_);
        const ImageCacheOptions& options = hierarchy_.approximation_policy().images();
        detail::DrawWithImages<R> sink(renderer_, queue_, maker.kept(), options);
        detail::Descent<R, detail::DrawWithImages<R>> descent(sources_, instances_, stats_, sink, deposits_);
        descent.enter(hierarchy_, primitives_, local, 0);
        stats_.images = sink.images();
        stats_.image_bytes = maker.kept().bytes();
    }

    FrameStats end() {
        queue_.replay();
        stats_.touched_bytes += stats_.cells_visited * sizeof(Node);
        renderer_.end_frame();
        return stats_;
    }

    detail::HeldHierarchy<H> hierarchy_;
    PrimitiveSpan<P> primitives_;
    R& renderer_;
    FrameStats stats_;
    detail::SourceTable<R> sources_;
    DrawQueue<R> queue_;
    float splat_limit_px_ = 0;  ///< the renderer's, as is the next
    bool deposits_primitives_ = false;
    bool deposits_ = false;  ///< in this frame, where a law is known
    detail::InstanceStack instances_;
    std::conditional_t<caches_images<H>, detail::ViewerImages<R>, detail::NoImages> images_;
};

/// Prefer this to naming the type: where something is missing, compilers say what.
template <class H, class P, class R>
auto make_viewer(const H& hierarchy, std::span<const P> primitives, R& renderer) {
    return Viewer<H, P, R>(hierarchy, primitives, renderer);
}
template <class H, class P, class R>
auto make_viewer(const H& hierarchy, const std::vector<P>& primitives, R& renderer) {
    return Viewer<H, P, R>(hierarchy, std::span<const P>(primitives), renderer);
}
/// Of what a source of primitives answers for, see primitive_source.hpp.
template <class H, CountsPrimitives S, class R>
auto make_viewer(const H& hierarchy, const S& source, R& renderer) {
    return Viewer<H, IndexedPrimitive<S>, R>(hierarchy, IndexedSpan<S>(source), renderer);
}
template <class H, class R>
requires PagedAtRunTime<H>
auto make_viewer(const H& hierarchy, R& renderer) {
    return Viewer<H, typename H::primitive_type, R>(hierarchy, renderer);
}
/// What is made in the call is gone before the first frame: keep hierarchy, primitives and renderer in variables.
template <class H, class P, class R>
void make_viewer(const H&&, std::span<const P>, R&&) = delete;
template <class H, class P, class R>
void make_viewer(const H&&, const std::vector<P>&, R&&) = delete;
template <class H, class P, class R>
void make_viewer(const H&, const std::vector<P>&&, R&&) = delete;
template <class H, CountsPrimitives S, class R>
void make_viewer(const H&&, const S&, R&&) = delete;
template <class H, CountsPrimitives S, class R>
void make_viewer(const H&, const S&&, R&&) = delete;

}  // namespace farfield
