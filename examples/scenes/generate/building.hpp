// An office building that repeats: the kind of scene that Greene 1996 renders (section 9 and figures 4, 6 and 7), "a
// version of the modular office building" of Greene, Kass and Miller 1993, made anew. Of his we know that modules of
// octrees of BSP trees with about 16,000 quadrilaterals each are replicated over 408 stories to about 167 million
// quadrilaterals, once in a shell and once without. Plan and furniture are ours.
#pragma once

#include <cstdint>

#include "farfield/view.hpp"
#include "scenes/scene.hpp"

namespace farfield::scenes {

struct BuildingOptions {
    std::uint64_t seed = 1;
    /// All of one plan, every other one turned by half a turn.
    std::size_t floors = 5;
    /// Of a floor, side by side; each has rooms on both sides.
    std::size_t corridors = 3;
    /// Along each side of a corridor: a floor has 2 * corridors * rooms_per_side rooms.
    std::size_t rooms_per_side = 12;
    /// Differently furnished rooms, dealt out at random; at least 1.
    std::size_t room_kinds = 6;
    /// The outermost walls, which have windows without glass. Without them one looks into the outer rooms and along the
    /// corridors: figures 6 and 7.
    bool exterior_walls = true;
};

/// All triangles belong to closed boxes: twelve in a row a box, counter-clockwise seen from outside, two in a row a
/// quadrilateral. Boxes touch and now and then reach into each other; none is hollow. Meters, y up; the middle of
/// the plan is at the origin, the lowest floor is y = 0, with 0.25 of its slab below.
///
/// A room is 4 wide and 5 deep, a corridor 2.5 wide, a story 3.5 high; walls are 0.125 thick. Every room has an open
/// door to its corridor, opposite to the door across, and about every second wall between neighbors has one too. Groups
/// of furniture are placed in rooms, rooms and walls in a floor, floors in the root, which has the roof for its own.
/// All places are multiples of 1/32 except those of furniture, and turns are by multiples of 90 degrees, so that what
/// touches does so exactly.
///
/// The default has 360 rooms and 961,452 triangles when expanded, 938,772 without exterior walls. Throws
/// std::invalid_argument for no floors, corridors, rooms or room kinds.
Scene building(const BuildingOptions& options = {});

/// 408 floors of 306 rooms: 166,346,502 quadrilaterals in the memory of one floor, where the paper has about 167
/// million.
BuildingOptions building_of_408_floors();

/// Stands in a room in the middle of the building, behind the desk, and looks through its door into the room across
/// the corridor.
Camera inside_building(const BuildingOptions& options);

/// All of the building from outside, over a corner, 15 degrees above its middle; for images at least as wide as high.
Camera outside_building(const BuildingOptions& options);

}  // namespace farfield::scenes
