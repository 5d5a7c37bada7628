// Work counted in triangles (Chamberlain et al. 1996, section 4). It needs no clock: builds are the same anywhere.
#pragma once

#include "farfield/settings.hpp"

#include <cstdint>
#include <initializer_list>

#include "farfield/cost_model.hpp"

namespace farfield {

/// The paper counts two triangles for a face. The other conversions are ours, rounded from measurements of our
/// renderers (bench/): a deposit costs as much as eight triangles smaller than a pixel, culling a cell as much as four.
struct TriangleCount {
    static constexpr const char* unit = "triangles";
    static constexpr std::uint32_t file_tag = 0x54430001u;

    float triangles_per_face = 2;
    float triangles_per_splat = 8;
    float triangles_per_cell = 4;
    float triangles_per_run = 4;
    float triangles_per_image = 2;
    float triangles_per_texel = 0.25f;

    const char* wrong_option() const {
        for (const float price : {triangles_per_face, triangles_per_splat, triangles_per_cell, triangles_per_run,
                                  triangles_per_image, triangles_per_texel}) {
            if (!is_price(price)) return "TriangleCount: prices must be 0 or more and finite";
        }
        return nullptr;
    }

    float cost(const Work& w) const {
        return w.triangles + triangles_per_face * w.faces + triangles_per_splat * w.splats +
               triangles_per_cell * w.cells + triangles_per_run * w.runs + triangles_per_image * w.images +
               triangles_per_texel * w.texels;
    }
};

}  // namespace farfield
