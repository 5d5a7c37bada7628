// Compiles the splats of color cubes for several at once.
#pragma once

#include "farfield/settings.hpp"

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>

#include "farfield/approximation.hpp"
#include "farfield/approximation/placed/placed_splats.hpp"
#include "farfield/geometry/area_law.hpp"
#include "farfield/geometry/length.hpp"
#include "farfield/simd.hpp"
#include "farfield/view/local_view.hpp"

namespace farfield {

/// A color cube and its cell, in words that are kept far apart: word i of many cubes lie side by side.
struct PlacedCube {
    /// The cell's center and half sides, then the six colors.
    enum Word : std::size_t { center = 0, half = 3, colors = 6, words = 12 };
    static constexpr std::size_t stride = detail::placed_stride;
};

namespace detail {

#define FARFIELD_LANES 4
namespace four_cubes {
#include "farfield/approximation/color_cube/cube_lanes.inl"
}
#undef FARFIELD_LANES

#if defined(__x86_64__)
FARFIELD_BEGIN_EIGHT_LANES
#define FARFIELD_LANES 8
namespace eight_cubes {
#include "farfield/approximation/color_cube/cube_lanes.inl"
}
#undef FARFIELD_LANES
FARFIELD_END_LANES
#else
namespace eight_cubes = four_cubes;  // lanes_for() has no eight there
#endif

inline constexpr PlacedKernels cube_kernels{&four_cubes::splats_of, &eight_cubes::splats_of};

}  // namespace detail
}  // namespace farfield
