// Curves with a radius, as grass, hair and cables have. The source answers for a link of a curve as a prism of six
// sides; no prism is stored (primitive_source.hpp).
#include <algorithm>
#include <array>
#include <cmath>
#include <iostream>
#include <random>
#include <vector>

#include "farfield/farfield.hpp"
using namespace farfield;

struct Curves {
    static constexpr std::uint32_t links = 8;  // of each curve
    std::vector<glm::vec4> knots;              // links + 1 of each; w is the radius

    std::array<glm::vec4, 2> ends(std::uint32_t i) const { return {knots[i + i / links], knots[i + i / links + 1]}; }
    std::size_t primitive_count() const { return knots.size() / (links + 1) * links; }
    Work work(std::uint32_t) const { return {.triangles = 12}; }
    Box bounds(std::uint32_t i) const {
        const auto e = ends(i);
        const glm::vec3 a(e[0]), b(e[1]), reach(1.05f * std::max(e[0].w, e[1].w));
        return {glm::min(a, b) - reach, glm::max(a, b) + reach};
    }
    void polygons(std::uint32_t i, auto&& sink) const {
        static constexpr Rgba8 green{90, 140, 60};
        const auto e = ends(i);
        const glm::vec3 along(e[1] - e[0]), x(1, 0, 0), y(0, 1, 0);
        const glm::vec3 right = direction_of(normal_to(along, std::abs(along.y) > std::abs(along.x) ? x : y)),
                        up = direction_of(normal_to(along, right));
        const auto corner = [&](std::size_t end, int k) {  // as wide as a circle in the mean over all directions
            const float angle = 1.0471976f * float(k), reach = 1.0471976f * e[end].w;
            return glm::vec3(e[end]) + reach * (std::cos(angle) * right + std::sin(angle) * up);
        };
        for (int k = 0; k < 6; ++k) {
            const std::array<glm::vec3, 4> side{corner(0, k), corner(0, k + 1), corner(1, k + 1), corner(1, k)};
            sink(Polygon{side, {&green, 1}});
        }
    }
};

int main() {
    std::mt19937 random;
    const auto number = [&] { return float(random() % 2000) / 1000 - 1; };
    Curves meadow;
    for (int blade = 0; blade < 20'000; ++blade) {
        const glm::vec3 root(10 * number(), 0, 10 * number()), bend(0.2f * number(), 0, 0.2f * number());
        for (std::uint32_t k = 0; k <= Curves::links; ++k) {
            const float t = float(k) / Curves::links;
            meadow.knots.emplace_back(root + glm::vec3(0, 0.5f * t, 0) + bend * t * t, 0.01f * (1 - t));
        }
    }
    const auto hierarchy = build<SpatialHierarchy<Octree, OpacityTensor, TriangleCount>>(meadow);
    ZBufferRenderer renderer;
    auto viewer = make_viewer(hierarchy, meadow, renderer);
    const auto stats = viewer.frame({.camera = Camera::perspective({0, 30, 200}, {0, 0, 0}, {0, 1, 0}, 0.8f)});
    std::cout << stats.primitives << " links and " << stats.approximations << " stand-ins drawn for 160,000 links\n";
    return stats.approximations > 0 && stats.primitives < meadow.primitive_count() ? 0 : 1;
}
