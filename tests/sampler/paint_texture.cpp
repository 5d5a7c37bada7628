#include "farfield/sampler/paint_texture.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "catch.hpp"
#include "farfield/approximation/color_cube.hpp"
#include "farfield/approximation/exact.hpp"
#include "farfield/approximation/opacity_tensor.hpp"
#include "farfield/build.hpp"
#include "farfield/cost_model/triangle_count.hpp"
#include "farfield/partition/octree.hpp"
#include "farfield/primitive/instance.hpp"
#include "farfield/primitive/triangle.hpp"
#include "farfield/update.hpp"

using namespace farfield;

namespace {

const Box everything{glm::vec3(-100), glm::vec3(100)};

struct Painted {
    std::vector<Triangle> pieces;
    double area = 0;  ///< weighted by alpha
    glm::dvec3 color{0};

    void operator()(const Polygon& polygon) {
        for_each_triangle(polygon.vertices.size(), [&](std::size_t a, std::size_t b, std::size_t c) {
            pieces.push_back({{polygon.vertices[a], polygon.vertices[b], polygon.vertices[c]}, polygon.colors[0]});
            const glm::dvec4 color_of_piece(to_vec4(polygon.colors[0]));
            area += pieces.back().area() * color_of_piece.w;
            color += glm::dvec3(color_of_piece) * (pieces.back().area() * color_of_piece.w);
        });
    }
};

TextureLevels noise(int width, int height, unsigned seed) {
    std::mt19937 random(seed);
    std::vector<Rgba8> texels;
    for (int i = 0; i < width * height; ++i) {
        const auto byte = [&] { return std::uint8_t(random() % 256); };
        texels.push_back({byte(), byte(), byte(), std::uint8_t(random() % 3 == 0 ? 0 : 255)});
    }
    return {width, height, texels};
}

Painted paint(const Polygon& polygon, std::span<const glm::vec2> at, const TextureLevels& texture, float finest,
              const Box& seen = everything) {
    Painted painted;
    paint_texture(polygon, at, texture, seen, finest, painted);
    return painted;
}

const std::array<glm::vec3, 4> square{{{0, 0, 1}, {2, 0, 1}, {2, 2, 1}, {0, 2, 1}}};
const Rgba8 plain{1, 2, 3, 255};
const Polygon square_polygon{square, {&plain, 1}};

}  // namespace

TEST_CASE("pieces of a texture have its area and color, at every level of detail") {
    const TextureLevels texture = noise(16, 8, 1);
    const std::array<glm::vec2, 4> whole{{{0, 0}, {1, 0}, {1, 1}, {0, 1}}};
    const Rgba8 mean = texture.texel(texture.levels() - 1, 0, 0);
    for (const float finest : {0.01f, 0.1f, 0.3f, 1.0f, 10.0f}) {
        const Painted painted = paint(square_polygon, whole, texture, finest);
        CHECK(std::abs(painted.area - 4 * double(mean.a) / 255) < 0.03);
        for (int i = 0; i < 3; ++i) {
            CHECK(std::abs(painted.color[i] / painted.area - double(to_vec4(mean)[i])) < 0.01);
        }
    }
    CHECK(paint(square_polygon, whole, texture, 10).pieces.size() == 2);
    CHECK(paint(square_polygon, whole, texture, 0.01f).pieces.size() > 100);
}

