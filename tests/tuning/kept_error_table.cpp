#include "farfield/tuning/kept_error_table.hpp"

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <numbers>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "catch.hpp"
#include "farfield/approximation/area_splat.hpp"
#include "farfield/approximation/color_cube.hpp"
#include "farfield/approximation/color_cube_cluster.hpp"
#include "farfield/build.hpp"
#include "farfield/cost_model/triangle_count.hpp"
#include "farfield/paging/open_pages.hpp"
#include "farfield/paging/pack_pages.hpp"
#include "farfield/paging/write_pages.hpp"
#include "farfield/partition/octree.hpp"
#include "farfield/primitive/triangle.hpp"
#include "farfield/storage/open.hpp"
#include "farfield/storage/save.hpp"
#include "storage/files.hpp"
#include "support/trim_zeros.hpp"

using namespace farfield;

namespace {

using Hierarchy = SpatialHierarchy<Octree, ColorCube, TriangleCount>;

const MeasuredWith with{"z-buffer", 640, 360};

/// A table with all that one may have: several numbers of samples, and numbers of many digits.
SampledErrorTable some_table() {
    const ErrorTable one({{0, 0.1, 1}, {0.25f, 1.0 / 3, 0.7}, {std::numbers::sqrt2_v<float>, 1e-300, 0.1}}, 0.125);
    return SampledErrorTable({{1, 1, one}, {9, 8.0 / 3, ErrorTable({{0, 0.05, 1}, {2, 0.06, 0.1}})}});
}
void require_same(const SampledErrorTable& a, const SampledErrorTable& b) {
    REQUIRE(a.tables().size() == b.tables().size());
    for (std::size_t t = 0; t < a.tables().size(); ++t) {
        const auto &its = a.tables()[t], &expected = b.tables()[t];
        CHECK(its.samples == expected.samples);
        CHECK(its.exact_cost == expected.exact_cost);
        CHECK(its.table.least_saving() == expected.table.least_saving());
        REQUIRE(its.table.trials().size() == expected.table.trials().size());
        for (std::size_t i = 0; i < its.table.trials().size(); ++i) {
            CHECK(its.table.trials()[i].tolerance_px == expected.table.trials()[i].tolerance_px);
            CHECK(its.table.trials()[i].rmse == expected.table.trials()[i].rmse);
            CHECK(its.table.trials()[i].cost == expected.table.trials()[i].cost);
        }
    }
}

struct Scene {
    std::vector<Triangle> triangles = scene(300);
    Hierarchy hierarchy = build<Hierarchy>(triangles);

    std::string identity() const { return "version 3\nhierarchy " + std::to_string(identity_of(hierarchy)) + "\n"; }
    std::string head() const { return identity() + "samples 1 1\nleast_saving 0.05\n"; }
    /// What is said of a note, after its name.
    std::string refusal(const std::string& text) const {
        try {
            return kept_error_table(with, hierarchy, Notes{{"errors z-buffer 640x360", text}}) ? "" : "NO TABLE";
        } catch (const std::runtime_error& e) {
            const std::string start = "farfield::kept_error_table: errors z-buffer 640x360:", what = e.what();
            return what.substr(0, start.size()) == start ? what.substr(start.size()) : "NO NAME: " + what;
        }
    }
};

}  // namespace

