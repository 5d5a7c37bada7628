#include "files.hpp"

using namespace farfield;
using namespace farfield::scenes;
using namespace farfield::scenes::test;

namespace {

bool contains(const std::string& text, const std::string& part) {
    return text.find(part) != std::string::npos;
}

}  // namespace

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

TEST_CASE("OBJ: what is wrong is said", "[scenes][load]") {
    const TemporaryDirectory directory;
    const std::string three = "v 0 0 0\nv 1 0 0\nv 1 1 0\n";
    CHECK(contains(outcome(directory.write("a.obj", "")), "empty"));
    CHECK_FALSE(outcome(directory.write("b.obj", three)).empty());
    CHECK_FALSE(outcome(directory.write("c.obj", three + "f 1 2 4\n")).empty());
    CHECK_FALSE(outcome(directory.write("d.obj", three + "f 1 2 -4\n")).empty());
    CHECK(contains(outcome(directory.write("e.obj", "v 0 0 0\nv 1 nan 0\nv 1 1 0\nf 1 2 3\n")), "is not finite"));
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
