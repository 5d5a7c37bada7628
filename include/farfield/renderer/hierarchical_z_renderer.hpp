// Hierarchical z-buffering: N. Greene, M. Kass, G. Miller, "Hierarchical Z-buffer Visibility", SIGGRAPH 1993. A
// z-pyramid over the z-buffer tests cells before anything in them is touched and polygons before they are scan
// converted.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

#include "farfield/image.hpp"
#include "farfield/raster/box_footprint.hpp"
#include "farfield/raster/render_options.hpp"
#include "farfield/raster/samples/depth_pyramid.hpp"
#include "farfield/raster/samples/depth_tested_fill.hpp"
#include "farfield/raster/samples/z_buffer_canvas.hpp"
#include "farfield/raster/scan_conversion.hpp"
#include "farfield/renderer.hpp"

namespace farfield::detail {

/// Fills like DepthTestedFill, but rejects triangles that the pyramid hides.
class PyramidTestedFill {
  public:
    PyramidTestedFill(const SampleProjection& projection, DepthPyramid& pyramid, const DepthTestedFill& fill)
        : projection_(projection), pyramid_(pyramid), fill_(fill) {}

    SampleBuffers& buffers() const { return fill_.buffers(); }

    bool rejects(const SnappedTriangle& t) const {
        const auto low = [](const std::int32_t(&v)[3]) { return std::min(std::min(v[0], v[1]), v[2]); };
        const auto high = [](const std::int32_t(&v)[3]) { return std::max(std::max(v[0], v[1]), v[2]); };
        return is_hidden(low(t.x), low(t.y), high(t.x), high(t.y), std::max(std::max(t.q[0], t.q[1]), t.q[2]));
    }

    template <class Prepare, class Shade>
    void operator()(const SnappedTriangle& t, std::int64_t doubled_area, Prepare&& prepare, const Shade& shade) const {
        fill_(t, doubled_area, prepare, shade);
    }

  private:
    /// Whether a box in 1/256 samples holds no sample, or its contents, at q or farther, are hidden.
    bool is_hidden(std::int32_t left, std::int32_t top, std::int32_t right, std::int32_t bottom, float q) const {
        const int x0 = std::max((left + 127) >> 8, projection_.first_x),
                  x1 = std::min((right - 128) >> 8, projection_.end_x - 1);
        const int y0 = std::max((top + 127) >> 8, projection_.first_y),
                  y1 = std::min((bottom - 128) >> 8, projection_.end_y - 1);
        if (x0 > x1 || y0 > y1) return true;
        // Of small ones the fill itself asks the few blocks that they touch.
        constexpr int few_blocks = 4 * SampleBlocks::side;
        return (x1 - x0 >= few_blocks || y1 - y0 >= few_blocks) &&
               pyramid_.all_nearer(x0 - projection_.first_x, y0 - projection_.first_y, x1 - projection_.first_x,
                                   y1 - projection_.first_y, q);
    }

    const SampleProjection& projection_;
    DepthPyramid& pyramid_;
    const DepthTestedFill& fill_;
};

}  // namespace farfield::detail

namespace farfield {

/// Draws what ZBufferRenderer draws: the same ranges give the same picture, bit for bit, in any order. It asks for
/// front to back, without needing it, because fewer ranges then come at all.
class HierarchicalZRenderer {
  public:
    static constexpr RendererFacts facts{.order = VisitOrder::front_to_back,
                                         .keeps_sources = true,
                                         .draws_changing_sources = true,
                                         .shares_sources = true,
                                         .tells_lifetime = true,
                                         .tells_light = true,
                                         .draws_faces = true,
                                         .draws_splats = true,
                                         .answers_hidden = true,
                                         .deposits_primitives = true,
                                         .keeps_images = true};

    /// Throws std::invalid_argument for a number of samples that is not a square of 1 to 8.
    explicit HierarchicalZRenderer(const ZBufferOptions& options = {})
        : canvas_(options, "HierarchicalZRenderer"), fill_(detail::block_fill(options.simd)) {}

