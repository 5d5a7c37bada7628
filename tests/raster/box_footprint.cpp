// Whatever is drawn inside a box stays inside its footprint, on the screen and in depth.
#include "farfield/raster/box_footprint.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "catch.hpp"
#include "farfield/raster/sample_rect.hpp"
#include "farfield/raster/scan_conversion.hpp"
#include "farfield/raster/snapping.hpp"
#include "support/pictures.hpp"
#include "support/random.hpp"

using namespace farfield;
using namespace farfield::detail;
using namespace farfield::test;

namespace {

LocalView local(const View& view) {
    return LocalView(view, glm::dvec3(0), 8);
}

}  // namespace

TEST_CASE("box footprint: triangles inside stay inside, as they are rasterized", "[raster]") {
    Random random(440);
    int bounded = 0, outside = 0, tight = 0, large = 0, before = 0, compared = 0;
    for (int round = 0; round < 4000; ++round) {
        const float far = std::pow(10.0f, random.between(-1, 3));
        const glm::dvec3 eye = glm::dvec3(random.in_cube(far)), target = glm::dvec3(random.in_cube(1));
        View view = round % 4 == 3 ? looking_orthographic(eye, target, random.between(0.1f, 9)) : looking(eye, target);
        view.width = 1 + int(random.below(700));
        view.height = 1 + int(random.below(300));
        const SampleProjection to(local(view), 1 + int(random.below(8)));
        const glm::vec3 center = random.in_cube(1.5f);
        const glm::vec3 half = glm::abs(random.in_cube(std::pow(10.0f, random.between(-5, 0))));
        const BoxFootprint footprint(center, half, to);
        if (!footprint.is_bounded) continue;
        ++bounded;
        SampleRect seen;
        for (int i = 0; i < 40; ++i) {
            std::array<glm::vec3, 3> corners;
            for (glm::vec3& p : corners) {
                const glm::vec3 at = glm::clamp(random.in_cube(2), glm::vec3(-1), glm::vec3(1));
                p = center + at * half;
            }
            SnappedTriangle t;
            for (unsigned c = 0; c < 3; ++c) {
                const glm::vec3 p = to.project(corners[c]);
                const float inverse = to.inverse_w(p.z), x = p.x * inverse + to.offset_x,
                            y = p.y * inverse + to.offset_y;
                const float guard = SampleProjection::guard_band * 256;
                t.x[c] = snapped_to_256th(std::clamp(x, -guard, guard));
                t.y[c] = snapped_to_256th(std::clamp(y, -guard, guard));
                t.q[c] = to.q(p.z, inverse);
                outside += t.q[c] > footprint.fronts.nearest_q;
            }
            if (t.doubled_area() < 0) t.flip();
            if (t.doubled_area() == 0) continue;
            // The depth of a sliver is known only within that of its corners.
            const auto side = [&](int a, int b) {
                return std::hypot(double(t.x[b] - t.x[a]), double(t.y[b] - t.y[a]));
            };
            const double longest = std::max({side(0, 1), side(1, 2), side(2, 0)});
            const bool is_sliver = double(t.doubled_area()) < longest * longest / 64;
            const DepthPlane depth(t, t.doubled_area());
            scan_convert(t, to, [&](int y, int begin, int end) {
                for (int x = begin; x < end && !is_sliver; x += std::max(1, (end - begin) / 3)) {
                    before += depth.at(depth.row(y), x) > footprint.fronts.nearest_in(x, y, x, y);
                    ++compared;
                }
                seen.add(begin, y, end, y + 1);
                outside += footprint.is_empty() || begin < footprint.x0 || end - 1 > footprint.x1 || y < footprint.y0 ||
                           y > footprint.y1;
            });
        }
        if (seen.is_empty()) continue;
        // Not much too large either: two samples around, where triangles reach all corners.
        ++large;
        tight += seen.x0 - footprint.x0 <= 4 && seen.y0 - footprint.y0 <= 4 && footprint.x1 - seen.x1 + 1 <= 4 &&
                 footprint.y1 - seen.y1 + 1 <= 4;
    }
    INFO(bounded << " bounded, " << tight << " of " << large << " tight");
    CHECK(outside == 0);
    CHECK(before == 0);
    CHECK(compared > 100000);
    CHECK(bounded > 2000);
    CHECK(tight > large * 3 / 4);
}

TEST_CASE("box footprint: a box that reaches to the near plane has none", "[raster]") {
    View view = looking({0, 0, 3}, {}, 64);
    view.camera.near_depth = 1;
    const SampleProjection to(local(view), 1);
    CHECK(BoxFootprint({0, 0, 1}, glm::vec3(0.9f), to).is_bounded);
    CHECK_FALSE(BoxFootprint({0, 0, 1}, glm::vec3(1.1f), to).is_bounded);
    CHECK_FALSE(BoxFootprint({0, 0, 3}, glm::vec3(0.1f), to).is_bounded);
    CHECK_FALSE(BoxFootprint({0, 0, 9}, glm::vec3(0.1f), to).is_bounded);
    CHECK(BoxFootprint({500, 0, -1}, glm::vec3(1), to).is_empty());
    CHECK_FALSE(BoxFootprint({0, 0, -1}, glm::vec3(0), to).is_empty());
}
