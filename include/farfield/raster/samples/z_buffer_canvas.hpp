// The common part of renderers with a z-buffer: it lights sources, and draws them and the far field into
// SampleBuffers.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "farfield/fail.hpp"
#include "farfield/image.hpp"
#include "farfield/raster/light_in_view.hpp"
#include "farfield/raster/render_options.hpp"
#include "farfield/raster/sample_count.hpp"
#include "farfield/raster/sample_projection.hpp"
#include "farfield/raster/samples/depth_tested_fill.hpp"
#include "farfield/raster/samples/far_deposits.hpp"
#include "farfield/raster/samples/kept_image.hpp"
#include "farfield/raster/samples/sample_buffers.hpp"
#include "farfield/raster/source_slots.hpp"
#include "farfield/raster/triangles/triangle_painter.hpp"
#include "farfield/raster/triangles/triangle_reader.hpp"
#include "farfield/raster/triangles/triangle_runs.hpp"
#include "farfield/raster/triangles/triangle_stream.hpp"
#include "farfield/raster/triangles/triangle_triage.hpp"
#include "farfield/renderer.hpp"

namespace farfield::detail {

/// Errors name `renderer`, a string literal.
class ZBufferCanvas {
  public:
    /// Throws std::invalid_argument for a number of samples that is not a square of 1 to 8.
    ZBufferCanvas(const ZBufferOptions& options, const char* renderer)
        : options_(options),
          renderer_(renderer),
          side_(checked_samples_a_side(options.samples, renderer)),
          triage_(triage_function<false>(options.simd)),
          triage_small_(triage_function<true>(options.simd)),
          light_(options.light) {}

    const ZBufferOptions& options() const { return options_; }
    int samples_a_side() const { return side_; }
    const Image& image() const { return image_; }
    const SampleProjection& projection() const { return projection_; }
    SampleBuffers& buffers() { return buffers_; }
    template <class P>
    std::uint32_t upload(const Source<P>& source) {
        return streams_.upload(source, options_.copies_sources);
    }
    /// Throws std::invalid_argument if the other keeps no triangles and this one is to.
    std::uint32_t share(const ZBufferCanvas& other, std::uint32_t id) {
        if (options_.copies_sources && !other.options_.copies_sources) {
            fail<std::invalid_argument>("farfield::" + std::string(renderer_) +
                                        ": copies_sources must be false here too, as where its sources come from");
        }
        return streams_.share(other.streams_, id);
    }
    SourceSlots<TriangleStream>& streams() { return streams_; }
    const SourceSlots<TriangleStream>& streams() const { return streams_; }

    /// Throws std::invalid_argument for images of no or too many samples: 16,000 on a side.
    void begin_frame(const LocalView& view) {
        if (std::exchange(makes_image_, false)) leave_target();  // an exception ended the last frame
        check_image_size(view, side_, renderer_);
        projection_ = SampleProjection(view, side_);
        buffers_.begin(projection_, side_, options_.background);
        light_.begin_frame(view);
    }
    void set_view(const LocalView& view) {
        projection_ = SampleProjection(view, side_);
        light_.set_view(view);
    }
    void end_frame() { buffers_.resolve(image_); }

    /// See RendererFacts::keeps_images. Throws std::invalid_argument as a frame does.
    void begin_image(const LocalView& view, float quad_depth, int samples) {
        const int image_side = checked_samples_a_side(samples, renderer_);
        check_image_size(view, image_side, renderer_);
        makes_image_ = true;
        std::swap(buffers_, target_);
        frame_side_ = std::exchange(side_, image_side);
        projection_ = SampleProjection(view, side_);
        quad_depth_ = quad_depth - view.anchor_depth;
        // Images come in all sizes. A target that grows and never shrinks is cleared only where it was drawn to.
        const auto grown = [](int& size, int needed) { return size = std::max(size, (needed + 63) / 64 * 64); };
        SampleProjection of_target = projection_;
        of_target.end_x = of_target.first_x + grown(target_width_, view.width) * side_;
        of_target.end_y = of_target.first_y + grown(target_height_, view.height) * side_;
        buffers_.begin(of_target, side_, {0, 0, 0, 0});
    }
    std::uint32_t end_image() {
        buffers_.resolve(target_image_);
        std::uint32_t slot = 0;
        while (slot < images_.size() && images_[slot].whole_width != 0) ++slot;
        if (slot == images_.size()) images_.emplace_back();
        keep_image(images_[slot], buffers_, target_image_, projection_, quad_depth_, relative_depths_);
        makes_image_ = false;
        leave_target();
        return slot + 1;
    }
    void free_image(std::uint32_t image) { images_[image - 1] = {}; }
    std::size_t image_bytes(int width, int height) const { return KeptImage::bytes_of(width, height); }
    void draw(std::span<const ImageQuad> quads) {
        buffers_.begin_far();
        ImageFill fill(projection_, buffers_);
        for (const ImageQuad& quad : quads) fill.add(quad, images_[quad.image - 1]);
    }

