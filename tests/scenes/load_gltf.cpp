#include <array>
#include <cstdint>
#include <cstring>
#include <vector>

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

/// A file as .glb, put together piece by piece; all else by the text of its JSON.
struct Binary {
    std::string bytes{}, views{}, accessors{};
    std::size_t accessor_count = 0;
    std::string nodes = R"([{"mesh":0}])";
    std::string roots = "[0]";
    std::string primitives{};  ///< of mesh 0
    std::string more{};        ///< begins with a comma
    std::string chunks_between{}, chunks_after{};

    template <class T>
    std::size_t view(const std::vector<T>& values, const std::string& properties = "") {
        while (bytes.size() % 4 != 0) bytes.push_back('\x7f');
        views += std::string(views.empty() ? "" : ",") + R"({"buffer":0,"byteOffset":)" + std::to_string(bytes.size()) +
                 R"(,"byteLength":)" + std::to_string(values.size() * sizeof(T)) + properties + "}";
        bytes.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T));
        return view_count++;
    }
    /// Values of the component type; its number of elements from its type.
    template <class T>
    std::string add(const std::vector<T>& values, const std::string& type, int component,
                    const std::string& properties = "", std::size_t stride = 0) {
        const std::size_t components = type == "SCALAR" ? 1
                                       : type == "MAT4" ? 16
                                                        : static_cast<std::size_t>(type[3] - '0');
        const std::string apart = stride > 0 ? R"(,"byteStride":)" + std::to_string(stride) : std::string();
        if (stride == 0) stride = components * sizeof(T);
        return raw(R"("bufferView":)" + std::to_string(view(values, apart)) + R"(,"componentType":)" +
                   std::to_string(component) + R"(,"type":")" + type + R"(","count":)" +
                   std::to_string(values.size() * sizeof(T) / stride) + properties);
    }
    std::string raw(const std::string& properties) {
        accessors += (accessors.empty() ? "{" : ",{") + properties + "}";
        return std::to_string(accessor_count++);
    }

    std::string json() const {
        return R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":)" + roots + R"(}],"nodes":)" + nodes +
               R"(,"meshes":[{"primitives":[)" + primitives + R"(]}],"buffers":[{"byteLength":)" +
               std::to_string(bytes.size()) + R"(}],"bufferViews":[)" + views + R"(],"accessors":[)" + accessors + "]" +
               more + "}";
    }
    std::string glb() const {
        std::string text = json();
        while (text.size() % 4 != 0) text.push_back(' ');
        const std::string chunks =
            chunk("JSON", text) + chunks_between + chunk(std::string("BIN\0", 4), bytes) + chunks_after;
        return "glTF" + little(2) + little(static_cast<std::uint32_t>(12 + chunks.size())) + chunks;
    }
    static std::string chunk(const std::string& kind, std::string content) {
        while (content.size() % 4 != 0) content.push_back('\0');
        return little(static_cast<std::uint32_t>(content.size())) + kind + content;
    }
    static std::string little(std::uint32_t value) {
        std::string result;
        for (int i = 0; i < 4; ++i) result.push_back(static_cast<char>(value >> (8 * i) & 0xff));
        return result;
    }

    std::vector<VertexColoredTriangle> triangles(const LoadOptions& options = unlit()) const {
        const TemporaryDirectory directory;
        return load(directory.write("test.glb", glb()), options).groups[0].triangles;
    }
    std::vector<std::string> notes() const {
        const TemporaryDirectory directory;
        return load(directory.write("test.glb", glb())).notes;
    }
    std::string failure() const {
        const TemporaryDirectory directory;
        return outcome(directory.write("test.glb", glb()));
    }

  private:
    std::size_t view_count = 0;
};

const std::vector<float> triangle_positions{0, 0, 0, 1, 0, 0, 0, 1, 0};

/// One triangle; `attributes` begin with a comma.
Binary one_triangle(const std::string& attributes = "", const std::string& properties = "") {
    Binary file;
    file.primitives = R"({"attributes":{"POSITION":)" + file.add(triangle_positions, "VEC3", 5126) + attributes + "}" +
                      properties + "}";
    return file;
}

using Vec3s = std::array<glm::vec3, 3>;

/// Four texels as an uncompressed TGA in a data URI; the upper row is red and white, the lower one blue and green.
const std::string four_texels = "data:application/octet-stream;base64,AAACAAAAAAAAAAAAAgACABgA/wAAAP8AAAD/////";
/// Eight by eight texels as a TGA: green in the middle, else black that is not seen.
const std::string leaf_texels =
    "data:image/"
    "x-tga;base64,"
    "AAACAAAAAAAAAAAACAAIACAIAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAA"
    "AAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAHpYU/x6WFP8AAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAelhT/HpYU/"
    "wAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAA"
    "AAAAAAAAAAAAAAAAAAAAAAAAAAAAAAA==";
/// One blue texel with an alpha of 102.
const std::string glass_texel = "data:image/x-tga;base64,AAACAAAAAAAAAAAAAQABACAI/wAAZg==";

