// Lazy masks: polygons in any order give what a z-buffer of every sample gives.
#include "farfield/coverage/a_buffer.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>
#include <vector>

#include "catch.hpp"
#include "support/masks.hpp"

using namespace farfield;
using namespace farfield::detail;
using namespace farfield::test;

namespace {
struct JitteredLazy : RecordedLazy<8> {
    static constexpr MaskSource masks = MaskSource::jittered;
};

/// Frames of one tiler an instruction set: nothing of an earlier one may be left.
template <class Traits>
class LazyCheck {
  public:
    LazyCheck() {
        for (const Simd simd : all_simd) frames_.emplace_back(simd);
    }
    void operator()(const SampleFrame& frame, const std::vector<TilePolygon>& polygons,
                    const JitterPatterns* patterns = nullptr) {
        BruteForce brute(frame);
        std::vector<bool> drew;
        for (const TilePolygon& p : polygons) drew.push_back(brute.draw_lazy(p, patterns) != 0);
        for (auto& f : frames_) {
            f.begin(frame);
            for (std::size_t i = 0; i < polygons.size(); ++i) {
                // Where something behind is not known to be, masks are z-buffered in vain: but what is seen is told.
                if (!f.tile(polygons[i]) && drew[i]) FAIL("polygon " << i << " was told not to be seen");
            }
            const std::size_t different = different_samples(f.end(), brute.colors());
            const std::string& error = Traits::samples::last_error;
            if (different != 0 || !error.empty()) {
                FAIL(frame.width_px << " x " << frame.height_px << ": " << different << " samples differ; " << error);
            }
        }
    }
    /// In the last frame.
    std::uint64_t masks_z_buffered() { return frames_[0].target().work.masks_z_buffered; }

  private:
    std::vector<TiledFrames<Traits>> frames_;
};

template <int side>
class Checked : public LazyCheck<RecordedLazy<side>> {};

float nearest(const TilePolygon& p) {
    return p.surface.depth.highest;
}

/// Some translucent, some of several colors, some as they are.
void vary(Random& random, std::vector<TilePolygon>& polygons) {
    for (TilePolygon& p : polygons) {
        Surface& s = p.surface;
        s.hash = std::uint32_t(random.bits());
        const std::uint32_t kind = random.below(4);
        if (kind == 0) {
            const auto alpha = std::uint8_t(random.below(256));
            for (Rgba8& c : s.colors) c.a = alpha;
        }
        if (kind == 1 && p.corners == 3) {
            for (Rgba8& c : s.colors) {
                c = random.color();
                if (random.below(3) == 0) c.a = std::uint8_t(random.below(256));
            }
            s.is_flat = false;
            s.color_weight = random.below(2) == 0 ? ColorWeight{1, 0} : ColorWeight{0, 1};
            if (s.color_weight.by_q != 0) {  // of what lies before the eye
                for (float& q : s.triangle.q) q = random.between(0.1f, 1);
            }
            s.has_gradient = false;
            s.need_gradient();
        }
        const bool is_opaque = s.colors[0].a == 255 && s.colors[1].a == 255 && s.colors[2].a == 255;
        s.kind = is_opaque ? SurfaceKind::opaque : SurfaceKind::translucent;
    }
}

/// Parallel to the screen, all over the image and beyond.
TilePolygon sheet(const SampleFrame& frame, float q, std::uint32_t number) {
    const std::int32_t x = 140 * frame.width(), y = 140 * frame.height();
    return tile_polygon({{-x, -y}, {x, -y}, {x, y}, {-x, y}}, {q, q, q}, numbered(number));
}
}  // namespace

