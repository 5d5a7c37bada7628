// The filters of FLIP; see flip.hpp for the paper.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <vector>

namespace farfield::detail {

/// All filters are products of two axes, or sums of two such products. Here is one axis: the weights of the pixels at
/// distance 0, 1, ... to either side.
struct FlipFilters {
    using Weights = std::vector<double>;

    /// Filters for the detail that an eye resolves (section "Spatial Filtering"): Gaussians of sum 1.
    Weights achromatic, red_green, blue_yellow_wide, blue_yellow_narrow;
    double blue_yellow_wide_share = 1;  ///< the narrow one has the rest
    /// Filters for the features that it is drawn to (section "Feature Detection"): a Gaussian of sum 1, and its first
    /// and second derivative, both with positive weights of sum 1 and negative ones of sum -1. `edge` holds the
    /// positive ones.
    Weights smooth, edge, point;

    explicit FlipFilters(double pixels_per_degree) {
        constexpr double pi = std::numbers::pi;
        const auto sum = [](const Weights& w) {
            double result = 0;
            for (std::size_t i = w.size() - 1; i > 0; --i) result += w[i];
            return w[0] + 2 * result;
        };
        const auto scaled = [](Weights w, double factor) {
            for (double& weight : w) weight *= factor;
            return w;
        };
        const auto filled = [](double radius, auto&& weight) {
            Weights w(static_cast<std::size_t>(radius) + 1);
            for (std::size_t i = 0; i < w.size(); ++i) w[i] = weight(static_cast<double>(i));
            return w;
        };
        // a sqrt(pi / b) exp(-(pi x)^2 / b), x in degrees, with the paper's a and b; the widest sets the radius.
        constexpr double a1 = 34.1, b1 = 0.04, a2 = 13.5, b2 = 0.025;
        const double radius = std::ceil(3 * std::sqrt(b1 / (2 * pi * pi)) * pixels_per_degree);
        const auto gaussian = [&](double b) {
            return filled(radius, [&](double x) {
                const double angle = pi * (x / pixels_per_degree);
                return std::exp(-angle * angle / b);
            });
        };
        const auto normalized = [&](const Weights& w) { return scaled(w, 1 / sum(w)); };
        achromatic = normalized(gaussian(0.0047));
        red_green = normalized(gaussian(0.0053));
        const double volume1 = a1 * std::sqrt(pi / b1) * sum(gaussian(b1)) * sum(gaussian(b1));
        const double volume2 = a2 * std::sqrt(pi / b2) * sum(gaussian(b2)) * sum(gaussian(b2));
        blue_yellow_wide = normalized(gaussian(b1));
        blue_yellow_narrow = normalized(gaussian(b2));
        blue_yellow_wide_share = volume1 / (volume1 + volume2);

        // Half of the distance from trough to peak of the eye's edge detector, 0.082 degrees. Below a third of a pixel
        // the radius is 1 and the weights are the same for any sigma: one is taken with which none underflows.
        const double sigma = std::max(0.5 * 0.082 * pixels_per_degree, 0.1);
        const double reach = std::ceil(3 * sigma);
        const auto bell = [&](double x) { return std::exp(-x * x / (2 * sigma * sigma)); };
        smooth = normalized(filled(reach, bell));
        edge = filled(reach, [&](double x) { return x * bell(x); });
        edge = scaled(edge, 2 / sum(edge));
        point = filled(reach, [&](double x) { return std::max(x * x / (sigma * sigma) - 1, 0.0) * bell(x); });
        const Weights trough =
            filled(reach, [&](double x) { return std::max(1 - x * x / (sigma * sigma), 0.0) * bell(x); });
        const double peak_sum = sum(point), trough_sum = sum(trough);
        for (std::size_t i = 0; i < point.size(); ++i) point[i] = point[i] / peak_sum - trough[i] / trough_sum;
    }
};

}  // namespace farfield::detail