std::string textured(const std::string& image, const std::string& info = "", const std::string& sampler = "{}",
                     const std::string& material = "") {
    return R"(,"images":[{"uri":")" + image + R"("}],"samplers":[)" + sampler +
           R"(],"textures":[{"source":0,"sampler":0}],"materials":[{"pbrMetallicRoughness":{"baseColorTexture":{"index":0)" +
           info + "}}" + material + "}]";
}

constexpr Rgba8 red{255, 0, 0}, green{0, 255, 0}, blue{0, 0, 255}, white{255, 255, 255};

}  // namespace

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
    CHECK(failure(gltf).empty());  // deep, but a tree
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
    CHECK(contains(outcome(directory.write("d.gltf", std::string(1'000'000, '['))), "JSON byte 1000000"));
    CHECK(contains(outcome(directory.write("e.gltf", "[]")), "not glTF"));
    CHECK(contains(outcome(directory.write("f.glb", "glTF")), "header"));
    CHECK(contains(outcome(directory.write("g.gltf", R"({"asset":{"version":"2.0"}})")), "no meshes"));
}

TEST_CASE("glTF: the default scene alone is drawn, and what nobody refers to is not looked at", "[scenes][load]") {
    Binary file = one_triangle();
    file.nodes = R"([{"mesh":0},{"mesh":1,"translation":[5,0,0]}])";
    std::string text = file.json();
    const auto replace = [&](const std::string& from, const std::string& to) {
        const std::size_t at = text.find(from);
        REQUIRE(at != std::string::npos);
        text.replace(at, from.size(), to);
    };
    replace(R"("scenes":[)", R"("scenes":[{"nodes":[1]},)");
    replace(R"("scene":0)", R"("scene":1)");
    replace(R"(]}],"buffers")",
            R"(]},{"primitives":[{"attributes":{"POSITION":77}}]}],"unused":[1,{"2":[]}],"buffers")");
    const TemporaryDirectory directory;
    replace(R"("byteLength":36}],"bufferViews")",
            R"("byteLength":36,"uri":"b.bin"},{"uri":"gone.bin"}],"bufferViews")");
    directory.write("b.bin", file.bytes);
    const Scene scene = load(directory.write("test.gltf", text), unlit());
    REQUIRE(triangle_count(scene) == 1);
    CHECK(bounds(scene) == Box{{0, 0, 0}, {1, 1, 0}});
    CHECK(scene.notes == std::vector<std::string>{"the default one of 2 scenes is drawn"});
    // The other one is broken, and says so.
    replace(R"("scene":1)", R"("scene":0)");
    CHECK(contains(outcome(directory.write("test.gltf", text)), "accessor that does not exist"));
}

TEST_CASE("glTF: without scenes the nodes that have no parent are drawn", "[scenes][load]") {
    Binary file = one_triangle();
    file.nodes = R"([{"children":[1],"translation":[0,0,3]},{"mesh":0},{"mesh":0}])";
    std::string text = file.json();
    const std::string scenes = R"("scene":0,"scenes":[{"nodes":[0]}],)";
    text.erase(text.find(scenes), scenes.size());
    const TemporaryDirectory directory;
    text.replace(text.find(R"("byteLength":36})"), 16, R"("byteLength":36,"uri":"b.bin"})");
    directory.write("b.bin", file.bytes);
    const auto triangles = load(directory.write("test.gltf", text), unlit()).groups[0].triangles;
    REQUIRE(triangles.size() == 2);
    CHECK(triangles[0].vertices[0].z == 3.0f);
    CHECK(triangles[1].vertices[0].z == 0.0f);
}

TEST_CASE("glTF: scenes name roots, each once", "[scenes][load]") {
    Binary file = one_triangle();
    file.nodes = R"([{"children":[1]},{"mesh":0}])";
    file.roots = "[1]";
    CHECK(contains(file.failure(), "scene 0: names node 1, which is the child of another"));
    file.roots = "[0,0]";
    CHECK(contains(file.failure(), "scene 0: names node 0 twice"));
}

