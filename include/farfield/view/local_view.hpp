// A view in one hierarchy's own coordinates, as policies and renderers see it.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <limits>

#include "farfield/geometry/cell.hpp"
#include "farfield/geometry/similarity.hpp"
#include "farfield/view.hpp"
#include "farfield/view/frustum.hpp"

namespace farfield {

/// Entering an instance changes this value and nothing else: instead of moving the instance into the world, the
/// viewer is moved into the instance. So neither policies nor renderers ever handle a transform.
struct LocalView {
    glm::vec3 eye{0};
    glm::vec3 right{1, 0, 0};  ///< unit vectors
    glm::vec3 up{0, 1, 0};
    glm::vec3 forward{0, 0, -1};
    bool is_perspective = true;
    bool is_mirrored = false;  ///< see Camera
    /// Pixels that a local unit of length takes: at depth 1 in perspective, anywhere in an orthographic view. Where
    /// pixels are not square, it is the larger number.
    float focal_px = 1;
    glm::vec2 squeeze{1};        ///< pixels a unit takes to the right, and up, in parts of focal_px; at most 1
    glm::dvec2 off_center{0.0};  ///< see Camera
    float near_depth = 0;        ///< local units; -infinity: nothing is cut
    float far_depth = std::numeric_limits<float>::infinity();  ///< local units
    float scale = 1;  ///< world units in one local unit of length: multiply depths by it to compare instances
    float tolerance_px = 1;
    DistanceMeasure distance = DistanceMeasure::nearest_point;
    int width = 0;
    int height = 0;
    /// Left, right, bottom, top, near, far, with unit normals; a point is inside where dot(xyz, p) + w >= 0.
    std::array<glm::vec4, plane_count> planes{};

    /// `origin` and `diagonal` are the hierarchy's: its coordinates are the user's minus origin. Throws
    /// std::invalid_argument as View::check does.
    LocalView(const View& view, glm::dvec3 origin, float diagonal)
        : eye(view.camera.eye - origin),
          right(view.camera.right),
          up(view.camera.up),
          forward(view.camera.forward),
          is_perspective(view.camera.projection == Projection::perspective),
          is_mirrored(view.camera.is_mirrored()),
          focal_px(float(view.height) / (2 * view.camera.half_height)),
          off_center(view.camera.off_center),
          near_depth(view.camera.near_depth),
          far_depth(view.camera.far_depth),
          tolerance_px(view.tolerance_px),
          distance(view.distance),
          width(view.width),
          height(view.height) {
        view.check();
        if (view.camera.half_width > 0) {
            const glm::vec2 focal(float(view.width) / (2 * view.camera.half_width), focal_px);
            focal_px = glm::max(focal.x, focal.y);
            squeeze = focal / focal_px;
        }
        if (near_depth == 0) {
            near_depth = is_perspective ? glm::max(diagonal * 0x1p-16f, std::numeric_limits<float>::min())
                                        : -std::numeric_limits<float>::infinity();
        }
        set_planes();
    }

    /// The same view seen from inside an instance: `offset` is the instance's own origin in its own coordinates.
    LocalView inside(const Similarity& placed, glm::dvec3 outer_origin, glm::dvec3 inner_origin) const {
        LocalView v = *this;
        const glm::mat3 to_local = glm::transpose(placed.rotation());
        const glm::dvec3 from_placement = glm::dvec3(eye) + outer_origin - placed.translation;
        v.eye = glm::vec3(glm::dmat3(to_local) * from_placement / double(placed.scale()) - inner_origin);
        v.right = to_local * right;
        v.up = to_local * up;
        v.forward = to_local * forward;
        v.near_depth = near_depth / placed.scale();
        v.far_depth = far_depth / placed.scale();
        v.scale = scale * placed.scale();
        if (!is_perspective) v.focal_px = focal_px * placed.scale();
        v.set_planes();
        return v;
    }

    float depth(glm::vec3 p) const { return glm::dot(p - eye, forward); }

    /// Distance from the eye to the cell as `distance` defines it; 0 inside, never negative, never NaN.
    float distance_to(const Cell& cell) const {
        if (distance == DistanceMeasure::depth) {
            return glm::max(0.0f, depth(cell.center) - glm::dot(glm::abs(forward), cell.half));
        }
        const glm::vec3 outside = glm::max(glm::abs(cell.center - eye) - cell.half, glm::vec3(0));
        return std::sqrt(glm::dot(outside, outside));
    }

    /// Pixels that a length takes when seen squarely at `at_distance`; infinity at distance 0 of a perspective view.
    float pixels(float length, float at_distance) const {
        if (!is_perspective) return length * focal_px;
        return at_distance > 0 ? length * focal_px / at_distance : std::numeric_limits<float>::infinity();
    }

    /// The viewpoint that orders are asked for: a point with w = 1, or with w = 0 the direction towards an infinitely
    /// far viewer.
    glm::vec4 viewpoint() const { return is_perspective ? glm::vec4(eye, 1) : glm::vec4(-forward, 0); }

    /// The factor by which the area of something small, seen squarely from the viewer, grows in the picture, which it
    /// meets at an angle away from its center. 1 or more; 1 behind the viewer.
    float stretch(glm::vec3 p) const {
        const glm::vec3 d = p - eye;
        const float depth = glm::dot(d, forward);
        return is_perspective && depth > 0 ? std::sqrt(glm::dot(d, d)) / depth : 1.0f;
    }

    /// Direction from a point towards the viewer, not normalized.
    glm::vec3 towards_viewer(glm::vec3 p) const { return is_perspective ? eye - p : -forward; }

  private:
    void set_planes() {
        const float half_width = float(width) / (2 * focal_px * squeeze.x);
        const float half_height = float(height) / (2 * focal_px * squeeze.y);
        const glm::vec2 off(off_center);
        const auto side = [&](glm::vec3 axis, float half) {
            // Perspective planes pass through the eye and tilt inwards; orthographic ones stand beside it.
            if (!is_perspective) return glm::vec4(-axis, half + glm::dot(axis, eye));
            const glm::vec3 n = glm::normalize(half * forward - axis);
            return glm::vec4(n, -glm::dot(n, eye));
        };
        planes = {side(-right, half_width * (1 - off.x)),
                  side(right, half_width * (1 + off.x)),
                  side(-up, half_height * (1 - off.y)),
                  side(up, half_height * (1 + off.y)),
                  glm::vec4(forward, -glm::dot(forward, eye) - near_depth),
                  glm::vec4(-forward, glm::dot(forward, eye) + far_depth)};
        for (const std::size_t i : {4u, 5u}) {
            if (std::isinf(planes[i].w)) planes[i] = glm::vec4(0, 0, 0, 1);
        }
    }
};

}  // namespace farfield
