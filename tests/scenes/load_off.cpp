#include <array>
#include <bit>
#include <variant>

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

TEST_CASE("OFF: concave polygons", "[scenes][load]") {
    const auto triangles =
        read("OFF\n8 1 0\n0 0 0\n3 0 0\n3 3 0\n2 3 0\n2 1 0\n1 1 0\n1 3 0\n0 3 0\n8 2 3 4 5 6 7 0 1\n");
    REQUIRE(triangles.size() == 6);
    float area = 0.0f;
    for (const auto& t : triangles) {
        const float z = glm::cross(t.vertices[1] - t.vertices[0], t.vertices[2] - t.vertices[0]).z;
        CHECK(z > 0.0f);
        area += 0.5f * z;
    }
    CHECK(area == 7.0f);
}

TEST_CASE("OFF: binary, as the manual has it and as others write it", "[scenes][load]") {
    const auto file = [](const std::string& keyword, bool big, const std::vector<std::variant<int, float>>& values) {
        std::string bytes = keyword + " BINARY\n";
        for (const auto& value : values) {
            const auto bits = std::holds_alternative<int>(value) ? static_cast<std::uint32_t>(std::get<int>(value))
                                                                 : std::bit_cast<std::uint32_t>(std::get<float>(value));
            for (int i = 0; i < 4; ++i) bytes.push_back(static_cast<char>(bits >> (big ? 24 - 8 * i : 8 * i) & 255));
        }
        return bytes;
    };
    const std::vector<std::variant<int, float>> four_corners{4,   2,   0,   0.f, 0.f, 0.f, 1.f, 0.f,
                                                             0.f, 1.f, 1.f, 0.f, 0.f, 1.f, 0.5f};
    const auto with = [&](std::vector<std::variant<int, float>> faces) {
        faces.insert(faces.begin(), four_corners.begin(), four_corners.end());
        return faces;
    };
    for (const bool big : {true, false}) {
        const auto counted = read(file("OFF", big, with({3, 0, 1, 2, 0, 3, 0, 2, 3, 3, 1.f, 0.f, 0.2f})));
        REQUIRE(counted.size() == 2);
        CHECK(counted[1].vertices[2] == glm::vec3(0, 1, 0.5f));
        CHECK(counted[0].rgba[0] == Rgba8{204, 204, 204});
        CHECK(counted[1].rgba[0] == Rgba8{255, 0, 51});
        CHECK(read(file("OFF", big, with({3, 0, 1, 2, 3, 0, 2, 3}))).size() == 2);
        const auto bytes = read(file("OFF", big, with({3, 0, 1, 2, 255, 0, 0, 3, 0, 2, 3, 0, 51, 0})));
        CHECK(bytes[1].rgba[0] == Rgba8{0, 51, 0});
        for (const int channels : {3, 4}) {
            std::vector<std::variant<int, float>> colored{3, 1, 0};
            for (int v = 0; v < 3; ++v) {
                for (const float c : {v == 1 ? 1.f : 0.f, v == 2 ? 1.f : 0.f, 0.f}) colored.push_back(c);
                for (int c = 0; c < channels; ++c) colored.push_back(c == v ? 1.f : 0.f);
            }
            for (const int i : {3, 0, 1, 2}) colored.push_back(i);
            const auto triangle = read(file("COFF", big, colored));
            REQUIRE(triangle.size() == 1);
            CHECK(triangle[0].rgba == std::array{Rgba8{255, 0, 0}, Rgba8{0, 255, 0}, Rgba8{0, 0, 255}});
        }
    }
    CHECK(contains(failure(file("OFF", true, with({3, 0, 1, 4, 0, 3, 0, 2, 3, 0}))), "is binary"));
    CHECK(contains(failure(file("OFF", true, with({3, 0, 1}))), "is binary"));
    CHECK(contains(failure(file("OFF", true, {-1, -1, 0})), "is binary"));
    CHECK(contains(failure(file("nOFF", true, with({}))), "binary nOFF is not read"));
}

