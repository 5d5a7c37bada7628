// Which points are near another: a grid of cells in a hash map.
#pragma once

#include <cmath>
#include <cstdint>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <unordered_map>
#include <utility>
#include <vector>

namespace farfield::scenes {

class PointGrid {
  public:
    /// `cell` in world units; queries up to that distance look at 27 cells.
    explicit PointGrid(float cell) : cell_(cell) {}

    void add(const glm::vec3& p) {
        cells_[key(coordinate(p.x), coordinate(p.y), coordinate(p.z))].push_back({count_++, p});
    }

    /// Calls `visit(index, point)` for the points within `distance` <= cell, ends included, in a fixed order. Of cells
    /// with more than `most_in_a_cell` points every second, third ... is looked at.
    template <class Visit>
    void for_each_within(const glm::vec3& p, float distance, Visit&& visit,
                         std::size_t most_in_a_cell = ~std::size_t{0}) const {
        const std::int64_t x = coordinate(p.x), y = coordinate(p.y), z = coordinate(p.z);
        for (std::int64_t dz = -1; dz <= 1; ++dz) {
            for (std::int64_t dy = -1; dy <= 1; ++dy) {
                for (std::int64_t dx = -1; dx <= 1; ++dx) {
                    const auto cell = cells_.find(key(x + dx, y + dy, z + dz));
                    if (cell == cells_.end()) continue;
                    const auto& points = cell->second;
                    const std::size_t step = (points.size() - 1) / most_in_a_cell + 1;
                    for (std::size_t i = 0; i < points.size(); i += step) {
                        const auto& [index, q] = points[i];
                        const glm::vec3 d = p - q;
                        if (glm::dot(d, d) <= distance * distance) visit(index, q);
                    }
                }
            }
        }
    }

    bool any_within(const glm::vec3& p, float distance) const {
        bool found = false;
        for_each_within(p, distance, [&](std::size_t, const glm::vec3&) { found = true; });
        return found;
    }

  private:
    // Clamped: what lies further out than 2^20 cells shares cells, which costs time, never correctness.
    std::int64_t coordinate(float v) const {
        constexpr float most = 1048575.0f;
        const float scaled = std::floor(v / cell_);
        return static_cast<std::int64_t>(scaled > most ? most : scaled > -most ? scaled : -most);
    }
    static std::uint64_t key(std::int64_t x, std::int64_t y, std::int64_t z) {
        constexpr std::uint64_t mask = (std::uint64_t{1} << 21) - 1;
        const auto bits = [](std::int64_t v) { return static_cast<std::uint64_t>(v) & mask; };
        return bits(x) << 42 | bits(y) << 21 | bits(z);
    }

    float cell_;
    std::size_t count_ = 0;
    std::unordered_map<std::uint64_t, std::vector<std::pair<std::size_t, glm::vec3>>> cells_;
};

}  // namespace farfield::scenes
