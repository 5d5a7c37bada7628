#include "export_tiles.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <glm/geometric.hpp>
#include <limits>
#include <map>
#include <random>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <vector>

#include "catch.hpp"
#include "farfield/build.hpp"
#include "farfield/paging/open_pages.hpp"
#include "farfield/paging/write_pages.hpp"
#include "scenes/paged_variants.hpp"
#include "support/temporary_directory.hpp"
#include "tileset_reader.hpp"

using namespace farfield_export;
using namespace farfield_export::testing;
using farfield::Box;
using farfield::BoxD;
using farfield::scenes::PagedPrimitive;
using Tensors = farfield::scenes::PagedOver<farfield::OpacityTensor>;
using Cubes = farfield::scenes::PagedOver<farfield::ColorCube>;
using Samples = farfield::scenes::PagedOver<farfield::SampleSet<farfield::AreaSplat>>;

namespace {

/// Leaves in bushes, so that cells pay, and a large floor, which lies in the root's cell itself.
std::vector<PagedPrimitive> leaves(std::size_t count, glm::vec3 at = glm::vec3(0)) {
    std::mt19937 random(19);
    const auto number = [&] { return float(random() % 20001) / 10000 - 1; };
    const auto point = [&] { return glm::vec3(number(), number(), number()); };
    std::vector<PagedPrimitive> out;
    glm::vec3 bush(0);
    while (out.size() < count) {
        if (out.size() % 100 == 0) bush = at + point();
        const glm::vec3 a = bush + 0.06f * point(), b = a + 0.01f * point(), c = a + 0.01f * point();
        const farfield::Rgba8 color{std::uint8_t(random() % 256), 120, 40, 255};
        out.push_back({{a, b, c}, {color, color, color}});
    }
    const farfield::Rgba8 gray{90, 90, 90, 255};
    const std::array<glm::vec3, 3> floor{at + glm::vec3(-1, -1, -1), at + glm::vec3(1, -1, 1),
                                         at + glm::vec3(1, -1, -1)};
    out.push_back({floor, {gray, gray, gray}});
    return out;
}

StoreFile into(Files& files) {
    return [&files](const std::string& name, std::string_view bytes) {
        if (!files.emplace(name, bytes).second) throw std::runtime_error("written twice: " + name);
    };
}

using Corners = std::array<float, 9>;
Corners corners_of(const glm::vec3* v) {
    return {v[0].x, v[0].y, v[0].z, v[1].x, v[1].y, v[1].z, v[2].x, v[2].y, v[2].z};
}
std::vector<Corners> sorted_triangles(const std::vector<PagedPrimitive>& primitives) {
    std::vector<Corners> out;
    for (const auto& p : primitives) out.push_back(corners_of(p.vertices.data()));
    std::sort(out.begin(), out.end());
    return out;
}
/// Of primitives; faces of stand-ins are seen from one side.
void add_surfaces(const Glb& glb, std::vector<Corners>& to) {
    const auto& primitives = glb.json["meshes"][0]["primitives"];
    for (const auto& p : primitives) {
        if (p["mode"] != 4 || !glb.json["materials"][p["material"].get<std::size_t>()]["doubleSided"].get<bool>())
            continue;
        Glb only = glb;
        only.json["meshes"][0]["primitives"] = {p};
        const auto v = only.triangles();
        for (std::size_t i = 0; i < v.size(); i += 3) to.push_back(corners_of(v.data() + i));
    }
}

void check_contains(const BoxD& box, const glm::dvec3& p, double tolerance) {
    const bool contains = BoxD{box.lower - tolerance, box.upper + tolerance}.contains(p);
    if (!contains) CHECK(contains);
}

/// The rules that every tileset keeps, and that leaves of the tree together, or all of it, hold every triangle once.
void check_rules(const Files& files, const std::vector<PagedPrimitive>& primitives, bool adds,
                 std::size_t least_contents = 21) {
    const ReadTile root = read_tileset(files);
    std::vector<Corners> found;
    std::size_t contents = 0;
    for_each_tile(root, [&](const ReadTile& tile) {
        CHECK(std::isfinite(tile.error));
        CHECK(tile.error >= 0);
        const double rounding = 1e-6 * double(tile.box.largest_side());
        for (const ReadTile& child : tile.children) {
            CHECK(child.error <= tile.error);
            check_contains(tile.box, child.box.lower, rounding);
            check_contains(tile.box, child.box.upper, rounding);
        }
        if (tile.children.empty()) CHECK(tile.error == 0);
        if (tile.content.empty()) return;
        ++contents;
        const Glb glb(files.at(tile.content));
        for (const int mode : {0, 4}) {
            for (const bool of_splats : {false, true}) {
                for (const glm::vec3& p : glb.attribute<glm::vec3>(mode, "POSITION", of_splats))
                    check_contains(tile.box, p, rounding);
            }
        }
        if (adds || tile.children.empty()) add_surfaces(glb, found);
    });
    std::sort(found.begin(), found.end());
    CHECK(found == sorted_triangles(primitives));
    // Nothing is written that no tile names.
    std::size_t glbs = 0;
    for (const auto& [name, bytes] : files) glbs += name.ends_with(".glb");
    CHECK(contents == glbs);
    CHECK(contents >= least_contents);
}

constexpr std::size_t small_tile = 200;

/// Of the root's transform, in glTF's axes.
glm::dvec3 translation_of(const Files& files) {
    const auto root = nlohmann::json::parse(files.at("tileset.json"))["root"];
    if (!root.contains("transform")) return glm::dvec3(0);
    const auto m = root["transform"].get<std::array<double, 16>>();
    for (std::size_t i = 0; i < 16; ++i) {
        if (i < 12 || i == 15) CHECK(m[i] == (i % 5 == 0 ? 1 : 0));
    }
    return {m[12], m[14], -m[13]};
}

/// In double precision, as surveys have it.
struct SurveyedTriangle {
    std::array<glm::dvec3, 3> vertices;
    farfield::Rgba8 color;

