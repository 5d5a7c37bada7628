// Projects a hierarchy's coordinates onto the grid of samples.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <limits>
#include <optional>
#include <stdexcept>

#include "farfield/drawables.hpp"
#include "farfield/fail.hpp"
#include "farfield/view/local_view.hpp"

namespace farfield::detail {

/// The weight of a corner's color where colors are interpolated over the screen: 1 / depth in perspective, or 1.
struct ColorWeight {
    float by_q = 1, at_zero = 0;

    float operator()(float q) const { return q * by_q + at_zero; }
};

/// The rectangle that a splat is deposited over, in samples from the center sample, and its depth.
struct SplatFootprint {
    glm::vec2 center, half;
    float q;
};

/// Sample (i, j), rows downwards, has its center at (i + 1/2, j + 1/2). Coordinates are relative to the sample nearest
/// to where the view's axis meets the picture's plane, its center in most pictures, and in 1/256 sample, to which
/// snapping rounds. So tiles of one picture have the same coordinates and get the same samples.
///
/// Depths are counted from the view's anchor. They are kept as q, which is linear over the screen and larger when
/// nearer: 1 / depth in perspective views and -depth in orthographic ones, in the view's depth_unit. It is the depth in
/// the world, so that instances of any scale compare. Where the eye is far from its anchor, 1 / depth could not tell
/// things apart, and q is the difference to that of the anchor: in the square of the anchor's inverse depth, as
/// numbers then stay near 1.
struct SampleProjection {
    /// Polygons are clipped farther than this many samples from the center. Coordinates in 1/256 sample then fit 22
    /// bits and a sign, where adding a constant rounds single precision to integers.
    static constexpr float guard_band = 16000.0f;
    /// Contents of a cell are projected and snapped on their own, and may lie this much beside it, in samples.
    static constexpr float snapping = 8.0f / 256;

    glm::vec3 anchor{0};
    glm::vec3 right{1, 0, 0};  ///< scaled: dot(right, p - anchor) is 1/256 samples times w
    glm::vec3 down{0, -1, 0};
    glm::vec3 forward{0, 0, -1};
    float offset_x = 0, offset_y = 0;
    /// x and y are divided by w = depth * depth_weight + depth_bias.
    float depth_weight = 1, depth_bias = 0;
    /// q is (q_of_inverse + depth * q_of_depth) / w.
    float q_of_inverse = 1, q_of_depth = 0;
    float near_depth = 0;  ///< from the anchor
    float far_depth = std::numeric_limits<float>::infinity();
    glm::vec2 focal{1};  ///< in samples
    bool is_perspective = true;
    bool is_mirrored = false;  ///< what is counter-clockwise from its front is clockwise on the screen
    bool is_at_eye = true;     ///< whether depths are counted from the eye
    ColorWeight color_weight;
    std::uint32_t seed = 0;  ///< LocalView's
    /// How far from its place, in samples, something may be drawn: snapping, and what stand-ins reach beyond cells.
    float reach = snapping;
    int first_x = 0, first_y = 0, end_x = 0, end_y = 0;  ///< the image, relative to the center sample
    /// What small triangles have to touch to be deposited, in 1/256 sample: the whole picture, and in a tile also one
    /// sample around it, which the square that is deposited for a triangle may reach into.
    float small_left = 0, small_top = 0, small_right = 0, small_bottom = 0;
    int left = 0, top = 0;                  ///< samples of the whole picture beside a tile, and above it
    int whole_width = 0, whole_height = 0;  ///< in samples

