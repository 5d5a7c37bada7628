// The table's answers keep the error that is wanted, fall with it, and are exact where nothing else pays.
#include "farfield/tuning/error_table.hpp"

#include <cmath>
#include <limits>
#include <random>
#include <stdexcept>
#include <tuple>
#include <utility>
#include <vector>

#include "catch.hpp"

using namespace farfield;

namespace {

using Reason = ToleranceReason;

ErrorTable table(std::vector<ToleranceTrial> trials) {
    return ErrorTable(std::move(trials));
}

/// Draws nothing: errors and costs by rule.
struct Rules {
    double exact_cost = 10;
    double pixels = 100;
    std::vector<float> drawn;

    double draw(std::size_t, float tolerance_px) {
        drawn.push_back(tolerance_px);
        return tolerance_px > 0 ? exact_cost / (1 + double(tolerance_px)) : exact_cost;
    }
    SquaredError error(std::size_t view) const {
        const double rmse = drawn.back() > 0 ? 0.01 * double(drawn.back()) : 0.025;
        return {rmse * rmse * pixels * double(view + 1), pixels * double(view + 1)};
    }
};

}  // namespace

TEST_CASE("the largest tolerance that keeps the error and pays is chosen") {
    const ErrorTable t = table({{0, 0.04, 1}, {1, 0.02, 1.5}, {2, 0.03, 0.6}, {4, 0.039, 0.3}, {8, 0.08, 0.1}});
    CHECK(t.exact_rmse() == 0.04);
    const ToleranceChoice as_points = t.tolerance_for();
    CHECK(as_points.trial.tolerance_px == 4);
    CHECK(as_points.trial.cost == 0.3);
    CHECK(as_points.reason == Reason::pays);
    CHECK(as_points.keeps_error());
    CHECK(!as_points.is_exact());
    CHECK(t.tolerance_for({0.03}).trial.tolerance_px == 2);
    CHECK(t.tolerance_for({0.079}).trial.tolerance_px == 4);
    CHECK(t.tolerance_for({1}).trial.tolerance_px == 8);
}

TEST_CASE("a coarse tolerance that is right by luck is not taken") {
    const ErrorTable t = table({{0, 0.02, 1}, {1, 0.021, 0.9}, {2, 0.05, 0.5}, {4, 0.03, 0.2}});
    CHECK(t.tolerance_for({0.03}).trial.tolerance_px == 1);
    CHECK(t.tolerance_for({0.05}).trial.tolerance_px == 4);
}

TEST_CASE("exact is chosen where nothing pays, and says why") {
    const ToleranceChoice dear = table({{0, 0.04, 1}, {1, 0.02, 3}, {2, 0.03, 0.99}, {4, 0.08, 0.2}}).tolerance_for();
    CHECK(dear.is_exact());
    CHECK(dear.reason == Reason::nothing_pays);
    CHECK(dear.trial.cost == 1);
    const ToleranceChoice wrong = table({{0, 0.01, 1}, {1, 0.02, 0.5}}).tolerance_for();
    CHECK(wrong.is_exact());
    CHECK(wrong.reason == Reason::nothing_keeps);
    CHECK(wrong.keeps_error());
    const ToleranceChoice untried = table({{0, 0, 1}}).tolerance_for();
    CHECK(untried.is_exact());
    CHECK(untried.reason == Reason::nothing_tried);
    // Half a percent is noise, unless the table is told that it is not.
    CHECK(ErrorTable({{0, 0.04, 1}, {2, 0.03, 0.99}}, 0.005).tolerance_for().reason == Reason::pays);
}

TEST_CASE("less than exact's own error is had where a tolerance errs less, and else said to be impossible") {
    const ErrorTable t = table({{0, 0.04, 1}, {1, 0.02, 1.5}, {2, 0.03, 0.6}});
    CHECK(t.tolerance_for({0.03}).reason == Reason::pays);
    const ToleranceChoice only = t.tolerance_for({0.02});
    CHECK(only.reason == Reason::only_way);
    CHECK(only.trial.tolerance_px == 1);
    const ToleranceChoice none = t.tolerance_for({0.01});
    CHECK(none.reason == Reason::cannot_be_had);
    CHECK(none.is_exact());
    CHECK(!none.keeps_error());
    CHECK(!table({{0, 0.04, 1}}).tolerance_for({0.01}).keeps_error());
}

