#include "files.hpp"

using namespace farfield;
using namespace farfield::scenes;
using namespace farfield::scenes::test;

namespace {

bool contains(const std::string& text, const std::string& part) {
    return text.find(part) != std::string::npos;
}

/// A triangle in a buffer of its own: three positions, three 16-bit indices, two bytes of padding.
const std::string triangle_buffer =
    "data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAAAAABAAIAAAA=";

struct Gltf {
    std::string nodes = R"([{"mesh":0}])";
    std::string roots = "[0]";
    std::string buffer = triangle_buffer;
    std::string buffer_bytes = "44";
    std::string vertex_count = "3";
    std::string index_accessor = "1";
    std::string material = R"({"pbrMetallicRoughness":{"baseColorFactor":[1,0,0,1]}})";
    std::string more{};

    std::string text() const {
        return R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":)" + roots + R"(}],"nodes":)" + nodes +
               R"(,"meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":)" + index_accessor +
               R"(,"material":0}]}],"materials":[)" + material + R"(],"buffers":[{"byteLength":)" + buffer_bytes +
               R"(,"uri":")" + buffer +
               R"("}],"bufferViews":[{"buffer":0,"byteLength":36},{"buffer":0,"byteOffset":36,"byteLength":6}],)" +
               R"("accessors":[{"bufferView":0,"componentType":5126,"count":)" + vertex_count +
               R"(,"type":"VEC3","min":[0,0,0],"max":[1,1,0]},)" +
               R"({"bufferView":1,"componentType":5123,"count":3,"type":"SCALAR"}])" + more + "}";
    }
};

