#include "farfield/approximation/opacity_tensor/stored_tensor.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>

#include "catch.hpp"
#include "farfield/approximation/opacity_tensor/appearance_lanes.hpp"
#include "support/random.hpp"

using namespace farfield;
using namespace farfield::test;

namespace {

/// Of the scale, which is rounded up to a sixteenth of an octave.
const float largest_scale_error = std::exp2(1.0f / 16) - 1;

TensorShape random_shape(Random& random) {
    TensorShape s;
    const float size = std::exp2(random.between(-20, 8));
    for (float& v : s.root) v = random.between(-size, size);
    s.facing = random.in_cube(size);
    s.tone = random.in_cube(size);
    s.center = random.in_cube(0.5f) + 0.5f;
    s.extent = random.in_cube(15.0f / 32) + 17.0f / 32;
    s.rgb = random.in_cube(127.5f) + 127.5f;
    s.error = random.unit();
    s.law = AreaLaw(random.below(3));
    return s;
}
float largest_of(const TensorShape& s) {
    float largest = 0;
    for (const float v : s.root) largest = std::max(largest, std::abs(v));
    return largest;
}
bool finite(glm::vec3 v) {
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}
bool finite(const TensorShape& s) {
    for (const float v : s.root) {
        if (!std::isfinite(v)) return false;
    }
    return finite(s.facing) && finite(s.tone) && finite(s.center) && finite(s.extent) && finite(s.rgb) &&
           std::isfinite(s.error);
}

}  // namespace

TEST_CASE("what a packed tensor keeps is off by half a step", "[approximation]") {
    static_assert(sizeof(StoredTensor) == 16);
    Random random(71);
    for (int i = 0; i < 20000; ++i) {
        const TensorShape s = random_shape(random);
        const StoredTensor packed = StoredTensor::packed(s);
        const TensorShape t = packed.unpacked();
        const float largest = largest_of(s);
        bool root = true, vectors = true, places = true, colors = true;
        for (std::size_t k = 0; k < 6; ++k) {
            root &= std::abs(t.root[k] - s.root[k]) <= 1.0001f / 62 * largest * (1 + largest_scale_error);
        }
        for (int axis = 0; axis < 3; ++axis) {
            // Facings and tones may be larger than the root's entries; what exceeds the scale is cut off.
            for (const auto& [is, was] : {std::pair(t.facing[axis], s.facing[axis]), {t.tone[axis], s.tone[axis]}}) {
                const float kept = glm::clamp(was, -largest, largest);
                const float step = std::abs(was) <= largest ? 1.0f / 30 : 1.0f / 30 + largest_scale_error;
                vectors &= std::abs(is - kept) <= 1.0001f * largest * step * (1 + largest_scale_error);
            }
            // The last of 32 places is 31/32.
            const float at = std::min(s.center[axis], 63.0f / 64);
            places &= std::abs(t.center[axis] - at) <= 1.0f / 64 + 1e-6f;
            places &= std::abs(t.extent[axis] - s.extent[axis]) <= 1.0f / 32 + 1e-6f;
            colors &= std::abs(t.rgb[axis] - s.rgb[axis]) <= (axis == 1 ? 255.0f / 126 : 255.0f / 62) + 1e-4f;
        }
        CHECK(root);
        CHECK(vectors);
        CHECK(places);
        CHECK(colors);
        CHECK(t.law == s.law);
        CHECK(t.error >= s.error);  // an upper bound stays one
        CHECK(t.error <= s.error + (62 * std::sqrt(s.error) + 1) / (31 * 31) + 1e-6f);
        CHECK(packed.area_law() == t.law);
        CHECK(packed.error() == t.error);
        CHECK(packed.is_sound());
        CHECK_FALSE(packed == StoredTensor{});
    }
}

TEST_CASE("thin extents are kept as exactly as thick ones", "[approximation]") {
    Random random(72);
    for (int i = 0; i < 20000; ++i) {
        const glm::vec3 extent = glm::exp2(random.in_cube(3) - 3.0f);
        TensorShape s;
        s.extent = extent;
        const glm::vec3 kept = StoredTensor::packed(s).unpacked().extent;
        CHECK(kept == StoredTensor::rounded_extent(extent));
        for (int axis = 0; axis < 3; ++axis) {
            CHECK(std::abs(kept[axis] - extent[axis]) <= std::max(extent[axis] / 16, 0.5f / 64) + 1e-6f);
        }
    }
    // Whatever is thinner takes the least, and what had a code of its own in sixteenths has one still.
    CHECK(StoredTensor::rounded_extent({0, 1e-9f, 2}) == glm::vec3(1.0f / 64, 1.0f / 64, 1));
    for (int i = 1; i <= 16; ++i)
        CHECK(StoredTensor::rounded_extent(glm::vec3(float(i) / 16)) == glm::vec3(float(i) / 16));
}