TEST_CASE("OOGL: braces, appearances, lists, references and definitions", "[scenes][load]") {
    const std::string triangle = "OFF 3 1 0 0 0 0 1 0 0 0 1 0 3 0 1 2 ";
    CHECK(read("{" + triangle + "}").size() == 1);
    CHECK(read("{ = " + triangle + "}").size() == 1);
    const auto orange = read("appearance { +edge material { ka 1 diffuse 1 0.6 0 } }\n{" + triangle + "}");
    CHECK(orange[0].rgba[0] == Rgba8{255, 153, 0});
    const auto list =
        read("LIST\n{ appearance { material { diffuse 1 0 0 } } " + triangle + "}\n{ LIST {" + triangle + "} { }}\n");
    REQUIRE(list.size() == 2);
    CHECK(list[0].rgba[0] == Rgba8{255, 0, 0});
    CHECK(list[1].rgba[0] == Rgba8{204, 204, 204});
    CHECK(read("{ LIST { define t " + triangle + "} { : t } {:t} }").size() == 3);
    CHECK(contains(failure("{ : t }"), "nothing is defined as 't'"));
    CHECK(contains(failure("{ LIST {" + triangle + "} { BEZ 1 2 } }"), "'BEZ'"));
    CHECK(contains(failure("{" + triangle), "ends where '}'"));
    CHECK(contains(failure("{ VECT 1 2 1 2 1 0 0 0 1 1 1 1 1 1 1 }"), "no triangles"));
    const TemporaryDirectory directory;
    directory.write("a part.off", triangle);
    directory.write("self.oogl", "LIST {" + triangle + "} { < self.oogl }");
    CHECK(triangle_count(load(directory.write("b.oogl", "LIST { < \"a part.off\" } { <\"a part.off\" }"))) == 2);
    CHECK(contains(outcome(directory.path() / "self.oogl"), "refers to itself"));
    CHECK(contains(outcome(directory.write("c.oogl", "{ < none.off }")), "'none.off': no such file"));
    const Scene scene =
        load(directory.write("d.oogl", "LIST {" + triangle + "} { VECT 1 2 1 2 1 0 0 0 1 1 1 1 1 1 1 }"));
    CHECK(scene.notes == std::vector<std::string>{"VECT is not drawn, only surfaces are"});
    CHECK(contains(failure(std::string(1000, '{')), "nested deeper than 64"));
    // Three hundred times three hundred times three hundred: refused before it is tried.
    std::string transforms = "TLIST";
    for (int i = 0; i < 300; ++i) transforms += " 1 0 0 0 0 1 0 0 0 0 1 0 0 0 " + std::to_string(i) + " 1";
    const std::string often = "LIST { define a INST transforms { " + transforms + " } geom {" + triangle +
                              "} } { define b INST transforms { " + transforms + " } geom : a } { INST transforms { " +
                              transforms + " } geom : b }";
    CHECK(contains(failure(often), "more than 10,000,000 triangles"));
}

TEST_CASE("OOGL: instances", "[scenes][load]") {
    const std::string triangle = "{ OFF 3 1 0 0 0 0 1 0 0 0 1 0 3 0 1 2 }";
    const auto one = read("INST geom " + triangle + " transform 2 0 0 0  0 2 0 0  0 0 2 0  5 6 7 1");
    REQUIRE(one.size() == 1);
    CHECK(one[0].vertices[1] == glm::vec3(7, 6, 7));
    const auto two =
        read("{ INST transforms { TLIST 1 0 0 0 0 1 0 0 0 0 1 0 5 5 5 1\n-1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1 } geom " +
             triangle + " }");
    REQUIRE(two.size() == 2);
    CHECK(two[0].vertices[0] == glm::vec3(5, 5, 5));
    // Mirrored, and turned round so that its front stays its front.
    CHECK(glm::cross(two[1].vertices[1] - two[1].vertices[0], two[1].vertices[2] - two[1].vertices[0]).z > 0.0f);
    CHECK(bounds(load(TemporaryDirectory().write("a.off", "LIST " + triangle))).upper == glm::vec3(1, 1, 0));
    CHECK(contains(failure("INST transform 1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1"), "an INST has no geom"));
    CHECK(contains(failure("INST geom " + triangle + " transform 1 0 0 x"), "'x' where a number of a transformation"));
}

TEST_CASE("OOGL: quadrilaterals and meshes", "[scenes][load]") {
    const auto quads = read("CQUAD\n0 0 0 1 0 0 1\n1 0 0 0 1 0 1\n1 1 0 0 0 1 1\n0 1 0 1 1 1 1\n");
    REQUIRE(quads.size() == 2);
    CHECK(quads[0].rgba[1] == Rgba8{0, 255, 0});
    CHECK(quads[1].vertices[2] == glm::vec3(0, 1, 0));
    const auto mesh = read("ZMESH 3 2  0 0 0  1 1 1");
    REQUIRE(mesh.size() == 4);
    CHECK(mesh[3].vertices[1] == glm::vec3(2, 1, 1));
    CHECK(read("uvMESH 3 3 0 0 0 1 0 0 2 0 0 0 1 0 1 1 0 2 1 0 0 2 0 1 2 0 2 2 0").size() == 18);
    CHECK(contains(failure("MESH 100000 100000 0 0 0"), "claims"));
    CHECK(contains(failure("MESH 0 0"), "no triangles"));
}

TEST_CASE("OFF: what is wrong is said, with its line", "[scenes][load]") {
    CHECK(contains(failure(""), "empty"));
    CHECK(contains(failure("PLY\n"), "line 1"));
    CHECK(contains(failure("OFF BINARY\n"), "is binary, and its counts fit neither"));
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
