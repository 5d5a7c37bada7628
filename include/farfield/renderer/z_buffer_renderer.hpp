// The reference renderer: scan conversion of triangles and convex polygons into a z-buffer of 1 to 64 samples a pixel,
// with far-field cells and triangles smaller than a sample composited over it front to back.
//
// It is the yardstick of every ratio in this house, so it must be honest competition: it takes eight triangles at a
// step, rejects those without a sample before setup, and clears and resolves only what was drawn.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/common.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <memory>
#include <span>

#include "farfield/geometry/length.hpp"
#include "farfield/image.hpp"
#include "farfield/raster/render_options.hpp"
#include "farfield/raster/sample_projection.hpp"
#include "farfield/raster/samples/depth_tested_fill.hpp"
#include "farfield/raster/samples/sample_buffers.hpp"
#include "farfield/raster/samples/sliced_buffers.hpp"
#include "farfield/raster/samples/z_buffer_canvas.hpp"
#include "farfield/renderer.hpp"

namespace farfield {

/// Draws for a Viewer; the picture is image() after the frame. It does not depend on the order of primitives: of two at
/// the same depth the larger color wins. Primitives with alpha below 255 cover that part of the samples, chosen by a
/// hash of sample and primitive: stable from frame to frame, needing no order (after Wyman and McGuire 2017, "Hashed
/// alpha testing"). Ranges with a law have their small triangles deposited in the order in which they come: that leaves
/// no holes in a coherent surface, and covers according to area in anything else.
class ZBufferRenderer {
  public:
    static constexpr RendererFacts facts{.keeps_sources = true,
                                         .draws_changing_sources = true,
                                         .shares_sources = true,
                                         .tells_lifetime = true,
                                         .tells_light = true,
                                         .draws_faces = true,
                                         .draws_splats = true,
                                         .answers_hidden = true,
                                         .deposits_primitives = true,
                                         .keeps_images = true,
                                         .slices_images = true};

    /// Throws std::invalid_argument for a number of samples that is not a square of 1 to 8.
    explicit ZBufferRenderer(const ZBufferOptions& options = {})
        : canvas_(options, "ZBufferRenderer"), fill_(detail::block_fill(options.simd)) {}

    const Image& image() const { return canvas_.image(); }
    const std::optional<DirectionalLight>& light() const { return canvas_.options().light; }

    template <PrimitiveWithPolygons P>
    std::uint32_t upload(const Source<P>& source) {
        return canvas_.upload(source);
    }
    std::uint32_t share(const ZBufferRenderer& other, std::uint32_t id) { return canvas_.share(other.canvas_, id); }
    void release(std::uint32_t id) { canvas_.streams().release(id); }
    /// The memory of all that is uploaded: once, however many viewers and renderers draw it.
    std::size_t uploaded_bytes() const { return canvas_.streams().bytes(); }
    std::weak_ptr<const void> lifetime() const { return canvas_.streams().lifetime(); }

    /// Throws std::invalid_argument for images of no samples or more than 16,000 on a side.
    void begin_frame(const LocalView& view) { canvas_.begin_frame(view); }
    void set_view(const LocalView& view) { canvas_.set_view(view); }
    void end_frame() { canvas_.end_frame(); }

    template <class P>
    void draw(const Source<P>& source, std::span<const Range> ranges) {
        if (canvas_.is_sliced()) {
            canvas_.draw(source, ranges, detail::SlicedFill(canvas_.projection(), canvas_.slices(), fill_));
        } else {
            canvas_.draw(source, ranges, detail::DepthTestedFill(canvas_.projection(), canvas_.buffers(), fill_));
        }
    }
    void draw(std::span<const Face> faces) { canvas_.draw(faces); }
    void draw(std::span<const Splat> splats) { canvas_.draw(splats); }

    void begin_image(const LocalView& view, float quad_depth, int samples) {
        canvas_.begin_image(view, quad_depth, samples);
    }
    void begin_image(const LocalView& view, std::span<const ImageSlice> slices, int samples) {
        canvas_.begin_image(view, slices, samples);
    }
    std::uint32_t end_image() { return canvas_.end_image(); }
    /// For renderers that shade pixels and not primitives: shade(Image&) may change colors, premultiplied, of pixels
    /// that are not transparent, before the image is kept.
    template <class Shade>
    std::uint32_t end_shaded_image(Shade&& shade) {
        std::uint32_t handle = 0;
        canvas_.end_image({&handle, 1}, shade);
        return handle;
    }
    void end_image(std::span<std::uint32_t> handles) { canvas_.end_image(handles); }
    void free_image(std::uint32_t image) { canvas_.free_image(image); }
    std::size_t image_bytes(int width, int height) const { return canvas_.image_bytes(width, height); }
    void draw(std::span<const ImageQuad> quads) { canvas_.draw(quads); }