TEST_CASE("pieces lie where their texels do: every point has the color that is looked up there") {
    const TextureLevels texture = noise(8, 8, 2);
    // Sheared, repeated and mirrored.
    const std::array<glm::vec2, 3> at{{{-0.3f, 0.2f}, {1.9f, -0.4f}, {0.6f, 1.7f}}};
    const std::array<glm::vec3, 3> triangle{{{0, 0, 0}, {3, 0.5f, 0}, {0.5f, 2, 0}}};
    const Painted painted = paint({triangle, {&plain, 1}}, at, texture, 1e-3f);
    std::mt19937 random(4);
    int looked_at = 0;
    for (int i = 0; i < 2000; ++i) {
        float b = float(random() % 1000) / 1000, c = float(random() % 1000) / 1000;
        if (b + c > 1) b = 1 - b, c = 1 - c;
        const glm::vec3 p = triangle[0] + (triangle[1] - triangle[0]) * b + (triangle[2] - triangle[0]) * c;
        const glm::vec2 t = (at[0] + (at[1] - at[0]) * b + (at[2] - at[0]) * c) * 8.0f;
        const glm::vec2 inside = t - glm::floor(t);
        if (std::min({inside.x, inside.y, 1 - inside.x, 1 - inside.y}) < 0.01f) continue;  // on a texel's border
        const Rgba8 wanted = texture.texel(0, int(std::floor(t.x)), int(std::floor(t.y)));
        int found = 0;
        for (const Triangle& piece : painted.pieces) {
            const auto side = [&](int k) {
                const glm::vec3 e = piece.vertices[std::size_t(k + 1) % 3] - piece.vertices[std::size_t(k)],
                                d = p - piece.vertices[std::size_t(k)];
                return e.x * d.y - e.y * d.x;
            };
            if (side(0) < 1e-6f || side(1) < 1e-6f || side(2) < 1e-6f) continue;
            ++found;
            if (piece.rgba != wanted) found = 100;
        }
        CHECK(found <= 1);
        if (wanted.a == 0) CHECK(found == 0);
        looked_at += found;
    }
    CHECK(looked_at > 700);
}

TEST_CASE("a polygon is cut off at the box that is seen") {
    const TextureLevels texture = noise(32, 32, 5);
    const std::array<glm::vec2, 4> whole{{{0, 0}, {1, 0}, {1, 1}, {0, 1}}};
    const Painted painted = paint(square_polygon, whole, texture, 0.02f, {{0.5f, 0.5f, 0}, {1, 1.5f, 2}});
    CHECK(!painted.pieces.empty());
    for (const Triangle& piece : painted.pieces) {
        for (const glm::vec3& p : piece.vertices) CHECK((p.x >= 0.499f && p.x <= 1.001f && p.y <= 1.501f));
    }
    CHECK(paint(square_polygon, whole, texture, 0.02f, {glm::vec3(5), glm::vec3(6)}).pieces.empty());
}