TEST_CASE("the less error is wanted, the less is chosen") {
    std::mt19937 random(7);
    const auto unit = [&] { return double(random()) / double(std::mt19937::max()); };
    for (int round = 0; round < 200; ++round) {
        std::vector<ToleranceTrial> trials{{0, 0.1 * unit(), 1}};
        for (float px = 0.5f; px < 20; px *= 2) trials.push_back({px, 0.1 * unit(), 2 * unit()});
        const ErrorTable t = table(trials);
        float last_px = 1000;
        for (double wanted = 0.11; wanted > 0.0005; wanted *= 0.97) {
            const ToleranceChoice choice = t.tolerance_for({wanted});
            if (!choice.keeps_error()) continue;
            CHECK(choice.trial.rmse <= wanted);
            if (choice.reason != Reason::pays) continue;
            CHECK(choice.trial.tolerance_px <= last_px);
            CHECK(choice.trial.cost < 1);
            last_px = choice.trial.tolerance_px;
        }
    }
}

TEST_CASE("tables that are none and errors below 0 are refused") {
    const double nan = std::numeric_limits<double>::quiet_NaN();
    CHECK_THROWS_AS(table({}), std::invalid_argument);
    CHECK_THROWS_AS(table({{1, 0.1, 1}}), std::invalid_argument);
    CHECK_THROWS_AS(table({{0, 0.1, 1}, {2, 0.1, 1}, {1, 0.1, 1}}), std::invalid_argument);
    CHECK_THROWS_AS(table({{0, nan, 1}}), std::invalid_argument);
    CHECK_THROWS_AS(table({{0, 0.1, 1}, {1, 0.1, -1}}), std::invalid_argument);
    CHECK_THROWS_AS(ErrorTable({{0, 0.1, 1}}, 1), std::invalid_argument);
    CHECK_THROWS_AS(table({{0, 0.1, 1}}).tolerance_for({-0.1}), std::invalid_argument);
    CHECK_THROWS_AS(table({{0, 0.1, 1}}).tolerance_for({nan}), std::invalid_argument);
}

TEST_CASE("a ladder has two steps an octave") {
    const std::vector<float> ladder = tolerance_ladder(0.25f, 16);
    REQUIRE(ladder.size() == 13);
    CHECK(ladder.front() == 0.25f);
    CHECK(ladder[2] == 0.5f);
    CHECK(ladder.back() == 16);
    CHECK(tolerance_ladder(1, 1).size() == 1);
    CHECK(tolerance_ladder(2, 1).empty());
    CHECK(tolerance_ladder(0, 1).empty());
    CHECK(tolerance_ladder(1, std::numeric_limits<float>::infinity()).size() > 200);
}

TEST_CASE("errors and costs of whatever draws are pooled over views") {
    Rules rules;
    const ErrorTable t = measure_error_table(rules, 3, {.tolerances_px = {1, 2, 4}, .repetitions = 2});
    CHECK(rules.drawn.size() == 3 * 4 * 2);
    REQUIRE(t.trials().size() == 4);
    CHECK(t.exact_rmse() == Approx(0.025));
    CHECK(t.trials()[2].rmse == Approx(0.02));
    CHECK(t.trials()[2].cost == Approx(1.0 / 3));
    CHECK(t.tolerance_for().trial.tolerance_px == 2);
}

TEST_CASE("without views, pixels or costs nothing but exact is in the table") {
    for (const auto& [views, pixels, cost] : {std::tuple{0, 100.0, 10.0}, {2, 0.0, 10.0}, {2, 100.0, 0.0}}) {
        Rules rules{.exact_cost = cost, .pixels = pixels, .drawn = {}};
        const ErrorTable t = measure_error_table(rules, std::size_t(views));
        CHECK(t.trials().size() == 1);
        CHECK(t.tolerance_for().is_exact());
        CHECK(t.tolerance_for().reason == Reason::nothing_tried);
    }
}
