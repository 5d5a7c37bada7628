// Leaf cards with alpha, and walls with textures: polygons carry what the sampler knows how to paint, and stand-ins get
// the colors and the opacity of texels instead of those of cards.
#include <array>
#include <iostream>
#include <random>
#include <vector>

#include "farfield/farfield.hpp"
using namespace farfield;
using Hierarchy = SpatialHierarchy<Octree, OpacityTensor, TriangleCount>;

struct Card {
    std::array<glm::vec3, 4> corners;
    const TextureLevels* material = nullptr;
    std::array<glm::vec2, 4> at{{{0, 0}, {1, 0}, {1, 1}, {0, 1}}};
    Box bounds() const {
        const auto& [a, b, c, d] = corners;
        return {glm::min(glm::min(a, b), glm::min(c, d)), glm::max(glm::max(a, b), glm::max(c, d))};
    }
    void polygons(auto&& sink) const {
        static constexpr Rgba8 color{70, 120, 50};  // for whoever does not know the texture
        sink(Polygon{corners, {&color, 1}, false, *this});
    }
};
struct CardSampler : GridSampler {
    void paint(const Polygon& polygon, const Box& seen, float finest, auto&& sink) const {
        const Card* card = polygon.carried.get<Card>();
        if (card == nullptr || card->material == nullptr) return sink(polygon);
        paint_texture(polygon, card->at, *card->material, seen, finest, sink);
    }
};

int main() {
    std::vector<Rgba8> texels;  // a round leaf, a quarter of its card
    for (int i = 0; i < 64 * 64; ++i) {
        texels.push_back({50, 140, 30, std::uint8_t(glm::length(glm::vec2(i % 64, i / 64) - 31.5f) < 18 ? 255 : 0)});
    }
    const TextureLevels leaf(64, 64, texels);
    std::mt19937 random;
    const auto number = [&] { return float(random() % 2000) / 1000 - 1; };
    const auto point = [&] { return glm::vec3{number(), number(), number()}; };
    std::vector<Card> tree;
    while (tree.size() < 20'000) {
        const glm::vec3 a = point(), u = 0.02f * point(), v = 0.02f * point();
        if (glm::length(a) < 1) tree.push_back({{a, a + u, a + u + v, a + v}, &leaf});
    }
    const auto painted = build<Hierarchy, CardSampler>(tree, {}), cards = build<Hierarchy>(tree);
    ZBufferRenderer renderer;
    const auto opacity = [&](const Hierarchy& hierarchy) {
        auto viewer = make_viewer(hierarchy, tree, renderer);
        viewer.frame({.camera = Camera::perspective({0, 0, 40}, {0, 0, 0}, {0, 1, 0}, 0.4f), .tolerance_px = 8});
        double sum = 0;
        for (const Rgba8 c : renderer.image().pixels()) sum += c.a / 255.0;
        return sum;
    };
    const double leaves = opacity(painted), all = opacity(cards);
    std::cout << "leaves cover " << leaves << " pixels, their cards would cover " << all << "\n";
    return leaves > 0.2 * all && leaves < 0.6 * all ? 0 : 1;
}