TEST_CASE("glTF: a texture has the set, the transform and the sampler that its material says", "[scenes][load]") {
    const std::vector<float> set0{0.1f, 0.1f, 0.1f, 0.1f, 0.1f, 0.1f};  // red alone
    const std::vector<float> set1{0.1f, 0.9f, 0.9f, 0.9f, 0.1f, 0.1f};  // blue, green, red
    Binary file;
    file.primitives = R"({"material":0,"attributes":{"POSITION":)" + file.add(triangle_positions, "VEC3", 5126) +
                      R"(,"TEXCOORD_0":)" + file.add(set0, "VEC2", 5126) + R"(,"TEXCOORD_1":)" +
                      file.add(set1, "VEC2", 5126) + "}}";
    using Colors = std::array<Rgba8, 3>;
    file.more = textured(four_texels);
    CHECK(file.triangles()[0].rgba == Colors{red, red, red});
    file.more = textured(four_texels, R"(,"texCoord":1)");
    CHECK(file.triangles()[0].rgba == Colors{blue, green, red});
    const std::string transform = R"(,"texCoord":0,"extensions":{"KHR_texture_transform":{"texCoord":1)";
    file.more = textured(four_texels, transform + "}}");
    CHECK(file.triangles()[0].rgba == Colors{blue, green, red});
    file.more = textured(four_texels, transform + R"(,"scale":[1,-1],"offset":[0,1]}})");
    CHECK(file.triangles()[0].rgba == Colors{red, white, blue});
    // The extension's own example: the lower left quarter, turned clockwise.
    file.more = textured(four_texels, transform + R"(,"offset":[0,1],"rotation":1.57079632679,"scale":[0.5,0.5]}})");
    CHECK(file.triangles()[0].rgba == Colors{blue, blue, blue});
    // A quarter turn counter-clockwise of the place in the image: (u, v) goes to (v, 1 - u).
    file.more = textured(four_texels, transform + R"(,"offset":[0,1],"rotation":1.57079632679}})");
    CHECK(file.triangles()[0].rgba == Colors{green, white, blue});
    // One further to the right.
    const std::string right = transform + R"(,"offset":[1,0]}})";
    file.more = textured(four_texels, right);
    CHECK(file.triangles()[0].rgba == Colors{blue, green, red});
    file.more = textured(four_texels, right, R"({"wrapS":33648})");
    CHECK(file.triangles()[0].rgba == Colors{green, blue, white});
    file.more = textured(four_texels, right, R"({"wrapS":33071})");
    CHECK(file.triangles()[0].rgba == Colors{green, green, white});
    const std::string below = transform + R"(,"offset":[0,1]}})";
    file.more = textured(four_texels, below, R"({"wrapT":33648})");
    CHECK(file.triangles()[0].rgba == Colors{red, white, blue});
    file.more = textured(four_texels, below, R"({"wrapT":33071})");
    CHECK(file.triangles()[0].rgba == Colors{blue, green, blue});
    file.more = textured(four_texels, "", R"({"wrapS":1})");
    CHECK(contains(file.failure(), "sampler 0: wrapS"));
    file.more = textured(four_texels, R"(,"texCoord":2)");
    CHECK(file.triangles()[0].rgba == Colors{white, white, white});
    CHECK(file.notes() ==
          std::vector<std::string>{"a mesh without TEXCOORD_2 is drawn without the texture that asks for it"});
}

TEST_CASE("glTF: texture coordinates and colors of every type", "[scenes][load]") {
    const auto colors = [](const std::string& attributes, Binary file, const std::string& more) {
        file.primitives = R"({"material":0,"attributes":{"POSITION":)" + file.add(triangle_positions, "VEC3", 5126) +
                          attributes + "}}";
        file.more = more;
        return file.triangles()[0].rgba;
    };
    using Colors = std::array<Rgba8, 3>;
    Binary file;
    const auto u8 =
        file.add(std::vector<std::uint8_t>{10, 240, 240, 240, 10, 10}, "VEC2", 5121, R"(,"normalized":true)");
    const auto u16 = file.add(std::vector<std::uint16_t>{2000, 64000, 64000, 64000, 2000, 2000}, "VEC2", 5123,
                              R"(,"normalized":true)");
    for (const std::string& uv : {u8, u16}) {
        CHECK(colors(R"(,"TEXCOORD_0":)" + uv, file, textured(four_texels)) == Colors{blue, green, red});
    }
    file = {};
    const std::vector<std::string> sets{
        file.add(std::vector<float>{1, 0, 0, 0, 1, 0, 0, 0, 1}, "VEC3", 5126),
        file.add(std::vector<float>{1, 0, 0, 0.5f, 0, 1, 0, 0, 0, 0, 1, 1}, "VEC4", 5126),
        file.add(std::vector<std::uint8_t>{255, 0, 0, 0, 255, 0, 0, 0, 255}, "VEC3", 5121, R"(,"normalized":true)"),
        file.add(std::vector<std::uint8_t>{255, 0, 0, 9, 0, 255, 0, 9, 0, 0, 255, 9}, "VEC4", 5121,
                 R"(,"normalized":true)"),
        file.add(std::vector<std::uint16_t>{65535, 0, 0, 0, 65535, 0, 0, 0, 65535}, "VEC3", 5123,
                 R"(,"normalized":true)"),
        file.add(std::vector<std::uint16_t>{65535, 0, 0, 9, 0, 65535, 0, 9, 0, 0, 65535, 9}, "VEC4", 5123,
                 R"(,"normalized":true)")};
    for (const std::string& set : sets) {
        CHECK(colors(R"(,"COLOR_0":)" + set, file, R"(,"materials":[{}])") == Colors{red, green, blue});
    }
    const auto two = file.add(std::vector<float>{1, 0, 0, 0, 1, 0}, "VEC3", 5126);
    file.primitives =
        R"({"attributes":{"POSITION":)" + file.add(triangle_positions, "VEC3", 5126) + R"(,"COLOR_0":)" + two + "}}";
    CHECK(contains(file.failure(), "mesh 0: COLOR_0 has 2 elements for 3 vertices"));
}

