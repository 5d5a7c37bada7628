#include "engines/forest.hpp"

#include <map>
#include <random>
#include <tuple>

#include "scenes/generate/tree.hpp"

namespace farfield::engines {
namespace {

Mesh mesh_of(const std::vector<VertexColoredTriangle>& triangles) {
    Mesh mesh;
    std::map<std::tuple<float, float, float, std::uint32_t>, std::uint32_t> known;
    for (const auto& triangle : triangles) {
        for (std::size_t i = 0; i < 3; ++i) {
            const glm::vec3 p = triangle.vertices[i];
            const Rgba8 c = triangle.rgba[i];
            const auto [found, is_new] = known.try_emplace({p.x, p.y, p.z, std::uint32_t(c.r | c.g << 8 | c.b << 16)},
                                                           std::uint32_t(mesh.vertices.size()));
            if (is_new) {
                mesh.vertices.push_back(p);
                mesh.colors.push_back({c.r, c.g, c.b, 255});
            }
            mesh.corners.push_back(found->second);
        }
    }
    return mesh;
}

Mesh ground_of(double half) {
    const auto h = float(half + Forest::spacing_m);
    const Rgba8 grass{74, 92, 41};
    const glm::vec3 a(-h, 0, -h), b(-h, 0, h), c(h, 0, h), d(h, 0, -h);
    return mesh_of({{{a, b, c}, {grass, grass, grass}}, {{a, c, d}, {grass, grass, grass}}});
}

}  // namespace

Forest::Forest(const ForestOptions& options) : half_extent(spacing_m * options.trees_a_side / 2) {
    for (int kind = 0; kind < options.kinds; ++kind) {
        scenes::TreeOptions tree;
        tree.seed = std::uint64_t(kind + 1);
        tree.triangles = options.triangles_a_tree;
        tree.light.to_sun = glm::vec3(0, 1, 0);  // the same light however a tree is turned
        kinds.push_back(mesh_of(scenes::tree(tree).groups.front().triangles));
    }
    std::mt19937 random(7);
    const auto number = [&] { return double(random() % 4096) / 4096; };
    for (int row = 0; row < options.trees_a_side; ++row) {
        for (int column = 0; column < options.trees_a_side; ++column) {
            const double size = 0.8 + 0.4 * number(), turn = 6.28 * number();
            const double x = column + 0.2 + 0.6 * number(), z = row + 0.2 + 0.6 * number();
            trees.push_back({random() % unsigned(options.kinds),
                             size,
                             turn,
                             {x * spacing_m - half_extent, 0, z * spacing_m - half_extent}});
        }
    }
    ground = ground_of(half_extent);
}

Eye Forest::eye(double along) const {
    const double height = 6 * height_m * (1 - along) + 1.2 * height_m * along;
    const double back = half_extent + (1 - along) * 4 * height_m;
    return {{0.1 * half_extent, height, back}, {0, 0.3 * height_m, back - half_extent}};
}

std::size_t Forest::triangles() const {
    std::size_t sum = 0;
    for (const PlacedTree& tree : trees) sum += kinds[tree.kind].corners.size() / 3;
    return sum;
}

}  // namespace farfield::engines
