// The far field over coverage masks: what was deposited into each pixel, and the transmittance left for what comes
// behind it (geometry/area_law.hpp).
#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

#include "farfield/coverage/triage_mask.hpp"
#include "farfield/geometry/area_law.hpp"
#include "farfield/geometry/rgba8.hpp"

namespace farfield {

/// Pixels are addressed as masks of samples are: 64 * block + subcell. Memory is taken by the first frame that has a
/// deposit.
class FarPixels {
  public:
    /// A new frame of so many blocks.
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
    /// Pixels of a block that were deposited into in this frame.
    std::uint64_t touched(std::size_t block) const { return has_any_ ? touched_[block] : no_subcells; }

    /// Something that covers `part` of a pixel, and takes `loss` of what it covers; of it the part `seen` is not behind
    /// geometry. True: nothing gets through any more.
    bool deposit(std::size_t at, float part, float seen, Loss loss, glm::vec3 rgb) {
        if (pixels_.empty()) pixels_.resize(64 * block_count_);
        has_any_ = true;
        Pixel& p = pixels_[at];
        const std::uint64_t bit = std::uint64_t(1) << (at & 63);
        if ((touched_[at / 64] & bit) == 0) {
            touched_[at / 64] |= bit;
            p = {};
        }
        const float left = transmitted(p.transmittance, {part * loss.relative, part * loss.absolute});
        const float weight = (p.transmittance - left) * seen;
        p.rgb += rgb * weight;
        p.alpha += weight;
        p.transmittance = left < closed_transmittance ? 0 : left;
        return p.transmittance == 0;
    }

    /// What comes through of something drawn behind all deposits so far. Rounded down, so that sums stay in range.
    Rgba8 behind(std::size_t at, Rgba8 c) const {
        const float t = pixels_[at].transmittance;
        return {std::uint8_t(float(c.r) * t), std::uint8_t(float(c.g) * t), std::uint8_t(float(c.b) * t),
                std::uint8_t(float(c.a) * t)};
    }

    /// f(at, rgb, alpha) of each pixel deposited into: premultiplied, in [0, 1].
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
        float transmittance = 1;
    };

    std::size_t block_count_ = 0;
    bool has_any_ = false;
    std::vector<std::uint64_t> touched_;  ///< by block
    std::vector<Pixel> pixels_;
};

}  // namespace farfield
