// Scenes that change: a hierarchy of the next version from that of the last, without a build.
//
//     HierarchyUpdater<H, Triangle> updater(triangles, {.world = space});
//     std::vector<Triangle> next = triangles;
//     const Changed changed = Change<Triangle>{.erased = {7}, .inserted = {roof}}.apply_to(next);
//     const H hierarchy = updater.update(next, changed.indices);
//
// "Dynamic updates of scenes could be very useful": future work of Klein et al. 2002 (section 8), for every
// approximation.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "farfield/build.hpp"
#include "farfield/build/build_control.hpp"
#include "farfield/build/cell_tree.hpp"
#include "farfield/fail.hpp"
#include "farfield/primitive.hpp"
#include "farfield/primitive_source.hpp"
#include "farfield/sampler/grid_sampler.hpp"

namespace farfield {

/// Where a change has put things.
struct Changed {
    struct Renumbered {
        std::uint32_t from = 0, to = 0;
        friend bool operator==(const Renumbered&, const Renumbered&) = default;
    };
    /// All that differ from those before, ascending, with indices that are no more: what HierarchyUpdater::update()
    /// asks for.
    std::vector<std::uint32_t> indices{};
    /// Primitives that have another index now.
    std::vector<Renumbered> renumbered{};
};

namespace detail {
/// Sorts indices; throws std::invalid_argument if one is not below `count` or is there twice, in these words.
inline void sort_named(std::vector<std::uint32_t>& indices, std::size_t count, const char* who, const char* too_large,
                       const char* there_twice) {
    std::sort(indices.begin(), indices.end());
    if (!indices.empty() && indices.back() >= count) {
        fail<std::invalid_argument>(who + std::to_string(indices.back()) + too_large + std::to_string(count));
    }
    const auto twice = std::adjacent_find(indices.begin(), indices.end());
    if (twice != indices.end()) fail<std::invalid_argument>(who + std::to_string(*twice) + there_twice);
}
}  // namespace detail

/// What becomes of primitives, by their indices before: those that go, those that are replaced (by themselves in
/// another place, say), and those that are new.
template <class P>
struct Change {
    struct Moved {
        std::uint32_t index = 0;
        P primitive;
    };
    std::vector<std::uint32_t> erased{};
    std::vector<Moved> moved{};
    std::vector<P> inserted{};

    /// What is new takes the places of what is erased, then comes at the end; places that are left go to the last
    /// primitives, so that few get another index. Takes time by the size of the change alone, where the vector has room
    /// for it. Throws std::invalid_argument that names an index which is out of range or is there twice; the primitives
    /// are then as they were.
    Changed apply_to(std::vector<P>& primitives) const {
        Changed out;
        out.indices = named(primitives.size());
        primitives.reserve(primitives.size() + inserted.size());
        for (const Moved& m : moved) primitives[m.index] = m.primitive;
        std::vector<std::uint32_t> places = erased;
        std::sort(places.begin(), places.end());
        std::size_t filled = 0;
        for (const P& p : inserted) {
            if (filled < places.size()) {
                primitives[places[filled++]] = p;
            } else {
                out.indices.push_back(std::uint32_t(primitives.size()));
                primitives.push_back(p);
            }
        }
        while (filled < places.size()) {
            const auto last = std::uint32_t(primitives.size() - 1);
            if (places.back() == last) {
                places.pop_back();
            } else {
                const std::uint32_t to = places[filled++];
                primitives[to] = std::move(primitives[last]);
                out.renumbered.push_back({last, to});
                out.indices.push_back(last);
            }
            primitives.pop_back();
        }
        std::sort(out.indices.begin(), out.indices.end());
        out.indices.erase(std::unique(out.indices.begin(), out.indices.end()), out.indices.end());
        return out;
    }

