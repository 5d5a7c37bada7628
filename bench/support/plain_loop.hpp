// The renderer one writes first: a scalar loop over all triangles, one after the other. Kept only because it is what
// the papers of 1995 and 1996 were measured against in spirit: every triangle goes down the pipeline, every frame.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <limits>
#include <span>
#include <vector>

#include "farfield/primitive/triangle.hpp"
#include "farfield/view/local_view.hpp"

namespace farfield::bench {

class PlainLoop {
  public:
    /// Perspective views only; triangles that cross the near plane are left out.
    void frame(std::span<const VertexColoredTriangle> triangles, const LocalView& view) {
        clear(view.width, view.height);
        draw(triangles, view);
    }
    void clear(int width, int height) {
        const std::size_t count = std::size_t(width) * std::size_t(height);
        depth_.assign(count, std::numeric_limits<float>::infinity());
        color_.assign(count, Rgba8{0, 0, 0, 0});
    }
    void draw(std::span<const VertexColoredTriangle> triangles, const LocalView& view) {
        for (const VertexColoredTriangle& t : triangles) draw(t, view);
    }
    std::span<const Rgba8> pixels() const { return color_; }

  private:
    void draw(const VertexColoredTriangle& t, const LocalView& view) {
        glm::vec3 p[3];
        for (int i = 0; i < 3; ++i) {
            const glm::vec3 d = t.vertices[std::size_t(i)] - view.eye;
            const float depth = glm::dot(d, view.forward);
            if (depth < view.near_depth) return;
            p[i] = {0.5f * float(view.width) + view.focal_px * glm::dot(d, view.right) / depth,
                    0.5f * float(view.height) - view.focal_px * glm::dot(d, view.up) / depth, depth};
        }
        const float area = (p[1].x - p[0].x) * (p[2].y - p[0].y) - (p[2].x - p[0].x) * (p[1].y - p[0].y);
        if (area == 0) return;
        const auto bounds = [&](int axis, int size, int& first, int& last) {
            const auto [low, high] = std::minmax({p[0][axis], p[1][axis], p[2][axis]});
            first = std::max(int(std::ceil(std::max(low, -1.0f) - 0.5f)), 0);
            last = std::min(int(std::floor(std::min(high, float(size) + 1) - 0.5f)), size - 1);
        };
        int x0, x1, y0, y1;
        bounds(0, view.width, x0, x1);
        bounds(1, view.height, y0, y1);
        for (int y = y0; y <= y1; ++y) {
            for (int x = x0; x <= x1; ++x) {
                const float px = float(x) + 0.5f, py = float(y) + 0.5f;
                const auto part = [&](int a, int b) {
                    return ((p[b].x - p[a].x) * (py - p[a].y) - (p[b].y - p[a].y) * (px - p[a].x)) / area;
                };
                const float w0 = part(1, 2), w1 = part(2, 0), w2 = part(0, 1);
                if (w0 < 0 || w1 < 0 || w2 < 0) continue;
                const float depth = w0 * p[0].z + w1 * p[1].z + w2 * p[2].z;
                const std::size_t at = std::size_t(y) * std::size_t(view.width) + std::size_t(x);
                if (depth >= depth_[at]) continue;
                depth_[at] = depth;
                color_[at] = t.rgba[0];
            }
        }
    }

    std::vector<float> depth_;
    std::vector<Rgba8> color_;
};

}  // namespace farfield::bench
