// Polygons of files, cut into triangles.
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <span>
#include <utility>
#include <vector>

namespace farfield::scenes::detail {

/// Cuts one polygon after the other, in the memory that the last one took.
class Triangulator {
  public:
    using Triangle = std::array<std::uint32_t, 3>;

    /// n - 2 triangles for n corners, facing as the polygon does; none for fewer than three corners. Where all
    /// triangles of the fan around the first corner face the same way, which includes every convex polygon, they are
    /// that fan. Otherwise they are ears. A polygon may be concave, have holes that a bridge (an edge there and back)
    /// joins to its border, touch itself, have corners in line with their neighbors, and bend out of its plane as far
    /// as it does not overlap, seen along the axis that it faces most. One that crosses itself may cover more
    /// than its area. Corners that are not finite are allowed; such a polygon becomes a fan.
    const std::vector<Triangle>& operator()(std::span<const glm::dvec3> corners);

  private:
    enum class Care { strict, touching, none };
    static constexpr std::uint32_t nothing = ~std::uint32_t{0};

    bool flatten(std::span<const glm::dvec3> corners);
    void sort_into_rows();
    void cut_ears();
    double turn(std::uint32_t a, std::uint32_t b, std::uint32_t c) const;
    template <class F>
    bool any_within(const Triangle& ear, F&& f) const;
    bool blocks(std::uint32_t p, const Triangle& ear, bool strict) const;
    std::uint32_t blocker_of(std::uint32_t b, bool strict) const;
    bool is_spike(std::uint32_t b) const;
    void try_ear(std::uint32_t b, double flat, Care care);
    void cut_spikes();
    void cut(std::uint32_t b);
    void ask_again(std::uint32_t b);
    void release(std::uint32_t p);

    std::vector<Triangle> triangles_;
    std::vector<glm::dvec2> flat_;               ///< corners in a plane, counterclockwise
    std::vector<std::uint32_t> before_, after_;  ///< ring of the corners that are left
    std::uint32_t left_ = 0;
    std::vector<std::uint32_t> spikes_;
    std::vector<char> cut_, convex_;  ///< by corner; what has been cut off counts as convex
    // Whose turn it is, with the how-manieth time that is. A corner that another is in the way of waits for that one.
    std::vector<std::pair<std::uint32_t, std::uint32_t>> now_, next_;
    std::vector<std::uint32_t> asked_;
    struct Wait {
        std::uint32_t corner, asked, next;
    };
    std::vector<std::uint32_t> waiting_;  ///< by corner: the first of those that it is in the way of
    std::vector<Wait> waits_;
    // All corners from below to above, in rows of as many; within a row from left to right.
    struct Row {
        std::uint32_t begin, end;
        double lower, upper;
    };
    std::vector<Row> rows_;
    std::vector<std::uint32_t> in_rows_;
};

}  // namespace farfield::scenes::detail