  private:
    /// Ascending.
    std::vector<std::uint32_t> named(std::size_t count) const {
        std::vector<std::uint32_t> all = erased;
        for (const Moved& m : moved) all.push_back(m.index);
        detail::sort_named(all, count, "farfield::Change: primitive ", " is to be changed and there are ",
                           " is erased or moved twice");
        return all;
    }
};

/// Makes versions of a hierarchy as its primitives change. Each is an H of its own, the same bytes as build() of its
/// primitives with the same options: those before stay as they are, and so do their viewers, as long as the primitives
/// that they were given do.
///
/// What did not change is shared: what has been decided, sampled and fitted for a cell is kept here, for all versions
/// to come, and made anew only where primitives of the cell changed. That takes 60 bytes a primitive and a half to two
/// kilobytes a cell: 70 MB of a million triangles without stand-ins, 115 with OpacityTensor, 190 in a SampleSet, 360 in
/// one of tensors. Arrays of a version are its own, for frames read them in a row: what is the same is copied, and of a
/// million triangles that is most of the time of a small change. In a scene of instances the hierarchies that these
/// hold are shared by all versions. Where data lie in a pool, and where a parent's stand-in is sampled from all below
/// it (a ColorCube that does not composite), more is done than cells that changed need.
///
/// Everything is built anew, as build() does, where the root's cell changes (bounds of all primitives that leave
/// BuildOptions::world, or any change of bounds without one), with a memory budget, and where the partition does not
/// decide cell by cell (`updates_cells`).
template <class H, Primitive P, OrthographicSampler Sampler = GridSampler>
class HierarchyUpdater {
  public:
    static constexpr bool updates_cells = detail::decides_cell_by_cell<H>;

    /// Builds the first version; throws what build() throws.
    explicit HierarchyUpdater(PrimitiveSpan<P> primitives, const BuildOptions<H, Sampler>& options = {})
        : options_(options), tree_(make_tree(options)) {
        static_assert(detail::check_buildable<H, P>());
        static_assert(detail::check_sampler<H, Sampler>());
        detail::check_build_options(options);
        make(primitives, {});
    }

    /// The latest version.
    const H& hierarchy() const { return hierarchy_; }

    /// `primitives` differ from the latest version's at the indices `changed` alone, in any order. Those beyond the end
    /// of the shorter of both ranges need not be named. Any executor gives the same bytes.
    ///
    /// Throws std::invalid_argument naming an index that is out of range or is there twice, or what build() throws; the
    /// latest version is then what it was, and the next call may be about any primitives whatever and builds anew.
    const H& update(PrimitiveSpan<P> primitives, std::span<const std::uint32_t> changed) {
        const std::size_t before = hierarchy_.primitive_count();
        const std::size_t fewer = std::min(before, primitives.size()), more = std::max(before, primitives.size());
        std::vector<std::uint32_t> all(changed.begin(), changed.end());
        detail::sort_named(all, more, "farfield::HierarchyUpdater: primitive ",
                           " has changed, it is said, and there are ", " is named twice");
        all.erase(std::lower_bound(all.begin(), all.end(), fewer), all.end());
        detail::check_primitive_count(primitives.size());
        for (std::size_t i = fewer; i < more; ++i) all.push_back(std::uint32_t(i));
        make(primitives, all);
        return hierarchy_;
    }

  private:
    struct NoTree {};
    static auto make_tree([[maybe_unused]] const BuildOptions<H, Sampler>& options) {
        if constexpr (updates_cells) {
            return detail::CellTree<H, P, Sampler>(options.partition, options.approximation, options.cost_model,
                                                   options.sampler, options.world);
        } else {
            return NoTree{};
        }
    }

    void make(PrimitiveSpan<P> primitives, [[maybe_unused]] std::span<const std::uint32_t> changed) {
        if constexpr (updates_cells) {
            if (options_.memory_budget_bytes == 0) {
                const detail::BuildControl control(options_.executor, options_.progress);
                const bool knows_cells = std::exchange(knows_cells_, false);
                typename H::Data data = knows_cells ? tree_.update(primitives, changed, hierarchy_.arrays(), control)
                                                    : tree_.build(primitives, control);
                detail::tell_light<typename H::approximation_type>(options_.sampler, data.facts);
                set(std::move(data));
                knows_cells_ = true;
                return;
            }
        }
        set(detail::build_data(primitives, options_));
    }
    void set(typename H::Data data) {
        hierarchy_ = H(options_.partition, options_.approximation, options_.cost_model, std::move(data));
    }

    BuildOptions<H, Sampler> options_;
    H hierarchy_;
    decltype(make_tree(std::declval<const BuildOptions<H, Sampler>&>())) tree_;
    bool knows_cells_ = false;
};

}  // namespace farfield
