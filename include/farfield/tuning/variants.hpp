// Experiments over variants: every composition of some partitions, approximations and cost models, from one
// compile-time list. Concepts, not people, leave out what does not compose.
#pragma once

#include "farfield/settings.hpp"

#include <ranges>
#include <string>
#include <string_view>
#include <tuple>
#include <utility>

#include "farfield/build.hpp"
#include "farfield/composition.hpp"
#include "farfield/spatial_hierarchy.hpp"

namespace farfield {

/// A policy and its name in tables. An empty name stands for the default, which is not worth mentioning.
template <class Policy>
struct Named {
    std::string_view name;
    Policy policy;
};
template <class Policy>
Named(const char*, Policy) -> Named<Policy>;

/// A type of hierarchy and the policies it is built with.
template <Partition Partition_, Approximation A, CostModel C>
requires Composable<Partition_, A, C>
struct NamedVariant {
    using hierarchy_type = SpatialHierarchy<Partition_, A, C>;

    std::string name;  ///< names of the policies, approximation first, joined by '+'
    Partition_ partition;
    A approximation;
    C cost_model;

    /// Calls farfield::build with the variant's own policies in place of those in `options`.
    template <OrthographicSampler Sampler = GridSampler, detail::ContiguousPrimitives Range>
    requires BuildableFrom<hierarchy_type, std::ranges::range_value_t<Range>> hierarchy_type
    build(const Range& primitives, BuildOptions<hierarchy_type, Sampler> options = {})
    const {
        options.partition = partition;
        options.approximation = approximation;
        options.cost_model = cost_model;
        return farfield::build<hierarchy_type, Sampler>(primitives, options);
    }
};

namespace detail {

template <class Partition_, class A, class C>
auto variant_if_composable(const Named<Partition_>& p, const Named<A>& a, const Named<C>& c) {
    if constexpr (Composable<Partition_, A, C>) {
        std::string name(a.name);
        for (const std::string_view part : {p.name, c.name}) {
            if (!name.empty() && !part.empty()) name += '+';
            name += part;
        }
        return std::tuple(NamedVariant<Partition_, A, C>{std::move(name), p.policy, a.policy, c.policy});
    } else {
        return std::tuple<>();
    }
}

}  // namespace detail

/// Every composition of one policy from each tuple of Named ones, as a tuple of NamedVariant; the last tuple varies
/// fastest and the approximation slowest.
template <class... Partition_, class... A, class... C>
auto variants_of(const std::tuple<Named<Partition_>...>& partitions, const std::tuple<Named<A>...>& approximations,
                 const std::tuple<Named<C>...>& costs) {
    const auto with_both = [&](const auto& a, const auto& p) {
        return std::apply([&](const auto&... c) { return std::tuple_cat(detail::variant_if_composable(p, a, c)...); },
                          costs);
    };
    const auto with_approximation = [&](const auto& a) {
        return std::apply([&](const auto&... p) { return std::tuple_cat(with_both(a, p)...); }, partitions);
    };
    return std::apply([&](const auto&... a) { return std::tuple_cat(with_approximation(a)...); }, approximations);
}

/// Calls f(variant) for each, in order.
template <class... V, class F>
void for_each_variant(const std::tuple<V...>& variants, F&& f) {
    std::apply([&](const auto&... v) { (f(v), ...); }, variants);
}

}  // namespace farfield
