// How far wrong an image of a cell is when it is seen from elsewhere than where it was made, and how far one may go.
//
// An image is drawn as a rectangle at constant depth. What it shows of a point a then comes from where the ray from the
// eye v0 that it was made for, through a, meets the rectangle: from a~. Seen from v, a and a~ subtend an angle (Shade
// et al. 1996, section 3, figure 1), which in the picture is a displacement.
//
// With p = a - v0 at depth z along the axis of the image, q = a~ - v0 = p d / z on the rectangle at depth d, and
// m = v - v0:
//
//     (a - v) x (a~ - v) = (p - m) x (q - m) = (1 - d / z) m x p
//
// so one cross product a corner is enough.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <limits>

#include "farfield/geometry/length.hpp"
#include "farfield/view/local_view.hpp"

namespace farfield {

/// Where an image, or one depth slice of it, was made, and what it shows; in the coordinates of the cell's hierarchy.
struct ImagePlace {
    glm::vec3 eye{0}, forward{0, 0, -1};  ///< the viewpoint, and the axis that depths are measured along
    glm::vec3 center{0}, half{0};         ///< the box of the cell's contents
    float depth = 1;                      ///< of the rectangle, from the eye
    float nearest = 0, farthest = 0;      ///< depths that contents of this slice lie between
    bool is_perspective = true;
    bool is_slice = false;  ///< its contents end where it ends, and not where the box does
};

namespace detail {

inline glm::vec3 corner_of(const ImagePlace& place, unsigned i) {
    return place.center + place.half * glm::vec3((i & 1) ? 1 : -1, (i & 2) ? 1 : -1, (i & 4) ? 1 : -1);
}

/// The squared sine of the angle that a point and its image subtend; infinity where one of them lies behind the other's
/// viewer. `p` is the point from the image's eye, `z` its depth, `m` how far the viewer has moved.
inline float squared_sine(glm::vec3 p, float z, float depth, glm::vec3 m) {
    constexpr float never = std::numeric_limits<float>::infinity();
    if (!(z > 0)) return never;
    const float stretch = depth / z;
    const glm::vec3 a = p - m, image = p * stretch - m, cross = glm::cross(p, m) * (1 - stretch);
    const float lengths = glm::dot(a, a) * glm::dot(image, image);
    if (!(glm::dot(a, image) > 0) || !(lengths > 0)) return never;
    return glm::dot(cross, cross) / lengths;
}

/// The sine of the angle that so many pixels take at the center of a perspective picture.
inline float sine_of_pixels(float pixels, const LocalView& view) {
    const float tangent = pixels / view.focal_px;
    return tangent / std::sqrt(1 + tangent * tangent);
}

}  // namespace detail

/// The paper's error: the largest angle over the corners of the box, here the square of its sine. "This is not a
/// conservative estimate, but it is fast to compute, and has been found to work well in practice." Perspective only.
inline float squared_sine_at_corners(const ImagePlace& place, glm::vec3 eye) {
    const glm::vec3 m = eye - place.eye;
    float largest = 0;
    for (unsigned i = 0; i < 8; ++i) {
        const glm::vec3 p = detail::corner_of(place, i) - place.eye;
        const float z = glm::dot(p, place.forward);
        if (!place.is_slice) {
            largest = std::max(largest, detail::squared_sine(p, z, place.depth, m));
            continue;
        }
        for (const float end : {place.nearest, place.farthest}) {
            largest = std::max(largest, detail::squared_sine(p * (end / z), end, place.depth, m));
        }
    }
    return largest;
}

/// A bound of the sine of the angle over all points that the image shows, not only corners. Perspective only.
///
/// Let c be a point's direction, scaled to depth 1: p = z c, q = d c. A vector is at least as long as its part along c:
/// |z c - m| >= |c| (z - t) with t = m.c / |c|^2, and so for d. With |p x m| = z |c| m' where m' is the part of m
/// across c,
///
///     sine = |1 - d/z| z |c| m' / (|z c - m| |d c - m|) <= m' / |c| |1 / (d - t) - 1 / (z - t)|
///
/// which is largest for the largest t and m' and for z at one of its ends. All directions lie within an angle of that
/// of the box's center, the largest of its corners' as the box is convex; this bounds t, m' and |c|.
inline float sine_bound(const ImagePlace& place, glm::vec3 eye) {
    constexpr float never = std::numeric_limits<float>::infinity();
    const glm::vec3 m = eye - place.eye, to_center = place.center - place.eye;
    const float moved = length_of(m), away = length_of(to_center);
    if (moved == 0) return 0;
    if (!(away > 0)) return never;
    const glm::vec3 axis = to_center / away;
    float least_cosine = 1;
    for (unsigned i = 0; i < 8; ++i) {
        const glm::vec3 p = detail::corner_of(place, i) - place.eye;
        least_cosine = std::min(least_cosine, glm::dot(p, axis) / length_of(p));
    }
    if (!(least_cosine > 0)) return never;
    const float spread = std::acos(std::min(least_cosine, 1.0f));
    constexpr float quarter = 1.57079632679f;
    const float apart = std::acos(glm::clamp(glm::dot(m, axis) / moved, -1.0f, 1.0f));
    const float along = moved * std::cos(std::max(apart - spread, 0.0f));
    const float lowest = std::max(apart - spread, 0.0f), highest = apart + spread;
    const float across =
        moved * (lowest <= quarter && highest >= quarter ? 1.0f : std::max(std::sin(lowest), std::sin(highest)));
    const float off_axis = std::acos(glm::clamp(glm::dot(axis, place.forward), -1.0f, 1.0f));
    const float cosine = std::cos(std::max(off_axis - spread, 0.0f));  // 1 / |c|, at most
    const float t = along > 0 ? along * cosine : 0.0f;
    if (!(place.nearest > t && place.depth > t)) return never;
    const float inverse = 1 / (place.depth - t);
    const float sine =
        across * cosine *
        std::max(std::abs(inverse - 1 / (place.nearest - t)), std::abs(inverse - 1 / (place.farthest - t)));
    return sine * (1 + 0x1p-16f);
}

/// The largest distance from the picture's center to a corner, in focal lengths.
inline float corner_of_picture(const LocalView& view) {
    const glm::vec2 half =
        glm::vec2(view.part.whole_width, view.part.whole_height) / (2 * view.focal_px * view.squeeze);
    return length_of(glm::vec3(half * (1.0f + glm::abs(glm::vec2(view.whole_off_center))), 0.0f));
}

/// The displacement in pixels at the picture's center that the paper's error stands for; in an orthographic view, that
/// of the points at either end, which is exact.
inline float displacement_px(const ImagePlace& place, const LocalView& view) {
    if (!place.is_perspective || !view.is_perspective) {
        if (place.is_perspective != view.is_perspective) return std::numeric_limits<float>::infinity();
        const float reach = std::max(place.depth - place.nearest, place.farthest - place.depth);
        return reach * length_of(glm::cross(place.forward, view.forward)) * view.focal_px;
    }
    const float squared = squared_sine_at_corners(place, view.eye);
    return squared < 1 ? view.focal_px * std::sqrt(squared / (1 - squared)) : std::numeric_limits<float>::infinity();
}

/// A bound of the displacement anywhere in the picture, in pixels. An angle is worth more pixels off center: a point at
/// an angle of the axis is displaced by theta by at most focal (tan(angle + theta) - tan(angle)), which grows with the
/// angle, so that the picture's corner is the worst.
inline float displacement_bound_px(const ImagePlace& place, const LocalView& view) {
    if (!place.is_perspective || !view.is_perspective) return displacement_px(place, view);
    constexpr float never = std::numeric_limits<float>::infinity();
    const float sine = sine_bound(place, view.eye);
    if (!(sine < 1)) return never;
    const float corner = corner_of_picture(view);
    const float tangent = sine / std::sqrt(1 - sine * sine), slope = 1 - corner * tangent;
    return slope > 0 ? view.focal_px * ((corner + tangent) / slope - corner) * (1 + 0x1p-16f) : never;
}

/// The sine of the angle that displacement_bound_px() turns into so many pixels.
inline float sine_of_pixels_anywhere(float pixels, const LocalView& view) {
    const float corner = corner_of_picture(view), moved = pixels / view.focal_px;
    const float tangent = moved / (1 + corner * corner + corner * moved) * (1 - 0x1p-16f);
    return tangent / std::sqrt(1 + tangent * tangent);
}

/// The radius of the sphere around the image's eye from within which no corner and its image subtend more than an angle
/// (equations 3 and 4). Viewpoints from which a and a~ subtend the angle lie on two circles, in any plane through both,
/// of radius r = |a - a~| / (2 sin). The nearer of both is h away from the eye, and the circles
/// d = sqrt(h^2 + r^2 + h |a - a~|) - r. As printed, with h the distance to a, the zone is too large where a~ is
/// nearer: the angle came to 1.4 times what was allowed.
inline float safety_radius(const ImagePlace& place, float sine) {
    float radius = std::numeric_limits<float>::infinity();
    for (unsigned i = 0; i < 8; ++i) {
        const glm::vec3 p = detail::corner_of(place, i) - place.eye;
        const float z = glm::dot(p, place.forward), length = length_of(p) / z;
        if (!(z > 0)) return 0;
        for (const float end : {place.is_slice ? place.nearest : z, place.is_slice ? place.farthest : z}) {
            const float h = length * std::min(end, place.depth), apart = length * std::abs(end - place.depth);
            if (apart == 0) continue;
            const float r = apart / (2 * sine);
            radius = std::min(radius, h * (h + apart) / (std::sqrt(h * h + r * r + h * apart) + r));
        }
    }
    return radius;
}

/// The radius of the sphere around the image's eye in which no point of the cell and its image subtend more than an
/// angle: that of sine_bound() with all of the way taken both along and across.
inline float conservative_radius(const ImagePlace& place, float sine) {
    const auto error = [&](float moved) {
        if (!(place.nearest > moved && place.depth > moved)) return std::numeric_limits<float>::infinity();
        const float inverse = 1 / (place.depth - moved);
        return moved * std::max(std::abs(inverse - 1 / (place.nearest - moved)),
                                std::abs(inverse - 1 / (place.farthest - moved)));
    };
    float good = 0, bad = std::max(place.nearest, 0.0f);
    for (int i = 0; i < 24; ++i) {
        const float middle = 0.5f * (good + bad);
        (error(middle) <= sine ? good : bad) = middle;
    }
    return good;
}

/// The number of frames, `most` at the most, for which something holds that holds(k) says of the k-th frame from now,
/// found by doubling and bisection: once it fails it is taken to fail from then on.
template <class Holds>
std::uint32_t life_span(std::uint32_t most, Holds&& holds) {
    std::uint32_t good = 0, step = 1;
    while (good < most && holds(std::min(good + step, most))) {
        good = std::min(good + step, most);
        step *= 2;
    }
    std::uint32_t bad = std::min(good + step, most + 1);
    while (bad - good > 1) {
        const std::uint32_t middle = good + (bad - good) / 2;
        (holds(middle) ? good : bad) = middle;
    }
    return good;
}

/// A lower bound of the number of frames spent in a sphere, given bounds of the speed, in lengths a frame, and of the
/// acceleration, in lengths a frame squared.
inline std::uint32_t frames_within(float radius, float most_speed, float most_acceleration, std::uint32_t most) {
    return life_span(most, [&](std::uint32_t k) {
        const auto frames = float(k);
        return frames * (most_speed + 0.5f * most_acceleration * frames) <= radius;
    });
}

}  // namespace farfield
