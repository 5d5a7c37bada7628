// Parts of several bodies in one region of space, and the plane that divides them best.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <glm/vec3.hpp>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "farfield/frame/subtree.hpp"
#include "farfield/geometry/cell.hpp"
#include "farfield/geometry/fragments.hpp"
#include "farfield/geometry/polygon.hpp"
#include "farfield/merged_viewer/body_frame.hpp"
#include "farfield/merged_viewer/clip_stack.hpp"

namespace farfield::detail {

/// A subtree of a body and the planes that cut it.
struct BodyPart : Subtree {
    Box box = Box::empty();  ///< around the part that is left of it
    std::uint32_t body = 0;
    ClipList clips{};
    bool visibility_tested = false;  ///< since it was last cut or something was drawn before it
};

struct SidesOfPlane {
    std::vector<BodyPart> behind, in_front;
};

/// Puts parts on their sides of a plane of `body`, which crosses none of that body's own parts. Parts that it crosses
/// go to both sides, cut.
inline void divide(std::span<const BodyPart> parts, std::span<const BodyFrame> bodies, std::uint32_t body,
                   const LocalPlane& plane, ClipStack& clips, SidesOfPlane& sides) {
    sides.behind.clear();
    sides.in_front.clear();
    for (const BodyPart& part : parts) {
        const LocalPlane seen = bodies[part.body].seen(bodies[body], plane, part.cell);
        const PlaneRelation relation = side_of_box(seen, part.box);
        for (const Side side : {Side::behind, Side::in_front}) {
            std::vector<BodyPart>& there = side == Side::behind ? sides.behind : sides.in_front;
            if (relation == (side == Side::behind ? PlaneRelation::in_front : PlaneRelation::behind)) continue;
            there.push_back(part);
            if (relation != PlaneRelation::crossing) continue;
            there.back().clips = clips.with(part.clips, seen, side);
            there.back().visibility_tested = false;
        }
    }
}

/// The plane of the largest of some polygons that lie in one plane, positions [first, end).
inline LocalPlane plane_of_polygons(const Fragments& polygons, std::uint32_t first, std::uint32_t end,
                                    const Cell& cell) {
    glm::dvec3 largest(0);
    std::span<const glm::vec3> its_vertices;
    for (std::uint32_t at = first; at < end; ++at) {
        const std::span<const glm::vec3> v = polygons[at].vertices;
        const glm::dvec3 area = doubled_area<double>(v.size(), [&](std::size_t i) { return v[i]; });
        if (!its_vertices.empty() && !(glm::dot(area, area) > glm::dot(largest, largest))) continue;
        largest = area;
        its_vertices = v;
    }
    CuttingPlane plane{glm::vec3(glm::normalize(largest)), 0};
    double offset = 0;
    for (const glm::vec3& v : its_vertices) {
        offset += glm::dot(glm::dvec3(plane.normal), glm::dvec3(v) - glm::dvec3(cell.center));
    }
    plane.offset = float(offset / double(its_vertices.size()));
    return LocalPlane(plane, cell);
}

/// A face of the box around one of the parts.
struct SeparatingFace {
    std::size_t part = 0;
    int face = 0;
};

/// The face that divides the parts most evenly and cuts none of them, or few where there are many. Such faces are tried
/// before any plane within a body, so that bodies whose boxes do not meet are never cut.
inline std::optional<SeparatingFace> separating_face(std::span<const BodyPart> parts,
                                                     std::span<const BodyFrame> bodies) {
    constexpr std::size_t most_boxes = 8;
    constexpr int price_of_cut = 4;
    std::optional<SeparatingFace> best;
    int least = std::numeric_limits<int>::max();
    const std::size_t boxes = std::min(parts.size(), most_boxes);
    for (std::size_t k = 0; k < boxes; ++k) {
        const std::size_t of = k * parts.size() / boxes;
        for (int face = 0; face < 6; ++face) {
            const LocalPlane plane = face_of_box(parts[of].box, face, parts[of].cell);
            int cut = 0, in_front = 0;
            for (std::size_t i = 0; i < parts.size(); ++i) {
                if (i == of) continue;
                const PlaneRelation relation =
                    side_of_box(bodies[parts[i].body].seen(bodies[parts[of].body], plane, parts[i].cell), parts[i].box);
                cut += relation == PlaneRelation::crossing;
                in_front += relation == PlaneRelation::in_front;
            }
            const int behind = int(parts.size()) - in_front - cut;
            const int price = std::abs(behind - in_front) + price_of_cut * cut;
            if (in_front == 0 || price_of_cut * cut > std::min(behind, in_front) || price >= least) continue;
            least = price;
            best = SeparatingFace{of, face};
            if (least <= int(parts.size() % 2)) return best;
        }
    }
    return best;
}

}  // namespace farfield::detail
