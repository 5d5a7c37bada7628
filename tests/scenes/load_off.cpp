#include "files.hpp"

using namespace farfield;
using namespace farfield::scenes;
using namespace farfield::scenes::test;

namespace {

std::vector<VertexColoredTriangle> read(const std::string& content) {
    const TemporaryDirectory directory;
    return load(directory.write("test.off", content), unlit()).groups[0].triangles;
}

std::string failure(const std::string& content) {
    const TemporaryDirectory directory;
    return outcome(directory.write("test.off", content));
}

bool contains(const std::string& text, const std::string& part) {
    return text.find(part) != std::string::npos;
}

const std::string square = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n";

}  // namespace

TEST_CASE("OFF: polygons become fans", "[scenes][load]") {
    const auto triangles = read("OFF\n4 1 0\n" + square + "4 0 1 2 3\n");
    REQUIRE(triangles.size() == 2);
    CHECK(triangles[0].vertices[2] == glm::vec3(1, 1, 0));
    CHECK(triangles[1].vertices[0] == glm::vec3(0, 0, 0));
    CHECK(triangles[1].vertices[2] == glm::vec3(0, 1, 0));
}

TEST_CASE("OFF: comments, blank lines, one line for all, no keyword, no edge count", "[scenes][load]") {
    CHECK(read("# first\n\nOFF # key\n\n4 1 0 # counts\n" + square + "# faces\n4 0 1 2 3 # end").size() == 2);
    CHECK(read("OFF 4 1 0 0 0 0 1 0 0 1 1 0 0 1 0 4 0 1 2 3").size() == 2);
    CHECK(read("4 1 0\n" + square + "4 0 1 2 3\n").size() == 2);
    CHECK(read("OFF\n4 1\n" + square + "4 0 1 2 3\n").size() == 2);
    CHECK(read("OFF4 1 0\n" + square + "4 0 1 2 3\n").size() == 2);
    CHECK(read("OFF\r\n3 1 0\r\n0 0 0\r\n1 0 0\r\n1 1 0\r\n3 0 1 2\r\n").size() == 1);
}

TEST_CASE("OFF: points and lines are not drawn", "[scenes][load]") {
    CHECK(read("OFF\n4 3 0\n" + square + "1 0\n2 0 1\n3 0 1 2\n").size() == 1);
}

TEST_CASE("OFF: face colors as bytes, as fractions, as indices", "[scenes][load]") {
    const auto bytes = read("OFF\n4 2 0\n" + square + "3 0 1 2 255 0 0\n3 0 2 3 1 0 0\n");
    CHECK(bytes[0].rgba[0] == Rgba8{255, 0, 0});
    CHECK(bytes[1].rgba[2] == Rgba8{1, 0, 0});
    const auto fractions = read("OFF\n4 2 0\n" + square + "3 0 1 2 1 0 0 0.5\n3 0 2 3 0 0.2 1 1\n");
    CHECK(fractions[0].rgba[0] == Rgba8{255, 0, 0});
    CHECK(fractions[1].rgba[0] == Rgba8{0, 51, 255});
    const auto indices = read("OFF\n4 2 0\n" + square + "3 0 1 2 7\n3 0 2 3 8\n");
    CHECK_FALSE(indices[0].rgba[0] == indices[1].rgba[0]);
}

TEST_CASE("OFF: vertex colors, normals, texture coordinates, homogeneous and many dimensions", "[scenes][load]") {
    const auto colored = read("COFF\n3 1 0\n0 0 0 255 0 0 255\n1 0 0 0 255 0 255\n0 1 0 0 0 255 255\n3 0 1 2\n");
    CHECK(colored[0].rgba[0] == Rgba8{255, 0, 0});
    CHECK(colored[0].rgba[2] == Rgba8{0, 0, 255});
    const auto all =
        read("STCNOFF\n3 1 0\n0 0 0 0 0 1 1 0 0 .5 .5\n1 0 0 0 0 1 0 1 0 .5 .5\n0 1 0 0 0 1 0 0 1 .5 .5\n3 0 1 2\n");
    CHECK(all[0].rgba[1] == Rgba8{0, 255, 0});
    CHECK(all[0].vertices[1] == glm::vec3(1, 0, 0));
    const auto homogeneous = read("4OFF\n3 1 0\n0 0 0 2\n2 0 0 2\n0 2 0 -2\n3 0 1 2\n");
    CHECK(homogeneous[0].vertices[1] == glm::vec3(1, 0, 0));
    CHECK(homogeneous[0].vertices[2] == glm::vec3(0, -1, 0));
    const auto many = read("nOFF 5\n3 1 0\n0 0 0 9 9\n1 0 0 9 9\n0 1 0 9 9\n3 0 1 2\n");
    CHECK(many[0].vertices[2] == glm::vec3(0, 1, 0));
}

TEST_CASE("OFF: what is wrong is said, with its line", "[scenes][load]") {
    CHECK(contains(failure(""), "empty"));
    CHECK(contains(failure("PLY\n"), "line 1"));
    CHECK(contains(failure("OFF BINARY\n"), "binary"));
    CHECK(contains(failure("OFF\n4 1 0\n" + square + "4 0 1 2 4\n"), "line 7: face 0 names vertex 4 of 4"));
    CHECK(contains(failure("OFF\n4 1 0\n" + square + "4 0 1 2 -1\n"), "line 7"));
    CHECK(contains(failure("OFF\n4 1 0\n" + square + "3 0 1 2 1 0\n"), "line 7: a color of 2 numbers"));
    CHECK(contains(failure("OFF\n3 1 0\n0 0 0\n1 0 nan\n0 1 0\n3 0 1 2\n"), "vertex 1 is not finite"));
    CHECK(contains(failure("OFF\n3 1 0\n0 0 0\n1 0 1e99\n0 1 0\n3 0 1 2\n"), "vertex 1 is too far away"));
    CHECK(contains(failure("OFF\n3 1 0\n0 0 0\n1 0 x\n0 1 0\n3 0 1 2\n"), "line 4: 'x'"));
    CHECK(contains(failure("4OFF\n1 0 0\n1 1 1 0\n"), "vertex 0 is not finite"));
    CHECK(contains(failure("OFF\n4 2 0\n" + square + "3 0 1 2\n"), "face 1 of 2"));
    CHECK(contains(failure("OFF\n4 0 0\n" + square), "no triangles"));
    CHECK(contains(failure("OFF\n0 0 0\n"), "no triangles"));
    // Eleven numbers under a keyword for three.
    CHECK(contains(failure("OFF\n4 0 0\n0 0 0 -1 0 0 255 0 0 0 0\n" + square), "line 3: 11 numbers"));
}

TEST_CASE("OFF: no count is believed before there is room for it", "[scenes][load]") {
    CHECK(contains(failure("OFF\n18446744073709551615 1 0\n" + square), "claims"));
    CHECK(contains(failure("OFF\n4 18446744073709551615 0\n" + square + "3 0 1 2\n"), "claims"));
    CHECK(contains(failure("OFF\n4 1 0\n" + square + "999999999999 0 1 2\n"), "claims"));
    CHECK(contains(failure("nOFF 18446744073709551615\n4 1 0\n" + square), "dimensions"));
}
