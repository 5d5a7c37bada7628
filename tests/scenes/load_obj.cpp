#include "files.hpp"

using namespace farfield;
using namespace farfield::scenes;
using namespace farfield::scenes::test;

namespace {

std::vector<VertexColoredTriangle> read(const std::string& content, const std::string& library = {}) {
    const TemporaryDirectory directory;
    if (!library.empty()) directory.write("a.mtl", library);
    return load(directory.write("test.obj", content), unlit()).groups[0].triangles;
}

std::string failure(const std::string& content, const std::string& library = {}) {
    const TemporaryDirectory directory;
    if (!library.empty()) directory.write("a.mtl", library);
    return outcome(directory.write("test.obj", content));
}

bool contains(const std::string& text, const std::string& part) {
    return text.find(part) != std::string::npos;
}

const std::string square = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";
constexpr Rgba8 white{255, 255, 255}, gray{204, 204, 204}, red{255, 0, 0};

/// One texel, uncompressed.
std::string tga(unsigned char r, unsigned char g, unsigned char b) {
    const unsigned char bytes[] = {0, 0, 2, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 1, 0, 24, 0, b, g, r};
    return {reinterpret_cast<const char*>(bytes), sizeof bytes};
}

}  // namespace

TEST_CASE("OBJ: comments anywhere, lines continued, any ends of lines", "[scenes][load]") {
    CHECK(read("# C:\\models\\\n" + square + "f 1 2 3 4 # a comment 5 6\n").size() == 2);
    CHECK(read(square + "f 1 2 3 4#5 6\n").size() == 2);
    CHECK(read(square + "f 1 2 \\\n3 \\\r\n 4\n").size() == 2);
    CHECK(read(square + "f 1 2 3 # not continued \\\nf 1 3 4").size() == 2);
    CHECK(read("v 0 0 0\r\nv 1 0 0\r\nv 1 1 0\r\nf 1 2 3\r\n").size() == 1);
    CHECK(read("v 0 0 0\rv 1 0 0\rv 1 1 0\rf 1 2 3\r").size() == 1);
    CHECK(read("  v 0 0 0\n\tv 1 0 0\nv\t1 1 0\n f 1 2 3 \\").size() == 1);
}

TEST_CASE("OBJ: indices from the front, from the back, and of what comes later", "[scenes][load]") {
    const auto triangles = read("f 1 2 3\n" + square + "vt 0 0\nvn 0 0 1\nf -4/1/1 -2/-1 -1//1\n");
    REQUIRE(triangles.size() == 2);
    CHECK(triangles[0].vertices[2] == glm::vec3(1, 1, 0));
    CHECK(triangles[1].vertices[1] == glm::vec3(1, 1, 0));
    CHECK(triangles[1].vertices[2] == glm::vec3(0, 1, 0));
}

TEST_CASE("OBJ: concave faces", "[scenes][load]") {
    const std::string u = "v 0 0 0\nv 3 0 0\nv 3 3 0\nv 2 3 0\nv 2 1 0\nv 1 1 0\nv 1 3 0\nv 0 3 0\n";
    const auto triangles = read(u + "f 3 4 5 6 7 8 1 2\n");
    REQUIRE(triangles.size() == 6);
    float area = 0.0f;
    for (const auto& t : triangles) {
        const glm::vec3 cross = glm::cross(t.vertices[1] - t.vertices[0], t.vertices[2] - t.vertices[0]);
        CHECK(cross.z > 0.0f);
        area += 0.5f * cross.z;
    }
    CHECK(area == 7.0f);
}

TEST_CASE("OBJ: a file that says nothing about colors has the one of all such files", "[scenes][load]") {
    CHECK(read(square + "f 1 2 3\n")[0].rgba[0] == gray);
    // A library that is not there, a material that is in none.
    CHECK(read("mtllib none.mtl\nusemtl a\n" + square + "f 1 2 3\n")[0].rgba[0] == gray);
    CHECK(read("mtllib a.mtl\nusemtl b\n" + square + "f 1 2 3\n", "newmtl a\nKd 1 0 0\n")[0].rgba[0] == gray);
    const TemporaryDirectory directory;
    const Scene scene = load(directory.write("a.obj", "mtllib none.mtl\nusemtl b c\n" + square + "f 1 2 3\n"));
    CHECK(scene.notes == std::vector<std::string>{"material library 'none.mtl' cannot be read",
                                                  "material 'b c' is in no material library"});
}

TEST_CASE("OBJ: a material has the color that its library says, full where it says none", "[scenes][load]") {
    const auto color = [](const std::string& library) {
        return read("mtllib a.mtl\nusemtl a\n" + square + "f 1 2 3\n", library)[0].rgba[0];
    };
    CHECK(color("newmtl a\nKa 0 0 0\n") == white);
    CHECK(color("newmtl a\nKd 1 0 0\n") == red);
    CHECK(color("newmtl a\nKd 0.2\n") == Rgba8{51, 51, 51});
    CHECK(color("newmtl b\nKd 0 0 1\n\n# x\nnewmtl a # the one\n\tKd 1 0 0 # red\n") == red);
    CHECK(color("newmtl a\r\nKd 1 0 0\r\n") == red);
    CHECK(color("newmtl a\nKd 1 0 0\nnewmtl a\nKd 0 1 0\n") == red);  // the first of a name
    CHECK(color("newmtl a\nmap_Kd none.png\n") == white);
    CHECK(color("newmtl a\nKd 1 0 0\nmap_Kd none.png\n") == red);
}

