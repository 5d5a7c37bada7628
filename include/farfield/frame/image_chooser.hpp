// Chooses, before a frame is drawn, which cells are drawn by images and which of these are made anew: the UpdateCaches
// of Shade et al. 1996, section 2, with its holes closed.
//
// The paper decides bottom up and makes images on the way, most of which no frame uses: their parent gets one too. Here
// nothing is made before all is priced, and of cells one in another that pay the outermost gets the image. Every cell
// gets a price on every way through: what is drawn by an image, what is hidden, and what holds the viewer. Cells at the
// picture's edge are made whole, and are priced so.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <optional>
#include <type_traits>
#include <utility>
#include <vector>

#include "farfield/approximation.hpp"
#include "farfield/cost_model.hpp"
#include "farfield/frame/descent.hpp"
#include "farfield/frame/image_choice.hpp"
#include "farfield/frame/image_life.hpp"
#include "farfield/frame/kept_images.hpp"
#include "farfield/frame/subtree.hpp"
#include "farfield/geometry/area_law.hpp"
#include "farfield/image_cache_options.hpp"
#include "farfield/view/local_view.hpp"

namespace farfield::detail {

/// A descent's sink. `Maker` gets what is wanted: maker.draw_contents(hierarchy, primitives, view, path, subtree).
template <class Maker>
class ImageChooser {
  public:
    static constexpr bool keeps_images = true;

    ImageChooser(KeptImages& kept, const ImageCacheOptions& options, const ExpectedPath& path,
                 ImageChoice<Maker>& choice)
        : kept_(kept),
          options_(options),
          life_(options, path),
          wanted_(choice.wanted),
          renewals_(choice.renewals),
          open_(choice.open) {
        wanted_.clear();
        renewals_.clear();
        open_.clear();
    }

    /// What drawing the frame costs without making images, in the unit of the cost model.
    float price() const { return float(present_price_); }
    /// What making images costs in a frame as most are: each once in its life.
    float usual_making() const { return float(usual_making_); }
    /// No image is left of what was drawn before: as in the first frame, and after a jump.
    bool is_afresh() const { return good_images_ == 0; }

    void enter(const auto&) {}
    void leave(const auto&) {}
    void enter_instance(const auto&, std::uint32_t) {}
    void leave_instance(const auto&) {}
    template <class V>
    void run(const V& v, const Subtree& subtree, std::uint32_t first, std::uint32_t end, std::optional<AreaLaw>) {
        const float triangles_each = PrimitiveWithInstance<typename V::primitive_type>
                                         ? 1.0f
                                         : v.hierarchy.whole_work().triangles / float(v.hierarchy.item_count());
        const Work work{.triangles = float(end - first) * triangles_each, .cells = 1, .runs = 1};
        // Seen from anywhere, a third of a box's rectangle is about what all triangles in it take, each squarely.
        const float radius = length_of(subtree.cell.bounds_half);
        const float away = std::max(length_of(subtree.cell.bounds_center - v.view.eye), radius);
        const float side = v.view.pixels(1.15f * radius, away);
        add(double(price_of(v.hierarchy.cost_policy(), work, side * side / (3 * work.triangles))));
    }
    template <class V>
    void stand_in(const V& v, const Subtree& subtree) {
        const auto& h = v.hierarchy;
        Work work = work_of_stand_in(h.approximation_policy(), h.stand_ins()[subtree.stand_in]);
        work += {.cells = 1};
        add(double(h.cost_policy().cost(work)));
    }
    /// Nothing is drawn yet. What was hidden in the last frame is taken as hidden.
    template <class V>
    bool hidden(const V& v, const Subtree& subtree) {
        const KeptCell* cell = kept_.find({v.path, subtree.node});
        const bool is_hidden = cell != nullptr && cell->hidden_frame + 1 == kept_.frame();
        hidden_ += is_hidden;
        return is_hidden;
    }

    template <class V>
    CellDrawn begin_cell(const V& v, const Subtree& subtree) {
        const std::uint32_t index = kept_.index_of({v.path, subtree.node});
        KeptCell& cell = kept_.cell(index);
        // What an image of a larger cell showed until now was not hidden.
        const bool is_new = cell.seen_frame + 1 != kept_.frame() && (open_.empty() || open_.back().is_new);
        cell.seen_frame = kept_.frame();
        if (const CellImage* image = kept_.image_of(cell); image != nullptr && is_good(*image, v.view, options_)) {
            cell.drawn_frame = kept_.frame();
            const float drawing = price_of_drawing(v, *image);
            price_ += double(drawing);
            present_price_ += double(drawing);
            whole_price_ += double(std::max(image->whole_price, drawing));
            ++images_;
            ++good_images_;
            usual_making_ += double(image->making_price) / double(image->lives);
            if (is_soon_over(v, *image)) add_renewal(v, subtree, index, *image);
            return CellDrawn::by_image;
        }
        open_.push_back({index, price_, present_price_, whole_price_, usual_making_, images_, hidden_, wanted_.size(),
                         renewals_.size(), is_new});
        return CellDrawn::in_parts;
    }

