// Work counted in nanoseconds of this machine and renderer (Shade et al. 1996, section 3.3).
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <cstdint>
#include <initializer_list>

#include "farfield/cost_model.hpp"

namespace farfield {

/// Prices from calibrate() (tuning/calibrate.hpp) or a price file; the defaults are one machine's, for tests.
///
/// A triangle that is near costs many times one under a pixel. Where stand-ins compete with triangles, the triangles
/// are small: a cell stands in when it is about a pixel wide. `Work::triangles` is therefore priced as small; the
/// prices of larger ones are what images are weighed against.
struct MeasuredTime {
    static constexpr const char* unit = "nanoseconds";
    static constexpr std::uint32_t file_tag = 0x4d540002u;

    float small_triangle = 3;   ///< narrower than a pixel, and without a sample
    float hit_triangle = 60;    ///< a pixel large
    float near_triangle = 140;  ///< `near_px` pixels large
    float face = 60;
    float splat = 30;
    float cell = 15;  ///< visited: culled, or tested and descended
    float run = 15;
    float image = 1000;       ///< drawn: what it takes however small it is
    float texel = 2;          ///< drawn: a pixel that its rectangle covers
    float made_image = 4000;  ///< on top of what it shows: begun, ended and freed
    float made_texel = 4;     ///< of the image's rectangle, on top of what it shows
    static constexpr float near_px = 32;

    const char* wrong_option() const {
        for (const float price : {small_triangle, hit_triangle, near_triangle, face, splat, cell, run, image, texel,
                                  made_image, made_texel}) {
            if (!is_price(price)) return "MeasuredTime: prices must be 0 or more and finite";
        }
        return nullptr;
    }

    /// The same with triangles that are each `pixels` large.
    float cost_of_large(const Work& w, float pixels) const {
        // A triangle of an eighth of a pixel costs half as much more as one that is hit: most of those hit no sample.
        const float each = (hit_triangle - small_triangle) * (pixels / (pixels + 0.125f)) +
                           std::max(near_triangle - hit_triangle, 0.0f) * (pixels / near_px);
        return cost(w) + each * w.triangles;
    }
    /// Making an image of so many texels, without drawing what it shows.
    float making_cost(float texels) const { return made_image + made_texel * texels; }

    float cost(const Work& w) const {
        return small_triangle * w.triangles + face * w.faces + splat * w.splats + cell * w.cells + run * w.runs +
               image * w.images + texel * w.texels;
    }
};

}  // namespace farfield
