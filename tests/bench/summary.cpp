#include "../../bench/accuracy/chart/summary.hpp"

#include "../../bench/accuracy/chart/equal_error_table.hpp"
#include "catch.hpp"

using namespace farfield::bench;

namespace {

Row measured(const char* variant, double samples, Row::Number tolerance_px, double rmse, double speedup) {
    Row row;
    row.chart = "accuracy";
    row.scene = "tree";
    row.view = "7 radii";
    row.variant = variant;
    row.samples = samples;
    row.tolerance_px = tolerance_px;
    row.rmse = rmse;
    row.speedup = speedup;
    return row;
}

const std::vector<Row> rows{
    measured("exact", 1, {}, 0.12, 1),   measured("exact", 4, {}, 0.06, 0.5), measured("exact", 16, {}, 0.03, 0.2),
    measured("cube", 1, 0.5, 0.04, 1.5), measured("cube", 1, 1, 0.05, 3),     measured("cube", 1, 2, 0.09, 9),
    measured("cube", 4, 1, 0.01, 1),     measured("cube", 4, 4, 0.045, 2),    measured("thin", 1, 0.5, 0.04, 2),
    measured("thin", 1, 1, 0.06, 3),     measured("thin", 1, 2, 0.049, 1.8),  measured("never", 1, 0.5, 0.2, 50),
};

std::vector<const Row*> all() {
    return by_view(rows, "accuracy").front().rows;
}

}  // namespace

TEST_CASE("rows are grouped by scene and view, in order of appearance") {
    std::vector<Row> mixed(5);
    const char* scenes[] = {"b", "a", "b", "b", "a"};
    const char* views[] = {"1", "1", "2", "1", "1"};
    for (std::size_t i = 0; i < 5; ++i) {
        mixed[i].chart = i == 4 ? "growth" : "accuracy";
        mixed[i].scene = scenes[i];
        mixed[i].view = views[i];
    }
    const std::vector<ViewGroup> groups = by_view(mixed, "accuracy");
    REQUIRE(groups.size() == 3);
    CHECK(groups[0].rows == std::vector<const Row*>{&mixed[0], &mixed[3]});
    CHECK(groups[1].scene == "a");
    CHECK(groups[2].view == "2");
    CHECK(by_view(mixed, "growth").size() == 1);
    CHECK(by_view(mixed, "other").empty());
}

TEST_CASE("a variant stands at the largest tolerance that keeps the bound, a bound that is met included") {
    const Row* cube = fastest_within(all(), "cube", &Row::rmse, 0.05);
    REQUIRE(cube);
    CHECK(cube->tolerance_px == 1);
    CHECK(cube->samples == 1);
    // The largest tolerance, not the fastest row: time is measured, and the fastest of many would be luck.
    const Row* thin = fastest_within(all(), "thin", &Row::rmse, 0.05);
    REQUIRE(thin);
    CHECK(thin->tolerance_px == 2);
    CHECK_FALSE(fastest_within(all(), "never", &Row::rmse, 0.05));
    CHECK_FALSE(fastest_within(all(), "nobody", &Row::rmse, 0.05));
    CHECK_FALSE(fastest_within(all(), "cube", &Row::flip, 0.05));
}

TEST_CASE("where more samples are needed they are taken") {
    const Row* exact = fastest_within(all(), "exact", &Row::rmse, 0.05);
    REQUIRE(exact);
    CHECK(exact->samples == 16);
    const Row* cube = fastest_within(all(), "cube", &Row::rmse, 0.02);
    REQUIRE(cube);
    CHECK(cube->samples == 4);
}

TEST_CASE("at equal error both keep the bound") {
    const Row* exact = fastest_within(all(), "exact", &Row::rmse, 0.05);
    CHECK(*speedup_at_equal_error(fastest_within(all(), "cube", &Row::rmse, 0.05), exact) == Approx(15));
    CHECK_FALSE(speedup_at_equal_error(nullptr, exact));
    CHECK_FALSE(speedup_at_equal_error(exact, nullptr));
}

TEST_CASE("the table has a line for each view and a dash where nothing keeps the bound") {
    const Table table = equal_error_table(rows, &Row::rmse, 0.05);
    REQUIRE(table.rows.size() == 2);
    CHECK(table.rows[0] ==
          std::vector<std::string>{"scene", "view", "exact at 1: error", "exact: samples", "cube", "thin", "never"});
    CHECK(table.rows[1] ==
          std::vector<std::string>{"tree", "7 radii", "0.12", "16", "1 px: 3x (15x)", "2 px: 1.8x (9x)", "-"});
    CHECK(equal_error_table({}, &Row::rmse, 0.05).rows.size() == 1);
}
