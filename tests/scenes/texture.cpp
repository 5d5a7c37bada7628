#include "scenes/load/texture.hpp"

#include <cmath>
#include <limits>

#include "catch.hpp"

using namespace farfield;
using namespace farfield::scenes::detail;

namespace {

constexpr Rgba8 red{255, 0, 0}, green{0, 255, 0}, blue{0, 0, 255}, white{255, 255, 255}, clear{0, 0, 0, 0};

/// Two by two, top row first.
const Image four{2, 2, {red, white, blue, green}};

/// A leaf of one color in the middle of clear texels.
Image leaf(int size, int first, int last, Rgba8 color) {
    Image image{size, size, std::vector<Rgba8>(static_cast<std::size_t>(size * size), clear)};
    for (int y = first; y < last; ++y) {
        for (int x = first; x < last; ++x) image.texels[static_cast<std::size_t>(y * size + x)] = color;
    }
    return image;
}

}  // namespace

TEST_CASE("a texture is read from below, nearest texel, in each way of wrapping", "[scenes][load]") {
    Texture texture{&four};
    CHECK(texture.at({0.25f, 0.25f}) == blue);
    CHECK(texture.at({0.75f, 0.25f}) == green);
    CHECK(texture.at({0.25f, 0.75f}) == red);
    CHECK(texture.at({1.25f, -0.75f}) == blue);
    CHECK(texture.at({-0.25f, 0.25f}) == green);
    texture.across = texture.up = Wrap::mirror;
    CHECK(texture.at({0.25f, 0.25f}) == blue);
    CHECK(texture.at({1.25f, 0.25f}) == green);
    CHECK(texture.at({-0.25f, 0.25f}) == blue);
    CHECK(texture.at({2.25f, 1.25f}) == red);
    texture.across = texture.up = Wrap::clamp;
    CHECK(texture.at({7.0f, 0.25f}) == green);
    CHECK(texture.at({-7.0f, 1.0f}) == red);
}

TEST_CASE("texture coordinates of any size, or that are none, name a texel", "[scenes][load]") {
    constexpr float inf = std::numeric_limits<float>::infinity();
    for (const Wrap wrap : {Wrap::repeat, Wrap::mirror, Wrap::clamp}) {
        const Texture texture{&four, wrap, wrap};
        for (const float v : {inf, -inf, std::nanf(""), 3e38f, -3e38f, 1e-45f, -1e-45f, 16777217.0f}) {
            texture.at({v, v});
            texture.corners({{{v, 0.0f}, {0.0f, v}, {1.0f, 1.0f}}});
        }
    }
    CHECK(Texture{&four}.at({std::nanf(""), std::nanf("")}) == blue);
}

TEST_CASE("corners between transparent texels have the color of the opaque ones", "[scenes][load]") {
    const Rgba8 dark_green{10, 90, 20};
    const Image image = leaf(16, 6, 10, dark_green);
    const Texture texture{&image};
    // Its corners and the ways to its middle miss the leaf; the triangle does not.
    const auto beside = texture.corners({{{0.0f, 0.0f}, {0.9f, 0.1f}, {0.45f, 0.55f}}});
    CHECK(beside[0] == dark_green);
    // No texel of the leaf lies in this one: the image's.
    const auto outside = texture.corners({{{0.0f, 0.0f}, {0.2f, 0.0f}, {0.0f, 0.2f}}});
    for (const Rgba8 c : outside) CHECK(c == dark_green);
    // A card of two triangles.
    for (const Rgba8 c : texture.corners({{{0, 0}, {1, 0}, {1, 1}}})) CHECK(c == dark_green);
    // Degenerate in the image, far repeated, upside down.
    for (const Rgba8 c : texture.corners({{{0, 0}, {0, 0}, {0, 0}}})) CHECK(c == dark_green);
    for (const Rgba8 c : texture.corners({{{0, 0}, {0, 1000}, {1000, 1000}}})) CHECK(c == dark_green);
    for (const Rgba8 c : texture.corners({{{0, 0}, {0.2f, 0.9f}, {0.9f, 0.2f}}})) CHECK(c == dark_green);
}

TEST_CASE("a mean is of the triangle's own texels", "[scenes][load]") {
    // Below the diagonal red and blue in equal parts, but clear where the corners look; above it green.
    constexpr int size = 32;
    Image image{size, size, std::vector<Rgba8>(size * size, green)};
    for (int y = 0; y < size; ++y) {
        for (int x = 0; x < size; ++x) {
            const int up = size - 1 - y;
            Rgba8& texel = image.texels[static_cast<std::size_t>(y * size + x)];
            if (up > x) continue;
            texel = up == 3 ? (x % 2 == 0 ? red : blue) : clear;
        }
    }
    const auto colors = Texture{&image}.corners({{{0, 0}, {1, 0}, {1, 1}}});
    // The row has 29 texels in the triangle: 15 blue ones.
    for (const Rgba8 c : colors) CHECK(c == Rgba8{123, 0, 132});
}

TEST_CASE("alpha that a material ignores hides no texel", "[scenes][load]") {
    const Image image{1, 1, {{40, 50, 60, 0}}};
    CHECK(Texture{&image, Wrap::repeat, Wrap::repeat, 0}.corners({{{0, 0}, {1, 0}, {1, 1}}})[1] ==
          Rgba8{40, 50, 60, 0});
    // Nothing at all is to be seen of it: white.
    CHECK(Texture{&image}.corners({{{0, 0}, {1, 0}, {1, 1}}})[1] == white);
}

TEST_CASE("what is no image has no texels", "[scenes][load]") {
    CHECK(decoded("").texels.empty());
    CHECK(decoded("not an image").texels.empty());
    // A TGA of 65,535 by 65,535 that is not there.
    std::string huge("\0\0\2\0\0\0\0\0\0\0\0\0\xff\xff\xff\xff\x18\0", 18);
    CHECK(decoded(huge).texels.empty());
    const std::string one("\0\0\2\0\0\0\0\0\0\0\0\0\1\0\1\0\x18\0\3\2\1", 21);
    REQUIRE(decoded(one).texels.size() == 1);
    CHECK(decoded(one).texels[0] == Rgba8{1, 2, 3});
}
