// Goes through runs of triangles, a block at a time.
#pragma once

#include "farfield/settings.hpp"

#include <bit>
#include <cstdint>

#include "farfield/raster/triangles/triangle_stream.hpp"
#include "farfield/raster/triangles/triangle_triage.hpp"

namespace farfield::detail {

/// Calls f(block, masks, triaged, in_range) for each block that holds some of the triangles [first, end); `in_range`
/// marks their lanes.
template <class F>
void for_triaged_blocks(const TriangleStream& stream, std::uint32_t first, std::uint32_t end,
                        const SampleProjection& projection, TriageFunction triage, F&& f) {
    if (first >= end) return;
    constexpr std::uint32_t lanes = TriangleBlock::lanes;
    TriagedBlock triaged;
    for (std::uint32_t block = first / lanes; block <= (end - 1) / lanes; ++block) {
        const TriageMasks masks = triage(stream.blocks()[block], projection, triaged);
        unsigned in_range = ~0u;
        if (block * lanes < first) in_range &= ~0u << (first - block * lanes);
        if ((block + 1) * lanes > end) in_range &= (1u << (end - block * lanes)) - 1;
        f(block, masks, triaged, in_range);
    }
}

/// Draws those of the triangles [first, end) that may hold samples, in their order.
template <class Painter>
void draw_triangles(const TriangleStream& stream, std::uint32_t first, std::uint32_t end,
                    const SampleProjection& projection, TriageFunction triage, Painter& painter) {
    for_triaged_blocks(
        stream, first, end, projection, triage,
        [&](std::uint32_t block, const TriageMasks& masks, const TriagedBlock& triaged, unsigned in_range) {
            for (unsigned left = (masks.draw | masks.clip) & in_range; left != 0; left &= left - 1) {
                const auto lane = unsigned(std::countr_zero(left));
                const std::uint32_t triangle = block * TriangleBlock::lanes + lane;
                if (masks.clip >> lane & 1) {
                    painter.draw_clipped(triangle);
                } else {
                    painter.draw(triangle, triaged, lane);
                }
            }
        });
}

}  // namespace farfield::detail
