// Strict order: the first polygon that covers a sample is seen there, every sample comes once, and what is left is the
// background.
#include "farfield/coverage/tiler/coverage_tiler.hpp"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "catch.hpp"
#include "support/masks.hpp"

using namespace farfield;
using namespace farfield::detail;
using namespace farfield::test;

namespace {
struct TableStrict : RecordedStrict<8> {
    static constexpr MaskSource masks = MaskSource::table;
};
struct JitteredStrict : RecordedStrict<8> {
    static constexpr MaskSource masks = MaskSource::jittered;
};

/// Frames of one tiler: nothing of an earlier one may be left.
template <int side>
class StrictCheck {
  public:
    void operator()(const SampleFrame& frame, const std::vector<TilePolygon>& polygons) {
        BruteForce brute(frame);
        std::vector<bool> drew;
        for (const TilePolygon& p : polygons) drew.push_back(brute.draw_strict(p) != 0);
        for (auto& frames : frames_) {
            frames.begin(frame);
            for (std::size_t i = 0; i < polygons.size(); ++i) {
                if (frames.tile(polygons[i]) != drew[i]) FAIL("polygon " << i << " was told to be seen or not");
            }
            const std::size_t different = different_samples(frames.end(), brute.colors());
            const std::string& error = RecordedSamples<side>::last_error;
            if (different != 0 || !error.empty()) {
                FAIL(frame.width_px << " x " << frame.height_px << " at " << side << ": " << different
                                    << " samples differ; " << error);
            }
        }
    }

  private:
    std::array<TiledFrames<RecordedStrict<side>>, 4> frames_{
        TiledFrames<RecordedStrict<side>>(all_simd[0]), TiledFrames<RecordedStrict<side>>(all_simd[1]),
        TiledFrames<RecordedStrict<side>>(all_simd[2]), TiledFrames<RecordedStrict<side>>(all_simd[3])};
};

TilePolygon polygon(const std::vector<ScreenPoint>& corners, std::uint32_t number) {
    return tile_polygon(corners, {1, 1, 1}, numbered(number));
}

/// Triangles and quadrilaterals that cover the plane around the frame's center once: a grid whose inner corners moved.
std::vector<TilePolygon> mesh(Random& random, const SampleFrame& frame, int columns, int rows, bool on_samples) {
    const std::int32_t step_x = frame.width() * 256 / columns + 1, step_y = frame.height() * 256 / rows + 1;
    std::vector<ScreenPoint> at;
    for (int j = 0; j <= rows; ++j) {
        for (int i = 0; i <= columns; ++i) {
            const auto dx = std::int32_t(random.below(std::uint32_t(step_x / 3 + 1))) - step_x / 6;
            const auto dy = std::int32_t(random.below(std::uint32_t(step_y / 3 + 1))) - step_y / 6;
            ScreenPoint p{256 * frame.first_x() + i * step_x + (i == 0 || i == columns ? 0 : dx),
                          256 * frame.first_y() + j * step_y + (j == 0 || j == rows ? 0 : dy)};
            if (on_samples) p = {(p.x & ~255) + 128, (p.y & ~255) + 128};
            at.push_back(p);
        }
    }
    std::vector<TilePolygon> out;
    const auto add = [&](const std::vector<ScreenPoint>& corners) {
        const std::vector<ScreenPoint> hull = hull_of(corners);
        if (!hull.empty()) out.push_back(polygon(hull, std::uint32_t(out.size())));
    };
    for (int j = 0; j < rows; ++j) {
        for (int i = 0; i < columns; ++i) {
            const auto n = std::size_t(j * (columns + 1) + i);
            const std::vector<ScreenPoint> four{at[n], at[n + 1], at[n + std::size_t(columns) + 2],
                                                at[n + std::size_t(columns) + 1]};
            if (random.below(2) == 0 && hull_of(four).size() == 4) {
                add(four);
            } else {
                add({four[0], four[1], four[2]});
                add({four[0], four[2], four[3]});
            }
        }
    }
    return out;
}

/// Whether a corner lies in the square of the mask that a sample belongs to.
bool has_corner(const std::vector<TilePolygon>& polygons, const SampleFrame& frame, int x, int y) {
    const std::int32_t x0 = 256 * (x / 8 * 8 + frame.first_x()), y0 = 256 * (y / 8 * 8 + frame.first_y());
    for (const TilePolygon& p : polygons) {
        for (std::size_t c = 0; c < std::size_t(p.corners); ++c) {
            if (p.x[c] >= x0 && p.x[c] <= x0 + 2048 && p.y[c] >= y0 && p.y[c] <= y0 + 2048) return true;
        }
    }
    return false;
}

/// Hexagons, three of which meet in each corner, over the image and beyond.
std::vector<TilePolygon> honeycomb(Random& random, const SampleFrame& frame) {
    const double radius = 2000 + 8000 * double(random.unit()), turn = 6.28 * double(random.unit());
    const double skew = 0.3 * double(random.unit());
    std::vector<TilePolygon> out;
    const int count = int(256 * frame.width() / radius);
    for (int j = -count; j <= count; ++j) {
        for (int i = -count; i <= count; ++i) {
            std::vector<ScreenPoint> corners;
            for (int c = 0; c < 6; ++c) {
                // Corners in units that are whole numbers: shared ones come out the same.
                constexpr int dx[] = {2, 1, -1, -2, -1, 1}, dy[] = {0, 1, 1, 0, -1, -1};
                const double x = 0.5 * radius * (3 * i + dx[c]), y = 0.8660254 * radius * (2 * j + (i & 1) + dy[c]);
                corners.push_back({std::int32_t(std::lround(x * std::cos(turn) - y * std::sin(turn) + skew * y)),
                                   std::int32_t(std::lround(x * std::sin(turn) + y * std::cos(turn)))});
            }
            corners = hull_of(corners);
            if (!corners.empty()) out.push_back(polygon(corners, std::uint32_t(out.size())));
        }
    }
    return out;
}
}  // namespace

