// Makes images of cells and draws a frame with them: the CreateCache and Render of Shade et al. 1996, section 2.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <utility>
#include <vector>

#include "farfield/drawables.hpp"
#include "farfield/frame/descent.hpp"
#include "farfield/frame/draw_queue.hpp"
#include "farfield/frame/draw_with_images.hpp"
#include "farfield/frame/image_chooser.hpp"
#include "farfield/frame/instance_stack.hpp"
#include "farfield/frame/kept_images.hpp"
#include "farfield/frame/source_table.hpp"
#include "farfield/view.hpp"

namespace farfield::detail {

/// A viewer's own, with all that it keeps of images. Borrows the renderer and the table of sources.
template <class R>
class ImageMaker {
  public:
    ImageMaker(R& renderer, SourceTable<R>& sources)
        : renderer_(renderer), sources_(sources), queue_(renderer, stats_) {}
    ~ImageMaker() {
        if (sources_.has_renderer()) free_all();
    }
    ImageMaker(const ImageMaker&) = delete;
    ImageMaker& operator=(const ImageMaker&) = delete;

    KeptImages& kept() { return kept_; }
    void free_all() {
        kept_.forget_all([&](std::uint32_t handle) { renderer_.free_image(handle); });
    }

    /// Between the renderer's begin_frame and whatever is drawn: chooses, and makes what is wanted. `view` is the
    /// outermost hierarchy's. Returns how many were made.
    template <class H, class Span>
    std::size_t update(const H& hierarchy, const Span& primitives, const LocalView& view, const ExpectedPath& path,
                       InstanceStack& instances, bool deposits) {
        const ImageCacheOptions& options = hierarchy.approximation_policy().images();
        instances_ = &instances;
        deposits_ = deposits;
        options_ = &options;
        path_ = &path;
        kept_.begin_frame();
        kept_.end_fades(options.fade_frames, [&](std::uint32_t handle) { renderer_.free_image(handle); });
        stats_ = {};
        ImageChooser<ImageMaker> chooser(kept_, options, path, choice_);
        Descent<R, ImageChooser<ImageMaker>> descent(sources_, instances, stats_, chooser, deposits);
        descent.enter(hierarchy, primitives, view, 0);
        float overhead = options.most_overhead * chooser.price();
        float making = 0;
        std::size_t made = 0;
        for (const WantedImage<ImageMaker>& wanted : choice_.wanted) {
            const float more = std::max(0.0f, wanted.making_price - wanted.contents_price);
            const float after = making + wanted.making_price;
            if (made == options.most_made || more > overhead || after > options.most_making) continue;
            // What has just come into sight may be hidden, and then its image is of no use. Where there is much of it,
            // it is drawn first, which tells.
            const bool may_be_hidden = R::facts.answers_hidden && wanted.is_new && !chooser.is_afresh();
            if (may_be_hidden && after > 2 * chooser.usual_making()) continue;
            if (!make(wanted)) continue;
            overhead -= more;
            making += wanted.making_price;
            ++made;
        }
        // "Room" is what a frame makes less than it would if lives were spread evenly.
        const auto age = [&](const WantedImage<ImageMaker>& w) {
            return kept_.image_of(kept_.cell(w.cell))->made_frame;
        };
        const float usual = std::min(chooser.usual_making(), options.most_making);
        std::sort(choice_.renewals.begin(), choice_.renewals.end(),
                  [&](const auto& a, const auto& b) { return std::pair(age(a), a.cell) < std::pair(age(b), b.cell); });
        for (const WantedImage<ImageMaker>& wanted : choice_.renewals) {
            if (made == options.most_made || making + wanted.making_price > usual) continue;
            // What is still good is not given up for what has no room.
            if (kept_.bytes() + bytes_of(wanted) > options.budget_bytes || !make(wanted)) continue;
            making += wanted.making_price;
            ++made;
        }
        // All that there are may be due in one frame, and frames that make none do not allocate.
        if (choice_.renewals.capacity() < kept_.image_count()) choice_.renewals.reserve(2 * kept_.image_count());
        return made;
    }

    std::uint64_t path_of(std::uint32_t cell) { return kept_.cell(cell).id.path; }

    /// Draws a subtree, all of it, as the image's view sees it.
    template <class H, class Span>
    void draw_contents(const H& h, const Span& primitives, const LocalView& view, std::uint64_t path,
                       const Subtree& subtree) {
        queue_.begin_frame();
        DrawWithImages<R> sink(renderer_, queue_, kept_, *options_, of_images_);
        Descent<R, DrawWithImages<R>> descent(sources_, *instances_, stats_, sink, deposits_);
        descent.enter_at(h, primitives, view, path, subtree);
        queue_.replay();
    }

  private:
    std::uint64_t bytes_of(const WantedImage<ImageMaker>& wanted) const {
        return std::uint64_t(wanted.slices) *
               std::uint64_t(renderer_.image_bytes(wanted.rect.width, wanted.rect.height));
    }

