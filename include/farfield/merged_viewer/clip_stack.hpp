// Planes that cut a subtree, found at its root and used at its leaves.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <utility>
#include <vector>

#include "farfield/geometry/box.hpp"
#include "farfield/geometry/clip_polygon.hpp"
#include "farfield/geometry/polygon.hpp"
#include "farfield/merged_viewer/body_frame.hpp"

namespace farfield::detail {

/// A plane, in the coordinates of the body that it cuts, and the side of it that is kept. Polygons on the plane, up to
/// its tolerance, count as in front of it: every polygon goes to one side, or has a part on each.
struct Clip {
    LocalPlane plane;
    Side side;
};

/// A range of clips in a ClipStack.
struct ClipList {
    std::uint32_t first = 0, count = 0;
};

/// A stack of lists of planes. A longer list is a copy, so that lists of its parent stay valid.
class ClipStack {
  public:
    std::size_t size() const { return clips_.size(); }
    void shrink(std::size_t size) { clips_.erase(clips_.begin() + std::ptrdiff_t(size), clips_.end()); }
    std::span<const Clip> operator[](ClipList list) const { return {clips_.data() + list.first, list.count}; }

    ClipList with(ClipList list, const LocalPlane& plane, Side side) {
        const ClipList longer{std::uint32_t(clips_.size()), list.count + 1};
        for (std::uint32_t i = list.first; i < list.first + list.count; ++i) clips_.push_back(Clip(clips_[i]));
        clips_.push_back({plane, side});
        return longer;
    }

    /// Drops planes that a box is clear of. Returns false if the box lies beyond one of them.
    bool narrow(ClipList& list, const Box& bounds) {
        const auto begin = std::uint32_t(clips_.size());
        for (std::uint32_t i = list.first; i < list.first + list.count; ++i) {
            const Clip clip = clips_[i];
            const PlaneRelation relation = side_of_box(clip.plane, bounds);
            if (relation == PlaneRelation::crossing) {
                clips_.push_back(clip);
            } else if ((relation == PlaneRelation::in_front) != (clip.side == Side::in_front)) {
                shrink(begin);
                return false;
            }
        }
        const auto left = std::uint32_t(clips_.size()) - begin;
        if (left == list.count) {
            shrink(begin);
        } else {
            list = {begin, left};
        }
        return true;
    }

    /// Shrinks a box to the part that the planes keep: plane by plane, so it may stay too large. Returns false if
    /// nothing is left.
    bool shrink(Box& box, ClipList list) const {
        for (const Clip& clip : (*this)[list]) {
            // The plane keeps dot(normal, p) >= offset.
            const double sign = clip.side == Side::in_front ? 1 : -1, tolerance = clip.plane.tolerance();
            const glm::dvec3 normal = sign * clip.plane.normal();
            const double offset = -sign * clip.plane.height(glm::vec3(0)) - tolerance;
            const glm::dvec3 highest = glm::max(normal * glm::dvec3(box.lower), normal * glm::dvec3(box.upper));
            const double sum = highest.x + highest.y + highest.z;
            for (int axis = 0; axis < 3; ++axis) {
                const double at = (offset - (sum - highest[axis])) / normal[axis];
                if (normal[axis] > 0 && at - tolerance > double(box.lower[axis]))
                    box.lower[axis] = float(at - tolerance);
                if (normal[axis] < 0 && at + tolerance < double(box.upper[axis]))
                    box.upper[axis] = float(at + tolerance);
            }
            if (box.is_empty()) return false;
        }
        return true;
    }

  private:
    std::vector<Clip> clips_;
};

/// Cuts polygons, one after the other, by planes. Keeps its buffers.
class PolygonClipper {
  public:
    enum class Left : std::uint8_t { nothing, all, part };

    Left clip(const Polygon& polygon, std::span<const Clip> clips) {
        corners_.clear();
        for (std::size_t i = 0; i < polygon.vertices.size(); ++i) {
            corners_.push_back({polygon.vertices[i], polygon.colors[i < polygon.colors.size() ? i : 0]});
        }
        Left left = Left::all;
        for (const Clip& clip : clips) {
            double lowest = std::numeric_limits<double>::infinity(), highest = -lowest;
            for (const Corner& c : corners_) {
                const double height = clip.plane.height(c.position);
                lowest = std::min(lowest, height);
                highest = std::max(highest, height);
            }
            const bool in_front = lowest >= -clip.plane.tolerance(), behind = highest <= clip.plane.tolerance();
            if (in_front || behind) {
                if (in_front != (clip.side == Side::in_front)) return Left::nothing;
                continue;
            }
            cut_.clear();
            if (!append_part(corners_, clip.plane, clip.side, glm::vec3(glm::normalize(doubled_area(corners_))),
                             cut_)) {
                return Left::nothing;
            }
            corners_.swap(cut_);
            left = Left::part;
        }
        return left;
    }

    /// The part that is left of the last polygon.
    std::span<const Corner> corners() const { return corners_; }

  private:
    std::vector<Corner> corners_, cut_;
};

}  // namespace farfield::detail
