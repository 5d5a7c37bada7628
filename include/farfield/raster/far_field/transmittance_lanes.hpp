// Deposits a square into the lanes of the samples it touches (far_sample.hpp): one lane at a time on any machine, eight
// at a time on any x86-64. The picture does not depend on which.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <cstdint>
#include <glm/vec3.hpp>

#include "farfield/geometry/area_law.hpp"
#include "farfield/raster/far_field/far_sample.hpp"
#include "farfield/raster/far_field/transmittance_lanes_sse2.hpp"

namespace farfield::detail {

// Two namespaces that compute the same bits, one lane at a time and eight:
//
//   Square         is cut off at the borders of a picture and rounded to units; NaN counts as 0
//     is_empty     nothing is left of it; nothing else may then be called
//     x0 ... y1    the samples that it touches, ends included
//     is_small     it touches at most 16 samples a side; only then may these be called:
//     columns(i)   how much of each column of lanes it covers in the i-th samples from the left
//     rows(i)      how much of each row of lanes in the i-th samples from the top
//     starts_at_column ... ends_at_row  whether its edges lie on borders of samples, so that it covers those that it
//                  touches there whole, as all between
//   Deposit        a loss in 65535ths, rounded and clamped to [0, 1] (NaN counts as 0), and a color
//     into         takes the loss from the part of each lane that is covered; true if that closed the sample. Without
//                  columns and rows the sample is covered whole; without lanes these are alike, too

namespace one_lane_at_a_time {

template <int lane>
struct Widths {
    std::uint32_t of[lanes::side];

    Widths(int begin, int end) {
        for (int i = 0; i < lanes::side; ++i) {
            of[i] = std::uint32_t(std::clamp(end - i * lane, 0, lane) - std::clamp(begin - i * lane, 0, lane));
        }
    }
};
using Columns = Widths<lanes::width>;
using Rows = Widths<lanes::height>;

class Square {
  public:
    int x0, y0, x1, y1;

    Square(float left, float top, float right, float bottom, int width, int height) {
        const Edge l(left, width, lanes::sample_width, 0.5f), r(right, width, lanes::sample_width, -0.5f);
        const Edge t(top, height, lanes::sample_height, 0.5f), b(bottom, height, lanes::sample_height, -0.5f);
        x0 = l.sample;
        y0 = t.sample;
        x1 = r.sample;
        y1 = b.sample;
        left_ = l.rest;
        top_ = t.rest;
        right_ = r.rest + (r.sample - x0) * lanes::sample_width;
        bottom_ = b.rest + (b.sample - y0) * lanes::sample_height;
    }
    bool is_empty() const { return left_ >= right_ || top_ >= bottom_; }
    bool is_small() const { return x1 - x0 < lanes::most_samples && y1 - y0 < lanes::most_samples; }
    Columns columns(int i) const { return {left_ - i * lanes::sample_width, right_ - i * lanes::sample_width}; }
    Rows rows(int i) const { return {top_ - i * lanes::sample_height, bottom_ - i * lanes::sample_height}; }
    bool starts_at_column() const { return left_ == 0; }
    bool starts_at_row() const { return top_ == 0; }
    bool ends_at_column() const { return right_ == (x1 - x0 + 1) * lanes::sample_width; }
    bool ends_at_row() const { return bottom_ == (y1 - y0 + 1) * lanes::sample_height; }

  private:
    struct Edge {
        int sample, rest;

        /// The sample is taken half a unit inwards, so that none is touched but not covered.
        Edge(float at, int samples, int units, float inwards) {
            const float v = std::min(std::max(0.0f, at), float(samples));
            sample = int(std::min(v + inwards / float(units), float(samples) - 1));
            rest = int((v - float(sample)) * float(units) + 0.5f);
        }
    };
    int left_, top_, right_, bottom_;  ///< in units from the upper left sample's corner
};

/// a b / 65535 rounded to nearest; a product with 65535 is exact (above 1/2 it may be one too small).
inline std::uint32_t product(std::uint32_t a, std::uint32_t b) {
    const std::uint32_t high = a * b >> 16, low = a * b & 0xffff;
    return high + (std::min<std::uint32_t>(low + high, 0xffff) >> 15);
}

class Deposit {
  public:
    Deposit(Loss loss, glm::vec3 rgb)
        : relative_(rounded(loss.relative)), absolute_(rounded(loss.absolute)), rgb_(rgb) {}

    bool into(FarSample& s, FarLanes& of, const Columns& columns, const Rows& rows) const {
        int sum = 0;
        for (int i = 0; i < lanes::count; ++i) {
            const std::uint32_t t = of.lane[i], part = columns.of[i % lanes::side] * rows.of[i / lanes::side];
            of.lane[i] = std::uint16_t(t - std::min(product(loss_of(t), part), t));
            sum += of.lane[i];
        }
        return take(s, sum);
    }
    bool into(FarSample& s, FarLanes& of) const {
        int sum = 0;
        for (std::uint16_t& lane : of.lane) {
            lane = std::uint16_t(lane - std::min<std::uint32_t>(loss_of(lane), lane));
            sum += lane;
        }
        return take(s, sum);
    }
    bool into(FarSample& s) const {
        const auto t = std::uint32_t(lane_of(s.transmittance));
        return take(s, lanes::count * int(t - std::min(loss_of(t), t)));
    }

  private:
    static std::uint32_t rounded(float v) {
        return std::uint32_t(int(std::min(std::max(0.0f, v), 1.0f) * float(lanes::one) + 0.5f));
    }
    std::uint32_t loss_of(std::uint32_t t) const {
        return std::min<std::uint32_t>((t * relative_ >> 16) + absolute_, lanes::one);
    }
    bool take(FarSample& s, int sum) const {
        const bool closes = sum < lanes::closed;
        const float taken = s.transmittance - (closes ? 0.0f : float(sum) * (1.0f / float(lanes::count * lanes::one)));
        s.r += taken * rgb_.x;
        s.g += taken * rgb_.y;
        s.b += taken * rgb_.z;
        s.transmittance -= taken;
        return closes;
    }
    std::uint32_t relative_, absolute_;
    glm::vec3 rgb_;
};

/// Deposits into a single lane, `part` of which is covered (at most all of it).
inline bool into_lane(FarSample& s, FarLanes& of, int lane, float part, Loss loss, glm::vec3 rgb) {
    const auto before = float(of.lane[lane]);
    const float taken_here =
        std::min((loss.relative * before + loss.absolute * float(lanes::one)) * std::min(part, 1.0f), before);
    const int left = int(before - taken_here + 0.5f);
    of.lane[lane] = std::uint16_t(left);
    float taken = (before - float(left)) * (1.0f / float(lanes::count * lanes::one));
    const bool closes = s.transmittance - taken < closed_transmittance;
    if (closes) taken = s.transmittance;
    s.r += taken * rgb.x;
    s.g += taken * rgb.y;
    s.b += taken * rgb.z;
    s.transmittance -= taken;
    return closes;
}

}  // namespace one_lane_at_a_time

#if defined(__SSE2__)
namespace native_lanes = eight_lanes_at_a_time;
#else
namespace native_lanes = one_lane_at_a_time;
#endif

}  // namespace farfield::detail
