// The kernel of CosineHumpFilter: the weight of each sample of a pixel for the 3 x 3 pixels around it, and tables of
// those for all byte patterns.
#pragma once

#include "farfield/settings.hpp"

#include <array>
#include <bit>
#include <cstdint>

namespace farfield {

namespace detail {

/// The kernel is (1 + cos(pi r)) / 2 of the distance r < 1 in pixels from a pixel's center to a sample's. The paper
/// does not say whether its hump is radial or a product of two; radial treats edges of every direction alike. A sample
/// reaches at most four pixels: its own and three in the direction of its quadrant, so a row of eight reaches six.
///
/// Weights are whole numbers, about 2^16 a pixel: sums of them times colors stay below 2^24, where single precision is
/// exact, so pictures do not depend on the order that samples come in. Against the kernel itself a pixel errs by at
/// most 0.12 of 255, whatever the colors.
struct CosineHump {
    /// Six weights: for the pixel to the left, the own one and the one to the right, then the same in the row above.
    struct alignas(16) Weights {
        std::uint16_t of[8] = {};
    };

    /// rows[j][byte] sums the samples of a byte in row j < 4. Row 7 - j is row j upside down.
    std::array<std::array<Weights, 256>, 4> rows{};
    /// of_pixels[c][r] is a pixel's weight for whole pixels around it: bits 0, 1 and 2 of c are the column to its left,
    /// its own and the one to its right, and r is the same for rows.
    std::array<std::array<float, 8>, 8> of_pixels{};

    constexpr CosineHump() {
        for (unsigned j = 0; j < 4; ++j) {
            for (unsigned byte = 1; byte < 256; ++byte) {
                const int i = std::countr_zero(byte);
                for (int k = 0; k < 6; ++k) {
                    const int x = 2 * i - 7 - 16 * (k % 3 - 1), y = 2 * int(j) - 7 + 16 * (k / 3);
                    rows[j][byte].of[k] = std::uint16_t(rows[j][byte & (byte - 1)].of[k] + weight(x, y));
                }
            }
        }
        unsigned corner = 0, edge = 0, own = 0;  // weights of whole pixels: diagonal, adjoining, own
        for (const auto& row : rows) {
            corner += row[255].of[3];
            edge += row[255].of[4];
            own += 2u * row[255].of[1];
        }
        for (unsigned c = 0; c < 8; ++c) {
            for (unsigned r = 0; r < 8; ++r) {
                const unsigned columns = (c & 1) + (c >> 2), lines = (r & 1) + (r >> 2), x = c >> 1 & 1, y = r >> 1 & 1;
                of_pixels[c][r] = float(columns * lines * corner + (columns * y + x * lines) * edge + x * y * own);
            }
        }
    }

    /// The weight of a sample at a distance of (x, y) / 16 pixels.
    static constexpr int weight(int x, int y) {
        // The kernel's sum over the 208 samples that it reaches: weights then add up to nearly 2^16.
        constexpr double sum = 59.77968581;
        const double squared = double(x * x + y * y) / 256;
        return squared < 1 ? int(kernel(squared) * (65536 / sum) + 0.5) : 0;
    }
    /// Takes the distance squared, below 1: the cosine is a series in that and needs no root.
    static constexpr double kernel(double squared) {
        double term = 1, cosine = 1;
        for (int i = 1; i < 15; ++i) {
            term *= -9.869604401089358 * squared / double(2 * i * (2 * i - 1));
            cosine += term;
        }
        return (1 + cosine) / 2;
    }
};
inline constexpr CosineHump cosine_hump{};
static_assert(cosine_hump.of_pixels[7][7] * 255 < 0x1p24f);

}  // namespace detail

}  // namespace farfield
