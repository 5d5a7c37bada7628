// The look of a stored opacity tensor from a direction: its area, its color, and the rectangle or faces that show them.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <glm/common.hpp>
#include <glm/exponential.hpp>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include "farfield/approximation/opacity_tensor/appearance_lanes.hpp"
#include "farfield/approximation/opacity_tensor/axis_masks.hpp"
#include "farfield/approximation/opacity_tensor/stored_tensor.hpp"
#include "farfield/drawables.hpp"
#include "farfield/geometry/area_law.hpp"
#include "farfield/geometry/box.hpp"
#include "farfield/geometry/cell.hpp"
#include "farfield/geometry/rgba8.hpp"
#include "farfield/view/local_view.hpp"

namespace farfield {

/// A shape and the options it was made with (OpacityTensor). Lengths are in sides of the cell's bounds, areas in
/// squares of it; w is a unit vector towards the viewer.
struct TensorAppearance {
    TensorShape shape;
    bool closed_surfaces = false;
    bool counts_overlap = true;

    struct Seen {
        float area;     ///< covered, each place once
        glm::vec3 rgb;  ///< 0 to 255
    };
    Seen seen_from(glm::vec3 w) const {
        const auto seen = detail::one_tensor::seen_from(shape, w, closed_surfaces, counts_overlap);
        return {seen.area, seen.rgb};
    }

    /// Width and height, in the picture, of the rectangle that is drawn about `center` and has room for this area.
    glm::vec2 rectangle(glm::vec3 center, const LocalView& view, float area) const {
        const auto size = detail::one_tensor::rectangle(shape, center, view, area);
        return {size.x, size.y};
    }

    /// Whether the contents may go on in neighboring cells in two directions, as a surface does: rounding included. In
    /// local units, `unit` is tensor_unit(cell), and `least` least_reach(cell).
    bool reaches_across(float unit, float least) const {
        const glm::vec3 e = shape.extent;
        const float second = std::max(std::min(e.x, e.y), std::min(std::max(e.x, e.y), e.z));
        return second * unit >= least;
    }
    static float least_reach(const Cell& cell) {
        return 1.75f * glm::max(cell.half.x, glm::max(cell.half.y, cell.half.z));
    }

    /// The contents' centroid, in local coordinates.
    glm::vec3 center_in(const Cell& cell) const {
        return cell.bounds_center - cell.bounds_half + shape.center * tensor_unit(cell);
    }

    /// What three crossing faces are to be multiplied by so that they show a cell's masks as much as the contents
    /// would: 1 to 1.1. From between the axes they lie in front of one another, and what looks the same from everywhere
    /// would lose a tenth.
    float gain_of_crossing_faces() const {
        const glm::vec3 half = 0.5f * shape.extent;
        AxisMasks masks;
        float area = 0, opaque = 0;
        for (int axis = 0; axis < 3; ++axis) {
            glm::vec3 w(0), u(0), v(0);
            w[axis] = 1;
            u[(axis + 1) % 3] = half[(axis + 1) % 3];
            v[(axis + 2) % 3] = half[(axis + 2) % 3];
            const float seen = seen_from(w).area;
            if (!(seen > 0)) continue;
            area += seen;
            opaque += 4 * u[(axis + 1) % 3] * v[(axis + 2) % 3];
            const Box box{glm::vec3(-0.5f), glm::vec3(0.5f)};
            masks.add(box, {-u - v, u - v, u + v});
            masks.add(box, {-u - v, u + v, v - u});
        }
        float covered = 0, shown = 0;
        for (int view = 0; view < AxisMasks::views; ++view) {
            const glm::vec3 w = AxisMasks::direction(view);
            covered += 0.5f * (seen_from(w).area + seen_from(-w).area);
            shown += float(masks.count(view)) * AxisMasks::sample_area(view) * std::min(area / opaque, 1.0f);
        }
        return shown > 0 ? std::min(std::max(covered / shown, 1.0f), 1.1f) : 1.0f;
    }

    /// One of three rectangles that cross at the centroid, as opaque as the contents are along its normal.
    Face crossing_face(const Cell& cell, int axis, bool looks_up, float gain = 1) const {
        const glm::vec3 center = center_in(cell), half = shape.extent * (0.5f * tensor_unit(cell));
        glm::vec3 w(0);
        w[axis] = looks_up ? 1.0f : -1.0f;
        const Seen seen = seen_from(w);
        const float outline = shape.extent[(axis + 1) % 3] * shape.extent[(axis + 2) % 3];
        const float alpha = std::min(gain * seen.area / outline, 1.0f);
        Face face{center - half, center + half, to_rgba8(glm::vec4(seen.rgb * (alpha / 255), alpha)),
                  std::uint8_t(2 * axis + (looks_up ? 1 : 0))};
        face.lower[axis] = face.upper[axis] = center[axis];
        return face;
    }
};

}  // namespace farfield
