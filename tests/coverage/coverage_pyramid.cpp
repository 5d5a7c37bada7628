// Images of any size: what lies beyond the border is covered from the start, and nothing else is.
#include "farfield/coverage/coverage_pyramid.hpp"

#include <algorithm>
#include <bit>
#include <utility>

#include "catch.hpp"

using namespace farfield;

namespace {
constexpr std::pair<int, int> sizes[] = {{1, 1},   {7, 3},     {8, 8},     {9, 8},    {64, 64},    {65, 63}, {1, 200},
                                         {513, 9}, {512, 512}, {640, 360}, {4096, 1}, {4097, 513}, {64, 64}};

/// Whether any sample of subcell k of a cell lies inside the image.
bool is_inside(const CoveragePyramid& p, int level, int x, int y, int k) {
    const int step = 1 << 3 * level;
    return (8 * x + k % 8) * step < p.width_samples() && (8 * y + k / 8) * step < p.height_samples();
}
}  // namespace

TEST_CASE("levels end with one cell, and cells beyond the border are covered", "[coverage]") {
    CoveragePyramid pyramid;
    for (const auto& [width, height] : sizes) {
        CAPTURE(width, height);
        pyramid.begin(width, height);
        REQUIRE(pyramid.width_samples() == width);
        REQUIRE(pyramid.height_samples() == height);
        const int top = pyramid.top_level();
        REQUIRE(top >= 1);
        CHECK(pyramid.columns(top) == 1);
        CHECK(pyramid.rows(top) == 1);
        CHECK((top == 1 || pyramid.columns(top - 1) > 1 || pyramid.rows(top - 1) > 1));
        std::size_t next = 0;
        bool all_right = true;
        for (int level = 1; level <= top; ++level) {
            const int side = 8 << 3 * level;
            CHECK(pyramid.columns(level) == (width + side - 1) / side);
            CHECK(pyramid.rows(level) == (height + side - 1) / side);
            for (int y = 0; y < pyramid.rows(level); ++y) {
                for (int x = 0; x < pyramid.columns(level); ++x, ++next) {
                    const std::size_t at = pyramid.index(level, x, y);
                    all_right = all_right && at == next;
                    std::uint64_t inside = 0;
                    for (int k = 0; k < 64; ++k) inside |= std::uint64_t(is_inside(pyramid, level, x, y, k)) << k;
                    all_right = all_right && pyramid.inside(at) == inside && pyramid.is_untouched(at) &&
                                pyramid[at] == TriageMask{~inside, inside} && pyramid.is_covered(at) == (inside == 0);
                }
            }
            if (level == 1) CHECK(pyramid.block_count() == next);
        }
        CHECK(all_right);
        CHECK(pyramid.size() == next);
        for (int y = 0; y < pyramid.rows(0); y += std::max(1, pyramid.rows(0) - 1)) {
            for (int x = 0; x < pyramid.columns(0); ++x) {
                std::uint64_t inside = 0;
                for (int k = 0; k < 64; ++k) inside |= std::uint64_t(is_inside(pyramid, 0, x, y, k)) << k;
                if (pyramid.samples_outside(x, y) != ~inside) FAIL(x << ", " << y);
            }
        }
    }
}

TEST_CASE("a new frame forgets the one before", "[coverage]") {
    CoveragePyramid pyramid;
    for (const auto& [width, height] : sizes) {
        for (int frame = 0; frame < 2; ++frame) {
            pyramid.begin(width, height);
            for (std::size_t at = 0; at < pyramid.size(); ++at) {
                if (!pyramid.is_untouched(at)) FAIL(width << ", " << height << ": " << at);
                pyramid[at] = {all_subcells, no_subcells};
                if (pyramid.is_untouched(at) && pyramid.inside(at) != 0) FAIL(width << ", " << height << ": " << at);
            }
        }
    }
}

TEST_CASE("a cell is untouched while it says no more than that it is vacant", "[coverage]") {
    CoveragePyramid pyramid;
    pyramid.begin(65, 63);
    CHECK(pyramid.is_untouched(1));
    pyramid[1].vacant &= pyramid[1].vacant - 1;
    CHECK_FALSE(pyramid.is_untouched(1));
    CHECK(pyramid.is_untouched(0));
    pyramid[0].covered = pyramid.inside(0) & (~pyramid.inside(0) + 1);
    pyramid[0].vacant &= ~pyramid[0].covered;
    CHECK_FALSE(pyramid.is_untouched(0));
    CHECK_FALSE(pyramid.is_covered(0));
    pyramid[0] = {all_subcells, no_subcells};
    CHECK(pyramid.is_covered(0));
}

TEST_CASE("each block has 64 masks of its own", "[coverage]") {
    CoveragePyramid pyramid;
    pyramid.begin(130, 70);
    REQUIRE(pyramid.block_count() == 6);
    for (std::size_t block = 0; block < 6; ++block) std::fill_n(pyramid.samples_of_block(block), 64, block + 1);
    const CoveragePyramid& same = pyramid;
    for (std::size_t block = 0; block < 6; ++block) {
        CHECK(std::count(same.samples_of_block(block), same.samples_of_block(block) + 64, block + 1) == 64);
    }
}

TEST_CASE("memory: one bit a sample, and 2/63 for the masks above", "[coverage]") {
    CoveragePyramid pyramid;
    pyramid.begin(8 * 512, 8 * 512);
    const double bits_a_sample = 8 * double(pyramid.bytes()) / (4096.0 * 4096.0);
    CHECK(pyramid.bytes() == 4096 * 4096 / 8 + 16 * (64 * 64 + 8 * 8 + 1));
    CHECK(bits_a_sample <= 1 + 2.0 / 63);
    CHECK(bits_a_sample > 1 + 2.0 / 63 - 1e-5);
}
