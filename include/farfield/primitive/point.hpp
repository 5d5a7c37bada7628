// A point of a cloud, as scanners and simulations give them: a disc where the surface's direction is known, else a
// ball.
//
// Both are few polygons whose area is right, so that a far field sampled from them has the opacity of the round ones.
// A splat that turns towards the viewer (Rusinkiewicz and Levoy 2000, "QSplat", section 4.3) was rejected: what lies in
// a hierarchy is the same from everywhere.
#pragma once

#include "farfield/settings.hpp"

#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include "farfield/cost_model.hpp"
#include "farfield/geometry/box.hpp"
#include "farfield/geometry/length.hpp"
#include "farfield/geometry/polygon.hpp"
#include "farfield/geometry/rgba8.hpp"

namespace farfield {

/// A disc or a ball of one color. Neither a radius of 0 nor several points at one place are special.
///
/// A disc is a regular hexagon of the disc's area, so that its projected area is right from every direction; corners
/// are 1.10 radii from the position. A ball is an octahedron of the ball's surface. By Cauchy's formula the projected
/// area of a convex body is a quarter of its surface, in the mean over all directions; here, too, that is the area of a
/// circle of the radius. From single directions it is between 18 % below (along the middle of an edge) and 15 % above
/// (along a corner); corners are 1.35 radii from the position. A tetrahedron has the same limits with half the faces,
/// but reaches to 1.65 radii, and looks it.
struct Point {
    glm::vec3 position{0.0f};
    float radius = 0.0f;  ///< world units, not negative
    /// The side from which the disc is counter-clockwise; of any length. 0: a ball.
    glm::vec3 normal{0.0f};
    Rgba8 rgba{};

    bool is_disc() const { return normal != glm::vec3(0.0f); }

    /// Encloses the polygons; not finite if the position, the radius or the normal is not.
    Box bounds() const {
        Box box = Box::empty();
        glm::vec3 zero(0.0f);
        const auto add = [&](const glm::vec3& corner) {
            zero += corner * 0.0f;
            box.add(corner);
        };
        if (is_disc()) {
            for (const glm::vec3& corner : disc()) add(corner);
        } else {
            const float reach = octahedron_reach * radius;
            add(position - reach);
            add(position + reach);
        }
        return {box.lower + zero, box.upper + zero};
    }
    /// The sum of the polygons' one-sided areas, in squared world units: of a disc pi r^2, of a ball 4 pi r^2.
    double area() const {
        constexpr double pi = 3.14159265358979323846;
        const double r = static_cast<double>(radius);
        return (is_disc() ? pi : 4.0 * pi) * r * r;
    }
    glm::vec4 color() const { return to_vec4(rgba); }
    Work work() const { return {.triangles = is_disc() ? 4.0f : 8.0f}; }
    template <class Sink>
    void polygons(Sink&& sink) const {
        if (is_disc()) {
            const std::array<glm::vec3, 6> corners = disc();
            sink(Polygon{corners, {&rgba, 1}});
            return;
        }
        const float reach = octahedron_reach * radius;
        for (unsigned octant = 0; octant < 8; ++octant) {
            const bool x = (octant & 1) != 0, y = (octant & 2) != 0, z = (octant & 4) != 0;
            std::array<glm::vec3, 3> corners{position, position, position};
            corners[0].x += x ? -reach : reach;
            // An odd number of mirrors turns the face around.
            const std::size_t second = x != y ? (z ? 1 : 2) : (z ? 2 : 1);
            corners[second].y += y ? -reach : reach;
            corners[3 - second].z += z ? -reach : reach;
            sink(Polygon{corners, {&rgba, 1}});
        }
    }

  private:
    /// How far a corner of the hexagon is from the middle, where the disc has the radius 1: sqrt(2 pi / sqrt(27)).
    static constexpr float hexagon_reach = 1.0996361f;
    /// The same for an octahedron, where the ball has the radius 1: sqrt(pi / sqrt(3)).
    static constexpr float octahedron_reach = 1.3467736f;

    /// Two axes squarely to the normal: Duff et al. 2017, "Building an orthonormal basis, revisited".
    std::array<glm::vec3, 6> disc() const {
        const glm::vec3 n = direction_of(normal);
        const float sign = std::copysign(1.0f, n.z), a = -1.0f / (sign + n.z), b = n.x * n.y * a;
        const glm::vec3 u = hexagon_reach * radius * glm::vec3(1.0f + sign * n.x * n.x * a, sign * b, -sign * n.x);
        const glm::vec3 v = hexagon_reach * radius * glm::vec3(b, sign + n.y * n.y * a, -n.y);
        const glm::vec3 half = 0.5f * u, up = 0.8660254f * v;
        return {position + u, position + half + up, position - half + up,
                position - u, position - half - up, position + half - up};
    }
};
static_assert(sizeof(Point) == 32 || !vectors_are_packed);

}  // namespace farfield
