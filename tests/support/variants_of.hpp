// Puts triples behind the interface of variants.hpp. For variants_*.cpp alone: this is what takes long to compile.
#pragma once

#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "farfield/build.hpp"
#include "farfield/paging/file_notes.hpp"
#include "farfield/spatial_hierarchy.hpp"
#include "farfield/storage/notes.hpp"
#include "farfield/storage/open.hpp"
#include "farfield/storage/save.hpp"
#include "farfield/tuning/kept_error_table.hpp"
#include "farfield/viewer.hpp"
#include "support/triples.hpp"
#include "support/variants.hpp"

namespace farfield::test {

template <class H>
class HierarchyOver final : public AnyHierarchy {
    using A = typename H::approximation_type;
    template <class R>
    struct ViewerOf final : AnyViewer {
        Viewer<H, Triangle, R> viewer;
        ViewerOf(const H& h, std::span<const Triangle> triangles, R& renderer) : viewer(h, triangles, renderer) {
            caches_images = farfield::caches_images<H>;
        }
        FrameStats frame(const View& view) override { return viewer.frame(view); }
    };
    H hierarchy_;
    std::span<const Triangle> triangles_;

  public:
    HierarchyOver(H h, std::span<const Triangle> triangles) : hierarchy_(std::move(h)), triangles_(triangles) {}

    std::span<const Node> nodes() const override { return hierarchy_.nodes(); }
    std::span<const std::uint32_t> order() const override { return hierarchy_.order(); }
    const Fragments& fragments() const override { return hierarchy_.fragments(); }
    std::uint32_t item_count() const override { return hierarchy_.item_count(); }
    const BuildReport& report() const override { return hierarchy_.report(); }
    const Box& bounds() const override { return hierarchy_.bounds(); }
    const Cell& root_cell() const override { return hierarchy_.root_cell(); }
    Cell child(const Cell& cell, std::uint32_t node, unsigned child) const override {
        return hierarchy_.partition_policy().child(cell, hierarchy_.data_of(node), child);
    }
    void front_to_back(const Cell& cell, std::uint32_t node, glm::vec4 viewpoint, ChildOrder& order) const override {
        hierarchy_.partition_policy().front_to_back(cell, hierarchy_.data_of(node), viewpoint, order);
    }
    std::size_t stand_in_count() const override { return hierarchy_.stand_ins().size(); }
    bool root_has_stand_in() const override { return hierarchy_.root_stand_in() != nullptr; }
    float error_px(std::size_t stand_in, const Cell& cell, const LocalView& view) const override {
        if constexpr (A::facts.stands_in) {
            return hierarchy_.approximation_policy().error_px(hierarchy_.stand_ins()[stand_in], cell, view);
        } else {
            return std::numeric_limits<float>::infinity();
        }
    }
    float least_error_px(const Cell& cell, unsigned levels, const LocalView& view) const override {
        if constexpr (A::facts.bounds_error) {
            return hierarchy_.approximation_policy().least_error_px(cell, levels, view);
        } else {
            return 0;
        }
    }
    float cost_of(std::size_t stand_in) const override {
        if constexpr (A::facts.stands_in) {
            return cost(farfield::detail::work_of_stand_in(hierarchy_.approximation_policy(),
                                                           hierarchy_.stand_ins()[stand_in]));
        } else {
            return 0;
        }
    }
    float cost(const Work& work) const override { return hierarchy_.cost_policy().cost(work); }
    std::vector<std::byte> bytes() const override {
        std::vector<std::byte> out;
        const auto add = [&](auto span) {
            if (span.empty()) return;
            const auto b = std::as_bytes(span);
            out.insert(out.end(), b.begin(), b.end());
        };
        add(hierarchy_.nodes());
        add(hierarchy_.order());
        add(hierarchy_.fragments().first_vertex);
        add(hierarchy_.fragments().colors);
        if constexpr (!std::is_empty_v<typename H::stand_in_data>) add(hierarchy_.stand_ins());
        if constexpr (!std::is_empty_v<typename H::pool_element>) add(hierarchy_.pool());
        return out;
    }
    std::optional<SampledErrorTable> stored(const SampledErrorTable& table) const override {
        const MeasuredWith with{"z-buffer", 64, 64};
        Notes notes;
        keep_error_table(table, with, hierarchy_, notes);
        std::vector<std::byte> bytes(saved_size(hierarchy_, notes));
        save(hierarchy_, std::span(bytes), notes);
        const std::span<const std::byte> saved(bytes);
        return kept_error_table(with, open<H>(saved), read_notes(saved));
    }
    std::unique_ptr<AnyHierarchy> stored() const override {
        static_assert(Storable<H>, "every variant that the library offers can be saved");
        auto bytes = std::make_shared<std::vector<std::byte>>(saved_size(hierarchy_));
        save(hierarchy_, std::span(*bytes));
        const std::span<const std::byte> saved(*bytes);
        return std::make_unique<HierarchyOver>(open<H>(saved, {}, bytes), triangles_);
    }
    std::unique_ptr<AnyViewer> viewer(ZBufferRenderer& r) const override {
        return std::make_unique<ViewerOf<ZBufferRenderer>>(hierarchy_, triangles_, r);
    }
    std::unique_ptr<AnyViewer> viewer(Recorder& r) const override {
        return std::make_unique<ViewerOf<Recorder>>(hierarchy_, triangles_, r);
    }
    std::unique_ptr<AnyViewer> viewer_of(std::span<const Triangle> other, Recorder& r) const override {
        return std::make_unique<ViewerOf<Recorder>>(hierarchy_, other, r);
    }
};

inline const char* name_of(const Octree&) {
    return "Octree";
}
inline const char* name_of(const SharedOctree&) {
    return "SharedOctree";
}
inline const char* name_of(const PolygonBsp&) {
    return "PolygonBsp";
}
inline const char* name_of(const OctreeOfBsps&) {
    return "OctreeOfBsps";
}

inline const char* name_of(const GapBsp&) {
    return "GapBsp";
}
template <class... H>
std::vector<Variant> variants_of(const char* approximation, std::tuple<H...>*) {
    return {Variant{
        std::string(name_of(typename H::partition_type{})) + ", " + approximation + ", " + H::cost_model_type::unit,
        H::assignment == Assignment::shared, H::assignment == Assignment::clipped,
        H::approximation_type::facts.stands_in, H::partition_type::facts.children_are_octants, caches_images<H>,
        [](std::span<const Triangle> triangles, std::uint64_t memory_budget_bytes, const GridSampler& sampler) {
            typename H::approximation_type how{};
            if constexpr (caches_images<H>) {
                how.image_options.least_items = 64;  // scenes of tests are small
                how.image_options.samples = 16;      // and their pictures are compared with finer ones
            }
            return std::unique_ptr<AnyHierarchy>(std::make_unique<HierarchyOver<H>>(
                build<H>(triangles,
                         {.approximation = how, .sampler = sampler, .memory_budget_bytes = memory_budget_bytes}),
                triangles));
        }}...};
}

}  // namespace farfield::test