    bool deposits_primitives() const { return canvas_.options().deposits_small_triangles; }
    /// This is two samples: a deposit then touches at most three by three.
    float largest_splat_px() const { return 2.0f / float(canvas_.samples_a_side()); }

    /// Whether a cell is hidden: nothing in it then changes the picture. Before the first deposit of a frame, a
    /// stand-in's or a triangle's, nothing is hidden: an exact picture takes every primitive in the frustum.
    bool hidden(const Cell& cell, CellId) {
        return is_hidden(cell, [this](int x0, int y0, int x1, int y1, float q) {
            return canvas_.buffers().all_settled(x0, y0, x1, y1, q);
        });
    }

    // For whoever draws by other means what this one says is seen: each drawable is dear there, and what can be left
    // out is worth a look at every sample, where hidden() looks at squares of 8 x 8.

    bool hidden_in_samples(const Cell& cell) {
        return is_hidden(cell, [this](int x0, int y0, int x1, int y1, float q) {
            return canvas_.buffers().each_settled(x0, y0, x1, y1, q);
        });
    }
    /// Whether a splat changes no sample: each that it touches is settled.
    bool hidden_in_samples(const Splat& splat) {
        const detail::SampleBuffers& buffers = canvas_.buffers();
        if (!buffers.has_far() || canvas_.is_sliced()) return false;
        const auto at = canvas_.projection().footprint(splat);
        if (!at) return false;
        constexpr float guard = detail::SampleProjection::guard_band;
        if (!(at->half.x < 32 && at->half.y < 32 && std::abs(at->center.x) < guard && std::abs(at->center.y) < guard))
            return false;
        const glm::vec2 upper_left = glm::floor(at->center - at->half), lower_right = glm::floor(at->center + at->half);
        return buffers.each_settled(int(upper_left.x), int(upper_left.y), int(lower_right.x), int(lower_right.y),
                                    at->q);
    }

  private:
    /// `all_settled` says so of a rectangle of samples.
    template <class AllSettled>
    bool is_hidden(const Cell& cell, AllSettled&& all_settled) {
        const detail::SampleBuffers& buffers = canvas_.buffers();
        if (!buffers.has_far() || canvas_.is_sliced()) return false;
        const detail::SampleProjection& projection = canvas_.projection();
        const glm::vec3 p = projection.project(cell.bounds_center);
        const float radius = length_of(cell.bounds_half);
        // A point of the sphere is projected at most radius (focal + |x|) / (depth - radius) away from its center.
        const float nearest = projection.is_perspective ? projection.w(p.z) - radius : 1.0f;
        if (!(nearest > 0)) return false;
        const float inverse = projection.inverse_w(p.z) * (1.0f / 256), x = p.x * inverse, y = p.y * inverse;
        const float skew = projection.is_perspective ? 1.0f : 0.0f, reach = radius / nearest;
        const float beyond = std::max(1.0f, projection.reach);
        const float rx = reach * (projection.focal.x + skew * std::abs(x)) + beyond,
                    ry = reach * (projection.focal.y + skew * std::abs(y)) + beyond;
        if (!(rx < 64 && ry < 64)) return false;  // large ones are seldom hidden and their children are asked again
        const float cx = x + projection.offset_x * (1.0f / 256), cy = y + projection.offset_y * (1.0f / 256);
        constexpr float guard = detail::SampleProjection::guard_band;
        if (!(std::abs(cx) < guard && std::abs(cy) < guard)) return false;
        // Nothing is nearer than this q, roundings included.
        const float rounding = (std::abs(p.z) + radius) * 0x1p-16f, front = p.z - radius - rounding;
        const float q = projection.q(front, 1 / std::max(projection.w(front), 0.5f * nearest));
        return all_settled(int(std::floor(cx - rx)), int(std::floor(cy - ry)), int(std::floor(cx + rx)),
                           int(std::floor(cy + ry)), q);
    }

    detail::ZBufferCanvas canvas_;
    detail::BlockFill fill_;
};

}  // namespace farfield
