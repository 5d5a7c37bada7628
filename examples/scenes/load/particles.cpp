#include "scenes/load/particles.hpp"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "scenes/load/atoms.hpp"

namespace farfield::scenes::detail {
namespace {

/// The median, over a few of the atoms, of how far the nearest atom at another place is. 0 if there is none. A box
/// around all would say little: one atom that has escaped makes it as large as you like.
double nearest_distance(const std::vector<Atom>& atoms) {
    constexpr std::size_t most = 64;
    const std::size_t step = (atoms.size() + most - 1) / most;
    std::vector<double> distances;
    for (std::size_t i = 0; i < atoms.size(); i += step) {
        const glm::dvec3 center(atoms[i].center);
        double nearest = std::numeric_limits<double>::infinity();
        for (const Atom& other : atoms) {
            const glm::dvec3 d = glm::dvec3(other.center) - center;
            const double squared = glm::dot(d, d);
            if (squared > 0 && squared < nearest) nearest = squared;
        }
        if (std::isfinite(nearest)) distances.push_back(std::sqrt(nearest));
    }
    if (distances.empty()) return 0.0;
    const auto middle = distances.begin() + static_cast<std::ptrdiff_t>(distances.size() / 2);
    std::nth_element(distances.begin(), middle, distances.end());
    return *middle;
}

/// Particles without a radius: half the edge of the cube that each would have to itself.
void set_radii(std::vector<Atom>& atoms) {
    Box box = Box::empty();
    for (const Atom& atom : atoms) box.add(atom.center);
    const float least = 0.01f * box.largest_side();
    const glm::vec3 size = glm::max(box.size(), glm::vec3(least));
    // The cube root of each side first: the product of three may be too large.
    float edge =
        std::cbrt(size.x) * std::cbrt(size.y) * std::cbrt(size.z) / std::cbrt(static_cast<float>(atoms.size()));
    // Particles spread at random are 0.55 edges from the nearest (Hertz 1909; Chandrasekhar 1943, "Stochastic problems
    // in physics and astronomy", equation 675). If it is far less, most of the box is empty and says nothing.
    const auto nearest = static_cast<float>(nearest_distance(atoms));
    if (nearest > 0 && edge > 4.0f * nearest) edge = 1.8f * nearest;
    for (Atom& atom : atoms) atom.radius = edge > 0 ? 0.5f * edge : 1.0f;
}

/// Nanometers, meters: bonds are 0.74 (hydrogen) to 3 angstroms long, so that what is nearer than 0.47 is in a unit
/// that is larger by powers of ten.
void scale_radii(std::vector<Atom>& atoms) {
    const double nearest = nearest_distance(atoms);
    double unit = 1.0;
    while (nearest > 0 && nearest < 0.47 * unit) unit /= 10.0;
    if (unit == 1.0) return;
    for (Atom& atom : atoms) atom.radius = static_cast<float>(static_cast<double>(atom.radius) * unit);
}

}  // namespace

Loaded drawn(Particles particles, const LoadOptions& options) {
    if (particles.all.empty()) throw std::runtime_error("has no atoms");
    BoxD box = BoxD::empty();
    for (const Particle& particle : particles.all) box.add(particle.center);
    Loaded loaded;
    loaded.lit = true;
    loaded.is_closed = true;
    loaded.notes = std::move(particles.notes);
    loaded.origin = origin_of_centers(box);
    check_size(box);
    std::vector<Atom> atoms;
    atoms.reserve(particles.all.size());
    for (const Particle& particle : particles.all) {
        atoms.push_back({in_single_precision(particle.center, loaded.origin, "atom", atoms.size()), particle.radius,
                         particle.color});
    }
    if (particles.radii_missing) {
        set_radii(atoms);
    } else if (particles.radii_of_elements) {
        scale_radii(atoms);
    }
    int levels = 2;
    while (levels > 0 && atoms.size() * (std::uint64_t{20} << (2 * levels)) > options.sphere_triangle_budget) {
        --levels;
    }
    loaded.triangles = spheres(atoms, icosphere(levels), options.up);
    if (!options.bake_light) {
        const std::size_t each = loaded.triangles.size() / atoms.size();
        for (std::size_t t = 0; t < loaded.triangles.size(); ++t) loaded.triangles[t].rgba.fill(atoms[t / each].color);
    }
    return loaded;
}

}  // namespace farfield::scenes::detail
