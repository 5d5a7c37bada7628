// Clouds of points, read from text and bytes, and what neighbors say about points of which files say little.
#include <bit>
#include <cstring>
#include <map>
#include <string>
#include <vector>

#include "files.hpp"
#include "scenes/load/points.hpp"
#include "support/random.hpp"

using namespace farfield;
using namespace farfield::scenes;
using namespace farfield::scenes::test;
using farfield::test::Random;

namespace {

constexpr std::size_t of_disc = 4, of_ball = 8;

Scene read(const std::string& name, const std::string& content) {
    const TemporaryDirectory directory;
    return load(directory.write(name, content), unlit());
}

std::string failure(const std::string& name, const std::string& content) {
    const TemporaryDirectory directory;
    return outcome(directory.write(name, content));
}

bool contains(const std::string& text, const std::string& part) {
    return text.find(part) != std::string::npos;
}

/// Of points that are all balls.
std::vector<Rgba8> colors(const Scene& scene) {
    std::vector<Rgba8> result;
    for (std::size_t i = 0; i < scene.groups[0].triangles.size(); i += of_ball) {
        result.push_back(scene.groups[0].triangles[i].rgba[0]);
    }
    return result;
}

glm::vec3 center(const Scene& scene, std::size_t ball) {
    Box box = Box::empty();
    for (std::size_t i = 0; i < of_ball; ++i) box.add(scene.groups[0].triangles[ball * of_ball + i].bounds());
    return box.center();
}

/// Two points, which lie in no plane, with the rest of their lines.
std::string two(const std::string& first, const std::string& second) {
    return "0 0 0 " + first + "\n1 0 0 " + second + "\n";
}

std::vector<Point> with_neighbors(std::vector<glm::vec3> positions) {
    std::vector<Point> points(positions.size());
    for (std::size_t i = 0; i < points.size(); ++i) points[i].position = positions[i];
    scenes::detail::set_from_neighbors(points, std::vector<scenes::detail::Unknown>(points.size(), {true, true}));
    return points;
}

std::vector<glm::vec3> sheet(int side) {
    std::vector<glm::vec3> positions;
    for (int i = 0; i < side * side; ++i) positions.emplace_back(i % side, 0, i / side);
    return positions;
}

template <class T>
void put(std::string& bytes, T value) {
    char raw[sizeof(T)];
    std::memcpy(raw, &value, sizeof value);
    if (std::endian::native == std::endian::big) std::reverse(raw, raw + sizeof value);
    bytes.append(raw, sizeof value);
}

std::string pcd_header(const std::string& fields, const std::string& sizes, const std::string& types,
                       const std::string& points, const std::string& data) {
    return "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS " + fields + "\nSIZE " + sizes + "\nTYPE " +
           types + "\nWIDTH " + points + "\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS " + points + "\nDATA " + data +
           "\n";
}

}  // namespace

TEST_CASE("points: the radius suits the distances, and the plane through the neighbors is the disc's", "[scenes]") {
    const auto points = with_neighbors(sheet(20));
    for (const Point& p : points) {
        CHECK(p.radius > 0.7071f);  // no gap on a square grid
        CHECK(p.radius < 1.5f);
        CHECK(p.normal.y > 0.999f);  // towards the light
    }
    // In any unit.
    for (const float scale : {0x1p-90f, 0x1p90f}) {
        auto scaled = sheet(20);
        for (glm::vec3& p : scaled) p *= scale;
        const auto same = with_neighbors(scaled);
        for (std::size_t i = 0; i < same.size(); ++i) {
            CHECK(same[i].radius == points[i].radius * scale);
            CHECK(same[i].normal == points[i].normal);
        }
    }
}

TEST_CASE("points: random samples of a surface cover most of it", "[scenes]") {
    Random random(1);
    std::vector<glm::vec3> positions;
    for (int i = 0; i < 4000; ++i) positions.emplace_back(random.unit(), 0.5f, random.unit());
    double area = 0;
    for (const Point& p : with_neighbors(positions)) {
        CHECK(p.is_disc());
        area += p.area();
    }
    // Discs of twice the surface in all leave e^-2 open.
    CHECK(area > 1.6);
    CHECK(area < 2.6);
}

