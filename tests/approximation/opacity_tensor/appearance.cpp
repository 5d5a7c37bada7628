#include "farfield/approximation/opacity_tensor/appearance.hpp"

#include <array>
#include <cmath>

#include "approximation/opacity_tensor/sums_of.hpp"
#include "catch.hpp"
#include "support/scenes.hpp"

using namespace farfield;
using namespace farfield::test;

namespace {

/// A flat piece of this area and direction in the middle of its bounds.
TensorShape flat(glm::vec3 normal, float area) {
    TensorShape s;
    std::array<float, 6> tensor{normal.x * normal.x, normal.y * normal.x, normal.z * normal.x,
                                normal.y * normal.y, normal.z * normal.y, normal.z * normal.z};
    s.root = TensorFit::root_of(tensor);
    for (float& v : s.root) v *= area;
    s.center = glm::vec3(0.5f);
    s.extent = glm::vec3(1);
    s.rgb = {200, 100, 50};
    s.law = AreaLaw::coherent;
    return s;
}

}  // namespace

TEST_CASE("a flat shape shows the cosine of its normal, in its color", "[approximation]") {
    Random random(131);
    for (int i = 0; i < 100; ++i) {
        const glm::vec3 n = random.direction(), w = random.direction();
        const TensorAppearance appearance{flat(n, 0.5f)};
        const auto seen = appearance.seen_from(w);
        CHECK(std::abs(seen.area - 0.5f * std::abs(glm::dot(n, w))) < 0.005f);
        CHECK(seen.rgb == appearance.shape.rgb);
    }
}

TEST_CASE("closed surfaces show their fronts and no backs", "[approximation]") {
    TensorShape s = flat({0, 0, 1}, 0.5f);
    s.facing = {0, 0, 0.5f};  // one sheet
    const TensorAppearance sheet{s, true};
    CHECK(sheet.seen_from({0, 0, 1}).area == Approx(0.5f));
    CHECK(sheet.seen_from({0, 0, -1}).area == 0);
    s.facing = glm::vec3(0);  // two of half the area, back to back
    const TensorAppearance both{s, true};
    CHECK(both.seen_from({0, 0, 1}).area == Approx(0.25f));
    CHECK(both.seen_from({0, 0, -1}).area == Approx(0.25f));
}

TEST_CASE("overlapping areas never cover more than the outline, unless overlap is counted twice", "[approximation]") {
    Random random(132);
    for (const AreaLaw law : {AreaLaw::independent, AreaLaw::mixed, AreaLaw::coherent}) {
        for (int i = 0; i < 100; ++i) {
            TensorShape s = flat(random.direction(), 5);
            s.extent = glm::vec3(random.between(0.1f, 1), random.between(0.1f, 1), random.between(0.1f, 1));
            s.law = law;
            const glm::vec3 w = random.direction();
            const TensorAppearance once{s}, twice{s, false, false};
            CHECK(once.seen_from(w).area <= outline_from(s, w));
            CHECK(once.seen_from(w).area <= twice.seen_from(w).area * 1.0001f);
            CHECK(twice.seen_from(w).area == area_seen_from(s, w));
        }
    }
}

TEST_CASE("the side that is lit is brighter by its tone", "[approximation]") {
    TensorShape s = flat({0, 0, 1}, 0.5f);
    s.tone = {0, 0, 0.1f};
    const TensorAppearance appearance{s};
    CHECK(appearance.seen_from({0, 0, 1}).rgb.r == Approx(200 * 1.2f));
    CHECK(appearance.seen_from({0, 0, -1}).rgb.r == Approx(200 * 0.8f));
}

TEST_CASE("a rectangle is as large as the box of its contents, and larger where they need it", "[approximation]") {
    View view;
    view.camera = Camera::orthographic({0, 0, 5}, {0, 0, 0}, {0, 1, 0}, 4);
    const LocalView local(view, glm::dvec3(0), 4);
    TensorShape s = flat({0, 0, 1}, 0.5f);
    s.extent = {0.5f, 0.25f, 1.0f / 16};
    CHECK(TensorAppearance{s}.rectangle({0, 0, 0}, local, 0.1f) == glm::vec2(0.5f, 0.25f));
    s.law = AreaLaw::independent;
    const glm::vec2 strewn = TensorAppearance{s}.rectangle({0, 0, 0}, local, 0.1f);
    CHECK(strewn.x == Approx(0.5f));
    CHECK(strewn.y == Approx(0.25f));
    for (const AreaLaw law : {AreaLaw::independent, AreaLaw::coherent}) {
        s.law = law;
        for (const float area : {0.125f, 0.13f, 0.2f, 1.0f}) {
            const glm::vec2 size = TensorAppearance{s}.rectangle({0, 0, 0}, local, area);
            CHECK(size.x * size.y >= 0.9999f * area);
        }
    }
}

TEST_CASE("several sheets take the room of their box", "[approximation]") {
    View view;
    view.camera = Camera::orthographic({0, 0, 5}, {0, 0, 0}, {0, 1, 0}, 4);
    const LocalView local(view, glm::dvec3(0), 4);
    // Two slats at 45 degrees, one above the other: each is an eighth high and they lie in a box of a half.
    TensorShape s = flat({0, 0.8f, 0.6f}, 0.25f);
    s.extent = {0.5f, 0.5f, 0.125f};
    const TensorAppearance appearance{s};
    const glm::vec2 one = appearance.rectangle({0, 0, 0}, local, 0.04f),
                    two = appearance.rectangle({0, 0, 0}, local, 0.2f);
    CHECK(one.y < 0.2f);
    CHECK(two.x == Approx(0.5f));
    CHECK(two.y == Approx(0.5f));
}

TEST_CASE("crossing faces meet in the centroid and keep the area", "[approximation]") {
    const Cell cell = unit_cell(2);
    TensorShape s = flat({0, 0, 1}, 0.25f);
    s.center = {0.25f, 0.5f, 0.75f};
    s.extent = {0.5f, 1, 1};
    const TensorAppearance appearance{s, false, false};
    CHECK(appearance.center_in(cell) == glm::vec3(-1, 0, 1));
    for (int axis = 0; axis < 3; ++axis) {
        for (const bool looks_up : {false, true}) {
            const Face face = appearance.crossing_face(cell, axis, looks_up);
            CHECK(face.side == 2 * axis + (looks_up ? 1 : 0));
            CHECK((face.lower + face.upper) * 0.5f == appearance.center_in(cell));
            CHECK(face.upper[axis] - face.lower[axis] == 0);
            CHECK(int(face.rgba.a) == (axis == 2 ? 128 : 0));  // a quarter of half the bounds
        }
    }
}