TEST_CASE("an error table comes back from its hierarchy's file to the last bit, and chooses the same") {
    const TemporaryDirectory directory;
    const Scene scene;
    const auto plain = directory / "plain", pages = directory / "pages.farfield", packed = directory / "packed";
    save(scene.hierarchy, plain);
    save_pages<Hierarchy, Triangle>(scene.hierarchy, scene.triangles, pages);
    pack_pages(test::TrimZeros(), pages, packed);
    const SampledErrorTable table = some_table();
    for (const auto& path : {plain, pages, packed}) {
        CHECK_FALSE(kept_error_table(with, scene.hierarchy, path));
        keep_error_table(table, {"coverage", 640, 360}, scene.hierarchy, path);
        CHECK_FALSE(kept_error_table(with, scene.hierarchy, path));
        keep_error_table(SampledErrorTable(ErrorTable({{0, 1, 1}})), with, scene.hierarchy, path);
        keep_error_table(table, with, scene.hierarchy, path);  // in place of it
        CHECK_FALSE(kept_error_table({"z-buffer", 360, 640}, scene.hierarchy, path));
        CHECK(error_tables_in(read_notes(path)) == std::vector<MeasuredWith>{{"coverage", 640, 360}, with});
        const auto back = kept_error_table(with, scene.hierarchy, path);
        REQUIRE(back);
        require_same(*back, table);
        for (const double wanted : {0.06, 0.1, 0.5}) {
            CHECK(back->cheapest_for({wanted}).samples == table.cheapest_for({wanted}).samples);
        }
    }
    // What is opened is the same hierarchy, and pages bring the table along.
    CHECK(identity_of(open<Hierarchy>(plain)) == identity_of(scene.hierarchy));
    const auto opened = open_pages<Hierarchy, Triangle>(pages);
    CHECK(identity_of(opened) == identity_of(scene.hierarchy));
    require_same(kept_error_table(with, opened).value(), table);
    CHECK(read_notes(plain) == read_notes(pages));
    CHECK(read_notes(plain) == read_notes(packed));
    const std::string text = read_notes(plain).at("errors z-buffer 640x360");
    CHECK(text.find("samples 9 2.6666666666666665\n") != std::string::npos);
    CHECK(text.find("0.25 0.3333333333333333 0.7\n") != std::string::npos);
}

TEST_CASE("the table of another hierarchy is refused, and what is no table, with its line") {
    const Scene scene;
    CHECK(scene.refusal(scene.head() + "0 0.1 1\n").empty());
    CHECK(scene.refusal("# mine\n\n" + scene.head() + "0 0.1 1").empty());
    CHECK(scene.refusal("version 3\nhierarchy 1\n").find("2: it was measured for another hierarchy") == 0);
    CHECK(scene.refusal(scene.head() + "0 0.1\n") == "5: expected a number, found ''");
    CHECK(scene.refusal(scene.head() + "0 much 1\n") == "5: expected a number, found 'much'");
    CHECK(scene.refusal(scene.head() + "0 0.1 1 2\n") == "5: '2' is too much");
    CHECK(scene.refusal(scene.head() + "nonsense\n") == "5: expected a number, found 'nonsense'");
    CHECK(scene.refusal("version 3\nsamples 1 1\nleast_saving 0.05\n0 0.1 1\n") ==
          " does not say of which hierarchy it is");
    CHECK(scene.refusal(scene.head()).find(" tolerances must ascend from 0") == 0);
    CHECK(scene.refusal(scene.head() + "0 0.1 1\n2 0.1 1\n1 0.1 1\n").find(" tolerances must ascend") == 0);
    for (const char* row : {"0 nan 1\n", "0 inf 1\n", "0 -1 1\n", "nan 1 1\n", "0 1 nan\n", "0 1e999 1\n"}) {
        INFO(row);
        CHECK_FALSE(scene.refusal(scene.head() + row).empty());
    }
    CHECK(scene.refusal(scene.identity() + "samples 1 1\n0 0.1 1\n")
              .find(" tolerances must ascend from 0, errors and costs be 0 or more, and the least saving") == 0);
    CHECK(scene.refusal(scene.identity() + "0 0.1 1\n") == "3: '0' comes before any number of samples");
    CHECK(scene.refusal(scene.identity()).find(" there must be a table") == 0);
    CHECK(scene.refusal(scene.head() + "0 0.1 1\nsamples 1 1\nleast_saving 0\n0 0.1 1\n").find(" there must be") == 0);
    CHECK(scene.refusal(scene.identity() + "samples -1 1\nleast_saving 0\n0 0.1 1\n").find(" there must be") == 0);
    CHECK(scene.refusal("version 2\n") == "1: it is of version 2, and this library reads version 3: measure it again");
    CHECK(scene.refusal("version\n") == "1: expected a number, found ''");
    CHECK(scene.refusal("nonsense\n") == "1: expected 'version', found 'nonsense'");
    CHECK(scene.refusal("") == " does not say of which hierarchy it is");
}