TEST_CASE("points: outliers do not become huge, and make nothing else so", "[scenes]") {
    for (const std::size_t outliers : {1u, 2u, 5u, 8u, 9u, 12u, 40u}) {
        auto positions = sheet(20);
        Random random(outliers);
        for (std::size_t i = 0; i < outliers; ++i) positions.push_back(glm::vec3(1e6f) + random.in_cube(3));
        CAPTURE(outliers);
        for (const Point& p : with_neighbors(positions)) CHECK(p.radius < 8);
    }
    // Each far from all others, and from each other.
    auto positions = sheet(20);
    for (int i = 0; i < 6; ++i)
        positions.emplace_back(i % 3 == 0 ? 1e6f * float(i + 1) : 0, i % 3 == 1 ? 3e5f : 0, -1e4f * float(i));
    const auto points = with_neighbors(positions);
    for (std::size_t i = 0; i < 400; ++i) CHECK(points[i].radius < 3);
    CHECK(std::count_if(points.begin(), points.end(), [](const Point& p) { return p.radius > 8; }) == 0);
}

TEST_CASE("points: duplicates count once", "[scenes]") {
    const auto once = with_neighbors(sheet(12));
    auto positions = sheet(12);
    for (int i = 0; i < 5; ++i) positions.insert(positions.end(), positions.begin(), positions.begin() + 144);
    const auto often = with_neighbors(positions);
    for (std::size_t i = 0; i < often.size(); ++i) {
        CHECK(often[i].radius == once[i % 144].radius);
        CHECK(often[i].normal == once[i % 144].normal);
    }
    // All at one place: anything, but something.
    for (const Point& p : with_neighbors(std::vector<glm::vec3>(100, {1, 2, 3}))) CHECK(p.radius == 1);
    CHECK(with_neighbors({{1, 2, 3}})[0].radius == 1);
    CHECK(with_neighbors({}).empty());
}

TEST_CASE("points: density may change by any factor", "[scenes]") {
    // As a scanner's does with the distance.
    std::vector<glm::vec3> positions;
    for (int ring = 0; ring < 60; ++ring) {
        const float r = std::pow(1.1f, float(ring));
        for (int i = 0; i < 64; ++i) {
            const float angle = 6.2831853f * float(i) / 64;
            positions.emplace_back(r * std::cos(angle), 0, r * std::sin(angle));
        }
    }
    const auto points = with_neighbors(positions);
    for (std::size_t i = 64; i + 64 < points.size(); ++i) {
        const float r = glm::length(points[i].position);
        CHECK(points[i].radius / r > 0.04f);
        CHECK(points[i].radius / r < 0.2f);
        CHECK(points[i].is_disc());
    }
}

TEST_CASE("points: the nearest are those that brute force finds", "[scenes]") {
    Random random(7);
    std::vector<glm::vec3> positions;
    for (int i = 0; i < 700; ++i) positions.push_back(std::pow(2.0f, random.between(-8, 3)) * random.direction());
    std::vector<double> spacings;
    std::vector<std::vector<std::size_t>> nearest;
    const auto middle = [](std::vector<double> values) {
        std::sort(values.begin(), values.end());
        return values[(values.size() - 1) / 2];
    };
    for (const glm::vec3& p : positions) {
        std::vector<std::pair<double, std::size_t>> all;
        for (std::size_t i = 0; i < positions.size(); ++i) {
            all.emplace_back(glm::length(glm::dvec3(positions[i]) - glm::dvec3(p)), i);
        }
        std::sort(all.begin(), all.end());
        std::vector<double> estimates;
        nearest.emplace_back();
        for (std::size_t j = 1; j <= 16; ++j) {
            estimates.push_back(all[j].first / std::sqrt(double(j)));
            nearest.back().push_back(all[j].second);
        }
        spacings.push_back(middle(estimates));
    }
    const auto points = with_neighbors(positions);
    for (std::size_t i = 0; i < points.size(); ++i) {
        std::vector<double> around;
        for (const std::size_t j : nearest[i]) around.push_back(spacings[j]);
        const double radius = std::sqrt(2.0) * std::min(spacings[i], 2 * middle(around));
        CHECK(std::abs(double(points[i].radius) / radius - 1) < 1e-6);
    }
}

