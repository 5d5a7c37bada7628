#include "farfield/approximation/opacity_tensor/area_sums.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "approximation/opacity_tensor/sums_of.hpp"
#include "catch.hpp"
#include "farfield/approximation/opacity_tensor.hpp"
#include "support/scenes.hpp"

using namespace farfield;
using namespace farfield::test;

namespace {

bool close(const AreaSums& a, const AreaSums& b, float by) {
    const float largest = std::max(a.area, b.area), brightest = 255 * largest;
    const auto within = [&](glm::vec3 p, glm::vec3 q, float of) {
        return glm::all(glm::lessThanEqual(glm::abs(p - q), glm::vec3(by * of)));
    };
    bool same = std::abs(a.area - b.area) <= by * largest && std::abs(a.opaque_area - b.opaque_area) <= by * largest;
    for (std::size_t i = 0; i < 6; ++i) same &= std::abs(a.tensor[i] - b.tensor[i]) <= by * largest;
    return same && within(a.normal, b.normal, largest) && within(a.along_axes, b.along_axes, largest) &&
           within(a.moment, b.moment, 4 * largest) && within(a.color, b.color, brightest) &&
           within(a.tone, b.tone, brightest);
}

}  // namespace

TEST_CASE("sums over a cell's parts are the sums over the cell, in any order", "[approximation]") {
    Random random(93);
    const Cell cell = unit_cell();
    for (int round = 0; round < 10; ++round) {
        const Triangles triangles = random_triangles(400, 930 + std::uint64_t(round), 0.3f);
        const TensorSums whole = sums_of(cell, triangles);
        std::vector<Cell> cells;
        std::vector<TensorSums> drafts;
        for (unsigned child = 0; child < 8; ++child) {
            Cell c = unit_cell();
            for (int axis = 0; axis < 3; ++axis) c.center[axis] = (child >> axis & 1) != 0 ? 0.5f : -0.5f;
            c.half = c.bounds_half = glm::vec3(0.5f);
            c.bounds_center = c.center;
            cells.push_back(c);
            drafts.push_back(sums_of(c, triangles));  // of which it takes what is in it
        }
        std::vector<ChildDraft<TensorSums>> children;
        for (unsigned child = 0; child < 8; ++child) children.push_back({child, &cells[child], &drafts[child]});
        for (int order = 0; order < 3; ++order) {
            TensorSums merged;
            OpacityTensor{}.merge(cell, merged, children);
            CHECK(close(merged.sums, whole.sums, 2e-5f));
            CHECK(
                glm::all(glm::lessThanEqual(glm::abs(merged.contents.lower - whole.contents.lower), glm::vec3(1e-6f))));
            CHECK(
                glm::all(glm::lessThanEqual(glm::abs(merged.contents.upper - whole.contents.upper), glm::vec3(1e-6f))));
            // Children snap to finer places.
            for (int axis = 0; axis < 3; ++axis) {
                CHECK(std::abs(merged.masks.count(axis) - whole.masks.count(axis)) <= 8);
            }
            random.shuffle(children);
        }
    }
}

TEST_CASE("own contents and children's add up", "[approximation]") {
    const Cell cell = unit_cell();
    const Triangles own = random_triangles(50, 94, 0.1f), below = random_triangles(50, 95, 0.1f);
    TensorSums merged = sums_of(cell, own);
    const TensorSums child = sums_of(cell, below);
    const std::vector<ChildDraft<TensorSums>> children{{0, &cell, &child}};
    OpacityTensor{}.merge(cell, merged, children);
    Triangles both = own;
    append(both, below);
    CHECK(close(merged.sums, sums_of(cell, both).sums, 1e-5f));
    TensorSums empty;
    OpacityTensor{}.merge(cell, empty, {});
    CHECK(TensorFit(empty, cell, false).is_empty());
}

TEST_CASE("what sticks out of a cell's bounds is not counted", "[approximation]") {
    const TensorSums d = sums_of(unit_cell(), sheet({-3, -3, 0.5f}, {6, 0, 0}, {0, 6, 0}, 5, 5, {255, 255, 255, 255}));
    CHECK(d.sums.area == Approx(4));
    CHECK(glm::length(d.contents.lower - glm::vec3(-1, -1, 0.5f)) < 1e-6f);
    CHECK(glm::length(d.contents.upper - glm::vec3(1, 1, 0.5f)) < 1e-6f);
    CHECK(d.masks.count(2) == AxisMasks::side * AxisMasks::side);
    CHECK(sums_of(unit_cell(), sheet({2, 2, 2}, {1, 0, 0}, {0, 1, 0}, 1, 1, {255, 255, 255, 255})).sums.area == 0);
}
