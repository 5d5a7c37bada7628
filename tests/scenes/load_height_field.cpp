#include "files.hpp"

using namespace farfield;
using namespace farfield::scenes;
using namespace farfield::scenes::test;

namespace {

Scene read(const std::string& content) {
    const TemporaryDirectory directory;
    return load(directory.write("test.csv", content), unlit());
}

std::string failure(const std::string& content) {
    const TemporaryDirectory directory;
    return outcome(directory.write("test.csv", content));
}

bool contains(const std::string& text, const std::string& part) {
    return text.find(part) != std::string::npos;
}

}  // namespace

TEST_CASE("height field: a table, whatever separates its numbers", "[scenes][load]") {
    for (const char* content : {"0,1,2\n3,4,5\n", "0;1;2;\r\n3;4;5;\r\n", "0 1 2\n3 4 5",
                                "\xef\xbb\xbf# m\n0\t1\t2\n\n3\t4\t5\n", "\"0\", \"1\", \"2\"\n3,4,5\n"}) {
        CAPTURE(content);
        const Scene scene = read(content);
        REQUIRE(triangle_count(scene) == 4);
        CHECK(bounds(scene) == Box{{0, 0, 0}, {2, 5, 1}});
        for (const VertexColoredTriangle& t : scene.groups[0].triangles) {
            CHECK(glm::cross(t.vertices[1] - t.vertices[0], t.vertices[2] - t.vertices[0]).y > 0.0f);  // up
        }
    }
}

TEST_CASE("height field: holes are left out", "[scenes][load]") {
    CHECK(triangle_count(read("0,0,0\n0,,0\n0,0,0\n")) == 2);
    CHECK(triangle_count(read("0,0,0\n0,NA,0\n0,0,nan\n")) == 1);
}

TEST_CASE("height field: points on a grid, by the names of their columns", "[scenes][load]") {
    const Scene scene =
        read("id;Height;X;Y\n1;7;500000;4649000\n2;8;500002;4649000\n3;9;500000;4649003\n4;10;500002;4649003\n");
    REQUIRE(triangle_count(scene) == 2);
    CHECK(scene.origin == glm::dvec3(500'000, 0, -4'649'000));
    CHECK(bounds(scene) == Box{{0, 7, -3}, {2, 10, 0}});  // north is away
    CHECK(triangle_count(read("x,y,z\n0,0,1\n1,0,1\n2,0,1\n0,1,1\n2,1,1\n0,2,1\n1,2,1\n2,2,1\n")) == 2);  // one missing
    CHECK(contains(failure("x,y,z\n0,0,1\n1,2,1\n3,5,1\n4,7,1\n8,9,2\n"), "lie on no grid"));
}

TEST_CASE("height field: what is wrong is said, with its line", "[scenes][load]") {
    CHECK(contains(failure(""), "is empty"));
    CHECK(contains(failure("1,2,3\n4,5\n"), "line 2: 2 values where the lines before have 3"));
    CHECK(contains(failure("1,2\n4,x\n"), "line 2: 'x' where a height should be"));
    CHECK(contains(failure("name,age\nA,1\n"), "line 1: 'name' is neither a height nor the name of a column"));
    CHECK(contains(failure("x,y,z\n1,2\n"), "line 2: too few values"));
    CHECK(contains(failure("1,2\n3,inf\n"), "is not finite"));
    CHECK(contains(failure("1,2,3\n"), "no triangles"));
}