TEST_CASE("glTF: positions and indices of every type, interleaved and sparse", "[scenes][load]") {
    // By reference: a copy could be made before the accessor is added to it.
    const auto positions = [](Binary& file, const std::string& accessor, const std::string& more = "") {
        file.primitives = R"({"attributes":{"POSITION":)" + accessor + "}" + more + "}";
        return file.triangles()[0].vertices;
    };
    const Vec3s expected{glm::vec3(0, 0, 0), glm::vec3(1, 0, 0), glm::vec3(0, 1, 0)};
    Binary file;
    CHECK(positions(file, file.add(std::vector<std::int8_t>{0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0}, "VEC3", 5120, "",
                                   4)) == expected);
    file = {};
    CHECK(positions(file, file.add(std::vector<std::int16_t>{0, 0, 0, 9, 32767, 0, 0, 9, -32768, 32767, 0, 9}, "VEC3",
                                   5122, R"(,"normalized":true)", 8)) ==
          Vec3s{glm::vec3(0, 0, 0), glm::vec3(1, 0, 0), glm::vec3(-1, 1, 0)});
    file = {};
    CHECK(positions(file, file.add(std::vector<std::uint16_t>{0, 0, 0, 9, 1, 0, 0, 9, 0, 1, 0, 9}, "VEC3", 5123, "",
                                   8)) == expected);
    // Two attributes in one view.
    file = {};
    file.view(std::vector<float>{9, 0, 0, 0, 9, 1, 0, 0, 9, 0, 1, 0}, R"(,"byteStride":16)");
    CHECK(positions(file, file.raw(R"("bufferView":0,"byteOffset":4,"componentType":5126,"type":"VEC3","count":3)")) ==
          expected);
    CHECK(contains(
        [&] {
            Binary longer = file;
            longer.primitives =
                R"({"attributes":{"POSITION":)" +
                longer.raw(R"("bufferView":0,"byteOffset":8,"componentType":5126,"type":"VEC3","count":3)") + "}}";
            return longer.failure();
        }(),
        "accessor 1 claims 3 elements"));
    for (int width : {1, 2, 4}) {
        file = {};
        const std::string corners = width == 1   ? file.add(std::vector<std::uint8_t>{2, 0, 1}, "SCALAR", 5121)
                                    : width == 2 ? file.add(std::vector<std::uint16_t>{2, 0, 1}, "SCALAR", 5123)
                                                 : file.add(std::vector<std::uint32_t>{2, 0, 1}, "SCALAR", 5125);
        const std::string accessor = file.add(triangle_positions, "VEC3", 5126);
        CHECK(positions(file, accessor, R"(,"indices":)" + corners) == Vec3s{expected[2], expected[0], expected[1]});
    }
    // Sparse over values, and over nothing.
    for (const bool over_nothing : {false, true}) {
        file = {};
        const std::string base = std::to_string(file.view(triangle_positions));
        const std::string where = std::to_string(file.view(std::vector<std::uint8_t>{1, 2}));
        const std::string what = std::to_string(file.view(std::vector<float>{5, 6, 7, 0, 1, 0}));
        const std::string sparse = R"(,"sparse":{"count":2,"indices":{"componentType":5121,"bufferView":)" + where +
                                   R"(},"values":{"bufferView":)" + what + "}}";
        const std::string head =
            over_nothing ? R"("componentType":5126)" : R"("bufferView":)" + base + R"(,"componentType":5126)";
        CHECK(positions(file, file.raw(head + R"(,"type":"VEC3","count":3)" + sparse)) ==
              Vec3s{glm::vec3(0), glm::vec3(5, 6, 7), glm::vec3(0, 1, 0)});
        file.primitives =
            R"({"attributes":{"POSITION":)" + file.raw(head + R"(,"type":"VEC3","count":2)" + sparse) + "}}";
        CHECK(contains(file.failure(), "sparse indices do not rise, or are out of range"));
    }
    file = {};
    file.primitives = R"({"attributes":{"POSITION":)" + file.add(triangle_positions, "VEC3", 5130) + "}}";
    CHECK(contains(file.failure(), "component type 5130"));
}

TEST_CASE("glTF: lists, strips and fans, with indices or without", "[scenes][load]") {
    const std::vector<float> square{0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0};
    for (const bool indexed : {false, true}) {
        for (const int mode : {5, 6}) {
            Binary file;
            // A fan goes around, a strip to and fro.
            const std::vector<float> around{0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0};
            file.primitives = R"({"mode":)" + std::to_string(mode) + R"(,"attributes":{"POSITION":)" +
                              file.add(mode == 5 ? square : around, "VEC3", 5126) + "}";
            if (indexed)
                file.primitives += R"(,"indices":)" + file.add(std::vector<std::uint8_t>{0, 1, 2, 3}, "SCALAR", 5121);
            file.primitives += "}";
            const auto triangles = file.triangles();
            REQUIRE(triangles.size() == 2);
            float area = 0;
            for (const VertexColoredTriangle& t : triangles) {
                const float z = glm::cross(t.vertices[1] - t.vertices[0], t.vertices[2] - t.vertices[0]).z;
                CHECK(z == 1.0f);  // counter-clockwise, half of the square
                area += float(t.area());
            }
            CHECK(area == 1.0f);
        }
    }
    Binary file;
    file.primitives = R"({"mode":7,"attributes":{"POSITION":)" + file.add(square, "VEC3", 5126) + "}}";
    CHECK(contains(file.failure(), "mode"));
}