TEST_CASE("odd texture coordinates are ordinary") {
    const TextureLevels texture = noise(16, 16, 6);
    const std::array<glm::vec2, 4> whole{{{0, 0}, {1, 0}, {1, 1}, {0, 1}}};
    const auto is_plain = [](const Painted& p) { return p.pieces.size() == 2 && p.pieces[0].rgba == plain; };
    CHECK(is_plain(paint(square_polygon, {}, texture, 0.1f)));
    CHECK(is_plain(paint(square_polygon, std::span(whole).first(3), texture, 0.1f)));
    CHECK(is_plain(paint(square_polygon, whole, TextureLevels(), 0.1f)));
    const float nan = std::numeric_limits<float>::quiet_NaN(), infinite = std::numeric_limits<float>::infinity();
    for (const float odd : {nan, infinite, -infinite}) {
        std::array<glm::vec2, 4> at = whole;
        at[2].y = odd;
        CHECK(is_plain(paint(square_polygon, at, texture, 0.1f)));
    }
    const TextureLevels one(1, 1, std::vector<Rgba8>{{7, 8, 9, 255}});
    CHECK(std::abs(paint(square_polygon, whole, one, 0).area - 4) < 1e-5);

    // A ramp, along which one coordinate stays as it is; and all in one point.
    const TextureLevels ramp(4, 1,
                             std::vector<Rgba8>{{0, 0, 0, 255}, {50, 0, 0, 255}, {100, 0, 0, 255}, {150, 0, 0, 255}});
    const std::array<glm::vec2, 4> along{{{0, 0.5f}, {1, 0.5f}, {1, 0.5f}, {0, 0.5f}}};
    const Painted ramped = paint(square_polygon, along, ramp, 0.01f);
    CHECK(std::abs(ramped.area - 4) < 1e-4);
    CHECK(std::abs(ramped.color.x / ramped.area * 255 - 75) < 1);
    const std::array<glm::vec2, 4> in_one_point{{{0.3f, 0}, {0.3f, 0}, {0.3f, 0}, {0.3f, 0}}};
    const Painted point = paint(square_polygon, in_one_point, ramp, 0.01f);
    CHECK(std::abs(point.area - 4) < 1e-4);
    CHECK(point.pieces[0].rgba.r == 50);

    // Repeated without measure: few pieces, and the mean.
    std::array<glm::vec2, 4> often = whole;
    for (glm::vec2& t : often) t *= 1e7f;
    CHECK(paint(square_polygon, often, texture, 1e-6f).pieces.size() < 100'000);
    // Transparent all over.
    const TextureLevels clear(4, 4, std::vector<Rgba8>(16, Rgba8{9, 9, 9, 0}));
    CHECK(paint(square_polygon, whole, clear, 0.01f).pieces.empty());
}

// --- in builds

namespace {

struct Card {
    std::array<glm::vec3, 4> corners;
    std::array<glm::vec2, 4> at{{{0, 0}, {1, 0}, {1, 1}, {0, 1}}};
    const TextureLevels* texture = nullptr;

    Box bounds() const {
        Box box = Box::empty();
        for (const glm::vec3& c : corners) box.add(c);
        return box;
    }
    template <class Sink>
    void polygons(Sink&& sink) const {
        const Rgba8 color{90, 90, 90, 255};
        sink(Polygon{corners, {&color, 1}, false, *this});
    }
};

struct CardSampler : GridSampler {
    template <class Sink>
    void paint(const Polygon& polygon, const Box& seen, float finest, Sink&& sink) const {
        const Card* card = polygon.carried.get<Card>();
        if (card == nullptr || card->texture == nullptr) return sink(polygon);
        paint_texture(polygon, card->at, *card->texture, seen, finest, sink);
    }
};
static_assert(PaintsPolygons<CardSampler> && !PaintsPolygons<GridSampler>);

std::vector<Card> cards_of(const TextureLevels* texture) {
    std::mt19937 random(7);
    const auto number = [&] { return float(random() % 2000) / 1000 - 1; };
    std::vector<Card> cards;
    for (int i = 0; i < 300; ++i) {
        const glm::vec3 a(number(), number(), number()), u = 0.3f * glm::vec3(number(), number(), number()),
                                                         v = 0.3f * glm::vec3(number(), number(), number());
        cards.push_back({{a, a + u, a + u + v, a + v}, {{{0, 0}, {1, 0}, {1, 1}, {0, 1}}}, texture});
    }
    return cards;
}

/// The same as geometry: what is not transparent of each texel.
std::vector<Triangle> texels_of(std::span<const Card> cards) {
    Painted painted;
    for (const Card& card : cards) {
        paint_texture({card.corners, {&plain, 1}}, card.at, *card.texture, everything, 1e-4f, painted);
    }
    return painted.pieces;
}

template <class A>
using HierarchyOf = SpatialHierarchy<Octree, A, TriangleCount>;

}  // namespace

TEST_CASE("cards with alpha are baked as their texels are: areas of tensors, colors of cubes") {
    const TextureLevels texture = noise(8, 8, 8);
    const std::vector<Card> cards = cards_of(&texture);
    const std::vector<Triangle> texels = texels_of(cards);

    using Tensors = HierarchyOf<OpacityTensor>;
    BuildOptions<Tensors, CardSampler> options;
    const auto painted = build<Tensors, CardSampler>(cards, options);
    const auto flat = build<Tensors>(cards);
    const auto exact = build<Tensors>(texels);
    const auto seen = [](const Tensors& h) {
        const TensorAppearance look{h.root_stand_in()->unpacked(), false, true};
        double sum = 0;
        for (int axis = 0; axis < 3; ++axis) {
            glm::vec3 w(0);
            w[axis] = 1;
            sum += double(look.seen_from(w).area);
        }
        return sum;
    };
    REQUIRE((painted.root_stand_in() != nullptr && flat.root_stand_in() != nullptr));
    REQUIRE(exact.root_stand_in() != nullptr);
    CHECK(std::abs(seen(painted) / seen(exact) - 1) < 0.03);
    CHECK(seen(flat) / seen(exact) > 1.05);

    using Cubes = HierarchyOf<ColorCube>;
    const auto cubes = build<Cubes, CardSampler>(cards, {});
    const auto exact_cubes = build<Cubes>(texels);
    REQUIRE((cubes.root_stand_in() != nullptr && exact_cubes.root_stand_in() != nullptr));
    for (std::size_t side = 0; side < 6; ++side) {
        const glm::vec4 off = to_vec4((*cubes.root_stand_in())[side]) - to_vec4((*exact_cubes.root_stand_in())[side]);
        for (int i = 0; i < 4; ++i) CHECK(std::abs(off[i]) < 0.08f);
    }
}

TEST_CASE("an update paints as a build does") {
    const TextureLevels texture = noise(8, 8, 9);
    std::vector<Card> cards = cards_of(&texture);
    using H = HierarchyOf<OpacityTensor>;
    BuildOptions<H, CardSampler> options;
    options.world = {glm::dvec3(-2), glm::dvec3(2)};
    HierarchyUpdater<H, Card, CardSampler> updater(cards, options);
    for (glm::vec3& c : cards[7].corners) c.x *= 0.5f;
    const std::array<std::uint32_t, 1> changed{7};
    const H& updated = updater.update(cards, changed);
    const H built = build<H, CardSampler>(cards, options);
    CHECK(std::ranges::equal(updated.stand_ins(), built.stand_ins()));
    CHECK(std::ranges::equal(updated.nodes(), built.nodes()));
}

TEST_CASE("cards without texture coordinates or texture, and transparent ones, are ordinary") {
    using H = HierarchyOf<OpacityTensor>;
    const std::vector<Card> untextured = cards_of(nullptr);
    const auto plainly = build<H>(untextured);
    const auto painted = build<H, CardSampler>(untextured, {});
    CHECK(std::ranges::equal(plainly.stand_ins(), painted.stand_ins()));
    const TextureLevels clear(4, 4, std::vector<Rgba8>(16, Rgba8{9, 9, 9, 0}));
    const auto transparent = build<H, CardSampler>(cards_of(&clear), {});
    CHECK(transparent.stand_ins().empty());
}

TEST_CASE("instances pass on what their primitives carry, until a stand-in takes their place") {
    const TextureLevels texture = noise(8, 8, 10);
    const std::vector<Card> cards = cards_of(&texture);
    using Inner = HierarchyOf<Exact>;
    const Inner inner = build<Inner>(cards);
    Similarity place;
    place.translation = {1e6, 0, 0};
    const std::vector<Instance<Inner, Card>> scene{{&inner, cards, place}};
    std::size_t carried = 0;
    local_polygons(scene[0], {1e6, 0, 0}, [&](const Polygon& p) { carried += p.carried.get<Card>() != nullptr; });
    CHECK(carried == cards.size());

    using H = HierarchyOf<OpacityTensor>;
    const H with_paint = build<H, CardSampler>(cards, {});
    const std::vector<Instance<H, Card>> painted{{&with_paint, cards, place}};
    REQUIRE(with_paint.root_stand_in() != nullptr);
    carried = 0;
    local_polygons(painted[0], {1e6, 0, 0}, [&](const Polygon& p) { carried += !p.carried.is_empty(); });
    CHECK(carried == 0);
}
