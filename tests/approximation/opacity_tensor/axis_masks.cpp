#include "farfield/approximation/opacity_tensor/axis_masks.hpp"

#include <algorithm>
#include <cmath>
#include <glm/vec2.hpp>
#include <vector>

#include "catch.hpp"
#include "support/scenes.hpp"

using namespace farfield;
using namespace farfield::test;

namespace {

constexpr int side = AxisMasks::side, samples = side * side;
const Box unit_box{{-1, -1, -1}, {1, 1, 1}};

void add(AxisMasks& masks, const Box& box, const Triangle& t) {
    const glm::vec3 corners[3] = {t.vertices[0], t.vertices[1], t.vertices[2]};
    masks.add(box, corners);
}
AxisMasks masks_of(const Box& box, const Triangles& triangles) {
    AxisMasks masks;
    for (const Triangle& t : triangles) add(masks, box, t);
    return masks;
}

/// By asking what a triangle around nothing but this sample adds.
bool covers(const AxisMasks& masks, const Box& box, int axis, int i, int j) {
    const int u = (axis + 1) % 3, v = (axis + 2) % 3;
    const glm::vec3 step = box.size() * (1.0f / float(side));
    glm::vec3 at = box.lower + 0.5f * box.size();
    at[u] = box.lower[u] + float(i) * step[u];
    at[v] = box.lower[v] + float(j) * step[v];
    glm::vec3 corners[3] = {at, at, at};
    corners[0][u] -= 0.25f * step[u];
    corners[0][v] -= 0.25f * step[v];
    corners[1][u] += 0.5f * step[u];
    corners[2][v] += 0.5f * step[v];
    AxisMasks with = masks;
    with.add(box, corners);
    return with.count(axis) == masks.count(axis);
}

bool equal(const AxisMasks& a, const AxisMasks& b, const Box& box) {
    for (int axis = 0; axis < 3; ++axis) {
        for (int j = 0; j < side; ++j) {
            for (int i = 0; i < side; ++i) {
                if (covers(a, box, axis, i, j) != covers(b, box, axis, i, j)) return false;
            }
        }
    }
    return true;
}

/// How far inside of the projected triangle a sample lies, in steps; negative outside.
double depth_inside(const Triangle& t, const Box& box, int axis, int i, int j) {
    const int u = (axis + 1) % 3, v = (axis + 2) % 3;
    glm::dvec2 p[3];
    for (std::size_t c = 0; c < 3; ++c) {
        for (int k = 0; k < 2; ++k) {
            const int a = k == 0 ? u : v;
            p[c][k] = (double(t.vertices[c][a]) - double(box.lower[a])) * side / double(box.upper[a] - box.lower[a]);
        }
    }
    const auto cross = [](glm::dvec2 a, glm::dvec2 b) { return a.x * b.y - a.y * b.x; };
    const double sign = cross(p[1] - p[0], p[2] - p[0]) < 0 ? -1 : 1;
    double least = 1e9;
    for (int c = 0; c < 3; ++c) {
        const glm::dvec2 edge = p[(c + 1) % 3] - p[c], to = glm::dvec2(i, j) - p[c];
        const double length = std::sqrt(edge.x * edge.x + edge.y * edge.y);
        least = std::min(least, length > 0 ? sign * cross(edge, to) / length : -1e9);
    }
    return least;
}

/// A grid of squares over a part of the box, its inner corners moved about, each square cut along either diagonal.
Triangles torn_grid(glm::vec3 corner, glm::vec3 u, glm::vec3 v, int n, Random& random) {
    std::vector<glm::vec3> at;
    for (int j = 0; j <= n; ++j) {
        for (int i = 0; i <= n; ++i) {
            const auto inner = [&](int k) { return k == 0 || k == n ? 0.0f : random.between(-0.3f, 0.3f); };
            const float x = float(i) + inner(i), y = float(j) + inner(j);
            at.push_back(corner + u * (x / float(n)) + v * (y / float(n)));
        }
    }
    Triangles out;
    for (int j = 0; j < n; ++j) {
        for (int i = 0; i < n; ++i) {
            const auto k = std::size_t(j * (n + 1) + i), above = k + std::size_t(n) + 1;
            const glm::vec3 a = at[k], b = at[k + 1], c = at[above + 1], d = at[above];
            if (random.below(2) != 0) {
                out.push_back({{a, b, c}, {}});
                out.push_back({{a, c, d}, {}});
            } else {
                out.push_back({{a, b, d}, {}});
                out.push_back({{d, c, b}, {}});  // the other way around
            }
        }
    }
    return out;
}

}  // namespace

