#include "scenes/generate/square_cube.hpp"

#include <cmath>
#include <stdexcept>

namespace farfield::scenes {
namespace {

using glm::vec3;

/// The side that faces `axis` of a box in units of the cube's side.
void add_square(std::vector<VertexColoredTriangle>& triangles, float side_m, vec3 lower, vec3 upper, int axis,
                vec3 place) {
    const auto world = [&](vec3 p) { return (p - 0.5f) * side_m; };
    vec3 b = upper, d = upper, a = upper;
    a[(axis + 1) % 3] = d[(axis + 1) % 3] = lower[(axis + 1) % 3];
    a[(axis + 2) % 3] = b[(axis + 2) % 3] = lower[(axis + 2) % 3];
    a = world(a), b = world(b), d = world(d);
    const vec3 c = world(upper);
    const Rgba8 color = to_rgba8(glm::vec4(place, 1.0f));
    triangles.push_back({{a, b, c}, {color, color, color}});
    triangles.push_back({{a, c, d}, {color, color, color}});
}

/// All eight by eight squares of the three faces through (1, 1, 1).
void add_faces(std::vector<VertexColoredTriangle>& triangles, float side_m) {
    constexpr int count = 8;
    constexpr float size = 1.0f / count;
    for (int axis = 0; axis < 3; ++axis) {
        for (int i = count - 1; i >= 0; --i) {
            for (int k = count - 1; k >= 0; --k) {
                vec3 corner(1.0f - size);
                corner[(axis + 1) % 3] = static_cast<float>(i) * size;
                corner[(axis + 2) % 3] = static_cast<float>(k) * size;
                vec3 place = corner * (static_cast<float>(count) / (count - 1));
                place[axis] = 1.0f;
                add_square(triangles, side_m, corner, corner + size, axis, place);
            }
        }
    }
}

/// Where two cubes differ on an axis, a plane across it parts them and has the eye on the side of the higher one: so
/// descending order is front to back.
void add_cubes(std::vector<VertexColoredTriangle>& triangles, float side_m, float gap) {
    constexpr int count = 4;
    // In double, so that the outermost sides are at 0 and 1 for any gap.
    const double sizes = count + (count - 1) * double(gap);
    const auto low = [&](vec3 index) { return vec3(glm::dvec3(index) * (1.0 + double(gap)) / sizes); };
    const auto high = [&](vec3 index) { return vec3((glm::dvec3(index) * (1.0 + double(gap)) + 1.0) / sizes); };
    for (int x = count - 1; x >= 0; --x) {
        for (int y = count - 1; y >= 0; --y) {
            for (int z = count - 1; z >= 0; --z) {
                const vec3 index(static_cast<float>(x), static_cast<float>(y), static_cast<float>(z));
                for (int axis = 0; axis < 3; ++axis) {
                    add_square(triangles, side_m, low(index), high(index), axis, index / float(count - 1));
                }
            }
        }
    }
}

}  // namespace

Scene square_cube(const SquareCubeOptions& options) {
    if (!(options.side_m > 0 && std::isfinite(options.side_m))) {
        throw std::invalid_argument("square_cube: the side must be positive and finite");
    }
    if (!(options.gap >= 0 && std::isfinite(options.gap))) {
        throw std::invalid_argument("square_cube: the gap must be finite and not negative");
    }
    Scene scene{"cube", std::vector<Group>(1)};
    auto& triangles = scene.groups[0].triangles;
    if (options.form == SquareCubeForm::faces) {
        add_faces(triangles, options.side_m);
    } else {
        add_cubes(triangles, options.side_m, options.gap);
    }
    return scene;
}

Camera square_cube_camera(const SquareCubeOptions& options) {
    const double along = 2.5 * options.side_m / std::sqrt(3.0);
    return Camera::perspective(glm::dvec3(along), glm::dvec3(0), {0, 1, 0}, 0.75f);
}

}  // namespace farfield::scenes