TEMPLATE_TEST_CASE_SIG("lazy masks equal a z-buffer, in any order, on images of any size", "[coverage]",
                       ((int side), side), 1, 8) {
    Random random(700 + side);
    Checked<side> check;
    const std::vector<std::pair<int, int>> sizes =
        side == 1 ? std::vector<std::pair<int, int>>{{1, 1},   {7, 3},     {8, 8},     {64, 64},   {65, 63},
                                                     {200, 1}, {333, 200}, {512, 512}, {640, 360}, {7, 3}}
                  : std::vector<std::pair<int, int>>{{1, 1}, {7, 3}, {8, 8}, {9, 7}, {40, 33}, {8, 8}, {1, 1}};
    for (const auto& [width, height] : sizes) {
        const SampleFrame frame{width, height, side};
        for (const std::uint32_t count : {2u, 12u, 50u}) {
            std::vector<TilePolygon> polygons = random_polygons(random, frame, count);
            check(frame, polygons);
            vary(random, polygons);
            check(frame, polygons);
            const auto is_nearer = [](const auto& a, const auto& b) { return nearest(a) > nearest(b); };
            std::sort(polygons.begin(), polygons.end(), is_nearer);
            check(frame, polygons);
            std::reverse(polygons.begin(), polygons.end());
            check(frame, polygons);
        }
    }
}

TEST_CASE("lazy masks equal a z-buffer on very many small frames", "[coverage]") {
    Random random(710);
    Checked<1> points;
    Checked<8> pixels;
    for (int i = 0; i < 1200; ++i) {
        const int width = 1 + int(random.below(90)), height = 1 + int(random.below(90));
        const std::uint32_t count = 1 + random.below(20);
        const SampleFrame frame =
            i % 2 == 0 ? SampleFrame{width, height, 1} : SampleFrame{width / 8 + 1, height / 8 + 1, 8};
        std::vector<TilePolygon> polygons = random_polygons(random, frame, count);
        if (i % 3 == 0) vary(random, polygons);
        frame.side == 1 ? points(frame, polygons) : pixels(frame, polygons);
    }
}

TEST_CASE("what covers cells at once is drawn over, in front and behind, at every level", "[coverage]") {
    Random random(720);
    Checked<1> check;
    const SampleFrame frames[] = {{700, 530, 1}, {512, 512, 1}, {64, 64, 1}, {4200, 90, 1}};
    for (int round = 0; round < 24; ++round) {
        const SampleFrame& frame = frames[round % 4];
        std::vector<TilePolygon> polygons;
        for (std::uint32_t i = 0; i < 8; ++i) {
            const float q = random.between(0.3f, 0.7f);
            polygons.push_back(random.below(2) == 0 ? sheet(frame, q, 2 * i) : random_polygon(random, frame, 2 * i));
            polygons.push_back(random_polygon(random, frame, 2 * i + 1));
        }
        check(frame, polygons);
    }
}

TEST_CASE("polygons that overlap in a circle and go through each other", "[coverage]") {
    Random random(730);
    Checked<8> check;
    const SampleFrame frame{20, 20, 8};
    for (int round = 0; round < 20; ++round) {
        std::vector<TilePolygon> polygons;
        for (std::uint32_t i = 0; i < 6; ++i) {  // blades around the center, each over the next one
            const double turn = 1.0471975511965976 * (double(i) + 0.1 * round);
            const auto at = [&](double along, double across) {
                return ScreenPoint{std::int32_t(17000 * (along * std::cos(turn) - across * std::sin(turn))),
                                   std::int32_t(17000 * (along * std::sin(turn) + across * std::cos(turn)))};
            };
            const std::vector<ScreenPoint> corners = hull_of({at(-1, 0.1), at(1, 0.1), at(1, 0.5), at(-1, 0.5)});
            REQUIRE(corners.size() == 4);
            std::array<float, 3> q;
            for (std::size_t c = 0; c < 3; ++c) {
                q[c] =
                    0.5f + 2e-5f * float(double(corners[c].x) * std::cos(turn) + double(corners[c].y) * std::sin(turn));
            }
            polygons.push_back(tile_polygon(corners, q, numbered(i)));
        }
        for (std::uint32_t i = 6; i < 12; ++i) polygons.push_back(random_polygon(random, frame, i));
        random.shuffle(polygons);
        check(frame, polygons);
    }
}

TEST_CASE("of polygons at the same depth the larger color is seen, whichever comes first", "[coverage]") {
    Random random(740);
    Checked<8> check;
    for (int round = 0; round < 20; ++round) {
        const SampleFrame frame{3 + 3 * (round % 7), 9, 8};
        std::vector<TilePolygon> polygons = random_polygons(random, frame, 10);
        if (round % 2 == 0) polygons.push_back(sheet(frame, 0.5f, 99));
        const std::size_t count = polygons.size();
        for (std::size_t i = 0; i < count; ++i) {
            polygons.push_back(polygons[i]);
            polygons.back().surface.colors.fill(numbered(100 + std::uint32_t(i)));
            if (round % 4 == 1) polygons.push_back(polygons[i]);
        }
        check(frame, polygons);
        random.shuffle(polygons);
        check(frame, polygons);
    }
}