TEST_CASE("glTF: points and lines are counted, and refused if there is nothing else", "[scenes][load]") {
    Binary file;
    const std::string positions = file.add(triangle_positions, "VEC3", 5126);
    const auto primitive = [&](int mode) {
        return R"({"mode":)" + std::to_string(mode) + R"(,"attributes":{"POSITION":)" + positions + "}}";
    };
    file.primitives = primitive(0) + "," + primitive(1) + "," + primitive(2) + "," + primitive(3);
    CHECK(contains(file.failure(), "points and lines only"));
    file.primitives += "," + primitive(4);
    CHECK(file.notes() == std::vector<std::string>{"lines left out: 6", "points left out: 3"});
    CHECK(file.triangles().size() == 1);
}

TEST_CASE("glTF: skins place vertices by their joints, wherever their node is", "[scenes][load]") {
    const auto skinned = [](const std::string& joints_type, bool inverse, const std::string& nodes) {
        Binary file;
        const std::string joints =
            joints_type == "u8"
                ? file.add(std::vector<std::uint8_t>{0, 1, 0, 0, 0, 1, 0, 0, 1, 0, 0, 0}, "VEC4", 5121)
                : file.add(std::vector<std::uint16_t>{0, 1, 0, 0, 0, 1, 0, 0, 1, 0, 0, 0}, "VEC4", 5123);
        // Of joint 0, of both in halves, of joint 1; the bytes lack a little of a sum of 1.
        const std::string weights =
            joints_type == "u8" ? file.add(std::vector<std::uint8_t>{254, 0, 0, 0, 127, 127, 0, 0, 255, 0, 0, 0},
                                           "VEC4", 5121, R"(,"normalized":true)")
                                : file.add(std::vector<float>{1, 0, 0, 0, 0.5f, 0.5f, 0, 0, 1, 0, 0, 0}, "VEC4", 5126);
        file.primitives = R"({"attributes":{"POSITION":)" + file.add(triangle_positions, "VEC3", 5126) +
                          R"(,"JOINTS_0":)" + joints + R"(,"WEIGHTS_0":)" + weights + "}}";
        // Bound with joint 0 at x = -1 and joint 1 at the origin.
        std::vector<float> matrices(32, 0.0f);
        for (std::size_t i = 0; i < 4; ++i) matrices[5 * i] = matrices[16 + 5 * i] = 1.0f;
        matrices[12] = 1.0f;
        file.more = R"(,"skins":[{"joints":[1,2])" +
                    (inverse ? R"(,"inverseBindMatrices":)" + file.add(matrices, "MAT4", 5126) : std::string()) + "}]";
        file.nodes = nodes;
        file.roots = "[0,1]";
        return file;
    };
    const std::string nodes = R"([{"mesh":0,"skin":0,"scale":[100,100,100]},{"translation":[10,0,0],"children":[2]},)"
                              R"({"translation":[0,0,4]}])";
    for (const char* type : {"u8", "u16"}) {
        CHECK(skinned(type, false, nodes).triangles()[0].vertices ==
              Vec3s{glm::vec3(10, 0, 0), glm::vec3(11, 0, 2), glm::vec3(10, 1, 4)});
        CHECK(skinned(type, true, nodes).triangles()[0].vertices ==
              Vec3s{glm::vec3(11, 0, 0), glm::vec3(11.5f, 0, 2), glm::vec3(10, 1, 4)});
    }
    // Joints that mirror turn the triangle round.
    const auto mirrored =
        skinned("u8", false, R"([{"mesh":0,"skin":0},{"scale":[-1,1,1],"children":[2]},{}])").triangles()[0];
    CHECK(glm::cross(mirrored.vertices[1] - mirrored.vertices[0], mirrored.vertices[2] - mirrored.vertices[0]).z ==
          1.0f);
    Binary broken = skinned("u8", false, nodes);
    broken.more = R"(,"skins":[{"joints":[1]}])";
    CHECK(contains(broken.failure(), "mesh 0: vertex 1 names a joint that does not exist"));
    broken.more = R"(,"skins":[{"joints":[1,7]}])";
    CHECK(contains(broken.failure(), "skin 0 names a node that does not exist"));
    broken.more = R"(,"skins":[{"joints":[1,2],"inverseBindMatrices":0}])";
    CHECK(contains(broken.failure(), "skin 0: has not a matrix for every joint"));
}

