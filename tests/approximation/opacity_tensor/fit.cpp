#include "farfield/approximation/opacity_tensor/fit.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "approximation/opacity_tensor/sums_of.hpp"
#include "catch.hpp"
#include "support/scenes.hpp"

using namespace farfield;
using namespace farfield::test;

namespace {

/// The shape that is stored, not rounded.
TensorShape shape_of(const Cell& cell, const Triangles& triangles, bool counts_overlap = false) {
    const TensorSums d = sums_of(cell, triangles);
    return TensorFit(d, cell, false).shape(counts_overlap);
}
AreaLaw law_of(const Cell& cell, const Triangles& triangles) {
    const TensorSums d = sums_of(cell, triangles);
    return TensorFit(d, cell, false).fitting_law();
}
double area_of(const Triangles& triangles) {
    double sum = 0;
    for (const Triangle& t : triangles) sum += double(t.area());
    return sum;
}

/// A square about `center`, n x n quads.
Triangles square(glm::vec3 center, glm::vec3 normal, float side, int n) {
    const glm::vec3 other = std::abs(normal.x) < 0.7f ? glm::vec3(1, 0, 0) : glm::vec3(0, 1, 0);
    const glm::vec3 u = glm::normalize(glm::cross(other, normal)), v = glm::cross(normal, u);
    return sheet(center - (u + v) * (0.5f * side), u * side, v * side, n, n, {255, 255, 255, 255});
}
/// Leaves of this side strewn over [-1, 1]^3 that cover together `fill` times a face of it on average.
Triangles leaves(float fill, float side, std::uint64_t seed) {
    Random random(seed);
    const auto count = int(fill * 8 / (side * side));  // half of their area is seen, a face has 4
    Triangles out;
    for (int i = 0; i < count; ++i) append(out, square(random.in_cube(1 - side), random.direction(), side, 1));
    return out;
}

/// L L^T, lower triangle by columns.
std::array<double, 6> squared(const std::array<float, 6>& root) {
    const double xx = root[0], yx = root[1], zx = root[2], yy = root[3], zy = root[4], zz = root[5];
    return {xx * xx, xx * yx, xx * zx, yx * yx + yy * yy, yx * zx + yy * zy, zx * zx + zy * zy + zz * zz};
}

}  // namespace

TEST_CASE("a flat piece is seen with the cosine of its normal", "[approximation]") {
    Random random(91);
    for (int i = 0; i < 300; ++i) {
        glm::vec3 n = random.direction();
        if (i % 8 == 0) n = glm::vec3(i % 3 == 0, i % 3 == 1, i % 3 == 2);
        const float side = random.between(0.05f, 1);
        const TensorShape s = shape_of(unit_cell(), square(random.in_cube(0.2f), n, side, 1 + i % 3));
        for (int k = 0; k < 20; ++k) {
            const glm::vec3 w = random.direction();
            const float expected = side * side * std::abs(glm::dot(n, w));
            INFO("normal " << n.x << " " << n.y << " " << n.z << ", cosine " << glm::dot(n, w));
            CHECK(std::abs(4 * area_seen_from(s, w) - expected) <= 0.01f * side * side);
        }
    }
}

TEST_CASE("from all directions together half of the area is seen", "[approximation]") {
    Random random(92);
    for (int i = 0; i < 40; ++i) {
        // From one triangle to many, of all directions or mostly of one.
        Triangles triangles = random_triangles(std::size_t(1) << i % 8, 920 + std::uint64_t(i), 0.2f);
        if (i % 2 != 0) {
            for (Triangle& t : triangles) {
                for (glm::vec3& v : t.vertices) v.z *= 0.1f;
            }
        }
        const Cell cell = unit_cell(2);  // of which nothing sticks out
        const TensorShape s = shape_of(cell, triangles);
        double sum = 0;
        const int count = 20000;
        for (int k = 0; k < count; ++k) sum += double(area_seen_from(s, random.direction()));
        const double unit = double(tensor_unit(cell)), expected = 0.5 * area_of(triangles) / (unit * unit);
        INFO(triangles.size() << " triangles, " << i);
        CHECK(std::abs(sum / count / expected - 1) < 0.01);
    }
}