TEST_CASE("points: what lies in no plane stays a ball", "[scenes]") {
    Random random(5);
    std::vector<glm::vec3> foliage, line;
    for (int i = 0; i < 2000; ++i) foliage.push_back(random.in_cube(1));
    for (int i = 0; i < 100; ++i) line.emplace_back(i, 2 * i, 3 * i);
    const auto balls = [](const std::vector<Point>& points) {
        return double(std::count_if(points.begin(), points.end(), [](const Point& p) { return !p.is_disc(); })) /
               double(points.size());
    };
    CHECK(balls(with_neighbors(foliage)) > 0.6);
    CHECK(balls(with_neighbors(line)) == 1);
    CHECK(balls(with_neighbors({{0, 0, 0}, {1, 0, 0}})) == 1);
}

TEST_CASE("points: order does not matter", "[scenes]") {
    Random random(6);
    std::vector<glm::vec3> positions;
    for (int i = 0; i < 500; ++i) positions.push_back(random.direction());
    for (int i = 0; i < 500; ++i) positions.emplace_back(random.below(8), random.below(8), 5);  // ties, duplicates
    std::map<std::array<float, 3>, float> radii;
    for (const Point& p : with_neighbors(positions)) radii[{p.position.x, p.position.y, p.position.z}] = p.radius;
    random.shuffle(positions);
    for (const Point& p : with_neighbors(positions)) {
        CHECK(radii.at({p.position.x, p.position.y, p.position.z}) == p.radius);
    }
}

TEST_CASE("XYZ: columns by what is in them", "[scenes][load]") {
    const std::vector<Rgba8> wanted{{255, 0, 51, 255}, {0, 102, 0, 255}};
    CHECK(colors(read("a.xyz", two("255 0 51", "0 102 0"))) == wanted);
    CHECK(colors(read("a.xyz", two("1 0 0.2", "0 0.4 0"))) == wanted);
    CHECK(colors(read("a.xyz", two("65535 0 13107", "0 26214 0"))) == wanted);
    CHECK(colors(read("a.xyz", two("255 0 51 7", "0 102 0 9"))) == wanted);      // and something else
    CHECK(colors(read("a.xyz", two("-700 255 0 51", "12 0 102 0"))) == wanted);  // no color has -700
    CHECK(colors(read("a.xyz", two("0.25 255 0 51", "0.75 0 102 0"))) == wanted);
    CHECK(colors(read("a.pts", two("12 255 0 51", "40 0 102 0"))) == wanted);
    CHECK(colors(read("a.xyz", two("", ""))) == std::vector<Rgba8>(2, {204, 204, 204, 255}));
    CHECK(colors(read("a.xyz", two("0", "1"))) == std::vector<Rgba8>{{0, 0, 0, 255}, {255, 255, 255, 255}});
    // Of neither kind.
    CHECK(read("a.xyz", two("-5 3 200", "7 -3.5 1")).notes.size() == 1);
    // Normals; with colors before or after them.
    const auto disc = [](const Scene& scene, std::size_t i) {
        REQUIRE(scene.groups[0].triangles.size() == 2 * of_disc);
        const VertexColoredTriangle& t = scene.groups[0].triangles[i * of_disc];
        return std::pair(glm::normalize(glm::cross(t.vertices[1] - t.vertices[0], t.vertices[2] - t.vertices[0])),
                         t.rgba[0]);
    };
    for (const auto& text :
         {two("0.6 0 0.8 255 0 51", "0 0 -1 0 102 0"), two("255 0 51 0.6 0 0.8", "0 102 0 0 0 -1")}) {
        const Scene scene = read("a.xyz", text);
        CHECK(glm::length(disc(scene, 0).first - glm::vec3(0.6f, 0, 0.8f)) < 1e-5f);
        CHECK(glm::length(disc(scene, 1).first - glm::vec3(0, 0, -1)) < 1e-5f);
        CHECK(disc(scene, 0).second == wanted[0]);
    }
    CHECK(disc(read("a.xyz", two("0.6 0 0.8", "0 0 -1")), 1).second == Rgba8{204, 204, 204, 255});
}