TEST_CASE("glTF: morph targets by the weights of the node, or else of the mesh", "[scenes][load]") {
    Binary file;
    const std::string positions = file.add(triangle_positions, "VEC3", 5126);
    const std::string up = file.add(std::vector<float>{0, 0, 1, 0, 0, 1, 0, 0, 1}, "VEC3", 5126);
    const std::string where = std::to_string(file.view(std::vector<std::uint16_t>{1}));
    const std::string what = std::to_string(file.view(std::vector<float>{8, 0, 0}));
    const std::string aside = file.raw(
        R"("componentType":5126,"type":"VEC3","count":3,"sparse":{"count":1,"indices":{"componentType":5123,"bufferView":)" +
        where + R"(},"values":{"bufferView":)" + what + "}}");
    file.primitives = R"({"attributes":{"POSITION":)" + positions + R"(},"targets":[{"POSITION":)" + up +
                      R"(},{"POSITION":)" + aside + "}]}";
    CHECK(file.triangles()[0].vertices[1] == glm::vec3(1, 0, 0));
    file.nodes = R"([{"mesh":0,"weights":[2,0.5]}])";
    CHECK(file.triangles()[0].vertices == Vec3s{glm::vec3(0, 0, 2), glm::vec3(5, 0, 2), glm::vec3(0, 1, 2)});
    file.nodes = R"([{"mesh":0}])";
    file.primitives += R"(],"weights":[-1,0)";
    CHECK(file.triangles()[0].vertices[0] == glm::vec3(0, 0, -1));
    file.nodes = R"([{"mesh":0,"weights":["much"]}])";
    CHECK(contains(file.failure(), "node 0: weights"));
}

TEST_CASE("glTF: unlit, glowing, specular and glossy materials", "[scenes][load]") {
    const auto color = [](const std::string& material, bool light = false) {
        Binary file = one_triangle("", R"(,"material":0)");
        file.more = R"(,"materials":[)" + material + "]";
        LoadOptions options;
        options.bake_light = light;
        return file.triangles(options)[0].rgba[0];
    };
    const std::string plain = R"("pbrMetallicRoughness":{"baseColorFactor":[1,0,0,1]})";
    CHECK(color("{" + plain + "}", true).r < 255);
    CHECK(color("{" + plain + R"(,"extensions":{"KHR_materials_unlit":{}}})", true) == red);
    CHECK(color("{" + plain + R"(,"emissiveFactor":[0,0,1]})") == Rgba8{255, 0, 255});
    CHECK(color("{" + plain + R"(,"emissiveFactor":[1,0,0]})", true) == red);
    CHECK(color(R"({"pbrMetallicRoughness":{"baseColorFactor":[0,0,0,1]},"emissiveFactor":[0.5,0,0],)"
                R"("extensions":{"KHR_materials_emissive_strength":{"emissiveStrength":2}}})") == red);
    CHECK(color("{" + plain +
                R"(,"extensions":{"KHR_materials_pbrSpecularGlossiness":{"diffuseFactor":[0,1,0,1]}}})") == green);
    // What glows is in a picture that is not there: nothing does.
    Binary file = one_triangle("", R"(,"material":0)");
    file.more = R"(,"images":[{"uri":"gone.png"}],"textures":[{"source":0}],"materials":[{)" + plain +
                R"(,"emissiveFactor":[1,1,1],"emissiveTexture":{"index":0}}])";
    CHECK(file.triangles()[0].rgba[0] == red);
    CHECK(file.notes() == std::vector<std::string>{"image 0: 'gone.png': no such file: drawn without it"});
}

TEST_CASE("glTF: alpha is ignored, cuts or blends", "[scenes][load]") {
    const auto leaf = [](const std::string& alpha_mode, const std::string& image) {
        Binary file;
        file.primitives = R"({"material":0,"attributes":{"POSITION":)" + file.add(triangle_positions, "VEC3", 5126) +
                          R"(,"TEXCOORD_0":)" + file.add(std::vector<float>{0, 0, 1, 0, 1, 1}, "VEC2", 5126) + "}}";
        file.more = textured(image, "", "{}", alpha_mode);
        return file.triangles()[0].rgba;
    };
    const Rgba8 leaf_green{20, 150, 30};
    // All three corners meet what is not seen.
    for (const Rgba8 c : leaf(R"(,"alphaMode":"MASK")", leaf_texels)) CHECK(c == leaf_green);
    for (const Rgba8 c : leaf(R"(,"alphaMode":"BLEND")", leaf_texels)) CHECK(c == leaf_green);
    for (const Rgba8 c : leaf("", leaf_texels)) CHECK(c == Rgba8{0, 0, 0});
    for (const Rgba8 c : leaf(R"(,"alphaMode":"BLEND")", glass_texel)) CHECK(c == Rgba8{0, 0, 255, 102});
    for (const Rgba8 c : leaf("", glass_texel)) CHECK(c == blue);
    for (const Rgba8 c : leaf(R"(,"alphaMode":"MASK","alphaCutoff":0.3)", glass_texel)) CHECK(c == blue);
    Binary file = one_triangle("", R"(,"material":0)");
    file.more = R"(,"materials":[{"alphaMode":"MASK","pbrMetallicRoughness":{"baseColorFactor":[1,1,1,0.4]}}])";
    CHECK(contains(file.failure(), "no triangles"));
    file.more = R"(,"materials":[{"alphaMode":"BLEND","pbrMetallicRoughness":{"baseColorFactor":[1,1,1,0.4]}}])";
    CHECK(file.triangles()[0].rgba[2].a == 102);
    CHECK(file.triangles(LoadOptions{})[0].rgba[2].a == 102);
}