    template <class V>
    void end_cell(const V& v, const Subtree& subtree) {
        const OpenCell open = open_.back();
        open_.pop_back();
        KeptCell& cell = kept_.cell(open.cell);
        // Also where it is chosen: its image may not be made in this frame, or be made from those below.
        // What is hidden below is found to be so again, where nothing is drawn whole.
        if (images_ != open.images || hidden_ != open.hidden) cell.parts_frame = kept_.frame();
        if (chooses(v, subtree, open)) images_ = open.images + 1;
    }

  private:
    /// Within the part of its life by which it may be made early. Motion decides, not age: whoever stands still needs
    /// no new image.
    template <class V>
    bool is_soon_over(const V& v, const CellImage& image) const {
        const auto early = std::uint32_t(options_.most_early * float(std::min(image.lives, ExpectedPath::farthest)));
        if (early == 0 || kept_.frame() - image.made_frame + early < image.lives) return false;
        return life_.is_over_after(early, image, v.view);
    }
    template <class V>
    void add_renewal(const V& v, const Subtree& subtree, std::uint32_t index, const CellImage& image) {
        const auto planned_from = [&](const LocalView& there) {
            return image_that_fits(there, subtree.cell.bounds_center, subtree.cell.bounds_half, image.slices);
        };
        const auto served = std::uint32_t(float(image.lives) / (1 + options_.most_ahead));
        const std::uint32_t ahead = image.is_of_images ? 0 : life_.frames_ahead(served, v.view, planned_from);
        const LocalView from = made_from(v.view, ahead);
        const std::optional<ImageRect> rect = fitting_rect(from, subtree.cell.bounds_center, subtree.cell.bounds_half);
        if (!rect) return;
        renewals_.push_back({.cell = index,
                             .hierarchy = &v.hierarchy,
                             .primitives = v.source.primitives.data(),
                             .primitive_count = v.source.primitives.size(),
                             .view = from,
                             .subtree = subtree,
                             .rect = *rect,
                             .slices = image.slices,
                             .whole_price = image.whole_price,
                             .making_price = image.making_price,
                             .lives = image.lives,
                             .is_ahead = ahead != 0,
                             .draw = &draw_wanted<V>});
    }

    void add(double price) {
        price_ += price;
        present_price_ += price;
        whole_price_ += price;
    }

    /// Slices are cropped: four of a tree have twice the texels of one.
    template <class V>
    static float texels_of(const V& v, const CellImage& image) {
        const glm::vec2 size =
            glm::vec2(length_of(image.across), length_of(image.down)) * v.view.focal_px * v.view.squeeze;
        return size.x * size.y * (1 + 0.375f * float(image.slices - 1));
    }
    template <class V>
    static float price_of_drawing(const V& v, const CellImage& image) {
        return v.hierarchy.cost_policy().cost(
            {.images = float(image.slices), .texels = texels_of(v, image), .cells = 1});
    }

