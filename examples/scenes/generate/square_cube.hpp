// The color cube that Greene 1996 tiles against a painter's algorithm (section 9 and figure 5), made anew. The
// text says only "the color-cube model of figure 5, composed of 192 presorted front-facing squares", and the figure is
// not at hand. Two cubes have half of 384 squares turned to a viewer on their diagonal, and both are here.
#pragma once

#include <cstdint>

#include "farfield/view.hpp"
#include "scenes/scene.hpp"

namespace farfield::scenes {

enum class SquareCubeForm : std::uint8_t {
    /// One cube, three faces of 8 x 8 squares: no square hides another.
    faces,
    /// 4 x 4 x 4 cubes apart from each other, three squares each. Squares hide squares, so that sorting them is worth
    /// mentioning and a painter overwrites pixels.
    cubes,
};

struct SquareCubeOptions {
    SquareCubeForm form = SquareCubeForm::faces;
    float side_m = 2.0f;
    /// Between neighboring cubes, as a part of the side of one of them. Inferred: nothing is said.
    float gap = 1.0f;
};

/// 192 squares of two triangles each, around the origin, facing +x, +y or +z. Sorted front to back for every eye
/// beyond the cube on all three axes: read backwards for a painter. The color of a square is its place in the cube as
/// red, green and blue, flat and without light (inferred from the model's name). Throws std::invalid_argument for a
/// side that is not positive and finite and a gap that is negative or not finite.
Scene square_cube(const SquareCubeOptions& options = {});

/// From the diagonal (1, 1, 1), all of the cube in view, from two and a half sides away (inferred).
Camera square_cube_camera(const SquareCubeOptions& options = {});

}  // namespace farfield::scenes