TEST_CASE("glTF: names of files are unescaped, and data may stand in the file itself", "[scenes][load]") {
    const TemporaryDirectory directory;
    Gltf gltf;
    std::string bytes(44, '\0');
    const float positions[] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    std::memcpy(bytes.data(), positions, sizeof positions);
    bytes[38] = 1;
    bytes[40] = 2;
    directory.write("my buffer.bin", bytes);
    gltf.buffer = "my%20buffer.bin";
    CHECK(load(directory.write("a.gltf", gltf.text())).groups[0].triangles.size() == 1);
    gltf.buffer = "my buffer.bin";
    CHECK(load(directory.write("a.gltf", gltf.text())).groups[0].triangles.size() == 1);
    directory.write("100%25.bin", bytes);  // not unescaped by who wrote the file
    gltf.buffer = "100%25.bin";
    CHECK(load(directory.write("a.gltf", gltf.text())).groups[0].triangles.size() == 1);
    std::filesystem::create_directory(directory.path() / "sub");
    directory.write("sub/b.bin", bytes);
    gltf.buffer = R"(sub\\b.bin)";
    CHECK(load(directory.write("a.gltf", gltf.text())).groups[0].triangles.size() == 1);
    std::string escaped = "data:,";
    constexpr std::string_view digits = "0123456789ABCDEF";
    for (const char c : bytes) {
        const auto b = static_cast<unsigned char>(c);
        escaped += {'%', digits[b >> 4], digits[b & 15]};
    }
    gltf.buffer = escaped;
    CHECK(load(directory.write("a.gltf", gltf.text())).groups[0].triangles.size() == 1);
    gltf.buffer = "http://example.com/b.bin";
    CHECK(contains(outcome(directory.write("a.gltf", gltf.text())),
                   "buffer 0: 'http://example.com/b.bin' is not a file"));
    gltf.buffer = "data:application/octet-stream;base64,A*";
    CHECK(contains(outcome(directory.write("a.gltf", gltf.text())), "buffer 0: a data URI with '*'"));
    gltf.buffer = "data:application/octet-stream";
    CHECK(contains(outcome(directory.write("a.gltf", gltf.text())), "without data"));
}

TEST_CASE("glTF: chunks that nobody knows are passed over", "[scenes][load]") {
    Binary file = one_triangle();
    file.chunks_between = Binary::chunk("ABCD", "anything");
    file.chunks_after = Binary::chunk("BINX", "more");
    CHECK(file.failure().empty());
    std::string bytes = one_triangle().glb();
    // Zeros for blanks at the end of the JSON; and something after the end.
    std::size_t end = bytes.find(std::string("BIN\0", 4)) - 4;
    while (bytes[end - 1] == ' ') bytes[--end] = '\0';
    const TemporaryDirectory directory;
    CHECK(outcome(directory.write("a.glb", bytes + "trailing")).empty());
    bytes[4] = 1;
    CHECK(contains(outcome(directory.write("a.glb", bytes)), "version 1"));
    bytes = one_triangle().glb();
    CHECK(contains(outcome(directory.write("a.glb", bytes.substr(0, bytes.size() - 4))), "claims"));
}

TEST_CASE("glTF: what a file requires and nobody here has is refused by name", "[scenes][load]") {
    for (const std::string name : {"KHR_draco_mesh_compression", "EXT_meshopt_compression", "KHR_texture_basisu",
                                   "KHR_materials_transmission", "ACME_anything"}) {
        Binary file = one_triangle();
        file.more = R"(,"extensionsRequired":["KHR_texture_transform",")" + name + R"("])";
        CHECK(contains(file.failure(), "requires the extension '" + name + "'"));
    }
    Binary file = one_triangle();
    file.more = R"(,"extensionsRequired":["KHR_texture_transform","KHR_mesh_quantization","KHR_materials_unlit"])";
    CHECK(file.failure().empty());
    // Used without being required, and with nothing else in its place.
    file = {};
    file.primitives = R"({"attributes":{"POSITION":)" + file.raw(R"("componentType":5126,"type":"VEC3","count":3)") +
                      R"(},"extensions":{"KHR_draco_mesh_compression":{"bufferView":0}}})";
    CHECK(contains(file.failure(), "KHR_draco_mesh_compression"));
}

