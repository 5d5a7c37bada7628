// A moving body as one frame sees it, and its planes in the coordinates of other bodies.
#pragma once

#include "farfield/settings.hpp"

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>
#include <glm/vec3.hpp>

#include "farfield/geometry/box.hpp"
#include "farfield/geometry/cell.hpp"
#include "farfield/geometry/cell_polygons.hpp"
#include "farfield/geometry/clip_polygon.hpp"
#include "farfield/view/local_view.hpp"

namespace farfield::detail {

/// Bodies meet in the camera's coordinates, by the numbers that a renderer projects with: the anchor and axes of each
/// body are rounded to single precision separately, and planes must lie where the picture shows them.
class BodyFrame {
  public:
    explicit BodyFrame(const LocalView& view)
        : view_(view),
          to_camera_(glm::transpose(glm::dmat3(view.right, view.up, view.forward)) * double(view.scale)),
          from_camera_(glm::inverse(to_camera_)) {}

    const LocalView& view() const { return view_; }

    /// A plane of another body in this one's coordinates, rounded once, about the center of a cell.
    LocalPlane seen(const BodyFrame& other, const LocalPlane& plane, const Cell& cell) const {
        const glm::dvec3 in_camera = plane.normal() * other.from_camera_;
        const glm::dvec3 normal = in_camera * to_camera_;
        const double length = glm::length(normal);
        const double from_anchor = -plane.height(other.view_.anchor);
        const glm::dvec3 to_center = glm::dvec3(cell.center) - glm::dvec3(view_.anchor);
        return LocalPlane(
            CuttingPlane{glm::vec3(normal / length), float((from_anchor - glm::dot(normal, to_center)) / length)},
            cell);
    }

  private:
    LocalView view_;
    glm::dmat3 to_camera_, from_camera_;
};

/// The side of a plane that a box lies on; a box on the plane counts as in front of it.
inline PlaneRelation side_of_box(const LocalPlane& plane, const Box& box) {
    const double middle = 0.5 * (plane.height(box.lower) + plane.height(box.upper));
    const double reach = 0.5 * glm::dot(glm::abs(plane.normal()), glm::dvec3(box.upper) - glm::dvec3(box.lower));
    if (middle - reach >= -plane.tolerance()) return PlaneRelation::in_front;
    return middle + reach <= plane.tolerance() ? PlaneRelation::behind : PlaneRelation::crossing;
}

/// The plane of a face of a box in a cell; the box lies behind it. Faces 0 to 5: -x, +x, -y, +y, -z, +z.
inline LocalPlane face_of_box(const Box& box, int face, const Cell& cell) {
    const int axis = face / 2;
    CuttingPlane plane;
    plane.normal[axis] = face % 2 == 0 ? -1.0f : 1.0f;
    plane.offset = face % 2 == 0 ? cell.center[axis] - box.lower[axis] : box.upper[axis] - cell.center[axis];
    return LocalPlane(plane, cell);
}

}  // namespace farfield::detail
