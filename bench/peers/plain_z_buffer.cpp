// It is compiled twice, with and without -march=native; FARFIELD_PLAIN_Z_BUFFER names what makes one.
//
// What it does for speed: 40 packed bytes a triangle; exact integer edges, 1/256 of a sample; wide rows solve for their
// span, narrow ones test their edges; loops over rows are left to the compiler's vectors; nothing is cleared for
// itself: colors count only where depth was written, and depth is reset while the filter has it in the cache, within
// the rectangle that was drawn to.
#include "plain_z_buffer.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <utility>
#include <vector>

namespace farfield::bench {
namespace {

constexpr int narrow = 32;                    ///< samples; up to it a row's edges are tested at each
constexpr float guard_band = 16000.0f * 256;  ///< 1/256 samples from the center; polygons are clipped there

struct Corner {
    double x, y, w;  ///< before division
};

class Afternoon final : public PlainZBuffer {
  public:
    explicit Afternoon(int samples_a_side) : a_side_(samples_a_side) {}

    void begin_frame(const LocalView& view) override {
        if (view.width * a_side_ != width_ || view.height * a_side_ != height_) {
            width_ = view.width * a_side_;
            height_ = view.height * a_side_;
            depth_.assign(std::size_t(width_) * std::size_t(height_), 0.0f);
            color_.assign(depth_.size(), 0u);
            sums_.resize(2 * std::size_t(width_));
        }
        left_ = width_, right_ = -1, top_ = height_, bottom_ = -1;
        set_view(view);
    }

    void set_view(const LocalView& view) override {
        const glm::vec2 scale = view.focal_px * float(a_side_) * 256.0f * view.squeeze;
        for (int i = 0; i < 3; ++i) {
            eye_[i] = view.eye[i];
            to_x_[i] = view.right[i] * scale.x;
            to_y_[i] = -view.up[i] * scale.y;
            to_w_[i] = view.forward[i];
        }
        near_ = view.near_depth;
        world_ = view.depth_unit / view.scale;
    }

    void draw(std::span<const PlainTriangle> triangles) override {
        for (const PlainTriangle& t : triangles) {
            float x[3], y[3], q[3];
            int outside = 0;
            for (int i = 0; i < 3; ++i) {
                const float dx = t.vertices[i][0] - eye_[0], dy = t.vertices[i][1] - eye_[1],
                            dz = t.vertices[i][2] - eye_[2];
                const float w = to_w_[0] * dx + to_w_[1] * dy + to_w_[2] * dz, inverse = 1 / w;
                x[i] = (to_x_[0] * dx + to_x_[1] * dy + to_x_[2] * dz) * inverse;
                y[i] = (to_y_[0] * dx + to_y_[1] * dy + to_y_[2] * dz) * inverse;
                q[i] = inverse * world_;
                outside |= int(!(w >= near_)) | int(std::abs(x[i]) > guard_band) | int(std::abs(y[i]) > guard_band);
            }
            if (outside) {
                draw_clipped(t);
            } else {
                fill(x, y, q, std::bit_cast<std::uint32_t>(t.rgba));
            }
        }
    }

    void end_frame() override {
        if (image_.width() * a_side_ != width_ || image_.height() * a_side_ != height_) {
            image_ = Image(width_ / a_side_, height_ / a_side_);
        }
        std::fill(image_.pixels().begin(), image_.pixels().end(), Rgba8{0, 0, 0, 0});
        if (left_ > right_) return;
        const int first = left_ / a_side_, end = right_ / a_side_ + 1;
        for (int y = top_ / a_side_; y <= bottom_ / a_side_; ++y) filter_row(y, first, end);
    }

    const Image& image() const override { return image_; }