TEST_CASE("glTF: instances by extension, and nodes that are not to be seen", "[scenes][load]") {
    Binary file = one_triangle();
    const std::string where = file.add(std::vector<float>{0, 0, 1, 0, 0, 2}, "VEC3", 5126);
    const std::string size = file.add(std::vector<float>{1, 1, 1, 3, 3, 3}, "VEC3", 5126);
    file.nodes =
        R"([{"mesh":0,"translation":[10,0,0],"extensions":{"EXT_mesh_gpu_instancing":{"attributes":{"TRANSLATION":)" +
        where + R"(,"SCALE":)" + size + "}}}}]";
    const auto triangles = file.triangles();
    REQUIRE(triangles.size() == 2);
    CHECK(triangles[0].vertices[1] == glm::vec3(11, 0, 1));
    CHECK(triangles[1].vertices[1] == glm::vec3(13, 0, 2));
    file.nodes = R"([{"children":[1,2]},{"mesh":0,"extensions":{"KHR_node_visibility":{"visible":false}}},{"mesh":0}])";
    CHECK(file.triangles().size() == 1);
}

TEST_CASE("glTF: far from the origin nothing is rounded before the origin is subtracted", "[scenes][load]") {
    Binary file = one_triangle();
    file.nodes = R"([{"children":[1],"translation":[500000,0,5400000]},{"mesh":0,"scale":[0.25,0.25,0.25]}])";
    const TemporaryDirectory directory;
    const Scene scene = load(directory.write("test.glb", file.glb()), unlit());
    const auto& v = scene.groups[0].triangles[0].vertices;
    CHECK(v[1] - v[0] == glm::vec3(0.25f, 0, 0));
    CHECK(v[2] - v[0] == glm::vec3(0, 0.25f, 0));
    CHECK(scene.origin + glm::dvec3(v[0]) == glm::dvec3(500000, 0, 5400000));
}

TEST_CASE("glTF: numbers that are none or too large are refused", "[scenes][load]") {
    Binary file;
    file.primitives = R"({"attributes":{"POSITION":)" +
                      file.add(std::vector<float>{0, 0, 0, 1, std::nanf(""), 0, 0, 1, 0}, "VEC3", 5126) + "}}";
    CHECK(contains(file.failure(), "mesh 0: vertex 1 is not finite"));
    file = one_triangle();
    file.nodes = R"([{"mesh":0,"scale":[1e300,1,1],"children":[1]},{"mesh":0,"scale":[1e300,1,1]}])";
    CHECK_FALSE(file.failure().empty());
    file.nodes = R"([{"mesh":0,"scale":[1e999,1,1]}])";
    CHECK(contains(file.failure(), "number that is too large"));
    file.nodes = R"([{"mesh":0,"scale":[1,1]}])";
    CHECK(contains(file.failure(), "node 0: scale has not 3 numbers"));
    file.nodes = R"([{"mesh":0,"scale":[1,1,"x"]}])";
    CHECK(contains(file.failure(), "node 0: scale"));
    file.nodes = R"([{"mesh":0,"scale":7}])";
    CHECK(contains(file.failure(), "node 0: scale is not a list"));
    // Nothing is allocated for triangles that no bytes are behind.
    file = {};
    file.primitives =
        R"({"attributes":{"POSITION":)" + file.raw(R"("componentType":5126,"type":"VEC3","count":3000000000)") + "}}";
    CHECK(contains(file.failure(), "accessor 0 claims 3000000000 elements without data"));
}

TEST_CASE("glTF: many primitives over one array of vertices cost what their triangles do", "[scenes][load]") {
    Binary file;
    const std::string positions = file.add(std::vector<float>(3 * 1'000'000, 1.0f), "VEC3", 5126);
    const std::string indices = file.add(std::vector<std::uint32_t>{0, 1, 999'999}, "SCALAR", 5125);
    const std::string primitive = R"({"attributes":{"POSITION":)" + positions + R"(},"indices":)" + indices + "}";
    file.primitives = primitive;
    for (int i = 1; i < 5'000; ++i) file.primitives += "," + primitive;  // 5 * 10^9 vertices, if each had its own
    CHECK(file.triangles().size() == 5'000);
}

TEST_CASE("glTF: small files that hide faults give what they say", "[scenes][load]") {
    const std::filesystem::path folder = shared_data();
    if (folder.empty()) return;
    const auto box = [&](const char* file) { return bounds(load(folder / "reports" / file)); };
    CHECK(box("gltf-skin.gltf") == Box{{10, 0, 0}, {11, 1, 0}});
    CHECK(box("gltf-twoscenes.gltf") == Box{{0, 0, 0}, {1, 1, 0}});
    for (const char* file : {"gltf-texcoord1.gltf", "gltf-percent/image.gltf"}) {
        const Scene scene = load(folder / "reports" / file, unlit());
        CHECK(scene.notes.empty());
        for (const VertexColoredTriangle& t : scene.groups[0].triangles) {
            for (const Rgba8 c : t.rgba) CHECK_FALSE(c == white);
        }
    }
}
