// Projects a hierarchy's coordinates onto the grid of samples.
#pragma once

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <limits>

#include "farfield/view/local_view.hpp"

namespace farfield::detail {

/// Sample (i, j), rows downwards, has its center at (i + 1/2, j + 1/2). Coordinates are relative to the sample nearest
/// to where the view's axis meets the picture's plane, its center in most pictures, and in 1/256 sample, to which
/// snapping rounds. So tiles of one picture have the same coordinates and get the same samples; where an image would
/// leave the guard band, the sample is another one.
///
/// Depth is kept as q, which is linear over the screen and larger when nearer: 1 / depth in perspective views and
/// -depth in orthographic ones. It is the depth in the world, so that instances of any scale compare.
struct SampleProjection {
    /// Polygons are clipped farther than this many samples from the center. Coordinates in 1/256 sample then fit 22
    /// bits and a sign, where adding a constant rounds single precision to integers.
    static constexpr float guard_band = 16000.0f;

    glm::vec3 eye{0};
    glm::vec3 right{1, 0, 0};  ///< scaled: dot(right, p - eye) is 1/256 samples times depth, or 1/256 samples
    glm::vec3 down{0, -1, 0};
    glm::vec3 forward{0, 0, -1};
    float offset_x = 0, offset_y = 0;
    /// x and y are multiplied by 1 / (depth * depth_weight + depth_bias).
    float depth_weight = 1, depth_bias = 0;
    /// q is that factor * q_of_inverse + depth * q_of_depth.
    float q_of_inverse = 1, q_of_depth = 0;
    float near_depth = 0, far_depth = std::numeric_limits<float>::infinity();
    glm::vec2 focal{1};  ///< in samples
    bool is_perspective = true;
    bool is_mirrored = false;  ///< what is counter-clockwise from its front is clockwise on the screen
    int first_x = 0, first_y = 0, end_x = 0, end_y = 0;  ///< the image, relative to the center sample

    SampleProjection() = default;
    SampleProjection(const LocalView& view, int samples_a_side) {
        const int width = view.width * samples_a_side, height = view.height * samples_a_side;
        eye = view.eye;
        focal = view.focal_px * float(samples_a_side) * view.squeeze;
        right = view.right * (focal.x * 256);
        down = -view.up * (focal.y * 256);
        forward = view.forward;
        place(width, view.off_center.x * width / 2, first_x, offset_x);
        place(height, -view.off_center.y * height / 2, first_y, offset_y);
        end_x = first_x + width;
        end_y = first_y + height;
        is_perspective = view.is_perspective;
        depth_weight = is_perspective ? 1.0f : 0.0f;
        depth_bias = 1.0f - depth_weight;
        q_of_inverse = is_perspective ? 1.0f / view.scale : 0.0f;
        q_of_depth = is_perspective ? 0.0f : -view.scale;
        near_depth = view.near_depth;
        far_depth = view.far_depth;
        is_mirrored = view.is_mirrored;
    }

    /// The coordinates before division: (x, y) in 1/256 samples times w, and depth.
    glm::vec3 project(glm::vec3 p) const {
        const glm::vec3 d = p - eye;
        return {glm::dot(right, d), glm::dot(down, d), glm::dot(forward, d)};
    }
    float inverse_w(float depth) const { return 1.0f / (depth * depth_weight + depth_bias); }
    float q(float depth, float inverse) const { return inverse * q_of_inverse + depth * q_of_depth; }

  private:
    /// `shift` says how many samples beyond the axis an image's center lies.
    static void place(int samples, double shift, int& first, float& offset) {
        first = -(samples / 2);
        offset = 128.0f * float(samples) + 256.0f * float(first);
        if (shift == 0) return;
        const double most = double(guard_band) - 1;
        const double steps = std::round(std::min(std::max(shift, -most - first), most - first - samples));
        first += int(steps);
        offset += float(256 * (steps - shift));
    }
};

}  // namespace farfield::detail
