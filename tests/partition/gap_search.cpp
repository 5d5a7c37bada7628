#include "farfield/partition/gap_search.hpp"

#include <limits>

#include "catch.hpp"
#include "support/random.hpp"

using namespace farfield;
using namespace farfield::test;
using farfield::detail::Extent;
using farfield::detail::Gap;
using farfield::detail::GapSearch;

namespace {

constexpr float price_of_split = 4;
using Extents = std::vector<Extent>;

/// What a plane does, counted one by one.
struct Sides {
    std::size_t behind = 0, in_front = 0, crossed = 0;
    double weight_behind = 0, weight_crossed = 0, weight = 0;

    double price() const {
        if (behind == 0 || in_front == 0) return std::numeric_limits<double>::infinity();
        const double share = (weight_behind + 0.5 * weight_crossed) / weight;
        return (1 + double(price_of_split) * double(crossed)) / (4 * share * (1 - share));
    }
};
Sides sides_of(const Extents& things, float at) {
    Sides s;
    for (const Extent& e : things) {
        s.weight += double(e.weight);
        if (e.upper <= at) {
            ++s.behind;
            s.weight_behind += double(e.weight);
        } else if (e.lower >= at) {
            ++s.in_front;
        } else {
            ++s.crossed;
            s.weight_crossed += double(e.weight);
        }
    }
    return s;
}
double least_price(const Extents& things) {
    double least = std::numeric_limits<double>::infinity();
    for (const Extent& e : things) least = std::min(least, sides_of(things, e.upper).price());
    return least;
}
Gap best(const Extents& things, float most_active = 1) {
    return GapSearch(price_of_split, most_active).best(things);
}
/// The gap is what it says.
void check(const Extents& things, const Gap& gap) {
    REQUIRE(gap.is_found());
    const Sides sides = sides_of(things, gap.at);
    CHECK(sides.behind > 0);
    CHECK(sides.in_front > 0);
    CHECK(sides.crossed == gap.active);
    CHECK(double(gap.price) == Approx(sides.price()).epsilon(1e-5));
}

Extents random_extents(std::size_t count, std::uint64_t seed, float length, bool on_a_grid = false) {
    Random random(seed);
    Extents out;
    for (std::size_t i = 0; i < count; ++i) {
        const float at = on_a_grid ? float(random.below(40)) : 40 * random.unit();
        const float size = on_a_grid ? float(random.below(2)) : length * random.unit();
        out.push_back({at, at + size, 1 + random.unit(), false});
    }
    return out;
}

}  // namespace

TEST_CASE("of few things the best gap is found") {
    for (std::uint64_t seed = 1; seed <= 60; ++seed) {
        for (const std::size_t count : {2u, 3u, 7u, 30u, 90u}) {
            const Extents things = random_extents(count, seed, seed % 3 == 0 ? 20.0f : 2.0f, seed % 4 == 0);
            const double least = least_price(things);
            const Gap gap = best(things);
            INFO(count << " things, seed " << seed);
            REQUIRE(gap.is_found() == (least < std::numeric_limits<double>::infinity()));
            if (!gap.is_found()) continue;
            check(things, gap);
            CHECK(double(gap.price) == Approx(least).epsilon(1e-5));
        }
    }
}

TEST_CASE("of many things a gap is found that is about as good as the best") {
    for (std::uint64_t seed = 1; seed <= 12; ++seed) {
        for (const std::size_t count : {100u, 800u, 6000u}) {
            const Extents things = random_extents(count, seed, seed % 3 == 0 ? 4.0f : 0.02f, seed % 4 == 0);
            INFO(count << " things, seed " << seed);
            const Gap gap = best(things);
            check(things, gap);
            CHECK(double(gap.price) <= 1.5 * least_price(things));
        }
    }
    INFO("bins are of no use where nearly everything is in one of them");
    Extents things = random_extents(3000, 5, 0.5f);
    things.push_back({1e9f, 1e9f, 1, false});
    check(things, best(things));
}

TEST_CASE("what touches is a gap, of two things and of a grid of many") {
    for (const int count : {2, 50, 4096}) {
        Extents things;
        for (int i = 0; i < count; ++i) things.push_back({float(i), float(i + 1), 1, false});
        const Gap gap = best(things);
        check(things, gap);
        CHECK(gap.active == 0);
        CHECK(gap.at == float(count / 2));
    }
}

TEST_CASE("planes pass through the middle of a gap") {
    const Gap gap = best({{0, 1, 1, false}, {3, 4, 1, false}});
    CHECK(gap.at == 2);
    CHECK(gap.length == 4);
    const float next = std::nextafter(1.0f, 2.0f);
    const Extents close{{0, 1, 1, false}, {next, 4, 1, false}};
    check(close, best(close));
}

TEST_CASE("weights, not numbers, are balanced") {
    Extents things;
    for (int i = 0; i < 9; ++i) things.push_back({float(2 * i), float(2 * i + 1), i == 8 ? 8.0f : 1.0f, false});
    CHECK(best(things).at == 15.5f);
    INFO("nothing weighs anything: numbers");
    for (Extent& e : things) e.weight = 0;
    CHECK(std::abs(best(things).at - 8.5f) <= 1.0f);
}

TEST_CASE("nothing is found where nothing is apart") {
    CHECK_FALSE(best({}).is_found());
    CHECK_FALSE(best({{0, 1, 1, false}}).is_found());
    for (const std::size_t count : {2u, 500u}) {
        CHECK_FALSE(best(Extents(count, {0, 1, 1, false})).is_found());
        CHECK_FALSE(best(Extents(count, {3, 3, 1, false})).is_found());
        INFO("all overlap");
        Extents nested;
        for (std::size_t i = 0; i < count; ++i) nested.push_back({-float(i + 1), float(i + 1), 1, false});
        CHECK_FALSE(best(nested).is_found());
    }
    INFO("things without extent lie behind a plane through them");
    const Extents points{{0, 0, 1, false}, {0, 0, 1, false}, {0, 1, 1, false}};
    check(points, best(points));
}

TEST_CASE("no plane crosses what blocks, or more than the allowed share") {
    // Three in a row, the middle one under a long one.
    Extents things{{0, 1, 1, false}, {2, 3, 1, false}, {4, 5, 1, false}, {0.5f, 3.5f, 1, true}};
    const Gap gap = best(things);
    check(things, gap);
    CHECK(gap.at == 3.75f);
    things.push_back({3.2f, 4.5f, 1, true});
    CHECK_FALSE(best(things).is_found());
    for (Extent& e : things) e.blocks = false;
    CHECK(best(things).is_found());
    CHECK_FALSE(best(things, 0.1f).is_found());
}

TEST_CASE("a search can be used again") {
    GapSearch search(price_of_split, 1);
    for (const std::size_t count : {5000u, 3u, 0u, 700u, 4000u}) {
        const Extents things = random_extents(count, count, 0.3f);
        CHECK(search.best(things).price == best(things).price);
        CHECK(search.best(things).at == best(things).at);
    }
}
