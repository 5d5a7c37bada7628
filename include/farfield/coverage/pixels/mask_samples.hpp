// The destinations of the tiler's masks: filters, for images with 64 samples a pixel, or the pixels themselves.
#pragma once

#include "farfield/settings.hpp"

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "farfield/coverage/a_buffer.hpp"
#include "farfield/coverage/pixels/box_filter.hpp"
#include "farfield/coverage/pixels/far_pixels.hpp"
#include "farfield/coverage/pixels/point_samples.hpp"
#include "farfield/coverage/polygons/surface.hpp"
#include "farfield/simd.hpp"

namespace farfield {

/// A block of 8 x 8 masks of samples: its number and place in the pyramid's level 1, and its first sample, relative to
/// the center sample.
struct MaskBlock {
    std::size_t index = 0;
    int x = 0, y = 0;
    int sample_x = 0, sample_y = 0;

    int sample_x_of(unsigned k) const { return sample_x + 8 * int(k % 8); }
    int sample_y_of(unsigned k) const { return sample_y + 8 * int(k / 8); }
};

/// Here a mask is a pixel's 64 samples.
template <class Filter>
class PixelSamples {
  public:
    static constexpr int samples_a_side = 8;
    static constexpr bool shades_samples = false;  ///< one color a surface and pixel
    /// Pixels beyond a pixel that its filter reaches.
    static constexpr int reach_px = [] {
        if constexpr (requires { Filter::reach_px; }) return int(Filter::reach_px);
        return 0;
    }();

    static constexpr bool takes_deposits = requires(Filter f) { f.add_sum(0, glm::vec4()); };

    void begin(int width_px, int height_px) {
        filter_.begin(width_px, height_px);
        if constexpr (takes_deposits) far_.begin(std::size_t((width_px + 7) / 8) * std::size_t((height_px + 7) / 8));
    }

    /// Call this before the masks of a block are written one by one.
    FARFIELD_INLINE void open_block(const MaskBlock& block) {
        if constexpr (has_blocks) filter_.open_block(block.index);
    }
    /// Adds all samples of a block that has none yet; `masks` are those inside the image. `Stores`: how words are
    /// stored, see PortableStores.
    template <class Stores = detail::PortableStores>
    FARFIELD_INLINE void cover_block(const MaskBlock& block, std::uint64_t masks, const Surface& surface) {
        if (!surface.is_flat) {
            open_block(block);
            cover_masks<Stores>(block, masks, surface);
        } else if constexpr (has_blocks) {
            filter_.fill_block(block.index, surface.seen_color());
        } else {
            filter_.fill(8 * block.x, 8 * block.y, 8, 8, surface.seen_color());
        }
    }
    /// Adds all samples of some masks.
    template <class Stores = detail::PortableStores>
    FARFIELD_INLINE void cover_masks(const MaskBlock& block, std::uint64_t masks, const Surface& surface) {
        if (surface.is_flat) {
            if constexpr (has_blocks) {
                filter_.template fill_pixels<Stores>(block.index, masks, surface.seen_color());
            } else {
                filter_.fill_pixels(8 * block.x, 8 * block.y, masks, surface.seen_color());
            }
            return;
        }
        for (unsigned row = 0; masks != 0; masks >>= 8, row += 8) {
            if ((masks & 255) == 0) continue;
            const auto colors = surface.seen_colors_of_pixels(block.sample_x, block.sample_y_of(row));
            if constexpr (has_blocks) {
                filter_.fill_row(64 * block.index + row, unsigned(masks & 255), colors);
                continue;
            }
            for (auto left = unsigned(masks & 255); left != 0; left &= left - 1) {
                const auto i = unsigned(std::countr_zero(left));
                add_color(block, row + i, all_subcells, 64, colors[i], true);
            }
        }
    }
    /// Adds `count` samples of mask k; `is_first`: the mask has none yet in this frame.
    template <class Stores = detail::PortableStores>
    FARFIELD_INLINE void add(const MaskBlock& block, unsigned k, std::uint64_t samples, int count,
                             const Surface& surface, bool is_first) {
        add_color(block, k, samples, count, color_of(block, k, surface), is_first);
    }
    /// Adds all samples of mask k of an open block, as f(add) tells: add(samples, color).
    template <class F>
    FARFIELD_INLINE void add_all(const MaskBlock& block, unsigned k, F&& f) {
        if constexpr (has_blocks) {
            std::uint64_t sum = 0;
            f([&](std::uint64_t samples, Rgba8 color) {
                sum += Filter::spread(color) * std::uint64_t(bit_count(samples));
            });
            filter_.set_sum(64 * block.index + k, sum);
        } else {
            bool is_first = true;
            f([&](std::uint64_t samples, Rgba8 color) {
                add_color(block, k, samples, bit_count(samples), color, std::exchange(is_first, false));
            });
        }
    }
    /// Deposits a surface of the far field over the samples `inside` of mask k, of which the subset `seen` is not
    /// behind geometry. Returns the part of each lane's transmittance that is left.
    FarPixels::LaneParts deposit(const MaskBlock& block, unsigned k, std::uint64_t inside, std::uint64_t seen,
                                 const Surface& surface) {
        return far_.deposit(64 * block.index + k, inside, seen, surface.loss, surface.far_rgb);
    }
    /// The masks of a block that something was deposited into.
    std::uint64_t deposited(const MaskBlock& block) const { return far_.touched(block.index); }
    bool is_closed(const MaskBlock& block, unsigned k) const { return far_.is_closed(64 * block.index + k); }
    /// Attenuates the colors of eight samples from s on by the deposits so far.
    void put_behind_deposits(const MaskBlock& block, unsigned k, unsigned s, std::array<Rgba8, 8>& colors) const {
        if ((deposited(block) >> k & 1) == 0) return;
        for (unsigned i = 0; i < 8; ++i) colors[i] = far_.behind(64 * block.index + k, s + i, colors[i]);
    }
    FARFIELD_INLINE static Rgba8 color_of(const MaskBlock& block, unsigned k, const Surface& surface) {
        return surface.is_flat ? surface.seen_color()
                               : surface.seen_color_of_pixel(block.sample_x_of(k), block.sample_y_of(k));
    }
    /// Adds all samples of mask k.
    void replace(const MaskBlock& block, unsigned k, const DeepMask& deep) {
        add_all(block, k, [&](auto&& add_one) {
            for (unsigned s = 0; s < 64; ++s) add_one(std::uint64_t(1) << s, deep.color[s]);
        });
    }

