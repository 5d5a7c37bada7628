// A hall of tumbling parts: bodies that move through a static building, for what Greene 1996, section 6.2 does with
// moving objects.
#pragma once

#include <cstdint>
#include <glm/mat4x4.hpp>
#include <string>
#include <vector>

#include "farfield/primitive/triangle.hpp"
#include "farfield/view.hpp"
#include "scenes/scene.hpp"

namespace farfield::scenes {

struct TumblingHallOptions {
    std::uint64_t seed = 1;
    std::size_t bodies = 12;
    std::size_t rooms_per_side = 4;  ///< of the one corridor, in which most bodies move
};

/// One that moves. It is closed, counter-clockwise seen from outside, about its own middle at the origin.
struct Body {
    std::string shape;  ///< box, ball, gem, star, ring or angle, in turns
    bool is_convex = false;
    std::vector<VertexColoredTriangle> triangles{};
};

/// Every triangle has one color, so that a renderer that shades once a pixel draws what one draws that shades samples.
/// Bodies keep the light that they were made in. Meters, y up.
struct TumblingHall {
    TumblingHallOptions options;
    std::vector<VertexColoredTriangle> building;  ///< one floor of scenes::building(), expanded
    std::vector<Body> bodies;
};

/// Same options, same bytes. Throws std::invalid_argument for no bodies or rooms.
TumblingHall tumbling_hall(const TumblingHallOptions& options = {});

/// Where the bodies are: a rigid motion for each, continuous in t and back where it began when t grows by 1. Every
/// third one flies through doors from room to room, across the corridor, all others along it. They pass through each
/// other, and through furniture.
std::vector<glm::mat4> placements_at(const TumblingHall& hall, double t);

/// The same as groups: the building, each body, and a root that places them in this order.
Scene scene_at(const TumblingHall& hall, double t);

/// At one end of the corridor, looking along it.
Camera inside_tumbling_hall(const TumblingHall& hall);

}  // namespace farfield::scenes
