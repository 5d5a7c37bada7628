// Blocks filled from images in vectors against one sample after the other, in doubles.
#include "farfield/raster/samples/image_block_fill.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <set>

#include "catch.hpp"
#include "farfield/image.hpp"
#include "support/random.hpp"

using namespace farfield;
using namespace farfield::detail;
using namespace farfield::test;

namespace {

/// Texels without a border that is kept: all of the border is transparent.
KeptImage random_image(Random& random, int across, int down, bool is_solid) {
    KeptImage image;
    image.whole_width = image.width = across;
    image.whole_height = image.height = down;
    const std::size_t stride = image.stride(), count = stride * std::size_t(down + 2);
    image.color.assign(count, {0, 0, 0, 0});
    image.depth.resize(count);
    image.least_depth = 0.9f;
    image.depth_step = 0.2f / 65535;
    image.is_solid = is_solid;
    for (std::uint16_t& d : image.depth) d = std::uint16_t(random.below(65536));
    for (int y = 1; y <= down; ++y) {
        for (int x = 1; x <= across; ++x) {
            if (random.below(4) == 0) continue;
            const std::uint32_t a = is_solid ? 255 : random.below(3) == 0 ? 255 : random.below(256);
            const auto channel = [&] { return std::uint8_t(random.below(a + 1)); };
            image.color[std::size_t(y) * stride + std::size_t(x)] = {channel(), channel(), channel(), std::uint8_t(a)};
        }
    }
    return image;
}

SampleProjection of_size(int across, int down) {
    SampleProjection to;
    to.first_x = to.first_y = to.left = to.top = 0;
    to.end_x = to.whole_width = across;
    to.end_y = to.whole_height = down;
    return to;
}

constexpr int picture_width = 21, picture_height = 13;  // neither is a multiple of a block

/// With geometry in some blocks, some of them covered by one surface.
void begin_with_geometry(SampleBuffers& buffers, std::uint64_t seed) {
    buffers.begin(of_size(picture_width, picture_height), 1, {1, 2, 3, 255});
    buffers.begin_far();
    Random random(seed);
    SampleBlocks& blocks = buffers.blocks();
    blocks.add_drawn(0, 0, picture_width, picture_height);
    for (int row = 0; row < 2; ++row) {
        for (int column = 0; column < 3; ++column) {
            const std::uint32_t kind = random.below(3);
            const std::size_t at = blocks.index(column, row);
            if (kind == 0) continue;
            SampleBlocks::Samples& samples = blocks.opened(at, column, row);
            float nearest = -std::numeric_limits<float>::infinity();
            for (int i = 0; i < SampleBlocks::area; ++i) {
                if (kind == 2 && random.below(2) == 0) continue;
                if (samples.depth[i] == std::numeric_limits<float>::infinity()) continue;
                samples.depth[i] = random.unit() * 2;
                samples.color[i] = {9, 8, std::uint8_t(i), 255};
                nearest = std::max(nearest, samples.depth[i]);
            }
            blocks.filled(at, nearest);
        }
    }
}

ImageInBlock random_block(Random& random, const KeptImage& image, int column, int row) {
    ImageInBlock in;
    in.x = column * 8;
    in.y = row * 8;
    in.end = std::min(8, picture_width - in.x);
    in.last_row = std::min(8, picture_height - in.y) - 1;
    if (random.below(3) == 0) {
        in.first = int(random.below(3));
        in.first_row = int(random.below(3));
    }
    const auto corner = [&](float u, float v) {
        const auto near_by = [&](float at) { return std::int32_t((at + random.unit()) * 65536); };
        return ImageCorner{near_by(u), near_by(v), 1 + 0.1f * random.unit()};
    };
    const float u = random.unit() * float(image.width) - 3, v = random.unit() * float(image.height) - 3;
    const float size = 1 + 12 * random.unit(), turn = 4 * random.unit() - 2;
    in.left[0] = corner(u, v);
    in.left[1] = corner(u - turn, v + size);
    in.right[0] = corner(u + size, v + turn);
    in.right[1] = corner(u + size - turn, v + size + turn);
    in.is_inside = true;
    for (const ImageCorner& c : {in.left[0], in.left[1], in.right[0], in.right[1]}) {
        in.is_inside = in.is_inside && c.u >= 0 && c.v >= 0 && (c.u + 128) >> 16 <= image.width &&
                       (c.v + 128) >> 16 <= image.height;
    }
    in.is_quotient = random.below(2) == 0;
    in.bias = 0.25f;
    if (random.below(2) == 0) {
        in.first_part = int(random.below(40));
        in.end_part = in.first_part + int(random.below(24));
    }
    in.whole_x = in.x + int(random.below(100));
    in.whole_y = in.y + int(random.below(100));
    return in;
}

/// What a sample gets of an image, or NaN as its depth.
struct TexelWanted {
    double q = std::numeric_limits<double>::quiet_NaN();
    double color[4] = {0, 0, 0, 0};
    double to_edge = 0;  ///< of a texel, beyond which another's depth counts; texels
};
TexelWanted texel_wanted(const KeptImage& image, const ImageInBlock& in, int x, int y) {
    const double s = x / 8.0, t = y / 8.0;
    const auto at = [&](auto member) {
        const double upper = double(in.left[0].*member) * (1 - s) + double(in.right[0].*member) * s;
        const double lower = double(in.left[1].*member) * (1 - s) + double(in.right[1].*member) * s;
        return upper * (1 - t) + lower * t;
    };
    const double u = at(&ImageCorner::u) / 65536, v = at(&ImageCorner::v) / 65536;
    const auto texel = [&](double a, double b) {
        const int column = std::clamp(int(a), 0, image.width + 1), row = std::clamp(int(b), 0, image.height + 1);
        return std::size_t(row) * image.stride() + std::size_t(column);
    };
    TexelWanted w;
    if (u < 0 || v < 0 || u >= image.width + 1 || v >= image.height + 1) return w;
    const double relative = double(image.least_depth) + double(image.depth_step) * image.depth[texel(u + 0.5, v + 0.5)];
    const double quad = at(&ImageCorner::q);
    w.q = in.is_quotient ? (quad + double(in.bias)) * relative - double(in.bias) : quad + relative;
    const double across = u - std::floor(u), down = v - std::floor(v);
    for (const int dx : {0, 1}) {
        for (const int dy : {0, 1}) {
            const double part = (dx == 1 ? across : 1 - across) * (dy == 1 ? down : 1 - down);
            const Rgba8 c = image.color[texel(std::floor(u) + dx, std::floor(v) + dy)];
            const std::uint8_t channels[4] = {c.r, c.g, c.b, c.a};
            for (int i = 0; i < 4; ++i) w.color[i] += part * channels[i];
        }
    }
    w.to_edge = std::min({std::abs(u + 0.5 - std::round(u + 0.5)), std::abs(v + 0.5 - std::round(v + 0.5)),
                          std::abs(u - std::round(u)), std::abs(v - std::round(v))});
    return w;
}

}  // namespace

