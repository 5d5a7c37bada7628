#include "farfield/build/build_control.hpp"

#include <algorithm>
#include <vector>

#include "catch.hpp"

using namespace farfield;
using farfield::detail::BuildControl;

TEST_CASE("every step is run once, in slices after which progress is told") {
    for (const std::size_t count : {0u, 1u, 15u, 16u, 17u, 1000u, 12345u}) {
        for (const bool has_executor : {false, true}) {
            std::vector<int> runs(count);
            std::vector<BuildProgress> told;
            AnyExecutor executor;
            if (has_executor) executor = ThreadExecutor(3);
            const ProgressCallback progress = [&](const BuildProgress& p) {
                CHECK(std::size_t(std::count(runs.begin(), runs.end(), 1)) == p.done);
                told.push_back(p);
                return true;
            };
            BuildControl(executor, progress).run(BuildPhase::sampling, count, [&](std::size_t i) { ++runs[i]; });
            CHECK(std::all_of(runs.begin(), runs.end(), [](int n) { return n == 1; }));
            CHECK(told.size() <= 101);
            CHECK(told.empty() == (count == 0));
            for (const BuildProgress& p : told) CHECK((p.phase == BuildPhase::sampling && p.total == count));
            if (!told.empty()) CHECK(told.back().done == count);
        }
    }
}

TEST_CASE("who does not listen is told nothing, and one call runs all") {
    std::size_t calls = 0, steps = 0;
    const AnyExecutor executor = [&](std::size_t count, const std::function<void(std::size_t)>& f) {
        ++calls;
        for (std::size_t i = 0; i < count; ++i) f(i);
    };
    const ProgressCallback nobody;
    const BuildControl control(executor, nobody);
    control.run(BuildPhase::splitting, 5000, [&](std::size_t) { ++steps; });
    CHECK((calls == 1 && steps == 5000));
    CHECK_NOTHROW(control.report(BuildPhase::splitting, 0, 1));
}

TEST_CASE("after a callback says no, no step is run") {
    std::size_t steps = 0, calls = 0;
    const AnyExecutor executor;
    const ProgressCallback twice = [&](const BuildProgress&) { return ++calls < 2; };
    const BuildControl control(executor, twice);
    CHECK_THROWS_AS(control.run(BuildPhase::splitting, 1000, [&](std::size_t) { ++steps; }), BuildCanceled);
    CHECK(calls == 2);
    CHECK(steps == 20);
    CHECK_THROWS_AS(control.report(BuildPhase::splitting, 1, 2), BuildCanceled);
    // What is too small to be told runs all the same.
    control.run_quietly(10, [&](std::size_t) { ++steps; });
    CHECK(steps == 30);
}
