// Axis-aligned boxes, in single precision for everything inside a hierarchy and in double for all that users bring.
#pragma once

#include "farfield/settings.hpp"

#include <cmath>
#include <glm/common.hpp>
#include <glm/vec3.hpp>
#include <limits>

namespace farfield {

/// GLM_FORCE_DEFAULT_ALIGNED_GENTYPES makes vectors of three take as much as vectors of four. Everything takes more
/// memory then, and is drawn alike, but nothing can be stored: files hold twelve bytes.
inline constexpr bool vectors_are_packed = sizeof(glm::vec3) == 12 && sizeof(glm::dvec3) == 24;

/// A closed axis-aligned box; `lower` and `upper` are both inside. A point is a box of size zero. A box with
/// lower > upper on any axis is *empty*: it contains nothing and adding it to another box changes nothing.
template <class T>
struct BasicBox {
    glm::vec<3, T> lower;
    glm::vec<3, T> upper;

    /// The identity of `add`: lower = +infinity, upper = -infinity.
    static constexpr BasicBox empty() {
        constexpr T infinity = std::numeric_limits<T>::infinity();
        return {glm::vec<3, T>(infinity), glm::vec<3, T>(-infinity)};
    }

    bool is_empty() const { return lower.x > upper.x || lower.y > upper.y || lower.z > upper.z; }

    /// False for NaN or infinity anywhere, and so for `empty()`.
    bool is_finite() const {
        for (int axis = 0; axis < 3; ++axis) {
            if (!std::isfinite(lower[axis]) || !std::isfinite(upper[axis])) return false;
        }
        return true;
    }

    /// Halves before adding: boxes near the largest number have a center too.
    glm::vec<3, T> center() const { return lower * T(0.5) + upper * T(0.5); }
    glm::vec<3, T> size() const { return upper - lower; }
    T largest_side() const {
        const glm::vec<3, T> s = size();
        return glm::max(s.x, glm::max(s.y, s.z));
    }

    void add(const glm::vec<3, T>& point) {
        lower = glm::min(lower, point);
        upper = glm::max(upper, point);
    }
    void add(const BasicBox& other) {
        lower = glm::min(lower, other.lower);
        upper = glm::max(upper, other.upper);
    }

    bool contains(const glm::vec<3, T>& p) const {
        return lower.x <= p.x && p.x <= upper.x && lower.y <= p.y && p.y <= upper.y && lower.z <= p.z && p.z <= upper.z;
    }
    /// Closed boxes: touching counts.
    bool intersects(const BasicBox& b) const {
        return lower.x <= b.upper.x && b.lower.x <= upper.x && lower.y <= b.upper.y && b.lower.y <= upper.y &&
               lower.z <= b.upper.z && b.lower.z <= upper.z;
    }

    friend bool operator==(const BasicBox&, const BasicBox&) = default;
};

using Box = BasicBox<float>;
using BoxD = BasicBox<double>;

}  // namespace farfield