TEST_CASE("blocks are filled from images as one sample after the other would be", "[image_block_fill]") {
    Random random(11);
    SampleBuffers before, after;
    int covered = 0, hidden = 0, outside = 0;
    for (int round = 0; round < 400; ++round) {
        const KeptImage image =
            random_image(random, 3 + int(random.below(12)), 3 + int(random.below(12)), /*is_solid=*/true);
        const auto seed = std::uint64_t(round);
        const int column = int(random.below(3)), row = int(random.below(2));
        const ImageInBlock in = random_block(random, image, column, row);
        begin_with_geometry(before, seed);
        begin_with_geometry(after, seed);
        const bool has_drawn = image_block_fill(Simd::automatic)(after, image, in);
        bool has_changed = false;
        for (int y = 0; y < picture_height; ++y) {
            for (int x = 0; x < picture_width; ++x) {
                const SampleBlocks::Sample was = before.blocks().sample(x, y), now = after.blocks().sample(x, y);
                const int i = x - in.x, j = y - in.y;
                const bool is_in_block = i >= in.first && i < in.end && j >= in.first_row && j <= in.last_row;
                const int order = is_in_block ? fade_order(in.whole_x + i, in.whole_y + j) : 0;
                const bool is_asked = is_in_block && order >= in.first_part && order < in.end_part;
                const TexelWanted w = is_asked ? texel_wanted(image, in, i, j) : TexelWanted{};
                has_changed = has_changed || was.depth != now.depth;
                if (std::isnan(w.q) || !(w.q > double(was.depth) - 1e-3)) {
                    if (is_asked && !std::isnan(w.q) && w.to_edge < 0.01) continue;
                    REQUIRE(now.depth == was.depth);
                    REQUIRE(now.color == was.color);
                    (std::isnan(w.q) ? outside : hidden) += 1;
                    continue;
                }
                // Near an edge of texels, of alpha one half and of what was there roundings decide.
                if (w.to_edge < 0.01 || std::abs(w.color[3] - 127.5) < 3 || w.q < double(was.depth) + 1e-3) continue;
                if (w.color[3] < 127.5) {
                    REQUIRE(now.depth == was.depth);
                    continue;
                }
                REQUIRE(double(now.depth) == Approx(w.q).margin(1e-3));
                REQUIRE(now.color.a == 255);
                const std::uint8_t channels[3] = {now.color.r, now.color.g, now.color.b};
                for (int k = 0; k < 3; ++k) {
                    REQUIRE(double(channels[k]) == Approx(w.color[k] * 255 / w.color[3]).margin(6));
                }
                ++covered;
            }
        }
        CHECK(has_drawn == has_changed);
        const SampleBlocks& blocks = after.blocks();
        for (int y = in.y; y < std::min(in.y + 8, picture_height); ++y) {
            for (int x = in.x; x < std::min(in.x + 8, picture_width); ++x) {
                REQUIRE(blocks.farthest(blocks.index(column, row)) <= blocks.sample(x, y).depth);
                if (has_drawn) REQUIRE(blocks.block(blocks.index(column, row)).nearest >= blocks.sample(x, y).depth);
            }
        }
    }
    CHECK(covered > 2000);
    CHECK(hidden > 500);
    CHECK(outside > 1000);
}

