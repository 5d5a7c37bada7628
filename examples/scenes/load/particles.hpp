// Atoms and particles as files have them, and the spheres that they become; shared by their loaders, not for users.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <string>
#include <vector>

#include "farfield/geometry/rgba8.hpp"
#include "scenes/load/element.hpp"
#include "scenes/load/load_detail.hpp"
#include "scenes/load/mesh.hpp"

namespace farfield::scenes::detail {

struct Particle {
    glm::dvec3 center;
    float radius;  ///< of the file, or of the element in angstroms
    Rgba8 color;
};

struct Particles {
    std::vector<Particle> all{};
    /// Some radius is not known: all particles then get one that suits their distances.
    bool radii_missing = false;
    /// Radii are elements': they are scaled by a power of ten if centers are so near to each other that their unit
    /// cannot be the angstrom.
    bool radii_of_elements = true;
    std::vector<std::string> notes{};
};

inline const Element& element_or_unknown(std::string_view symbol) {
    const Element* element = find_element(symbol);
    return element ? *element : unknown_element;
}

/// The `i`-th of the words as a number; throws with the line and what was `wanted`.
template <class T>
T word_as(const Lines& lines, const std::vector<std::string_view>& words, std::size_t i, std::string_view wanted) {
    if (i >= words.size()) lines.fail("no " + std::string(wanted));
    const std::optional<T> value = number<T>(words[i]);
    if (!value) lines.fail(in_quotes(words[i]) + " where " + std::string(wanted) + " should be");
    return *value;
}

/// One sphere a particle, in order, with the light in the colors if `options` ask for it. Throws if there are none.
Loaded drawn(Particles particles, const LoadOptions& options);

}  // namespace farfield::scenes::detail
