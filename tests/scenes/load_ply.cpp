#include <bit>
#include <cstring>

#include "files.hpp"

using namespace farfield;
using namespace farfield::scenes;
using namespace farfield::scenes::test;

namespace {

std::vector<VertexColoredTriangle> read(const std::string& content) {
    const TemporaryDirectory directory;
    return load(directory.write("test.ply", content), unlit()).groups[0].triangles;
}

std::string failure(const std::string& content) {
    const TemporaryDirectory directory;
    return outcome(directory.write("test.ply", content));
}

bool contains(const std::string& text, const std::string& part) {
    return text.find(part) != std::string::npos;
}

std::string header(const std::string& format, const std::string& vertices, const std::string& faces,
                   const std::string& vertex_extra = {}, const std::string& face_extra = {}) {
    return "ply\nformat " + format + " 1.0\ncomment by hand\nelement vertex " + vertices +
           "\nproperty float x\nproperty float y\nproperty float z\n" + vertex_extra + "element face " + faces +
           "\nproperty list uchar int vertex_indices\n" + face_extra + "end_header\n";
}

template <class T>
void put(std::string& bytes, T value, bool big) {
    char raw[sizeof(T)];
    std::memcpy(raw, &value, sizeof value);
    if (big == (std::endian::native == std::endian::little)) std::reverse(raw, raw + sizeof value);
    bytes.append(raw, sizeof value);
}

std::string binary(bool big) {
    std::string bytes = header(big ? "binary_big_endian" : "binary_little_endian", "4", "1");
    for (const float v : {0.f, 0.f, 0.f, 1.f, 0.f, 0.f, 1.f, 1.f, 0.f, 0.f, 1.f, 0.5f}) put(bytes, v, big);
    put(bytes, std::uint8_t{4}, big);
    for (const std::int32_t i : {0, 1, 2, 3}) put(bytes, i, big);
    return bytes;
}

}  // namespace

TEST_CASE("PLY: text and both kinds of binary", "[scenes][load]") {
    for (const std::string& content :
         {header("ascii", "4", "1") + "0 0 0\n1 0 0\n1 1 0\n0 1 0.5\n4 0 1 2 3\n", binary(false), binary(true)}) {
        const auto triangles = read(content);
        REQUIRE(triangles.size() == 2);
        CHECK(triangles[1].vertices[2] == glm::vec3(0, 1, 0.5f));
    }
}

TEST_CASE("PLY: colors of vertices and of faces", "[scenes][load]") {
    const std::string bytes = "property uchar red\nproperty uchar green\nproperty uchar blue\n";
    const auto of_vertices =
        read(header("ascii", "3", "1", bytes) + "0 0 0 255 0 0\n1 0 0 0 255 0\n0 1 0 0 0 7\n3 0 1 2\n");
    CHECK(of_vertices[0].rgba[0] == Rgba8{255, 0, 0});
    CHECK(of_vertices[0].rgba[2] == Rgba8{0, 0, 7});
    const auto of_faces = read(header("ascii", "3", "1", "", bytes) + "0 0 0\n1 0 0\n0 1 0\n3 0 1 2 1 2 3\n");
    CHECK(of_faces[0].rgba[1] == Rgba8{1, 2, 3});
    const std::string floats = "property float red\nproperty float green\nproperty float blue\n";
    const auto fractions =
        read(header("ascii", "3", "1", floats) + "0 0 0 1 0 0.2\n1 0 0 1 0 0\n0 1 0 1 0 0\n3 0 1 2\n");
    CHECK(fractions[0].rgba[0] == Rgba8{255, 0, 51});
}

TEST_CASE("PLY: other elements and lists are passed over", "[scenes][load]") {
    const auto triangles = read(
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty list uchar float weights\nproperty double z\nproperty "
        "double y\nproperty double x\nelement edge 1\nproperty int a\nproperty int b\nelement face 1\nproperty list "
        "uchar float texcoord\nproperty list uchar uint vertex_index\nend_header\n2 9 9 0 0 0\n0 0 0 1\n1 9 0 1 0\n0 "
        "1\n6 0 0 0 0 0 0 3 0 1 2\n");
    REQUIRE(triangles.size() == 1);
    CHECK(triangles[0].vertices[1] == glm::vec3(1, 0, 0));
    CHECK(triangles[0].vertices[2] == glm::vec3(0, 1, 0));
}

