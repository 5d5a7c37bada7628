// Work counted in nanoseconds of this machine and renderer (Shade et al. 1996, section 3.3).
#pragma once

#include "farfield/settings.hpp"

#include <cstdint>
#include <initializer_list>

#include "farfield/cost_model.hpp"

namespace farfield {

/// Prices from calibrate() (tuning/calibrate.hpp) or a price file; the defaults are one machine's, for tests.
///
/// A triangle that is near costs many times one under a pixel. Where stand-ins compete with triangles, the triangles
/// are small: a cell stands in when it is about a pixel wide. `Work::triangles` is therefore priced as small; the price
/// of near ones is kept for estimates of what culling saves.
struct MeasuredTime {
    static constexpr const char* unit = "nanoseconds";
    static constexpr std::uint32_t file_tag = 0x4d540001u;

    float small_triangle = 3;  ///< narrower than a pixel
    float near_triangle = 60;  ///< some tens of pixels large
    float face = 60;
    float splat = 30;
    float cell = 15;  ///< visited: culled, or tested and descended
    float run = 15;
    float image = 1000;
    float texel = 2;

    const char* wrong_option() const {
        for (const float price : {small_triangle, near_triangle, face, splat, cell, run, image, texel}) {
            if (!is_price(price)) return "MeasuredTime: prices must be 0 or more and finite";
        }
        return nullptr;
    }

    /// The same with near triangles: what images are weighed against.
    float near_cost(const Work& w) const { return cost(w) + (near_triangle - small_triangle) * w.triangles; }

    float cost(const Work& w) const {
        return small_triangle * w.triangles + face * w.faces + splat * w.splats + cell * w.cells + run * w.runs +
               image * w.images + texel * w.texels;
    }
};

}  // namespace farfield
