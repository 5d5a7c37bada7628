// Structural similarity of two pictures.
//
// Z. Wang, A. C. Bovik, H. R. Sheikh, E. P. Simoncelli, "Image Quality Assessment: From Error Visibility to
// Structural Similarity", IEEE Transactions on Image Processing 13(4), 2004; section III.B for the index,
// III.C for the window and the constants. As in the authors' implementation the windows lie inside of the
// picture, none is padded. Unlike their later advice the pictures are not shrunk first: a pixel here is a
// pixel that somebody looks at.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <vector>

#include "farfield/image.hpp"
#include "farfield/measure/pixel_rect.hpp"

namespace farfield {

/// Mean structural similarity of the luma (Rec. 601) of two pictures over `rect` (without one: all of them), in [-1,
/// 1]: exactly 1 for equal luma, near 0 where nothing corresponds, negative where light and dark are exchanged.
/// Symmetric. Alpha is not compared.
///
/// The mean is over the Gaussian windows of 11 x 11 pixels that lie inside of the rectangle, so the outer 5
/// pixels count less; pixels outside of it do not count at all. Along an axis with fewer than 11 pixels there
/// is one window around each pixel instead, clipped to the rectangle, its weights scaled to sum 1: defined
/// down to a single pixel, but there it compares means only. Throws as `compared_rect` does.
double ssim(const Image& variant, const Image& reference, std::optional<PixelRect> rect = {});

namespace detail {

/// One axis of one window: weights of the pixels `first`, `first` + 1, ... that sum to 1.
struct SsimWindow {
    static constexpr int size = 11;

    int first = 0;
    int count = 0;
    std::array<double, size> weights{};
};

/// The windows along an axis of `length` pixels, in order.
inline std::vector<SsimWindow> ssim_windows(int length) {
    constexpr int radius = SsimWindow::size / 2;
    constexpr double sigma = 1.5;
    const bool clipped = length < SsimWindow::size;
    std::vector<SsimWindow> windows;
    for (int center = clipped ? 0 : radius; center < (clipped ? length : length - radius); ++center) {
        SsimWindow w;
        w.first = std::max(center - radius, 0);
        w.count = std::min(center + radius + 1, length) - w.first;
        double sum = 0;
        for (int i = 0; i < w.count; ++i) {
            const double d = w.first + i - center;
            sum += w.weights[static_cast<std::size_t>(i)] = std::exp(-d * d / (2 * sigma * sigma));
        }
        for (double& weight : w.weights) weight /= sum;
        windows.push_back(w);
    }
    return windows;
}

/// Weighted means that the index is made of: of two lumas, their squares and their product.
struct SsimMoments {
    double a = 0, b = 0, aa = 0, bb = 0, ab = 0;

    void add(double weight, const SsimMoments& m) {
        a += weight * m.a;
        b += weight * m.b;
        aa += weight * m.aa;
        bb += weight * m.bb;
        ab += weight * m.ab;
    }

    /// Wang et al. 2004, equation 13.
    double index() const {
        constexpr double c1 = 0.01 * 0.01;  // (K1 L)^2 with the dynamic range L = 1
        constexpr double c2 = 0.03 * 0.03;
        const double variance_a = aa - a * a;
        const double variance_b = bb - b * b;
        const double covariance = ab - a * b;
        return ((2 * a * b + c1) * (2 * covariance + c2)) / ((a * a + b * b + c1) * (variance_a + variance_b + c2));
    }
};

/// Luma in [0, 1], Rec. 601, of the colors as stored. Summed in integers, so that gray 255 is exactly 1.
inline double ssim_luma(Rgba8 c) {
    return double(299 * c.r + 587 * c.g + 114 * c.b) / 255000.0;
}

}  // namespace detail

inline double ssim(const Image& variant, const Image& reference, std::optional<PixelRect> rect) {
    using detail::SsimMoments;
    using detail::SsimWindow;
    const PixelRect r = compared_rect(variant, reference, rect);
    const std::vector<SsimWindow> columns = detail::ssim_windows(r.width());
    const std::vector<SsimWindow> rows = detail::ssim_windows(r.height());

    // A two-dimensional Gaussian is a product, and so is one clipped to a rectangle: rows are filtered once
    // and kept as long as a window reaches them.
    std::vector<SsimMoments> pixels(static_cast<std::size_t>(r.width()));
    std::vector<SsimMoments> filtered(columns.size() * SsimWindow::size);
    const auto filtered_row = [&](int y) {
        return filtered.data() + columns.size() * static_cast<std::size_t>(y % SsimWindow::size);
    };
    const auto filter_row = [&](int y) {
        for (int x = 0; x < r.width(); ++x) {
            const double a = detail::ssim_luma(variant.at(r.x0 + x, r.y0 + y));
            const double b = detail::ssim_luma(reference.at(r.x0 + x, r.y0 + y));
            pixels[static_cast<std::size_t>(x)] = {a, b, a * a, b * b, a * b};
        }
        SsimMoments* out = filtered_row(y);
        for (const SsimWindow& w : columns) {
            SsimMoments mean;
            for (int i = 0; i < w.count; ++i) {
                mean.add(w.weights[static_cast<std::size_t>(i)], pixels[static_cast<std::size_t>(w.first + i)]);
            }
            *out++ = mean;
        }
    };

    double sum = 0;
    int rows_filtered = 0;
    for (const SsimWindow& row : rows) {
        for (; rows_filtered < row.first + row.count; ++rows_filtered) filter_row(rows_filtered);
        for (std::size_t column = 0; column < columns.size(); ++column) {
            SsimMoments mean;
            for (int i = 0; i < row.count; ++i) {
                mean.add(row.weights[static_cast<std::size_t>(i)], filtered_row(row.first + i)[column]);
            }
            sum += mean.index();
        }
    }
    return sum / (static_cast<double>(columns.size()) * static_cast<double>(rows.size()));
}

}  // namespace farfield
