// Of tolerances at several numbers of samples the cheapest that keeps the error is chosen.
#include "farfield/tuning/sampled_error_table.hpp"

#include <limits>
#include <random>
#include <stdexcept>
#include <utility>
#include <vector>

#include "catch.hpp"

using namespace farfield;

namespace {

using Reason = ToleranceReason;

/// Stand-ins cost the less, the coarser; samples divide what exact errs by.
SampledErrorTable three() {
    return SampledErrorTable({{1, 2, ErrorTable({{0, 0.06, 1}, {1, 0.05, 0.9}, {4, 0.08, 0.2}})},
                              {4, 3, ErrorTable({{0, 0.03, 1}, {1, 0.031, 0.8}, {4, 0.05, 0.3}})},
                              {16, 8, ErrorTable({{0, 0.01, 1}, {1, 0.02, 0.6}, {4, 0.05, 0.4}})}});
}

/// Draws nothing: errors and costs by rule.
struct Rules {
    std::vector<std::pair<float, int>> drawn{};
    double pixels = 100;

    double draw(std::size_t, float tolerance_px, int samples) {
        drawn.emplace_back(tolerance_px, samples);
        return double(samples) / (1 + double(tolerance_px));
    }
    SquaredError error(std::size_t) const {
        const double rmse = 0.1 / drawn.back().second + 0.01 * double(drawn.back().first);
        return {rmse * rmse * pixels, pixels};
    }
};

}  // namespace

TEST_CASE("more samples of coarser stand-ins are taken where they cost less than few of fine ones") {
    const SampleChoice choice = three().cheapest_for({0.055});
    CHECK(choice.samples == 4);
    CHECK(choice.tolerance.trial.tolerance_px == 4);
    CHECK(choice.cost == Approx(0.45));  // of exact at one sample
    CHECK(choice.tolerance.reason == Reason::pays);
    CHECK(three().at(1).tolerance_for({0.055}).trial.tolerance_px == 1);  // what a renderer of one sample draws

    View asked;
    asked.width = 7;
    asked.tolerance_px = 9;
    const View view = choice.applied_to(asked);
    CHECK(view.width == 7);
    CHECK(view.tolerance_px == 4);
    CHECK(view.wanted.samples == 4);
}

TEST_CASE("an error that no tolerance keeps is had by samples, and one that none keep is said to be impossible") {
    const SampleChoice fine = three().cheapest_for({0.02});
    CHECK(fine.samples == 16);
    CHECK(fine.tolerance.trial.tolerance_px == 1);
    const SampleChoice exact = three().cheapest_for({0.015});
    CHECK(exact.samples == 16);
    CHECK(exact.tolerance.is_exact());
    CHECK(exact.tolerance.keeps_error());
    CHECK(exact.cost == Approx(4));
    const SampleChoice none = three().cheapest_for({0.005});
    CHECK(!none.tolerance.keeps_error());
    CHECK(none.tolerance.reason == Reason::cannot_be_had);
    CHECK(none.tolerance.is_exact());
    CHECK(none.samples == 16);  // which errs least
}

TEST_CASE("point sampling is exact at the samples that were named") {
    CHECK(three().cheapest_for().tolerance.trial.rmse <= 0.06);
    CHECK(three().cheapest_for({.samples = 4}).tolerance.trial.rmse <= 0.03);
    CHECK(three().cheapest_for({.samples = 16}).tolerance.trial.rmse <= 0.01);
    CHECK_THROWS_AS(three().cheapest_for({.samples = 9}), std::invalid_argument);
    CHECK_THROWS_AS(three().at(9), std::invalid_argument);
}

TEST_CASE("of one number of samples a table chooses as that of tolerances alone") {
    std::mt19937 random(11);
    const auto unit = [&] { return double(random()) / double(std::mt19937::max()); };
    for (int round = 0; round < 200; ++round) {
        std::vector<ErrorsAtSamples> tables;
        for (const int samples : {1, 4, 16}) {
            std::vector<ToleranceTrial> trials{{0, 0.1 * unit() / samples, 1}};
            for (float px = 0.5f; px < 20; px *= 2) trials.push_back({px, 0.1 * unit(), 2 * unit()});
            tables.push_back({samples, unit() + 0.1, ErrorTable(std::move(trials))});
        }
        const SampledErrorTable all(tables);
        for (double wanted = 0.11; wanted > 0.0005; wanted *= 0.9) {
            const SampleChoice choice = all.cheapest_for({wanted});
            if (choice.tolerance.keeps_error()) CHECK(choice.tolerance.trial.rmse <= wanted);
            bool any_keeps = false;
            for (const ErrorsAtSamples& t : tables) {
                const SampleChoice alone = SampledErrorTable(t.table, t.samples).cheapest_for({wanted});
                const ToleranceChoice its = t.table.tolerance_for({wanted});
                CHECK(alone.tolerance.trial.tolerance_px == its.trial.tolerance_px);
                CHECK(alone.tolerance.reason == its.reason);
                if (!its.keeps_error()) continue;
                any_keeps = true;
                CHECK(choice.cost <= its.trial.cost * t.exact_cost / tables[0].exact_cost);
            }
            CHECK(choice.tolerance.keeps_error() == any_keeps);
        }
    }
}

TEST_CASE("what are no tables of samples is refused") {
    const ErrorTable table({{0, 0.1, 1}});
    const double infinity = std::numeric_limits<double>::infinity();
    const auto made = [](std::vector<ErrorsAtSamples> tables) { return SampledErrorTable(std::move(tables)); };
    CHECK_THROWS_AS(made({}), std::invalid_argument);
    CHECK_THROWS_AS(made({{0, 1, table}}), std::invalid_argument);
    CHECK_THROWS_AS(made({{4, 1, table}, {1, 1, table}}), std::invalid_argument);
    CHECK_THROWS_AS(made({{4, 1, table}, {4, 1, table}}), std::invalid_argument);
    CHECK_THROWS_AS(made({{1, 0, table}}), std::invalid_argument);
    CHECK_THROWS_AS(made({{1, infinity, table}}), std::invalid_argument);
    CHECK_THROWS_AS(three().cheapest_for({-1}), std::invalid_argument);
    CHECK(made({{4, 1, table}}).fewest_samples() == 4);
}

TEST_CASE("whatever draws is measured at all samples, in turns") {
    Rules rules;
    const int samples[] = {1, 4};
    const SampledErrorTable t =
        measure_sampled_error_table(rules, samples, 2, {.tolerances_px = {1, 2}, .repetitions = 2});
    REQUIRE(rules.drawn.size() == 2 * 2 * 3 * 2);
    CHECK(rules.drawn[2] == std::pair(2.0f, 1));
    CHECK(rules.drawn[3] == std::pair(0.0f, 4));
    REQUIRE(t.tables().size() == 2);
    CHECK(t.tables()[1].exact_cost == Approx(4 * t.tables()[0].exact_cost));
    CHECK(t.at(4).exact_rmse() == Approx(0.025));
    CHECK(t.at(4).trials()[1].rmse == Approx(0.035));
    CHECK(t.at(1).trials()[2].cost == Approx(1.0 / 3));
    Rules blind{.pixels = 0};
    CHECK(measure_sampled_error_table(blind, samples, 2).cheapest_for().tolerance.reason == Reason::nothing_tried);
    Rules unseen;
    CHECK(measure_sampled_error_table(unseen, samples, 0).tables()[1].table.trials().size() == 1);
}
