// Where a viewer will be some frames from now if it goes on as it went, and what it will need of pages that are not in
// memory yet (Klein et al. 2002, section 6.2, asks for the cut and some levels more; levels double what is in use, and
// most of them lie where nobody goes).
#pragma once

#include "farfield/settings.hpp"

#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <optional>

#include "farfield/camera.hpp"
#include "farfield/frame/stand_in_choice.hpp"
#include "farfield/frame/subtree.hpp"
#include "farfield/view.hpp"

namespace farfield::detail {

/// The motion of one viewer.
class Motion {
  public:
    /// Takes the view of a frame, and returns the one that is so many frames ahead; none without a frame before, or
    /// where the viewer stands still, turns farther than that can be known, or has another kind of camera than before.
    std::optional<View> ahead(const View& view, float frames) {
        const std::optional<Camera> before = before_;
        before_ = view.camera;
        if (!before || before->projection != view.camera.projection) return std::nullopt;
        const Camera& now = view.camera;
        if (before->eye == now.eye && before->forward == now.forward && before->up == now.up) return std::nullopt;
        View there = view;
        there.camera.eye += double(frames) * (now.eye - before->eye);
        const glm::vec3 forward = now.forward + frames * (now.forward - before->forward);
        const glm::vec3 up = now.up + frames * (now.up - before->up);
        const float length = glm::length(forward);
        // More than 11 degrees a frame: whoever looks around so fast stops before.
        if (!(length > 0) || !(glm::dot(before->forward, now.forward) > 0.98f)) return std::nullopt;
        there.camera.forward = forward / length;
        const glm::vec3 right = glm::cross(there.camera.forward, up);
        const float width = glm::length(right);
        if (!(width > 0.1f)) return std::nullopt;
        there.camera.right = right / width;
        there.camera.up = glm::normalize(glm::cross(there.camera.right, there.camera.forward));
        if (now.is_mirrored()) there.camera.right = -there.camera.right;
        return is_finite(there.camera) ? std::optional(there) : std::nullopt;
    }

  private:
    static bool is_finite(const Camera& c) {
        return std::isfinite(c.eye.x) && std::isfinite(c.eye.y) && std::isfinite(c.eye.z) && std::isfinite(c.up.x) &&
               std::isfinite(c.up.y) && std::isfinite(c.up.z);
    }
    std::optional<Camera> before_;
};

/// Asks for the pages that a subtree's contents lie in, as far as the view of `ahead` opens them.
template <class E>
void expect_contents_of(const E& ahead, Subtree subtree) {
    const auto& h = ahead.hierarchy;
    if (is_outside(ahead.view.planes, subtree)) return;
    float urgency = 1;
    if (subtree.has_stand_in()) {
        urgency = stand_in_error_px(ahead, subtree) / ahead.view.tolerance_px;
        if (!(urgency > 1)) return;
    }
    if (h.is_portal(h.nodes()[subtree.node]) && !h.expect(subtree, urgency)) return;
    if (h.nodes()[subtree.node].child_mask == 0) return;
    for_each_child<VisitOrder::any>(h, subtree, ahead.view.viewpoint(),
                                    [&](const Subtree& child) { expect_contents_of(ahead, child); });
}

/// The same of a subtree that the view of `v` does not open, or does not show: `urgency` is that of its stand-in now.
template <class E>
void expect_contents_ahead(const E& v, const Subtree& found, float urgency) {
    using H = typename E::hierarchy_type;
    using P = typename E::primitive_type;
    Subtree subtree = found;
    if (const LocalView* const view = v.hierarchy.view_ahead()) {
        // In so few frames nobody comes so near; and to ask is work for every stand-in that is drawn.
        constexpr float least = 0.6f;
        if (!(urgency > least)) return;
        subtree.crossed_planes = all_planes;
        return expect_contents_of(Entered<H, P>{v.hierarchy, v.source, *view, v.path}, subtree);
    }
    // Nobody knows where to: whatever would be opened from a little nearer.
    constexpr float nearer = 0.8f;
    if (urgency > nearer && urgency <= 1 && v.hierarchy.is_portal(v.hierarchy.nodes()[subtree.node])) {
        v.hierarchy.expect(subtree, urgency);
    }
}

}  // namespace farfield::detail