TEST_CASE("PLY: colors by name, in any place, of any type", "[scenes][load]") {
    const auto color = [](const std::string& type, const std::string& names, const std::string& values) {
        std::string extra;
        for (const auto& name : {names.substr(0, names.find(' ')), names.substr(names.find(' ') + 1)}) {
            extra += "property " + type + ' ' + name + '\n';
        }
        const auto body = "0 0 0 " + values + "\n1 0 0 " + values + "\n0 1 0 " + values + "\n3 0 1 2\n";
        return read(header("ascii", "3", "1", extra + "property " + type + " red\n") + body)[0].rgba[0];
    };
    CHECK(color("uchar", "blue green", "3 2 1") == Rgba8{1, 2, 3});
    CHECK(color("ushort", "blue green", "0 13107 65535") == Rgba8{255, 51, 0});
    CHECK(color("int", "blue green", "3 2 1") == Rgba8{1, 2, 3});
    CHECK(color("double", "blue green", "0 0.2 1") == Rgba8{255, 51, 0});
    CHECK(color("float", "blue green", "0 51 255") == Rgba8{255, 51, 0});   // bytes written as floats
    CHECK(color("uchar", "green alpha", "1 1 1") == Rgba8{204, 204, 204});  // no blue: no color
    const std::string diffuse =
        "property uchar diffuse_blue\nproperty uchar alpha\nproperty uchar diffuse_red\nproperty uchar diffuse_green\n";
    CHECK(read(header("ascii", "3", "1", diffuse) + "0 0 0 3 9 1 2\n1 0 0 3 9 1 2\n0 1 0 3 9 1 2\n3 0 1 2\n")[0]
              .rgba[0] == Rgba8{1, 2, 3});
}

TEST_CASE("PLY: strips and fans, with restarts and turns", "[scenes][load]") {
    const auto with = [](const std::string& element, const std::string& list, const std::string& extra = {}) {
        return read(
            "ply\nformat ascii 1.0\nelement vertex 6\nproperty float x\nproperty float y\nproperty float z\nelement " +
            element + " 1\nproperty list int int vertex_indices\n" + extra +
            "end_header\n0 0 0\n1 0 0\n0 1 0\n1 1 0\n0 2 0\n1 2 0\n" + list + "\n");
    };
    const auto strips = with("tristrips", "9 0 1 2 3 -1 2 3 4 5");
    REQUIRE(strips.size() == 4);
    float area = 0.0f;
    for (const auto& t : strips) {
        area += 0.5f * glm::cross(t.vertices[1] - t.vertices[0], t.vertices[2] - t.vertices[0]).z;
    }
    CHECK(area == 2.0f);  // all face the same way
    CHECK(strips[2].vertices[0] == glm::vec3(0, 1, 0));
    CHECK(with("tristrips", "8 0 1 2 2 2 2 3 4").size() == 2);  // a turn within a strip: 0 1 2 and 2 3 4
    const auto fans = with("trifans", "5 0 1 3 2 4");
    REQUIRE(fans.size() == 3);
    CHECK(fans[2].vertices[0] == glm::vec3(0, 0, 0));
    const std::string color = "property uchar red\nproperty uchar green\nproperty uchar blue\n";
    CHECK(with("tristrips", "4 0 1 2 3 7 8 9", color)[1].rgba[2] == Rgba8{7, 8, 9});
}

