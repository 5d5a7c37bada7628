// The cameras of engines: what their two matrices show is what a Camera shows.
//
// Everything follows from the three rows of projection * view that make x, y and w of clip coordinates. Where all three
// are 0 is the eye; along w's row lies `forward`, and what x's and y's rows have of it is how far off center the
// picture is. So it does not matter which of the two matrices mirrors, scales uniformly, shifts or jitters; nor whether
// view space looks along -z or +z, whose world is then left-handed for the library and `right` its opposite.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/mat4x4.hpp>
#include <glm/matrix.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <limits>
#include <stdexcept>
#include <string>

#include "farfield/camera.hpp"
#include "farfield/fail.hpp"

namespace farfield {
namespace detail {

class CameraFromMatrices {
  public:
    CameraFromMatrices(const glm::dmat4& view, const glm::dmat4& projection, ClipDepth depth)
        : view_(view), clip_(projection * view), clip_depth_(depth) {
        for (int column = 0; column < 4; ++column) {
            for (int row = 0; row < 4; ++row) {
                if (!std::isfinite(view[column][row])) refuse("the view matrix must be finite");
                if (!std::isfinite(projection[column][row])) refuse("the projection matrix must be finite");
            }
        }
        if (row_of(view, 3) != glm::dvec4(0, 0, 0, 1)) refuse("the last row of the view matrix must be 0, 0, 0, 1");
        const glm::dmat3 linear(view);
        const double most = glm::length(linear[0]) * glm::length(linear[1]) * glm::length(linear[2]);
        if (!(std::abs(glm::determinant(linear)) > most * double(std::numeric_limits<float>::epsilon())))
            refuse("the view matrix is singular");
    }

    Camera camera() const {
        const glm::dvec4 w = row_of(clip_, 3);
        const bool is_perspective = glm::length(glm::dvec3(w)) > 0;
        Camera camera = is_perspective ? perspective(w) : orthographic(w.w);
        camera.validate();
        return camera;
    }

  private:
    [[noreturn]] static void refuse(const char* why) {
        detail::fail<std::invalid_argument>(std::string("farfield::Camera::from_matrices: ") + why);
    }
    static glm::dvec4 row_of(const glm::dmat4& m, int row) { return {m[0][row], m[1][row], m[2][row], m[3][row]}; }

    /// Sets axes and size: `x` and `y` are rows without their part along `forward`, per unit of w.
    static void set_picture(Camera& camera, glm::dvec3 x, glm::dvec3 y, glm::dvec3 forward) {
        const double by_x = glm::length(x), by_y = glm::length(y);
        if (!(by_x > 0 && by_y > 0 && std::isfinite(by_x) && std::isfinite(by_y)))
            refuse("the projection matrix is singular");
        const glm::dvec3 right = x / by_x;
        if (!(std::abs(glm::dot(right, y)) <= double(Camera::rounding_of_axes) * by_y))
            refuse("together the matrices skew the picture");
        // Exactly at right angles, whatever rounding did.
        glm::dvec3 up = glm::cross(right, forward);
        if (glm::dot(up, y) < 0) up = -up;
        camera.right = glm::vec3(right);
        camera.up = glm::vec3(up);
        camera.forward = glm::vec3(forward);
        camera.half_width = float(1 / by_x);
        camera.half_height = float(1 / by_y);
    }

    /// Rows of clip coordinates are a * (p - eye): w's is along forward.
    Camera perspective(const glm::dvec4& w) const {
        Camera camera;
        const double by_depth = glm::length(glm::dvec3(w));
        const glm::dvec3 forward = glm::dvec3(w) / by_depth;
        const glm::dvec4 x = row_of(clip_, 0), y = row_of(clip_, 1), z = row_of(clip_, 2);
        const double x_off = glm::dot(glm::dvec3(x), forward), y_off = glm::dot(glm::dvec3(y), forward);
        set_picture(camera, (glm::dvec3(x) - x_off * forward) / by_depth, (glm::dvec3(y) - y_off * forward) / by_depth,
                    forward);
        camera.off_center = -glm::dvec2(x_off, y_off) / by_depth;
        // The point where x, y and w are 0, by Cramer's rule.
        const glm::dvec3 a(x), b(y), c(w);
        const glm::dvec3 bc = glm::cross(b, c), ca = glm::cross(c, a), ab = glm::cross(a, b);
        camera.eye = -(x.w * bc + y.w * ca + w.w * ab) / glm::dot(a, bc);
        if (!is_along(glm::dvec3(z), forward)) refuse("an oblique near plane cannot be had");
        // z / w is at_infinity + by_inverse / depth.
        const double at_infinity = glm::dot(glm::dvec3(z), forward) / by_depth;
        const double by_inverse = (glm::dot(glm::dvec3(z), camera.eye) + z.w) / by_depth;
        if (by_inverse == 0) refuse("the projection matrix is singular");
        double nearest = infinity, farthest = 0;
        for (const double lowest : {0.0, -1.0}) {
            if (clip_depth_ == (lowest == 0 ? ClipDepth::minus_one_to_one : ClipDepth::zero_to_one)) continue;
            const bool is_reversed = by_inverse > 0;
            const double first = is_reversed ? 1 : lowest, last = is_reversed ? lowest : 1;
            const double near_depth = by_inverse / (first - at_infinity);
            const double rounding = std::abs(last) * double(std::numeric_limits<float>::epsilon());
            const double far_depth =
                std::abs(last - at_infinity) <= rounding ? infinity : by_inverse / (last - at_infinity);
            if (!(0 < near_depth && near_depth < far_depth)) continue;
            nearest = std::min(nearest, near_depth);
            farthest = std::max(farthest, far_depth);
        }
        if (!(nearest < farthest)) refuse("no depth in front of the eye is between the near plane and the far one");
        camera.near_depth = float(nearest);
        camera.far_depth = float(farthest);
        return camera;
    }

