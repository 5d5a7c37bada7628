// Tiles polygons hierarchically: Warnock subdivision driven by masks (Greene 1996, sections 3.1, 4.3 and listing 1),
// with lazy z-buffering on top (6.1).
//
// The same source is compiled for one, four, eight and sixteen lanes; the widest that the processor has is chosen at
// run time. All give the same masks, and so the same picture. Its parts are listed in coverage_tiler.inl.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <type_traits>
#include <utility>

#include "farfield/coverage/a_buffer.hpp"
#include "farfield/coverage/coverage_pyramid.hpp"
#include "farfield/coverage/coverage_work.hpp"
#include "farfield/coverage/edge_mask_table.hpp"
#include "farfield/coverage/jitter.hpp"
#include "farfield/coverage/pixels/mask_samples.hpp"
#include "farfield/coverage/polygons/silhouette.hpp"
#include "farfield/coverage/polygons/surface.hpp"
#include "farfield/coverage/triage_mask.hpp"
#include "farfield/simd.hpp"

namespace farfield {

/// The order in which polygons come.
enum class CoverageOrder : std::uint8_t {
    strict,  ///< front to back: what is covered stays as it is
    lazy,    ///< any; nearly front to back costs little more than strict
};

/// The source of edges' masks.
enum class MaskSource : std::uint8_t {
    exact,     ///< integer edge functions, many samples at a step
    table,     ///< the paper's table of quantized edges (edge_mask_table.hpp): no faster, and off by some samples
    jittered,  ///< exact, with samples at random in their squares (jitter.hpp); depth is that of the centers
};

/// The parts of a tiler. Derive from one of these and hide the members that are to differ.
struct LazyCoverage {
    static constexpr CoverageOrder order = CoverageOrder::lazy;
    static constexpr MaskSource masks = MaskSource::exact;
    static constexpr std::size_t jitter_patterns = 16;
    using samples = PixelSamples<BoxFilter>;  ///< or another filter, or SinglePixels: mask_samples.hpp
    using work = CoverageWork;                ///< or CoverageWorkImage
};
struct StrictCoverage : LazyCoverage {
    static constexpr CoverageOrder order = CoverageOrder::strict;
};

}  // namespace farfield

namespace farfield::detail {

/// The buffers that polygons are tiled into.
template <class Traits>
struct CoverageTarget {
    using samples_type = typename Traits::samples;
    static constexpr bool is_lazy = Traits::order == CoverageOrder::lazy;
    static constexpr MaskSource masks = Traits::masks;
    /// How far from its regular center a sample may be, in 1/256 sample.
    static constexpr int reach_of_samples = masks == MaskSource::jittered ? 128 : 0;
    struct Nothing {
        void begin(const CoveragePyramid&) {}
    };

    CoveragePyramid pyramid;
    samples_type samples;
    std::conditional_t<is_lazy, ABuffer, Nothing> fragments;
    typename Traits::work work;
    JitterPatterns patterns{masks == MaskSource::jittered ? Traits::jitter_patterns : 1};
    int first_x = 0, first_y = 0;  ///< the first sample, relative to the center sample
    int left_px = 0, top_px = 0;   ///< where a tile lies in the whole picture

    void begin(int width_px, int height_px, int first_sample_x, int first_sample_y) {
        pyramid.begin(width_px * samples_type::samples_a_side, height_px * samples_type::samples_a_side);
        samples.begin(width_px, height_px);
        fragments.begin(pyramid);
        work.begin(pyramid);
        first_x = first_sample_x;
        first_y = first_sample_y;
    }

    MaskBlock block_at(int x, int y) const {
        return {pyramid.index(1, x, y), x, y, 64 * x + first_x, 64 * y + first_y};
    }

    /// Calls f(block) for the blocks in a cell.
    template <class F>
    FARFIELD_INLINE void for_blocks(int level, int x, int y, F&& f) const {
        const int shift = 3 * (level - 1);
        const int end_x = std::min((x + 1) << shift, pyramid.columns(1));
        const int end_y = std::min((y + 1) << shift, pyramid.rows(1));
        for (int by = y << shift; by < end_y; ++by) {
            for (int bx = x << shift; bx < end_x; ++bx) f(block_at(bx, by));
        }
    }

    /// Writes the picture, after all samples have come.
    void resolve(Image& image) {
        if constexpr (is_lazy) show(pyramid.top_level(), 0, 0);
        samples.resolve(image);
    }

