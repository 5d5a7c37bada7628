// The work of drawing a part of a cut, and what is gained by opening a cell of it, known before anything is drawn.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <limits>
#include <utility>

#include "farfield/approximation.hpp"
#include "farfield/drawables.hpp"
#include "farfield/frame/frame_prices.hpp"
#include "farfield/frame/stand_in_choice.hpp"
#include "farfield/frame/subtree.hpp"
#include "farfield/geometry/length.hpp"
#include "farfield/geometry/mixed.hpp"
#include "farfield/hierarchy/node.hpp"
#include "farfield/partition.hpp"
#include "farfield/primitive.hpp"
#include "farfield/view/frustum.hpp"
#include "farfield/view/local_view.hpp"

namespace farfield::detail {

/// How much is gained by opening a cell for what it costs. Ties are broken by a hash of its place, the same in every
/// frame.
struct Gain {
    float value = 0;
    std::uint64_t place = 0;

    static constexpr Gain infinite() {
        return {std::numeric_limits<float>::infinity(), std::numeric_limits<std::uint64_t>::max()};
    }
    friend bool operator<(const Gain& a, const Gain& b) {
        return a.value != b.value ? a.value < b.value : a.place < b.place;
    }
};

/// Pixels of the picture that a rectangle about the view's axis covers, from `lower` to `upper` in pixels from it.
inline float seen_px(const LocalView& view, glm::vec2 lower, glm::vec2 upper) {
    const glm::vec2 whole(view.part.whole_width, view.part.whole_height);
    const glm::vec2 middle = 0.5f * whole * glm::vec2(view.whole_off_center);
    const glm::vec2 size = glm::min(upper, middle + 0.5f * whole) - glm::max(lower, middle - 0.5f * whole);
    return size.x > 0 && size.y > 0 ? size.x * size.y : 0.0f;
}

/// Pixels that a face covers, by what the view's planes leave of it: of one beside the eye a bounding rectangle would
/// be most of the picture.
inline float seen_px(const LocalView& view, const Face& face) {
    const unsigned axis = face.side / 2u, u = (axis + 1) % 3, v = (axis + 2) % 3;
    std::array<glm::vec3, 4 + plane_count> corners{}, cut{};
    for (unsigned i = 0; i < 4; ++i) {
        corners[i] = face.lower;
        corners[i][int(u)] = i == 1 || i == 2 ? face.upper[int(u)] : face.lower[int(u)];
        corners[i][int(v)] = i >= 2 ? face.upper[int(v)] : face.lower[int(v)];
    }
    std::size_t count = 4;
    for (const glm::vec4& plane : view.planes) {
        const auto height = [&](glm::vec3 p) { return glm::dot(glm::vec3(plane), p) + plane.w; };
        std::size_t kept = 0;
        for (std::size_t i = 0; i < count; ++i) {
            const glm::vec3 from = corners[i], to = corners[i + 1 < count ? i + 1 : 0];
            const float here = height(from), there = height(to);
            if (here >= 0) cut[kept++] = from;
            if ((here >= 0) != (there >= 0) && kept < cut.size())
                cut[kept++] = glm::mix(from, to, here / (here - there));
        }
        std::swap(corners, cut);
        count = kept;
    }
    const auto at = [&](glm::vec3 p) {
        const glm::vec3 d = p - view.eye;
        const float depth = view.is_perspective ? std::max(glm::dot(d, view.forward), view.near_depth) : 1.0f;
        return glm::vec2(glm::dot(d, view.right), glm::dot(d, view.up)) * view.squeeze * (view.focal_px / depth);
    };
    float twice = 0;
    for (std::size_t i = 0; i < count; ++i) {
        const glm::vec2 a = at(corners[i]), b = at(corners[i + 1 < count ? i + 1 : 0]);
        twice += a.x * b.y - b.x * a.y;
    }
    const float px = 0.5f * std::abs(twice), whole = float(view.part.whole_width) * float(view.part.whole_height);
    return px <= whole ? px : px > whole ? whole : 0.0f;
}

/// What boxes cover, flat ones too, about: as much as their silhouettes have from afar; of boxes that cross a side of
/// the picture the part of their rectangle that lies in it.
inline float covered_px(const LocalView& view, glm::vec3 center, glm::vec3 half, bool is_inside) {
    const glm::vec3 d = center - view.eye;
    const glm::vec2 whole(view.part.whole_width, view.part.whole_height);
    const float distance = view.is_perspective ? std::max(length_of(d), length_of(half)) : 1.0f;
    // From inside there is no direction that it is seen from.
    const bool is_around = view.is_perspective && !(length_of(d) > length_of(half));
    const glm::vec3 towards = is_around ? glm::vec3(1) : glm::abs(view.is_perspective ? d / distance : view.forward);
    const glm::vec2 scale = view.squeeze * (view.focal_px / distance);
    const float silhouette = 4 * glm::dot(towards, glm::vec3(half.y * half.z, half.z * half.x, half.x * half.y));
    const float px = std::min(silhouette * scale.x * scale.y, whole.x * whole.y);
    if (is_inside || !(px > 0)) return px > 0 ? px : 0.0f;
    glm::vec2 lower(std::numeric_limits<float>::max()), upper(std::numeric_limits<float>::lowest());
    for (unsigned corner = 0; corner < 8; ++corner) {
        const glm::vec3 c = d + half * glm::vec3(corner & 1 ? 1 : -1, corner & 2 ? 1 : -1, corner & 4 ? 1 : -1);
        const float depth = view.is_perspective ? glm::dot(c, view.forward) : 1.0f;
        if (!(depth > 0)) return 0.5f * px;
        const glm::vec2 at =
            glm::vec2(glm::dot(c, view.right), glm::dot(c, view.up)) * view.squeeze * (view.focal_px / depth);
        lower = glm::min(lower, at);
        upper = glm::max(upper, at);
    }
    const float area = (upper.x - lower.x) * (upper.y - lower.y);
    return area > 0 ? std::min(px, area) * (seen_px(view, lower, upper) / area) : 0.0f;
}
inline float covered_px(const LocalView& view, const Subtree& subtree) {
    return covered_px(view, subtree.cell.bounds_center, subtree.cell.bounds_half, subtree.crossed_planes == 0);
}

/// Adds up what a stand-in covers that is drawn into it.
struct CoverageSink {
    const LocalView& view;
    float& px;
    float splat_limit_px = 0;