TEMPLATE_TEST_CASE_SIG("strict masks equal brute force, on images of any size, frame after frame", "[coverage]",
                       ((int side), side), 1, 8) {
    Random random(600 + side);
    StrictCheck<side> check;
    const std::vector<std::pair<int, int>> sizes =
        side == 1 ? std::vector<std::pair<int, int>>{{1, 1},   {7, 3},     {8, 8},     {64, 64},   {65, 63}, {1, 200},
                                                     {513, 9}, {333, 200}, {512, 512}, {640, 360}, {64, 64}, {7, 3}}
                  : std::vector<std::pair<int, int>>{{1, 1}, {7, 3}, {8, 8}, {9, 7}, {65, 63}, {8, 8}, {1, 1}};
    for (int round = 0; round < 3; ++round) {
        for (const auto& [width, height] : sizes) {
            const SampleFrame frame{width, height, side};
            for (const std::uint32_t count : {1u, 12u, 60u}) check(frame, random_polygons(random, frame, count));
        }
    }
}

TEST_CASE("strict masks equal brute force on very many small frames", "[coverage]") {
    Random random(610);
    StrictCheck<1> check;
    for (int i = 0; i < 2500; ++i) {
        const int width = 1 + int(random.below(90)), height = 1 + int(random.below(90));
        const std::uint32_t count = 1 + random.below(20);
        const SampleFrame frame{width, height, 1};
        check(frame, random_polygons(random, frame, count));
    }
}

TEST_CASE("strict masks equal brute force on more than 4096 samples a side", "[coverage]") {
    Random random(620);
    StrictCheck<1> check;
    for (const auto& [width, height] : {std::pair{4200, 70}, {70, 4200}, {5000, 520}}) {
        const SampleFrame frame{width, height, 1};
        check(frame, random_polygons(random, frame, 25));
    }
}

