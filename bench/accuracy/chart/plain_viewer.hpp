// The plain loop of support/ as one of those that take turns.
#pragma once

#include <cmath>
#include <glm/geometric.hpp>
#include <stdexcept>

#include "farfield/view/local_view.hpp"
#include "scenes/built_scene.hpp"
#include "scenes/scene.hpp"
#include "support/plain_loop.hpp"

namespace farfield::bench {

class PlainViewer final : public scenes::SceneViewer {
  public:
    /// Instances are expanded.
    explicit PlainViewer(const scenes::Scene& scene)
        : expanded_(scenes::expanded(scene)), diagonal_(glm::length(scenes::bounds(scene).size())) {}

    FrameStats frame(const View& view) override {
        const auto& triangles = expanded_.groups.back().triangles;
        loop_.frame(triangles, LocalView(view, glm::dvec3(0), diagonal_));
        FrameStats stats;
        stats.primitives = triangles.size();
        return stats;
    }
    /// Only timed.
    const Image& image() const override { throw std::logic_error("the plain loop keeps no picture"); }

  private:
    scenes::Scene expanded_;
    float diagonal_;
    PlainLoop loop_;
};

}  // namespace farfield::bench
