// What people point at in a scene: the cells that a frame was drawn by, and what lies under a pixel with its cell. All
// in the scene's own coordinates, whatever instance it lies in.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "farfield/frame/selection.hpp"
#include "farfield/pick.hpp"
#include "farfield/primitive.hpp"
#include "farfield/view.hpp"

namespace farfield::scenes {

struct CellOutline {
    glm::dvec3 center{0.0};
    std::array<glm::dvec3, 3> half{};  ///< from the center to the middles of three faces
    unsigned depth = 0;                ///< levels below the root of its own hierarchy
    bool is_stand_in = false;          ///< else its primitives were drawn
    bool is_hidden = false;            ///< it was not drawn: what lies before it hides it
    bool is_outside = false;           ///< it was not drawn: it lies beside the picture
};

struct PickedInScene {
    double depth = 0;  ///< along the camera's forward
    glm::dvec3 point{0.0};
    std::vector<std::uint32_t> path;    ///< as PickedPrimitive's; of pages the page and the item in it
    std::vector<glm::dvec3> corners;    ///< of the primitive's polygon
    std::optional<CellOutline> cell;    ///< of pages none is told
    std::uint32_t node = 0;             ///< of the cell in its hierarchy
    std::uint64_t cell_primitives = 0;  ///< in the cell and below
};

namespace detail {

/// Takes points of an instance into the scene.
struct Placed {
    glm::dmat3 linear{1.0};
    glm::dvec3 moved{0.0};