TEST_CASE("a mesh covers every sample once, whatever its order", "[coverage]") {
    Random random(630);
    StrictCheck<8> fine;
    StrictCheck<1> coarse;
    for (int round = 0; round < 6; ++round) {
        for (const int columns : {1, 3, 20, 90}) {
            const bool on_samples = round % 2 == 0;
            const SampleFrame frame{round < 3 ? 24 : 21, round < 3 ? 24 : 13, 8}, points{200, 150, 1};
            for (const SampleFrame& f : {frame, points}) {
                std::vector<TilePolygon> polygons = mesh(random, f, columns, 1 + columns / 2, on_samples);
                BruteForce brute(f);
                for (const TilePolygon& p : polygons) brute.draw_strict(p);
                for (int order = 0; order < 2; ++order) {
                    f.side == 8 ? fine(f, polygons) : coarse(f, polygons);
                    BruteForce other(f);
                    std::reverse(polygons.begin(), polygons.end());
                    for (const TilePolygon& p : polygons) other.draw_strict(p);
                    REQUIRE(brute.colors() == other.colors());
                }
            }
        }
    }
}

TEST_CASE("a gap of one sample between occluders stays", "[coverage]") {
    const SampleFrame frame{16, 16, 8};
    const std::int32_t left = 256 * frame.first_x(), right = -left, top = 256 * frame.first_y(), bottom = -top;
    for (const auto& [x, y] : {std::pair{0, 0}, {127, 127}, {63, 64}, {64, 63}, {9, 100}}) {
        const std::int32_t x0 = left + 256 * x, x1 = x0 + 256, y0 = top + 256 * y, y1 = y0 + 256;
        std::vector<TilePolygon> walls;
        if (x0 > left) walls.push_back(polygon({{left, top}, {x0, top}, {x0, bottom}, {left, bottom}}, 0));
        if (x1 < right) walls.push_back(polygon({{x1, top}, {right, top}, {right, bottom}, {x1, bottom}}, 1));
        if (y0 > top) walls.push_back(polygon({{x0, top}, {x1, top}, {x1, y0}, {x0, y0}}, 2));
        if (y1 < bottom) walls.push_back(polygon({{x0, y1}, {x1, y1}, {x1, bottom}, {x0, bottom}}, 3));
        for (const Simd simd : all_simd) {
            TiledFrames<RecordedStrict<8>> frames(simd);
            frames.begin(frame);
            for (const TilePolygon& p : walls) CHECK(frames.tile(p));
            const TilePolygon behind = polygon({{left, top}, {right, top}, {right, bottom}, {left, bottom}}, 4);
            CHECK(frames.is_seen(behind, 1, 0));
            CHECK(frames.tile(behind));
            CHECK_FALSE(frames.is_seen(behind, 1, 0));
            CHECK_FALSE(frames.tile(behind));
            const Image& image = frames.end();
            CHECK(std::count(image.pixels().begin(), image.pixels().end(), numbered(4)) == 1);
            CHECK(image.at(x, y) == numbered(4));
        }
    }
}

TEST_CASE("asking tells exactly whether tiling would draw, and changes nothing", "[coverage]") {
    Random random(640);
    std::array<std::array<int, 2>, 2> answers{};
    for (const Simd simd : all_simd) {
        TiledFrames<RecordedStrict<1>> frames(simd);
        for (int round = 0; round < 60; ++round) {
            const int width = 1 + int(random.below(300)), height = 1 + int(random.below(300));
            const SampleFrame frame{width, height, 1};
            frames.begin(frame);
            for (std::uint32_t i = 0; i < 25; ++i) {
                const TilePolygon p = random_polygon(random, frame, i);
                const bool answer = frames.is_seen(p, 1, 0);
                if (frames.tile(p) != answer) FAIL("round " << round << ", polygon " << i);
                ++answers[0][answer];
                // Grown, it is seen wherever it was.
                const TilePolygon q = random_polygon(random, frame, i);
                const bool grown = frames.is_seen(q, 1, 8);
                if (frames.is_seen(q, 1, 0) && !grown) FAIL("round " << round);
                ++answers[1][grown];
            }
            frames.end();
        }
    }
    for (const auto& count : answers) CHECK(std::min(count[0], count[1]) > 500);
}

