// The part of a triangle inside a box (Sutherland and Hodgman 1974), for sums of areas cell by cell.
#pragma once

#include "farfield/settings.hpp"

#include <array>
#include <cstddef>
#include <glm/vec3.hpp>
#include <span>

#include "farfield/geometry/box.hpp"

namespace farfield {

/// The part of a triangle that lies in a box: up to nine corners.
class ClippedTriangle {
  public:
    ClippedTriangle(const Box& box, const glm::vec3 (&triangle)[3]) : corners_{triangle[0], triangle[1], triangle[2]} {
        for (int axis = 0; axis < 3; ++axis) {
            cut(axis, box.lower[axis], 1);
            cut(axis, box.upper[axis], -1);
        }
    }

    /// The corners in the triangle's order; fewer than three where nothing is left.
    std::span<const glm::vec3> corners() const { return {corners_.data(), count_}; }

  private:
    void cut(int axis, float at, float sign) {
        std::array<glm::vec3, 9> kept{};
        std::size_t kept_count = 0;
        for (std::size_t i = 0; i < count_; ++i) {
            const glm::vec3 a = corners_[i], b = corners_[i + 1 < count_ ? i + 1 : 0];
            const float from = sign * (a[axis] - at), to = sign * (b[axis] - at);
            if (from >= 0 && kept_count < kept.size()) kept[kept_count++] = a;
            if ((from < 0) != (to < 0) && kept_count < kept.size()) {
                glm::vec3 crossing = a + (b - a) * (from / (from - to));
                crossing[axis] = at;
                kept[kept_count++] = crossing;
            }
        }
        corners_ = kept;
        count_ = kept_count;
    }

    std::array<glm::vec3, 9> corners_;
    std::size_t count_ = 3;
};

}  // namespace farfield
