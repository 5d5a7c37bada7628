// Atoms and particles drawn as spheres; shared by the molecule and the loaders.
#pragma once

#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "farfield/geometry/rgba8.hpp"
#include "farfield/primitive/triangle.hpp"
#include "scenes/generate/sphere.hpp"

namespace farfield::scenes {

struct Atom {
    glm::vec3 center;
    float radius;
    Rgba8 color;
};

/// One copy of `sphere` an atom, in order; each triangle of one color, lit by a fixed light. Deep in a crowd
/// of atoms the light is dimmer, so that the surface reads as one.
std::vector<VertexColoredTriangle> spheres(std::span<const Atom> atoms, const UnitSphere& sphere,
                                           glm::vec3 up = {0, 1, 0});

}  // namespace farfield::scenes
