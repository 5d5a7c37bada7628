#include "farfield/paging/contents_reach.hpp"

#include <catch2/catch.hpp>
#include <cstdint>
#include <glm/common.hpp>
#include <glm/vec3.hpp>

#include "farfield/geometry/box.hpp"
#include "farfield/geometry/cell.hpp"
#include "support/random.hpp"

using namespace farfield;
using namespace farfield::test;
using farfield::detail::ContentsReach;

namespace {

Cell loose_cell(glm::vec3 center, glm::vec3 half) {
    return {.center = center, .half = half, .bounds_center = center, .bounds_half = 2.0f * half};
}
bool holds(const Box& outer, const Box& inner) {
    return outer.contains(inner.lower) && outer.contains(inner.upper);
}

}  // namespace

TEST_CASE("reach of contents: the least of its boxes that holds them, and never less than the cell") {
    Random random(11);
    for (int i = 0; i < 2000; ++i) {
        // Far from zero steps are no larger than what rounding moves.
        const float place = i % 3 == 0 ? 1e6f : 1.0f, size = i % 2 == 0 ? 1.0f : 1e-3f;
        const Cell cell = loose_cell(random.in_cube(place), glm::vec3(size) + glm::abs(random.in_cube(size)));
        const Box bounds = cell.bounds();
        Box contents = Box::empty();
        for (int corner = 0; corner < 3; ++corner) {
            const glm::vec3 p = cell.center + random.in_cube(random.between(0.0f, 2.0f)) * cell.half;
            contents.add(glm::clamp(p, bounds.lower, bounds.upper));
        }
        const ContentsReach reach(contents, cell);
        const Box box = reach.box(cell);
        REQUIRE(holds(box, contents));
        REQUIRE(holds(box, cell.box()));
        REQUIRE(holds(bounds, box));
        REQUIRE(reach.byte() > 0);
        if (reach.byte() > 1) REQUIRE_FALSE(holds(ContentsReach(std::uint8_t(reach.byte() - 1)).box(cell), contents));
        REQUIRE(ContentsReach(reach.byte()).box(cell) == box);
    }
}

TEST_CASE("reach of contents: what is not known, does not stick out, or is nothing") {
    const Cell cell = loose_cell({1, 2, 3}, {1, 2, 0.5f});
    CHECK(ContentsReach().box(cell) == cell.bounds());  // files written before say so
    CHECK(ContentsReach(255).box(cell) == cell.bounds());
    CHECK(ContentsReach(cell.box(), cell).box(cell) == cell.box());
    CHECK(ContentsReach(Box::empty(), cell).box(cell) == cell.box());
    CHECK(ContentsReach(cell.bounds(), cell).box(cell) == cell.bounds());
    CHECK(ContentsReach(Box{{-90, 2, 3}, {1, 2, 3}}, cell).box(cell) == cell.bounds());
    // Where bounds are the cell there is one box.
    Cell tight = cell;
    tight.bounds_half = tight.half;
    CHECK(ContentsReach(tight.box(), tight).box(tight) == tight.box());
    // Of no size at all.
    const Cell point{.center = glm::vec3(4), .bounds_center = glm::vec3(4)};
    CHECK(ContentsReach(point.box(), point).box(point) == point.box());
}