    BoxD bounds() const {
        BoxD box = BoxD::empty();
        for (const glm::dvec3& v : vertices) box.add(v);
        return box;
    }
    template <class Sink>
    void polygons(Sink&& sink) const {
        sink(farfield::PolygonD{vertices, {&color, 1}});
    }
};

/// What a viewer shows of a tileset: refined until an error of a pixel at most is left.
void show(const ReadTile& tile, glm::dvec3 eye, double focal_px, bool adds, std::vector<const ReadTile*>& shown) {
    const double distance = glm::length(glm::max(glm::abs(tile.box.center() - eye) - tile.box.size() * 0.5, 0.0));
    const bool refines = tile.error * focal_px > distance && !tile.children.empty();
    if (!tile.content.empty() && (adds || !refines)) shown.push_back(&tile);
    if (!refines) return;
    for (const ReadTile& child : tile.children) show(child, eye, focal_px, adds, shown);
}

}  // namespace

TEMPLATE_TEST_CASE("tiles hold their contents and every triangle once, and errors fall", "", Tensors, Cubes, Samples) {
    auto primitives = leaves(12000);
    const auto hierarchy = farfield::build_in_place<TestType>(primitives, {});
    constexpr bool adds = TestType::approximation_type::facts.samples_primitives;
    Files files;
    const ExportOptions options{.tile_size = small_tile, .sample_levels = 2, .tiles_in_file = adds ? 4u : 16u};
    const ExportReport report = export_tiles(hierarchy, primitives, into(files), options);
    check_rules(files, primitives, adds);
    CHECK(report.files == files.size());
    CHECK((report.splats > 0) == std::is_same_v<TestType, Tensors>);
    CHECK((report.face_triangles > 0) == std::is_same_v<TestType, Cubes>);
    CHECK((report.points > 0) == adds);
    if (adds) CHECK(report.triangles == primitives.size());
    // More than one file of tiles.
    CHECK(std::count_if(files.begin(), files.end(), [](const auto& f) { return f.first.ends_with(".json"); }) > 2);

    Files again;
    export_tiles(hierarchy, primitives, into(again), options);
    CHECK(files == again);
}

