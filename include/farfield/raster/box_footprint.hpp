// Where on the screen can something inside a box be, and how near?
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "farfield/raster/box_fronts.hpp"
#include "farfield/raster/sample_projection.hpp"

namespace farfield::detail {

/// Holds every sample, inside the image and relative to its center sample, that polygons inside the box may cover,
/// roundings of box, projection and snapping included.
struct BoxFootprint {
    bool is_bounded = false;               ///< false: reaches to the near plane or nearly so; the rest is not set
    int x0 = 0, y0 = 0, x1 = -1, y1 = -1;  ///< ends included; empty if x0 > x1 or y0 > y1
    BoxFronts fronts;

    bool is_empty() const { return x0 > x1 || y0 > y1; }

    BoxFootprint(glm::vec3 center, glm::vec3 half, const SampleProjection& projection) {
        constexpr float some_roundings = 0x1p-20f;
        half += (glm::abs(center) + half) * some_roundings;
        const glm::vec3 reach = glm::abs(center - projection.anchor) + half;
        const float error = (reach.x + reach.y + reach.z) * some_roundings;  // of a depth
        const glm::vec3 p = projection.project(center);
        const glm::vec3 x = projection.right * half, y = projection.down * half, z = projection.forward * half;
        const float nearest = p.z - (std::abs(z.x) + std::abs(z.y) + std::abs(z.z)) - error;
        if (!(nearest >= projection.near_depth)) return;
        float low_x = 0, high_x = 0, low_y = 0, high_y = 0;
        if (projection.is_perspective) {
            float px[8], py[8];
            for (int corner = 0; corner < 8; ++corner) {
                const float a = corner & 1 ? 1.0f : -1.0f, b = corner & 2 ? 1.0f : -1.0f, c = corner & 4 ? 1.0f : -1.0f;
                const float inverse = projection.inverse_w(std::max(p.z + a * z.x + b * z.y + c * z.z, nearest));
                px[corner] = (p.x + a * x.x + b * x.y + c * x.z) * inverse;
                py[corner] = (p.y + a * y.x + b * y.y + c * y.z) * inverse;
            }
            low_x = high_x = px[0];
            low_y = high_y = py[0];
            for (int corner = 1; corner < 8; ++corner) {
                low_x = std::min(low_x, px[corner]);
                high_x = std::max(high_x, px[corner]);
                low_y = std::min(low_y, py[corner]);
                high_y = std::max(high_y, py[corner]);
            }
        } else {
            const float half_x = std::abs(x.x) + std::abs(x.y) + std::abs(x.z);
            const float half_y = std::abs(y.x) + std::abs(y.y) + std::abs(y.z);
            low_x = p.x - half_x;
            high_x = p.x + half_x;
            low_y = p.y - half_y;
            high_y = p.y + half_y;
        }
        // One sample covers snapping and the distance to its center, a splat may reach farther; the rest is the error
        // of projection.
        const float beyond = 256 * std::max(1.0f, projection.reach);
        const float relative = error / projection.w(nearest);
        const glm::vec2 focal = projection.focal * 256.0f;
        const float slack_x = beyond + relative * (focal.x + std::max(std::abs(low_x), std::abs(high_x)));
        const float slack_y = beyond + relative * (focal.y + std::max(std::abs(low_y), std::abs(high_y)));
        // Written so that a NaN ends up outside.
        const auto sample = [](float v, int first, int end) {
            return int(std::floor(std::clamp(v * (1.0f / 256), float(first) - 1, float(end))));
        };
        low_x += projection.offset_x - slack_x;
        high_x += projection.offset_x + slack_x;
        low_y += projection.offset_y - slack_y;
        high_y += projection.offset_y + slack_y;
        if (!(low_x <= high_x && low_y <= high_y)) return;
        x0 = std::max(sample(low_x, projection.first_x, projection.end_x), projection.first_x);
        y0 = std::max(sample(low_y, projection.first_y, projection.end_y), projection.first_y);
        x1 = std::min(sample(high_x, projection.first_x, projection.end_x), projection.end_x - 1);
        y1 = std::min(sample(high_y, projection.first_y, projection.end_y), projection.end_y - 1);
        const float q = projection.q(nearest, projection.inverse_w(nearest));
        fronts = BoxFronts(center, half, projection, {glm::vec2(low_x, low_y), glm::vec2(high_x, high_y)}, q,
                           q - projection.q(nearest + 2 * error, projection.inverse_w(nearest + 2 * error)));
        is_bounded = true;
    }
};

}  // namespace farfield::detail
