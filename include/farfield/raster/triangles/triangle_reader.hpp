// Reads triangles from where the user keeps them, each time they are drawn.
#pragma once

#include "farfield/settings.hpp"

#include <cstdint>

#include "farfield/raster/triangles/triangle_stream.hpp"
#include "farfield/renderer.hpp"

namespace farfield::detail {

/// Keeps memory for some dozens of blocks. Triangles lie in the same lanes of the same blocks as those of a stream that
/// keeps them all, so whoever draws block by block draws the same picture.
class TriangleReader {
  public:
    /// Calls draw(window, first, end) with streams that hold a range of positions, in order: triangles [first, end) of
    /// the window. `index` is the source's stream, which need not keep its triangles.
    template <PrimitiveWithPolygons P, class F>
    void read(const Source<P>& source, const TriangleStream& index, const Range& range, F&& draw) {
        std::uint32_t first = index.first_triangle(range.first) % TriangleBlock::lanes;
        window_.restart(first, index.several_colors());
        const TriangleStream& window = window_;
        for (std::uint32_t at = range.first; at < range.first + range.count; ++at) {
            source.prefetch(at);
            source.polygons(at, [&](const Polygon& polygon) { window_.add(polygon); });
            if (window.size() < batch) continue;
            const std::uint32_t whole_blocks = window.size() - window.size() % TriangleBlock::lanes;
            draw(window, first, whole_blocks);
            window_.drop(whole_blocks);
            first = 0;
        }
        draw(window, first, window.size());
    }

  private:
    static constexpr std::uint32_t batch = 256;

    TriangleStream window_;
};

}  // namespace farfield::detail
