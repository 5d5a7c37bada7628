// Renderers behind virtual functions, compiled once a program and not once a type of hierarchy. Calls go by batches, so
// that they cost nothing that could be measured.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <utility>

#include "farfield/coverage/coverage_work.hpp"
#include "farfield/geometry/box.hpp"
#include "farfield/geometry/polygon.hpp"
#include "farfield/image.hpp"
#include "farfield/renderer.hpp"
#include "scenes/renderers/renderer_choice.hpp"

namespace farfield::scenes {

/// A Source, the type of its primitives forgotten.
class AnySource {
  public:
    template <PrimitiveWithPolygons P>
    explicit AnySource(const Source<P>& source)
        : source_(&source), item_count_(source.item_count), polygons_(&polygons_of<P>) {}

    std::uint32_t item_count() const { return item_count_; }
    /// Calls sink(Polygon) with what the position holds, in local coordinates.
    void polygons(std::uint32_t position, const AnyPolygonSink& sink) const { polygons_(source_, position, sink); }

  private:
    template <class P>
    static void polygons_of(const void* source, std::uint32_t position, const AnyPolygonSink& sink) {
        static_cast<const Source<P>*>(source)->polygons(position, sink);
    }

    const void* source_;
    std::uint32_t item_count_;
    void (*polygons_)(const void*, std::uint32_t, const AnyPolygonSink&);
};

class AnyRenderer {
  public:
    virtual ~AnyRenderer() = default;

    virtual std::uint32_t upload(const AnySource& source) = 0;
    /// Uploads what another, made by make_renderer for the same choice, has as `id`, without a copy. Never called of
    /// those whose facts do not say so.
    virtual std::uint32_t share(const AnyRenderer& other, std::uint32_t id) = 0;
    virtual void release(std::uint32_t id) = 0;
    virtual void begin_frame(const LocalView& view) = 0;
    virtual void set_view(const LocalView& view) = 0;
    virtual void end_frame() = 0;
    virtual void draw(std::uint32_t source, std::span<const Range> ranges) = 0;
    virtual const Image& image() const = 0;
    /// OpenGL's name of the texture that it was drawn into, in the context that drew it; 0: there is none.
    virtual unsigned texture() const { return 0; }
    /// What the last frame sent to the GPU.
    virtual std::uint64_t sent_bytes() const { return 0; }

    // Of those whose facts say so; never called of others.
    virtual void draw(std::span<const Face> faces) = 0;
    virtual void draw(std::span<const Splat> splats) = 0;
    virtual void draw(const PlacedStandIns& placed) = 0;
    virtual bool shapes_stand_ins() const = 0;
    virtual float largest_splat_px() const = 0;
    virtual bool deposits_primitives() const = 0;
    virtual bool hidden(const Cell& cell, CellId id) = 0;
    virtual void begin_image(const LocalView& view, float quad_depth, int samples) = 0;
    virtual std::uint32_t end_image() = 0;
    virtual void begin_image(const LocalView& view, std::span<const ImageSlice> slices, int samples) = 0;
    virtual void end_image(std::span<std::uint32_t> handles) = 0;
    virtual void free_image(std::uint32_t image) = 0;
    virtual std::size_t image_bytes(int width, int height) const = 0;
    virtual void draw(std::span<const ImageQuad> quads) = 0;

    /// Of the last frame; null where nobody counts.
    virtual const CoverageWork* work() const = 0;
    /// The same with the places; null unless RendererChoice::maps_work.
    virtual const CoverageWorkImage* work_map() const = 0;
    /// What the last frame drew, seen from above and behind, its frustum outlined in green and images that cells were
    /// drawn by in red; null unless RendererChoice::looks_on and there were any. The next frame forgets it. From a view
    /// of the caller's own, if there is one, images or not.
    virtual const Image* from_outside([[maybe_unused]] const LocalView* from = nullptr) { return nullptr; }
};

/// `is_strict`: what is drawn comes in strict order, which coverage masks make use of. Throws std::invalid_argument for
/// numbers of samples that the renderer does not take.
std::unique_ptr<AnyRenderer> make_renderer(const RendererChoice& choice, bool is_strict);

/// What a Viewer draws with: any renderer that has the facts of `Like`.
template <class Like>
class RendererLike {
  public:
    static constexpr RendererFacts facts = [] {
        RendererFacts f = Like::facts;
        f.keeps_sources = true;
        f.shapes_stand_ins = f.draws_splats;  // if this one does
        f.tells_lifetime = false;             // it lives here
        f.tells_light = false;                // scenes have their light baked in, and are drawn without one
        f.draws_polygons = false;             // they come of MergedViewer only, which no scene is drawn by here
        return f;
    }();

    /// Pixels beyond its own that a pixel gets samples from.
    static constexpr int reach_px = [] {
        if constexpr (requires { Like::reach_px; }) return int(Like::reach_px);
        return 0;
    }();

    explicit RendererLike(std::unique_ptr<AnyRenderer> renderer) : renderer_(std::move(renderer)) {}

    const AnyRenderer& any() const { return *renderer_; }
    AnyRenderer& any() { return *renderer_; }
    const Image& image() const { return renderer_->image(); }

    template <PrimitiveWithPolygons P>
    std::uint32_t upload(const Source<P>& source) {
        return renderer_->upload(AnySource(source));
    }
    std::uint32_t share(const RendererLike& other, std::uint32_t id) { return renderer_->share(*other.renderer_, id); }
    void release(std::uint32_t id) { renderer_->release(id); }
    void begin_frame(const LocalView& view) { renderer_->begin_frame(view); }
    void set_view(const LocalView& view) { renderer_->set_view(view); }
    void end_frame() { renderer_->end_frame(); }
    template <class P>
    void draw(const Source<P>& source, std::span<const Range> ranges) {
        renderer_->draw(source.id, ranges);
    }
    void draw(std::span<const Face> faces) { renderer_->draw(faces); }
    void draw(std::span<const Splat> splats) { renderer_->draw(splats); }
    void draw(const PlacedStandIns& placed) { renderer_->draw(placed); }
    bool shapes_stand_ins() const { return renderer_->shapes_stand_ins(); }
    float largest_splat_px() const { return renderer_->largest_splat_px(); }
    bool deposits_primitives() const { return renderer_->deposits_primitives(); }
    bool hidden(const Cell& cell, CellId id) { return renderer_->hidden(cell, id); }
    void begin_image(const LocalView& view, float quad_depth, int samples) {
        renderer_->begin_image(view, quad_depth, samples);
    }
    std::uint32_t end_image() { return renderer_->end_image(); }
    void begin_image(const LocalView& view, std::span<const ImageSlice> slices, int samples) {
        renderer_->begin_image(view, slices, samples);
    }
    void end_image(std::span<std::uint32_t> handles) { renderer_->end_image(handles); }
    void free_image(std::uint32_t image) { renderer_->free_image(image); }
    std::size_t image_bytes(int width, int height) const { return renderer_->image_bytes(width, height); }
    void draw(std::span<const ImageQuad> quads) { renderer_->draw(quads); }

  private:
    std::unique_ptr<AnyRenderer> renderer_;
};

}  // namespace farfield::scenes
