// The viewer, the picture's size and its tolerance: everything that a user says once a frame.
#pragma once

#include <cmath>
#include <cstdint>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <stdexcept>

#include "farfield/fail.hpp"
#include "farfield/geometry/length.hpp"

namespace farfield {

enum class Projection : std::uint8_t { perspective, orthographic };

/// A camera in the user's coordinates. The eye is double, so that it may be far from the origin; the axes are
/// orthonormal, right-handed with `forward` = up x right reversed, that is right = forward x up.
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
    /// orthographic views; 2^-64 of the diagonal is the least. There is no far plane.
    float near_depth = 0;

    /// Throws std::invalid_argument where the numbers do not make a camera (eye on the target, up along the view,
    /// a field of view outside (0, pi), NaN).
    static Camera perspective(glm::dvec3 eye, glm::dvec3 target, glm::vec3 up, float vertical_fov_radians,
                              float near_depth = 0) {
        if (!(vertical_fov_radians > 0 && vertical_fov_radians < 3.14159f)) {
            detail::fail<std::invalid_argument>(
                "farfield::Camera: the field of view must lie between 0 and pi radians");
        }
        return looking(eye, target, up, Projection::perspective, std::tan(vertical_fov_radians / 2), near_depth);
    }
    /// The image shows `height` world units from top to bottom.
    static Camera orthographic(glm::dvec3 eye, glm::dvec3 target, glm::vec3 up, float height, float near_depth = 0) {
        if (!(height > 0 && std::isfinite(height)))
            detail::fail<std::invalid_argument>("farfield::Camera: the height seen must be above 0");
        return looking(eye, target, up, Projection::orthographic, height / 2, near_depth);
    }

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
        return {eye, x, y, glm::vec3(f), projection, half_height, near_depth};
    }
};

/// The distance of a cell that its error depends on. `nearest_point` of its box is safe in every direction of view;
/// `depth` along the viewing direction is that of Chamberlain 1995, section 3.1, whose levels change at planes.
enum class DistanceMeasure : std::uint8_t { nearest_point, depth };

/// The settings of one frame. Pixels are square.
struct View {
    Camera camera;
    int width = 512;  ///< image size in pixels
    int height = 512;
    /// A stand-in is drawn where its error is at most this many pixels; 0 draws every primitive exactly.
    float tolerance_px = 1;
    DistanceMeasure distance = DistanceMeasure::nearest_point;
};

/// The work that a frame did, in counts. Times are for the caller to take.
struct FrameStats {
    static constexpr int max_levels = 64;

    std::uint64_t primitives = 0;      ///< primitives handed to the renderer, instances excluded
    std::uint64_t runs = 0;            ///< ranges they were handed over in
    std::uint64_t approximations = 0;  ///< stand-ins drawn
    std::uint64_t faces = 0;           ///< far-field faces handed over
    std::uint64_t splats = 0;          ///< far-field deposits handed over
    std::uint64_t cells_visited = 0;
    std::uint64_t cells_outside = 0;                         ///< culled by the frustum
    std::uint64_t cells_hidden = 0;                          ///< culled because the renderer said so
    std::uint64_t instances = 0;                             ///< instances entered
    std::uint64_t touched_bytes = 0;                         ///< working set: nodes, stand-ins and item indices read
    std::uint64_t approximations_by_level[max_levels] = {};  ///< by depth in their own hierarchy
};

}  // namespace farfield
