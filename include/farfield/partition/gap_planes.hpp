// The best plane across a few directions: gaps of several are weighed against one another (Shade et al. 1996, section
// 4).
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <limits>
#include <vector>

#include "farfield/partition.hpp"
#include "farfield/partition/extent.hpp"
#include "farfield/partition/gap_search.hpp"
#include "farfield/partition/plane_sides.hpp"

namespace farfield::detail {

/// extents(normal, out) appends what the items, `count` at the most, take up along a normal; is_good(plane) says
/// whether a plane may be taken. False if no plane tells any apart.
///
/// The longest extent comes first, and no other is looked along where that has as good a gap as there is. The three
/// axes are looked along too where no plane across the directions crosses less than half of the items, and where the
/// cell is more than twice as long along an axis as along any direction.
template <std::size_t count_of_directions, class Extents, class IsGood>
bool best_gap_plane(const Cell& cell, const std::array<glm::vec3, count_of_directions>& directions, GapSearch& search,
                    std::size_t count, Extents&& extents, IsGood&& is_good, CuttingPlane& plane) {
    constexpr float good_price = 1.05f;
    struct Choice {
        CuttingPlane plane;
        Gap gap;
    };
    std::vector<Extent> along;
    along.reserve(count);
    std::array<Choice, count_of_directions + 3> choices;
    std::size_t size = 0;
    bool has_gap = false;
    float price = std::numeric_limits<float>::infinity();
    const auto look_along = [&](glm::vec3 direction) {
        if (direction == glm::vec3(0)) return;
        along.clear();
        extents(direction, along);
        const Gap gap = search.best(along);
        if (gap.is_found()) choices[size++] = {{direction, gap.at}, gap};
        has_gap = has_gap || (gap.is_found() && 2 * gap.active <= along.size());
        price = std::min(price, gap.price);
    };
    std::array<glm::vec3, count_of_directions> by_length;
    for (std::size_t i = 0; i < by_length.size(); ++i) by_length[i] = unit_direction(directions[i]);
    const auto length = [&](glm::vec3 normal) { return glm::dot(glm::abs(normal), cell.half); };
    std::stable_sort(by_length.begin(), by_length.end(),
                     [&](glm::vec3 a, glm::vec3 b) { return length(a) > length(b); });
    const float longest_axis = std::max(cell.half.x, std::max(cell.half.y, cell.half.z));
    const bool is_long = longest_axis > 2 * length(by_length[0]);
    for (const glm::vec3& d : by_length) {
        // The least price of all is 1: a shorter direction has next to nothing to gain on such a gap.
        if (price <= good_price && !is_long) break;
        look_along(d);
    }
    if (!has_gap || is_long) {
        for (int axis = 0; axis < 3; ++axis) look_along(glm::vec3(axis == 0, axis == 1, axis == 2));
    }
    float longest = 0;
    for (std::size_t i = 0; i < size; ++i) longest = std::max(longest, choices[i].gap.length);
    // A direction half as long as the longest must have a gap at half the price.
    for (std::size_t i = 0; i < size; ++i) choices[i].gap.price *= longest / choices[i].gap.length;
    const auto end = choices.begin() + std::ptrdiff_t(size);
    for (std::size_t tried = 0; tried < size; ++tried) {
        Choice& best = *std::min_element(choices.begin(), end,
                                         [](const Choice& a, const Choice& b) { return a.gap.price < b.gap.price; });
        if (is_good(best.plane)) {
            plane = best.plane;
            return true;
        }
        best.gap.price = std::numeric_limits<float>::infinity();
    }
    return false;
}

}  // namespace farfield::detail
