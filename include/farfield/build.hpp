// A hierarchy from primitives, in one call with options by name:
//
//     const auto hierarchy = build<H>(triangles, {.approximation = {.samples = 8}, .executor = ThreadExecutor()});
#pragma once

#include "farfield/settings.hpp"

#include <concepts>
#include <cstdint>
#include <functional>
#include <optional>
#include <ranges>
#include <span>
#include <stdexcept>
#include <type_traits>
#include <utility>
#include <vector>

#include "farfield/build/build_control.hpp"
#include "farfield/build/build_progress.hpp"
#include "farfield/build/hierarchy_builder.hpp"
#include "farfield/composition.hpp"
#include "farfield/executor.hpp"
#include "farfield/fail.hpp"
#include "farfield/geometry/box.hpp"
#include "farfield/hierarchy/fingerprint.hpp"
#include "farfield/missing_hooks.hpp"
#include "farfield/primitive_source.hpp"
#include "farfield/sampler/grid_sampler.hpp"
#include "farfield/spatial_hierarchy.hpp"

namespace farfield {

/// Options of a build. Same input and options give the same bytes, whatever the executor and its number of
/// threads.
template <class H, OrthographicSampler Sampler = GridSampler>
struct BuildOptions {
    typename H::partition_type partition{};
    typename H::approximation_type approximation{};
    typename H::cost_model_type cost_model{};
    /// Makes the colors of stand-ins. Give it the light that the renderer will have: `.sampler = light`.
    Sampler sampler{};
    AnyExecutor executor{};       ///< empty: everything on the thread that calls
    ProgressCallback progress{};  ///< told how far the build has come; may cancel it
    /// Bytes of nodes, stand-ins and item indices after which no cell is split any more; 0: no limit. Checked between
    /// levels, so that the result may exceed it by one level; where the partition cuts, at every cell, depth first, so
    /// that the result exceeds it by one cell's children at most and what a descent comes to last is left whole.
    std::uint64_t memory_budget_bytes = 0;
    /// Where the partition cuts: no cell is split any more when there are this many pieces for each polygon and half a
    /// million more; 0: no limit. Scenes take 2 to 4, but where all polygons cross all others their pieces grow with
    /// the square: 800 long triangles become 1.6 million. What is left together then is in no order: the report counts
    /// it, and renderers that need strict order refuse it.
    std::uint32_t most_pieces_per_polygon = 16;
    /// The root's cell is made for this space too, in the primitives' coordinates, beside all that there is. What is
    /// added in it later leaves the cells where they are, so that an update (update.hpp) need not build all anew.
    BoxD world = BoxD::empty();
};

namespace detail {

template <class Range>
concept ContiguousPrimitives = std::ranges::contiguous_range<Range> && std::ranges::sized_range<Range> &&
    Primitive<std::ranges::range_value_t<Range>>;

/// Throws std::invalid_argument if an option makes no sense.
template <class H, class Sampler>
void check_build_options(const BuildOptions<H, Sampler>& options) {
    check_options(options.partition);
    check_options(options.approximation);
    check_options(options.cost_model);
    check_options(options.sampler);
    if (options.world != BoxD::empty() && (options.world.is_empty() || !options.world.is_finite()))
        detail::fail<std::invalid_argument>("farfield: BuildOptions::world must be BoxD::empty() or a finite box");
}

/// Keeps in mind what light the sampler has given stand-ins.
template <class A, class Sampler>
void tell_light([[maybe_unused]] const Sampler& sampler, [[maybe_unused]] HierarchyFacts& facts) {
    if constexpr (A::facts.stands_in && TellsItsLight<Sampler>) {
        const std::optional<DirectionalLight> light = sampler.light;
        facts.baked_light = light ? BakedLight::directional : BakedLight::none;
        facts.light = light.value_or(DirectionalLight{});
    }
}

template <class H, class Sampler, class Span>
typename H::Data build_data(const Span& primitives, const BuildOptions<H, Sampler>& options) {
    using P = PrimitiveIn<Span>;
    const BuildControl control(options.executor, options.progress);
    check_build_options(options);
    auto data =
        HierarchyBuilder<H, P, Sampler>(
            primitives, options.partition, options.approximation, options.cost_model, options.sampler,
            {options.memory_budget_bytes, options.most_pieces_per_polygon, BuildBudget{}.free_pieces, options.world},
            control)
            .build();
    tell_light<typename H::approximation_type>(options.sampler, data.facts);
    return data;
}

}  // namespace detail

/// H is a SpatialHierarchy; any contiguous range of primitives will do. It is not kept: a Viewer is given it again.
/// Throws std::invalid_argument naming an option that makes no sense, or the first primitive whose bounding box is
/// empty or not finite, that has a cost below 0, or that is an instance of nothing; BuildCanceled if the progress
/// callback says so.
template <class H, OrthographicSampler Sampler = GridSampler, detail::ContiguousPrimitives Range>
H build(const Range& primitives, const BuildOptions<H, Sampler>& options = {}) {
    using P = std::ranges::range_value_t<Range>;
    static_assert(detail::check_buildable<H, P>());
    static_assert(detail::check_sampler<H, Sampler>());
    const std::span<const P> all(std::ranges::data(primitives), std::ranges::size(primitives));
    return H(options.partition, options.approximation, options.cost_model, detail::build_data(all, options));
}

/// Builds over a source, which answers for the primitive of an index and stores none (primitive_source.hpp). It is not
/// kept either.
template <class H, OrthographicSampler Sampler = GridSampler, CountsPrimitives S>
H build(const S& source, const BuildOptions<H, Sampler>& options = {}) {
    static_assert(detail::check_buildable<H, IndexedPrimitive<S>>());
    static_assert(detail::check_sampler<H, Sampler>());
    return H(options.partition, options.approximation, options.cost_model,
             detail::build_data(IndexedSpan<S>(source), options));
}

/// Says how a build names what it builds.
template <class Hierarchy = void, std::ranges::range Range>
requires std::is_void_v<Hierarchy>
void build(Range&&, const auto&...) {
    static_assert(
        !std::is_void_v<Hierarchy>,
        "farfield: name the hierarchy: build<SpatialHierarchy<Octree, OpacityTensor, TriangleCount>>(primitives)");
}

/// Builds as build() does, and puts the primitives into the hierarchy's order, so that no list of indices is needed:
/// four bytes a primitive less, and runs read memory in a row. Only where every primitive is stored once. Whatever is
/// thrown, the primitives are then as they were, but for what their own copies and moves throw.
template <class H, OrthographicSampler Sampler = GridSampler, detail::ContiguousPrimitives Range>
requires BuildableFrom<H, std::ranges::range_value_t<Range>> &&(H::assignment == Assignment::unique) &&
    (!std::is_const_v<std::remove_reference_t<std::ranges::range_reference_t<Range>>>)H
    build_in_place(Range&& primitives, const BuildOptions<H, Sampler>& options = {}) {
    using P = std::ranges::range_value_t<Range>;
    const std::span<P> all(std::ranges::data(primitives), std::ranges::size(primitives));
    typename H::Data data = detail::build_data(std::span<const P>(all), options);
    const std::vector<std::uint32_t> order = std::exchange(data.order, {});
    data.facts.fingerprint = detail::fingerprint_of(std::span<const P>(all), order);
    // Primitives are moved last, when nothing needs memory any more.
    std::vector<P> ordered;
    ordered.reserve(all.size());
    H hierarchy(options.partition, options.approximation, options.cost_model, std::move(data));
    for (const std::uint32_t i : order) ordered.push_back(std::move(all[i]));
    std::move(ordered.begin(), ordered.end(), all.begin());
    return hierarchy;
}

}  // namespace farfield