TEST_CASE("XYZ: columns by their names, comments, and any separators", "[scenes][load]") {
    const std::vector<Rgba8> wanted{{255, 0, 51, 255}, {0, 102, 0, 255}};
    const std::string rows = "9 255 0 51 0 0 0\n9 0 102 0 1 0 0\n";
    for (const std::string names :
         {"t R G B X Y Z\n", "t,r,g,b,x,y,z\n", "# t red green blue x y z\n", "//t;R;G;B;X;Y;Z\n2\n"}) {
        const Scene scene = read("a.xyz", names + rows);
        CHECK(colors(scene) == wanted);
        CHECK(glm::length(center(scene, 1) - glm::vec3(1, 0, 0)) < 1e-6f);
    }
    for (const char separator : {',', ';', '\t'}) {
        std::string text = "# scanned\n\n" + two("255 0 51", "0 102 0") + "# the end\n";
        std::replace(text.begin() + 10, text.end() - 12, ' ', separator);
        CHECK(colors(read("a.xyz", text)) == wanted);
    }
    CHECK(colors(read("a.xyz",
                      "\xef\xbb\xbf"
                      "0, 0, 0,\r\n1, 0, 0,\r\n"))
              .size() == 2);
    // Decimal commas are no separators.
    CHECK(contains(failure("a.xyz", "1,5 2,5 3,5\n"), "line 1"));
    CHECK(contains(failure("a.xyz", "1,5;2,5;3,5\n"), "line 1"));
    // A radius by its name.
    const Scene scene = read("a.xyz", "x y z radius\n0 0 0 0.25\n9 0 0 0\n");
    CHECK(std::abs(scene.groups[0].triangles[0].bounds().largest_side() - 0.25f * 1.3467736f) < 1e-6f);
    CHECK(scene.groups[0].triangles.back().bounds().largest_side() == 0);
}

TEST_CASE("XYZ: molecules are not clouds, and clouds no molecules", "[scenes][load]") {
    const auto is_molecule = [](const std::string& text) { return read("a.xyz", text).is_closed; };
    CHECK(is_molecule("2\n\nO 0 0 0\nH 1 0 0\n"));
    CHECK(is_molecule("2\n\n1 0 0 0\n2 1 0 0\n"));
    CHECK(is_molecule("2\n0 0 0 0\n1 0 0 0\n2 1 0 0\n"));  // numbers as a comment, and one line more than atoms
    CHECK(is_molecule("2\n10 0 0 0 10 0 0 0 10\n1 0 0 0\n2 1 0 0\n"));
    CHECK(is_molecule("1\n1 2 3 4\n1 0 0 0\n1\n1 2 3 4\n1 0 0 0\n"));  // two frames
    CHECK(is_molecule("2\nt= 0.5\n1 0 0 0\n2 1 0 0\n"));
    CHECK(is_molecule("1\nProperties=pos:R:3\n0 0 0\n"));
    CHECK_FALSE(is_molecule("0 0 0\n1 0 0\n"));
    CHECK_FALSE(is_molecule("2\n0 0 0\n1 0 0\n"));
    CHECK_FALSE(is_molecule("2\n0 0 0 255 0 0\n1 0 0 0 0 9\n"));
    CHECK_FALSE(is_molecule("1\n1 2 3\n"));
    CHECK_FALSE(is_molecule("X Y Z\n1 2 3\n"));
    CHECK_FALSE(is_molecule("1 2 3 car\n4 5 6 tree\n"));
}