TEMPLATE_TEST_CASE("pages give tiles by the same rules within their cache", "", Tensors, Cubes, Samples) {
    auto primitives = leaves(12000);
    const auto hierarchy = farfield::build_in_place<TestType>(primitives, {});
    const farfield::test::TemporaryDirectory directory;
    const auto path = directory.path() / "leaves.farfield";
    farfield::save_pages(hierarchy, primitives, path, {.page_bytes = 8192});
    farfield::PageCacheOptions cache;
    cache.most_bytes = 48 * 8192;
    {
        auto pages = farfield::open_pages<TestType, PagedPrimitive>(path, cache);
        REQUIRE(pages.page_count() > 40);
        Files files;
        export_tiles(pages, into(files), {.tile_size = small_tile, .sample_levels = 2});
        check_rules(files, primitives, TestType::approximation_type::facts.samples_primitives);
    }
}

TEST_CASE("an error target in pixels keeps what a tolerance keeps") {
    auto primitives = leaves(12000);
    const auto hierarchy = farfield::build_in_place<Tensors>(primitives, {});
    Files files;
    export_tiles(hierarchy, primitives, into(files), {.tile_size = small_tile});
    const ReadTile root = read_tileset(files);

    // Which cell a splat is of.
    struct Place {
        farfield::Cell cell;
        farfield::StoredTensor data;
        float factor = 1;
    };
    std::map<std::array<float, 6>, Place> places;
    const auto key = [](glm::vec3 center, glm::vec3 scale) {
        return std::array<float, 6>{center.x, center.y, center.z, scale.x, scale.y, scale.z};
    };
    const auto visit = [&](auto&& self, const farfield::Subtree& s) -> void {
        if (s.has_stand_in()) {
            const auto& data = hierarchy.stand_ins()[s.stand_in];
            const GaussianSplat splat = gaussian_of(hierarchy.approximation_policy(), data, s.cell);
            places[key(splat.center, splat.scale)] = {
                s.cell, data, farfield::detail::error_of_replaced_levels(hierarchy.nodes()[s.node])};
        }
        farfield::for_each_child<farfield::VisitOrder::any>(hierarchy, s, glm::vec4(0),
                                                            [&](farfield::Subtree& child) { self(self, child); });
    };
    visit(visit, farfield::whole_of(hierarchy));

    std::size_t seen = 0;
    for (const double distance : {1.5, 4.0, 20.0, 5000.0}) {
        const glm::dvec3 eye = distance * glm::normalize(glm::dvec3(1, 2, 3));
        farfield::View view;
        view.camera = farfield::Camera::perspective(eye, {0, 0, 0}, {0, 1, 0}, 0.8f);
        const farfield::LocalView local(view, hierarchy.origin(), hierarchy.bounds());
        std::vector<const ReadTile*> shown;
        show(root, eye, double(local.focal_px), false, shown);
        REQUIRE(!shown.empty());
        float largest = 0;
        for (const ReadTile* tile : shown) {
            const Glb glb(files.at(tile->content));
            const auto centers = glb.attribute<glm::vec3>(0, "POSITION", true);
            const auto scales = glb.attribute<glm::vec3>(0, "KHR_gaussian_splatting:SCALE", true);
            for (std::size_t i = 0; i < centers.size(); ++i) {
                const Place& place = places.at(key(centers[i], scales[i]));
                largest = std::max(
                    largest, place.factor * hierarchy.approximation_policy().error_px(place.data, place.cell, local));
                ++seen;
            }
        }
        CHECK(largest <= 1.0001f);
        // Not in vain: far away something is left to be wrong.
        if (distance == 5000) CHECK(shown.size() == 1);
    }
    CHECK(seen > 100);
}

