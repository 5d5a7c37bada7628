// The reference renderer: scan conversion of triangles and convex polygons into a z-buffer of 1 to 64 samples a pixel,
// with far-field cells and triangles smaller than a sample composited over it front to back.
//
// It is the yardstick of every ratio in this house, so it must be honest competition: eight triangles at a step, those
// without a sample rejected before set-up, only what was drawn cleared and resolved.
#pragma once

#include <bit>
#include <cmath>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "farfield/geometry/light.hpp"
#include "farfield/raster/far_deposits.hpp"
#include "farfield/raster/image.hpp"
#include "farfield/raster/sample_buffers.hpp"
#include "farfield/raster/sample_projection.hpp"
#include "farfield/raster/triangle_painter.hpp"
#include "farfield/raster/triangle_stream.hpp"
#include "farfield/raster/triangle_triage.hpp"
#include "farfield/renderer.hpp"

namespace farfield {

struct ZBufferOptions {
    int samples = 1;                          ///< a pixel, on a regular grid: 1, 4, 9, 16, 25, 36, 49 or 64
    Rgba8 background{0, 0, 0, 0};             ///< premultiplied
    std::optional<DirectionalLight> light{};  ///< in the outermost hierarchy's axes; none: colors as they are
    bool culls_back_faces = false;            ///< for closed surfaces that are counter-clockwise seen from outside
    Simd simd = Simd::automatic;              ///< all give the same picture
    /// Triangles smaller than two samples cover their part of those, by their cell's area law, instead of all or
    /// nothing. Only those of ranges with a law: an exact picture is point sampled whatever is said here.
    bool deposits_small_triangles = true;
};

/// Draws what a Viewer hands over; the picture is image() after the frame. The result does not depend on the order of
/// primitives: of two at the same depth the larger color wins. Primitives with alpha below 255 cover that part of the
/// samples, chosen by a hash of sample and primitive: stable from frame to frame, needing no order (after Wyman and
/// McGuire 2017, "Hashed alpha testing"). Of ranges with a law the small triangles are deposited in the order in which
/// they come; of a coherent surface that leaves no holes, of anything else it covers what its area is worth.
class ZBufferRenderer {
  public:
    static constexpr RendererFacts facts{.keeps_sources = true,
                                         .draws_faces = true,
                                         .draws_splats = true,
                                         .answers_hidden = true,
                                         .deposits_primitives = true};

    /// Throws std::invalid_argument for a number of samples that is not a square of 1 to 8.
    explicit ZBufferRenderer(const ZBufferOptions& options = {}) : options_(options) {
        while (side_ * side_ < options.samples) ++side_;
        if (options.samples < 1 || side_ > 8 || side_ * side_ != options.samples) {
            throw std::invalid_argument(
                "farfield::ZBufferRenderer: samples must be 1, 4, 9, 16, 25, 36, 49 or 64, not " +
                std::to_string(options.samples));
        }
        triage_ = triage_function<false>(options.simd);
        triage_small_ = triage_function<true>(options.simd);
    }

    const Image& image() const { return image_; }

    template <PrimitiveWithPolygons P>
    std::uint32_t page_in(const Source<P>& source) {
        for (std::size_t i = 0; i < streams_.size(); ++i) {
            if (!streams_[i]) return streams_[i] = std::make_unique<TriangleStream>(source), std::uint32_t(i);
        }
        streams_.push_back(std::make_unique<TriangleStream>(source));
        return std::uint32_t(streams_.size() - 1);
    }
    void page_out(std::uint32_t id) { streams_[id].reset(); }

    /// Throws std::invalid_argument for images of no or too many samples: 16,000 on a side.
    void begin_frame(const LocalView& view) {
        const double limit = SampleProjection::guard_band;
        if (view.width < 1 || view.height < 1 || double(view.width) * side_ > limit ||
            double(view.height) * side_ > limit) {
            throw std::invalid_argument("farfield::ZBufferRenderer: an image must have 1 to 16000 samples on a side");
        }
        to_ = SampleProjection(view, side_);
        buffers_.begin(to_, side_, options_.background);
        if (options_.light) {
            const glm::vec3 l = options_.light->towards;
            light_in_view_ = {glm::dot(l, view.right), glm::dot(l, view.up), glm::dot(l, view.forward)};
        }
    }
    void set_view(const LocalView& view) {
        to_ = SampleProjection(view, side_);
        if (options_.light) {
            light_ = *options_.light;
            light_.towards =
                view.right * light_in_view_.x + view.up * light_in_view_.y + view.forward * light_in_view_.z;
        }
    }
    void end_frame() { buffers_.resolve(image_); }

    template <class P>
    void draw(const Source<P>& source, std::span<const Range> ranges) {
        const TriangleStream& stream = *streams_[source.id];
        for (const Range& r : ranges) {
            const std::uint32_t first = stream.first_triangle(r.first), end = stream.first_triangle(r.first + r.count);
            if (r.law && options_.deposits_small_triangles) {
                draw<true>(stream, first, end, *r.law);
            } else {
                draw<false>(stream, first, end, AreaLaw::coherent);
            }
        }
    }