TEST_CASE("PTS: counts, intensities, several scans", "[scenes][load]") {
    const std::vector<Rgba8> wanted{{255, 0, 51, 255}, {0, 102, 0, 255}};
    CHECK(colors(read("a.pts", "2\n" + two("-1000 255 0 51", "20 0 102 0"))) == wanted);
    CHECK(colors(read("a.pts", "1\n0 0 0 5 255 0 51\n1\n1 0 0 6 0 102 0\n")) == wanted);
    CHECK(colors(read("a.pts", "2\n" + two("255 0 51", "0 102 0"))) == wanted);
    const auto grays = [](const std::string& i, const std::string& j) {
        const auto c = colors(read("a.pts", "2\n" + two(i, j)));
        CHECK(c[0].r == c[0].b);
        return std::pair<int, int>(c[0].r, c[1].r);
    };
    CHECK(grays("-2048", "2047") == std::pair(0, 255));
    CHECK(grays("-1", "1023") == std::pair(127, 191));
    CHECK(grays("0.2", "0.4") == std::pair(51, 102));
    CHECK(grays("51", "102") == std::pair(51, 102));
    CHECK(grays("1000", "9000") == std::pair(0, 255));
    CHECK(grays("nan", "1e30") == std::pair(128, 128));  // one value has no range
    CHECK(
        contains(failure("a.pts", "3\n" + two("1.000", "2.000")), "line 3: only 2 of the 3 points that line 1 claims"));
    CHECK(contains(failure("a.pts", "1\n" + two("1", "2")), "line 3: more than the 1 points that line 1 claims"));
    CHECK(contains(failure("a.pts", "2\n0 0 0\n1\n1 0 0\n"), "only 1 of the 2"));
    CHECK(contains(failure("a.pts", "18446744073709551615\n0 0 0\n"), "claims"));
    CHECK(contains(failure("a.pts", "0\n"), "no points"));
    CHECK(contains(failure("a.pts", ""), "no points"));
    CHECK(contains(failure("a.pts", "0 0\n"), "line 1: fewer than three"));
    CHECK(contains(failure("a.pts", two("1", "2") + "3 4\n"), "line 3: fewer than 4"));
    CHECK(contains(failure("a.pts", two("1", "2") + "3 4 x 5\n"), "line 3: 'x' where a coordinate"));
    CHECK(contains(failure("a.pts", two("1", "x")), "line 2: 'x' where a number"));
    CHECK(contains(failure("a.pts", "name age\n1 2\n"), "line 1"));
}

TEST_CASE("clouds: what was not seen is left out, and far from zero nothing is lost", "[scenes][load]") {
    const Scene scene = read("a.xyz", "0 0 0\nnan nan nan\n1 0 0\n1 inf 0\n");
    CHECK(scene.groups[0].triangles.size() == 2 * of_ball);
    CHECK(scene.notes == std::vector<std::string>{"2 points without finite coordinates are left out"});
    CHECK(contains(failure("a.xyz", "nan nan nan\n"), "no points whose coordinates are finite"));
    CHECK(contains(failure("a.xyz", "1e300 0 0\n0 0 0\n"), "point 0"));
    std::string near_zero, far_off;
    for (int i = 0; i < 100; ++i) {
        const std::string rest = "." + std::to_string(i / 10) + "25 7.5\n";
        near_zero += std::to_string(i % 10) + ".125 " + std::to_string(i / 10) + rest;
        far_off += "50000" + std::to_string(i % 10) + ".125 540000" + std::to_string(i / 10) + rest;
    }
    const Scene here = read("a.xyz", near_zero), there = read("a.xyz", far_off);
    // Not even by a point that means nothing.
    std::string often;
    for (int i = 0; i < 3; ++i) often += far_off;
    CHECK(read("a.xyz", often + "0 0 0\n").origin == there.origin);
    CHECK(there.origin == glm::dvec3(500000, 5400000, 0));
    REQUIRE(here.groups[0].triangles.size() == there.groups[0].triangles.size());
    for (std::size_t i = 0; i < here.groups[0].triangles.size(); ++i) {
        CHECK(here.groups[0].triangles[i].vertices == there.groups[0].triangles[i].vertices);
    }
}

