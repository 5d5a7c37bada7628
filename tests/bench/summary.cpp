#include "../../bench/accuracy/chart/summary.hpp"

#include <limits>

#include "../../bench/accuracy/chart/equal_error_table.hpp"
#include "catch.hpp"

using namespace farfield;
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
    row.time_ms = 10 / speedup;
    return row;
}

const std::vector<Row> rows{
    measured("exact", 1, {}, 0.12, 1),    measured("exact", 4, {}, 0.06, 0.5), measured("exact", 16, {}, 0.03, 0.2),
    measured("cube", 1, 0.5, 0.04, 1.5),  measured("cube", 1, 1, 0.05, 3),     measured("cube", 1, 2, 0.09, 9),
    measured("cube", 4, 1, 0.01, 1),      measured("cube", 4, 4, 0.045, 2),    measured("thin", 1, 0.5, 0.04, 2),
    measured("thin", 1, 1, 0.06, 3),      measured("thin", 1, 2, 0.049, 1.8),  measured("never", 1, 0.5, 0.2, 50),
    measured("masks", 64, {}, 0.02, 0.8),
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

TEST_CASE("a variant stands at the largest tolerance that keeps the error and pays, an error that is met included") {
    const EqualErrorChoice cube = at_equal_error(all(), "cube", &Row::rmse, 0.05);
    REQUIRE(cube.row);
    CHECK(cube.reason == ToleranceReason::pays);
    CHECK(cube.row->tolerance_px == 1);
    CHECK(cube.row->samples == 1);
    // A coarse tolerance that is right by luck is not taken: a finer one errs more than is wanted.
    const EqualErrorChoice thin = at_equal_error(all(), "thin", &Row::rmse, 0.05);
    REQUIRE(thin.row);
    CHECK(thin.row->tolerance_px == 0.5);
    CHECK(at_equal_error(all(), "cube", &Row::rmse).row->tolerance_px == 2);  // exact's own error, 0.12
    // The largest tolerance, not the fastest row: time is measured, and the fastest of many would be luck.
    CHECK(at_equal_error(all(), "thin", &Row::rmse).row->tolerance_px == 2);
}

TEST_CASE("more samples are taken where they are needed or faster, and what has no tolerance has a place, too") {
    const EqualErrorChoice cube = at_equal_error(all(), "cube", &Row::rmse, 0.02);
    REQUIRE(cube.row);
    CHECK(cube.reason == ToleranceReason::only_way);
    CHECK(cube.row->samples == 4);
    const EqualErrorChoice masks = at_equal_error(all(), "masks", &Row::rmse, 0.05);
    REQUIRE(masks.row);
    CHECK(masks.reason == ToleranceReason::only_way);
    CHECK(masks.row->samples == 64);
    CHECK(exact_within(all(), &Row::rmse, 0.05)->samples == 16);
    CHECK(exact_within(all(), &Row::rmse, std::nullopt)->samples == 1);
    CHECK_FALSE(exact_within(all(), &Row::rmse, 0.001));
}

TEST_CASE("exact is drawn where nothing pays or no other keeps the error, and nothing where exact does not keep it") {
    CHECK(at_equal_error(all(), "masks", &Row::rmse).reason == ToleranceReason::nothing_pays);
    CHECK(at_equal_error(all(), "masks", &Row::rmse).row == &rows[0]);
    CHECK(at_equal_error(all(), "never", &Row::rmse).reason == ToleranceReason::nothing_keeps);
    CHECK(at_equal_error(all(), "never", &Row::rmse).row == &rows[0]);
    CHECK(at_equal_error(all(), "never", &Row::rmse, 0.05).reason == ToleranceReason::cannot_be_had);
    CHECK_FALSE(at_equal_error(all(), "never", &Row::rmse, 0.05).row);
    CHECK_FALSE(at_equal_error(all(), "nobody", &Row::rmse, 0.05).row);
    CHECK_FALSE(at_equal_error(all(), "cube", &Row::flip, 0.05).row);
}

TEST_CASE("what is not a number or not finite, as a file may have it, takes no part") {
    std::vector<Row> broken = rows;
    for (const double bad : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(), -1.0}) {
        broken.push_back(measured("bad", 1, 1, bad, 2));
        broken.push_back(measured("bad", 1, 1, 0.01, bad));
    }
    broken.push_back(measured("bad", 1, 1, 0.01, 0));
    CHECK_FALSE(at_equal_error(by_view(broken, "accuracy").front().rows, "bad", &Row::rmse).row);
}

TEST_CASE("the table has two lines for each view and a dash where nothing keeps the error") {
    const Table table = equal_error_table(rows, &Row::rmse, 0.05);
    const auto texts = [&](std::size_t line) {
        std::vector<std::string> result;
        for (const TableCell& cell : table.rows[line]) result.push_back(cell.text);
        return result;
    };
    REQUIRE(table.rows.size() == 3);
    CHECK(texts(0) ==
          std::vector<std::string>{"scene", "view", "error at most", "exact", "cube", "thin", "never", "masks"});
    CHECK(texts(1) == std::vector<std::string>{"tree", "7 radii", "0.12 (exact's own)", "10 ms, 1x", "2 px: 1.1 ms, 9x",
                                               "2 px: 5.6 ms, 1.8x", "exact: none keeps it", "exact: nothing pays"});
    CHECK(texts(2) == std::vector<std::string>{"tree", "7 radii", "0.05", "16 samples: 50 ms, 0.2x", "1 px: 3.3 ms, 3x",
                                               "0.5 px: 5 ms, 2x", "-", "64 samples: 12 ms, 0.8x"});
    CHECK(table.rows[1][4].row == &rows[5]);
    CHECK_FALSE(table.rows[2][6].row);
    CHECK(equal_error_table({}, &Row::rmse, 0.05).rows.size() == 1);
}
