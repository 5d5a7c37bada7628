// The buffers that an image of several depth slices is drawn into, one for each slice: what a nearer slice holds hides
// nothing of a farther one, which the viewer may come to see between both (after G. Schaufler, "Per-Object Image
// Warping with Layered Impostors", Eurographics Workshop on Rendering 1998, who draws the object once for each layer;
// here all are drawn in one go).
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <utility>
#include <vector>

#include "farfield/geometry/area_law.hpp"
#include "farfield/raster/sample_projection.hpp"
#include "farfield/raster/samples/depth_tested_fill.hpp"
#include "farfield/raster/samples/sample_buffers.hpp"
#include "farfield/raster/scan_conversion.hpp"

namespace farfield::detail {

/// Depths that a slice lies between, as q.
struct DepthRange {
    float farthest, nearest;

    bool contains(float q) const { return q >= farthest && q <= nearest; }
};

/// Takes the place of a SampleBuffers where things are deposited. Borrows the buffers; ranges go front to back.
class SlicedBuffers {
  public:
    void clear() { slices_.clear(); }
    void add(SampleBuffers& buffers, const DepthRange& range) { slices_.push_back({&buffers, range}); }
    std::size_t size() const { return slices_.size(); }

    SampleBuffers& buffers(std::size_t i) { return *slices_[i].buffers; }
    const DepthRange& range(std::size_t i) const { return slices_[i].range; }
    /// The slice that holds a depth; of two that overlap the nearer one.
    SampleBuffers& at(float q) {
        std::size_t i = 0;
        while (i + 1 < slices_.size() && q < slices_[i].range.farthest) ++i;
        return *slices_[i].buffers;
    }

    void begin_far() {
        for (const Slice& s : slices_) s.buffers->begin_far();
    }
    template <class Depth>
    void deposit_row(int y, int begin, int end, Depth&& q, const FarSamples::Deposit& deposit) {
        if (begin < end) at(q(begin + (end - begin) / 2)).deposit_row(y, begin, end, q, deposit);
    }
    void deposit_square(float left, float top, float right, float bottom, float q, Loss loss, glm::vec3 rgb) {
        at(q).deposit_square(left, top, right, bottom, q, loss, rgb);
    }
    template <class Color>
    void deposit_in_lane(float x, float y, float area, float q, Loss loss, Color&& rgb) {
        at(q).deposit_in_lane(x, y, area, q, loss, std::forward<Color>(rgb));
    }

  private:
    struct Slice {
        SampleBuffers* buffers;
        DepthRange range;
    };
    std::vector<Slice> slices_;
};

/// Draws a triangle into every slice that it reaches into.
class SlicedFill {
  public:
    SlicedFill(const SampleProjection& projection, SlicedBuffers& slices, BlockFill fill)
        : projection_(projection), slices_(slices), fill_(fill) {}

    SlicedBuffers& buffers() const { return slices_; }
    static constexpr bool rejects(const SnappedTriangle&) { return false; }

    template <class Prepare, class Shade>
    void operator()(const SnappedTriangle& t, std::int64_t doubled_area, Prepare&& prepare, const Shade& shade) const {
        const auto [farthest, nearest] = std::minmax({t.q[0], t.q[1], t.q[2]});
        bool is_prepared = false;
        const auto once = [&] {
            if (!std::exchange(is_prepared, true)) prepare();
        };
        for (std::size_t i = 0; i < slices_.size(); ++i) {
            const DepthRange& range = slices_.range(i);
            if (nearest < range.farthest || farthest > range.nearest) continue;
            DepthTestedFill(projection_, slices_.buffers(i), fill_)(t, doubled_area, once, shade);
        }
    }

  private:
    const SampleProjection& projection_;
    SlicedBuffers& slices_;
    BlockFill fill_;
};

}  // namespace farfield::detail
