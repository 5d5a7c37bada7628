// Where a picture is taken from: position, axes, and how much is seen.
#pragma once

#include "farfield/settings.hpp"

#include <cmath>
#include <cstdint>
#include <glm/fwd.hpp>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <limits>
#include <stdexcept>
#include <string>

#include "farfield/fail.hpp"
#include "farfield/geometry/length.hpp"

namespace farfield {

enum class Projection : std::uint8_t { perspective, orthographic };

/// How clip coordinates z / w tell depth: from 0 to 1 (Direct3D, Metal, Vulkan) or from -1 to 1 (OpenGL), either way
/// round. `either`: what one of them shows is not cut.
enum class ClipDepth : std::uint8_t { either, zero_to_one, minus_one_to_one };

/// A camera in the user's coordinates. The eye is double, so that it may be far from the origin; the axes are unit
/// vectors at right angles, with right = forward x up or, for pictures of left-handed coordinates and of mirrors, its
/// opposite.
struct Camera {
    glm::dvec3 eye{0.0};
    glm::vec3 right{1, 0, 0};
    glm::vec3 up{0, 1, 0};
    glm::vec3 forward{0, 0, -1};
    Projection projection = Projection::perspective;
    /// Perspective: tangent of half the vertical field of view. Orthographic: half the height seen, in world units.
    float half_height = 0.577350269f;
    /// Nothing nearer than this depth along `forward` is drawn, world units. 0 chooses 2^-40 of the scene's diagonal
    /// for perspective, where depth is kept as its inverse and a plane so near costs nothing, and nothing is cut for
    /// orthographic views; 2^-64 of the diagonal is the least.
    float near_depth = 0;
    /// Nothing farther than this depth is drawn but stand-ins of cells that reach nearer. Infinity: everything is.
    float far_depth = std::numeric_limits<float>::infinity();
    /// What `half_height` says of the height, of the width. 0: as wide as square pixels make it.
    float half_width = 0;
    /// The picture's center lies so many half widths to the right, and half heights above, where `forward` meets the
    /// plane of the picture: 0 but for tiles of a larger picture, stereo and jitter.
    glm::dvec2 off_center{0.0};

    /// Throws std::invalid_argument where the numbers do not make a camera (eye on the target, up along the view,
    /// a field of view outside (0, pi), NaN).
    static Camera perspective(glm::dvec3 eye, glm::dvec3 target, glm::vec3 up, float vertical_fov_radians,
                              float near_depth = 0) {
        if (!(vertical_fov_radians > 0 && vertical_fov_radians < 3.14159f)) {
            detail::fail<std::invalid_argument>(
                "farfield::Camera: the field of view must lie between 0 and pi radians; 60 degrees are 1.05");
        }
        return looking(eye, target, up, Projection::perspective, std::tan(vertical_fov_radians / 2), near_depth);
    }
    /// The image shows `height` world units from top to bottom.
    static Camera orthographic(glm::dvec3 eye, glm::dvec3 target, glm::vec3 up, float height, float near_depth = 0) {
        if (!(height > 0 && std::isfinite(height)))
            detail::fail<std::invalid_argument>("farfield::Camera: the height seen must be above 0");
        return looking(eye, target, up, Projection::orthographic, height / 2, near_depth);
    }

    /// The camera of an engine: points of the world times `view`, times `projection`, are clip coordinates. See
    /// camera_from_matrices.hpp, where it is defined, for what is understood and what is refused.
    static Camera from_matrices(const glm::dmat4& view, const glm::dmat4& projection,
                                ClipDepth depth = ClipDepth::either);
    static Camera from_matrices(const glm::mat4& view, const glm::mat4& projection,
                                ClipDepth depth = ClipDepth::either);

    /// Whether the picture is one in a mirror: right is the opposite of forward x up.
    bool is_mirrored() const { return glm::dot(glm::cross(forward, up), right) < 0; }

    /// Throws std::invalid_argument that names the first field that makes no picture.
    void validate() const {
        const auto demand = [](bool holds, const char* what) {
            if (!holds) detail::fail<std::invalid_argument>(std::string("farfield::Camera: ") + what);
        };
        const auto is_finite = [](auto v) { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); };
        demand(is_finite(eye), "eye must be finite");
        const auto is_unit = [](glm::vec3 v) { return std::abs(glm::dot(v, v) - 1) <= rounding_of_axes; };
        demand(is_unit(right), "right must have length 1");
        demand(is_unit(up), "up must have length 1");
        demand(is_unit(forward), "forward must have length 1");
        const auto are_square = [](glm::vec3 a, glm::vec3 b) { return std::abs(glm::dot(a, b)) <= rounding_of_axes; };
        demand(are_square(right, up) && are_square(up, forward) && are_square(forward, right),
               "right, up and forward must be at right angles");
        demand(projection == Projection::perspective || projection == Projection::orthographic,
               "projection must be perspective or orthographic");
        demand(half_height > 0 && std::isfinite(half_height), "half_height must be above 0 and finite");
        demand(half_width >= 0 && std::isfinite(half_width), "half_width must be above 0 and finite, or 0");
        demand(std::abs(off_center.x) <= 0x1p30 && std::abs(off_center.y) <= 0x1p30,
               "off_center must be finite and within 2^30");
        demand(near_depth >= 0 && std::isfinite(near_depth), "near_depth must be 0 or more and finite");
        demand(far_depth > near_depth, "far_depth must be above near_depth");
    }

    /// Axes are unit vectors at right angles up to this, the rounding of products of many single-precision matrices.
    static constexpr float rounding_of_axes = 0x1p-12f;

  private:
    static Camera looking(glm::dvec3 eye, glm::dvec3 target, glm::vec3 up, Projection projection, float half_height,
                          float near_depth) {
        const glm::dvec3 forward = scaled_to_one(target - eye);
        const glm::dvec3 right = glm::cross(forward, scaled_to_one(glm::dvec3(up)));
        const double lengths = glm::length(forward) * glm::length(right);
        if (!(lengths > 0) || !std::isfinite(lengths)) {
            detail::fail<std::invalid_argument>("farfield::Camera: eye, target and up must be finite and span a plane");
        }
        if (!(near_depth >= 0 && std::isfinite(near_depth)))
            detail::fail<std::invalid_argument>("farfield::Camera: near_depth must be 0 or more");
        const glm::dvec3 f = glm::normalize(forward);
        const glm::dvec3 r = glm::normalize(right);
        const glm::vec3 x(r), y(glm::cross(r, f));
        // Axes in single precision point past a target that is far away; the eye then moves by what they miss it by.
        const double distance = length_of(target - eye), seen = 2 * double(half_height);
        if (distance > 64 * (projection == Projection::perspective ? seen * distance : seen))
            eye = target - direction_of(glm::cross(glm::dvec3(y), glm::dvec3(x))) * distance;
        return {.eye = eye,
                .right = x,
                .up = y,
                .forward = glm::vec3(f),
                .projection = projection,
                .half_height = half_height,
                .near_depth = near_depth};
    }
};

}  // namespace farfield