TEST_CASE("PLY: concave polygons", "[scenes][load]") {
    const auto triangles =
        read(header("ascii", "8", "1") + "0 0 0\n3 0 0\n3 3 0\n2 3 0\n2 1 0\n1 1 0\n1 3 0\n0 3 0\n8 2 3 4 5 6 7 0 1\n");
    REQUIRE(triangles.size() == 6);
    float area = 0.0f;
    for (const auto& t : triangles) {
        const float z = glm::cross(t.vertices[1] - t.vertices[0], t.vertices[2] - t.vertices[0]).z;
        CHECK(z > 0.0f);
        area += 0.5f * z;
    }
    CHECK(area == 7.0f);
}

TEST_CASE("PLY: names and ends of lines of other writers", "[scenes][load]") {
    const std::string three = "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
    const auto list = [&](const std::string& type, const std::string& name) {
        return "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement "
               "face "
               "1\nproperty list uchar " +
               type + ' ' + name + "\nend_header\n" + three;
    };
    CHECK(read(list("int", "vertex_indexes")).size() == 1);
    CHECK(read(list("uint", "corners")).size() == 1);  // the only list of whole numbers
    CHECK(contains(failure(list("float", "corners")), "faces have no list vertex_indices"));
    std::string carriage_returns = binary(false);
    for (char& c : carriage_returns) {
        if (&c - carriage_returns.data() < static_cast<std::ptrdiff_t>(carriage_returns.find("end_header") + 11) &&
            c == '\n')
            c = '\r';
    }
    CHECK(read(carriage_returns).size() == 2);
    // The first byte of the first number is a line feed.
    carriage_returns[carriage_returns.find("end_header") + 11] = '\n';
    CHECK(read(carriage_returns)[0].vertices[0].x == std::bit_cast<float>(10));
    const std::string patches =
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement patch "
        "1\nproperty list uchar int vertex_indices\nend_header\n" +
        three;
    CHECK(contains(failure(patches), "what an element 'patch' makes of its vertices is not known"));
}

TEST_CASE("PLY: what is wrong is said", "[scenes][load]") {
    const std::string three = "0 0 0\n1 0 0\n0 1 0\n";
    CHECK(contains(failure(""), "empty"));
    CHECK(contains(failure("plyx\n"), "line 1"));
    CHECK(contains(failure("ply\nformat ascii 1.0\n"), "within its header"));
    CHECK(contains(failure("ply\nend_header\n"), "no format"));
    CHECK(contains(failure("ply\nformat ebcdic 1.0\nend_header\n"), "line 2"));
    CHECK(contains(failure("ply\nformat ascii 1.0\nelement vertex -1\nend_header\n"), "line 3"));
    CHECK(contains(failure("ply\nformat ascii 1.0\nelement vertex 1\nproperty quad x\nend_header\n"), "line 4"));
    CHECK(contains(failure(header("ascii", "3", "1") + three + "3 0 1 3\n"), "face 0 names a vertex out of range"));
    CHECK(contains(failure(header("ascii", "3", "1") + three + "3 0 1 -1\n"), "out of range"));
    CHECK(contains(failure(header("ascii", "3", "1") + "0 0 0\n1 0 inf\n0 1 0\n3 0 1 2\n"), "vertex 1 is not finite"));
    CHECK(contains(failure(header("ascii", "3", "1") + "0 0 0\n1 0 x\n0 1 0\n3 0 1 2\n"), "'x' in vertex 1 of 3"));
    CHECK(contains(failure(header("ascii", "3", "1") + three), "ends within face 0 of 1"));
    CHECK(contains(failure(header("ascii", "0", "0")), "no triangles"));
    CHECK(contains(failure(header("ascii", "3", "1") + three + "3 0 nan 2\n"), "out of range"));
}

TEST_CASE("PLY: no count is believed before there is room for it", "[scenes][load]") {
    CHECK(contains(failure(header("ascii", "18446744073709551615", "1") + "0 0 0\n"), "claims"));
    CHECK(contains(failure(header("binary_little_endian", "1000000000000", "1") + "0000"), "claims"));
    CHECK(
        contains(failure("ply\nformat ascii 1.0\nelement nothing 18446744073709551615\nend_header\n"), "no triangles"));
    std::string list = binary(false);
    list.resize(list.size() - 16);
    CHECK(contains(failure(list), "longer than the file"));
}
