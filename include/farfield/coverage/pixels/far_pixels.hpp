// The far field over coverage masks: the color deposited into each pixel, and the transmittance left for what lies
// behind it (geometry/area_law.hpp).
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

#include "farfield/coverage/pixels/box_filter.hpp"
#include "farfield/coverage/triage_mask.hpp"
#include "farfield/geometry/area_law.hpp"
#include "farfield/geometry/rgba8.hpp"

namespace farfield {

/// Pixels are addressed like masks of samples: 64 * block + subcell. The first frame with a deposit takes the memory.
class FarPixels {
  public:
    /// A lane is two by two samples: things side by side in a pixel are thus not behind each other.
    static constexpr unsigned lane_count = 16;
    using LaneParts = std::array<float, lane_count>;

    /// Begins a frame with this many blocks.
    void begin(std::size_t blocks) {
        block_count_ = blocks;
        if (touched_.size() != blocks) {
            touched_.assign(blocks, no_subcells);
            pixels_.clear();
        } else if (has_any_) {
            std::fill(touched_.begin(), touched_.end(), no_subcells);
        }
        has_any_ = false;
    }

    bool has_any() const { return has_any_; }
    /// The pixels of a block that were deposited into in this frame.
    std::uint64_t touched(std::size_t block) const { return has_any_ ? touched_[block] : no_subcells; }

    /// Deposits something that covers the samples `inside` of a pixel and takes `loss` where it covers; the subset
    /// `seen` is not behind geometry. Returns the part of each lane's transmittance that is left.
    LaneParts deposit(std::size_t at, std::uint64_t inside, std::uint64_t seen, Loss loss, glm::vec3 rgb) {
        if (pixels_.empty()) pixels_.resize(64 * block_count_);
        has_any_ = true;
        Pixel& p = pixels_[at];
        const std::uint64_t bit = std::uint64_t(1) << (at & 63);
        if ((touched_[at / 64] & bit) == 0) {
            touched_[at / 64] |= bit;
            p = {};
        }
        LaneParts parts;
        float taken = 0, left = 0;
        for (unsigned lane = 0; lane < lane_count; ++lane) {
            const auto covered = unsigned(bit_count(inside & samples_of_lane(lane)));
            float& t = p.lanes[lane];
            if (covered != 0) {
                const float part = 0.25f * float(covered);
                const float now = transmitted(t, {part * loss.relative, part * loss.absolute});
                taken += (t - now) * float(bit_count(seen & samples_of_lane(lane))) / float(covered);
                parts[lane] = t > 0 ? now / t : 0;
                t = now;
            } else {
                parts[lane] = 1;
            }
            left += t;
        }
        taken *= 1.0f / lane_count;
        p.rgb += rgb * taken;
        p.alpha += taken;
        if (left < closed_transmittance * lane_count) p.lanes.fill(0);
        return parts;
    }

    bool is_closed(std::size_t at) const {
        return std::all_of(pixels_[at].lanes.begin(), pixels_[at].lanes.end(), [](float t) { return !(t > 0); });
    }

    /// The color c drawn at sample s as it comes through all deposits so far. Rounded down, so that sums stay in range.
    Rgba8 behind(std::size_t at, unsigned s, Rgba8 c) const { return attenuated(c, pixels_[at].lanes[lane_of(s)]); }
    static Rgba8 attenuated(Rgba8 c, float t) {
        return {std::uint8_t(float(c.r) * t), std::uint8_t(float(c.g) * t), std::uint8_t(float(c.b) * t),
                std::uint8_t(float(c.a) * t)};
    }
    static unsigned lane_of(unsigned sample) { return sample / 16 * 4 + sample % 8 / 2; }

    /// Calls f(at, rgb, alpha) for each pixel deposited into: premultiplied, in [0, 1].
    template <class F>
    void for_touched(F&& f) const {
        if (!has_any_) return;
        for (std::size_t block = 0; block < touched_.size(); ++block) {
            for (std::uint64_t left = touched_[block]; left != 0; left &= left - 1) {
                const std::size_t at = 64 * block + std::size_t(std::countr_zero(left));
                f(at, pixels_[at].rgb, pixels_[at].alpha);
            }
        }
    }

  private:
    struct Pixel {
        glm::vec3 rgb{0};
        float alpha = 0;
        LaneParts lanes{1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1};  ///< transmittance, row by row
    };
    static std::uint64_t samples_of_lane(unsigned lane) {
        return std::uint64_t(0x0303) << (lane / 4 * 16 + lane % 4 * 2);
    }

    std::size_t block_count_ = 0;
    bool has_any_ = false;
    std::vector<std::uint64_t> touched_;  ///< by block
    std::vector<Pixel> pixels_;
};

}  // namespace farfield