TEST_CASE("a mask holds the samples that lie in the projected triangle", "[approximation]") {
    Random random(61);
    int inside = 0, left_out = 0;
    for (int round = 0; round < 120; ++round) {
        Box box = unit_box;
        if (round % 2 != 0) {
            box.lower = random.in_cube(3);
            box.upper = box.lower + glm::vec3(random.between(0.1f, 2), random.between(0.1f, 2), random.between(1, 5));
        }
        const float reach = round % 3 == 0 ? 0.9f : round % 3 == 1 ? 0.5f : 0.12f;
        Triangle t;
        const glm::vec3 middle = 0.5f * (box.lower + box.upper) + random.in_cube(0.2f) * box.size();
        for (glm::vec3& v : t.vertices) v = middle + random.in_cube(reach) * box.size();
        const AxisMasks masks = masks_of(box, {t});
        int wrong = 0;
        for (int axis = 0; axis < 3; ++axis) {
            for (int j = 0; j < side; ++j) {
                for (int i = 0; i < side; ++i) {
                    const double depth = depth_inside(t, box, axis, i, j);
                    if (std::abs(depth) < 1.0 / 256) {
                        ++left_out;
                        continue;
                    }
                    inside += depth > 0;
                    wrong += covers(masks, box, axis, i, j) != (depth > 0);
                }
            }
        }
        INFO("round " << round);
        CHECK(wrong == 0);
    }
    CHECK(inside > 20000);
    CHECK(left_out < 2000);
}

TEST_CASE("triangles that share edges cover each sample once", "[approximation]") {
    Random random(62);
    for (int axis = 0; axis < 3; ++axis) {
        glm::vec3 corner(-1), u(0), v(0);
        corner[axis] = 0.3f;
        u[(axis + 1) % 3] = v[(axis + 2) % 3] = 2;
        u[axis] = 0.4f;  // seen askew from the other axes
        for (const int n : {1, 2, 7, 32, 45}) {
            const Triangles whole =
                n == 32 ? sheet(corner, u, v, n, n, {}) : torn_grid(corner, u, v, n, random);  // corners on samples
            int sum = 0;
            AxisMasks all;
            for (const Triangle& t : whole) {
                sum += masks_of(unit_box, {t}).count(axis);
                add(all, unit_box, t);
            }
            INFO("axis " << axis << ", " << n << " squares a side");
            CHECK(sum == samples);
            CHECK(all.count(axis) == samples);
        }
        // Half of it, from the middle on: no sample of the other half.
        CHECK(masks_of(unit_box, sheet(corner, 0.5f * u, v, 5, 3, {})).count(axis) == samples / 2);
        CHECK(masks_of(unit_box, sheet(corner + 0.5f * u, 0.5f * u, v, 5, 3, {})).count(axis) == samples / 2);
    }
}

TEST_CASE("what a parent covers is what its children cover", "[approximation]") {
    // Places in 256ths of the parent's steps: rounding leaves them alone, so that not even edges may differ.
    Random random(63);
    const auto snapped = [](glm::vec3 v) { return glm::round(v * 4096.0f) * (1.0f / 4096); };
    for (const bool is_loose : {true, false}) {
        for (int round = 0; round < 4; ++round) {
            AxisMasks parent, merged;
            for (int child = 0; child < 8; ++child) {
                // Of a loose cell the bounds are twice as large as the cell: its children's overlap.
                Box box;
                for (int axis = 0; axis < 3; ++axis) {
                    const bool upper = (child >> axis & 1) != 0;
                    box.lower[axis] = -1 + 2 * (is_loose ? (upper ? 0.375f : 0.125f) : (upper ? 0.5f : 0.0f));
                    box.upper[axis] = box.lower[axis] + 1;
                }
                AxisMasks own;
                for (int i = 0; i < 5; ++i) {
                    Triangle t;
                    const glm::vec3 middle = box.lower + glm::vec3(0.5f) + random.in_cube(0.3f);
                    for (glm::vec3& v : t.vertices) {
                        v = snapped(glm::clamp(middle + random.in_cube(0.4f), box.lower, box.upper));
                    }
                    add(own, box, t);
                    add(parent, unit_box, t);
                }
                merged.add_child(unit_box, own, box);
            }
            INFO((is_loose ? "loose" : "tight") << ", round " << round);
            for (int axis = 0; axis < 3; ++axis) CHECK(merged.count(axis) == parent.count(axis));
            CHECK(parent.count(0) > 50);
            CHECK(parent.count(0) < samples);
            CHECK(equal(merged, parent, unit_box));
        }
    }
}

