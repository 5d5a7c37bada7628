// How near can the contents of a box be, sample by sample?
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <limits>

#include "farfield/raster/sample_projection.hpp"
#include "farfield/raster/scan_conversion.hpp"

namespace farfield::detail {

/// The sides of a box that face the eye, as planes of q. A ray enters the box where it meets the last of them, so at
/// each sample nothing inside has a larger q than any of them. A room is thus hidden behind a corridor's wall though
/// its nearest corner is nearer than most of the wall, which a bound by that corner alone cannot tell.
///
/// The planes are raised by as much as rounding, snapping and the reach of splats may raise what is drawn. (A sliver on
/// the screen, whose corners lie almost on a line, has a depth known only to within that of its corners: if it lies
/// before a front, that is due to this error, and it may be left out with what is hidden.)
struct BoxFronts {
    std::array<DepthPlane, 3> planes;  ///< over samples, relative to the center sample
    int count = 0;                     ///< 1 or more once made
    float nearest_q = 0;               ///< no point of the box has a larger q

    BoxFronts() = default;
    /// A bound for something that is only known to be nowhere nearer.
    explicit BoxFronts(float q) : count(1), nearest_q(q) { planes[0] = DepthPlane(q, 0, 0, q, q); }

    /// The whole box must lie beyond the near plane; on the screen it lies between low_and_high, in 1/256 sample
    /// relative to the center sample. nearest_q has been raised by rounding_q.
    ///
    /// A point at depth d that is seen at (X, Y), samples from where the view's axis meets the screen, is eye + d
    /// forward + w (X right + Y down) / focal, where w is d in perspective and 1 in orthographic views. Once its
    /// coordinate on one axis is given, q is linear in X and Y. The anchor stands for the eye where depths are counted
    /// from it.
    BoxFronts(glm::vec3 center, glm::vec3 half, const SampleProjection& projection,
              std::array<glm::vec2, 2> low_and_high, float nearest, float rounding_q)
        : nearest_q(nearest) {
        // From afar the fronts of a box differ by little more than rounding.
        if (!projection.is_at_eye) {
            *this = BoxFronts(nearest_q);
            return;
        }
        const float to_x = projection.offset_x * (1.0f / 256), to_y = projection.offset_y * (1.0f / 256);
        const auto reach = [&](int axis, float zero) {
            return std::max(std::abs(low_and_high[0][axis] * (1.0f / 256) - zero),
                            std::abs(low_and_high[1][axis] * (1.0f / 256) - zero));
        };
        const float reach_x = reach(0, to_x), reach_y = reach(1, to_y);
        // projection.right has a length of 256 focal.x.
        const glm::vec2 by_sample = 1.0f / (projection.focal * projection.focal * 256.0f);
        for (int axis = 0; axis < 3; ++axis) {
            const float a = projection.right[axis] * by_sample.x, b = projection.down[axis] * by_sample.y;
            const float to_lower = center[axis] - half[axis] - projection.anchor[axis],
                        to_upper = center[axis] + half[axis] - projection.anchor[axis];
            float plane, by_plane, q;
            if (projection.is_perspective) {
                plane = to_lower > 0 ? to_lower : to_upper < 0 ? to_upper : 0.0f;  // 0: no front
                by_plane = projection.q_of_inverse / plane;
                q = by_plane * projection.forward[axis];
            } else {
                plane = projection.forward[axis] > 0 ? to_lower : to_upper;
                by_plane = -projection.q_of_depth / projection.forward[axis];
                q = -by_plane * plane;
            }
            const float by_x = by_plane * a, by_y = by_plane * b;
            const float most = std::abs(q) + std::abs(by_x) * reach_x + std::abs(by_y) * reach_y;
            const float sums = std::abs(center[axis]) + half[axis] + std::abs(projection.anchor[axis]);
            const float rounding = most * (sums * 0x1p-22f / std::abs(plane) + 0x1p-18f) + rounding_q;
            const float at_first = q + rounding + (std::abs(by_x) + std::abs(by_y)) * projection.reach +
                                   by_x * (0.5f - to_x) + by_y * (0.5f - to_y);
            if (!std::isfinite(at_first) || !std::isfinite(by_x) || !std::isfinite(by_y)) continue;
            planes[std::size_t(count++)] =
                DepthPlane(at_first, by_x, by_y, -std::numeric_limits<float>::infinity(), nearest_q);
        }
        if (count == 0) *this = BoxFronts(nearest_q);
    }

    /// An upper bound of q for anything inside, over a rectangle of samples, ends included.
    float nearest_in(int x0, int y0, int x1, int y1) const {
        float nearest = nearest_q;
        for (int i = 0; i < count; ++i) {
            const DepthPlane& p = planes[std::size_t(i)];
            nearest = std::min(nearest, p.at(p.row(p.by_y > 0 ? y1 : y0), p.by_x > 0 ? x1 : x0));
        }
        return nearest;
    }
};

}  // namespace farfield::detail
