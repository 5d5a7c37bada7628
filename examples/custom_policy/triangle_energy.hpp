// A cost model of your own: what is moved from memory, in nanojoules. Where a battery is what runs out, a hierarchy is
// built for that and not for time.
#pragma once

#include <cstdint>

#include "farfield/cost_model.hpp"

struct TriangleEnergy {
    float nanojoules_per_byte = 0.15f;  ///< about what memory outside of the chip takes
    float nanojoules_per_pixel = 2;     ///< of a face, which is about one in size

    static constexpr const char* unit = "nanojoules";
    static constexpr std::uint32_t file_tag = 0x74650001u;

    float cost(const farfield::Work& work) const {
        const float bytes = bytes_per_triangle * work.triangles + bytes_per_cell * work.cells +
                            bytes_per_run * work.runs + bytes_per_stand_in * (work.splats + work.faces / 3) +
                            bytes_per_texel * (work.texels + work.images);
        return nanojoules_per_byte * bytes + nanojoules_per_pixel * (work.faces + work.splats);
    }

  private:
    static constexpr float bytes_per_triangle = 40, bytes_per_cell = 32, bytes_per_run = 8, bytes_per_stand_in = 24,
                           bytes_per_texel = 4;
};

static_assert(farfield::CostModel<TriangleEnergy>);
