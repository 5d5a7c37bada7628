// Only what was drawn is cleared and resolved: pictures are those of who clears and resolves everything.
#include "farfield/raster/samples/color_samples.hpp"

#include <algorithm>

#include "catch.hpp"
#include "support/random.hpp"
#include "support/views.hpp"

using namespace farfield;
using namespace farfield::detail;
using namespace farfield::test;

namespace {

struct Rows {
    int x0, y0, x1, y1;
    Rgba8 color;
};

void draw(ColorSamples& samples, const std::vector<Rows>& drawn) {
    for (const Rows& r : drawn) {
        for (int y = r.y0; y < r.y1; ++y) std::fill(samples.row(y) + r.x0, samples.row(y) + r.x1, r.color);
        samples.drawn(r.x0, r.y0, r.x1, r.y1);
    }
}

}  // namespace

TEST_CASE("pictures in a row are those that are drawn from scratch", "[raster]") {
    Random random(780);
    ColorSamples kept;
    Image image;
    int side = 1, width = 20, height = 10;
    Rgba8 background{};
    for (int round = 0; round < 400; ++round) {
        if (random.below(20) == 0) side = 1 + int(random.below(8));
        if (random.below(20) == 0) width = 1 + int(random.below(30)), height = 1 + int(random.below(30));
        if (random.below(20) == 0) background = random.color();
        View view = looking({0, 0, 5});
        view.width = width;
        view.height = height;
        const SampleProjection to(LocalView(view, glm::dvec3(0), 1), side);
        std::vector<Rows> drawn;
        for (auto n = random.below(4); n > 0; --n) {
            const auto between = [&](int from, int end) {
                return from + int(random.below(std::uint32_t(end - from + 1)));
            };
            const int x0 = between(to.first_x, to.end_x), y0 = between(to.first_y, to.end_y);
            const int x1 = between(x0, to.end_x), y1 = between(y0, to.end_y);
            if (x0 < x1 && y0 < y1) drawn.push_back({x0, y0, x1, y1, random.color()});
        }
        kept.begin(to, side, background);
        draw(kept, drawn);
        kept.resolve(image);
        ColorSamples fresh;
        Image expected;
        fresh.begin(to, side, background);
        draw(fresh, drawn);
        fresh.resolve(expected);
        REQUIRE(image == expected);
        REQUIRE((image.width() == width && image.height() == height));
        // One pixel by hand.
        const int px = int(random.below(std::uint32_t(width))), py = int(random.below(std::uint32_t(height)));
        int sum = 0;
        for (int y = py * side; y < (py + 1) * side; ++y) {
            for (int x = px * side; x < (px + 1) * side; ++x) sum += fresh.row(y + to.first_y)[x + to.first_x].g;
        }
        CHECK(std::abs(float(expected.at(px, py).g) - float(sum) / float(side * side)) <= 0.51f);
    }
}
