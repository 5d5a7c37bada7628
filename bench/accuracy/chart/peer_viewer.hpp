// The peer's loop over all triangles as one of those that take turns.
#pragma once

#include <memory>
#include <vector>

#include "farfield/view/local_view.hpp"
#include "peers/plain_renderer.hpp"
#include "scenes/built_scene.hpp"
#include "scenes/scene.hpp"

namespace farfield::bench {

/// Scenes of more triangles than this are too large to be expanded.
constexpr double peer_limit = 4'000'000;

class PeerViewer final : public scenes::SceneViewer {
  public:
    /// Instances are expanded.
    PeerViewer(const scenes::Scene& scene, int samples_a_side)
        : triangles_(plain_triangles(scenes::expanded(scene).groups.back().triangles)),
          bounds_(scenes::bounds(scene)),
          peer_(native_plain_z_buffer(samples_a_side)) {}

    FrameStats frame(const View& view) override {
        peer_->begin_frame(LocalView(view, glm::dvec3(0), bounds_));
        peer_->draw(triangles_);
        peer_->end_frame();
        FrameStats stats;
        stats.primitives = triangles_.size();
        return stats;
    }
    const Image& image() const override { return peer_->image(); }

  private:
    std::vector<PlainTriangle> triangles_;
    Box bounds_;
    std::unique_ptr<PlainZBuffer> peer_;
};

}  // namespace farfield::bench
