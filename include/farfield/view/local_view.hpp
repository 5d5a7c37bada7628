// A view in one hierarchy's own coordinates, as policies and renderers see it.
#pragma once

#include "farfield/settings.hpp"

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <limits>

#include "farfield/geometry/box.hpp"
#include "farfield/geometry/cell.hpp"
#include "farfield/geometry/length.hpp"
#include "farfield/geometry/similarity.hpp"
#include "farfield/simd.hpp"
#include "farfield/view.hpp"
#include "farfield/view/frustum.hpp"
#include "farfield/wanted_error.hpp"

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
    glm::dvec2 off_center{0.0};  ///< see Camera; of this picture, whether it is a part or whole
    float near_depth = 0;        ///< local units; -infinity: nothing is cut
    float far_depth = std::numeric_limits<float>::infinity();  ///< local units
    float scale = 1;  ///< world units in one local unit of length: multiply depths by it to compare instances
    /// How local coordinates lie in the outermost hierarchy's, for renderers that keep it: p is place + turned p scale
    /// there.
    glm::mat3 turned{1.0f};
    glm::dvec3 place{0.0};
    float tolerance_px = 1;
    WantedError wanted = WantedError::any();
    float tolerance_jitter = 0;
    float fade = 0;
    /// The largest splat of the renderer that the view is for; 0: it draws none, or is not known.
    float splat_limit_px = 0;
    DistanceMeasure distance = DistanceMeasure::nearest_point;
    int width = 0;
    int height = 0;
    /// Where the picture lies in the whole that the camera shows; the whole's size is set even where it is no part.
    PartOfPicture part{};
    glm::dvec2 whole_off_center{0.0};  ///< of the whole picture
    /// Pixels that what is drawn for a cell may reach beyond the cell's bounds, snapping left out; 0: everything is
    /// drawn in its place.
    float reach_px = 0;
    /// Coordinates are projected relative to this point of the ray through the middle of the picture, at
    /// `anchor_depth`. It is the eye with depth 0, unless the eye is so far that subtracting it would leave nothing of
    /// the coordinates.
    glm::vec3 anchor{0};
    float anchor_depth = 0;
    /// A power of two, in world units: renderers measure depths in it, because their inverses have to be numbers too.
    float depth_unit = 1;
    /// Goes into whatever is decided by a hash of coordinates, because instances have the same: a hash of the path of
    /// instances that leads here, 0 for the outermost hierarchy.
    std::uint32_t seed = 0;
    /// Left, right, bottom, top, near, far, with unit normals; a point is inside where dot(xyz, p) + w >= 0. They are
    /// the whole picture's, also in a tile, because what is chosen by them must not depend on how a picture is tiled.
    std::array<glm::vec4, plane_count> planes{};
    /// A tile's own sides where it ends before the whole does, some pixels outwards: what stands in for a cell may
    /// reach beyond the cell's bounds.
    std::array<glm::vec4, border_count> borders{};
    PlaneMask borders_used = 0;  ///< how many there are

    /// The hierarchy's coordinates are the user's minus `origin`; `bounds` are in its coordinates. Throws
    /// std::invalid_argument as View::check does.
    LocalView(const View& view, glm::dvec3 origin, const Box& bounds, float stand_in_px = 0)
        : LocalView(view, origin,
                    bounds.is_empty() ? 1.0f : glm::min(length_of(bounds.size()), std::numeric_limits<float>::max()),
                    bounds.is_empty() ? glm::vec3(0) : bounds.center(), stand_in_px) {}
    /// The same for a hierarchy whose bounds have this diagonal around this center. Cells of up to `stand_in_px`
    /// pixels, seen squarely, may be drawn as splats; 0: none is.
    LocalView(const View& view, glm::dvec3 origin, float diagonal, glm::vec3 center = glm::vec3(0),
              float stand_in_px = 0)
        : eye(view.camera.eye - origin),
          right(view.camera.right),
          up(view.camera.up),
          forward(view.camera.forward),
          is_perspective(view.camera.projection == Projection::perspective),
          is_mirrored(view.camera.is_mirrored()),
          focal_px(float(view.whole_height()) / (2 * view.camera.half_height)),
          near_depth(view.camera.near_depth),
          far_depth(view.camera.far_depth),
          tolerance_px(view.tolerance_px),
          wanted(view.wanted),
          tolerance_jitter(view.tolerance_jitter),
          fade(view.fade),
          distance(view.distance),
          width(view.width),
          height(view.height),
          part{view.part.left, view.part.top, view.whole_width(), view.whole_height()},
          whole_off_center(view.camera.off_center),
          anchor(eye),
          depth_unit(std::ldexp(1.0f, glm::clamp(exponent_of(diagonal), -100, 100))) {
        view.validate();
        off_center = whole_off_center;
        if (!view.part.is_whole()) {
            const glm::dvec2 size(width, height), whole(part.whole_width, part.whole_height);
            const glm::dvec2 corner(part.left, part.top);
            off_center = (whole_off_center * whole + (2.0 * corner + size - whole) * glm::dvec2(1, -1)) / size;
        }
        if (view.camera.half_width > 0) {
            const glm::vec2 focal(float(part.whole_width) / (2 * view.camera.half_width), focal_px);
            focal_px = glm::max(focal.x, focal.y);
            squeeze = focal / focal_px;
        }
        if (near_depth == 0) {
            near_depth = is_perspective ? diagonal * 0x1p-40f : -std::numeric_limits<float>::infinity();
        }
        // Inverse depths times the length of an edge on the screen have to be numbers.
        if (is_perspective) {
            near_depth = glm::max(near_depth, glm::max(diagonal * 0x1p-64f, std::numeric_limits<float>::min()));
        }
        if (stand_in_px > 0) reach_px = reach_of(stand_in_px);
        move_anchor(view.camera.eye - origin, diagonal, center, origin);
        set_planes();
    }

    /// The same view seen from inside an instance: `offset` is the instance's own origin in its own coordinates.
    LocalView inside(const Similarity& placed, glm::dvec3 outer_origin, glm::dvec3 inner_origin) const {
        LocalView v = *this;
        const glm::mat3 to_local = glm::transpose(placed.rotation());
        const auto moved = [&](glm::vec3 p) {
            const glm::dvec3 from_placement = glm::dvec3(p) + outer_origin - placed.translation;
            return glm::vec3(glm::dmat3(to_local) * from_placement / double(placed.scale()) - inner_origin);
        };
        v.eye = moved(eye);
        v.anchor = moved(anchor);
        v.anchor_depth = anchor_depth / placed.scale();
        v.right = to_local * right;
        v.up = to_local * up;
        v.forward = to_local * forward;
        v.near_depth = near_depth / placed.scale();
        v.far_depth = far_depth / placed.scale();
        const glm::dvec3 origin = glm::dmat3(placed.rotation()) * inner_origin * double(placed.scale());
        v.place = place + glm::dmat3(turned) * (origin + placed.translation - outer_origin) * double(scale);
        v.turned = turned * placed.rotation();
        v.scale = scale * placed.scale();
        if (!is_perspective) v.focal_px = focal_px * placed.scale();
        v.set_planes();
        return v;
    }

    /// The view of a rectangle of the whole picture's pixels, first row topmost, that may reach beyond the picture or
    /// lie outside of it: a whole picture by itself, whose samples lie where they lie in this one. "We redefine the
    /// viewing frustum so that it contains the entire node without changing the viewpoint or the view direction" (Shade
    /// et al. 1996, section 2).
    LocalView rectangle(int left, int top, int rectangle_width, int rectangle_height) const {
        const glm::dvec2 whole(part.whole_width, part.whole_height), size(rectangle_width, rectangle_height);
        LocalView v = *this;
        v.off_center = v.whole_off_center =
            (whole_off_center * whole + (2.0 * glm::dvec2(left, top) + size - whole) * glm::dvec2(1, -1)) / size;
        v.width = rectangle_width;
        v.height = rectangle_height;
        v.part = {0, 0, rectangle_width, rectangle_height};
        v.set_planes();
        return v;
    }
    /// The same view from elsewhere.
    LocalView moved(glm::vec3 way) const {
        LocalView v = *this;
        v.eye += way;
        v.anchor += way;
        v.set_planes();
        return v;
    }
    /// The same view, with nothing drawn but what lies in a range of depths, in local units.
    LocalView between(float near_limit, float far_limit) const {
        LocalView v = *this;
        v.near_depth = glm::max(near_depth, near_limit);
        v.far_depth = glm::min(far_depth, far_limit);
        v.set_planes();
        return v;
    }

    float depth(glm::vec3 p) const { return glm::dot(p - eye, forward); }

    /// Distance from the eye to the cell as `distance` defines it; 0 inside, never negative, never NaN.
    float distance_to(const Cell& cell) const {
        if (distance == DistanceMeasure::depth) {
            return glm::max(0.0f, depth(cell.center) - glm::dot(glm::abs(forward), cell.half));
        }
        return length_of(glm::max(glm::abs(cell.center - eye) - cell.half, glm::vec3(0)));
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
        return is_perspective && depth > 0 ? length_of(d) / depth : 1.0f;
    }

    /// The order in which points come front to back: the smaller the nearer.
    float order_of(glm::vec3 p) const {
        return is_perspective && anchor_depth == 0 ? length_of(p - eye) : glm::dot(p - anchor, forward);
    }

    /// Direction from a point towards the viewer, not normalized.
    glm::vec3 towards_viewer(glm::vec3 p) const { return is_perspective ? eye - p : -forward; }
    /// The same, of length 1, from the eye itself too.
    glm::vec3 direction_towards_viewer(glm::vec3 p) const {
        const glm::vec3 towards = towards_viewer(p);
        return towards == glm::vec3(0) ? -forward : direction_of(towards);
    }

  private:
    /// A splat lies about any point of its cell and is as large as the cell may look: half of it reaches beyond. (Away
    /// from the axis a cell is nearer than its distance by stretch(), and is stretched by as much.) What is deposited
    /// for a small triangle reaches less far than a pixel.
    float reach_of(float stand_in_px) const {
        const glm::vec2 away = half_size() * (1.0f + glm::abs(glm::vec2(whole_off_center)));
        const float squared_stretch = is_perspective ? 1 + glm::dot(away, away) : 1.0f;
        return 0.75f * glm::max(1.0f, stand_in_px * squared_stretch);
    }

    /// What is projected are differences to the eye. In single precision a difference to an eye a thousand times as far
    /// as the scene is large has lost ten bits, and two sheets near each other come to lie in one plane. A parallel
    /// view does not change if its eye slides along the axis, so it slides next to the scene. An eye of a perspective
    /// view stays, but depths are counted from a point of the axis next to the scene.
    ///
    /// Not where it would gain less than four bits: differences of an eye nearby are rounded as they always were.
    void move_anchor(glm::dvec3 exact_eye, float diagonal, glm::vec3 center, glm::dvec3 origin) {
        // The axis along which nothing moves sideways on the screen; axes in single precision are not quite square.
        glm::dvec3 axis = glm::cross(glm::dvec3(up), glm::dvec3(right));
        if (glm::dot(axis, glm::dvec3(forward)) < 0) axis = -axis;
        axis = direction_of(axis);
        const double to_center = glm::dot(glm::dvec3(center) - exact_eye, axis), size = double(diagonal);
        // Things in the view may be much smaller than the scene, and lie where the user's coordinates are finest.
        const glm::dvec3 next_to = length_of(glm::dvec3(center) + origin) <= size ? -origin : glm::dvec3(center);
        const double slid = glm::dot(next_to - exact_eye, axis);
        const float depth = float(slid * glm::dot(axis, glm::dvec3(forward)));
        const auto moved = glm::vec3(exact_eye + axis * slid);
        if (!std::isfinite(slid) || !std::isfinite(depth)) return;
        if (is_perspective) {
            if (!(to_center > 16 * size) || !(depth > 0)) return;
            anchor = moved;
            anchor_depth = depth;
        } else {
            const double seen = double(glm::max(part.whole_width, part.whole_height)) / double(focal_px);
            if (!(std::abs(to_center) > 4 * size || std::abs(to_center) > 64 * seen)) return;
            eye = anchor = moved;
            near_depth -= depth;
            far_depth -= depth;
        }
    }

    /// Half of the whole picture, in the unit of plane_at().
    glm::vec2 half_size() const { return glm::vec2(part.whole_width, part.whole_height) / (2 * focal_px * squeeze); }
    /// The plane that meets the picture's at `half` along an axis: perspective planes pass through the eye and tilt
    /// inwards; orthographic ones stand beside it.
    FARFIELD_INLINE glm::vec4 plane_at(glm::vec3 axis, float half) const {
        if (!is_perspective) return glm::vec4(-axis, half + glm::dot(axis, eye));
        const glm::vec3 inwards = half * forward - axis, n = glm::normalize(inwards);
        return glm::vec4(n, half * anchor_depth / glm::length(inwards) - glm::dot(n, anchor));
    }

    void set_planes() {
        const glm::vec2 half = half_size(), off(whole_off_center);
        planes = {plane_at(-right, half.x * (1 - off.x)),
                  plane_at(right, half.x * (1 + off.x)),
                  plane_at(-up, half.y * (1 - off.y)),
                  plane_at(up, half.y * (1 + off.y)),
                  glm::vec4(forward, anchor_depth - glm::dot(forward, anchor) - near_depth),
                  glm::vec4(-forward, glm::dot(forward, anchor) - anchor_depth + far_depth)};
        for (const std::size_t i : {4u, 5u}) {
            if (std::isinf(planes[i].w)) planes[i] = glm::vec4(0, 0, 0, 1);
        }
        if (part.left != 0 || part.top != 0 || width != part.whole_width || height != part.whole_height) set_borders();
    }

    void set_borders() {
        borders_used = 0;
        const glm::vec2 half = half_size(), off(whole_off_center), pixel = 1.0f / (focal_px * squeeze);
        const float outwards_px = 0.25f + reach_px;
        const auto border = [&](glm::vec3 axis, float whole_half, int cut_off, float unit) {
            const float outwards = float(cut_off) - outwards_px;
            if (outwards > 0) borders[borders_used++] = plane_at(axis, whole_half - outwards * unit);
        };
        border(-right, half.x * (1 - off.x), part.left, pixel.x);
        border(right, half.x * (1 + off.x), part.whole_width - part.left - width, pixel.x);
        border(-up, half.y * (1 - off.y), part.whole_height - part.top - height, pixel.y);
        border(up, half.y * (1 + off.y), part.top, pixel.y);
    }
};

}  // namespace farfield