    /// "amortizedCost < cost to draw contents" (UpdateNode). If so the cell is wanted, and nothing below it.
    template <class V>
    bool chooses(const V& v, const Subtree& subtree, const OpenCell& open) {
        const auto contents = float(price_ - open.price), whole = float(whole_price_ - open.whole_price),
                   present = float(present_price_ - open.present_price);
        const Cell& cell = subtree.cell;
        const LocalView& view = v.view;
        if (view.is_perspective && cell.bounds().contains(view.eye)) return false;
        if (kept_.cell(open.cell).refused_frame + 64 > kept_.frame() && kept_.cell(open.cell).refused_frame != 0)
            return false;
        // To decide costs as much as to draw a few.
        constexpr float deciding = 4;
        if (!(contents > deciding * v.hierarchy.cost_policy().cost({.images = 1}))) return false;
        const std::optional<ImageRect> rect = fitting_rect(view, cell.bounds_center, cell.bounds_half);
        if (!rect) return false;
        const float whole_price = whole / visible_part(view, *rect);
        // What is made of images below is good for half of the threshold, and is made from here.
        const auto of_images = [&](float making_it) { return 2 * (making_it - whole_price + present) < making_it; };
        float best = contents, making = 0;
        int slices = 0;
        ImageLife::Service served;
        // Slices are worth their texels only where fewer of them are soon wrong: all that more can save is making.
        for (int n = 1; n <= options_.slices; n *= 2) {
            const CellImage planned = planned_image(view, cell.bounds_center, cell.bounds_half, *rect, n);
            const float texels = texels_of(v, planned);
            const float drawing = price_of_drawing(v, planned);
            if (!(drawing < best)) break;
            const float making_it = whole_price * making_factor(n) +
                                    float(n) * price_of_making(v.hierarchy.cost_policy(), texels / float(n));
            // What no frame may make does not keep cells below from theirs. Most cells have no image that pays, and to
            // ask for the frame from which on it does is quicker than to find out how long it lives.
            if (making_it > options_.most_making) continue;
            const float longer = 1 + options_.most_ahead;
            if (!life_.may_serve(planned, view, making_it / (best - drawing) / longer)) continue;
            const auto planned_from = [&](const LocalView& there) {
                return image_that_fits(there, cell.bounds_center, cell.bounds_half, n);
            };
            const ImageLife::Service serves = n == 1 && of_images(making_it)
                                                  ? ImageLife::Service{0, 1 + life_.frames_served(planned, view)}
                                                  : life_.service(planned, view, planned_from);
            const float amortized = making_it / float(serves.lives) + drawing;
            if (!(amortized < best)) continue;
            best = amortized;
            making = making_it;
            served = serves;
            slices = n;
        }
        if (slices == 0) return false;
        const LocalView from = made_from(view, served.ahead);
        price_ = open.price + double(best);
        usual_making_ = open.usual_making + double(making) / double(served.lives);
        wanted_.erase(wanted_.begin() + std::ptrdiff_t(open.wanted), wanted_.end());
        renewals_.erase(renewals_.begin() + std::ptrdiff_t(open.renewals), renewals_.end());
        wanted_.push_back(
            {.cell = open.cell,
             .hierarchy = &v.hierarchy,
             .primitives = v.source.primitives.data(),
             .primitive_count = v.source.primitives.size(),
             .view = from,
             .subtree = subtree,
             .rect = served.ahead == 0 ? *rect : *fitting_rect(from, cell.bounds_center, cell.bounds_half),
             .slices = slices,
             .contents_price = present,
             .whole_price = whole_price,
             .making_price = making,
             .lives = served.lives,
             .is_new = open.is_new,
             .is_ahead = served.ahead != 0,
             .draw = &draw_wanted<V>});
        return true;
    }

    LocalView made_from(const LocalView& view, std::uint32_t ahead) const {
        return ahead == 0 ? view : view.moved(life_.way(ahead, view));
    }

    /// The part of a rectangle that lies in the picture; above 0.
    static float visible_part(const LocalView& view, const ImageRect& rect) {
        const auto overlap = [](int first, int size, int whole) {
            return float(std::max(std::min(first + size, whole) - std::max(first, 0), 1)) / float(size);
        };
        return overlap(rect.left, rect.width, view.part.whole_width) *
               overlap(rect.top, rect.height, view.part.whole_height);
    }
    /// What a nearer slice hides is drawn all the same, and what crosses two is drawn twice.
    static float making_factor(int slices) { return 1 + 0.0625f * float(slices - 1); }

    template <class V>
    static void draw_wanted(Maker& maker, const WantedImage<Maker>& wanted, const LocalView& image_view) {
        using P = typename V::primitive_type;
        const auto& h = *static_cast<const typename V::hierarchy_type*>(wanted.hierarchy);
        const auto primitives = span_at<P>(wanted.primitives, wanted.primitive_count);
        maker.draw_contents(h, primitives, image_view, maker.path_of(wanted.cell), wanted.subtree);
    }

    KeptImages& kept_;
    const ImageCacheOptions& options_;
    ImageLife life_;
    std::vector<WantedImage<Maker>>&wanted_, &renewals_;
    std::vector<OpenCell>& open_;
    /// Of what has been priced so far: with the images that are wanted, their making spread over their lives; as it
    /// would be drawn if none were made; and without any images.
    double price_ = 0, present_price_ = 0, whole_price_ = 0;
    double usual_making_ = 0;
    std::size_t images_ = 0, good_images_ = 0, hidden_ = 0;
};

}  // namespace farfield::detail
