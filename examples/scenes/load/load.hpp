// Scenes from files.
#pragma once

#include <cstdint>
#include <filesystem>

#include "scenes/scene.hpp"

namespace farfield::scenes {

struct LoadOptions {
    /// Multiplies colors by the light that falls on a face from above and in front, between 0.35 and 1, so
    /// that a mesh of one color can be made out. False keeps the colors of the file.
    bool bake_light = true;
    /// Atoms are spheres of 320, 80 or 20 triangles: the finest that stays within this sum, else 20.
    std::uint64_t sphere_triangle_budget = 1'000'000;
};

/// By extension, ignoring case; always one group of triangles, colors opaque:
///
///     .off .oogl            Object File Format with all its prefixes, text only; vertex or face colors
///     .ply                  text and binary; vertex or face colors
///     .obj .gltf .glb       vertex colors times material color times base-color texture, taken at the
///     corners .pdb .ent             first model, first alternate location; van der Waals spheres; angstroms
///     .xyz                  first frame; elements, or numbered types
///     .dump .lammpstrj      LAMMPS text dump, first frame
///     .data .lmp            LAMMPS data file
///
/// Polygons in OFF and PLY are cut into fans, so they should be convex. Triangles of no area are kept.
///
/// Throws std::runtime_error, one line "file: what is wrong", with the line, byte or index where one is
/// known: unreadable, cut short or contradicting itself, an index out of range, a coordinate that is not
/// finite, or nothing to draw. No count that a file claims is believed before the file is seen to have room
/// for it.
Scene load(const std::filesystem::path& file, const LoadOptions& options = {});

}  // namespace farfield::scenes