TEST_CASE("the root of a tensor squared is the tensor", "[approximation]") {
    Random random(96);
    for (int i = 0; i < 4000; ++i) {
        std::array<float, 6> t{};
        const int rank = i % 4;
        const float size = std::exp2(random.between(-20, 20));
        for (int k = 0; k < rank; ++k) {
            glm::vec3 v = random.direction() * size * random.between(0.1f, 1);
            if (i % 5 == 0) v[i % 3] = 0;
            t[0] += v.x * v.x, t[1] += v.y * v.x, t[2] += v.z * v.x;
            t[3] += v.y * v.y, t[4] += v.z * v.y, t[5] += v.z * v.z;
        }
        TensorShape shape;
        shape.root = TensorFit::root_of(t);
        const auto again = squared(shape.root);
        const double largest = std::max({t[0], t[3], t[5]});
        INFO("rank " << rank << ", largest " << largest);
        for (std::size_t k = 0; k < 6; ++k) {
            CHECK(std::isfinite(shape.root[k]));
            // A coordinate in which less than 1e-5 of the largest lies is left out, and its products with others.
            CHECK(std::abs(again[k] - double(t[k])) <= 0.0033 * largest);
        }
        for (int k = 0; k < 10; ++k) {
            const glm::dvec3 w(random.direction());
            const double square = t[0] * w.x * w.x + t[3] * w.y * w.y + t[5] * w.z * w.z +
                                  2 * (t[1] * w.x * w.y + t[2] * w.x * w.z + t[4] * w.y * w.z);
            const double expected = std::sqrt(std::max(square, 0.0)), found = double(area_seen_from(shape, w));
            CHECK(std::abs(found - expected) <= 0.0066 * std::sqrt(largest));
        }
    }
    for (const float v : TensorFit::root_of({})) CHECK(v == 0);
    CHECK(TensorFit::mean_area({}) == 0);
}

TEST_CASE("the mean over the lattice is the mean over all directions", "[approximation]") {
    // |n.w| has the mean 1/2, an isotropic tensor's area is the same from everywhere.
    Random random(97);
    for (int i = 0; i < 500; ++i) {
        const glm::vec3 n = random.direction();
        const auto root = TensorFit::root_of({n.x * n.x, n.y * n.x, n.z * n.x, n.y * n.y, n.z * n.y, n.z * n.z});
        CHECK(std::abs(TensorFit::mean_area(root) - 0.5f) < 0.005f);
    }
    CHECK(TensorFit::mean_area({2, 0, 0, 2, 0, 2}) == Approx(2));
}

TEST_CASE("a plane is coherent, leaves are independent", "[approximation]") {
    Random random(98);
    for (const float looseness : {1.0f, 2.0f}) {
        const Cell cell = unit_cell(looseness);
        for (int axis = 0; axis < 3; ++axis) {
            glm::vec3 corner(-1), u(0), v(0);
            corner[axis] = 0.1f;
            u[(axis + 1) % 3] = v[(axis + 2) % 3] = 2;
            CHECK(law_of(cell, sheet(corner, u, v, 8, 8, {255, 255, 255, 255})) == AreaLaw::coherent);
            u[axis] = 0.8f;
            CHECK(law_of(cell, sheet(corner, u, v, 8, 8, {255, 255, 255, 255})) == AreaLaw::coherent);
        }
        for (const float fill : {0.7f, 1.0f, 2.0f}) {
            CHECK(law_of(cell, leaves(fill, 0.08f, 980)) == AreaLaw::independent);
        }
    }
}

TEST_CASE("what the masks saw of overlapping areas is what is kept along the axes", "[approximation]") {
    // Half of the cell's width and n sheets behind each other.
    for (const int n : {1, 2, 10}) {
        Triangles sheets;
        for (int i = 0; i < n; ++i) {
            const float z = n == 1 ? 0.0f : -0.9f + 1.8f * float(i) / float(n - 1);
            append(sheets, sheet({-1, -1, z}, {1, 0, 0}, {0, 2, 0}, 4, 4, {255, 255, 255, 255}));
        }
        // Something at the far border widens the contents' box: half of it is covered.
        append(sheets, sheet({0.98f, -1, -1}, {0.02f, 0, 0}, {0, 0.02f, 0}, 1, 1, {255, 255, 255, 255}));
        const TensorShape all = shape_of(unit_cell(), sheets), once = shape_of(unit_cell(), sheets, true);
        INFO(n << " sheets, law " << int(once.law));
        CHECK(area_seen_from(all, {0, 0, 1}) == Approx(0.5f * float(n)).epsilon(0.01));
        const float covered = 1 - transmitted(1, area_seen_from(once, {0, 0, 1}), once.law);
        CHECK(covered == Approx(0.5f).margin(0.02));
    }
}

