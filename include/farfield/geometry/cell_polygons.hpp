// The contents of a cell as a partition that cuts sees them: convex polygons, and instances, which are never cut.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <span>
#include <utility>

#include "farfield/geometry/box.hpp"
#include "farfield/geometry/cell.hpp"
#include "farfield/geometry/clip_polygon.hpp"

namespace farfield {

/// A piece of a polygon, or an instance, while the hierarchy is built.
struct ClippedItem {
    Box bounds;                      ///< local coordinates
    std::uint32_t source = 0;        ///< index of the primitive, or of the first one where polygons were joined
    std::uint32_t polygon = 0;       ///< number of its supporting plane, which every piece of it keeps
    std::uint32_t first_corner = 0;  ///< in the builder's array
    std::uint32_t corners = 0;       ///< 0: an instance
    float cost = 0;                  ///< of drawing one of its triangles, or all of an instance
};

/// dot(normal, p) = offset, as near to the polygon's own vertices as a normal in single precision can be.
struct SupportingPlane {
    glm::vec3 normal{0};
    double offset = 0;
};

/// The side of a plane that something lies on: `crossing` is on both.
enum class PlaneRelation : std::uint8_t { behind, on, in_front, crossing };

/// The plane that a polygon lies in, in a cell.
inline CuttingPlane plane_in(const SupportingPlane& plane, const Cell& cell) {
    return {plane.normal, float(plane.offset - glm::dot(glm::dvec3(plane.normal), glm::dvec3(cell.center)))};
}

/// `local_plane` is `plane` in the cell. Pieces of the polygon that it was laid through lie on it, however their
/// corners were rounded. An instance as thin as the plane counts as in front of it: it is never `on`.
inline PlaneRelation relation_of(const ClippedItem& item, std::span<const Corner> polygon,
                                 std::span<const SupportingPlane> planes, const CuttingPlane& plane,
                                 const LocalPlane& local_plane, const Cell& cell) {
    const double tolerance = local_plane.tolerance();
    const int axis = local_plane.axis();
    double lowest, highest;
    if (axis >= 0) {
        // Along an axis an item reaches exactly as far as its bounds.
        lowest = local_plane.height_along(axis, item.bounds.lower);
        highest = local_plane.height_along(axis, item.bounds.upper);
        if (highest < lowest) std::swap(lowest, highest);
    } else {
        const double middle = 0.5 * (local_plane.height(item.bounds.lower) + local_plane.height(item.bounds.upper));
        const double reach = 0.5 * glm::dot(glm::abs(local_plane.normal()),
                                            glm::dvec3(item.bounds.upper) - glm::dvec3(item.bounds.lower));
        lowest = middle - reach;
        highest = middle + reach;
    }
    if (item.corners == 0) {
        if (lowest >= -tolerance) return PlaneRelation::in_front;
        return highest <= tolerance ? PlaneRelation::behind : PlaneRelation::crossing;
    }
    const SupportingPlane& own = planes[item.polygon];  // instances have none
    const bool may_be_own = plane.normal == own.normal;
    if (!may_be_own && lowest > tolerance) return PlaneRelation::in_front;
    if (!may_be_own && highest < -tolerance) return PlaneRelation::behind;
    if (axis < 0) {
        lowest = highest = local_plane.height(polygon[0].position);
        for (const Corner& c : polygon.subspan(1)) {
            const double height = local_plane.height(c.position);
            lowest = glm::min(lowest, height);
            highest = glm::max(highest, height);
        }
    }
    const bool behind = lowest<-tolerance, in_front = highest> tolerance;
    if (!(behind || in_front) || (may_be_own && plane == plane_in(own, cell))) return PlaneRelation::on;
    return behind && in_front ? PlaneRelation::crossing : behind ? PlaneRelation::behind : PlaneRelation::in_front;
}

/// The contents of one cell, instances first.
class ClippedItems {
  public:
    ClippedItems(std::span<const ClippedItem> items, std::span<const Corner> corners,
                 std::span<const SupportingPlane> planes)
        : items_(items), corners_(corners), planes_(planes) {
        instances_ = std::size_t(
            std::partition_point(items.begin(), items.end(), [](const ClippedItem& i) { return i.corners == 0; }) -
            items.begin());
    }

    std::size_t size() const { return items_.size(); }
    std::size_t instances() const { return instances_; }  ///< items [0, instances()) are instances
    const ClippedItem& operator[](std::size_t i) const { return items_[i]; }
    std::span<const Corner> polygon(std::size_t i) const {
        return corners_.subspan(items_[i].first_corner, items_[i].corners);
    }
    glm::vec3 normal(std::size_t i) const { return planes_[items_[i].polygon].normal; }
    /// The plane that a polygon lies in.
    CuttingPlane plane_of(std::size_t i, const Cell& cell) const { return plane_in(planes_[items_[i].polygon], cell); }
    /// See relation_of.
    PlaneRelation relation(std::size_t i, const CuttingPlane& plane, const LocalPlane& local_plane,
                           const Cell& cell) const {
        return relation_of(items_[i], polygon(i), planes_, plane, local_plane, cell);
    }

    /// Whether any order of the items is right, from wherever they are seen: one item, or polygons in one plane.
    bool need_no_order(const Cell& cell) const {
        if (size() <= 1) return true;
        if (instances_ != 0) return false;
        const CuttingPlane plane = plane_of(0, cell);
        const LocalPlane local_plane(plane, cell);
        for (std::size_t i = 1; i < size(); ++i) {
            if (relation(i, plane, local_plane, cell) != PlaneRelation::on) return false;
        }
        return true;
    }

  private:
    std::span<const ClippedItem> items_;
    std::span<const Corner> corners_;
    std::span<const SupportingPlane> planes_;
    std::size_t instances_ = 0;
};

/// Up to three planes that cut a cell one after the other. No instance may cross one.
struct Cuts {
    std::array<CuttingPlane, 3> planes;
    unsigned count = 0;
    unsigned children = 0;  ///< how many there may be; empty ones are left out
};
/// The side of each of the planes.
using Sides = std::array<Side, 3>;

}  // namespace farfield
