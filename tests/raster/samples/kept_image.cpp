// What is kept of an image against one texel after the other.
#include "farfield/raster/samples/kept_image.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <utility>
#include <vector>

#include "catch.hpp"
#include "farfield/geometry/area_law.hpp"
#include "farfield/image.hpp"
#include "farfield/view/local_view.hpp"
#include "support/random.hpp"
#include "support/views.hpp"

using namespace farfield;
using namespace farfield::detail;
using namespace farfield::test;

namespace {

constexpr float nothing = -std::numeric_limits<float>::infinity();

/// A picture with geometry in some samples and deposits over some, and each sample's nearest depth.
struct Picture {
    SampleProjection projection;
    int side;
    SampleBuffers buffers;
    Image colors;
    std::vector<float> nearest;  ///< q, by samples; -infinity: nothing

    Picture(Random& random, int width, int height, int samples_a_side, bool perspective, bool has_far)
        : side(samples_a_side) {
        View view = perspective ? looking({0, 0, 0}, {0, 0, -1}, 8) : looking_orthographic({0, 0, 0}, {0, 0, -1}, 2, 8);
        view.width = width;
        view.height = height;
        projection = SampleProjection(LocalView(view, glm::dvec3(0), 10), side);
        buffers.begin(projection, side, {0, 0, 0, 0});
        const int across = width * side, down = height * side;
        nearest.assign(std::size_t(across) * std::size_t(down), nothing);
        add_geometry(random, across, down);
        if (has_far) add_deposits(random, across, down);
        buffers.resolve(colors);
    }
    float& at(int x, int y) { return nearest[std::size_t(y) * std::size_t(projection.whole_width) + std::size_t(x)]; }
    float some_depth(Random& random) const {
        return projection.is_perspective ? random.between(0.1f, 0.5f) : -random.between(2, 10);
    }

  private:
    void add_geometry(Random& random, int across, int down) {
        SampleBlocks& blocks = buffers.blocks();
        const int columns = (across + 7) / 8, rows = (down + 7) / 8;
        for (int row = 0; row < rows; ++row) {
            for (int column = 0; column < columns; ++column) {
                // Some of the margin stays empty.
                const std::uint32_t kind = column == 0 ? 0 : random.below(4);
                if (kind == 0) continue;
                const std::size_t block = blocks.index(column, row);
                const int end_x = std::min(column * 8 + 8, across), end_y = std::min(row * 8 + 8, down);
                blocks.add_drawn(column * 8, row * 8, end_x, end_y);
                if (kind == 1) {
                    const float q = some_depth(random);
                    blocks.set_surface(block, DepthPlane(q, 0, 0, q, q), {1, 2, 3, 255}, q, q);
                    for (int y = row * 8; y < end_y; ++y) {
                        for (int x = column * 8; x < end_x; ++x) at(x, y) = q;
                    }
                    continue;
                }
                SampleBlocks::Samples& samples = blocks.opened(block, column, row);
                float most = nothing;
                for (int y = row * 8; y < end_y; ++y) {
                    for (int x = column * 8; x < end_x; ++x) {
                        if (random.below(3) == 0) continue;
                        const int i = (y & 7) * 8 + (x & 7);
                        at(x, y) = samples.depth[i] = some_depth(random);
                        samples.color[i] = {9, std::uint8_t(random.below(256)), std::uint8_t(i), 255};
                        most = std::max(most, at(x, y));
                    }
                }
                blocks.filled(block, most);
            }
        }
    }
    void add_deposits(Random& random, int across, int down) {
        buffers.begin_far();
        std::vector<char> is_touched(nearest.size());
        const std::vector<float> geometry = nearest;
        for (int i = 0; i < 12; ++i) {
            const auto x0 = int(random.below(std::uint32_t(across))), y0 = int(random.below(std::uint32_t(down)));
            const int x1 = std::min(across, x0 + 1 + int(random.below(12))),
                      y1 = std::min(down, y0 + 1 + int(random.below(12)));
            const float q = some_depth(random);
            // Up to the edges, and not to what lies behind them.
            const auto left = float(projection.first_x), top = float(projection.first_y);
            buffers.deposit_square(left + float(x0), top + float(y0), left + float(x1) - 0.25f, top + float(y1) - 0.25f,
                                   q, loss_of_opacity(0.3f, AreaLaw::independent), {0.2f, 0.4f, 0.6f});
            for (int y = y0; y < y1; ++y) {
                for (int x = x0; x < x1; ++x) {
                    const std::size_t sample = std::size_t(y) * std::size_t(across) + std::size_t(x);
                    if (q <= geometry[sample] || is_touched[sample]) continue;
                    is_touched[sample] = 1;
                    nearest[sample] = q;
                }
            }
        }
    }
};

/// Of the samples that something covers.
float mean_depth(Picture& picture, int px, int py) {
    double sum = 0;
    int count = 0;
    for (int y = py * picture.side; y < (py + 1) * picture.side; ++y) {
        for (int x = px * picture.side; x < (px + 1) * picture.side; ++x) {
            if (picture.at(x, y) == nothing) continue;
            sum += double(picture.at(x, y));
            ++count;
        }
    }
    return count == 0 ? nothing : float(sum / count);
}

}  // namespace