TEST_CASE("slats that cover enough from above are all kept", "[approximation]") {
    Triangles slats;
    for (int i = 0; i < 16; ++i) {
        append(slats, sheet({-1, -0.9375f + 0.125f * float(i), -1}, {0, 0, 2}, {2, 0, 0}, 4, 4, {255, 255, 255, 255}));
    }
    const TensorShape all = shape_of(unit_cell(), slats), once = shape_of(unit_cell(), slats, true);
    CHECK(once.law == AreaLaw::coherent);
    for (const float angle : {0.0f, 0.5f, 0.785f, 1.2f}) {
        const glm::vec3 w(0, std::cos(angle), std::sin(angle));
        CHECK(area_seen_from(once, w) >= 0.99f * area_seen_from(all, w));
    }
}

TEST_CASE("centroid, extent and color are those of the contents", "[approximation]") {
    const Cell cell = unit_cell(2);
    Triangles t = sheet({0, 0, 0.5f}, {1, 0, 0}, {0, 0.5f, 0}, 3, 2, {200, 100, 50, 255});
    TensorShape s = shape_of(cell, t);
    const auto at = [](glm::vec3 p) { return (p + 2.0f) * 0.25f; };
    CHECK(glm::length(s.center - at({0.5f, 0.25f, 0.5f})) < 1e-5f);
    CHECK(glm::length(s.extent - glm::vec3(0.25f, 0.125f, 1.0f / 64)) < 1e-5f);
    CHECK(glm::length(s.rgb - glm::vec3(200, 100, 50)) < 0.01f);
    // Three times as large, elsewhere, of another color.
    append(t, sheet({-1, -1, -0.5f}, {1, 0, 0}, {0, 1.5f, 0}, 3, 2, {0, 200, 50, 255}));
    s = shape_of(cell, t);
    CHECK(glm::length(s.center - at({-0.25f, -0.125f, -0.25f})) < 1e-5f);
    CHECK(glm::length(s.rgb - glm::vec3(50, 175, 50)) < 0.01f);
    // Half transparent: half of the area.
    const TensorShape opaque = shape_of(cell, t);
    for (Triangle& triangle : t) triangle.rgba.a = 128;
    const TensorShape half = shape_of(cell, t);
    CHECK(area_seen_from(half, {0, 0, 1}) == Approx(area_seen_from(opaque, {0, 0, 1}) * (128.0f / 255)));
    CHECK(glm::length(half.center - opaque.center) < 1e-5f);
}

TEST_CASE("drafts of nothing are empty", "[approximation]") {
    const Cell cell = unit_cell();
    CHECK(TensorFit(TensorSums{}, cell, false).is_empty());
    const glm::vec3 a(0.1f, 0.2f, 0.3f), b(-0.5f, 0.2f, 0.9f);
    const TensorSums lines = sums_of(cell, {{{a, a, a}, {}}, {{a, b, b}, {}}, {{a, b, a}, {}}});
    CHECK(TensorFit(lines, cell, false).is_empty());
    // Areas, but all transparent.
    const TensorSums glass = sums_of(cell, sheet(a, {0.3f, 0, 0}, {0, 0.3f, 0}, 2, 2, {255, 255, 255, 0}));
    CHECK(TensorFit(glass, cell, false).is_empty());
    Cell point = cell;
    point.half = point.bounds_half = glm::vec3(0);
    TensorSums d = sums_of(cell, sheet(a, {0.3f, 0, 0}, {0, 0.3f, 0}, 2, 2, {255, 255, 255, 255}));
    CHECK_FALSE(TensorFit(d, cell, false).is_empty());
    CHECK(TensorFit(d, point, false).is_empty());
}
