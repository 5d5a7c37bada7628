// Polygons made for one frame, on their way to a renderer.
#pragma once

#include "farfield/settings.hpp"

#include <cstddef>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "farfield/geometry/clip_polygon.hpp"
#include "farfield/renderer.hpp"

namespace farfield::detail {

/// A batch of polygons of one view. Keeps its buffers.
class PolygonBatch {
  public:
    bool empty() const { return ends_.empty(); }
    bool is_full() const { return ends_.size() >= 256; }

    void clear() {
        vertices_.clear();
        colors_.clear();
        ends_.clear();
    }

    void add(std::span<const Corner> corners) {
        for (const Corner& c : corners) {
            vertices_.push_back(c.position);
            colors_.push_back(c.color);
        }
        ends_.push_back(vertices_.size());
    }

    /// Draws the polygons in the order they came in and empties the batch.
    template <DrawsPolygons R>
    void draw(R& renderer) {
        if (empty()) return;
        polygons_.clear();
        std::size_t begin = 0;
        for (const std::size_t end : ends_) {
            polygons_.push_back({std::span(vertices_).subspan(begin, end - begin),
                                 std::span(colors_).subspan(begin, end - begin), false});
            begin = end;
        }
        renderer.draw(std::span<const Polygon>(polygons_));
        clear();
    }

  private:
    std::vector<glm::vec3> vertices_;
    std::vector<Rgba8> colors_;
    std::vector<std::size_t> ends_;
    std::vector<Polygon> polygons_;
};

}  // namespace farfield::detail
