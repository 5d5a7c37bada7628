// A renderer that can show from outside what it drew: Shade et al. 1996, figure 3(c).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "farfield/primitive/triangle.hpp"
#include "farfield/view/local_view.hpp"
#include "scenes/renderers/any_renderer.hpp"

namespace farfield::scenes {

/// Draws as another does, and remembers what was drawn in the last frame: each batch, the view it was drawn in, and the
/// images that cells were drawn by. Remembering takes time and memory. In perspective.
class Onlooker final : public AnyRenderer {
  public:
    explicit Onlooker(std::unique_ptr<AnyRenderer> renderer) : renderer_(std::move(renderer)) {}

    std::uint32_t upload(const AnySource& source) override { return renderer_->upload(source); }
    std::uint32_t share(const AnyRenderer& other, std::uint32_t id) override {
        return renderer_->share(*static_cast<const Onlooker&>(other).renderer_, id);
    }
    void release(std::uint32_t id) override { renderer_->release(id); }
    void begin_frame(const LocalView& view) override {
        outermost_ = local_ = view;
        batches_.clear();
        renderer_->begin_frame(view);
    }
    void set_view(const LocalView& view) override {
        local_ = view;
        renderer_->set_view(view);
    }
    void end_frame() override { renderer_->end_frame(); }
    void draw(std::uint32_t source, std::span<const Range> ranges) override {
        remember({.view = local_, .source = source, .ranges = {ranges.begin(), ranges.end()}});
        renderer_->draw(source, ranges);
    }
    void draw(std::span<const Face> faces) override {
        remember({.view = local_, .faces = {faces.begin(), faces.end()}});
        renderer_->draw(faces);
    }
    void draw(std::span<const Splat> splats) override {
        remember({.view = local_, .splats = {splats.begin(), splats.end()}});
        renderer_->draw(splats);
    }
    void draw(const PlacedStandIns& placed) override {
        Batch batch{.view = local_, .placed = placed};
        batch.words.assign(placed.words, placed.words + PlacedStandIns::stride * placed.word_count());
        remember(std::move(batch));
        renderer_->draw(placed);
    }
    void draw(std::span<const ImageQuad> quads) override {
        remember({.view = local_, .quads = {quads.begin(), quads.end()}});
        renderer_->draw(quads);
    }
    bool shapes_stand_ins() const override { return renderer_->shapes_stand_ins(); }
    float largest_splat_px() const override { return renderer_->largest_splat_px(); }
    bool deposits_primitives() const override { return renderer_->deposits_primitives(); }
    bool hidden(const Cell& cell, CellId id) override { return renderer_->hidden(cell, id); }
    void begin_image(const LocalView& view, float quad_depth, int samples) override {
        makes_image_ = true;
        renderer_->begin_image(view, quad_depth, samples);
    }
    std::uint32_t end_image() override {
        makes_image_ = false;
        return renderer_->end_image();
    }
    void begin_image(const LocalView& view, std::span<const ImageSlice> slices, int samples) override {
        makes_image_ = true;
        renderer_->begin_image(view, slices, samples);
    }
    void end_image(std::span<std::uint32_t> handles) override {
        makes_image_ = false;
        renderer_->end_image(handles);
    }
    void free_image(std::uint32_t image) override { renderer_->free_image(image); }
    std::size_t image_bytes(int width, int height) const override { return renderer_->image_bytes(width, height); }

    const Image& image() const override { return renderer_->image(); }
    const CoverageWork* work() const override { return renderer_->work(); }
    const CoverageWorkImage* work_map() const override { return renderer_->work_map(); }

    const Image* from_outside(const LocalView* from) override;

  private:
    /// What came in one call.
    struct Batch {
        LocalView view;
        std::uint32_t source = 0;
        std::vector<Range> ranges{};
        std::vector<Face> faces{};
        std::vector<Splat> splats{};
        std::vector<ImageQuad> quads{};
        PlacedStandIns placed{};
        std::vector<std::uint32_t> words{};  ///< of them
    };
    using Segment = std::array<glm::vec3, 2>;  ///< in outermost coordinates

    void remember(Batch batch) {
        if (!makes_image_) batches_.push_back(std::move(batch));
    }
    /// A point of another view's coordinates in those of the outermost.
    glm::vec3 outside(const LocalView& view, glm::vec3 p) const;
    std::array<glm::vec3, 4> corners(const LocalView& view, const ImageQuad& quad) const;
    /// The depth that nine images of ten are nearer than: one that stands for the horizon would make all else small. 0:
    /// there are none.
    float reach() const;
    LocalView outer_view(float reach) const;
    /// The source that they are drawn from, which is kept until the frame ends; none where there are no lines.
    std::optional<std::uint32_t> draw_lines(const LocalView& view, std::span<const Segment> segments, Rgba8 color);

    std::unique_ptr<AnyRenderer> renderer_;
    LocalView outermost_{View{}, {}, 1}, local_ = outermost_;
    std::vector<Batch> batches_;
    bool makes_image_ = false;
};

}  // namespace farfield::scenes
