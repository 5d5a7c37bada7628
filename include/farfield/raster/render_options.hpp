// What a user chooses of a renderer with a z-buffer.
#pragma once

#include <optional>

#include "farfield/geometry/light.hpp"
#include "farfield/geometry/rgba8.hpp"
#include "farfield/raster/simd.hpp"

namespace farfield {

struct ZBufferOptions {
    int samples = 1;                          ///< a pixel, on a regular grid: 1, 4, 9, 16, 25, 36, 49 or 64
    Rgba8 background{0, 0, 0, 0};             ///< premultiplied
    std::optional<DirectionalLight> light{};  ///< in the outermost hierarchy's axes; none: colors as they are
    bool culls_back_faces = false;            ///< for closed surfaces that are counter-clockwise seen from outside
    Simd simd = Simd::automatic;              ///< all give the same picture
    /// Triangles smaller than two samples cover their part of those, by their cell's area law, instead of all or
    /// nothing. Only those of ranges with a law: an exact picture is point sampled whatever is said here.
    bool deposits_small_triangles = true;
};

}  // namespace farfield
