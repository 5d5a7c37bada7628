// Scenes from files.
#pragma once

#include <cstdint>
#include <filesystem>
#include <glm/vec3.hpp>

#include "scenes/scene.hpp"

namespace farfield::scenes {

struct LoadOptions {
    /// Multiplies colors by the light that falls on a face from above and in front, between 0.35 and 1, so
    /// that a mesh of one color can be made out. False keeps the colors of the file.
    bool bake_light = true;
    /// What is up in the file, along one of its axes: the scene's up, and where the light is above. Coordinates stay as
    /// they are.
    glm::vec3 up{0, 1, 0};
    /// Atoms are spheres of 320, 80 or 20 triangles: the finest that stays within this sum, else 20.
    std::uint64_t sphere_triangle_budget = 1'000'000;
};

/// By extension, ignoring case, or by content where the name has none that is known; packed by gzip or not. Always one
/// group of triangles.
///
///     .off .oogl             Object File Format with all its prefixes, text and binary; vertex or face colors;
///                            lists, instances, quadrilaterals and meshes
///     .ply                   text and binary; faces, strips and fans; vertex or face colors
///     .obj                   vertex color times material color times texture, taken at the corners; what has none
///                            of them is gray
///     .gltf .glb             the same, of the default scene in the pose of its nodes; drawn from both sides, whatever
///                            doubleSided says. Only alphaMode BLEND gives colors that are not opaque.
///     .pdb .ent .cif .mmcif  first model, first alternate location; van der Waals spheres; angstroms
///     .xyz                   first frame; elements, or numbered types; columns as `Properties` names them
///     .ply .xyz .pts .pcd    clouds of points; see below
///     .dump .lammpstrj       LAMMPS text dump, first frame
///     .data .lmp             LAMMPS data file
///     .csv                   height field: a table of heights, or columns named x, y and z; y is up
///
/// Clouds are PLY files without faces, PCD files (text, binary, compressed), and tables of numbers with a point a line:
/// .pts, and .xyz unless it is a molecule, with a symbol before each atom or a line between count and atoms. A table
/// may begin with a count, or with names of its columns, in a comment or not. Of columns without names the numbers
/// decide: three of unit length are a normal; three whole numbers up to 255 or fractions up to 1 are a color, the first
/// three where several could be, but in .pts the second where an intensity comes first; one more is an intensity.
/// Intensities become grays where there are no colors. Points with a normal are discs of 4 triangles (192 bytes),
/// others balls of 8 (384 bytes). What a file does not say of radii and normals is taken from up to 16 neighbors;
/// scattered points, which lie close to no plane, stay balls. Points whose coordinates are not finite, which mean that
/// nothing was seen, are left out with a note.
///
/// Coordinates are read in double precision. Where single precision would be too coarse for them, the scene has an
/// origin of its own (Scene::origin); it looks the same near zero and far away. Polygons may be concave and have holes.
/// Triangles of no area are kept. What a file has and the scene has not (further models, lines, textures that cannot be
/// read) is said in Scene::notes; what would make it another picture (compressed meshes, extensions that a file
/// requires) is refused by name.
///
/// Throws std::runtime_error, one line "file: what is wrong", with the line, byte or index where one is known:
/// unreadable, cut short or contradicting itself, an index out of range, a coordinate of a mesh or an atom that is not
/// finite, a scene larger than 2^100 or smaller than 2^-100, or nothing to draw. No count that a file claims is
/// believed before the file is seen to have room for it.
Scene load(const std::filesystem::path& file, const LoadOptions& options = {});

}  // namespace farfield::scenes