TEMPLATE_TEST_CASE("a scene far from zero keeps its place in a transform", "", Tensors, Cubes, Samples) {
    auto primitives = leaves(3000);
    const auto hierarchy = farfield::build_in_place<TestType>(primitives, {});
    CHECK(hierarchy.origin() == glm::dvec3(0));
    ExportOptions options{.tile_size = small_tile, .sample_levels = 2, .tiles_in_file = 4};
    Files here, there;
    export_tiles(hierarchy, primitives, into(here), options);
    CHECK(translation_of(here) == glm::dvec3(0));
    // Which single precision does not have.
    options.origin = {500'000.125, 210.7, 5'400'000.3};
    export_tiles(hierarchy, primitives, into(there), options);
    CHECK(translation_of(there) == options.origin);
    // That is all: tiles are what they were.
    REQUIRE(here.size() > 8);
    REQUIRE(there.size() == here.size());
    for (const auto& [name, bytes] : here) {
        if (name != "tileset.json") CHECK(there.at(name) == bytes);
    }
    check_rules(there, primitives, TestType::approximation_type::facts.samples_primitives);
    for (const double no : {std::numeric_limits<double>::infinity(), std::numeric_limits<double>::quiet_NaN()}) {
        options.origin.y = no;
        Files none;
        CHECK_THROWS_AS(export_tiles(hierarchy, primitives, into(none), options), std::invalid_argument);
        CHECK(none.empty());
    }
}

TEMPLATE_TEST_CASE("primitives in double precision keep their place to the last digit that matters", "", Tensors, Cubes,
                   Samples) {
    const glm::dvec3 away(500'000.125, 210.7, 5'400'000.3);
    const auto near_zero = leaves(1000);
    std::vector<SurveyedTriangle> primitives;
    std::vector<glm::dvec3> vertices;
    for (const PagedPrimitive& p : near_zero) {
        SurveyedTriangle& t = primitives.emplace_back();
        for (std::size_t i = 0; i < 3; ++i) t.vertices[i] = away + glm::dvec3(p.vertices[i]);
        t.color = p.rgba[0];
        vertices.insert(vertices.end(), t.vertices.begin(), t.vertices.end());
    }
    const auto hierarchy = farfield::build_in_place<TestType>(primitives, {});
    // Half of it in the primitives, half in what a loader has left out.
    const glm::dvec3 more(0, 0, 1e7);
    Files files;
    ExportOptions options{.tile_size = small_tile, .sample_levels = 2};
    options.origin = more;
    export_tiles(hierarchy, primitives, into(files), options);
    const glm::dvec3 origin = translation_of(files);
    CHECK(origin == hierarchy.origin() + more);
    std::size_t triangles = 0;
    double farthest = 0;
    for_each_tile(read_tileset(files), [&](const ReadTile& tile) {
        if (tile.content.empty() || !(TestType::approximation_type::facts.samples_primitives || tile.children.empty()))
            return;
        std::vector<Corners> found;
        add_surfaces(Glb(files.at(tile.content)), found);
        for (const Corners& c : found) {
            ++triangles;
            for (std::size_t i = 0; i < 9; i += 3) {
                const glm::dvec3 at = origin - more + glm::dvec3(c[i], c[i + 1], c[i + 2]);
                double nearest = 1e300;
                for (const glm::dvec3& v : vertices) nearest = std::min(nearest, glm::length(v - at));
                farthest = std::max(farthest, nearest);
            }
        }
    });
    CHECK(triangles == primitives.size());
    // Half a unit in the last place of coordinates around 1, three times; 0.5 where they were around 5,400,000.
    CHECK(farthest < 3e-7);
}

TEMPLATE_TEST_CASE("contents far from zero in single precision are vertices near zero and a translation", "", Tensors,
                   Cubes, Samples) {
    const glm::vec3 away(500'000, -210, 5'400'000);
    auto primitives = leaves(3000);
    for (PagedPrimitive& p : primitives) {
        for (glm::vec3& v : p.vertices) v = v * 1000.0f + away;
    }
    const auto hierarchy = farfield::build_in_place<TestType>(primitives, {});
    Files files;
    export_tiles(hierarchy, primitives, into(files), {.tile_size = small_tile, .sample_levels = 2});
    check_rules(files, primitives, TestType::approximation_type::facts.samples_primitives);
    for_each_tile(read_tileset(files), [&](const ReadTile& tile) {
        if (tile.content.empty()) return;
        const Glb glb(files.at(tile.content));
        for (const auto& accessor : glb.json["accessors"]) {
            if (!accessor.contains("min")) continue;
            for (const char* bound : {"min", "max"}) {
                const auto at = accessor[bound].get<std::array<double, 3>>();
                CHECK(std::abs(at[0]) <= tile.box.size().x * 1.001);
                CHECK(std::abs(at[2]) <= tile.box.size().z * 1.001);
            }
        }
    });
}

TEST_CASE("what is empty is refused, and what is degenerate is exported") {
    std::vector<PagedPrimitive> primitives;
    Files files;
    CHECK_THROWS_AS(export_tiles(farfield::build<Tensors>(primitives), primitives, into(files)), std::invalid_argument);
    const farfield::Rgba8 c{1, 2, 3, 255};
    // A thousand at one place, without an area.
    primitives.assign(1000, {{glm::vec3(1), glm::vec3(1), glm::vec3(1)}, {c, c, c}});
    for (const std::size_t size : {std::size_t(64), std::size_t(8192)}) {
        files.clear();
        const auto report = export_tiles(farfield::build<Tensors>(primitives), primitives, into(files),
                                         ExportOptions{.tile_size = size});
        CHECK(report.triangles == 1000);
    }
}

TEMPLATE_TEST_CASE("scenes of any size, and one triangle, are exported by the same rules", "", Tensors, Cubes,
                   Samples) {
    constexpr bool adds = TestType::approximation_type::facts.samples_primitives;
    for (const float size : {0x1p-80f, 0x1p80f}) {
        auto primitives = leaves(3000);
        for (PagedPrimitive& p : primitives) {
            for (glm::vec3& v : p.vertices) v *= size;
        }
        const auto hierarchy = farfield::build_in_place<TestType>(primitives, {});
        Files files;
        export_tiles(hierarchy, primitives, into(files), {.tile_size = 100, .sample_levels = 2});
        check_rules(files, primitives, adds, 10);
    }
    std::vector<PagedPrimitive> one(1, leaves(1)[0]);
    for (const ExportOptions& options : {ExportOptions{}, ExportOptions{.tile_size = 0, .sample_levels = 0}}) {
        Files files;
        CHECK(export_tiles(farfield::build<TestType>(one), one, into(files), options).triangles == 1);
        check_rules(files, one, adds, 1);
    }
}

TEMPLATE_TEST_CASE("pages that are empty or go missing end an export with a reason", "", Tensors, Cubes, Samples) {
    const farfield::test::TemporaryDirectory directory;
    const auto path = directory.path() / "leaves.farfield";
    Files files;
    std::vector<PagedPrimitive> primitives;
    farfield::save_pages(farfield::build<TestType>(primitives), primitives, path);
    {
        auto pages = farfield::open_pages<TestType, PagedPrimitive>(path);
        CHECK_THROWS_AS(export_tiles(pages, into(files)), std::invalid_argument);
    }
    primitives = leaves(12000);
    const auto hierarchy = farfield::build_in_place<TestType>(primitives, {});
    farfield::save_pages(hierarchy, primitives, path, {.page_bytes = 8192});
    farfield::PageCacheOptions cache;
    cache.most_bytes = 48 * 8192;
    const auto size = std::filesystem::file_size(path);
    auto pages = farfield::open_pages<TestType, PagedPrimitive>(path, cache);
    std::filesystem::resize_file(path, size / 2);
    try {
        export_tiles(pages, into(files), {.tile_size = small_tile, .sample_levels = 2});
        FAIL("half of the pages were exported as all");
    } catch (const std::runtime_error& error) {
        const std::string said = error.what();
        INFO(said);
        CHECK(said.find("a page is missing") != std::string::npos);
        CHECK(said.find("leaves.farfield") != std::string::npos);
    }
    CHECK(!files.contains("tileset.json"));
    CHECK_THROWS_AS((farfield::open_pages<TestType, PagedPrimitive>(path, cache)), std::runtime_error);
}
