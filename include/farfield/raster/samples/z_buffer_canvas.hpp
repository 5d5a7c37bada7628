// The common part of renderers with a z-buffer: it lights sources, and draws them and the far field into
// SampleBuffers.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <limits>
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
#include "farfield/raster/samples/image_block_fill.hpp"
#include "farfield/raster/samples/image_fill.hpp"
#include "farfield/raster/samples/kept_image.hpp"
#include "farfield/raster/samples/sample_buffers.hpp"
#include "farfield/raster/samples/sliced_buffers.hpp"
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
          image_fill_(image_block_fill(options.simd)),
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
        const ImageSlice all{.depth = quad_depth};
        begin_image(view, {&all, 1}, samples);
    }
    /// See RendererFacts::slices_images.
    void begin_image(const LocalView& view, std::span<const ImageSlice> slices, int samples) {
        const int image_side = checked_samples_a_side(samples, renderer_);
        check_image_size(view, image_side, renderer_);
        if (targets_.size() < slices.size()) targets_.resize(slices.size());
        makes_image_ = true;
        frame_side_ = std::exchange(side_, image_side);
        std::swap(buffers_, targets_[0].buffers);
        projection_ = SampleProjection(view, side_);
        slices_.clear();
        const auto q = [&](float depth) {
            const float from_anchor = depth - view.anchor_depth;
            if (!(from_anchor > projection_.near_depth)) return std::numeric_limits<float>::infinity();
            if (!(from_anchor < std::numeric_limits<float>::max())) return -std::numeric_limits<float>::infinity();
            return projection_.q(from_anchor, projection_.inverse_w(from_anchor));
        };
        for (std::size_t i = 0; i < slices.size(); ++i) {
            Target& target = targets_[i];
            target.quad_depth = slices[i].depth - view.anchor_depth;
            // Images come in all sizes. A target that grows and never shrinks is cleared only where it was drawn to.
            const auto grown = [](int& size, int needed) { return size = std::max(size, (needed + 63) / 64 * 64); };
            SampleProjection of_target = projection_;
            of_target.end_x = of_target.first_x + grown(target.width, view.width) * side_;
            of_target.end_y = of_target.first_y + grown(target.height, view.height) * side_;
            SampleBuffers& buffers = i == 0 ? buffers_ : target.buffers;
            buffers.begin(of_target, side_, {0, 0, 0, 0});
            slices_.add(buffers, {q(slices[i].farthest), q(slices[i].nearest)});
        }
    }
    std::uint32_t end_image() {
        std::uint32_t handle = 0;
        end_image({&handle, 1});
        return handle;
    }
    /// If memory runs out, no image of these is kept.
    void end_image(std::span<std::uint32_t> handles) {
        end_image(handles, [](Image&) {});
    }
    /// The same, after shade(Image&) has changed colors, premultiplied, of pixels that are not transparent.
    template <class Shade>
    void end_image(std::span<std::uint32_t> handles, Shade&& shade) {
        std::fill(handles.begin(), handles.end(), 0u);
        struct Unfinished {
            ZBufferCanvas& canvas;
            std::span<const std::uint32_t> handles;
            ~Unfinished() {
                for (const std::uint32_t handle : handles) {
                    if (handle != 0) canvas.free_image(handle);
                }
            }
        } unfinished{*this, handles};
        for (std::size_t i = 0; i < handles.size(); ++i) {
            while (first_free_ < images_.size() && images_[first_free_].whole_width != 0) ++first_free_;
            if (first_free_ == images_.size()) images_.emplace_back();
            const std::size_t slot = first_free_++;
            handles[i] = std::uint32_t(slot + 1);
            SampleBuffers& buffers = slices_.buffers(i);
            buffers.resolve(targets_[i].image);
            shade(targets_[i].image);
            keep_image(images_[slot], buffers, targets_[i].image, projection_, targets_[i].quad_depth, slices_.range(i),
                       scratch_);
        }
        unfinished.handles = {};
        makes_image_ = false;
        leave_target();
    }
    void free_image(std::uint32_t image) {
        images_[image - 1] = {};
        first_free_ = std::min(first_free_, std::size_t(image - 1));
    }
    std::size_t image_bytes(int width, int height) const { return KeptImage::bytes_of(width, height); }
    void draw(std::span<const ImageQuad> quads) {
        for (const ImageQuad& quad : quads) {
            SampleBuffers& buffers = is_sliced() ? slices_.at(q_of_center(quad)) : buffers_;
            buffers.begin_far();
            ImageFill(projection_, buffers, image_fill_).add(quad, images_[quad.image - 1]);
        }
    }

    /// Whether what is drawn goes into several depth slices.
    bool is_sliced() const { return makes_image_ && slices_.size() > 1; }
    SlicedBuffers& slices() { return slices_; }

    /// Small triangles of ranges with a law are deposited if the options say so.
    template <class P, class Fill>
    void draw(const Source<P>& source, std::span<const Range> ranges, const Fill& fill) {
        const TriangleStream& stream = streams_[source.id];
        for (const Range& r : ranges) {
            const auto draw_range = [&](const TriangleStream& of, std::uint32_t first, std::uint32_t end) {
                TrianglePainter<Fill> painter(of, projection_, light_.light(), options_.culls_back_faces, fill);
                if (r.law && options_.deposits_small_triangles) {
                    draw_with_deposits(of, first, end, r.law, fill, painter);
                } else {
                    draw_triangles(of, first, end, projection_, triage_, painter);
                }
            };
            if (options_.copies_sources && !source.changes) {
                draw_range(stream, stream.first_triangle(r.first), stream.first_triangle(r.first + r.count));
            } else {
                reader_.read(source, stream, r, draw_range);
            }
        }
    }

    void draw(std::span<const Face> faces) { is_sliced() ? deposit(faces, slices_) : deposit(faces, buffers_); }
    void draw(std::span<const Splat> splats) { is_sliced() ? deposit(splats, slices_) : deposit(splats, buffers_); }

  private:
    template <class Drawable, class Buffers>
    void deposit(std::span<const Drawable> drawables, Buffers& buffers) {
        buffers.begin_far();
        FarDeposits deposits(projection_, buffers);
        for (const Drawable& d : drawables) deposits.add(d);
    }

    void leave_target() {
        std::swap(buffers_, targets_[0].buffers);
        side_ = frame_side_;
    }
    float q_of_center(const ImageQuad& quad) const {
        const glm::vec3 p = projection_.project(quad.corner + 0.5f * (quad.across + quad.down));
        return projection_.q(p.z, projection_.inverse_w(p.z));
    }

    /// Draws triangles [first, end) of a cell whose law is known. Not inlined, or g++ at -O1 warns that a law may be
    /// read unset, for ranges that never get here.
    template <class Fill, class Painter>
    [[gnu::noinline]] void draw_with_deposits(const TriangleStream& stream, std::uint32_t first, std::uint32_t end,
                                              const std::optional<AreaLaw>& known_law, const Fill& fill,
                                              Painter& painter) {
        const AreaLaw law = *known_law;
        const Loss opaque = loss_of_opacity(1, law);
        for_triaged_blocks(
            stream, first, end, projection_, triage_small_,
            [&](std::uint32_t block, const TriageMasks& masks, const TriagedBlock& triaged, unsigned in_range) {
                unsigned small_ones = masks.small_ones & in_range;
                if (options_.culls_back_faces) small_ones &= masks.front;
                if (small_ones != 0) fill.buffers().begin_far();
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
    ImageBlockFill image_fill_;
    LightInView light_;
    SampleProjection projection_;
    SampleBuffers buffers_;
    SourceSlots<TriangleStream> streams_;
    TriangleReader reader_;  ///< where streams keep no triangles
    Image image_;

    /// What a slice of an image is drawn into.
    struct Target {
        SampleBuffers buffers;  ///< the first one's are the frame's while an image is made
        Image image;
        int width = 0, height = 0;
        float quad_depth = 0;  ///< from the anchor
    };
    bool makes_image_ = false;  ///< buffers_ and side_ are an image's, frame_side_ the frame's
    int frame_side_ = 1;
    std::vector<Target> targets_;
    SlicedBuffers slices_;           ///< of the image that is made
    std::vector<KeptImage> images_;  ///< by handle less 1; of no width where free
    std::size_t first_free_ = 0;     ///< none before it is
    KeepingScratch scratch_;
};

}  // namespace farfield::detail