    /// What an image may show of images of cells below. It lives half as long with them, or not that, so they have to
    /// save as much, and to be good for half of the way that it would have served on. In slices there are none: what a
    /// rectangle shows may lie in several. Nor are there in images from elsewhere, which would have to be good from
    /// here with twice the error.
    ImageOfImages of_images_below(const WantedImage<ImageMaker>& wanted) const {
        const glm::vec3 center = wanted.subtree.cell.bounds_center, half = wanted.subtree.cell.bounds_half;
        ImageOfImages of{.view = wanted.view, .low = center - half, .high = center + half};
        const float of_geometry = wanted.making_price,
                    of_images = of_geometry - wanted.whole_price + wanted.contents_price;
        of.may_be_drawn = wanted.slices == 1 && !wanted.is_ahead && 2 * of_images < of_geometry;
        const std::uint32_t frames = std::max(1u, std::min(wanted.lives, ExpectedPath::farthest) / 2);
        of.least_radius = std::max(length_of(path_->after(frames)), options_->most_speed * float(frames));
        return of;
    }

    /// "If the dimensions [fit] we redefine the viewing frustum so that it contains the entire node without changing
    /// the viewpoint or the view direction, and render the node."
    bool make(const WantedImage<ImageMaker>& wanted) {
        KeptCell& cell = kept_.cell(wanted.cell);
        const auto free_handle = [&](std::uint32_t handle) { renderer_.free_image(handle); };
        const std::uint64_t bytes = bytes_of(wanted);
        if (cell.image != KeptCell::no_image) {
            const bool was_seen = cell.drawn_frame + 1 >= kept_.frame();
            if (options_->fade_frames > 0 && was_seen && kept_.bytes() + bytes <= options_->budget_bytes) {
                kept_.fade(cell, free_handle);
            } else {
                kept_.forget(cell, free_handle);
            }
        }
        if (!kept_.make_room(bytes, options_->budget_bytes, free_handle)) return false;
        CellImage image = planned_image(wanted.view, wanted.subtree.cell.bounds_center, wanted.subtree.cell.bounds_half,
                                        wanted.rect, wanted.slices);
        const LocalView view =
            wanted.view.rectangle(wanted.rect.left, wanted.rect.top, wanted.rect.width, wanted.rect.height);
        ImageOfImages of_images = of_images_below(wanted);
        of_images_ = &of_images;
        const auto slices = std::size_t(image.slices);
        std::array<ImageSlice, ImageCacheOptions::most_slices> extents = image.extents;
        // Nothing in the box is left out for a rounding.
        extents[0].nearest = -std::numeric_limits<float>::infinity();
        extents[slices - 1].farthest = std::numeric_limits<float>::infinity();
        MadeSlices made(renderer_, {image.handles.data(), slices});
        if constexpr (R::facts.slices_images) {
            renderer_.begin_image(view, std::span<const ImageSlice>(extents.data(), slices), options_->samples);
            wanted.draw(*this, wanted, view);
            std::array<std::uint32_t, ImageCacheOptions::most_slices> handles{};
            renderer_.end_image(std::span<std::uint32_t>(handles.data(), slices));
            image.handles = handles;
        } else {
            for (std::size_t i = 0; i < slices; ++i) {
                const LocalView slice = slices == 1 ? view : view.between(extents[i].nearest, extents[i].farthest);
                renderer_.begin_image(slice, extents[i].depth, options_->samples);
                wanted.draw(*this, wanted, slice);
                image.handles[i] = renderer_.end_image();
                if (image.handles[i] == 0) break;
            }
        }
        if (!made.are_all()) {
            cell.refused_frame = kept_.frame();
            return false;
        }
        if (of_images.images != 0) {
            image.is_of_images = true;
            image.inherited_radius = of_images.inherited_radius / wanted.view.scale;
            image.inherited_sine = allowed_sine(wanted.view, *options_, 0.5f);
            enlarge_box(image, wanted.view, of_images.low, of_images.high);
        }
        image.bytes = bytes;
        image.whole_price = wanted.whole_price;
        image.making_price = wanted.making_price;
        image.made_frame = kept_.frame();
        image.lives = wanted.lives;
        set_safety_zone(image, wanted.view, *options_);
        kept_.keep(cell, image);
        made.release();
        cell.drawn_frame = kept_.frame();
        return true;
    }

    /// Frees what there is of an image if the rest fails, or whatever throws.
    class MadeSlices {
      public:
        MadeSlices(R& renderer, std::span<const std::uint32_t> handles) : renderer_(renderer), handles_(handles) {}
        ~MadeSlices() {
            for (const std::uint32_t handle : handles_) {
                if (handle != 0) renderer_.free_image(handle);
            }
        }
        MadeSlices(const MadeSlices&) = delete;
        MadeSlices& operator=(const MadeSlices&) = delete;
        bool are_all() const { return std::find(handles_.begin(), handles_.end(), 0u) == handles_.end(); }
        void release() { handles_ = {}; }

      private:
        R& renderer_;
        std::span<const std::uint32_t> handles_;
    };

    R& renderer_;
    SourceTable<R>& sources_;
    FrameStats stats_;  ///< nobody reads what choosing and making count
    DrawQueue<R> queue_;
    KeptImages kept_;
    ImageChoice<ImageMaker> choice_;
    const ImageCacheOptions* options_ = nullptr;
    InstanceStack* instances_ = nullptr;
    bool deposits_ = false;
    const ExpectedPath* path_ = nullptr;
    ImageOfImages* of_images_ = nullptr;  ///< of the image that is being made
};

}  // namespace farfield::detail
