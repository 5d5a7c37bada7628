// Compiles what opacity tensors look like for one and for several at once.
#pragma once

#include "farfield/settings.hpp"

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>

#include "farfield/approximation.hpp"
#include "farfield/approximation/opacity_tensor/stored_tensor.hpp"
#include "farfield/approximation/placed/placed_splats.hpp"
#include "farfield/geometry/area_law.hpp"
#include "farfield/geometry/length.hpp"
#include "farfield/simd.hpp"
#include "farfield/view/local_view.hpp"

namespace farfield {

/// A stored tensor in its cell, in words that are kept far apart: word i of many tensors lie side by side.
struct PlacedTensor {
    /// The stored tensor's, then its lower corner, its unit of length, 1.75 of its cell's half side, and its scale.
    enum Word : std::size_t { bits = 0, x = 4, y = 5, z = 6, unit = 7, reach = 8, scale = 9, words = 10 };
    static constexpr std::size_t stride = detail::placed_stride;
};

/// Those of OpacityTensor that a look depends on.
struct TensorOptions {
    bool closed_surfaces, counts_overlap;
    float sheet_gain;
};

namespace detail {

// --- the same for one, four and eight

#define FARFIELD_LANES 1
namespace one_tensor {
#include "farfield/approximation/opacity_tensor/appearance_lanes.inl"
}
#undef FARFIELD_LANES

#define FARFIELD_LANES 4
namespace four_tensors {
#include "farfield/approximation/opacity_tensor/appearance_lanes.inl"
}
#undef FARFIELD_LANES

#if defined(__x86_64__)
FARFIELD_BEGIN_EIGHT_LANES
#define FARFIELD_LANES 8
namespace eight_tensors {
#include "farfield/approximation/opacity_tensor/appearance_lanes.inl"
}
#undef FARFIELD_LANES
FARFIELD_END_LANES
#else
namespace eight_tensors = four_tensors;  // lanes_for() has no eight there
#endif

inline constexpr PlacedKernels tensor_kernels{&four_tensors::splats_of, &eight_tensors::splats_of};

}  // namespace detail

/// The projected area if nothing hides anything; w is a unit vector.
inline float area_seen_from(const TensorShape& shape, glm::vec3 w) {
    return detail::one_tensor::area_seen_from(shape, w);
}
/// Area of the contents' outline. Sheets lie anywhere in their box. Leaves strewn in it are thin where they are seen
/// through one of its edges or corners, which count for less: within 4 % of the area that leaves cover where they fill
/// a cube once or twice.
inline float outline_from(const TensorShape& shape, glm::vec3 w) {
    return detail::one_tensor::outline_from(shape, w);
}
/// The normal, of any length, of contents that are nearly flat; 0 unless nine tenths of the surfaces have one
/// direction.
inline glm::vec3 sheet_normal(const TensorShape& shape) {
    return detail::one_tensor::sheet_normal(shape);
}

}  // namespace farfield