    const Image& image() const { return canvas_.image(); }
    const std::optional<DirectionalLight>& light() const { return canvas_.options().light; }

    template <PrimitiveWithPolygons P>
    std::uint32_t upload(const Source<P>& source) {
        return canvas_.upload(source);
    }
    std::uint32_t share(const HierarchicalZRenderer& other, std::uint32_t id) {
        return canvas_.share(other.canvas_, id);
    }
    void release(std::uint32_t id) { canvas_.streams().release(id); }
    /// The memory of all that is uploaded: once, however many viewers and renderers draw it.
    std::size_t uploaded_bytes() const { return canvas_.streams().bytes(); }
    std::weak_ptr<const void> lifetime() const { return canvas_.streams().lifetime(); }

    /// Throws std::invalid_argument for images of no samples or more than 16,000 on a side.
    void begin_frame(const LocalView& view) {
        canvas_.begin_frame(view);
        pyramid_.begin(canvas_.buffers().blocks());
    }
    void set_view(const LocalView& view) { canvas_.set_view(view); }
    void end_frame() { canvas_.end_frame(); }

    template <class P>
    void draw(const Source<P>& source, std::span<const Range> ranges) {
        const detail::DepthTestedFill fill(canvas_.projection(), canvas_.buffers(), fill_);
        canvas_.draw(source, ranges, detail::PyramidTestedFill(canvas_.projection(), pyramid_, fill));
    }
    void draw(std::span<const Face> faces) { canvas_.draw(faces); }
    void draw(std::span<const Splat> splats) { canvas_.draw(splats); }

    void begin_image(const LocalView& view, float quad_depth, int samples) {
        canvas_.begin_image(view, quad_depth, samples);
        pyramid_.begin(canvas_.buffers().blocks());
    }
    std::uint32_t end_image() {
        const std::uint32_t image = canvas_.end_image();
        pyramid_.begin(canvas_.buffers().blocks());
        return image;
    }
    void free_image(std::uint32_t image) { canvas_.free_image(image); }
    std::size_t image_bytes(int width, int height) const { return canvas_.image_bytes(width, height); }
    void draw(std::span<const ImageQuad> quads) { canvas_.draw(quads); }

    bool deposits_primitives() const { return canvas_.options().deposits_small_triangles; }
    /// This is two samples: a deposit then touches at most three by three.
    float largest_splat_px() const { return 2.0f / float(canvas_.samples_a_side()); }

    /// Whether geometry drawn before is nearer than the cell's bounds in every sample that these touch: nothing in the
    /// cell then changes the picture. It is false for cells that reach to the near plane. In a far field closed samples
    /// hide too, as in ZBufferRenderer::hidden.
    bool hidden(const Cell& cell, CellId) {
        const detail::SampleProjection& projection = canvas_.projection();
        const detail::BoxFootprint at(cell.bounds_center, cell.bounds_half, projection);
        if (!at.is_bounded) return false;
        if (at.is_empty()) return true;
        detail::SampleBuffers& buffers = canvas_.buffers();
        const auto nearest = [&](int x0, int y0, int x1, int y1) {
            return at.fronts.nearest_in(x0 + projection.first_x, y0 + projection.first_y, x1 + projection.first_x,
                                        y1 + projection.first_y);
        };
        return pyramid_.all_nearer(at.x0 - projection.first_x, at.y0 - projection.first_y, at.x1 - projection.first_x,
                                   at.y1 - projection.first_y, nearest) ||
               (buffers.has_far() && buffers.all_settled(at.x0, at.y0, at.x1, at.y1, at.fronts.nearest_q));
    }

  private:
    detail::ZBufferCanvas canvas_;
    detail::BlockFill fill_;
    detail::DepthPyramid pyramid_;
};

}  // namespace farfield