    /// Small triangles of ranges with a law are deposited if the options say so.
    template <class P, class Fill>
    void draw(const Source<P>& source, std::span<const Range> ranges, const Fill& fill) {
        const TriangleStream& stream = streams_[source.id];
        for (const Range& r : ranges) {
            const auto draw_range = [&](const TriangleStream& of, std::uint32_t first, std::uint32_t end) {
                TrianglePainter<Fill> painter(of, projection_, light_.light(), options_.culls_back_faces, fill);
                if (r.law && options_.deposits_small_triangles) {
                    draw_with_deposits(of, first, end, r.law, painter);
                } else {
                    draw_triangles(of, first, end, projection_, triage_, painter);
                }
            };
            if (options_.copies_sources) {
                draw_range(stream, stream.first_triangle(r.first), stream.first_triangle(r.first + r.count));
            } else {
                reader_.read(source, stream, r, draw_range);
            }
        }
    }

    void draw(std::span<const Face> faces) {
        buffers_.begin_far();
        FarDeposits deposits(projection_, buffers_);
        for (const Face& face : faces) deposits.add(face);
    }
    void draw(std::span<const Splat> splats) {
        buffers_.begin_far();
        FarDeposits deposits(projection_, buffers_);
        for (const Splat& splat : splats) deposits.add(splat);
    }

  private:
    void leave_target() {
        std::swap(buffers_, target_);
        side_ = frame_side_;
    }

    /// Draws triangles [first, end) of a cell whose law is known. Not inlined, or g++ at -O1 warns that a law may be
    /// read unset, for ranges that never get here.
    template <class Painter>
    [[gnu::noinline]] void draw_with_deposits(const TriangleStream& stream, std::uint32_t first, std::uint32_t end,
                                              const std::optional<AreaLaw>& known_law, Painter& painter) {
        const AreaLaw law = *known_law;
        const Loss opaque = loss_of_opacity(1, law);
        for_triaged_blocks(
            stream, first, end, projection_, triage_small_,
            [&](std::uint32_t block, const TriageMasks& masks, const TriagedBlock& triaged, unsigned in_range) {
                unsigned small_ones = masks.small_ones & in_range;
                if (options_.culls_back_faces) small_ones &= masks.front;
                if (small_ones != 0) buffers_.begin_far();
                for (unsigned left = small_ones; left != 0; left &= left - 1) {
                    const auto lane = unsigned(std::countr_zero(left));
                    const bool front = (masks.front >> lane & 1) != 0;
                    painter.deposit(block * TriangleBlock::lanes + lane, triaged, lane, front, opaque);
                }
                // Squares do not tile a surface as its triangles do, and its larger triangles are not deposited at all.
                // So that nothing shows through, samples that its small ones hold are drawn as well, behind.
                if (law != AreaLaw::coherent) in_range &= ~masks.small_ones;
                for (unsigned left = (masks.draw | masks.clip) & in_range; left != 0; left &= left - 1) {
                    const auto lane = unsigned(std::countr_zero(left));
                    const std::uint32_t triangle = block * TriangleBlock::lanes + lane;
                    if (masks.clip >> lane & 1) {
                        painter.draw_clipped(triangle);
                    } else if (small_ones >> lane & 1) {
                        painter.draw_behind(triangle, triaged, lane);
                    } else {
                        painter.draw(triangle, triaged, lane);
                    }
                }
            });
    }

    ZBufferOptions options_;
    const char* renderer_;
    int side_;
    TriageFunction triage_, triage_small_;
    LightInView light_;
    SampleProjection projection_;
    SampleBuffers buffers_;
    SourceSlots<TriangleStream> streams_;
    TriangleReader reader_;  ///< where streams keep no triangles
    Image image_;

    bool makes_image_ = false;  ///< buffers_ and side_ are an image's, and target_ and frame_side_ the frame's
    SampleBuffers target_;
    int frame_side_ = 1, target_width_ = 0, target_height_ = 0;
    float quad_depth_ = 0;  ///< from the anchor
    Image target_image_;
    std::vector<KeptImage> images_;       ///< by handle less 1; of no width where free
    std::vector<float> relative_depths_;  ///< keep_image's
};

}  // namespace farfield::detail