TEST_CASE("hundreds of layers in a pixel", "[coverage]") {
    Random random(750);
    for (const int side : {1, 8}) {
        const SampleFrame frame{side == 1 ? 9 : 2, side == 1 ? 8 : 1, side};
        Checked<1> points;
        Checked<8> pixels;
        for (int order = 0; order < 3; ++order) {
            std::vector<TilePolygon> polygons = random_polygons(random, frame, 600);
            if (order == 1) vary(random, polygons);
            if (order == 2) {
                for (std::uint32_t i = 0; i < 300; ++i) polygons.push_back(sheet(frame, 0.001f * float(i), 600 + i));
            }
            side == 1 ? points(frame, polygons) : pixels(frame, polygons);
        }
    }
}

TEST_CASE("a mask that shows too many surfaces is z-buffered, until something covers it", "[coverage]") {
    Random random(755);
    Checked<8> check;
    const SampleFrame frame{9, 9, 8};
    std::uint64_t z_buffered = 0;
    for (int round = 0; round < 6; ++round) {
        // Rows and columns of samples before a sheet, which go through each other: 64 fragments a mask.
        std::vector<TilePolygon> polygons{sheet(frame, 0.2f, 999)};
        for (std::uint32_t i = 0; i < 144; ++i) {
            const std::int32_t at = 256 * (frame.first_x() + std::int32_t(i) / 2), end = 40 * frame.width();
            const std::vector<ScreenPoint> corners =
                i % 2 == 0 ? std::vector<ScreenPoint>{{at, -end}, {at + 256, -end}, {at + 256, end}, {at, end}}
                           : std::vector<ScreenPoint>{{-end, at}, {end, at}, {end, at + 256}, {-end, at + 256}};
            std::array<float, 3> q;
            for (float& v : q) v = random.between(0.3f, 0.9f);
            polygons.push_back(tile_polygon(hull_of(corners), q, numbered(i)));
        }
        if (round % 2 == 1) vary(random, polygons);
        if (round >= 2) random.shuffle(polygons);
        if (round >= 4) {
            polygons.push_back(sheet(frame, 1e4f, 1000));  // nearer than all
            for (std::uint32_t i = 0; i < 20; ++i) polygons.push_back(random_polygon(random, frame, 1001 + i));
        }
        check(frame, polygons);
        z_buffered += check.masks_z_buffered();
    }
    CHECK(z_buffered > 0);
}

TEST_CASE("front to back nothing is z-buffered, and back to front no more than is hidden", "[coverage]") {
    Checked<8> check;
    const SampleFrame frame{64, 64, 8};
    std::vector<TilePolygon> sheets;
    for (std::uint32_t i = 0; i < 10; ++i) sheets.push_back(sheet(frame, 1 - 0.1f * float(i), i));
    check(frame, sheets);
    CHECK(check.masks_z_buffered() == 0);
    std::reverse(sheets.begin(), sheets.end());
    check(frame, sheets);
    CHECK(check.masks_z_buffered() <= 64 * 64);
}

TEST_CASE("jittered samples are z-buffered at the depth of their squares' centers", "[coverage]") {
    Random random(760);
    LazyCheck<JitteredLazy> check;
    const JitterPatterns patterns(LazyCoverage::jitter_patterns);
    for (int round = 0; round < 40; ++round) {
        const SampleFrame frame{1 + int(random.below(20)), 12, 8};
        check(frame, random_polygons(random, frame, 20), &patterns);
    }
}

