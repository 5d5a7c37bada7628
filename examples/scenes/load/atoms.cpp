#include "scenes/load/atoms.hpp"

#include <cmath>

#include "scenes/generate/point_grid.hpp"
#include "scenes/light.hpp"

namespace farfield::scenes {
namespace {

/// For each atom the unit vector away from the crowd, times how one-sided the crowd is, in [0, 1].
std::vector<glm::vec3> openings(std::span<const Atom> atoms) {
    float mean_radius = 0.0f;
    for (const Atom& atom : atoms) mean_radius += atom.radius / static_cast<float>(atoms.size());
    if (!(mean_radius > 0.0f)) return std::vector<glm::vec3>(atoms.size(), glm::vec3(0.0f));
    // Squares of lengths near 1 do not leave single precision, whatever the unit; a power of two rounds nothing.
    const float unit = std::ldexp(1.0f, -std::ilogb(mean_radius));
    const float reach = 4.0f * mean_radius * unit;
    // Where atoms crowd far beyond what radii allow (some are very large, or at one place), a part of them speaks for
    // all: otherwise the work grows with the square. In crystals a cell has up to 60.
    constexpr std::size_t most_in_a_cell = 128;
    PointGrid grid(reach);
    for (const Atom& atom : atoms) grid.add(atom.center * unit);
    std::vector<glm::vec3> result;
    result.reserve(atoms.size());
    for (const Atom& atom : atoms) {
        const glm::vec3 center = atom.center * unit;
        glm::vec3 sum(0.0f);
        float count = 0.0f;
        const auto add = [&](std::size_t, const glm::vec3& other) {
            const glm::vec3 away = center - other;
            const float distance = glm::length(away);
            if (distance > 0.0f) {
                sum += away / distance;
                count += 1.0f;
            }
        };
        grid.for_each_within(center, reach, add, most_in_a_cell);
        result.push_back(count > 0.0f ? sum / count : glm::vec3(0.0f));
    }
    return result;
}

}  // namespace

std::vector<VertexColoredTriangle> spheres(std::span<const Atom> atoms, const UnitSphere& sphere, glm::vec3 up) {
    Light light;
    light.sun *= 0.55f;
    light.sky *= 1.15f;
    light.ground *= 2.0f;
    const std::vector<glm::vec3> open = openings(atoms);
    std::vector<VertexColoredTriangle> triangles;
    triangles.reserve(atoms.size() * sphere.size());
    for (std::size_t i = 0; i < atoms.size(); ++i) {
        const Atom& atom = atoms[i];
        const glm::vec3 albedo = linear_color(atom.color);
        // A lone atom is open to all sides; one in the crowd only where its neighbors are not.
        const float crowd = glm::length(open[i]);
        for (const auto& [a, b, c] : sphere) {
            const glm::vec3 normal = glm::normalize(a + b + c);
            const float towards = crowd > 0.0f ? glm::dot(normal, open[i]) : 1.0f;
            const float seen = std::clamp(0.55f + 0.9f * towards, 0.12f, 1.0f);
            const Rgba8 color = display_color(lit(light, albedo, with_y_up(normal, up), seen, seen));
            triangles.push_back(
                {{atom.center + a * atom.radius, atom.center + b * atom.radius, atom.center + c * atom.radius},
                 {color, color, color}});
        }
    }
    return triangles;
}

}  // namespace farfield::scenes
