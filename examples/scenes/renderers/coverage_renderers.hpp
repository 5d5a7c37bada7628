// Coverage masks as an AnyRenderer: each order is four types of tilers, each for four instruction sets. Hence a file an
// order.
#pragma once

#include <memory>
#include <stdexcept>
#include <string>
#include <type_traits>

#include "scenes/renderers/coverage_tilers.hpp"
#include "scenes/renderers/renderer_behind.hpp"

namespace farfield::scenes {

std::unique_ptr<AnyRenderer> make_lazy_coverage_renderer(const RendererChoice& choice);
std::unique_ptr<AnyRenderer> make_strict_coverage_renderer(const RendererChoice& choice);
/// The paper's table of edges instead of exact masks, lazy, 64 samples; maps no work.
std::unique_ptr<AnyRenderer> make_table_coverage_renderer(const RendererChoice& choice);

namespace detail {

template <class Order, class Samples, class Work>
struct CoverageTraits : Order {
    using samples = Samples;
    using work = Work;
};

inline CoverageOptions coverage_options(const RendererChoice& choice) {
    CoverageOptions options;
    if (choice.far_field_by_area_law) options.far_coverage = FarCoverage::area_law;
    options.culls_back_faces = choice.culls_back_faces;
    return options;
}

template <class Order, class Samples>
std::unique_ptr<AnyRenderer> make_coverage_renderer_of(const RendererChoice& choice) {
    const CoverageOptions options = coverage_options(choice);
    // The defaults are those of the ready-made renderer, whose tilers are there already.
    constexpr bool is_ready_made = std::is_same_v<Samples, typename Order::samples>;
    using Counting =
        BasicCoverageRenderer<std::conditional_t<is_ready_made, Order, CoverageTraits<Order, Samples, CoverageWork>>>;
    using Mapping = BasicCoverageRenderer<CoverageTraits<Order, Samples, CoverageWorkImage>>;
    if (choice.maps_work) return std::make_unique<RendererBehind<Mapping>>(options);
    return std::make_unique<RendererBehind<Counting>>(options);
}

}  // namespace detail

/// As make_renderer.
template <class Order>
std::unique_ptr<AnyRenderer> make_coverage_renderer(const RendererChoice& choice) {
    if (choice.samples == 64) return detail::make_coverage_renderer_of<Order, typename Order::samples>(choice);
    if (choice.samples == 1) return detail::make_coverage_renderer_of<Order, SinglePixels>(choice);
    throw std::invalid_argument("coverage masks have 1 or 64 samples a pixel, not " + std::to_string(choice.samples));
}

}  // namespace farfield::scenes
