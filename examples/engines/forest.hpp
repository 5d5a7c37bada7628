// A forest as engines have it: a few trees, placed often, over ground. Each engine makes its own objects of it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

#include "farfield/geometry/rgba8.hpp"

namespace farfield::engines {

struct ForestOptions {
    int trees_a_side = 16;
    unsigned triangles_a_tree = 20'000;
    int kinds = 3;
};

/// Vertices that are the same are shared. The light is in the colors.
struct Mesh {
    std::vector<glm::vec3> vertices{};
    std::vector<Rgba8> colors{};
    std::vector<std::uint32_t> corners{};  ///< three a triangle
};

/// A tree scaled, then turned about y, then moved.
struct PlacedTree {
    std::size_t kind;
    double size, turn;
    glm::dvec3 at;
};

struct Eye {
    glm::dvec3 at, target;  ///< y is up
};

struct Forest {
    static constexpr double spacing_m = 8, height_m = 10;  ///< about, of trees

    explicit Forest(const ForestOptions& options);

    /// Down from above the edge to among the first trees; `along` from 0 to 1.
    Eye eye(double along) const;
    /// In all trees.
    std::size_t triangles() const;

    double half_extent;
    std::vector<Mesh> kinds{};
    std::vector<PlacedTree> trees{};
    Mesh ground{};
};

}  // namespace farfield::engines
