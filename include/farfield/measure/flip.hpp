// The difference that a viewer sees who alternates between two pictures.
//
// P. Andersson, J. Nilsson, T. Akenine-Moller, M. Oskarsson, K. Astrom, M. D. Fairchild, "FLIP: A Difference
// Evaluator for Alternating Images", Proceedings of the ACM on Computer Graphics and Interactive Techniques 3(2),
// 2020 (HPG). Its form for pictures of low dynamic range: what an eye cannot resolve is filtered out, the rest
// compared in a space of colors made to be compared, and the difference raised where edges or points came or went.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/common.hpp>
#include <glm/vec3.hpp>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <vector>

#include "farfield/fail.hpp"
#include "farfield/image.hpp"
#include "farfield/measure/flip_colors.hpp"
#include "farfield/measure/flip_filters.hpp"
#include "farfield/measure/pixel_rect.hpp"

namespace farfield {

/// The paper's default, 67.02: seen from 0.7 m, on a display 0.7 m wide with 3840 pixels to a row.
inline constexpr double flip_pixels_per_degree = 3840 * std::numbers::pi / 180;

/// Mean of the errors of the pixels of `rect` (without one: all), in [0, 1]: 0 for equal colors, 0.967 for black
/// against white, 1 for the two colors farthest apart, green and blue. Colors are sRGB, as stored; alpha is not
/// compared. Symmetric.
///
/// It errs low for somebody who looks closer than `pixels_per_degree` says, or at one spot, whose error the mean
/// thins out. Pixels outside of the rectangle do not count: filters that reach beyond it see its outermost pixels
/// repeated. Time grows with `pixels_per_degree`; at the default the filters are 21 pixels wide. Throws as
/// `compared_rect` does, and std::invalid_argument unless 0 < `pixels_per_degree` <= 10'000.
double flip(const Image& variant, const Image& reference, std::optional<PixelRect> rect = {},
            double pixels_per_degree = flip_pixels_per_degree);

/// The errors that `flip` is the mean of, row by row: one for each pixel of `compared_rect`. Throws as `flip` does.
std::vector<float> flip_map(const Image& variant, const Image& reference, std::optional<PixelRect> rect = {},
                            double pixels_per_degree = flip_pixels_per_degree);

namespace detail {

/// A picture through the filters, a row at a time.
class FlipRows {
  public:
    std::vector<glm::dvec3> colors;     ///< of the last row: Hunt-adjusted L*a*b*
    std::vector<double> edges, points;  ///< of the last row: how strong, whatever their direction

    FlipRows(const Image& image, PixelRect rect, const FlipColors& space, const FlipFilters& filters)
        : colors(static_cast<std::size_t>(rect.width())),
          edges(colors.size()),
          points(colors.size()),
          image_(image),
          rect_(rect),
          space_(space),
          filters_(filters),
          radius_(static_cast<int>(std::max(filters.achromatic.size(), filters.smooth.size())) - 1),
          window_(static_cast<int>(std::min<std::int64_t>(2 * std::int64_t{radius_} + 1, rect.height()))),
          padded_(3 * (colors.size() + 2 * static_cast<std::size_t>(radius_))),
          filtered_(static_cast<std::size_t>(window_) * planes * colors.size()),
          light_(colors.size()),
          red_green_(colors.size()),
          wide_(colors.size()),
          narrow_(colors.size()),
          across_(colors.size()),
          down_(colors.size()) {}

    /// Filters the next row, from the top of the rectangle.
    void advance() {
        const int last = std::min(row_ + radius_, rect_.height() - 1);
        for (; rows_filtered_ <= last; ++rows_filtered_) filter_along(rows_filtered_);
        const auto column = [this](Plane plane) {
            return [this, plane](int i) { return filtered(plane, std::clamp(row_ + i, 0, rect_.height() - 1)); };
        };
        even(filters_.achromatic, column(achromatic), light_.data());
        even(filters_.red_green, column(red_green), red_green_.data());
        even(filters_.blue_yellow_wide, column(blue_yellow_wide), wide_.data());
        even(filters_.blue_yellow_narrow, column(blue_yellow_narrow), narrow_.data());
        const double share = filters_.blue_yellow_wide_share;
        for (std::size_t x = 0; x < colors.size(); ++x) {
            const glm::dvec3 opponent(light_[x], red_green_[x], share * wide_[x] + (1 - share) * narrow_[x]);
            colors[x] = space_.hunt_lab(glm::clamp(space_.rgb_from_opponent * opponent, 0.0, 1.0));
        }
        const auto length = [this](std::vector<double>& out) {
            for (std::size_t x = 0; x < out.size(); ++x) {
                out[x] = std::sqrt(across_[x] * across_[x] + down_[x] * down_[x]);
            }
        };
        even(filters_.smooth, column(edge), across_.data());
        odd(filters_.edge, column(smooth), down_.data());
        length(edges);
        even(filters_.smooth, column(point), across_.data());
        curvature(filters_.point, column(smooth), down_.data());
        length(points);
        ++row_;
    }

  private:
    /// A row filtered along itself, by the filter of that name.
    enum Plane : std::size_t {
        achromatic,
        red_green,
        blue_yellow_wide,
        blue_yellow_narrow,
        smooth,
        edge,
        point,
        planes
    };