TEST_CASE("OBJ: names with spaces, several libraries, in a line or in several", "[scenes][load]") {
    const TemporaryDirectory directory;
    directory.write("my first.mtl", "newmtl bright red\nKd 1 0 0\n");
    directory.write("b.mtl", "newmtl no#2\nKd 0 1 0\n");
    directory.write("c.mtl", "newmtl blue\nKd 0 0 1\n");
    const std::string faces =
        square + "usemtl bright red\nf 1 2 3\nusemtl no#2\nf 1 2 3\nusemtl blue \nf 1 2 3\nusemtl\nf 1 2 3\n";
    for (const char* libraries : {"mtllib my first.mtl b.mtl none.mtl c.mtl\n", "mtllib b.mtl c.mtl my first.mtl\n",
                                  "mtllib my first.mtl\nmtllib .\\b.mtl\nmtllib C:\\there\\c.mtl\n",
                                  "mtllib \"my first.mtl\"\nmtllib b.mtl\nmtllib c.mtl\n"}) {
        CAPTURE(libraries);
        const auto triangles = load(directory.write("a.obj", libraries + faces), unlit()).groups[0].triangles;
        REQUIRE(triangles.size() == 4);
        CHECK(triangles[0].rgba[0] == red);
        CHECK(triangles[1].rgba[0] == Rgba8{0, 255, 0});
        CHECK(triangles[2].rgba[0] == Rgba8{0, 0, 255});
        CHECK(triangles[3].rgba[0] == gray);
    }
}

TEST_CASE("OBJ: a texture times the material's color, with the options before its name", "[scenes][load]") {
    const TemporaryDirectory directory;
    directory.write("a tex.tga", tga(200, 100, 50));
    const auto color = [&](const std::string& material) {
        directory.write("a.mtl", "newmtl a\n" + material);
        const auto file =
            directory.write("a.obj", "mtllib a.mtl\nusemtl a\n" + square + "vt 0.9 0.5\nf 1/1 2/1 3/1\nf 1 2 3\n");
        const auto triangles = load(file, unlit()).groups[0].triangles;
        return std::pair{triangles[0].rgba[1], triangles[1].rgba[1]};
    };
    CHECK(color("map_Kd a tex.tga\n") == std::pair{Rgba8{200, 100, 50}, white});
    CHECK(color("Kd 0.5 1 0\nmap_Kd a tex.tga\n") == std::pair{Rgba8{100, 100, 0}, Rgba8{128, 255, 0}});
    CHECK(color("map_Kd -blendu off -s 2 2 2 -o 0.5 -bm 1 -clamp on a tex.tga\n").first == Rgba8{200, 100, 50});
    CHECK(color("map_Kd -mm 0.2 0.5 a tex.tga\n").first == Rgba8{151, 101, 76});
    CHECK(color("map_Kd \"C:\\my\\a tex.tga\"\n").first == Rgba8{200, 100, 50});
}

TEST_CASE("OBJ: colors of vertices, of some, as fractions or bytes", "[scenes][load]") {
    const auto all = read("v 0 0 0 1 0 0\nv 1 0 0 0 1 0\nv 0 1 0 0 0.2 1 0.5\nf 1 2 3\n");
    CHECK(all[0].rgba == std::array{red, Rgba8{0, 255, 0}, Rgba8{0, 51, 255}});
    const auto bytes = read("v 0 0 0 255 0 0\nv 1 0 0 0 51 1\nv 0 1 0 0 0 0\nf 1 2 3\n");
    CHECK(bytes[0].rgba == std::array{red, Rgba8{0, 51, 1}, Rgba8{0, 0, 0}});
    const auto some = read("v 0 0 0\nv 1 0 0 1 0 0\nv 0 1 0\nv 1 1 1\nf 1 2 3\nf 1 2 4\n");
    CHECK(some[0].rgba == std::array{gray, red, gray});
    CHECK(some[1].rgba == std::array{gray, red, gray});
    const auto with_material =
        read("mtllib a.mtl\nusemtl a\nv 0 0 0\nv 1 0 0 1 0.2 1\nv 0 1 0\nf 1 2 3\n", "newmtl a\nKd 1 1 0.5\n");
    CHECK(with_material[0].rgba == std::array{Rgba8{255, 255, 128}, Rgba8{255, 51, 128}, Rgba8{255, 255, 128}});
    CHECK(read("v 0 0 0 1\nv 1 0 0 1\nv 0 1 0 2\nf 1 2 3\n")[0].vertices[2] == glm::vec3(0, 1, 0));  // weights
}

