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
    std::string head() const {
        return "hierarchy " + HierarchyIdentity::of(hierarchy).as_text() + "\nleast_saving 0.05\n";
    }
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
    const ErrorTable table({{0, 0.1, 1}, {0.25f, 1.0 / 3, 0.7}, {std::numbers::sqrt2_v<float>, 1e-300, 0.1}}, 0.125);
    write_error_table(table, file.hierarchy, file.path());
    const ErrorTable back = read_error_table(file.hierarchy, file.path());
    REQUIRE(back.trials().size() == 3);
    for (std::size_t i = 0; i < 3; ++i) {
        CHECK(back.trials()[i].tolerance_px == table.trials()[i].tolerance_px);
        CHECK(back.trials()[i].rmse == table.trials()[i].rmse);
        CHECK(back.trials()[i].cost == table.trials()[i].cost);
    }
    CHECK(back.least_saving() == 0.125);
    CHECK(file.text().find("0.25 0.3333333333333333 0.7\n") != std::string::npos);
}

TEST_CASE("the table of another hierarchy is refused, and what is no table, with its line") {
    const TableFile file;
    CHECK(file.refusal(file.head() + "0 0.1 1\n").empty());
    CHECK(file.refusal("# mine\r\n\n" + file.head() + "0 0.1 1\r\n").empty());
    CHECK(file.refusal("hierarchy 1 2 3 4\n").find("1: it was measured for another hierarchy") == 0);
    CHECK(file.refusal(file.head() + "0 0.1\n") == "3: expected a number, found ''");
    CHECK(file.refusal(file.head() + "0 much 1\n") == "3: expected a number, found 'much'");
    CHECK(file.refusal(file.head() + "0 0.1 1 2\n") == "3: '2' is too much");
    CHECK(file.refusal(file.head() + "nonsense\n") == "3: expected a number, found 'nonsense'");
    CHECK(file.refusal("least_saving 0.05\n0 0.1 1\n") == " does not say of which hierarchy it is");
    CHECK(file.refusal(file.head()).find(" tolerances must ascend from 0") == 0);
    CHECK(file.refusal(file.head() + "0 0.1 1\n2 0.1 1\n1 0.1 1\n").find(" tolerances must ascend") == 0);
    CHECK(file.refusal(file.head() + "0 nan 1\n").find(" tolerances must ascend") == 0);
    CHECK(file.refusal("hierarchy " + HierarchyIdentity::of(file.hierarchy).as_text() + "\n0 0.1 1\n")
              .find(" tolerances must ascend from 0, errors and costs be 0 or more, and the least saving") == 0);
    CHECK_THROWS_AS(read_error_table(file.hierarchy, file.directory / "none"), std::runtime_error);
    CHECK_THROWS_AS(write_error_table(ErrorTable({{0, 0, 1}}), file.hierarchy, file.directory.path()),
                    std::runtime_error);
}

TEST_CASE("a table of a scene's hierarchies together is that of all of them, in their order") {
    const TemporaryDirectory directory;
    const auto several = [](std::initializer_list<int> counts) {
        HierarchyIdentity identity;
        for (const int count : counts) identity.add(HierarchyIdentity::of(build<Hierarchy>(triangles(count))));
        return identity;
    };
    const ErrorTable table({{0, 0.1, 1}, {2, 0.2, 0.5}});
    write_error_table(table, several({300, 400}), directory / "table");
    CHECK(read_error_table(several({300, 400}), directory / "table").trials().size() == 2);
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
