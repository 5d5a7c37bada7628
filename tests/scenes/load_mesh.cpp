// One scene near zero and far from it, in every format of meshes: the same floats, and the origin that was subtracted.
#include <bit>
#include <cstring>

#include "files.hpp"
#include "scenes/load/mesh.hpp"

using namespace farfield;
using namespace farfield::scenes;
using namespace farfield::scenes::test;

namespace {

/// Numbers that are sums in binary, too: all loss there is comes from reading.
constexpr double corners[4][3] = {{0, 0, 0}, {8.125, 0, 0.25}, {7.5, 6.0625, 0}, {0, 9, 0.5}};

std::string text(double value) {
    char buffer[64];
    std::snprintf(buffer, sizeof buffer, "%.17g", value);
    return buffer;
}

std::string rows(const glm::dvec3& away, const std::string& begin) {
    std::string result;
    for (const auto& c : corners) {
        result += begin + text(c[0] + away.x) + ' ' + text(c[1] + away.y) + ' ' + text(c[2] + away.z) + '\n';
    }
    return result;
}

std::string off(const glm::dvec3& away) {
    return "OFF\n4 1 0\n" + rows(away, "") + "4 0 1 2 3\n";
}
std::string obj(const glm::dvec3& away) {
    return rows(away, "v ") + "f 1 2 3 4\n";
}
std::string oogl(const glm::dvec3& away) {
    return "{ INST transform 1 0 0 0 0 1 0 0 0 0 1 0 " + text(away.x) + ' ' + text(away.y) + ' ' + text(away.z) +
           " 1 geom { " + off({0, 0, 0}) + " } }";
}
std::string ply(const glm::dvec3& away) {
    std::string bytes =
        "ply\nformat binary_little_endian 1.0\nelement vertex 4\nproperty double x\nproperty double y\nproperty double "
        "z\nelement face 1\nproperty list uchar uchar vertex_indices\nend_header\n";
    for (const auto& c : corners) {
        for (int i = 0; i < 3; ++i) {
            const auto bits = std::bit_cast<std::uint64_t>(c[i] + away[i]);
            for (int byte = 0; byte < 8; ++byte) bytes.push_back(static_cast<char>(bits >> (8 * byte) & 255));
        }
    }
    return bytes + std::string("\4\0\1\2\3", 5);
}

}  // namespace