    Camera orthographic(double w) const {
        if (w == 0) refuse("the projection matrix is singular");
        Camera camera;
        camera.projection = Projection::orthographic;
        const glm::dvec4 x = row_of(clip_, 0) / w, y = row_of(clip_, 1) / w, z = row_of(clip_, 2) / w;
        glm::dvec3 forward = glm::cross(glm::dvec3(x), glm::dvec3(y));
        if (!(glm::length(forward) > 0)) refuse("the projection matrix is singular");
        forward = glm::normalize(forward);
        const double slope = glm::dot(glm::dvec3(z), forward);
        if (slope == 0) refuse("the projection matrix is singular");
        if (!is_along(glm::dvec3(z), forward)) refuse("an oblique near plane cannot be had");
        const double lowest = clip_depth_ == ClipDepth::zero_to_one ? 0 : -1;
        camera.eye = -(glm::inverse(glm::dmat3(view_)) * glm::dvec3(view_[3]));
        // The eye looks towards the middle of what is seen; if it stands there, up to rounding, to where z grows.
        const double z_of_eye = glm::dot(glm::dvec3(z), camera.eye) + z.w;
        const double ahead = (clip_depth_ == ClipDepth::minus_one_to_one ? 0 : 0.5) - z_of_eye;
        if ((std::abs(ahead) > 0x1p-10 ? ahead * slope : slope) < 0) forward = -forward;
        set_picture(camera, glm::dvec3(x), glm::dvec3(y), forward);
        camera.off_center =
            -glm::dvec2(glm::dot(glm::dvec3(x), camera.eye) + x.w, glm::dot(glm::dvec3(y), camera.eye) + y.w);
        const double by_depth = glm::dot(glm::dvec3(z), forward);
        const double one = (lowest - z_of_eye) / by_depth, other = (1 - z_of_eye) / by_depth;
        // It may stand anywhere on its axis, so that the near plane lies before it.
        const double nearest = std::min(one, other), size = std::abs(one - other);
        const double back = nearest > 0 ? 0 : size - nearest;
        camera.eye -= forward * back;
        camera.near_depth = float(nearest + back);
        camera.far_depth = float(nearest + back + size);
        return camera;
    }

    static bool is_along(glm::dvec3 row, glm::dvec3 forward) {
        return glm::length(row - glm::dot(row, forward) * forward) <=
               double(Camera::rounding_of_axes) * glm::length(row);
    }

    static constexpr double infinity = std::numeric_limits<double>::infinity();
    glm::dmat4 view_, clip_;
    ClipDepth clip_depth_;
};

}  // namespace detail

/// Perspective and orthographic, single precision too, of any handedness, with z upwards or reversed, with a far plane
/// or without, off center, with pixels that are not square once the picture's size is chosen. An orthographic eye must
/// stand before the middle of what is seen, or it looks to where z grows.
///
/// Throws std::invalid_argument for what no Camera is: matrices that are singular, not finite, skew the picture or have
/// a near plane that is not at right angles to the view (as some have for pictures in mirrors).
///
/// Clip coordinates have y upwards. Vulkan's, which has it downwards, are had by changing the sign of the projection's
/// second row.
inline Camera Camera::from_matrices(const glm::dmat4& view, const glm::dmat4& projection, ClipDepth depth) {
    return detail::CameraFromMatrices(view, projection, depth).camera();
}
inline Camera Camera::from_matrices(const glm::mat4& view, const glm::mat4& projection, ClipDepth depth) {
    return from_matrices(glm::dmat4(view), glm::dmat4(projection), depth);
}

}  // namespace farfield