    glm::dvec3 apply(glm::dvec3 p) const { return linear * p + moved; }
    Placed inside(const Similarity& s) const {
        return {linear * glm::dmat3(s.rotation()) * double(s.scale()), apply(s.translation)};
    }
    CellOutline outline(const Cell& cell, glm::dvec3 origin) const {
        const glm::dvec3 half(cell.bounds_half);
        return {apply(glm::dvec3(cell.bounds_center) + origin),
                {linear[0] * half.x, linear[1] * half.y, linear[2] * half.z},
                cell.depth};
    }
};

/// The way down leads through the children whose positions hold the node's first.
template <class H>
Subtree subtree_of(const H& hierarchy, std::uint32_t node) {
    Subtree at = whole_of(hierarchy);
    const std::uint32_t position = hierarchy.nodes()[node].first_item;
    while (at.node != node && hierarchy.nodes()[at.node].first_child != 0) {
        std::optional<Subtree> next;
        for_each_child<VisitOrder::any>(hierarchy, at, glm::vec4(0), [&](const Subtree& child) {
            const bool holds = hierarchy.nodes()[child.node].first_item <= position && position < child.end_item;
            if (holds || child.node == node) next = child;
        });
        if (!next) break;
        at = *next;
    }
    return at;
}

/// Follows the path of what was picked, and tells where it leads to.
template <class H, class P>
void tell(const H& hierarchy, std::span<const P> primitives, std::span<const std::uint32_t> path, const Placed& placed,
          PickedInScene& out) {
    const P& primitive = primitives[path[0]];
    if (path.size() > 1) {
        if constexpr (PrimitiveWithInstance<P>) {
            primitive_traits<P>::visit_instance(primitive, [&](const auto& instance) {
                tell(*instance.hierarchy, instance.primitives, path.subspan(1), placed.inside(instance.to_world), out);
            });
        }
        return;
    }
    primitive.polygons([&](const auto& polygon) {
        for (const auto& v : polygon.vertices) out.corners.push_back(placed.apply(glm::dvec3(v)));
    });
    const Subtree cell = subtree_of(hierarchy, out.node);
    out.cell = placed.outline(cell.cell, hierarchy.origin());
    out.cell_primitives = cell.end_item - hierarchy.nodes()[cell.node].first_item;
}

}  // namespace detail

/// What lies under a point of a view's picture, as pick() finds it.
template <class H, class P>
std::optional<PickedInScene> picked_in_scene(const H& hierarchy, std::span<const P> primitives, const View& view,
                                             glm::dvec2 pixel) {
    const Ray ray = ray_through(view, pixel);
    const auto picked = pick(hierarchy, primitives, ray);
    if (!picked) return std::nullopt;
    PickedInScene out;
    out.depth = picked->distance;
    out.point = ray.at(picked->distance);
    out.path = picked->path;
    out.node = picked->node;
    detail::tell(hierarchy, primitives, std::span<const std::uint32_t>(out.path), {}, out);
    return out;
}

namespace detail {

/// Calls f(entered, selected, outline) for each cell of a selection: stand-ins, and those whose primitives are drawn.
template <class Selection, class F>
void for_each_outline(const Selection& selection, F&& f) {
    if (selection.views().empty() || selection.hierarchy() == nullptr) return;
    const LocalView& outermost = selection.views().front();
    const auto axes = [](const LocalView& v) {
        return glm::dmat3(glm::dvec3(v.right), glm::dvec3(v.up), glm::dvec3(v.forward));
    };
    const glm::dvec3 eye = selection.view().camera.eye;
    selection.for_each([&](const auto& entered, const Selected& s) {
        if (s.kind == Selected::Kind::instance) return;
        // Both views have the same eye and axes, which tells how one lies in the other.
        const LocalView& v = entered.view;
        const glm::dmat3 linear = axes(outermost) * glm::transpose(axes(v)) * double(v.scale);
        const Placed placed{linear, eye - linear * glm::dvec3(v.eye)};
        CellOutline outline = placed.outline(s.subtree.cell, glm::dvec3(0));
        outline.is_stand_in = s.kind == Selected::Kind::stand_in;
        f(entered, s.subtree, outline);
    });
}

/// Moves the largest of [begin, end) as seen from an eye, `count` of them or all, to the front; returns their end.
template <class Iterator>
Iterator keep_largest(glm::dvec3 eye, Iterator begin, Iterator end, std::size_t count) {
    const auto size = [&](const CellOutline& c) {
        const double squared =
            glm::dot(c.half[0], c.half[0]) + glm::dot(c.half[1], c.half[1]) + glm::dot(c.half[2], c.half[2]);
        const glm::dvec3 away = c.center - eye;
        return squared / std::max(glm::dot(away, away), squared);
    };
    if (std::size_t(end - begin) <= count) return end;
    const auto kept = begin + std::ptrdiff_t(count);
    std::nth_element(begin, kept, end, [&](const CellOutline& a, const CellOutline& b) { return size(a) > size(b); });
    return kept;
}

}  // namespace detail

/// The cells of a selection. At most `most`, the largest in the picture, a quarter of them for primitives; and as many
/// of those of which is_hidden(entered, subtree) says so.
template <class Selection, class IsHidden>
std::vector<CellOutline> outlines_of(const Selection& selection, std::size_t most, IsHidden&& is_hidden) {
    std::vector<CellOutline> drawn, hidden;
    detail::for_each_outline(selection, [&](const auto& entered, const Subtree& subtree, CellOutline outline) {
        outline.is_hidden = is_hidden(entered, subtree);
        (outline.is_hidden ? hidden : drawn).push_back(outline);
    });
    const glm::dvec3 eye = selection.view().camera.eye;
    // Stand-ins are smaller than all else that is drawn, and what people look for.
    const auto split = std::partition(drawn.begin(), drawn.end(), [](const auto& c) { return c.is_stand_in; });
    const auto stand_ins = detail::keep_largest(eye, drawn.begin(), split, most - most / 4);
    const auto others = detail::keep_largest(eye, split, drawn.end(), most - std::size_t(stand_ins - drawn.begin()));
    drawn.erase(std::move(split, others, stand_ins), drawn.end());
    drawn.insert(drawn.end(), hidden.begin(), detail::keep_largest(eye, hidden.begin(), hidden.end(), most));
    return drawn;
}

/// A view that shows twice as much to all sides, as finely: some of what was culled beside the picture.
inline View twice_as_wide(View view) {
    view.camera.half_height *= 2;
    view.camera.half_width *= 2;
    view.width *= 2;
    view.height *= 2;
    return view;
}

/// Whether a cell lies beside, above or below a perspective view's picture, whose middle is straight ahead, or behind
/// the eye. May err towards no.
inline bool is_outside(const View& view, const CellOutline& cell) {
    const Camera& c = view.camera;
    const glm::dvec3 away = cell.center - c.eye;
    const double depth = glm::dot(away, glm::dvec3(c.forward));
    const double radius = std::sqrt(glm::dot(cell.half[0], cell.half[0]) + glm::dot(cell.half[1], cell.half[1]) +
                                    glm::dot(cell.half[2], cell.half[2]));
    const double up = double(c.half_height),
                 across = c.half_width > 0 ? double(c.half_width) : up * double(view.width) / double(view.height);
    const auto is_beyond = [&](glm::vec3 axis, double half) {
        const double beyond = std::abs(glm::dot(away, glm::dvec3(axis))) - half * depth;
        return beyond > radius * std::sqrt(1 + half * half);
    };
    return depth < -radius || is_beyond(c.right, across) || is_beyond(c.up, up);
}

/// Adds the cells of a selection that lie beside a picture; at most `most`, the largest.
template <class Selection>
void add_outlines_outside(const Selection& selection, const View& view, std::size_t most,
                          std::vector<CellOutline>& outlines) {
    std::vector<CellOutline> outside;
    detail::for_each_outline(selection, [&](const auto&, const Subtree&, CellOutline outline) {
        outline.is_outside = is_outside(view, outline);
        if (outline.is_outside) outside.push_back(outline);
    });
    const auto end = detail::keep_largest(view.camera.eye, outside.begin(), outside.end(), most);
    outlines.insert(outlines.end(), outside.begin(), end);
}

}  // namespace farfield::scenes