    void operator()(const Face& face) const { px += seen_px(view, face); }
    void operator()(const Splat& splat) const {
        const glm::vec3 d = splat.center - view.eye;
        const float depth = view.is_perspective ? glm::dot(d, view.forward) : 1.0f;
        if (!(depth > 0)) return;
        const glm::vec2 scale = view.squeeze * (view.focal_px / depth);
        const glm::vec2 at = glm::vec2(glm::dot(d, view.right), glm::dot(d, view.up)) * scale;
        px += seen_px(view, at - 0.5f * splat.size * scale, at + 0.5f * splat.size * scale);
    }
    void operator()(OwnRun) const {}
};

/// The work of drawing a run, but for the pixels and for what instances in it hold.
template <class E>
FrameWork work_of_run(const E& e, std::uint32_t first, std::uint32_t end, float px) {
    using P = typename E::primitive_type;
    double triangles = 0;
    FrameWork work;
    if constexpr (PrimitiveWithInstance<P>) {
        for (std::uint32_t at = first; at < end; ++at) {
            const P& p = e.source[at];
            if (!primitive_traits<P>::visit_instance(p, [](const auto&) {})) triangles += double(work_of(p).triangles);
        }
    } else if (!e.source.fragments.empty()) {
        const auto& vertex = e.source.fragments.first_vertex;
        triangles = double(vertex[end] - vertex[first]) - 2.0 * double(end - first);
    } else {
        triangles = double(e.hierarchy.facts().work.triangles) /
                    double(std::max<std::uint64_t>(e.hierarchy.primitive_count(), 1)) * double(end - first);
    }
    if (!(triangles > 0)) return work;
    work[FrameWork::runs] = 1;
    // Others may have drawn every second item: a run is broken where something is left out.
    if (E::hierarchy_type::assignment == Assignment::shared) work[FrameWork::runs] = std::ceil(0.5 * triangles);
    work[double(px) > 2 * triangles ? FrameWork::large_triangles : FrameWork::triangles] = triangles;
    work[FrameWork::triangle_pixels] = double(px);
    return work;
}

template <class A, class Data>
FrameWork work_of_drawing(const A& approximation, const Data& data, float px) {
    const Work w = work_of_stand_in(approximation, data);
    FrameWork work;
    const double drawn = double(w.faces) + double(w.splats);
    work[FrameWork::stand_ins] = std::isfinite(drawn) ? drawn : 1;  // of empty ones, which are kept for their samples
    work[FrameWork::stand_in_pixels] = double(px);
    return work;
}

/// Projected area times error, by the price of opening: "coverage x error removed / cost". Where nothing stands in,
/// everything is missing, and the error is the cell's own size.
template <class E>
Gain gain_of_opening(const E& entered, const Subtree& subtree, const FramePrices& prices, float px) {
    using H = typename E::hierarchy_type;
    const H& h = entered.hierarchy;
    const Node& node = h.nodes()[subtree.node];
    const float whole = std::max(float(entered.view.part.whole_width), float(entered.view.part.whole_height));
    float error = 0;
    if constexpr (H::approximation_type::facts.stands_in) {
        if (subtree.has_stand_in()) error = stand_in_error_px(entered, subtree);
    }
    if (!subtree.has_stand_in()) {
        error = entered.view.pixels(subtree.cell.largest_side(), entered.view.distance_to(subtree.cell));
    }
    const auto& each = prices.each;
    const double children = bits_set[node.child_mask];
    const double an_item = PrimitiveWithInstance<typename E::primitive_type>
                               ? each[FrameWork::instances] + each[FrameWork::stand_ins]
                               : each[FrameWork::triangles];
    const double price = each[FrameWork::openings] + children * (each[FrameWork::cells] + each[FrameWork::stand_ins]) +
                         double(end_of_own_run(h, subtree) - node.first_item) * an_item;
    const float gained = px * std::min(error, whole);
    // What is free is opened first, and what gains nothing last.
    const float value = price > 0 ? gained / float(price) : gained > 0 ? std::numeric_limits<float>::infinity() : 0.0f;
    return {value, mixed(entered.path, subtree.node)};
}

}  // namespace farfield::detail