  private:
    /// Sutherland and Hodgman, in double precision: few triangles come here.
    void draw_clipped(const PlainTriangle& t) {
        Corner corners[8], cut[8];
        int count = 3;
        for (int i = 0; i < 3; ++i) {
            double d[3];
            for (int k = 0; k < 3; ++k) d[k] = double(t.vertices[i][k]) - double(eye_[k]);
            const auto along = [&](const float(&axis)[3]) {
                return double(axis[0]) * d[0] + double(axis[1]) * d[1] + double(axis[2]) * d[2];
            };
            corners[i] = {along(to_x_), along(to_y_), along(to_w_)};
        }
        for (int plane = 0; plane < 5 && count >= 3; ++plane) {
            const auto inside = [&](const Corner& c) {
                const double guard = double(guard_band) * c.w;
                return plane == 0   ? c.w - double(near_)
                       : plane == 1 ? guard - c.x
                       : plane == 2 ? guard + c.x
                       : plane == 3 ? guard - c.y
                                    : guard + c.y;
            };
            int kept = 0;
            for (int i = 0; i < count; ++i) {
                const Corner &a = corners[i], &b = corners[(i + 1) % count];
                const double at_a = inside(a), at_b = inside(b);
                if (at_a >= 0) cut[kept++] = a;
                if ((at_a >= 0) != (at_b >= 0)) {
                    const double part = at_a / (at_a - at_b);
                    cut[kept++] = {a.x + (b.x - a.x) * part, a.y + (b.y - a.y) * part, a.w + (b.w - a.w) * part};
                }
            }
            std::copy(cut, cut + kept, corners);
            count = kept;
        }
        float x[8], y[8], q[8];
        for (int i = 0; i < count; ++i) {
            x[i] = float(std::clamp(corners[i].x / corners[i].w, -double(guard_band), double(guard_band)));
            y[i] = float(std::clamp(corners[i].y / corners[i].w, -double(guard_band), double(guard_band)));
            q[i] = float(double(world_) / corners[i].w);
        }
        for (int i = 2; i < count; ++i) {
            const float fan_x[3] = {x[0], x[i - 1], x[i]}, fan_y[3] = {y[0], y[i - 1], y[i]},
                        fan_q[3] = {q[0], q[i - 1], q[i]};
            fill(fan_x, fan_y, fan_q, std::bit_cast<std::uint32_t>(t.rgba));
        }
    }

    /// Adding 3 * 2^22 leaves the nearest integer in the low bits.
    static int rounded(float v) { return std::bit_cast<int>(v + 12582912.0f) - 0x4b400000; }

    void fill(const float (&fx)[3], const float (&fy)[3], const float (&q)[3], std::uint32_t color) {
        int x[3], y[3];
        for (int i = 0; i < 3; ++i) {
            x[i] = rounded(fx[i]) + width_ * 128;
            y[i] = rounded(fy[i]) + height_ * 128;
        }
        const int low_x = std::min({x[0], x[1], x[2]}), high_x = std::max({x[0], x[1], x[2]});
        const int low_y = std::min({y[0], y[1], y[2]}), high_y = std::max({y[0], y[1], y[2]});
        const int x0 = std::max((low_x + 127) >> 8, 0), x1 = std::min((high_x - 128) >> 8, width_ - 1);
        const int y0 = std::max((low_y + 127) >> 8, 0), y1 = std::min((high_y - 128) >> 8, height_ - 1);
        if (x0 > x1 || y0 > y1) return;
        const std::int64_t area = std::int64_t(x[1] - x[0]) * (y[2] - y[0]) - std::int64_t(x[2] - x[0]) * (y[1] - y[0]);
        if (area == 0) return;
        left_ = std::min(left_, x0), right_ = std::max(right_, x1);
        top_ = std::min(top_, y0), bottom_ = std::max(bottom_, y1);

        const float q1 = q[1] - q[0], q2 = q[2] - q[0], scale = 256 / float(area);
        const float q_by_x = (q1 * float(y[2] - y[0]) - q2 * float(y[1] - y[0])) * scale;
        const float q_by_y = (q2 * float(x[1] - x[0]) - q1 * float(x[2] - x[0])) * scale;
        float q_row =
            q[0] + q_by_x * (float(x0 * 256 + 128 - x[0]) / 256) + q_by_y * (float(y0 * 256 + 128 - y[0]) / 256);

        // Edge i leads from corner i to the next; on the screen's left and top an edge has its samples.
        std::int64_t e[3], by_x[3], by_y[3];
        for (int i = 0; i < 3; ++i) {
            const int a = area > 0 ? i : (i + 1) % 3, b = area > 0 ? (i + 1) % 3 : i;
            const std::int64_t dx = x[b] - x[a], dy = y[b] - y[a];
            e[i] = dx * (y0 * 256 + 128 - y[a]) - dy * (x0 * 256 + 128 - x[a]) - !(dy < 0 || (dy == 0 && dx > 0));
            by_x[i] = -dy * 256;
            by_y[i] = dx * 256;
        }
        const int count = x1 - x0 + 1;
        const std::size_t stride = std::size_t(width_);
        std::size_t at = std::size_t(y0) * stride + std::size_t(x0);
        if (count <= narrow && high_x - low_x < 1 << 14 && high_y - low_y < 1 << 14) {
            int a = int(e[0]), b = int(e[1]), c = int(e[2]);
            const int a_x = int(by_x[0]), b_x = int(by_x[1]), c_x = int(by_x[2]);
            for (int row = y0; row <= y1; ++row, at += stride, q_row += q_by_y) {
                test_row(&depth_[at], &color_[at], count, a, b, c, a_x, b_x, c_x, q_row, q_by_x, color);
                a += int(by_y[0]), b += int(by_y[1]), c += int(by_y[2]);
            }
        } else {
            for (int row = y0; row <= y1; ++row, at += stride, q_row += q_by_y) {
                // Quotients in double precision are exact once rounded down: both numbers are integers below 2^53.
                double begin = 0, end = count;
                for (int i = 0; i < 3; ++i) {
                    if (by_x[i] > 0) begin = std::max(begin, std::ceil(double(-e[i]) / double(by_x[i])));
                    if (by_x[i] < 0) end = std::min(end, std::floor(double(e[i]) / double(-by_x[i])) + 1);
                    if (by_x[i] == 0 && e[i] < 0) end = 0;
                    e[i] += by_y[i];
                }
                if (begin >= end) continue;
                const int i = int(begin);
                fill_row(&depth_[at + std::size_t(i)], &color_[at + std::size_t(i)], int(end) - i,
                         q_row + q_by_x * float(i), q_by_x, color);
            }
        }
    }