TEST_CASE("what lies far from zero is read with all its details", "[scenes][load]") {
    const TemporaryDirectory directory;
    struct Format {
        const char* name;
        std::string (*content)(const glm::dvec3&);
    };
    const auto format = GENERATE(values<Format>({{"a.off", off}, {"a.obj", obj}, {"a.oogl", oogl}, {"a.ply", ply}}));
    CAPTURE(format.name);
    const Scene here = load(directory.write(format.name, format.content({0, 0, 0})));
    CHECK(here.origin == glm::dvec3(0.0));
    CHECK(here.groups[0].triangles[0].vertices[1] == glm::vec3(8.125, 0, 0.25));
    for (const glm::dvec3 away :
         {glm::dvec3(500'000, 4'649'000, 0), glm::dvec3(-5e6, 0, 1e9), glm::dvec3(0, 1e12, -1000)}) {
        const Scene there = load(directory.write(format.name, format.content(away)));
        CHECK(there.origin == away);
        REQUIRE(triangle_count(there) == 2);
        for (std::size_t t = 0; t < 2; ++t) {
            CHECK(there.groups[0].triangles[t].vertices == here.groups[0].triangles[t].vertices);
            CHECK(there.groups[0].triangles[t].rgba == here.groups[0].triangles[t].rgba);
        }
    }
}

TEST_CASE("a vertex that no face names has no say in where the origin is", "[scenes][load]") {
    const TemporaryDirectory directory;
    const Scene scene =
        load(directory.write("a.obj", "v 0 0 0\nv 1000000.25 0 0\nv 1000000.5 0 0\nv 1000000.25 1 0\nf 2 3 4\n"));
    CHECK(scene.origin == glm::dvec3(1'000'000, 0, 0));
    CHECK(scene.groups[0].triangles[0].vertices[0] == glm::vec3(0.25f, 0, 0));
}

TEST_CASE("the origin is zero as long as single precision is fine enough there", "[scenes][load]") {
    using scenes::detail::origin_of;
    CHECK(origin_of({{-1, -1, -1}, {1, 1, 1}}) == glm::dvec3(0.0));
    CHECK(origin_of({{14, 0, 0}, {15, 1, 1}}) == glm::dvec3(0.0));
    CHECK(origin_of({{17, 0, 0}, {18, 1, 1}}) == glm::dvec3(17, 0, 0));
    CHECK(origin_of({{99, 0, -101}, {101, 1, -99}}) == glm::dvec3(100, 0, -100));
    CHECK(origin_of({{5e6, 5e6, 5e6}, {5e6, 5e6, 5e6}}) == glm::dvec3(0.0));  // a point
    CHECK(origin_of(BoxD::empty()) == glm::dvec3(0.0));
    // A step of 10 below the side on the others: finite whatever the numbers.
    const glm::dvec3 flat = origin_of({{1e300, 0, 0}, {1e300, 1e-30, 0}});
    CHECK(std::isfinite(flat.x));
    for (const double unit : {1e-30, 1e-20, 1e20, 1e29}) {
        const glm::dvec3 origin = origin_of({{100 * unit, 0, 0}, {101 * unit, unit, 0}});
        CHECK(origin.x == Approx(100 * unit));
        CHECK(origin.y == 0.0);
    }
}

TEST_CASE("atoms or points that are all at one place have an origin there, for they have an extent", "[scenes][load]") {
    using scenes::detail::origin_of_centers;
    CHECK(origin_of_centers({{5e6, 5e6, 5e6}, {5e6, 5e6, 5e6}}) == glm::dvec3(5e6));
    CHECK(origin_of_centers({{5, 5, 5}, {5, 5, 5}}) == glm::dvec3(0.0));
    CHECK(origin_of_centers({{99, 0, -101}, {101, 1, -99}}) == glm::dvec3(100, 0, -100));
    CHECK(origin_of_centers(BoxD::empty()) == glm::dvec3(0.0));
    const TemporaryDirectory directory;
    for (const char* point : {"1\nnone\nC 5000000.5 0 0\n", "2\nnone\nC 5000000.5 0 0\nC 5000000.5 0 0\n"}) {
        const Scene scene = load(directory.write("a.xyz", point));
        CHECK(scene.origin == glm::dvec3(5e6, 0, 0));
        CHECK(bounds(scene).size().x == Approx(bounds(scene).size().y).margin(0.1));
    }
    const Scene point = load(directory.write("a.pts", "1\n5000000.5 0 0\n"));
    CHECK(bounds(point).size().y > 1);
    CHECK(bounds(point).size().x == Approx(bounds(point).size().y).margin(1e-5));
}

TEST_CASE("the light on a face does not depend on the unit of the file", "[scenes][load]") {
    const TemporaryDirectory directory;
    const auto cube = [](const std::string& e) {
        return "OFF\n4 2 0\n0 0 0\n1" + e + " 0 0\n1" + e + " 1" + e + " 0\n0 1" + e + " 1" + e +
               "\n3 0 2 1\n3 0 2 3\n";
    };
    const auto one = load(directory.write("a.off", cube(""))).groups[0].triangles;
    CHECK_FALSE(one[0].rgba == one[1].rgba);
    for (const char* exponent : {"e-30", "e-19", "e-5", "e10", "e19", "e30"}) {
        CAPTURE(exponent);
        const auto other = load(directory.write("a.off", cube(exponent))).groups[0].triangles;
        REQUIRE(other.size() == 2);
        CHECK(other[0].rgba == one[0].rgba);
        CHECK(other[1].rgba == one[1].rgba);
    }
    const auto failure = [&](const std::string& e) { return outcome(directory.write("a.off", cube(e))); };
    CHECK(failure("e32").find("vertex 2 is too far away to be drawn: more than 2^100") != std::string::npos);
    CHECK(failure("e-33").find("is too small to be drawn") != std::string::npos);
}
