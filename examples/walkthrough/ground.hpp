// How high one has to be, so as not to be in the ground.
#pragma once

#include <cstddef>
#include <vector>

#include "farfield/primitive/triangle.hpp"
#include "frame_of_reference.hpp"
#include "scenes/scene.hpp"

namespace walkthrough {

/// A coarse grid of the greatest heights of the root's own triangles: of the ground alone where all else is placed on
/// it, as on the island, else of everything. Lengths are in the frame's unit.
class Ground {
  public:
    Ground(const farfield::scenes::Scene& scene, const FrameOfReference& frame);

    /// Never too low within one square about the place; the lowest height of all where there is nothing.
    float height(glm::vec2 plan) const;

  private:
    static constexpr int squares = 256;  ///< along a side

    glm::ivec2 square_of(glm::vec2 plan) const;
    void raise(const farfield::VertexColoredTriangle& triangle, const FrameOfReference& frame);

    glm::vec2 lower_{0}, squares_per_unit_{0};
    float lowest_ = 0;
    std::vector<float> heights_;
};

}  // namespace walkthrough