  private:
    /// Passes what a cell shows to the samples.
    void show(int level, int x, int y) requires(is_lazy) {
        const std::size_t at = pyramid.index(level, x, y);
        const ABuffer::Cell& cell = fragments.cell(at);
        if (level == 1) return show_block(block_at(x, y));
        for (std::uint32_t f = cell.list; f != ABuffer::none; f = fragments.fragment(f).next) {
            const Surface& surface = shown(fragments.fragment(f).surface);
            for (std::uint64_t left = fragments.fragment(f).bits; left != 0; left &= left - 1) {
                const int k = std::countr_zero(left);
                for_blocks(level - 1, 8 * x + k % 8, 8 * y + k / 8, [&](const MaskBlock& block) {
                    samples.cover_block(block, pyramid.inside(block.index), surface);
                });
            }
        }
        for (std::uint64_t left = pyramid.inside(at) & ~cell.whole; left != 0; left &= left - 1) {
            const int k = std::countr_zero(left);
            show(level - 1, 8 * x + k % 8, 8 * y + k / 8);
        }
    }
    void show_block(const MaskBlock& block) requires(is_lazy) {
        const ABuffer::Cell& cell = fragments.cell(block.index);
        const std::uint64_t inside = pyramid.inside(block.index);
        if (cell.list != ABuffer::none && fragments.fragment(cell.list).bits == inside) {
            return samples.cover_block(block, inside, shown(fragments.fragment(cell.list).surface));
        }
        samples.open_block(block);
        for (std::uint32_t f = cell.list; f != ABuffer::none; f = fragments.fragment(f).next) {
            samples.cover_masks(block, fragments.fragment(f).bits, shown(fragments.fragment(f).surface));
        }
        for (std::uint64_t left = inside & ~cell.whole; left != 0; left &= left - 1) {
            const auto k = unsigned(std::countr_zero(left));
            const std::size_t at = 64 * block.index + k;
            if ((cell.deep >> k & 1) != 0) {
                samples.replace(block, k, fragments.deep(at));
                continue;
            }
            show_mask(block, k, fragments.list(at));
        }
    }
    void show_mask(const MaskBlock& block, unsigned k, std::uint32_t list) requires(is_lazy) {
        if constexpr (!samples_type::shades_samples) {
            samples.add_all(block, k, [&](auto&& add) {
                for (std::uint32_t f = list; f != ABuffer::none; f = fragments.fragment(f).next) {
                    add(fragments.fragment(f).bits, shown_color(block, k, fragments.fragment(f).surface));
                }
            });
            return;
        }
        bool is_first = true;
        for (std::uint32_t f = list; f != ABuffer::none; f = fragments.fragment(f).next) {
            const std::uint64_t bits = fragments.fragment(f).bits;
            samples.add(block, k, bits, bit_count(bits), shown(fragments.fragment(f).surface), is_first);
            is_first = false;
        }
    }
    FARFIELD_INLINE Rgba8 shown_color(const MaskBlock& block, unsigned k, std::uint32_t surface) requires(is_lazy) {
        Surface* const details = fragments.details(surface);
        if (details == nullptr || details->is_flat) return fragments.color(surface);
        details->need_gradient();
        return details->seen_color_of_pixel(block.sample_x_of(k), block.sample_y_of(k));
    }
    /// The surface as it is to be shown.
    const Surface& shown(std::uint32_t surface) requires(is_lazy) {
        Surface* const details = fragments.details(surface);
        if (details != nullptr && !details->is_flat) {
            details->need_gradient();
            return *details;
        }
        flat_.kind = SurfaceKind::background;  // the color as it is
        flat_.colors[0] = fragments.color(surface);
        return flat_;
    }

    Surface flat_{};
};

#define FARFIELD_LANES 1
namespace one_lane {
#include "farfield/coverage/tiler/coverage_tiler.inl"
}  // namespace one_lane
#undef FARFIELD_LANES

#if defined(__x86_64__)
#define FARFIELD_LANES 4
namespace four_lanes {
#include "farfield/coverage/tiler/coverage_tiler.inl"
}  // namespace four_lanes
#undef FARFIELD_LANES

FARFIELD_BEGIN_EIGHT_LANES
#define FARFIELD_LANES 8
namespace eight_lanes {
#include "farfield/coverage/tiler/coverage_tiler.inl"
}  // namespace eight_lanes
#undef FARFIELD_LANES
FARFIELD_END_LANES

FARFIELD_BEGIN_SIXTEEN_LANES
#define FARFIELD_LANES 16
namespace sixteen_lanes {
#include "farfield/coverage/tiler/coverage_tiler.inl"
}  // namespace sixteen_lanes
#undef FARFIELD_LANES
FARFIELD_END_LANES
#endif

/// The tiler for one target, as functions compiled for one instruction set.
template <class Target>
struct CoverageTiler {
    /// Tiles the visible part of a polygon, finding its gradient if needed. Returns false if nothing is visible.
    bool (*tile)(Target&, TilePolygon&);
    /// Whether anything in the box might be seen: "stopping if a visible sample is found" (section 5.2). The silhouette
    /// is grown by `grown_by` / 256 samples.
    bool (*is_seen)(Target&, const Silhouette&, int grown_by);

    explicit CoverageTiler(Simd simd);
};

/// It is not inline, so that `extern template struct CoverageTiler<...>` keeps a program from compiling four tilers in
/// every file that draws with masks.
template <class Target>
CoverageTiler<Target>::CoverageTiler(Simd simd) : tile(&one_lane::tile<Target>), is_seen(&one_lane::is_seen<Target>) {
#if defined(__x86_64__)
    const int lanes = lanes_for(simd);
    if (lanes >= 4) tile = &four_lanes::tile<Target>, is_seen = &four_lanes::is_seen<Target>;
    if (lanes >= 8) tile = &eight_lanes::tile<Target>, is_seen = &eight_lanes::is_seen<Target>;
    if (lanes >= 16) tile = &sixteen_lanes::tile<Target>, is_seen = &sixteen_lanes::is_seen<Target>;
#else
    static_cast<void>(simd);
#endif
}

}  // namespace farfield::detail
