// A renderer of the library as an AnyRenderer. It must be one that reads a source only while it is paged in.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <type_traits>
#include <vector>

#include "scenes/renderers/any_renderer.hpp"

namespace farfield::scenes {

/// A position of an AnySource as a primitive.
struct AnyItem {
    const AnySource* source;
    std::uint32_t position;

    Box bounds() const { return Box::empty(); }  // renderers do not ask
    template <class Sink>
    void polygons(Sink&& sink) const {
        source->polygons(position, AnyPolygonSink(sink));
    }
};

template <class R>
class RendererBehind final : public AnyRenderer {
  public:
    template <class Options>
    explicit RendererBehind(const Options& options) : renderer_(options) {}

    std::uint32_t upload(const AnySource& source) override {
        std::vector<AnyItem> items;
        items.reserve(source.item_count());
        for (std::uint32_t i = 0; i < source.item_count(); ++i) items.push_back({&source, i});
        return renderer_.upload(Source<AnyItem>{items, {}, source.item_count()});
    }
    std::uint32_t share([[maybe_unused]] const AnyRenderer& other, [[maybe_unused]] std::uint32_t id) override {
        if constexpr (R::facts.shares_sources) {
            return renderer_.share(static_cast<const RendererBehind&>(other).renderer_, id);
        }
        return id;
    }
    void release(std::uint32_t id) override { renderer_.release(id); }
    void begin_frame(const LocalView& view) override { renderer_.begin_frame(view); }
    void set_view(const LocalView& view) override { renderer_.set_view(view); }
    void end_frame() override { renderer_.end_frame(); }
    void draw(std::uint32_t id, std::span<const Range> ranges) override {
        Source<AnyItem> source{};
        source.id = id;
        renderer_.draw(source, ranges);
    }
    const Image& image() const override { return renderer_.image(); }
    unsigned texture() const override {
        if constexpr (requires { renderer_.texture(); }) return renderer_.texture();
        return 0;
    }
    std::uint64_t sent_bytes() const override {
        if constexpr (requires { renderer_.sent_bytes(); }) return renderer_.sent_bytes();
        return 0;
    }

    void draw([[maybe_unused]] std::span<const Face> faces) override {
        if constexpr (R::facts.draws_faces) renderer_.draw(faces);
    }
    void draw([[maybe_unused]] std::span<const Splat> splats) override {
        if constexpr (R::facts.draws_splats) renderer_.draw(splats);
    }
    void draw([[maybe_unused]] const PlacedStandIns& placed) override {
        if constexpr (R::facts.shapes_stand_ins) renderer_.draw(placed);
    }
    bool shapes_stand_ins() const override {
        if constexpr (R::facts.shapes_stand_ins) return renderer_.shapes_stand_ins();
        return false;
    }
    float largest_splat_px() const override {
        if constexpr (R::facts.draws_splats) return renderer_.largest_splat_px();
        return 0;
    }
    bool deposits_primitives() const override {
        if constexpr (R::facts.deposits_primitives) return renderer_.deposits_primitives();
        return false;
    }
    bool hidden([[maybe_unused]] const Cell& cell, [[maybe_unused]] CellId id) override {
        if constexpr (R::facts.answers_hidden) return renderer_.hidden(cell, id);
        return false;
    }

    void begin_image([[maybe_unused]] const LocalView& view, [[maybe_unused]] float quad_depth,
                     [[maybe_unused]] int samples) override {
        if constexpr (R::facts.keeps_images) renderer_.begin_image(view, quad_depth, samples);
    }
    std::uint32_t end_image() override {
        if constexpr (R::facts.keeps_images) return renderer_.end_image();
        return 0;
    }
    void begin_image([[maybe_unused]] const LocalView& view, [[maybe_unused]] std::span<const ImageSlice> slices,
                     [[maybe_unused]] int samples) override {
        if constexpr (R::facts.slices_images) renderer_.begin_image(view, slices, samples);
    }
    void end_image([[maybe_unused]] std::span<std::uint32_t> handles) override {
        if constexpr (R::facts.slices_images) renderer_.end_image(handles);
    }
    void free_image([[maybe_unused]] std::uint32_t image) override {
        if constexpr (R::facts.keeps_images) renderer_.free_image(image);
    }
    std::size_t image_bytes([[maybe_unused]] int width, [[maybe_unused]] int height) const override {
        if constexpr (R::facts.keeps_images) return renderer_.image_bytes(width, height);
        return 0;
    }
    void draw([[maybe_unused]] std::span<const ImageQuad> quads) override {
        if constexpr (R::facts.keeps_images) renderer_.draw(quads);
    }

    const CoverageWork* work() const override {
        if constexpr (requires { renderer_.work(); }) return &renderer_.work();
        return nullptr;
    }
    const CoverageWorkImage* work_map() const override {
        if constexpr (requires(const CoverageWorkImage*& map) { map = &renderer_.work(); }) return &renderer_.work();
        return nullptr;
    }

  private:
    R renderer_;
};

}  // namespace farfield::scenes
