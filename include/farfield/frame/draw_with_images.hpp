// This sink of a descent draws at once, and cells by images: the Render of Shade et al. 1996, section 2.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>

#include "farfield/approximation.hpp"
#include "farfield/drawables.hpp"
#include "farfield/frame/descent.hpp"
#include "farfield/frame/draw_now.hpp"
#include "farfield/frame/draw_queue.hpp"
#include "farfield/frame/kept_images.hpp"
#include "farfield/frame/safety_zone.hpp"
#include "farfield/frame/subtree.hpp"
#include "farfield/geometry/length.hpp"

namespace farfield::detail {

/// A descent's sink that draws at once, and cells by images where there are some. In a frame these are the ones chosen;
/// in an image, those of cells below that are good enough to be seen through two: their error is inherited, so it may
/// be half the threshold, and the image is good only inside the spheres in which theirs stays so. ("The safety zone of
/// an interior node is computed by [...] taking the intersection of this safety zone with the safety zones of the
/// children.")
template <class R>
class DrawWithImages : public DrawNow<R> {
  public:
    static constexpr bool keeps_images = true;

    DrawWithImages(R& renderer, DrawQueue<R>& queue, KeptImages& kept, const ImageCacheOptions& options,
                   bool is_in_image)
        : DrawNow<R>(renderer, queue, tint_),
          renderer_(renderer),
          queue_(queue),
          kept_(kept),
          options_(options),
          is_in_image_(is_in_image) {}

    template <class V>
    bool hidden(const V& v, const Subtree& subtree) {
        const bool is_hidden = DrawNow<R>::hidden(v, subtree);
        if (is_hidden && !is_in_image_) {
            if (KeptCell* cell = kept_.find({v.path, subtree.node})) cell->hidden_frame = kept_.frame();
        }
        return is_hidden;
    }
    template <class V>
    CellDrawn begin_cell(const V& v, const Subtree& subtree) {
        const KeptCell* cell = kept_.find({v.path, subtree.node});
        if (cell == nullptr) return CellDrawn::as_contents;  // cells above those with images are known
        const CellImage* image = kept_.image_of(*cell);
        if (image != nullptr && (is_in_image_ ? may_be_in_image(v, *image) : is_drawn(v, *cell, *image))) {
            queue_.flush(v.source);
            float shown = 1;
            if (const CellImage* old = is_in_image_ ? nullptr : kept_.fading_of(*cell)) {
                // Threshold or no, something old is better seen for a while than gone at once.
                if (is_good(*old, v.view, options_, options_.is_conservative ? 1.0f : 2.0f)) {
                    const auto frames = float(kept_.frame() - image->made_frame + 1);
                    shown = std::min(frames / float(options_.fade_frames + 1), 1.0f);
                    draw(*old, shown, 1);
                }
            }
            draw(*image, 0, shown);
            ++images_;
            return CellDrawn::by_image;
        }
        const bool has_parts = cell->parts_frame == kept_.frame() || cell->hidden_frame + 1 == kept_.frame();
        return has_parts ? CellDrawn::in_parts : CellDrawn::as_contents;
    }
    void end_cell(const auto&, const Subtree&) {}

    std::size_t images() const { return images_; }
    float inherited_radius() const { return inherited_radius_; }

  private:
    void draw(const CellImage& image, float first_part, float end_part) {
        for (int i = 0; i < image.slices; ++i) {
            ImageQuad& quad = quads_[std::size_t(i)];
            quad = image.quad(i);
            quad.first_part = first_part;
            quad.end_part = end_part;
        }
        renderer_.draw(std::span<const ImageQuad>(quads_.data(), std::size_t(image.slices)));
    }

    template <class V>
    bool is_drawn(const V& v, const KeptCell& cell, const CellImage& image) const {
        if (cell.drawn_frame == kept_.frame()) return true;
        // Nothing was chosen of what had been hidden.
        return cell.drawn_frame != 0 && cell.hidden_frame + 1 == kept_.frame() && is_good(image, v.view, options_);
    }
    template <class V>
    bool may_be_in_image(const V& v, const CellImage& image) {
        if (image.is_of_images || image.slices > 1) return false;
        const float half = sine_of_pixels(0.5f * options_.threshold_px, v.view);
        const float radius =
            options_.is_conservative ? conservative_radius(image.place, half) : safety_radius(image.place, half);
        const float left = radius - length_of(v.view.eye - image.place.eye);
        if (!(left > 0) || !is_good(image, v.view, options_, 0.5f)) return false;
        inherited_radius_ = std::min(inherited_radius_, left * v.view.scale);
        return true;
    }

    static constexpr AsTheyAre tint_{};
    R& renderer_;
    DrawQueue<R>& queue_;
    KeptImages& kept_;
    const ImageCacheOptions& options_;
    bool is_in_image_;
    std::size_t images_ = 0;
    float inherited_radius_ = std::numeric_limits<float>::infinity();  ///< world units
    std::array<ImageQuad, ImageCacheOptions::most_slices> quads_;
};

}  // namespace farfield::detail