    static void test_row(float* __restrict depth, std::uint32_t* __restrict colors, int count, int a, int b, int c,
                         int a_x, int b_x, int c_x, float q, float q_by_x, std::uint32_t color) {
        if (count < 8) {  // too few for vectors
            for (int i = 0; i < count; ++i, a += a_x, b += b_x, c += c_x) {
                const float here = q + q_by_x * float(i);
                if ((a | b | c) >= 0 && here > depth[i]) {
                    depth[i] = here;
                    colors[i] = color;
                }
            }
            return;
        }
        for (int i = 0; i < count; ++i) {
            const float here = q + q_by_x * float(i);
            const bool is_seen = (((a + a_x * i) | (b + b_x * i) | (c + c_x * i)) >= 0) & (here > depth[i]);
            depth[i] = is_seen ? here : depth[i];
            colors[i] = is_seen ? color : colors[i];
        }
    }

    static void fill_row(float* __restrict depth, std::uint32_t* __restrict colors, int count, float q, float q_by_x,
                         std::uint32_t color) {
        for (int i = 0; i < count; ++i) {
            const float here = q + q_by_x * float(i);
            const bool is_nearer = here > depth[i];
            depth[i] = is_nearer ? here : depth[i];
            colors[i] = is_nearer ? color : colors[i];
        }
    }

    /// Writes pixels [first, end) of a row, and resets depth.
    void filter_row(int y, int first, int end) {
        const std::size_t begin = std::size_t(first * a_side_), count = std::size_t((end - first) * a_side_);
        std::uint32_t* __restrict even = sums_.data();
        std::uint32_t* __restrict odd = even + count;
        for (int row = 0; row < a_side_; ++row) {
            const std::size_t at = std::size_t(y * a_side_ + row) * std::size_t(width_) + begin;
            float* __restrict depth = &depth_[at];
            const std::uint32_t* __restrict colors = &color_[at];
            if (a_side_ == 1) {
                for (std::size_t i = 0; i < count; ++i) even[i] = depth[i] > 0 ? colors[i] : 0;
                std::memcpy(static_cast<void*>(&image_.at(first, y)), even, count * sizeof(Rgba8));
            } else {
                if (row == 0) std::fill(even, even + 2 * count, 0u);
                for (std::size_t i = 0; i < count; ++i) {
                    const std::uint32_t c = depth[i] > 0 ? colors[i] : 0;
                    even[i] += c & 0x00ff00ffu;  // two channels a word: 64 times 255 stay below 2^16
                    odd[i] += c >> 8 & 0x00ff00ffu;
                }
            }
            std::fill(depth, depth + count, 0.0f);
        }
        for (int x = first; a_side_ == 8 && x < end; ++x) {
            std::uint32_t e = 0x00200020u, o = 0x00200020u;  // rounds to nearest
            for (int i = (x - first) * 8, last = i + 8; i < last; ++i) e += even[i], o += odd[i];
            image_.at(x, y) = std::bit_cast<Rgba8>((e >> 6 & 0x00ff00ffu) | (o >> 6 & 0x00ff00ffu) << 8);
        }
    }

    int a_side_;
    int width_ = 0, height_ = 0;                          ///< in samples
    int left_ = 0, right_ = -1, top_ = 0, bottom_ = -1;   ///< what this frame has drawn to
    float eye_[3]{}, to_x_[3]{}, to_y_[3]{}, to_w_[3]{};  ///< axes in 1/256 samples at depth 1
    float near_ = 0, world_ = 1;
    std::vector<float> depth_;          ///< its inverse; 0: nothing
    std::vector<std::uint32_t> color_;  ///< means something where there is depth
    std::vector<std::uint32_t> sums_;   ///< of a row of pixels, samples one above another
    Image image_;
};

}  // namespace

std::unique_ptr<PlainZBuffer> FARFIELD_PLAIN_Z_BUFFER(int samples_a_side) {
    return std::make_unique<Afternoon>(samples_a_side);
}

}  // namespace farfield::bench
