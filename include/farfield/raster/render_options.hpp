// The options of renderers with a z-buffer.
#pragma once

#include "farfield/settings.hpp"

#include <optional>

#include "farfield/geometry/light.hpp"
#include "farfield/geometry/rgba8.hpp"
#include "farfield/simd.hpp"

namespace farfield {

struct ZBufferOptions {
    int samples = 1;                          ///< a pixel, on a regular grid: 1, 4, 9, 16, 25, 36, 49 or 64
    Rgba8 background{0, 0, 0, 0};             ///< premultiplied
    std::optional<DirectionalLight> light{};  ///< in the outermost hierarchy's axes; none: colors as they are
    bool culls_back_faces = false;            ///< for closed surfaces that are counter-clockwise seen from outside
    Simd simd = Simd::automatic;              ///< all give the same picture
    /// Triangles smaller than two samples cover a part of each sample, by their cell's area law, instead of all or
    /// nothing. This holds for ranges with a law only; an exact picture is always point sampled.
    bool deposits_small_triangles = true;
    /// Whether the renderer keeps its own copy of what it draws: 40 bytes a triangle, 48 where colors differ within
    /// one. Otherwise it reads the primitives anew in each frame, from the user's array, which must then stay as it is
    /// while viewers last. Both give the same picture.
    bool copies_sources = true;
};

}  // namespace farfield