TEST_CASE("PLY without faces is a cloud", "[scenes][load]") {
    const std::string position = "property double x\nproperty double y\nproperty double z\n";
    const auto ply = [&](const std::string& properties, const std::string& body, const std::string& more = {}) {
        return "ply\nformat ascii 1.0\nelement vertex 2\n" + position + properties + more + "end_header\n" + body;
    };
    const std::string rgb = "property uchar red\nproperty uchar green\nproperty uchar blue\n";
    const std::vector<Rgba8> wanted{{255, 0, 51, 255}, {0, 102, 0, 255}};
    CHECK(colors(read("a.ply", ply(rgb, two("255 0 51", "0 102 0")))) == wanted);
    CHECK(colors(read("a.ply", ply(rgb, two("255 0 51", "0 102 0"),
                                   "element face 0\nproperty list uchar int vertex_indices\n"))) == wanted);
    CHECK(colors(read("a.ply", ply("property float intensity\n", two("0.2", "0.4"))))[1] == Rgba8{102, 102, 102, 255});
    CHECK(
        read("a.ply", ply("", two("", ""), "element range_grid 1\nproperty list uchar int vertex_indices\n") + "1 0\n")
            .groups[0]
            .triangles.size() == 2 * of_ball);
    const std::string normals = "property float nx\nproperty float ny\nproperty float nz\nproperty float radius\n";
    const Scene discs = read("a.ply", ply(normals, two("0 0 1 0.25", "0 0 0 0.5")));
    REQUIRE(discs.groups[0].triangles.size() == of_disc + of_ball);  // no direction: not known
    Box box = Box::empty();
    for (std::size_t i = 0; i < of_disc; ++i) box.add(discs.groups[0].triangles[i].bounds());
    CHECK(box.size().z == 0);
    CHECK(std::abs(box.largest_side() - 0.5f * 1.0996361f) < 1e-6f);
    CHECK(read("a.ply", ply("property float f_dc_0\n", two("1", "2"))).notes.size() == 1);
    CHECK(contains(failure("a.ply", ply("property float radius\n", two("1e38", "1"))), "point 0 has a radius of more"));
    CHECK(read("a.ply", ply("", "0 0 0\nnan nan nan\n")).notes.size() == 1);
    CHECK(contains(failure("a.ply", ply("", "0 0 0.000\n1 0.000\n")), "vertex 1 of 2"));
}