    void resolve(Image& image) {
        if constexpr (takes_deposits) {
            far_.for_touched([&](std::size_t at, glm::vec3 rgb, float alpha) {
                filter_.add_sum(at, glm::vec4(rgb, alpha) * (255.0f * 64));
            });
        }
        filter_.resolve(image);
    }

  private:
    static constexpr bool has_blocks = requires(Filter f) { f.open_block(0); };

    FARFIELD_INLINE void add_color(const MaskBlock& block, unsigned k, std::uint64_t samples, int count, Rgba8 color,
                                   bool is_first) {
        if constexpr (has_blocks) {
            filter_.add_at(64 * block.index + k, count, color, is_first);
        } else {
            filter_.add(8 * block.x + int(k % 8), 8 * block.y + int(k / 8), samples, color, is_first);
        }
    }

    Filter filter_;
    FarPixels far_;
};

/// Here a sample is a pixel, and a mask is 8 x 8 of them.
class SinglePixels {
  public:
    static constexpr int samples_a_side = 1;
    static constexpr bool shades_samples = true;
    static constexpr int reach_px = 0;
    static constexpr bool takes_deposits = false;

    void begin(int width_px, int height_px) { pixels_.begin(width_px, height_px); }

    void open_block(const MaskBlock&) {}
    template <class Stores = detail::PortableStores>
    FARFIELD_INLINE void cover_block(const MaskBlock& block, std::uint64_t masks, const Surface& surface) {
        if (!surface.is_flat) return cover_masks<Stores>(block, masks, surface);
        pixels_.fill(64 * block.x, 64 * block.y, 64, 64, surface.seen_color());
    }
    template <class Stores = detail::PortableStores>
    FARFIELD_INLINE void cover_masks(const MaskBlock& block, std::uint64_t masks, const Surface& surface) {
        for (; masks != 0; masks &= masks - 1) {
            add<Stores>(block, unsigned(std::countr_zero(masks)), all_subcells, 64, surface, true);
        }
    }
    template <class Stores = detail::PortableStores>
    FARFIELD_INLINE void add(const MaskBlock& block, unsigned k, std::uint64_t samples, int, const Surface& surface,
                             bool) {
        const std::size_t at = place(block, k);
        if (surface.is_flat) return pixels_.template add<Stores>(at, samples, surface.seen_color());
        for (; samples != 0; samples &= samples - 1) {
            const auto s = std::countr_zero(samples);
            pixels_.add(at, std::uint64_t(1) << s,
                        surface.seen_color_at(block.sample_x_of(k) + s % 8, block.sample_y_of(k) + s / 8));
        }
    }
    FarPixels::LaneParts deposit(const MaskBlock&, unsigned, std::uint64_t, std::uint64_t, const Surface&) {
        return {};
    }
    std::uint64_t deposited(const MaskBlock&) const { return no_subcells; }
    bool is_closed(const MaskBlock&, unsigned) const { return false; }
    void put_behind_deposits(const MaskBlock&, unsigned, unsigned, std::array<Rgba8, 8>&) const {}
    void replace(const MaskBlock& block, unsigned k, const DeepMask& deep) {
        for (unsigned s = 0; s < 64; ++s) {
            pixels_.add(place(block, k), std::uint64_t(1) << s, deep.color[s]);
        }
    }

    void resolve(Image& image) { pixels_.resolve(image); }

  private:
    std::size_t place(const MaskBlock& block, unsigned k) const {
        return pixels_.block_of(64 * block.x + 8 * int(k % 8), 64 * block.y + 8 * int(k / 8));
    }

    PointSamples pixels_;
};

}  // namespace farfield
