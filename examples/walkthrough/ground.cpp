#include "ground.hpp"

#include <algorithm>
#include <glm/common.hpp>
#include <limits>

namespace walkthrough {

Ground::Ground(const farfield::scenes::Scene& scene, const FrameOfReference& frame) {
    const auto& triangles = scene.groups.back().triangles;
    glm::vec2 lower(std::numeric_limits<float>::infinity()), upper(-lower);
    lowest_ = std::numeric_limits<float>::infinity();
    for (const auto& t : triangles) {
        for (const glm::vec3& v : t.vertices) {
            const glm::vec3 p = frame.in_units(v);
            lower = glm::min(lower, frame.plan(p));
            upper = glm::max(upper, frame.plan(p));
            lowest_ = std::min(lowest_, frame.height(p));
        }
    }
    if (triangles.empty()) {
        lowest_ = frame.height(frame.in_units(farfield::scenes::bounds(scene).lower));
        return;
    }
    lower_ = lower;
    squares_per_unit_ = float(squares) / (upper - lower);
    heights_.assign(std::size_t(squares) * squares, lowest_);
    for (const auto& t : triangles) raise(t, frame);
}

float Ground::height(glm::vec2 plan) const {
    if (heights_.empty()) return lowest_;
    const glm::ivec2 at = square_of(plan);
    float highest = lowest_;
    for (int y = std::max(at.y - 1, 0); y <= std::min(at.y + 1, squares - 1); ++y) {
        for (int x = std::max(at.x - 1, 0); x <= std::min(at.x + 1, squares - 1); ++x) {
            highest = std::max(highest, heights_[std::size_t(y) * squares + std::size_t(x)]);
        }
    }
    return highest;
}

glm::ivec2 Ground::square_of(glm::vec2 plan) const {
    // In a scene without extent along one axis a square is 0 times infinity. A clamp would let that through, and as an
    // integer it is anything; this comparison takes it for the first square.
    const auto square = [](float s) { return s > 0 ? int(std::min(s, float(squares - 1))) : 0; };
    const glm::vec2 at = (plan - lower_) * squares_per_unit_;
    return {square(at.x), square(at.y)};
}

void Ground::raise(const farfield::VertexColoredTriangle& triangle, const FrameOfReference& frame) {
    const glm::vec3 a = frame.in_units(triangle.vertices[0]), b = frame.in_units(triangle.vertices[1]),
                    c = frame.in_units(triangle.vertices[2]);
    const glm::vec2 pa = frame.plan(a), pb = frame.plan(b), pc = frame.plan(c);
    const float height = std::max({frame.height(a), frame.height(b), frame.height(c)});
    const glm::ivec2 first = square_of(glm::min(pa, glm::min(pb, pc)));
    const glm::ivec2 last = square_of(glm::max(pa, glm::max(pb, pc)));
    for (int y = first.y; y <= last.y; ++y) {
        for (int x = first.x; x <= last.x; ++x) {
            float& highest = heights_[std::size_t(y) * squares + std::size_t(x)];
            highest = std::max(highest, height);
        }
    }
}

}  // namespace walkthrough