TEST_CASE("masks of masks: three levels down a wall still covers its cell", "[approximation]") {
    // A wall through all cells it meets, cut at their borders; leaves are of an eighth.
    const auto masks_below = [](auto&& self, const Box& box, int levels) -> AxisMasks {
        AxisMasks own;
        const glm::vec3 middle = 0.5f * (box.lower + box.upper);
        if (levels == 0) {
            if (!(box.lower.z <= 0.1f && 0.1f < box.upper.z)) return own;
            return masks_of(
                box, sheet({box.lower.x, box.lower.y, 0.1f}, {box.size().x, 0, 0}, {0, box.size().y, 0}, 1, 1, {}));
        }
        for (int child = 0; child < 8; ++child) {
            Box part = box;
            for (int axis = 0; axis < 3; ++axis) {
                ((child >> axis & 1) != 0 ? part.lower : part.upper)[axis] = middle[axis];
            }
            own.add_child(box, self(self, part, levels - 1), part);
        }
        return own;
    };
    const AxisMasks masks = masks_below(masks_below, unit_box, 3);
    CHECK(masks.count(2) == samples);
    CHECK(masks.count(0) == 0);
    CHECK(masks.count(1) == 0);
}

TEST_CASE("what lies beside a box is not seen, and a flat box is seen squarely", "[approximation]") {
    for (int axis = 0; axis < 3; ++axis) {
        for (const float shift : {-2.001f, 2.001f, -70.0f, 70.0f, -1e30f, 1e30f}) {
            const int u = (axis + 1) % 3;
            glm::vec3 corner(-1), du(0), dv(0);
            corner[axis] = 0;
            corner[u] += shift;
            du[u] = dv[(axis + 2) % 3] = 2;
            CHECK(masks_of(unit_box, sheet(corner, du, dv, 1, 1, {})).count(axis) == 0);
        }
        // Twice as large as the box and around it.
        glm::vec3 corner(-2), du(0), dv(0);
        corner[axis] = 0;
        du[(axis + 1) % 3] = dv[(axis + 2) % 3] = 4;
        CHECK(masks_of(unit_box, sheet(corner, du, dv, 1, 1, {})).count(axis) == samples);

        Box flat = unit_box;
        flat.lower[axis] = flat.upper[axis] = 0;
        const AxisMasks squarely = masks_of(flat, sheet(corner, du, dv, 1, 1, {}));
        CHECK(squarely.count(axis) == samples);
        CHECK(squarely.count((axis + 1) % 3) == 0);
        CHECK(squarely.count((axis + 2) % 3) == 0);
        AxisMasks parent;
        parent.add_child(flat, squarely, flat);
        CHECK(parent.count(axis) == samples / 4);  // every other one each way
    }
    const Box point{{1, 1, 1}, {1, 1, 1}};
    CHECK(masks_of(point, sheet({0, 0, 1}, {2, 0, 0}, {0, 2, 0}, 1, 1, {})).count(2) == 0);
}

TEST_CASE("triangles without an area cover no sample", "[approximation]") {
    Random random(64);
    for (int i = 0; i < 200; ++i) {
        const glm::vec3 a = random.in_cube(1), b = random.in_cube(1);
        const AxisMasks masks = masks_of(unit_box, {{{a, a, a}, {}}, {{a, b, b}, {}}, {{a, b, a}, {}}});
        for (int axis = 0; axis < 3; ++axis) CHECK(masks.count(axis) == 0);
    }
}

TEST_CASE("masks are the same by vectors of any width", "[approximation]") {
    Random random(64);
    for (int i = 0; i < 4000; ++i) {
        // From a hundredth of the box to several times as large, and now and then exactly along its samples.
        const float reach = std::exp2(random.between(-6, 2));
        const glm::vec3 middle = random.in_cube(1.2f);
        glm::vec3 corners[3];
        for (glm::vec3& v : corners) {
            v = middle + random.in_cube(reach);
            if (i % 3 == 0) v = glm::round(v * 16.0f) * (1.0f / 16);
        }
        AxisMasks one_by_four, one_by_eight;
        one_by_four.add(unit_box, corners, Simd::four_lanes);
        one_by_eight.add(unit_box, corners, Simd::eight_lanes);
        REQUIRE(one_by_four == one_by_eight);
    }
}
