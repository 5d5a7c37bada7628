// Writes a triangle's samples into a z-buffer.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <cstdint>

#include "farfield/geometry/rgba8.hpp"
#include "farfield/raster/sample_projection.hpp"
#include "farfield/raster/samples/block_fill.hpp"
#include "farfield/raster/samples/sample_buffers.hpp"
#include "farfield/raster/scan_conversion.hpp"

namespace farfield::detail {

/// The nearer sample stays; of two at the same depth the larger color stays, in whatever order they come.
class DepthTestedFill {
  public:
    DepthTestedFill(const SampleProjection& projection, SampleBuffers& buffers, BlockFill fill)
        : projection_(projection), buffers_(buffers), fill_(fill) {}

    SampleBuffers& buffers() const { return buffers_; }

    /// A fill may reject triangles that change nothing. The kernel does that block by block.
    static constexpr bool rejects(const SnappedTriangle&) { return false; }

    /// The triangle must be clockwise. prepare() is called before the first sample that it covers; shade(x, y) then
    /// gives the sample's color; alpha 0 means that it is not covered after all.
    template <class Prepare, class Shade>
    void operator()(const SnappedTriangle& t, std::int64_t doubled_area, Prepare&& prepare, const Shade& shade) const {
        struct Both : TriangleShade {
            Prepare& prepares;
            const Shade& shade;
        };
        const auto prepares = [](TriangleShade& base) {
            auto& both = static_cast<Both&>(base);
            both.prepares();
            if constexpr (!Shade::is_one_color) both.plane = &*both.shade.plane;
        };
        const auto at = [](const TriangleShade& base, int x, int y) {
            return static_cast<const Both&>(base).shade(x, y);
        };
        if constexpr (Shade::is_one_color) {
            Both both{{prepares, at, &shade.color, nullptr, true, true}, prepare, shade};
            fill_(buffers_.blocks(), t, doubled_area, projection_, both);
        } else {
            Both both{{prepares, at, shade.corners, nullptr, false, shade.are_opaque()}, prepare, shade};
            fill_(buffers_.blocks(), t, doubled_area, projection_, both);
        }
    }

  private:
    const SampleProjection& projection_;
    SampleBuffers& buffers_;
    BlockFill fill_;
};

}  // namespace farfield::detail
