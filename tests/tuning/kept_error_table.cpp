#include "farfield/tuning/error_table_file.hpp"

#include <initializer_list>
#include <numbers>
#include <stdexcept>
#include <string>
#include <vector>

#include "catch.hpp"
#include "farfield/approximation/color_cube.hpp"
#include "farfield/approximation/color_cube_cluster.hpp"
#include "farfield/build.hpp"
#include "farfield/cost_model/triangle_count.hpp"
#include "farfield/partition/octree.hpp"
#include "farfield/primitive/triangle.hpp"
#include "storage/files.hpp"

using namespace farfield;

namespace {

using Hierarchy = SpatialHierarchy<Octree, ColorCube, TriangleCount>;

std::vector<Triangle> triangles(int count) {
    std::vector<Triangle> result;
    for (int i = 0; i < count; ++i) {
        const glm::vec3 a(i % 7, i % 5, i % 3);
        result.push_back({{a, a + glm::vec3(0.1f, 0, 0), a + glm::vec3(0, 0.1f, 0.1f)}, {90, 90, 90}});
    }
    return result;
}

struct TableFile {
    Hierarchy hierarchy = build<Hierarchy>(triangles(400));
    TemporaryDirectory directory;

    std::filesystem::path path() const { return directory / "table"; }
    std::string text() const {
        const Bytes bytes = read_file(path());
        return {bytes.begin(), bytes.end()};
    }
    std::string head() const { return identity() + "samples 1 1\nleast_saving 0.05\n"; }
    std::string identity() const { return "version 2\nhierarchy " + HierarchyIdentity::of(hierarchy).as_text() + "\n"; }
    /// What read_error_table() says, after the file's name.
    std::string refusal(const std::string& contents) const {
        write_file(path(), Bytes(contents.begin(), contents.end()));
        try {
            read_error_table(hierarchy, path());
            return {};
        } catch (const std::runtime_error& e) {
            const std::string start = "farfield::read_error_table: " + path().string() + ":", what = e.what();
            return what.substr(0, start.size()) == start ? what.substr(start.size()) : "NO NAME: " + what;
        }
    }
};

}  // namespace

TEST_CASE("an error table comes back from its file to the last bit, and chooses the same") {
    const TableFile file;
    const ErrorTable one({{0, 0.1, 1}, {0.25f, 1.0 / 3, 0.7}, {std::numbers::sqrt2_v<float>, 1e-300, 0.1}}, 0.125);
    const SampledErrorTable table({{1, 1, one}, {9, 8.0 / 3, ErrorTable({{0, 0.05, 1}, {2, 0.06, 0.1}})}});
    write_error_table(table, file.hierarchy, file.path());
    const SampledErrorTable back = read_error_table(file.hierarchy, file.path());
    REQUIRE(back.tables().size() == 2);
    for (std::size_t t = 0; t < 2; ++t) {
        const auto &its = back.tables()[t], &expected = table.tables()[t];
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
    for (const double wanted : {0.06, 0.1, 0.5}) {
        CHECK(back.cheapest_for({wanted}).samples == table.cheapest_for({wanted}).samples);
    }
    CHECK(file.text().find("samples 9 2.6666666666666665\n") != std::string::npos);
    CHECK(file.text().find("0.25 0.3333333333333333 0.7\n") != std::string::npos);
}

TEST_CASE("the table of another hierarchy is refused, and what is no table, with its line") {
    const TableFile file;
    CHECK(file.refusal(file.head() + "0 0.1 1\n").empty());
    CHECK(file.refusal("# mine\r\n\n" + file.head() + "0 0.1 1\r\n").empty());
    CHECK(file.refusal("version 2\nhierarchy 1 2 3 4\n").find("2: it was measured for another hierarchy") == 0);
    CHECK(file.refusal(file.head() + "0 0.1\n") == "5: expected a number, found ''");
    CHECK(file.refusal(file.head() + "0 much 1\n") == "5: expected a number, found 'much'");
    CHECK(file.refusal(file.head() + "0 0.1 1 2\n") == "5: '2' is too much");
    CHECK(file.refusal(file.head() + "nonsense\n") == "5: expected a number, found 'nonsense'");
    CHECK(file.refusal("version 2\nsamples 1 1\nleast_saving 0.05\n0 0.1 1\n") ==
          " does not say of which hierarchy it is");
    CHECK(file.refusal(file.head()).find(" tolerances must ascend from 0") == 0);
    CHECK(file.refusal(file.head() + "0 0.1 1\n2 0.1 1\n1 0.1 1\n").find(" tolerances must ascend") == 0);
    CHECK(file.refusal(file.head() + "0 nan 1\n").find(" tolerances must ascend") == 0);
    CHECK(file.refusal(file.identity() + "samples 1 1\n0 0.1 1\n")
              .find(" tolerances must ascend from 0, errors and costs be 0 or more, and the least saving") == 0);
    CHECK(file.refusal(file.identity() + "0 0.1 1\n") == "3: '0' comes before any number of samples");
    CHECK(file.refusal(file.identity()).find(" there must be a table") == 0);
    CHECK(file.refusal(file.head() + "0 0.1 1\nsamples 1 1\nleast_saving 0\n0 0.1 1\n").find(" there must be") == 0);
    CHECK_THROWS_AS(read_error_table(file.hierarchy, file.directory / "none"), std::runtime_error);
    CHECK_THROWS_AS(
        write_error_table(SampledErrorTable(ErrorTable({{0, 0, 1}})), file.hierarchy, file.directory.path()),
        std::runtime_error);
}

TEST_CASE("error tables of another version are refused, and what they know is not guessed") {
    const TableFile file;
    const std::string old =
        "# farfield\nhierarchy " + HierarchyIdentity::of(file.hierarchy).as_text() + "\nleast_saving 0.05\n0 0.1 1\n";
    CHECK(file.refusal(old) == "2: it is of version 1, which knew no numbers of samples; measure it again");
    CHECK(file.refusal("version 3\n") == "1: it is of version 3, and this library reads version 2");
    CHECK(file.refusal("version\n") == "1: expected a number, found ''");
    CHECK(file.refusal("nonsense\n") == "1: expected 'version', found 'nonsense'");
    CHECK(!file.refusal("").empty());
}

TEST_CASE("a table of a scene's hierarchies together is that of all of them, in their order") {
    const TemporaryDirectory directory;
    const auto several = [](std::initializer_list<int> counts) {
        HierarchyIdentity identity;
        for (const int count : counts) identity.add(HierarchyIdentity::of(build<Hierarchy>(triangles(count))));
        return identity;
    };
    const SampledErrorTable table(ErrorTable({{0, 0.1, 1}, {2, 0.2, 0.5}}), 4);
    write_error_table(table, several({300, 400}), directory / "table");
    CHECK(read_error_table(several({300, 400}), directory / "table").at(4).trials().size() == 2);
    for (const auto& counts : {several({300}), several({400, 300}), several({300, 401}), several({300, 400, 400})}) {
        CHECK_THROWS_AS(read_error_table(counts, directory / "table"), std::runtime_error);
    }
    using Cells = SpatialHierarchy<Octree, ColorCubeCluster<4>, TriangleCount>;
    HierarchyIdentity other = HierarchyIdentity::of(build<Cells>(triangles(400)));
    const HierarchyIdentity cubes = HierarchyIdentity::of(build<Hierarchy>(triangles(400)));
    other.cells = cubes.cells;
    other.stand_ins = cubes.stand_ins;
    CHECK(other.fingerprint == cubes.fingerprint);
    CHECK(other.as_text() != cubes.as_text());
}