    SampleProjection() = default;
    SampleProjection(const LocalView& view, int samples_a_side) {
        const PartOfPicture& part = view.part;
        anchor = view.anchor;
        focal = view.focal_px * float(samples_a_side) * view.squeeze;
        right = view.right * (focal.x * 256);
        down = -view.up * (focal.y * 256);
        forward = view.forward;
        place(samples_a_side, part.whole_width, view.whole_off_center.x, part.left, view.width, first_x, offset_x);
        place(samples_a_side, part.whole_height, -view.whole_off_center.y, part.top, view.height, first_y, offset_y);
        left = part.left * samples_a_side;
        top = part.top * samples_a_side;
        whole_width = part.whole_width * samples_a_side;
        whole_height = part.whole_height * samples_a_side;
        end_x = first_x + view.width * samples_a_side;
        end_y = first_y + view.height * samples_a_side;
        small_left = 256.0f * float(first_x - (part.left > 0));
        small_top = 256.0f * float(first_y - (part.top > 0));
        small_right = 256.0f * float(end_x + (part.left + view.width < part.whole_width));
        small_bottom = 256.0f * float(end_y + (part.top + view.height < part.whole_height));
        is_perspective = view.is_perspective;
        is_at_eye = view.anchor_depth == 0;
        seed = view.seed;
        depth_weight = is_perspective ? 1.0f : 0.0f;
        is_mirrored = view.is_mirrored;
        depth_bias = is_perspective ? view.anchor_depth : 1.0f;
        near_depth = view.near_depth - view.anchor_depth;
        far_depth = view.far_depth - view.anchor_depth;
        reach = snapping + view.reach_px * float(samples_a_side);
        const float world_units = view.scale / view.depth_unit;
        if (!is_perspective) {
            q_of_inverse = 0;
            q_of_depth = -world_units;
            color_weight = {0, 1};
        } else if (is_at_eye) {
            q_of_inverse = 1 / world_units;
            q_of_depth = 0;
        } else {
            // Depth d is seen from the eye at a + d, and 1 / (a + d) - 1 / a = -d / (a + d) / a.
            q_of_inverse = 0;
            q_of_depth = -view.anchor_depth * world_units;
            color_weight = {1 / (view.anchor_depth * world_units), 1};
            // Clipping divides by w.
            near_depth = std::max(near_depth, -view.anchor_depth * (1 - 0x1p-20f));
        }
    }

    /// The coordinates before division: (x, y) in 1/256 samples times w, and depth.
    glm::vec3 project(glm::vec3 p) const {
        const glm::vec3 d = p - anchor;
        return {glm::dot(right, d), glm::dot(down, d), glm::dot(forward, d)};
    }
    float w(float depth) const { return depth * depth_weight + depth_bias; }
    float inverse_w(float depth) const { return 1.0f / w(depth); }
    float q(float depth, float inverse) const { return inverse * (q_of_inverse + depth * q_of_depth); }

    /// Nothing for a splat that does not lie before the eye.
    std::optional<SplatFootprint> footprint(const Splat& splat) const {
        const glm::vec3 p = project(splat.center);
        if (!(p.z > near_depth)) return {};
        const float inverse = inverse_w(p.z);
        return SplatFootprint{{(p.x * inverse + offset_x) * (1.0f / 256), (p.y * inverse + offset_y) * (1.0f / 256)},
                              splat.size * (0.5f * focal * inverse),
                              q(p.z, inverse)};
    }

  private:
    /// Places the pixels [first_px, first_px + count_px) of a picture of `whole_px` whose center lies `off_center` of
    /// its halves beyond the axis. Where samples would leave the guard band, std::invalid_argument is thrown.
    static void place(int samples_a_side, int whole_px, double off_center, int first_px, int count_px, int& first,
                      float& offset) {
        const double whole = double(whole_px) * samples_a_side, shift = off_center * whole / 2;
        const double most = double(guard_band) - 1, steps = shift == 0 ? 0 : std::round(shift);
        const int whole_samples = whole_px * samples_a_side;
        const double begin = steps - whole_samples / 2 + double(first_px) * samples_a_side;
        if ((shift != 0 || first_px != 0 || count_px != whole_px) &&
            !(begin >= -most && begin + double(count_px) * samples_a_side <= most)) {
            detail::fail<std::invalid_argument>(
                "farfield::Camera: off_center puts the picture more than 16000 samples beside the view's axis; take "
                "fewer samples, or turn the camera");
        }
        first = int(begin);
        offset = whole_samples % 2 == 0 ? 0.0f : 128.0f;
        if (shift != 0) offset += float(256 * (steps - shift));
    }
};

}  // namespace farfield::detail