TEST_CASE("OBJ: points, lines, normals and what else there may be are passed over", "[scenes][load]") {
    CHECK(read("o x\ng a b\ns off\n" + square + "vn 0 0 1\nvp 1 2\np 1\nl 1 2\nf 1 2\nlod 1\nf 1 2 3\nbevel on\nend\n")
              .size() == 1);
}

TEST_CASE("OBJ: what is wrong is said, with its line", "[scenes][load]") {
    CHECK(contains(failure(""), "is empty"));
    CHECK(contains(failure(square), "no triangles"));
    CHECK(contains(failure(square + "f 1 2 5\n"), "line 5: a face names vertex 5 of 4"));
    CHECK(contains(failure(square + "f 1 2 0\n"), "line 5: a face names vertex 0 of 4"));
    CHECK(contains(failure(square + "f 1 2 -5\n"), "line 5: a face names vertex -5 of 4"));
    CHECK(contains(failure(square + "f 1 2 99999999999999\n"), "line 5: a face names vertex 99999999999999 of 4"));
    CHECK(contains(failure(square + "f 1/1 2 3\n"), "line 5: a face names texture coordinate 1 of 0"));
    CHECK(contains(failure(square + "f 1 2 x\n"), "line 5: 'x' where the number of a vertex should be"));
    CHECK(contains(failure("v 0 0\n"), "line 1: a vertex of 2 numbers"));
    CHECK(contains(failure("v 0 0 0 1 0\n"), "line 1: a vertex of 5 numbers"));
    CHECK(contains(failure("v 0 0 1.#IND\n"), "line 1: '1.#IND' in a vertex"));
    CHECK(contains(failure("v 0 0 1,5\n"), "line 1: '1,5' in a vertex"));
    CHECK(contains(failure("v 0 0 0\nv 0 inf 0\n"), "line 2: vertex 1 is not finite"));
    CHECK(contains(failure("v 0 0 0\nv 0 -1e999 0\n"), "line 2: vertex 1 is not finite"));
    CHECK(contains(failure("surf 0 1 0 1 1 2 3\n"), "line 1: 'surf' is not read"));
    CHECK(contains(failure("mtllib a.mtl\n" + square + "f 1 2 3\n", "newmtl a\nKd spectral x.rfl\n"),
                   "a.mtl: line 2: a Kd that is not three numbers"));
    CHECK(contains(failure("mtllib a.mtl\n" + square + "f 1 2 3\n", "newmtl a\nmap_Kd -foo 1 x.png\n"),
                   "a.mtl: line 2: option '-foo'"));
}

TEST_CASE("OBJ: polygons, negative indices, material and vertex colors", "[scenes][load]") {
    const TemporaryDirectory directory;
    directory.write("test.mtl", "newmtl red\nKd 1 0 0\n");
    const auto with_material =
        load(directory.write("a.OBJ", "mtllib test.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nusemtl red\nf 1 2 3 4\n"),
             unlit());
    REQUIRE(triangle_count(with_material) == 2);
    CHECK(with_material.groups[0].triangles[0].rgba[0] == Rgba8{255, 0, 0});
    CHECK(with_material.name == "a");
    const auto with_colors =
        load(directory.write("b.obj", "v 0 0 0 0 1 0\nv 1 0 0 0 1 0\nv 1 1 0 0 1 0\nf -3 -2 -1\n"), unlit());
    CHECK(triangle_count(with_colors) == 1);
    CHECK(with_colors.groups[0].triangles[0].rgba[0].r == 0);
    CHECK(with_colors.groups[0].triangles[0].rgba[0].g > 100);
}

TEST_CASE("OBJ: a texture beside the file colors the corners", "[scenes][load]") {
    const TemporaryDirectory directory;
    // 2 x 2 uncompressed TGA, rows from below: blue, green; red, white.
    const unsigned char tga[] = {0, 0,  2, 0,   0, 0, 0, 0,   0, 0, 0, 0,   2,   0,   2,
                                 0, 24, 0, 255, 0, 0, 0, 255, 0, 0, 0, 255, 255, 255, 255};
    directory.write("four.tga", {reinterpret_cast<const char*>(tga), sizeof tga});
    directory.write("test.mtl", "newmtl four\nKd 1 1 1\nmap_Kd four.tga\n");
    const std::string obj =
        "mtllib test.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0.1 0.1\nvt 0.9 0.1\nvt 0.1 0.9\nusemtl four\nf 1/1 2/2 3/3\n";
    const auto triangles = load(directory.write("test.obj", obj), unlit()).groups[0].triangles;
    REQUIRE(triangles.size() == 1);
    CHECK(triangles[0].rgba[0] == Rgba8{0, 0, 255});
    CHECK(triangles[0].rgba[1] == Rgba8{0, 255, 0});
    CHECK(triangles[0].rgba[2] == Rgba8{255, 0, 0});
    directory.write("four.tga", "not an image");
    const auto plain = load(directory.path() / "test.obj", unlit()).groups[0].triangles;
    CHECK(plain[0].rgba[0] == Rgba8{255, 255, 255});
}
