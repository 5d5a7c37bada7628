// Rays, and where they meet boxes and triangles.
#pragma once

#include "farfield/settings.hpp"

#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <limits>

namespace farfield {

/// The points origin + distance * direction for distances in [nearest, farthest]. The direction may have any length but
/// 0: distances are counted in it.
struct Ray {
    glm::dvec3 origin{0.0};
    glm::dvec3 direction{0, 0, -1};
    double nearest = 0;
    double farthest = std::numeric_limits<double>::infinity();

    glm::dvec3 at(double distance) const { return origin + distance * direction; }

    /// Whether it has a direction, and all its numbers are numbers; `farthest` may be infinite.
    bool is_valid() const {
        const auto is_finite = [](glm::dvec3 v) {
            return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
        };
        return is_finite(origin) && is_finite(direction) && direction != glm::dvec3(0) && nearest <= farthest;
    }
};

namespace detail {

inline constexpr double missed = std::numeric_limits<double>::infinity();

/// Meets boxes and triangles along one ray, with what is the same for all of them computed once.
class RayMeeter {
  public:
    explicit RayMeeter(const Ray& ray) : ray_(ray) {
        const glm::dvec3 size = glm::abs(ray.direction);
        along_ = size.x > size.y ? (size.x > size.z ? 0 : 2) : (size.y > size.z ? 1 : 2);
        shear_ = glm::dvec2(ray.direction[first()], ray.direction[second()]) / ray.direction[along_];
        // 1 / 0 would make 0 * infinity of what lies just beside; this makes 0, and infinities farther away.
        constexpr double almost_none = std::numeric_limits<double>::min();
        for (int i = 0; i < 3; ++i) inverse_[i] = 1 / (size[i] < almost_none ? almost_none : ray.direction[i]);
    }

    const Ray& ray() const { return ray_; }

    /// The distance at which the ray enters a box, `nearest` inside of it, or `missed`. It errs towards an early entry
    /// and a hit: boxes are taken for a millionth larger than their coordinates say, which are rounded to single
    /// precision.
    double entry_distance(glm::vec3 center, glm::vec3 half) const {
        constexpr float rounding = 0x1p-20f;
        const glm::dvec3 reach(half + rounding * (glm::abs(center) + half)), ahead = glm::dvec3(center) - ray_.origin;
        const glm::dvec3 one = (ahead - reach) * inverse_, other = (ahead + reach) * inverse_;
        const glm::dvec3 low = glm::min(one, other), high = glm::max(one, other);
        const double enter = glm::max(glm::max(low.x, low.y), glm::max(low.z, ray_.nearest));
        const double leave = glm::min(glm::min(high.x, high.y), glm::min(high.z, ray_.farthest));
        return enter <= leave ? enter : missed;
    }

    /// The distance of a triangle, from either side, or `missed`. One that is seen edge on, or has no area, is missed.
    /// Triangles that share edges or corners leave no gap between them: corners are moved along the ray into a plane,
    /// each by itself, and the side of an edge on which the ray passes is told by comparing two products, of which
    /// rounding never makes the smaller one the larger (Woop, Benthin, Wald: Watertight Ray/Triangle Intersection,
    /// 2013, do the same in single precision, with a second try in double precision at 0).
    double distance_to(glm::dvec3 a, glm::dvec3 b, glm::dvec3 c) const {
        a -= ray_.origin;
        b -= ray_.origin;
        c -= ray_.origin;
        const glm::dvec2 in_plane_a = in_plane(a), in_plane_b = in_plane(b), in_plane_c = in_plane(c);
        const int past_a = side(in_plane_b, in_plane_c), past_b = side(in_plane_c, in_plane_a),
                  past_c = side(in_plane_a, in_plane_b);
        const bool is_inside =
            (past_a >= 0 && past_b >= 0 && past_c >= 0) || (past_a <= 0 && past_b <= 0 && past_c <= 0);
        if (!is_inside) return missed;
        const glm::dvec3 normal = glm::cross(b - a, c - a);
        const double distance = glm::dot(a, normal) / glm::dot(ray_.direction, normal);
        return distance >= ray_.nearest && distance <= ray_.farthest && distance < missed ? distance : missed;
    }

  private:
    int first() const { return (along_ + 1) % 3; }
    int second() const { return (along_ + 2) % 3; }
    glm::dvec2 in_plane(glm::dvec3 p) const { return glm::dvec2(p[first()], p[second()]) - shear_ * p[along_]; }
    static int side(glm::dvec2 from, glm::dvec2 to) {
        const double one = from.x * to.y, other = from.y * to.x;
        return int(one > other) - int(one < other);
    }

    Ray ray_;
    int along_ = 2;  ///< the axis along which the direction is longest
    glm::dvec2 shear_{0.0};
    glm::dvec3 inverse_{1.0};
};

}  // namespace detail

}  // namespace farfield