TEST_CASE("vectors of all widths fill the same bits from images", "[image_block_fill]") {
    Random random(12);
    SampleBuffers one, some;
    Image expected, image_of_some;
    int deposits = 0;
    for (int round = 0; round < 400; ++round) {
        const KeptImage image =
            random_image(random, 3 + int(random.below(12)), 3 + int(random.below(12)), random.below(2) == 0);
        const auto seed = std::uint64_t(round);
        const ImageInBlock first = random_block(random, image, int(random.below(3)), int(random.below(2)));
        const ImageInBlock second = random_block(random, image, int(random.below(3)), int(random.below(2)));
        begin_with_geometry(one, seed);
        for (const ImageInBlock& in : {first, second}) image_block_fill(Simd::scalar)(one, image, in);
        one.resolve(expected);
        for (const Simd simd : {Simd::four_lanes, Simd::eight_lanes}) {
            begin_with_geometry(some, seed);
            for (const ImageInBlock& in : {first, second}) image_block_fill(simd)(some, image, in);
            some.resolve(image_of_some);
            REQUIRE(image_of_some == expected);
            for (int y = 0; y < picture_height; ++y) {
                for (int x = 0; x < picture_width; ++x) {
                    REQUIRE(some.blocks().sample(x, y).depth == one.blocks().sample(x, y).depth);
                    deposits += image.is_solid ? 0 : some.drawn_pixels().x1 > 0;
                }
            }
        }
    }
    CHECK(deposits > 0);
}

TEST_CASE("images appear evenly, each sample once", "[image_block_fill]") {
    for (const int x : {-8, 0, 3, 16}) {
        std::set<int> orders;
        for (int dy = 0; dy < 8; ++dy) {
            for (int dx = 0; dx < 8; ++dx) orders.insert(fade_order(x + dx, dy - 3));
        }
        CHECK(orders.size() == 64);
        CHECK(*orders.begin() == 0);
        CHECK(*orders.rbegin() == 63);
    }
    // A quarter of all samples is one of each two by two.
    for (int y = 0; y < 8; y += 2) {
        for (int x = 0; x < 8; x += 2) {
            int shown = 0;
            for (const int dx : {0, 1}) shown += (fade_order(x + dx, y) < 16) + (fade_order(x + dx, y + 1) < 16);
            CHECK(shown == 1);
        }
    }
}
