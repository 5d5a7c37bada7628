// Writes a triangle's samples into a z-buffer.
#pragma once

#include "farfield/settings.hpp"

#include <bit>
#include <cstdint>

#include "farfield/geometry/rgba8.hpp"
#include "farfield/raster/sample_projection.hpp"
#include "farfield/raster/samples/sample_buffers.hpp"
#include "farfield/raster/scan_conversion.hpp"
#include "farfield/raster/triangles/sample_rows.hpp"

namespace farfield::detail {

/// The nearer sample stays; of two at the same depth the larger color stays, in whatever order they come.
class DepthTestedFill {
  public:
    DepthTestedFill(const SampleProjection& projection, SampleBuffers& buffers, const SampleRows& rows)
        : projection_(projection), buffers_(buffers), rows_(rows) {}

    SampleBuffers& buffers() const { return buffers_; }

    /// A fill may reject triangles that change nothing.
    static constexpr bool rejects(const SnappedTriangle&) { return false; }

    /// The triangle must be clockwise. prepare() is called before the first sample that it covers; shade(x, y) then
    /// gives the sample's color; alpha 0 means that it is not covered after all.
    template <class Prepare, class Shade>
    void operator()(const SnappedTriangle& t, std::int64_t doubled_area, Prepare&& prepare, const Shade& shade) const {
        DepthPlane plane;
        bool prepared = false;
        scan_convert(t, projection_, [&](int y, int begin, int end) {
            if (!prepared) {
                prepared = true;
                plane = DepthPlane(t, doubled_area);
                prepare();
            }
            float* depth = buffers_.depth_row(y);
            Rgba8* color = buffers_.color_row(y);
            const float row = plane.row(y);
            buffers_.near_drawn(begin, y, end, y + 1);
            if (end - begin >= SampleRows::shortest && rows_.one_color != nullptr) {
                if constexpr (Shade::is_one_color) {
                    return rows_.one_color(depth, color, begin, end, DepthOfRow(t, plane, y), shade(begin, y));
                } else if (shade.are_opaque()) {
                    if (rows_.several_colors(depth, color, begin, end, DepthOfRow(t, plane, y),
                                             ColorsOfRow(*shade.plane, shade.corners, y))) {
                        return;
                    }
                }
            }
            for (int x = begin; x < end; ++x) {
                const float q = plane.at(row, x);
                if (q < depth[x]) continue;
                Rgba8 c = shade(x, y);
                if (c.a == 0) continue;
                c.a = 255;
                if (q == depth[x] && std::bit_cast<std::uint32_t>(c) <= std::bit_cast<std::uint32_t>(color[x]))
                    continue;
                depth[x] = q;
                color[x] = c;
            }
        });
    }

  private:
    const SampleProjection& projection_;
    SampleBuffers& buffers_;
    const SampleRows& rows_;
};

}  // namespace farfield::detail