    void draw(std::span<const Face> faces) {
        buffers_.begin_far();
        FarDeposits deposits(to_, buffers_);
        for (const Face& face : faces) deposits.add(face);
    }

    void draw(std::span<const Splat> splats) {
        buffers_.begin_far();
        FarDeposits deposits(to_, buffers_);
        for (const Splat& splat : splats) deposits.add(splat);
    }
    bool deposits_primitives() const { return options_.deposits_small_triangles; }
    /// Two samples: a deposit then touches at most three by three.
    float largest_splat_px() const { return 2.0f / float(side_); }

    /// Asked in front-to-back order. Geometry drawn before hides what lies behind all of it, and that exactly; where
    /// deposits closed a sample, contents of a loose cell that reach in front of a cell already drawn may be lost
    /// with it, by less than a cell. Before the first deposit of a frame, a stand-in's or a triangle's, nothing is
    /// hidden: an exact picture takes every primitive in the frustum.
    bool hidden(const Cell& cell, CellId) {
        if (!buffers_.has_far()) return false;
        const glm::vec3 p = to_.project(cell.bounds_center);
        const float radius = std::sqrt(glm::dot(cell.bounds_half, cell.bounds_half));
        // A point of the sphere is off by at most radius (focal + |x|) / (depth - radius) from its center's image.
        const float nearest = to_.is_perspective ? p.z - radius : 1.0f;
        if (!(nearest > 0)) return false;
        const float inverse = to_.inverse_w(p.z) * (1.0f / 256), x = p.x * inverse, y = p.y * inverse;
        const float skew = to_.is_perspective ? 1.0f : 0.0f, reach = radius / nearest;
        const float rx = reach * (to_.focal + skew * std::abs(x)), ry = reach * (to_.focal + skew * std::abs(y));
        if (!(rx < 64 && ry < 64)) return false;  // large ones are seldom hidden and their children are asked again
        const float cx = x + to_.offset_x * (1.0f / 256), cy = y + to_.offset_y * (1.0f / 256);
        // Nearer than any corner, roundings included: vertices are snapped, hence the sample added around.
        const float front = to_.is_perspective ? nearest : p.z - radius;
        const float rounding = (std::abs(p.z) + radius) * 0x1p-16f;
        const float q = to_.q(front - rounding, to_.inverse_w(std::max(front - rounding, 0.5f * nearest)));
        return buffers_.all_settled(int(std::floor(cx - rx)) - 1, int(std::floor(cy - ry)) - 1,
                                    int(std::floor(cx + rx)) + 1, int(std::floor(cy + ry)) + 1, q);
    }

  private:
    /// Positions of triangles [first, end). With `deposits`, the small ones of a cell of this law.
    template <bool deposits>
    void draw(const TriangleStream& stream, std::uint32_t first, std::uint32_t end, AreaLaw law) {
        if (first >= end) return;
        constexpr std::uint32_t lanes = TriangleBlock::lanes;
        TrianglePainter painter(stream, to_, options_.light ? &light_ : nullptr, options_.culls_back_faces, buffers_);
        const Loss opaque = loss_of_opacity(1, law);
        TriagedBlock triaged;
        for (std::uint32_t block = first / lanes; block <= (end - 1) / lanes; ++block) {
            const TriageMasks masks = (deposits ? triage_small_ : triage_)(stream.blocks()[block], to_, triaged);
            unsigned in_range = ~0u;
            if (block * lanes < first) in_range &= ~0u << (first - block * lanes);
            if ((block + 1) * lanes > end) in_range &= (1u << (end - block * lanes)) - 1;
            unsigned small = 0;
            if constexpr (deposits) {
                small = masks.small & in_range;
                if (options_.culls_back_faces) small &= masks.front;
                if (small != 0) buffers_.begin_far();
                for (unsigned left = small; left != 0; left &= left - 1) {
                    const auto lane = unsigned(std::countr_zero(left));
                    painter.deposit(block * lanes + lane, triaged, lane, (masks.front >> lane & 1) != 0, opaque);
                }
                // Squares do not tile a surface as its triangles do, and its larger triangles are no deposits at all.
                // So that nothing shows through, the samples that its small ones hold are drawn as well, behind.
                if (law != AreaLaw::coherent) in_range &= ~masks.small;
            }
            unsigned wanted = (masks.draw | masks.clip) & in_range;
            for (; wanted != 0; wanted &= wanted - 1) {
                const auto lane = unsigned(std::countr_zero(wanted));
                const std::uint32_t triangle = block * lanes + lane;
                if (masks.clip >> lane & 1) {
                    painter.draw_clipped(triangle);
                } else if (small >> lane & 1) {
                    painter.draw_behind(triangle, triaged, lane);
                } else {
                    painter.draw(triangle, triaged, lane);
                }
            }
        }
    }

    ZBufferOptions options_;
    int side_ = 1;
    TriageFunction triage_, triage_small_;
    SampleProjection to_;
    SampleBuffers buffers_;
    DirectionalLight light_;
    glm::vec3 light_in_view_{0};
    std::vector<std::unique_ptr<TriangleStream>> streams_;
    Image image_;
};

}  // namespace farfield