    double* filtered(Plane plane, int row) {
        return filtered_.data() + (static_cast<std::size_t>(row % window_) * planes + plane) * colors.size();
    }

    void filter_along(int row) {
        const std::size_t length = padded_.size() / 3;
        for (std::size_t i = 0; i < length; ++i) {
            const int x = std::clamp(static_cast<int>(i) - radius_, 0, rect_.width() - 1);
            const glm::dvec3 c = space_.opponent(image_.at(rect_.x0 + x, rect_.y0 + row));
            for (int k = 0; k < 3; ++k) padded_[static_cast<std::size_t>(k) * length + i] = c[k];
        }
        const auto along = [&](std::size_t channel) {
            return [this, first = padded_.data() + channel * length](int i) { return first + (radius_ + i); };
        };
        even(filters_.achromatic, along(0), filtered(achromatic, row));
        even(filters_.red_green, along(1), filtered(red_green, row));
        even(filters_.blue_yellow_wide, along(2), filtered(blue_yellow_wide, row));
        even(filters_.blue_yellow_narrow, along(2), filtered(blue_yellow_narrow, row));
        even(filters_.smooth, along(0), filtered(smooth, row));
        odd(filters_.edge, along(0), filtered(edge, row));
        curvature(filters_.point, along(0), filtered(point, row));
    }

    // `tap(i)` gives the pixels i to the right of, or below, those of a row.
    template <class Tap>
    void even(const FlipFilters::Weights& weights, const Tap& tap, double* out) const {
        const double* middle = tap(0);
        for (std::size_t x = 0; x < colors.size(); ++x) out[x] = weights[0] * middle[x];
        add_pairs(weights, tap, out, [](double before, double, double after) { return before + after; });
    }

    // Both are exactly 0 where there is nothing to detect: the square root taken later would make much of a rounding
    // error.
    template <class Tap>
    void odd(const FlipFilters::Weights& weights, const Tap& tap, double* out) const {
        std::fill_n(out, colors.size(), 0.0);
        add_pairs(weights, tap, out, [](double before, double, double after) { return after - before; });
    }
    template <class Tap>
    void curvature(const FlipFilters::Weights& weights, const Tap& tap, double* out) const {
        std::fill_n(out, colors.size(), 0.0);
        add_pairs(weights, tap, out,
                  [](double before, double middle, double after) { return (before - middle) + (after - middle); });
    }

    template <class Tap, class Pair>
    void add_pairs(const FlipFilters::Weights& weights, const Tap& tap, double* out, const Pair& pair) const {
        const double* middle = tap(0);
        for (int i = 1; i < static_cast<int>(weights.size()); ++i) {
            const double weight = weights[static_cast<std::size_t>(i)];
            const double* before = tap(-i);
            const double* after = tap(i);
            for (std::size_t x = 0; x < colors.size(); ++x) out[x] += weight * pair(before[x], middle[x], after[x]);
        }
    }

    const Image& image_;
    PixelRect rect_;
    const FlipColors& space_;
    const FlipFilters& filters_;
    int radius_;
    int window_;             ///< rows kept: as many as a filter reaches
    int row_ = 0;            ///< the next one to be filtered
    int rows_filtered_ = 0;  ///< along the row
    std::vector<double> padded_, filtered_;
    std::vector<double> light_, red_green_, wide_, narrow_, across_, down_;  ///< of the last row
};

/// Calls use(error) for each pixel of the rectangle.
template <class Use>
void for_each_flip_error(const Image& variant, const Image& reference, PixelRect rect, double pixels_per_degree,
                         const Use& use) {
    if (!(pixels_per_degree > 0 && pixels_per_degree <= 10'000)) {
        detail::fail<std::invalid_argument>("farfield::flip: pixels_per_degree must be above 0 and at most 10000");
    }
    const FlipColors space;
    const FlipFilters filters(pixels_per_degree);
    FlipRows a(variant, rect, space, filters);
    FlipRows b(reference, rect, space, filters);
    for (int y = rect.y0; y < rect.y1; ++y) {
        a.advance();
        b.advance();
        for (std::size_t x = 0; x < a.colors.size(); ++x) {
            const double feature = std::max(std::abs(a.edges[x] - b.edges[x]), std::abs(a.points[x] - b.points[x]));
            use(std::pow(space.error(a.colors[x], b.colors[x]), 1 - std::sqrt(feature / std::numbers::sqrt2)));
        }
    }
}

}  // namespace detail

inline double flip(const Image& variant, const Image& reference, std::optional<PixelRect> rect,
                   double pixels_per_degree) {
    const PixelRect r = compared_rect(variant, reference, rect);
    double sum = 0;
    detail::for_each_flip_error(variant, reference, r, pixels_per_degree, [&](double error) { sum += error; });
    return sum / (static_cast<double>(r.width()) * r.height());
}

inline std::vector<float> flip_map(const Image& variant, const Image& reference, std::optional<PixelRect> rect,
                                   double pixels_per_degree) {
    const PixelRect r = compared_rect(variant, reference, rect);
    std::vector<float> errors;
    errors.reserve(static_cast<std::size_t>(r.width()) * static_cast<std::size_t>(r.height()));
    detail::for_each_flip_error(variant, reference, r, pixels_per_degree,
                                [&](double error) { errors.push_back(static_cast<float>(error)); });
    return errors;
}

}  // namespace farfield