TEST_CASE("a changed character of a table leaves a table, or is told by the name of its note") {
    const Scene scene;
    Notes notes;
    keep_error_table(some_table(), with, scene.hierarchy, notes);
    const std::string good = notes.begin()->second;
    for (std::size_t i = 0; i < good.size(); ++i) {
        std::string bad = good;
        bad[i] = char(bad[i] ^ (1 << i % 8));
        // Checksums find all; what passes them is some table, or says why it is none.
        const std::string why = scene.refusal(bad);
        CAPTURE(i, bad[i], why);
        CHECK(why.find("NO NAME") == std::string::npos);
    }
}

TEST_CASE("a table that was put into the file of another hierarchy is refused by the file's name") {
    const TemporaryDirectory directory;
    const Scene scene;
    save(scene.hierarchy, directory / "h");
    using Cells = SpatialHierarchy<Octree, ColorCubeCluster<4>, TriangleCount>;
    const auto fewer = build<Hierarchy>(::scene(299)),
               deeper = build<Hierarchy>(scene.triangles, {.partition = {.max_depth = 0}});
    CHECK(identity_of(fewer) != identity_of(scene.hierarchy));
    CHECK(identity_of(deeper) != identity_of(scene.hierarchy));
    CHECK(identity_of(build<Cells>(scene.triangles)) != identity_of(scene.hierarchy));
    CHECK(identity_of(build<Hierarchy>(scene.triangles)) == identity_of(scene.hierarchy));
    const Bytes before = read_file(directory / "h");
    CHECK_THROWS_WITH(keep_error_table(some_table(), with, fewer, directory / "h"),
                      Catch::Matchers::Contains("farfield::keep_error_table: " + (directory / "h").string()) &&
                          Catch::Matchers::Contains("another hierarchy"));
    CHECK(read_file(directory / "h") == before);
    Notes notes;
    keep_error_table(some_table(), with, fewer, notes);
    write_notes(notes, directory / "h");
    CHECK_THROWS_WITH(kept_error_table(with, scene.hierarchy, directory / "h"),
                      Catch::Matchers::Contains((directory / "h").string() + ": errors z-buffer 640x360:3: it was") &&
                          Catch::Matchers::Contains("another hierarchy"));
    CHECK_THROWS_AS(kept_error_table(with, scene.hierarchy, directory / "none"), std::runtime_error);
    CHECK_THROWS_AS(keep_error_table(some_table(), with, scene.hierarchy, directory.path()), std::runtime_error);
}

TEST_CASE("a table belongs to the options that its hierarchy was built with, in files of any kind") {
    const TemporaryDirectory directory;
    const auto triangles = ::scene(300);
    using Splats = SpatialHierarchy<Octree, AreaSplat, TriangleCount>;
    const auto some = build<Splats>(triangles, {.approximation = {.shown = 0.5f}}),
               others = build<Splats>(triangles, {.approximation = {.shown = 0.9f}});
    CHECK(identity_of(some) != identity_of(others));
    save(some, directory / "plain");
    save_pages<Splats, Triangle>(some, triangles, directory / "pages");
    pack_pages(test::TrimZeros(), directory / "pages", directory / "packed");
    for (const char* name : {"plain", "pages", "packed"}) {
        CHECK_THROWS_WITH(keep_error_table(some_table(), with, others, directory / name),
                          Catch::Matchers::Contains("another hierarchy"));
        keep_error_table(some_table(), with, some, directory / name);
        CHECK(kept_error_table(with, some, directory / name));
    }
    CHECK(identity_of(open_pages<Splats, Triangle>(directory / "pages")) == identity_of(some));
}

TEST_CASE("what tables were measured with is told, and nothing else that is noted") {
    const Scene scene;
    Notes notes{{"errors", ""},        {"errors ", ""},      {"errors z", ""},      {"errors z 2x", ""},
                {"errors z 02x3", ""}, {"errors x 1 2", ""}, {"errors z 2x3 ", ""}, {"errors 9999999999x1", ""},
                {"other z 2x3", ""}};
    CHECK(error_tables_in(notes).empty());
    const std::vector<MeasuredWith> all{{"", 1, 2}, {"an x renderer", 640, 360}, {"z", 2, 3}};
    for (const MeasuredWith& each : all) keep_error_table(some_table(), each, scene.hierarchy, notes);
    CHECK(error_tables_in(notes) == all);
}