TEST_CASE("an outline is grown by as much as it says, along both axes", "[coverage]") {
    // All covered but one sample: it is seen behind an outline that reaches into the square about its center.
    const SampleFrame frame{130, 130, 1};
    const std::int32_t left = 256 * frame.first_x(), right = -left, top = 256 * frame.first_y(), bottom = -top;
    Random random(645);
    std::array<int, 2> answers{};
    for (const Simd simd : all_simd) {
        TiledFrames<RecordedStrict<1>> frames(simd);
        for (int round = 0; round < 120; ++round) {
            const auto x = std::int32_t(10 + random.below(110)), y = std::int32_t(10 + random.below(110));
            const std::int32_t x0 = left + 256 * x, x1 = x0 + 256, y0 = top + 256 * y, y1 = y0 + 256;
            frames.begin(frame);
            frames.tile(polygon({{left, top}, {x0, top}, {x0, bottom}, {left, bottom}}, 0));
            frames.tile(polygon({{x1, top}, {right, top}, {right, bottom}, {x1, bottom}}, 1));
            frames.tile(polygon({{x0, top}, {x1, top}, {x1, y0}, {x0, y0}}, 2));
            frames.tile(polygon({{x0, y1}, {x1, y1}, {x1, bottom}, {x0, bottom}}, 3));
            const std::int32_t cx = x0 + 128, cy = y0 + 128;
            for (const int grown_by : {16, 100, 256, 700}) {
                // A line past the center, a polygon behind it; `off` is how far, along one axis or the other.
                const auto across = std::int32_t(1 + random.below(3000)), down = std::int32_t(1 + random.below(3000));
                const auto off = std::int32_t(random.below(std::uint32_t(3 * grown_by)));
                const std::int32_t ax = cx - across - off, ay = cy + down - off, bx = cx + across - off,
                                   by = cy - down - off;
                const TilePolygon behind = polygon({{ax, ay}, {ax, by}, {bx, by}}, 4);
                // E of the edge from a to b at the center, and what the square about it adds.
                const std::int64_t e = std::int64_t(off) * (across + down);
                const std::int64_t reach = std::int64_t(grown_by) * (across + down);
                if (e == reach || cx > bx + grown_by || cy > ay + grown_by) continue;
                const bool answer = frames.is_seen(behind, 1, grown_by);
                if (answer != (e < reach)) FAIL("grown by " << grown_by << ", " << off << " off");
                ++answers[answer];
            }
        }
    }
    CHECK(std::min(answers[0], answers[1]) > 200);
}

TEST_CASE("jittered samples are where they are, and a mesh covers each of them once", "[coverage]") {
    Random random(650);
    const JitterPatterns patterns(StrictCoverage::jitter_patterns);
    std::vector<TiledFrames<JitteredStrict>> frames;
    for (const Simd simd : all_simd) frames.emplace_back(simd);
    for (int round = 0; round < 40; ++round) {
        const SampleFrame frame{1 + int(random.below(20)), 12, 8};
        std::vector<TilePolygon> polygons =
            round % 2 == 0 ? random_polygons(random, frame, 20) : mesh(random, frame, 1 + round, 1 + round / 3, false);
        BruteForce brute(frame);
        for (const TilePolygon& p : polygons) brute.draw_strict(p, &patterns);
        if (round % 2 == 1) std::reverse(polygons.begin(), polygons.end());
        for (auto& f : frames) {
            REQUIRE(different_samples(f.draw(frame, polygons), brute.colors()) == 0);
            REQUIRE(JitteredStrict::samples::last_error == "");
        }
    }
}

