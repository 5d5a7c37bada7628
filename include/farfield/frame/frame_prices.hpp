// What drawing a frame takes, and what each part of that costs: more kinds of work than a build's cost model tells
// apart, since what is large in the picture costs by its pixels.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <limits>

namespace farfield {

/// Counts of each kind of work of one frame, estimated before it is drawn; or what one of each costs.
struct FrameWork {
    enum Kind : std::size_t {
        frames,           ///< 1: what every frame takes, whatever it shows
        pixels,           ///< of the picture: clearing and finishing it
        cells,            ///< looked at
        openings,         ///< of cells, by the best gain
        stand_ins,        ///< faces and splats
        stand_in_pixels,  ///< that they cover, each cell by itself
        runs,             ///< of primitives
        triangles,        ///< smaller than two pixels, or out of sight
        large_triangles,
        triangle_pixels,  ///< that cells cover that are drawn as primitives
        instances,        ///< entered
        /// No more pixels are seen than there are, and what is behind costs less. Set by with_shown().
        shown_triangle_pixels,
        shown_stand_in_pixels,  ///< where no triangle is
        kinds
    };
    std::array<double, kinds> of{};

    double& operator[](Kind kind) { return of[kind]; }
    double operator[](Kind kind) const { return of[kind]; }
    FrameWork with_shown() const {
        FrameWork work = *this;
        work[shown_triangle_pixels] = std::min(of[triangle_pixels], of[pixels]);
        work[shown_stand_in_pixels] = std::min(of[stand_in_pixels], of[pixels] - work[shown_triangle_pixels]);
        return work;
    }

    FrameWork& operator+=(const FrameWork& other) {
        for (std::size_t i = 0; i < kinds; ++i) of[i] += other.of[i];
        return *this;
    }
    FrameWork& operator-=(const FrameWork& other) {
        for (std::size_t i = 0; i < kinds; ++i) of[i] -= other.of[i];
        return *this;
    }
};

/// The price of one of each kind, in any unit. The defaults are one machine's nanoseconds; measure_frame_prices()
/// (tuning/measure_frame_prices.hpp) has this machine's.
struct FramePrices {
    FrameWork each{{20000, 1, 100, 300, 150, 10, 40, 15, 100, 1, 1000, 15, 30}};

    double cost(const FrameWork& counted) const {
        const FrameWork work = counted.with_shown();
        double sum = 0;
        for (std::size_t i = 0; i < FrameWork::kinds; ++i) sum += each.of[i] * work.of[i];
        return sum;
    }
    /// A budget by these is one of primitives: triangles, and what is drawn for a cell as `a_stand_in` of them.
    static constexpr FramePrices of_primitives(double a_stand_in = 1) {
        return {{{0, 0, 0, 0, a_stand_in, 0, 0, 1, 1, 0, 0, 0, 0}}};
    }
    /// Null, or what is wrong.
    const char* wrong_option() const {
        for (const double price : each.of) {
            if (!(price >= 0 && price <= std::numeric_limits<double>::max())) {
                return "FramePrices: prices must be 0 or more and finite";
            }
        }
        return nullptr;
    }
};

}  // namespace farfield
