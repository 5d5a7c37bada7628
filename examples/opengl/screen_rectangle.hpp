// The part of a picture that is drawn into: what lies outside of it need be neither cleared nor looked at.
#pragma once

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "farfield/geometry/box.hpp"
#include "opengl/view_row.hpp"

namespace farfield::opengl {

/// In pixels, rows downwards, the end not included.
struct ScreenRectangle {
    int left = 0, top = 0, right = 0, bottom = 0;

    bool is_empty() const { return left >= right || top >= bottom; }
    int width() const { return right - left; }
    int height() const { return bottom - top; }
};

/// Grows by what it is told of, in a picture of this size.
class DrawnPart {
  public:
    DrawnPart(int width, int height) : size_(width, height) {}

    void add(const Box& box, const ViewRow& row) {
        for (int i = 0; i < 8; ++i) {
            add(glm::vec3((i & 1) != 0 ? box.upper.x : box.lower.x, (i & 2) != 0 ? box.upper.y : box.lower.y,
                          (i & 4) != 0 ? box.upper.z : box.lower.z),
                row);
        }
    }
    /// One corner of something convex.
    void add(glm::vec3 p, const ViewRow& row) {
        const glm::vec3 d = p - glm::vec3(row.anchor);
        const float w = glm::dot(glm::vec3(row.forward), d) * row.forward.w + row.anchor.w;
        const glm::vec2 clip(glm::dot(glm::vec3(row.across), d) + w * row.across.w,
                             glm::dot(glm::vec3(row.upward), d) + w * row.upward.w);
        // Behind the eye, or so near that it may be anywhere.
        const glm::vec2 at = w > 0 ? clip / w : glm::vec2(2);
        if (!(w > 0)) low_ = glm::vec2(-1), high_ = glm::vec2(1);
        low_ = glm::min(low_, at);
        high_ = glm::max(high_, at);
    }

    void add(const DrawnPart& other) {
        low_ = glm::min(low_, other.low_);
        high_ = glm::max(high_, other.high_);
    }

    /// With a pixel to spare on each side.
    ScreenRectangle rectangle() const {
        if (!(low_.x <= high_.x)) return {};
        const auto pixel = [](float ndc, float size) {
            return int(std::clamp((0.5f + 0.5f * ndc) * size, -4.0f, size + 4.0f));
        };
        const ScreenRectangle r{pixel(low_.x, size_.x) - 1, pixel(-high_.y, size_.y) - 1, pixel(high_.x, size_.x) + 2,
                                pixel(-low_.y, size_.y) + 2};
        return {std::max(r.left, 0), std::max(r.top, 0), std::min(r.right, int(size_.x)),
                std::min(r.bottom, int(size_.y))};
    }

  private:
    glm::vec2 size_;
    glm::vec2 low_{1e9f}, high_{-1e9f};
};

}  // namespace farfield::opengl
