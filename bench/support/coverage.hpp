// What a picture without a background covers.
#pragma once

#include "farfield/image.hpp"

namespace farfield::bench {

/// Pixels.
inline double coverage(const Image& image) {
    double sum = 0;
    for (const Rgba8 c : image.pixels()) sum += c.a;
    return sum / 255;
}

/// What a picture lacks inside its reference's silhouette: where all nine pixels about one are covered altogether.
struct Tearing {
    double inside = 0;  ///< pixels
    double torn = 0;    ///< of them, those of which less than half is covered
    double leak = 0;    ///< mean part of them that is not covered; 0 without an inside
};
inline Tearing tearing_of(const Image& image, const Image& reference) {
    const auto is_inside = [&](int x, int y) {
        for (int dy = -1; dy <= 1; ++dy) {
            for (int dx = -1; dx <= 1; ++dx) {
                if (reference.at(x + dx, y + dy).a != 255) return false;
            }
        }
        return true;
    };
    Tearing sums;
    for (int y = 1; y + 1 < reference.height(); ++y) {
        for (int x = 1; x + 1 < reference.width(); ++x) {
            if (!is_inside(x, y)) continue;
            ++sums.inside;
            sums.torn += image.at(x, y).a < 128;
            sums.leak += 1 - image.at(x, y).a / 255.0;
        }
    }
    if (sums.inside > 0) sums.leak /= sums.inside;
    return sums;
}

}  // namespace farfield::bench
