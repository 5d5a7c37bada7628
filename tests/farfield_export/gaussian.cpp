#include "gaussian.hpp"

#include <cmath>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>
#include <numbers>
#include <random>
#include <vector>

#include "catch.hpp"
#include "farfield/build.hpp"
#include "farfield/cost_model/triangle_count.hpp"
#include "farfield/partition/octree.hpp"
#include "farfield/primitive/triangle.hpp"
#include "farfield/spatial_hierarchy.hpp"

using namespace farfield_export;

namespace {

using Hierarchy = farfield::SpatialHierarchy<farfield::Octree, farfield::OpacityTensor, farfield::TriangleCount>;

/// The integral of a splat's opacity over a parallel picture from w.
float covered_by(const GaussianSplat& s, glm::vec3 w) {
    const glm::mat3 axes = matrix_of(s.rotation);
    glm::vec3 along;
    for (int i = 0; i < 3; ++i) along[i] = glm::dot(axes[i], w);
    const glm::vec3 v = s.scale * s.scale;
    const float adjugate =
        along.x * along.x * v.y * v.z + along.y * along.y * v.z * v.x + along.z * along.z * v.x * v.y;
    return 2 * std::numbers::pi_v<float> * s.opacity * std::sqrt(adjugate);
}

}  // namespace

TEST_CASE("axes of symmetric matrices are theirs, and quaternions are their axes") {
    std::mt19937 random(3);
    const auto number = [&] { return float(random() % 2001) / 1000 - 1; };
    for (int round = 0; round < 200; ++round) {
        glm::mat3 root;
        for (int i = 0; i < 9; ++i) root[i / 3][i % 3] = round % 4 == 0 && i > 2 ? 0.0f : number();
        const glm::mat3 m = root * glm::transpose(root);
        const PrincipalAxes found = principal_axes(m);
        glm::mat3 diagonal(0);
        for (int i = 0; i < 3; ++i) diagonal[i][i] = found.values[i];
        const glm::mat3 again = found.axes * diagonal * glm::transpose(found.axes);
        const glm::mat3 turned = matrix_of(quaternion_of(found.axes));
        CHECK(glm::determinant(found.axes) == Approx(1).epsilon(1e-4));
        for (int i = 0; i < 9; ++i) {
            CHECK(again[i / 3][i % 3] == Approx(m[i / 3][i % 3]).margin(1e-5));
            CHECK(turned[i / 3][i % 3] == Approx(found.axes[i / 3][i % 3]).margin(1e-4));
        }
    }
}

TEST_CASE("a splat shows the area of its tensor from everywhere") {
    std::mt19937 random(4);
    const auto number = [&] { return float(random() % 2001) / 1000 - 1; };
    const auto direction = [&] { return glm::normalize(glm::vec3(number(), number(), number() + 1e-3f)); };
    std::vector<farfield::Triangle> leaves;
    for (int i = 0; i < 4000; ++i) {
        const glm::vec3 a(number(), number(), number());
        const glm::vec3 b(number(), number(), number()), c(number(), number(), number());
        leaves.push_back({{a, a + 0.03f * b, a + 0.03f * c}, {60, 200, 40, 255}});
    }
    const auto hierarchy = farfield::build_in_place<Hierarchy>(leaves, {});
    REQUIRE(hierarchy.root_stand_in() != nullptr);
    const auto& data = *hierarchy.root_stand_in();
    const farfield::Cell cell = hierarchy.root_cell();
    const GaussianSplat splat = gaussian_of(hierarchy.approximation_policy(), data, cell, {.sheet_gain = 1});
    CHECK(splat.opacity > 0);
    CHECK(splat.opacity <= 1);
    CHECK(splat.rgb.y == Approx(200.0f / 255).margin(0.02));
    const farfield::TensorAppearance look{data.unpacked()};
    const float unit = farfield::tensor_unit(cell);
    for (int i = 0; i < 50; ++i) {
        const glm::vec3 w = direction();
        CHECK(covered_by(splat, w) == Approx(look.seen_from(w).area * unit * unit).epsilon(0.12));
    }
    for (int axis = 0; axis < 3; ++axis) CHECK(splat.reach()[axis] > 0);
}

TEST_CASE("a flat thing becomes a flat splat, and nothing becomes none") {
    std::vector<farfield::Triangle> wall;
    for (int i = 0; i < 32; ++i) {
        for (int k = 0; k < 32; ++k) {
            const glm::vec3 a(float(i) / 32, float(k) / 32, 0), x(1.0f / 32, 0, 0), y(0, 1.0f / 32, 0);
            wall.push_back({{a, a + x, a + y}, {200, 100, 50, 255}});
            wall.push_back({{a + x, a + x + y, a + y}, {200, 100, 50, 255}});
        }
    }
    const auto hierarchy = farfield::build_in_place<Hierarchy>(wall, {});
    REQUIRE(hierarchy.root_stand_in() != nullptr);
    const GaussianSplat splat =
        gaussian_of(hierarchy.approximation_policy(), *hierarchy.root_stand_in(), hierarchy.root_cell());
    const glm::vec3 reach = splat.reach();
    CHECK(reach.z < 0.3f * reach.x);
    CHECK(reach.x == Approx(reach.y).epsilon(0.1));
    CHECK(gaussian_of({}, farfield::StoredTensor{}, hierarchy.root_cell()).opacity == 0);
}