TEMPLATE_TEST_CASE_SIG("what is said not to be seen changes no sample, wherever it comes", "[coverage]",
                       ((int side), side), 1, 8) {
    Random random(770 + side);
    int hidden = 0, seen = 0;
    for (const Simd simd : all_simd) {
        TiledFrames<RecordedLazy<side>> frames(simd);
        for (int round = 0; round < 80; ++round) {
            const int width = 1 + int(random.below(200)), height = 1 + int(random.below(200));
            const SampleFrame frame =
                side == 1 ? SampleFrame{width, height, 1} : SampleFrame{width / 8 + 1, height / 8 + 1, 8};
            frames.begin(frame);
            BruteForce brute(frame);
            for (std::uint32_t i = 0; i < 25; ++i) {
                const TilePolygon p = random_polygon(random, frame, i);
                frames.tile(p);
                brute.draw_lazy(p);
                TilePolygon q = random_polygon(random, frame, 1000 + i);
                if (frames.is_seen(q, q.surface.depth.highest, 0)) {
                    ++seen;
                } else {
                    ++hidden;
                    BruteForce with = brute;
                    if (with.draw_lazy(q) != 0) FAIL("round " << round << ", polygon " << i);
                }
            }
            if (different_samples(frames.end(), brute.colors()) != 0) FAIL("asking changed the picture");
        }
    }
    CHECK(std::min(hidden, seen) > 500);
}

TEST_CASE("plainly hidden is told: behind a wall, though not behind everything", "[coverage]") {
    const SampleFrame frame{40, 30, 8};
    for (const Simd simd : all_simd) {
        TiledFrames<RecordedLazy<8>> frames(simd);
        frames.begin(frame);
        const std::int32_t x = 100 * frame.width(), y = 100 * frame.height();
        frames.tile(tile_polygon({{-x, -y}, {x, -y}, {x, y}, {-x, y}}, {0.5f, 0.5f, 0.5f}, numbered(1)));
        const auto is_seen = [&](std::int32_t half, std::int32_t cx, std::int32_t cy, float q) {
            const TilePolygon p = tile_polygon(
                {{cx - half, cy - half}, {cx + half, cy - half}, {cx + half, cy + half}, {cx - half, cy + half}},
                {q, q, q}, numbered(2));
            return frames.is_seen(p, q, 8);
        };
        for (const std::int32_t half : {200, 3000, 16000, 23000}) {
            CHECK_FALSE(is_seen(half, 0, 0, 0.4f));
            CHECK_FALSE(is_seen(half, 77, 1001, 0.4f));
            CHECK(is_seen(half, 0, 0, 0.5f));
            CHECK(is_seen(half, 0, 0, 0.6f));
            CHECK(is_seen(half, x, 0, 0.4f));  // around the wall's edge
            CHECK(is_seen(half, x, y, 0.4f));
        }
        CHECK_FALSE(is_seen(300, 400 * frame.width(), 0, 0.9f));  // off the screen
    }
}

