// This sink of a descent draws at once, and cells by images: the Render of Shade et al. 1996, section 2.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <limits>
#include <span>

#include "farfield/drawables.hpp"
#include "farfield/frame/descent.hpp"
#include "farfield/frame/draw_now.hpp"
#include "farfield/frame/draw_queue.hpp"
#include "farfield/frame/kept_images.hpp"
#include "farfield/frame/safety_zone.hpp"
#include "farfield/frame/subtree.hpp"
#include "farfield/geometry/length.hpp"
#include "farfield/image_cache_options.hpp"
#include "farfield/view/local_view.hpp"

namespace farfield::detail {

/// What an image that is being made may show of images of cells below.
struct ImageOfImages {
    const LocalView& view;      ///< of the cell that the image is made of
    float least_radius = 0;     ///< world units, that others have to be good for from there
    bool may_be_drawn = false;  ///< none is
    glm::vec3 low{0}, high{0};  ///< in the cell's coordinates: the box of it, and then of all rectangles shown as well
    std::size_t images = 0;     ///< that were drawn
    float inherited_radius = std::numeric_limits<float>::infinity();  ///< world units: all of them are good within it
};

/// A descent's sink that draws at once, and cells by images where there are some. In a frame these are the ones chosen;
/// in an image, those of cells below that are good enough to be seen through two. What one of these shows at a~ instead
/// of at a, the image shows at a~~. Displacements add up, and each may be half the threshold: the one from a to a~
/// inside the spheres in which those below stay so good, which the image's zone is intersected with ("The safety zone
/// of an interior node is computed by [...] taking the intersection of this safety zone with the safety zones of the
/// children."); the one from a~ to a~~ by the image's own zone, for which a~ has to lie in its box, so that the box is
/// made to hold the rectangles shown.
template <class R>
class DrawWithImages : public DrawNow<R> {
  public:
    static constexpr bool keeps_images = true;

    /// `image` is what is drawn into; null: the frame.
    DrawWithImages(R& renderer, DrawQueue<R>& queue, KeptImages& kept, const ImageCacheOptions& options,
                   ImageOfImages* image = nullptr)
        : DrawNow<R>(renderer, queue, tint_),
          renderer_(renderer),
          queue_(queue),
          kept_(kept),
          options_(options),
          image_(image) {}

    template <class V>
    bool hidden(const V& v, const Subtree& subtree) {
        const bool is_hidden = DrawNow<R>::hidden(v, subtree);
        if (is_hidden && image_ == nullptr) {
            if (KeptCell* cell = kept_.find({v.path, subtree.node})) cell->hidden_frame = kept_.frame();
        }
        return is_hidden;
    }
    template <class V>
    CellDrawn begin_cell(const V& v, const Subtree& subtree) {
        const KeptCell* cell = kept_.find({v.path, subtree.node});
        if (cell == nullptr) return CellDrawn::as_contents;  // cells above those with images are known
        const CellImage* image = kept_.image_of(*cell);
        if (image != nullptr && image_ != nullptr && may_be_in_image(v, *image)) {
            queue_.flush(v.source);
            add_rectangles(v.view, *image);
            draw(*image, 0, 1);
            ++image_->images;
            return CellDrawn::by_image;
        }
        if (image != nullptr && image_ == nullptr && is_drawn(v, *cell, *image)) {
            queue_.flush(v.source);
            float shown = 1;
            if (const CellImage* old = kept_.fading_of(*cell)) {
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
        if (image_ != nullptr && !image_->may_be_drawn) return CellDrawn::as_contents;
        const bool has_parts = cell->parts_frame == kept_.frame() || cell->hidden_frame + 1 == kept_.frame();
        return has_parts ? CellDrawn::in_parts : CellDrawn::as_contents;
    }
    void end_cell(const auto&, const Subtree&) {}

    /// Drawn in the frame.
    std::size_t images() const { return images_; }

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
        if (!image_->may_be_drawn || image.is_of_images || !v.view.is_perspective) return false;
        if (!is_good(image, v.view, options_, 0.5f)) return false;
        const float radius = safe_radius_of(image, allowed_sine(v.view, options_, 0.5f), options_.is_conservative);
        const float left = (radius - length_of(v.view.eye - image.place.eye)) * v.view.scale;
        if (!(left > 0 && left >= image_->least_radius)) return false;
        image_->inherited_radius = std::min(image_->inherited_radius, left);
        return true;
    }
    /// Both views have one eye and one direction.
    void add_rectangles(const LocalView& view, const CellImage& image) {
        const LocalView& outer = image_->view;
        for (int i = 0; i < image.slices; ++i) {
            const ImageQuad quad = image.quad(i);
            for (const glm::vec3& p : {quad.corner, quad.corner + quad.across, quad.corner + quad.down,
                                       quad.corner + quad.across + quad.down}) {
                const glm::vec3 d = (p - view.eye) * (view.scale / outer.scale);
                const glm::vec3 at = outer.eye + outer.right * glm::dot(d, view.right) +
                                     outer.up * glm::dot(d, view.up) + outer.forward * glm::dot(d, view.forward);
                image_->low = glm::min(image_->low, at);
                image_->high = glm::max(image_->high, at);
            }
        }
    }

    static constexpr AsTheyAre tint_{};
    R& renderer_;
    DrawQueue<R>& queue_;
    KeptImages& kept_;
    const ImageCacheOptions& options_;
    ImageOfImages* image_;
    std::size_t images_ = 0;
    std::array<ImageQuad, ImageCacheOptions::most_slices> quads_;
};

}  // namespace farfield::detail