TEST_CASE("PCD: text, bytes, and packed bytes", "[scenes][load]") {
    const std::vector<Rgba8> wanted{{255, 0, 51, 255}, {0, 102, 0, 255}};
    const std::uint32_t red = 0xff0033, green = 0x006600;
    const auto as_float = [](std::uint32_t bits) {
        char text[64];
        std::snprintf(text, sizeof text, "%.9g", double(std::bit_cast<float>(bits)));
        return std::string(text);
    };
    const std::string rows = two(as_float(red), as_float(green));
    const auto text = [&](const std::string& type, const std::string& body) {
        return pcd_header("x y z rgb", "4 4 4 4", "F F F " + type, "2", "ascii") + body;
    };
    CHECK(colors(read("a.pcd", text("F", rows))) == wanted);
    CHECK(colors(read("a.pcd", text("U", two(std::to_string(red), std::to_string(green))))) == wanted);
    CHECK(colors(read("a.pcd", text("F", two(std::to_string(red), std::to_string(green))))) == wanted);
    CHECK(colors(read("without_extension", text("F", rows))) == wanted);
    CHECK(colors(read("a.pcd", "COLUMNS x y z rgb\nPOINTS 2\nDATA ascii\n" + rows)) == wanted);
    CHECK(colors(read("a.pcd",
                      "VERSION .5\nFIELDS x y z rgb\nSIZE 4 4 4 4\nTYPE F F F F\nWIDTH 1\nHEIGHT 2\nDATA ascii\n" +
                          rows)) == wanted);

    std::string bytes, by_field;
    for (const std::uint32_t i : {0u, 1u}) {
        put(bytes, std::uint8_t{7});
        put(bytes, double(i));
        put(bytes, 0.0f);
        put(bytes, std::int16_t{-3});
        put(bytes, i == 0 ? red : green);
        bytes += "pad";
    }
    for (int i = 0; i < 2; ++i) put(by_field, std::uint8_t{7});
    for (const double x : {0.0, 1.0}) put(by_field, x);
    for (const float y : {0.0f, 0.0f}) put(by_field, y);
    for (int i = 0; i < 2; ++i) put(by_field, std::int16_t{-3});
    for (const std::uint32_t color : {red, green}) put(by_field, color);
    by_field += "padpad";
    const auto header = [&](const std::string& data) {
        std::string h = pcd_header("label x y z rgb _", "1 8 4 2 4 1", "U F F I F U", "2", data);
        return h.replace(h.find("WIDTH"), 0, "COUNT 1 1 1 1 1 3\n");
    };
    const Scene binary = read("a.pcd", header("binary") + bytes);
    CHECK(colors(binary) == wanted);
    CHECK(glm::length(center(binary, 1) - glm::vec3(1, 0, -3)) < 1e-6f);

    // As runs of bytes, the last of them as a copy of what is three before.
    std::string packed;
    const std::string literal = by_field.substr(0, by_field.size() - 3);
    for (std::size_t at = 0; at < literal.size(); at += 32) {
        const std::string run = literal.substr(at, 32);
        packed += char(run.size() - 1);
        packed += run;
    }
    packed += char(1 << 5);
    packed += char(2);
    const auto compressed = [&](const std::string& data, std::uint32_t size, std::uint32_t unpacked) {
        std::string sizes;
        put(sizes, size);
        put(sizes, unpacked);
        return header("binary_compressed") + sizes + data;
    };
    const auto size = std::uint32_t(packed.size()), whole = std::uint32_t(by_field.size());
    const Scene unpacked = read("a.pcd", compressed(packed, size, whole));
    CHECK(colors(unpacked) == wanted);
    CHECK(glm::length(center(unpacked, 1) - glm::vec3(1, 0, -3)) < 1e-6f);
    CHECK(contains(failure("a.pcd", compressed(packed, size + 1, whole)), "claims"));
    CHECK(contains(failure("a.pcd", compressed(packed, size - 1, whole)), "packed data are cut short"));
    CHECK(contains(failure("a.pcd", compressed(packed, size, whole + 1)), "another length"));
    CHECK(contains(failure("a.pcd", compressed(packed, size, whole - 1)), "claims"));
    CHECK(contains(failure("a.pcd", compressed("\x3f\xff" + packed, size, whole)), "damaged"));
    CHECK(contains(failure("a.pcd", header("binary_compressed") + "1234"), "ends before"));
    CHECK(contains(failure("a.pcd", header("binary") + bytes.substr(1)), "claims 2 points, but only 43 bytes"));
}

TEST_CASE("PCD: other fields", "[scenes][load]") {
    const auto read_fields = [](const std::string& fields, const std::string& sizes, const std::string& types,
                                const std::string& rows) {
        return read("a.pcd", pcd_header("x y z " + fields, "8 8 8 " + sizes, "F F F " + types, "2", "ascii") + rows);
    };
    CHECK(colors(read_fields("r g b", "1 1 1", "U U U", two("255 0 51", "1 1 1")))[1] == Rgba8{1, 1, 1, 255});
    CHECK(colors(read_fields("r g b", "4 4 4", "F F F", two("1 0 0.2", "1 1 1")))[1] == Rgba8{255, 255, 255, 255});
    CHECK(colors(read_fields("intensity", "4", "F", two("0.2", "0.4")))[0] == Rgba8{51, 51, 51, 255});
    CHECK(
        read_fields("normal_x normal_y normal_z", "4 4 4", "F F F", two("0 0 1", "0 1 0")).groups[0].triangles.size() ==
        2 * of_disc);
    // Organized: what the camera did not see.
    const Scene holes = read_fields("rgb", "4", "F", "nan nan nan nan\n1 2 3 0\n");
    CHECK(colors(holes) == std::vector<Rgba8>{{0, 0, 0, 255}});
    CHECK(holes.notes.size() == 1);
}