TEST_CASE("of a table a mesh leaves gaps and overlaps at corners alone", "[coverage]") {
    Random random(660);
    std::vector<TiledFrames<TableStrict>> frames;
    for (const Simd simd : all_simd) frames.emplace_back(simd);
    std::size_t gaps = 0, overlaps = 0, wrong = 0, samples = 0;
    for (int round = 0; round < 30; ++round) {
        const SampleFrame frame{20, 20, 8};
        std::vector<TilePolygon> polygons = mesh(random, frame, 5 + round % 7, 5, round % 3 == 0);
        BruteForce brute(frame);
        for (const TilePolygon& p : polygons) brute.draw_strict(p);
        const Image forward = frames[0].draw(frame, polygons);
        for (auto& f : frames) {
            REQUIRE(f.draw(frame, polygons) == forward);
            REQUIRE(TableStrict::samples::last_error == "");
        }
        std::reverse(polygons.begin(), polygons.end());
        const Image backward = frames[0].draw(frame, polygons);
        for (int y = 0; y < frame.height(); ++y) {
            for (int x = 0; x < frame.width(); ++x) {
                const bool gap = forward.at(x, y).a == 0 && brute.is_covered(x, y);
                const bool overlap = forward.at(x, y) != backward.at(x, y);
                if ((gap || overlap) && !has_corner(polygons, frame, x, y))
                    FAIL("round " << round << ": " << x << ", " << y);
                gaps += gap, overlaps += overlap, ++samples;
                wrong += forward.at(x, y) != brute.colors()[frame.at(x, y)];
            }
        }
    }
    CAPTURE(gaps, overlaps, wrong);
    CHECK(wrong > 0);  // it is quantized
    CHECK(wrong * 200 < samples);
}

TEST_CASE("of a table one corner in hundreds leaves a sample to none of three polygons", "[coverage]") {
    Random random(665);
    TiledFrames<TableStrict> frames(Simd::automatic);
    const SampleFrame frame{32, 32, 8};
    std::size_t gaps = 0, corners = 0;
    for (int round = 0; round < 60; ++round) {
        std::vector<TilePolygon> polygons = honeycomb(random, frame);
        BruteForce brute(frame);
        for (const TilePolygon& p : polygons) brute.draw_strict(p);
        const Image& image = frames.draw(frame, polygons);
        for (int y = 0; y < frame.height(); ++y) {
            for (int x = 0; x < frame.width(); ++x) gaps += image.at(x, y).a == 0 && brute.is_covered(x, y) ? 1u : 0u;
        }
        corners += 2 * polygons.size();
    }
    CAPTURE(gaps, corners);
    CHECK(gaps * 350 < corners);
}

TEST_CASE("of a table two halves of the plane leave no gap and no overlap", "[coverage]") {
    Random random(670);
    std::vector<TiledFrames<TableStrict>> frames;
    for (const Simd simd : all_simd) frames.emplace_back(simd);
    const SampleFrame frame{19, 13, 8};
    const std::int32_t far = 1 << 21;
    for (int round = 0; round < 150; ++round) {
        // A line through the image from border to border of a square around it.
        const std::int32_t a = std::int32_t(random.below(2u << 20)) - (1 << 20),
                           b = std::int32_t(random.below(2u << 20)) - (1 << 20);
        const std::int32_t left = a / (round % 5 == 0 ? 4096 : 64), right = b / (round % 5 == 0 ? 4096 : 64);
        std::vector<TilePolygon> halves;
        if (round % 2 == 0) {
            halves.push_back(polygon({{-far, -far}, {far, -far}, {far, right}, {-far, left}}, 0));
            halves.push_back(polygon({{-far, left}, {far, right}, {far, far}, {-far, far}}, 1));
        } else {
            halves.push_back(polygon({{-far, -far}, {right, -far}, {left, far}, {-far, far}}, 0));
            halves.push_back(polygon({{right, -far}, {far, -far}, {far, far}, {left, far}}, 1));
        }
        const Image forward = frames[0].draw(frame, halves);
        REQUIRE(std::count(forward.pixels().begin(), forward.pixels().end(), Rgba8{0, 0, 0, 0}) == 0);
        for (auto& f : frames) REQUIRE(f.draw(frame, halves) == forward);
        std::swap(halves[0], halves[1]);
        REQUIRE(frames[0].draw(frame, halves) == forward);
    }
}