TEST_CASE("what a cell remembers: depths, fragments in lists, deep masks where they are", "[coverage]") {
    CoveragePyramid pyramid;
    ABuffer buffer;
    for (const auto& [width, height] : {std::pair{640, 360}, {64, 64}, {7, 3}, {640, 360}}) {
        pyramid.begin(width, height);
        buffer.begin(pyramid);
        const std::size_t top = pyramid.size() - 1;
        CHECK(buffer.cell(top).whole == no_subcells);
        for (unsigned k = 0; k < 64; ++k) {
            if ((pyramid.inside(top) >> k & 1) != 0) continue;
            CHECK(buffer.farthest(top).q[k] == std::numeric_limits<float>::infinity());
        }
        buffer.open(0, pyramid.inside(0));
        CHECK(buffer.cell(0).deep == no_subcells);
        CHECK(buffer.cell(0).list == ABuffer::none);

        for (std::uint32_t i = 0; i < 100; ++i) {
            Surface s;
            s.colors.fill({std::uint8_t(i), 0, 0, 255});
            s.depth = DepthPlane(float(i), 0, 0, 0, 100);
            s.is_flat = i % 3 != 0;
            CHECK(buffer.add(s) == i);
        }
        for (std::uint32_t i = 0; i < 100; ++i) {
            CHECK(buffer.record(i).depth.at_corner == float(i));
            CHECK(buffer.color(i).r == i);
            CHECK((buffer.details(i) == nullptr) == (i % 3 != 0));
            if (i % 3 == 0) CHECK(buffer.details(i)->colors[0].r == i);
        }

        std::uint32_t list = ABuffer::none;
        buffer.reserve_fragments(500);
        for (std::uint32_t i = 1; i <= 500; ++i) buffer.add_fragment(list, {i, i % 100, ABuffer::none, 0, 0});
        std::uint32_t left = 0;
        buffer.take(list, 1, [&](const ABuffer::Fragment&) { ++left; });  // every other one loses a bit, the first all
        CHECK(left == 499);
        std::uint32_t at = list;
        for (std::uint32_t i = 500; i > 1; --i, at = buffer.fragment(at).next) {
            REQUIRE(at != ABuffer::none);
            CHECK(buffer.fragment(at).bits == (i & ~1u));
            CHECK(buffer.fragment(at).surface == i % 100);
        }
        CHECK(at == ABuffer::none);
        buffer.unlink(list);
        CHECK(buffer.fragment(list).surface == 499 % 100);
        // What was given back is taken first: there is no room for more.
        buffer.add_fragment(list, {7, 1, ABuffer::none, 0, 0});
        buffer.add_fragment(list, {8, 2, ABuffer::none, 0, 0});
        CHECK(buffer.fragment(list).bits == 8);

        buffer.cell(0) = {};
        buffer.reserve_fragments(2);
        buffer.add_fragment(buffer.cell(0).list, {0b101, 11, ABuffer::none, 0, 0});
        buffer.add_fragment(buffer.cell(0).list, {0b010, 12, ABuffer::none, 0, 0});
        CHECK(buffer.surface_of_whole(0, 2) == 11);
        CHECK(buffer.surface_of_whole(0, 1) == 12);
        buffer.cell(0).whole = 0b111;
        CHECK(buffer.part_of_whole(0, 2) == 11);
        CHECK(buffer.cell(0).whole == 0b011);
        CHECK(buffer.part_of_whole(0, 1) == 12);
        CHECK(buffer.surface_of_whole(0, 0) == 11);

        const std::size_t masks = std::min<std::size_t>(64 * pyramid.block_count(), 600);
        std::vector<DeepMask*> deep;
        for (std::size_t i = 0; i < masks; ++i) {
            deep.push_back(&buffer.make_deep(masks - 1 - i));
            deep.back()->q[0] = float(i);
        }
        for (std::size_t i = 0; i < masks; ++i) {
            CHECK(&buffer.deep(masks - 1 - i) == deep[i]);  // they stay where they are
            CHECK(deep[i]->q[0] == float(i));
        }
        buffer.release_deep(3);
        CHECK(&buffer.make_deep(4) == deep[masks - 1 - 3]);
    }
}

TEST_CASE("what lies behind a z-buffered mask on the picture's border is hidden", "[coverage]") {
    // Masks that reach beyond the picture, of which only the samples inside are ever drawn.
    for (const auto& [width, height] : {std::pair{68, 68}, {131, 69}, {65, 200}}) {
        const SampleFrame frame{width, height, 1};
        const std::int32_t left = 256 * frame.first_x(), right = left + 256 * width, top = 256 * frame.first_y(),
                           bottom = top + 256 * height;
        // Two that pass through each other, and end where the picture does.
        const std::vector<ScreenPoint> corners{{left, top}, {right, top}, {right, bottom}, {left, bottom}};
        const TilePolygon one = tile_polygon(corners, {0.4f, 0.6f, 0.6f}, numbered(1));
        const TilePolygon other = tile_polygon(corners, {0.6f, 0.4f, 0.4f}, numbered(2));
        for (const Simd simd : all_simd) {
            TiledFrames<RecordedLazy<1>> frames(simd);
            for (int round = 0; round < 2; ++round) {
                frames.begin(frame);
                CHECK(frames.tile(one));
                CHECK(frames.tile(other));
                // All of it, and about the middle of the lower border, where they meet.
                const std::int32_t middle = left + 128 * width;
                const std::vector<ScreenPoint> border{{middle - 300, bottom - 600},
                                                      {middle + 300, bottom - 600},
                                                      {middle + 300, bottom},
                                                      {middle - 300, bottom}};
                for (const auto& outline : {corners, border}) {
                    const TilePolygon behind = tile_polygon(outline, {0.3f, 0.3f, 0.3f}, numbered(3));
                    CHECK_FALSE(frames.is_seen(behind, 0.3f, 0));
                    CHECK(frames.is_seen(behind, 0.7f, 0));
                    CHECK_FALSE(frames.tile(behind));
                }
                frames.end();
            }
        }
    }
}