TEST_CASE("areas of packed tensors are right in the mean", "[approximation]") {
    Random random(73);
    double sum = 0, squares = 0;
    const int count = 20000;
    for (int i = 0; i < count; ++i) {
        // A sheet: L of A^2 n n^T is one column.
        glm::vec3 n = random.direction();
        if (n.x < 0) n = -n;
        const float area = std::exp2(random.between(-18, 4));
        TensorShape s;
        s.extent = glm::vec3(1);
        s.root = {area * n.x, area * n.y, area * n.z, 0, 0, 0};
        const glm::vec3 w = random.direction();
        const double off =
            double(area_seen_from(StoredTensor::packed(s).unpacked(), w) - area_seen_from(s, w)) / double(area);
        sum += off;
        squares += off * off;
        CHECK(std::abs(off) < 0.06);
    }
    CHECK(std::abs(sum / count) < 0.0025);  // of a mean of half an area
    CHECK(std::sqrt(squares / count) < 0.016);
}

TEST_CASE("packed extremes stay finite", "[approximation]") {
    constexpr float infinity = std::numeric_limits<float>::infinity();
    constexpr float most = std::numeric_limits<float>::max(), least = std::numeric_limits<float>::denorm_min();
    TensorShape nothing;
    const TensorShape none = StoredTensor::packed(nothing).unpacked();
    CHECK(finite(none));
    CHECK(area_seen_from(none, {0, 0, 1}) == 0);
    for (const float v : {0.0f, least, 1e-30f, 1e-12f, 1.0f, 1e9f, 1e30f, most, infinity}) {
        for (const float sign : {1.0f, -1.0f}) {
            TensorShape s;
            s.root.fill(sign * v);
            s.facing = s.tone = s.center = s.extent = s.rgb = glm::vec3(sign * v);
            s.error = sign * v;
            const StoredTensor packed = StoredTensor::packed(s);
            const TensorShape t = packed.unpacked();
            INFO(sign * v);
            CHECK(packed.is_sound());
            CHECK(finite(t));
            CHECK(t.error >= 0);
            CHECK(t.error <= 1);
            for (int axis = 0; axis < 3; ++axis) {
                CHECK(t.center[axis] >= 0);
                CHECK(t.center[axis] <= 1);
                CHECK(t.extent[axis] > 0);
                CHECK(t.extent[axis] <= 1);
                CHECK(t.rgb[axis] >= 0);
                CHECK(t.rgb[axis] <= 255);
            }
            CHECK(std::isfinite(area_seen_from(t, glm::vec3(std::sqrt(1.0f / 3)))));
        }
    }
}

TEST_CASE("a law that is none is not sound", "[approximation]") {
    for (std::uint64_t law = 0; law < 4; ++law) {
        CHECK((StoredTensor{0, law << 54}).is_sound() == (law != 3));
        CHECK((StoredTensor{~0ull, ~0ull ^ (3ull ^ law) << 54}).is_sound() == (law != 3));
    }
    CHECK(StoredTensor{}.is_sound());
}

TEST_CASE("any bits unpack to numbers", "[approximation]") {
    Random random(74);
    for (int i = 0; i < 5000; ++i) {
        CHECK(finite((StoredTensor{random.bits(), random.bits()}).unpacked()));
    }
    CHECK(finite((StoredTensor{0, 0}).unpacked()));
    CHECK(finite((StoredTensor{~0ull, ~0ull}).unpacked()));
}

TEST_CASE("a sheet's normal is known, and of what is none there is none", "[approximation]") {
    Random random(75);
    for (int i = 0; i < 2000; ++i) {
        glm::vec3 n = random.direction();
        if (i % 3 > 0) n.x = 0;
        if (i % 3 > 1) n.y = 0;
        n = glm::normalize(n);
        TensorShape s;
        s.extent = glm::vec3(1);
        s.root = {n.x, n.y, n.z, 0, 0, 0};
        if (n.x == 0) s.root = {0, 0, 0, n.y, n.z, 0};
        if (n.x == 0 && n.y == 0) s.root = {0, 0, 0, 0, 0, n.z};
        const glm::vec3 found = sheet_normal(StoredTensor::packed(s).unpacked());
        REQUIRE(glm::length(found) > 0);
        CHECK(std::abs(glm::dot(glm::normalize(found), n)) > 0.999f);
    }
    TensorShape isotropic;
    isotropic.root = {1, 0, 0, 1, 0, 1};
    CHECK(sheet_normal(isotropic) == glm::vec3(0));
    CHECK(sheet_normal(TensorShape{}) == glm::vec3(0));
}
