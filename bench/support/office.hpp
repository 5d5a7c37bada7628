// The office building as benchmarks see it: cameras within and around it, and what a z-buffer gets to draw if somebody
// has left out by hand all rooms that cannot be seen.
#pragma once

#include <cmath>
#include <cstdint>
#include <glm/vec3.hpp>
#include <set>
#include <span>
#include <vector>

#include "farfield/primitive/triangle.hpp"
#include "farfield/renderer/z_buffer_renderer.hpp"
#include "farfield/view.hpp"
#include "scenes/framing.hpp"
#include "scenes/generate/building.hpp"
#include "scenes/scene.hpp"
#include "support/subject.hpp"

namespace farfield::bench {

constexpr int office_size_px = 512;

inline View office_view(const Camera& camera) {
    return {.camera = camera, .width = office_size_px, .height = office_size_px, .tolerance_px = 0};
}

inline View at_eye_level(glm::dvec3 eye, glm::dvec3 target) {
    return office_view(Camera::perspective(eye, target, {0, 1, 0}, 1.04719755f));
}

/// Plan of scenes::building: rooms of 4 x 5 on both sides of corridors 2.5 wide, stories of 3.5.
struct OfficePlan {
    scenes::BuildingOptions options;

    /// Where a room's back wall meets its wall towards lower x; odd rows look the other way.
    glm::dvec3 corner(int room, int floor, int row) const {
        return {4.0 * (room - 0.5 * double(options.rooms_per_side)), 3.5 * floor,
                12.5 * (row - 0.5 * double(options.corridors))};
    }

    /// The room, or the piece of a corridor as long as one is wide, that a triangle is counted to: above 0.
    std::uint32_t room_of(const VertexColoredTriangle& t) const {
        const glm::vec3 p = (t.vertices[0] + t.vertices[1] + t.vertices[2]) / 3.0f;
        const double x = double(p.x) / 4 + 0.5 * double(options.rooms_per_side);
        const double y = (double(p.y) + 0.25) / 3.5, z = double(p.z) / 12.5 + 0.5 * double(options.corridors);
        const double along = (z - std::floor(z)) * 12.5;
        const int zone = along < 5 ? 0 : along < 7.5 ? 1 : 2;
        const auto index = [](double v) { return std::uint32_t(std::lround(std::floor(v)) + 1) & 0x3f; };
        return 1 + (((index(y) << 6 | index(z)) << 6 | index(x)) * 3 + std::uint32_t(zone));
    }

    /// A walk through rooms, doors and corridors; the first is scenes::inside_building. Each view is followed, ten
    /// later, by what is seen from the same place of another room.
    std::vector<View> inside() const {
        std::vector<View> views{office_view(scenes::inside_building(options))};
        const auto walk = [&](glm::dvec3 middle, glm::dvec3 end, glm::dvec3 outer, glm::dvec3 last) {
            const auto from = [&](glm::dvec3 c, glm::dvec3 eye, glm::dvec3 target) {
                views.push_back(at_eye_level(c + eye, c + target));
            };
            from(middle, {2.0, 1.65, 4.5}, {2.0, 1.2, 0.0});    // from the door back at the desk
            from(middle, {2.0, 1.65, 6.25}, {2.0, 1.3, 0.0});   // from the corridor into the room
            from(middle, {2.0, 1.65, 6.25}, {8.0, 1.5, 6.25});  // along the corridor
            from(end, {0.5, 1.65, 6.25}, {40, 1.5, 6.25});      // along all of it
            from(middle, {1.0, 1.65, 6.6}, {5.0, 1.3, 3.0});    // aslant into doors
            from(outer, {2.2, 1.65, 4.2}, {1.8, 1.4, 0.0});     // towards a window
            from(outer, {0.8, 1.65, 0.8}, {2.6, 1.4, 5.0});     // out of its door
            from(outer, {1.0, 1.65, 3.4}, {6.0, 1.4, 3.7});     // through a door to the neighbor
            from(last, {3.0, 1.65, 10.0}, {1.5, 1.3, 6.0});     // the other side of the corridor
        };
        walk(corner(6, 2, 1), corner(0, 2, 1), corner(2, 1, 0), corner(9, 3, 2));
        const glm::dvec3 other = corner(8, 0, 2);
        views.push_back(at_eye_level(other + glm::dvec3(2.0, 1.65, 1.0), other + glm::dvec3(2.0, 1.4, 9.0)));
        walk(corner(3, 3, 1), corner(0, 4, 2), corner(10, 4, 0), corner(5, 1, 1));
        return views;
    }

    /// Around it, from the ground to above the roof; the first is scenes::outside_building.
    std::vector<View> outside() const {
        const double half = 0.0625;
        const glm::dvec3 size(4.0 * double(options.rooms_per_side), 3.5 * double(options.floors),
                              12.5 * double(options.corridors));
        const BoxD box{{-0.5 * size.x - half, -0.25, -0.5 * size.z - half},
                       {0.5 * size.x + half, size.y, 0.5 * size.z + half}};
        std::vector<View> views{office_view(scenes::outside_building(options))};
        for (int i = 0; i < 19; ++i) {
            const double angle = (5 + 360.0 / 19 * i) * 3.14159265358979 / 180, rise = 0.1 * (i % 5);
            views.push_back(office_view(scenes::framing(box, {std::sin(angle), rise, std::cos(angle)}, 0.785398163f)));
        }
        return views;
    }
};

/// Finds, for a view, all triangles of rooms of which at least one of the picture's 64 samples a pixel shows something.
class SeenRooms {
  public:
    SeenRooms(std::span<const VertexColoredTriangle> triangles, const OfficePlan& plan)
        : plan_(plan),
          numbered_(numbered(triangles, plan)),
          viewer_(numbered_.hierarchy, numbered_.primitives, renderer_) {}

    std::vector<VertexColoredTriangle> triangles(std::span<const VertexColoredTriangle> all, View view) {
        // A picture of room numbers, of as many pixels as there are samples.
        view.width *= 8;
        view.height *= 8;
        viewer_.frame(view);
        std::set<std::uint32_t> seen;
        std::uint32_t last = 0;
        for (const Rgba8 c : renderer_.image().pixels()) {
            const std::uint32_t room = std::uint32_t(c.r) | std::uint32_t(c.g) << 8 | std::uint32_t(c.b) << 16;
            if (room != last) seen.insert(last = room);
        }
        std::vector<VertexColoredTriangle> result;
        for (const VertexColoredTriangle& t : all) {
            if (seen.count(plan_.room_of(t)) != 0) result.push_back(t);
        }
        return result;
    }

  private:
    static std::vector<VertexColoredTriangle> numbered(std::span<const VertexColoredTriangle> triangles,
                                                       const OfficePlan& plan) {
        std::vector<VertexColoredTriangle> result(triangles.begin(), triangles.end());
        for (VertexColoredTriangle& t : result) {
            const std::uint32_t room = plan.room_of(t);
            t.rgba.fill({std::uint8_t(room), std::uint8_t(room >> 8), std::uint8_t(room >> 16), 255});
        }
        return result;
    }

    OfficePlan plan_;
    Built<ExactHierarchy> numbered_;
    ZBufferRenderer renderer_;
    Viewer<ExactHierarchy, VertexColoredTriangle, ZBufferRenderer> viewer_;
};

}  // namespace farfield::bench