std::string failure(const Gltf& gltf) {
    const TemporaryDirectory directory;
    return outcome(directory.write("test.gltf", gltf.text()));
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

TEST_CASE("glTF: node transforms and material color", "[scenes][load]") {
    const TemporaryDirectory directory;
    Gltf gltf;
    gltf.nodes =
        R"([{"children":[1,2],"translation":[10,0,0]},{"mesh":0,"scale":[2,2,2]},{"mesh":0,"scale":[-1,1,1]}])";
    const Scene scene = load(directory.write("test.gltf", gltf.text()), unlit());
    REQUIRE(triangle_count(scene) == 2);
    CHECK(bounds(scene) == Box{{9, 0, 0}, {12, 2, 0}});
    for (const VertexColoredTriangle& t : scene.groups[0].triangles) {
        CHECK(t.rgba[0] == Rgba8{255, 0, 0});
        // The mirrored one is turned round again, so that its front stays its front.
        CHECK(glm::cross(t.vertices[1] - t.vertices[0], t.vertices[2] - t.vertices[0]).z > 0.0f);
    }
}

TEST_CASE("glTF: nodes that contain themselves are refused", "[scenes][load]") {
    Gltf gltf;
    gltf.nodes = R"([{"children":[1]},{"children":[0],"mesh":0}])";
    CHECK(contains(failure(gltf), "contain themselves"));
    gltf.nodes = R"([{"children":[0],"mesh":0}])";
    CHECK(contains(failure(gltf), "contain themselves"));
    gltf.nodes = R"([{"mesh":0},{"children":[2]},{"children":[1]}])";
    CHECK(contains(failure(gltf), "contain themselves"));
    gltf.nodes = R"([{"children":[1,2]},{"children":[3]},{"children":[3]},{"mesh":0}])";
    CHECK(contains(failure(gltf), "more than one parent"));
    gltf.nodes = R"([{"children":[7],"mesh":0}])";
    CHECK(contains(failure(gltf), "does not exist"));
    gltf.nodes = "[";
    for (int i = 1; i < 100'000; ++i) gltf.nodes += R"({"children":[)" + std::to_string(i) + "]},";
    gltf.nodes += R"({"mesh":0}])";
    CHECK(contains(failure(gltf), "deep"));
}

TEST_CASE("glTF: counts, indices and files that are not there are refused", "[scenes][load]") {
    CHECK(failure({}).empty());
    Gltf gltf;
    gltf.vertex_count = "4";
    CHECK(contains(failure(gltf), "accessor 0 claims 4"));
    gltf.vertex_count = "4000000000000";
    CHECK(contains(failure(gltf), "accessor 0 claims"));
    gltf.vertex_count = "-3";
    CHECK(contains(failure(gltf), "not a count"));
    gltf.vertex_count = "2";
    CHECK_FALSE(failure(gltf).empty());
    gltf = {};
    gltf.buffer_bytes = "4000000000";
    CHECK(contains(failure(gltf), "buffer 0 claims"));
    gltf = {};
    gltf.buffer_bytes = "40";
    CHECK(contains(failure(gltf), "beyond its buffer"));
    gltf = {};
    gltf.buffer = "missing.bin";
    CHECK(contains(failure(gltf), "missing.bin"));
    gltf = {};
    gltf.index_accessor = "2";
    CHECK(contains(failure(gltf), "does not exist"));
    gltf = {};
    gltf.roots = "[5]";
    CHECK(contains(failure(gltf), "does not exist"));
    gltf = {};
    gltf.material = R"({"pbrMetallicRoughness":{"baseColorTexture":{"index":0}}})";
    CHECK(contains(failure(gltf), "does not exist"));
    gltf = {};
    gltf.more = R"(,"extensionsRequired":["KHR_draco_mesh_compression"])";
    CHECK(contains(failure(gltf), "KHR_draco_mesh_compression"));
}

TEST_CASE("glTF: one face of two with a vertex that does not exist is refused, not left out", "[scenes][load]") {
    // Four positions; the indices are 0 1 2, 0 2 9.
    const TemporaryDirectory directory;
    std::string buffer(48, '\0');
    for (const int index : {0, 1, 2, 0, 2, 9}) buffer.append({static_cast<char>(index), '\0'});
    directory.write("two.bin", buffer);
    Gltf gltf;
    gltf.buffer = "two.bin";
    gltf.buffer_bytes = "60";
    gltf.vertex_count = "4";
    std::string text = gltf.text();
    const auto replace = [&](const std::string& from, const std::string& to) {
        const std::size_t at = text.find(from);
        REQUIRE(at != std::string::npos);
        text.replace(at, from.size(), to);
    };
    replace(R"("byteLength":36})", R"("byteLength":48})");
    replace(R"("byteOffset":36,"byteLength":6)", R"("byteOffset":48,"byteLength":12)");
    replace(R"("componentType":5123,"count":3)", R"("componentType":5123,"count":6)");
    CHECK(contains(outcome(directory.write("two.gltf", text)), "1 of 2 triangles name vertices out of range"));
    buffer[58] = 3;
    directory.write("two.bin", buffer);
    CHECK(outcome(directory.write("two.gltf", text)).empty());
}

TEST_CASE("glTF: JSON that is none is refused", "[scenes][load]") {
    const TemporaryDirectory directory;
    CHECK(contains(outcome(directory.write("a.gltf", "")), "empty"));
    CHECK(contains(outcome(directory.write("b.gltf", "{\"asset\":")), "JSON byte 9"));
    CHECK(contains(outcome(directory.write("c.gltf", "{\"asset\":{\"version\":\"2.0\"}} x")), "JSON byte"));
    CHECK(contains(outcome(directory.write("d.gltf", std::string(1'000'000, '['))), "nested"));
    CHECK(contains(outcome(directory.write("e.gltf", "[]")), "not glTF"));
    CHECK(contains(outcome(directory.write("f.glb", "glTF")), "header"));
    CHECK(contains(outcome(directory.write("g.gltf", R"({"asset":{"version":"2.0"}})")), "no meshes"));
}

TEST_CASE("glTF: a texture beside the file colors the corners", "[scenes][load]") {
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