TEST_CASE("images keep what was drawn, texel by texel", "[kept_image]") {
    Random random(81);
    int translucent = 0, solid = 0, cut = 0;
    KeptImage kept;  // memory is used again
    KeepingScratch scratch;
    for (int i = 0; i < 160; ++i) {
        const int side = std::array{1, 1, 2, 4, 8}[random.below(5)];
        const int width = 1 + int(random.below(40)), height = 1 + int(random.below(30));
        const bool perspective = random.below(2) == 0, has_far = random.below(2) == 0;
        Picture picture(random, width, height, side, perspective, has_far);
        const float quad = random.between(2, 10);
        DepthRange range{nothing, -nothing};
        if (random.below(3) == 0) range = {picture.some_depth(random), -nothing};
        keep_image(kept, picture.buffers, picture.colors, picture.projection, quad, range, scratch);
        INFO("picture " << i << ", " << width << " x " << height << ", " << side << " samples a side");
        REQUIRE(kept.whole_width == width);
        REQUIRE(kept.whole_height == height);
        const float quad_q = picture.projection.q(quad, picture.projection.inverse_w(quad));
        const auto relative = [&](float q) { return perspective ? q / quad_q : q - quad_q; };
        const auto depth_of = [&](std::size_t texel) {
            return kept.least_depth + kept.depth_step * float(kept.depth[texel]);
        };
        bool is_solid = true;
        for (int y = 0; y < height; ++y) {
            for (int x = 0; x < width; ++x) {
                const Rgba8 drawn = picture.colors.at(x, y);
                const float q = mean_depth(picture, x, y);
                const bool is_in = drawn.a != 0 && (q == nothing || (q >= range.farthest && q <= range.nearest));
                cut += drawn.a != 0 && !is_in;
                const int u = x - kept.left + 1, v = y - kept.top + 1;
                const bool is_kept = u >= 1 && v >= 1 && u <= kept.width && v <= kept.height;
                if (is_in) REQUIRE(is_kept);
                if (!is_kept) continue;
                const std::size_t texel = std::size_t(v) * kept.stride() + std::size_t(u);
                REQUIRE(kept.color[texel] == (is_in ? drawn : Rgba8{0, 0, 0, 0}));
                if (!is_in) continue;
                is_solid = is_solid && drawn.a == 255;
                REQUIRE(kept.tiles[std::size_t(v / 8) * kept.tile_columns() + std::size_t(u / 8)] == 1);
                if (q == nothing) continue;
                REQUIRE(std::abs(depth_of(texel) - relative(q)) <= 0.51f * kept.depth_step + 1e-5f);
            }
        }
        const auto is_shown = [&](int u, int v) {
            return kept.color[std::size_t(v) * kept.stride() + std::size_t(u)].a != 0;
        };
        for (int v = 0; v < kept.height + 2; ++v) {
            for (int u = 0; u < kept.width + 2; ++u) {
                const std::size_t texel = std::size_t(v) * kept.stride() + std::size_t(u);
                const bool is_border = u == 0 || v == 0 || u == kept.width + 1 || v == kept.height + 1;
                if (is_border) REQUIRE(!is_shown(u, v));
                if (is_shown(u, v)) continue;
                bool has_neighbor = false, has_its_depth = false;
                for (const auto& [du, dv] : {std::pair(0, -1), std::pair(0, 1), std::pair(-1, 0), std::pair(1, 0)}) {
                    const int nu = u + du, nv = v + dv;
                    if (nu < 0 || nv < 0 || nu > kept.width + 1 || nv > kept.height + 1 || !is_shown(nu, nv)) continue;
                    const std::size_t neighbor = std::size_t(nv) * kept.stride() + std::size_t(nu);
                    has_its_depth = has_its_depth || kept.depth[neighbor] == kept.depth[texel];
                    has_neighbor = true;
                }
                if (has_neighbor) REQUIRE(has_its_depth);
                if (!has_neighbor) REQUIRE(std::abs(depth_of(texel) - (perspective ? 1 : 0)) <= kept.depth_step);
            }
        }
        REQUIRE(kept.is_solid == is_solid);
        (is_solid ? solid : translucent) += kept.width > 0;
    }
    CHECK(translucent > 10);
    CHECK(solid > 10);
    CHECK(cut > 1000);
}

TEST_CASE("an image of nothing keeps nothing, and is one all the same", "[kept_image]") {
    SampleProjection projection;
    projection.end_x = projection.whole_width = 12;
    projection.end_y = projection.whole_height = 7;
    SampleBuffers buffers;
    buffers.begin(projection, 1, {0, 0, 0, 0});
    Image colors;
    buffers.resolve(colors);
    KeptImage kept;
    KeepingScratch scratch;
    keep_image(kept, buffers, colors, projection, 3, {nothing, -nothing}, scratch);
    CHECK(kept.whole_width == 12);
    CHECK(kept.whole_height == 7);
    CHECK(kept.width == 0);
    CHECK(kept.height == 0);
    CHECK(kept.is_solid);
}
