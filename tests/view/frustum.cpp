#include "farfield/view/frustum.hpp"

#include <algorithm>

#include "catch.hpp"
#include "farfield/view/local_view.hpp"
#include "support/random.hpp"

using namespace farfield;
using namespace farfield::test;

TEST_CASE("planes crossed are those with corners of the box on both sides", "[geometry]") {
    Random random(8);
    int outside = 0, inside = 0, crossing = 0;
    for (int i = 0; i < 5000; ++i) {
        View view;
        view.camera =
            i % 2 ? Camera::perspective(random.in_cube(2), random.in_cube(1), {0, 1, 0}, random.between(0.3f, 2.5f))
                  : Camera::orthographic(random.in_cube(2), random.in_cube(1), {0, 1, 0}, random.between(0.5f, 4),
                                         i % 4 ? 0 : 0.5f);
        view.width = 100 + int(random.below(400));
        const LocalView local(view, {}, 4);
        const glm::vec3 center = random.in_cube(3),
                        half(random.between(0, 1), random.between(0, 1), random.between(0, 1));
        const PlaneMask asked = i % 3 ? all_planes : PlaneMask(random.below(64));
        const PlaneMask got = crossed_planes(local.planes, center, half, asked);
        bool is_outside = false, unclear = false;
        PlaneMask crossed = 0;
        for (PlaneMask p = 0; p < plane_count; ++p) {
            if ((asked >> p & 1) == 0) continue;
            double low = 1e30, high = -1e30;
            for (int c = 0; c < 8; ++c) {
                const glm::dvec3 corner =
                    glm::dvec3(center) + glm::dvec3(half) * glm::dvec3(c & 1 ? 1 : -1, c & 2 ? 1 : -1, c & 4 ? 1 : -1);
                const double d = glm::dot(glm::dvec3(local.planes[p]), corner) + double(local.planes[p].w);
                low = std::min(low, d);
                high = std::max(high, d);
            }
            unclear = unclear || std::abs(low) < 1e-5 || std::abs(high) < 1e-5;
            is_outside = is_outside || high < 0;
            if (low < 0 && high >= 0) crossed |= PlaneMask(1) << p;
        }
        if (unclear) continue;
        CHECK(got == (is_outside ? outside_a_plane : crossed));
        (is_outside ? outside : crossed ? crossing : inside) += 1;
    }
    CHECK(std::min({outside, inside, crossing}) > 100);
}
