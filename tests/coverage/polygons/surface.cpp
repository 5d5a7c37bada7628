// Colors and hashed samples of a surface are those that ZBufferRenderer gives single samples.
#include "farfield/coverage/polygons/surface.hpp"

#include <bit>
#include <cmath>

#include "catch.hpp"
#include "support/random.hpp"

using namespace farfield;
using namespace farfield::detail;
using namespace farfield::test;

namespace {
Surface random_surface(Random& random, bool is_flat) {
    Surface s;
    while (true) {
        for (int c = 0; c < 3; ++c) {
            s.triangle.x[c] = std::int32_t(random.below(20000)) - 10000;
            s.triangle.y[c] = std::int32_t(random.below(20000)) - 10000;
            s.triangle.q[c] = random.between(0.1f, 1);
        }
        if (s.triangle.doubled_area() < 0) s.triangle.flip();
        if (s.triangle.doubled_area() != 0) break;
    }
    s.depth = DepthPlane(s.triangle, s.triangle.doubled_area());
    s.color_weight = random.below(2) == 0 ? ColorWeight{1, 0} : ColorWeight{0, 1};
    s.is_flat = is_flat;
    s.kind = SurfaceKind::translucent;
    s.hash = std::uint32_t(random.bits());
    for (Rgba8& c : s.colors) {
        c = random.color();
        c.a = std::uint8_t(random.below(256));
    }
    if (is_flat) s.colors.fill(s.colors[0]);
    s.gradient = ColorGradient(s.triangle, s.colors, s.color_weight);
    return s;
}
Rgba8 opaque(Rgba8 c) {
    return {c.r, c.g, c.b, 255};
}
}  // namespace

TEST_CASE("a sample's color is the plane's through the corners; alpha is spent", "[coverage]") {
    Random random(820);
    for (int i = 0; i < 2000; ++i) {
        const Surface s = random_surface(random, false);
        const Rgba8 corners[3] = {s.colors[0], s.colors[1], s.colors[2]};
        const ColorPlane plane(s.triangle, s.triangle.doubled_area(), s.color_weight);
        const int x = int(random.below(80)) - 40, y = int(random.below(80)) - 40;
        CHECK(s.seen_color_at(x, y) == opaque(plane.at(x, y, corners)));
        CHECK(s.seen_color_of_pixel(x, y) == opaque(s.gradient.pixel(float(x) + 4, float(y) + 4)));
    }
}

TEST_CASE("a flat surface has its color everywhere; the background keeps its alpha", "[coverage]") {
    Random random(821);
    Surface s = random_surface(random, true);
    CHECK(s.seen_color() == opaque(s.colors[0]));
    CHECK(s.seen_color_at(3, -7) == s.seen_color());
    CHECK(s.seen_color_of_pixel(300, 7) == s.seen_color());
    s.kind = SurfaceKind::background;
    CHECK(s.seen_color() == s.colors[0]);
    CHECK(s.seen_color_at(3, -7) == s.colors[0]);
}

TEST_CASE("hashed samples are those of the z-buffer's hash, alpha of 256 of them", "[coverage]") {
    Random random(822);
    double expected = 0, count = 0;
    for (int i = 0; i < 3000; ++i) {
        const Surface s = random_surface(random, i % 2 == 0);
        const Rgba8 corners[3] = {s.colors[0], s.colors[1], s.colors[2]};
        const ColorPlane plane(s.triangle, s.triangle.doubled_area(), s.color_weight);
        const int x = 8 * (int(random.below(80)) - 40), y = 8 * (int(random.below(80)) - 40);
        for (const bool shades_samples : {false, true}) {
            const std::uint64_t mask = s.hashed_samples(x, y, shades_samples);
            for (int k = 0; k < 64; ++k) {
                const int sx = x + k % 8, sy = y + k / 8;
                const Rgba8 color =
                    shades_samples ? plane.at(sx, sy, corners) : s.gradient.pixel(float(x) + 4, float(y) + 4);
                const std::uint8_t alpha = s.is_flat ? s.colors[0].a : color.a;
                const bool is_covered = alpha == 255 || covered_by_hash(sx, sy, s.hash, alpha);
                if ((mask >> k & 1) != is_covered) FAIL("surface " << i << ", sample " << k);
                expected += alpha / 256.0;
            }
            count += std::popcount(mask);
        }
    }
    CHECK(std::abs(count / expected - 1) < 0.01);
}

TEST_CASE("alpha of 0 covers nothing, of 255 everything", "[coverage]") {
    Random random(823);
    Surface s = random_surface(random, true);
    for (Rgba8& c : s.colors) c.a = 0;
    CHECK(s.hashed_samples(8, 16, false) == 0);
    for (Rgba8& c : s.colors) c.a = 255;
    CHECK(s.hashed_samples(8, 16, false) == ~std::uint64_t(0));
}

TEST_CASE("of a part of the far field the number of samples is exact, but for rounding that evens out", "[coverage]") {
    Random random(824);
    for (std::size_t n = 0; n <= 64; ++n) CHECK(std::size_t(std::popcount(detail::first_samples[n])) == n);
    for (int alpha = 0; alpha < 256; ++alpha) {
        double sum = 0;
        std::uint64_t every = 0;
        for (int i = 0; i < 400; ++i) {
            Surface s = random_surface(random, true);
            s.kind = SurfaceKind::fraction;
            for (Rgba8& c : s.colors) c.a = std::uint8_t(alpha);
            const int x = 8 * (int(random.below(80)) - 40), y = 8 * (int(random.below(80)) - 40);
            const std::uint64_t mask = s.hashed_samples(x, y, false);
            CHECK(s.hashed_samples(x, y, false) == mask);
            const double exact = alpha * 64 / 255.0;
            if (std::abs(std::popcount(mask) - exact) >= 1) FAIL("alpha " << alpha);
            sum += std::popcount(mask) - exact;
            every |= mask;
        }
        if (std::abs(sum / 400) > 0.12) FAIL("alpha " << alpha << ": " << sum / 400);
        if (alpha > 8) CHECK(every == ~std::uint64_t(0));  // masks are turned
    }
}
