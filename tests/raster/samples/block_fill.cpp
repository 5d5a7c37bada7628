// Triangles in blocks against the loop that one writes first: each covered sample, one after the other.
#include "farfield/raster/samples/block_fill.hpp"

#include <bit>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "catch.hpp"
#include "farfield/raster/samples/depth_tested_fill.hpp"
#include "farfield/raster/triangles/triangle_painter.hpp"
#include "support/random.hpp"

using namespace farfield;
using namespace farfield::detail;
using namespace farfield::test;

namespace {

SampleProjection image_of(int first_x, int first_y, int end_x, int end_y) {
    SampleProjection to;
    to.first_x = first_x;
    to.first_y = first_y;
    to.end_x = end_x;
    to.end_y = end_y;
    return to;
}

/// What DepthTestedFill is to do.
struct OneByOne {
    const SampleProjection& image;
    std::vector<float> depth;
    std::vector<Rgba8> color;

    explicit OneByOne(const SampleProjection& to)
        : image(to),
          depth(std::size_t(width() * (to.end_y - to.first_y)), -std::numeric_limits<float>::infinity()),
          color(depth.size()) {}
    int width() const { return image.end_x - image.first_x; }

    template <class Shade>
    void fill(const SnappedTriangle& t, std::int64_t doubled_area, const Shade& shade) {
        const DepthPlane plane(t, doubled_area);
        scan_convert(t, image, [&](int y, int begin, int end) {
            for (int x = begin; x < end; ++x) {
                const auto at = std::size_t((y - image.first_y) * width() + x - image.first_x);
                const float q = plane.at(plane.row(y), x);
                if (q < depth[at]) continue;
                Rgba8 c = shade(x, y);
                if (c.a == 0) continue;
                c.a = 255;
                const bool is_less = std::bit_cast<std::uint32_t>(c) <= std::bit_cast<std::uint32_t>(color[at]);
                if (q == depth[at] && is_less) continue;
                depth[at] = q;
                color[at] = c;
            }
        });
    }
};

}  // namespace

TEST_CASE("triangles of all sizes, one upon the other, give the samples of a plain loop at every width", "[raster]") {
    Random random(791);
    int surfaces = 0;
    for (int round = 0; round < 60; ++round) {
        const int left = int(random.below(20)), top = int(random.below(20)), right = 1 + int(random.below(50)),
                  bottom = 1 + int(random.below(40));
        const SampleProjection image = image_of(-left, -top, right, bottom);
        OneByOne expected(image);
        constexpr Simd widths[] = {Simd::scalar, Simd::four_lanes, Simd::eight_lanes};
        SampleBuffers buffers[3];
        for (SampleBuffers& b : buffers) b.begin(image, 1, Rgba8{0, 0, 0, 0});
        for (int i = 0; i < 80; ++i) {
            const std::int32_t reach = std::int32_t(1) << (6 + random.below(16));
            // Layers at equal depth, flat ones, tilted ones; around the picture or far beyond it.
            const float flat = float(random.below(4)) * 0.25f;
            const bool is_flat = random.below(3) == 0;
            const auto near_x = std::int32_t(random.below(64 * 256)) - 20 * 256;
            const auto near_y = std::int32_t(random.below(64 * 256)) - 20 * 256;
            SnappedTriangle t;
            for (int c = 0; c < 3; ++c) {
                const auto within = [&](std::int32_t middle) {
                    const auto v = middle + std::int32_t(random.below(2 * std::uint32_t(reach))) - reach;
                    return std::clamp(v, -(1 << 22) + 1, (1 << 22) - 1);
                };
                t.x[c] = within(near_x);
                t.y[c] = within(near_y);
                t.q[c] = is_flat ? flat : random.unit();
            }
            if (t.doubled_area() < 0) t.flip();
            const std::int64_t area = t.doubled_area();
            if (area == 0) continue;
            Rgba8 corners[3] = {random.color(), random.color(), random.color()};
            const auto kind = random.below(4);  // one color; translucent; several colors; several, translucent
            for (Rgba8& c : corners) {
                if (kind < 2) c = corners[0];
                c.a = kind % 2 == 0 ? std::uint8_t(255) : std::uint8_t(random.below(256));
            }
            if (kind == 1) corners[1].a = corners[2].a = corners[0].a;
            int prepared = 0;
            const auto draw = [&](auto&& with) {
                if (kind == 0) return with(OneColor{corners[0]}, [&] { ++prepared; });
                SeveralColors shade{corners, kind == 1};
                with(shade, [&] {
                    ++prepared;
                    shade.plane.emplace(t, area, image.color_weight);
                    shade.hash = std::uint32_t(i);
                });
            };
            draw([&](const auto& shade, const auto& prepare) {
                prepare();
                expected.fill(t, area, shade);
            });
            for (int w = 0; w < 3; ++w) {
                const DepthTestedFill fill(image, buffers[w], block_fill(widths[w]));
                prepared = 0;
                draw([&](const auto& shade, const auto& prepare) { fill(t, area, prepare, shade); });
                CHECK(prepared <= 1);
            }
        }
        for (SampleBuffers& b : buffers) {
            int wrong = 0;
            for (int y = 0; y < bottom + top; ++y) {
                for (int x = 0; x < right + left; ++x) {
                    const auto at = std::size_t(y * expected.width() + x);
                    wrong += b.blocks().depth(x, y) != expected.depth[at];
                    wrong += b.blocks().color(x, y) != expected.color[at];
                }
            }
            CHECK(wrong == 0);
            const SampleBlocks& blocks = b.blocks();
            for (std::size_t at = 0; at < blocks.index(0, (blocks.height() + 7) / 8); ++at) {
                surfaces += blocks.is_drawn(blocks.block(at)) && blocks.block(at).is_surface;
            }
        }
    }
    CHECK(surfaces > 100);
}
