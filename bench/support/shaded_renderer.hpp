// A renderer whose pixels are dear, as a user's may be: a z-buffer with deferred shading, by a shader that takes as
// long as it is told to.
#pragma once

#include <algorithm>
#include <cstdint>
#include <ctime>
#include <span>
#include <vector>

#include "farfield/drawables.hpp"
#include "farfield/geometry/rgba8.hpp"
#include "farfield/image.hpp"
#include "farfield/renderer.hpp"
#include "farfield/renderer/z_buffer_renderer.hpp"
#include "farfield/view/local_view.hpp"

namespace farfield::bench {

/// A sum of noise that depends on a pixel's material alone, each term on the one before: no compiler shortens it, and
/// none draws two pixels at once.
class DearShader {
  public:
    /// Of so many terms.
    explicit DearShader(unsigned terms) : terms_(terms) {}
    /// As many as take this time on this machine, on one thread.
    static DearShader taking_ns(double ns) {
        constexpr unsigned terms = 512, pixels = 4096;
        const DearShader shader(terms);
        const auto now_ns = [] {
            timespec t{};
            clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
            return double(t.tv_sec) * 1e9 + double(t.tv_nsec);
        };
        double best = 1e300;
        std::uint32_t seen = 0;
        for (int run = 0; run < 8; ++run) {
            const double start = now_ns();
            for (unsigned i = 0; i < pixels; ++i) seen += shader({0, std::uint8_t(i), std::uint8_t(i >> 8), 255}).g;
            const double each = (now_ns() - start) / pixels;
            if (each < best && seen != 0) best = each;
        }
        return DearShader(unsigned(ns / best * terms));
    }
    unsigned terms() const { return terms_; }

    /// Green and blue are the material and what comes of it.
    Rgba8 operator()(Rgba8 c) const {
        std::uint32_t noise = std::uint32_t(c.g) << 8 | c.b;
        float sum = 0;
        for (unsigned i = 0; i < terms_; ++i) {
            noise = noise * 1664525 + 1013904223;
            sum += float(noise >> 8) * 0x1p-24f;
        }
        const float light = 0.5f + (terms_ == 0 ? 0.5f : sum / float(terms_));  // about 1
        const auto lit = [&](std::uint8_t v) { return std::uint8_t(std::min(float(v) * light + 0.5f, float(c.a))); };
        return {c.r, lit(c.g), lit(c.b), c.a};
    }

  private:
    unsigned terms_;
};

/// Shades each pixel of a frame once, where anything but an image is seen, and each pixel of an image once, when it is
/// made: what images show has been shaded. Red says where shading is due, so scenes are shown in green and blue.
class ShadedRenderer : public ZBufferRenderer {
  public:
    static constexpr RendererFacts facts = [] {
        RendererFacts f = ZBufferRenderer::facts;
        f.slices_images = f.shares_sources = f.draws_changing_sources = false;
        return f;
    }();

    explicit ShadedRenderer(const ZBufferOptions& options = {}, DearShader shader = DearShader(0))
        : ZBufferRenderer(options), shader_(shader) {}

    void set_shader(DearShader shader) { shader_ = shader; }
    /// Over all frames.
    std::uint64_t shaded_pixels() const { return shaded_pixels_; }
    const Image& image() const { return image_; }

    template <PrimitiveWithPolygons P>
    std::uint32_t upload(const Source<P>& source) {
        std::vector<Unshaded<P>> items;
        for (std::uint32_t i = 0; i < source.item_count; ++i) items.push_back({&source, i});
        return ZBufferRenderer::upload(Source<Unshaded<P>>{items, {}, source.item_count});
    }
    void end_frame() {
        ZBufferRenderer::end_frame();
        image_ = ZBufferRenderer::image();
        shade(image_);
        for (Rgba8& c : image_.pixels()) c.r = c.g;
    }
    template <class P>
    void draw(const Source<P>& source, std::span<const Range> ranges) {
        ZBufferRenderer::draw(source, ranges);
    }
    void draw(std::span<const Splat> splats) {
        splats_.assign(splats.begin(), splats.end());
        for (Splat& s : splats_) s.rgb.r = 255;
        ZBufferRenderer::draw(std::span<const Splat>(splats_));
    }
    void draw(std::span<const Face> faces) {
        faces_.assign(faces.begin(), faces.end());
        for (Face& f : faces_) f.rgba.r = f.rgba.a;
        ZBufferRenderer::draw(std::span<const Face>(faces_));
    }
    void draw(std::span<const ImageQuad> quads) { ZBufferRenderer::draw(quads); }
    std::uint32_t end_image() {
        return end_shaded_image([this](Image& image) { shade(image); });
    }

  private:
    /// A position of a source, in a color that asks to be shaded.
    template <class P>
    struct Unshaded {
        const Source<P>* source;
        std::uint32_t position;

        Box bounds() const { return Box::empty(); }  // renderers do not ask
        template <class Sink>
        void polygons(Sink&& sink) const {
            source->polygons(position, [&](const Polygon& p) {
                Rgba8 color = p.colors[0];
                color.r = 255;
                sink(Polygon{p.vertices, {&color, 1}, p.is_lit});
            });
        }
    };

    void shade(Image& image) {
        for (Rgba8& c : image.pixels()) {
            if (c.r == 0) continue;
            c = shader_(c);
            c.r = 0;
            ++shaded_pixels_;
        }
    }

    DearShader shader_;
    Image image_;
    std::vector<Splat> splats_;
    std::vector<Face> faces_;
    std::uint64_t shaded_pixels_ = 0;
};

}  // namespace farfield::bench
