// A protein-like molecule: the size of the one that Chamberlain et al. 1996 measure with (section 5: 6,534
// atoms as spheres of 800 triangles), with atoms of our own.
#pragma once

#include <cstdint>

#include "scenes/scene.hpp"

namespace farfield::scenes {

inline constexpr std::size_t molecule_atoms = 6'534;
inline constexpr std::size_t molecule_triangles_per_atom = 800;

/// World units are angstroms. The 800 triangles of an atom follow each other, counter-clockwise seen from
/// outside, each of a single color; atoms are in the order of the chain, so neighbors in the array are
/// neighbors in space. Centers are at least 1.2 apart; spheres have van der Waals radii and overlap.
Scene molecule(std::uint64_t seed = 1);

}  // namespace farfield::scenes