TEST_CASE("PCD: what is wrong is said", "[scenes][load]") {
    const auto fails = [](const std::string& text, const std::string& reason) {
        const std::string message = failure("a.pcd", text);
        INFO(message);
        CHECK(contains(message, reason));
    };
    fails("", "no line FIELDS");
    fails("0 0 0\n", "line 1: '0' in the header");
    fails("FIELDS x y z\nSIZE 4 4 4\n", "no line DATA");
    fails("FIELDS x y z\nSIZE 4 4\n", "line 2: SIZE has 2 values for 3 fields");
    fails("FIELDS x y z\nSIZE 4 x 4\n", "line 2: 'x' where a count should be");
    fails(pcd_header("x y z", "4 4 3", "F F F", "1", "ascii"), "the field 'z' is of the unknown type F with 3 bytes");
    fails(pcd_header("x y z", "4 4 4", "F F Q", "1", "ascii"), "unknown type Q");
    fails(pcd_header("x y", "4 4", "F F", "1", "ascii") + "0 0\n", "no fields x, y, z");
    fails(pcd_header("x y z", "4 4 4", "F F F", "1", "xml") + "0 0 0\n", "unknown kind of data 'xml'");
    fails(pcd_header("x y z", "4 4 4", "F F F", "0", "ascii"), "no points");
    fails("FIELDS x y z\nDATA ascii\n0 0 0\n", "neither POINTS nor WIDTH");
    fails("FIELDS x y z\nWIDTH 2\nHEIGHT 2\nPOINTS 3\nDATA ascii\n0 0 0\n",
          "claims 3 POINTS, but WIDTH 2 and HEIGHT 2");
    fails("FIELDS x y z\nWIDTH 4294967296\nHEIGHT 4294967297\nDATA ascii\n0 0 0\n", "more than 2^64");
    fails(pcd_header("x y z", "4 4 4", "F F F", "18446744073709551615", "ascii") + "0 0 0\n", "claims");
    fails(pcd_header("x y z", "4 4 4", "F F F", "18446744073709551615", "binary") + "0 0 0\n", "claims");
    fails("FIELDS x y z a\nCOUNT 1 1 1 18446744073709551615\nPOINTS 1\nDATA binary\n", "claims");
    fails(pcd_header("x y z", "4 4 4", "F F F", "2", "ascii") + "0 0 0         \n", "ends after 1 of 2");
    fails(pcd_header("x y z", "4 4 4", "F F F", "1", "ascii") + "0 0    \n", "line 11: fewer than 3");
    fails(pcd_header("x y z", "4 4 4", "F F F", "1", "ascii") + "0 0 x\n", "'x' in the field 'z'");
}

TEST_CASE("the points of others' meshes are clouds, too", "[scenes][load]") {
    const std::filesystem::path folder = shared_data();
    if (folder.empty()) return;
    // The bunny without its faces: 35,947 points, nearly all with a plane through their neighbors.
    std::string content = content_of(folder / "meshes/bun_zipper.ply");
    const std::size_t faces = content.find("element face");
    content.erase(faces, content.find("end_header") - faces);
    const Scene scene = read("bunny.ply", content);
    const std::size_t count = scene.groups[0].triangles.size();
    CHECK(count >= 35947 * of_disc);
    CHECK(count < 35947 * of_disc * 103 / 100);
    const Box box = bounds(scene), mesh = bounds(load(folder / "meshes/bun_zipper.ply"));
    CHECK(box.largest_side() < 1.05f * mesh.largest_side());
}
