// What the shaders know of a view: one row of a vertex buffer, which a draw finds by its base instance. So draws of
// many instances are one call.
#pragma once

#include <cmath>
#include <cstdint>
#include <cstring>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <limits>

#include "farfield/geometry/light.hpp"
#include "farfield/view/local_view.hpp"

namespace farfield::opengl {

/// With d = p - anchor: clip x = dot(across, d) + w across.w, likewise y, w = dot(forward, d) forward.w + anchor.w,
/// clip z = depths.x + depths.y dot(forward, d).
///
/// The viewer is moved into each instance, and not the instance into the world: single precision then goes to what is
/// near the eye (LocalView). Rows of a frame are made on the GPU, of the outermost one's (view_places.hpp); those of an
/// image are uploaded.
struct ViewRow {
    glm::vec4 anchor, across, upward, forward;
    glm::vec4 depths;  ///< z: near depth from the anchor, w: far depth, both to be cut at
    glm::vec4 light;   ///< towards it, in the view's axes; w: bits of LocalView::seed
    friend bool operator==(const ViewRow&, const ViewRow&) = default;
};
static_assert(sizeof(ViewRow) == 96);

/// How depths lie in the depth buffer, larger ones nearer: near / depth where they are counted from the eye, which
/// keeps a number's precision at any distance; else a linear part of the picture's depths around the anchor, of 16 of
/// the view's depth units, and what lies beyond is drawn in any order.
struct DepthRule {
    bool is_quotient = true;  ///< of the near depth and a depth
    /// z + bias is proportional to the inverse depth from the eye; in a parallel view differences are.
    float bias = 0;
    bool is_perspective = true;
    bool clips = false;  ///< by depths in the row, and not by the depth buffer's range
};

inline DepthRule depth_rule(const LocalView& view) {
    const bool at_eye = view.is_perspective && view.anchor_depth == 0;
    DepthRule rule{.is_quotient = at_eye, .is_perspective = view.is_perspective};
    if (view.is_perspective && !at_eye) rule.bias = view.anchor_depth * (view.scale / view.depth_unit) / 16 - 0.5f;
    rule.clips = !at_eye || std::isfinite(view.far_depth);
    return rule;
}

/// `light` is in the view's axes.
inline ViewRow view_row(const LocalView& view, const DirectionalLight* light) {
    const glm::vec2 per_unit = view.focal_px * view.squeeze * 2.0f / glm::vec2(view.width, view.height);
    const glm::vec2 off(view.off_center);
    ViewRow row;
    row.anchor = glm::vec4(view.anchor, view.is_perspective ? view.anchor_depth : 1.0f);
    row.across = glm::vec4(view.right * per_unit.x, -off.x);
    row.upward = glm::vec4(view.up * per_unit.y, -off.y);
    row.forward = glm::vec4(view.forward, view.is_perspective ? 1.0f : 0.0f);
    const float in_units = view.scale / view.depth_unit / 16;
    if (!view.is_perspective) {
        row.depths = glm::vec4(0.5f, -in_units, 0, 0);
    } else if (view.anchor_depth == 0) {
        row.depths = glm::vec4(view.near_depth, 0, 0, 0);
    } else {
        row.depths = glm::vec4(0.5f * view.anchor_depth, 0.5f - view.anchor_depth * in_units, 0, 0);
    }
    constexpr float most = std::numeric_limits<float>::max();
    row.depths.z = glm::clamp(view.near_depth - view.anchor_depth, -most, most);
    row.depths.w = glm::clamp(view.far_depth - view.anchor_depth, -most, most);
    row.light = glm::vec4(light != nullptr ? light->towards : glm::vec3(0), 0);
    std::memcpy(&row.light.w, &view.seed, sizeof view.seed);
    return row;
}

/// By how much something is longer in the picture, at most, than its length seen squarely at its depth.
inline float stretch_of(const ViewRow& row) {
    if (row.forward.w == 0) return 1;
    const auto away = [](const glm::vec4& axis) {
        const float tangent = (1 + std::abs(axis.w)) / glm::length(glm::vec3(axis));
        return tangent * tangent;
    };
    return std::sqrt(1 + away(row.across) + away(row.upward));
}

}  // namespace farfield::opengl
