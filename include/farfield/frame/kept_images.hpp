// What a viewer keeps of cells from frame to frame: their images, and what is known of them (Shade et al. 1996, section
// 2). It is keyed by the path of instances and the node, and never goes into a hierarchy.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "farfield/approximation.hpp"
#include "farfield/drawables.hpp"
#include "farfield/frame/safety_zone.hpp"
#include "farfield/geometry/length.hpp"
#include "farfield/geometry/mixed.hpp"
#include "farfield/view/local_view.hpp"

namespace farfield::detail {

/// A rectangle of the whole picture's pixels, possibly beyond it.
struct ImageRect {
    int left = 0, top = 0, width = 0, height = 0;
};

/// An image of a cell: one rectangle a depth slice, front to back.
struct CellImage {
    ImagePlace place;  ///< with the depths of the slice asked for last
    int slices = 0;
    std::array<std::uint32_t, ImageCacheOptions::most_slices> handles{};
    std::array<ImageSlice, ImageCacheOptions::most_slices> extents{};  ///< as far as the box reaches
    glm::vec3 corner{0}, across{0}, down{0};  ///< from the eye, at depth 1; in a parallel view as they are
    float pixels_a_unit = 1;                  ///< at the box's center
    /// Seen from within this radius of where it was made, nothing in it subtends a larger angle than one of this sine:
    /// the paper's safety zone, which is quick to ask.
    float safe_radius = 0, safe_sine = 0;
    std::uint64_t bytes = 0;
    float whole_price = 0;   ///< of drawing what it shows, all of it
    float making_price = 0;  ///< of making it, that included
    std::uint32_t made_frame = 0;
    std::uint32_t lives = 1;  ///< frames that it was made for
    /// What it shows is partly images of cells below: it is good inside this sphere, and for half the threshold.
    float inherited_radius = std::numeric_limits<float>::infinity();
    bool is_of_images = false;

    ImagePlace slice(int i) const {
        ImagePlace p = place;
        p.depth = extents[std::size_t(i)].depth;
        p.nearest = extents[std::size_t(i)].nearest;
        p.farthest = extents[std::size_t(i)].farthest;
        p.is_slice = slices > 1;
        return p;
    }
    ImageQuad quad(int i) const {
        const float depth = extents[std::size_t(i)].depth;
        if (!place.is_perspective)
            return {handles[std::size_t(i)], place.eye + place.forward * depth + corner, across, down};
        return {handles[std::size_t(i)], place.eye + corner * depth, across * depth, down * depth};
    }
};

/// The pixels that a cell's contents may touch, some more included ("an axis-aligned rectangle that is guaranteed to
/// contain the image of the node's contents"). None if it reaches behind the viewer or past the near plane.
inline std::optional<ImageRect> image_rect(const LocalView& view, glm::vec3 center, glm::vec3 half) {
    glm::vec2 low(std::numeric_limits<float>::infinity()), high = -low;
    const glm::vec2 focal = view.focal_px * view.squeeze;
    for (unsigned i = 0; i < 8; ++i) {
        const glm::vec3 p =
            center + half * glm::vec3((i & 1) ? 1 : -1, (i & 2) ? 1 : -1, (i & 4) ? 1 : -1) - view.anchor;
        const float depth = glm::dot(p, view.forward) + view.anchor_depth;
        if (!(depth > view.near_depth) || !(depth < view.far_depth)) return {};
        const glm::vec2 at =
            focal * glm::vec2(glm::dot(p, view.right), -glm::dot(p, view.up)) / (view.is_perspective ? depth : 1.0f);
        low = glm::min(low, at);
        high = glm::max(high, at);
    }
    constexpr float most = 8192;
    if (!(low.x > -most && low.y > -most && high.x < most && high.y < most)) return {};
    const glm::dvec2 size(view.part.whole_width, view.part.whole_height);
    const glm::dvec2 axis = size * 0.5 * (1.0 + view.whole_off_center * glm::dvec2(-1, 1));
    const double margin = 1 + std::ceil(double(view.reach_px));
    const glm::dvec2 first = glm::floor(glm::dvec2(low) + axis) - margin,
                     end = glm::ceil(glm::dvec2(high) + axis) + margin;
    return ImageRect{int(first.x), int(first.y), int(end.x - first.x), int(end.y - first.y)};
}

/// The image that a view would make of a box, without handles.
inline CellImage planned_image(const LocalView& view, glm::vec3 center, glm::vec3 half, const ImageRect& rect,
                               int slices) {
    CellImage image;
    image.place = {.eye = view.eye,
                   .forward = view.forward,
                   .center = center,
                   .half = half,
                   .is_perspective = view.is_perspective};
    const float middle = view.depth(center), reach = glm::dot(glm::abs(view.forward), half);
    const float nearest = middle - reach, farthest = middle + reach;
    image.slices = slices;
    // Parallax goes with the difference of inverse depths, so slices are even in those, and each rectangle lies in the
    // middle. Slices overlap by an eighth. A single one lies "at constant depth through the center of the node's
    // bounding box".
    const auto between = [&](float part) {
        if (!view.is_perspective) return nearest + (farthest - nearest) * part;
        return 1 / (1 / nearest + (1 / farthest - 1 / nearest) * part);
    };
    for (int i = 0; i < slices; ++i) {
        constexpr float overlap = 0.0625f;
        const auto number = float(i), count = float(slices);
        image.extents[std::size_t(i)] = {slices == 1 ? middle : between((number + 0.5f) / count),
                                         i == 0 ? nearest : between((number - overlap) / count),
                                         i + 1 == slices ? farthest : between((number + 1 + overlap) / count)};
    }
    const glm::dvec2 size(view.part.whole_width, view.part.whole_height);
    const glm::dvec2 axis = size * 0.5 * (1.0 + view.whole_off_center * glm::dvec2(-1, 1));
    const glm::vec2 unit = 1.0f / (view.focal_px * view.squeeze);
    const glm::vec2 upper_left = glm::vec2(glm::dvec2(rect.left, rect.top) - axis) * unit;
    image.corner = view.right * upper_left.x - view.up * upper_left.y;
    if (view.is_perspective) image.corner += view.forward;
    image.across = view.right * (float(rect.width) * unit.x);
    image.down = -view.up * (float(rect.height) * unit.y);
    image.pixels_a_unit = view.pixels(1, length_of(center - view.eye));
    return image;
}

/// The sine of the angle that displaces something by `part` of the threshold.
inline float allowed_sine(const LocalView& view, const ImageCacheOptions& options, float part) {
    const float pixels = options.threshold_px * part;
    return options.is_conservative ? sine_of_pixels_anywhere(pixels, view) : sine_of_pixels(pixels, view);
}
/// Sets the zone in which the image is good for `part` of the threshold.
inline void set_safety_zone(CellImage& image, const LocalView& view, const ImageCacheOptions& options) {
    image.safe_sine = allowed_sine(view, options, image.is_of_images ? 0.5f : 1.0f);
    image.safe_radius = std::numeric_limits<float>::infinity();
    for (int i = 0; i < image.slices; i += std::max(1, image.slices - 1)) {
        const ImagePlace place = image.slice(i);
        image.safe_radius =
            std::min(image.safe_radius, options.is_conservative ? conservative_radius(place, image.safe_sine)
                                                                : safety_radius(place, image.safe_sine));
    }
}

/// Whether an image may be drawn in a view in place of what it shows, with its error at most `part` of the threshold.
inline bool is_good(const CellImage& image, const LocalView& view, const ImageCacheOptions& options, float part = 1) {
    const glm::vec3 from_center = glm::abs(view.eye - image.place.center);
    // "Geometry is always drawn if the viewpoint is inside the node."
    if (view.is_perspective && glm::all(glm::lessThanEqual(from_center, image.place.half))) return false;
    const float now = view.pixels(1, length_of(image.place.center - view.eye));
    if (!(now <= image.pixels_a_unit * options.most_magnified && now * options.most_minified >= image.pixels_a_unit))
        return false;
    if (!(length_of(view.eye - image.place.eye) <= image.inherited_radius)) return false;
    if (image.is_of_images) part *= 0.5f;
    const bool is_safe = view.is_perspective && image.safe_sine > 0 &&
                         length_of(view.eye - image.place.eye) <= image.safe_radius &&
                         image.safe_sine <= allowed_sine(view, options, part);
    // Slices between the first and the last are displaced less than one of these: see planned_image().
    for (int i = 0; i < image.slices; i += std::max(1, image.slices - 1)) {
        const ImageQuad quad = image.quad(i);
        for (const glm::vec3& p :
             {quad.corner, quad.corner + quad.across, quad.corner + quad.down, quad.corner + quad.across + quad.down}) {
            if (!(view.depth(p) > view.near_depth)) return false;
        }
        if (is_safe) continue;
        const ImagePlace slice = image.slice(i);
        const float displaced =
            options.is_conservative ? displacement_bound_px(slice, view) : displacement_px(slice, view);
        if (!(displaced <= options.threshold_px * part)) return false;
    }
    return true;
}

/// What is known of a cell that may have an image.
struct KeptCell {
    static constexpr std::uint32_t no_image = std::numeric_limits<std::uint32_t>::max();

    CellId id;
    std::uint32_t image = no_image;   ///< index into images
    std::uint32_t fading = no_image;  ///< the one that was renewed, and is still seen in part
    std::uint32_t seen_frame = 0;     ///< it was looked at last
    std::uint32_t drawn_frame = 0;    ///< its image is drawn in
    std::uint32_t parts_frame = 0;    ///< images of cells below are drawn in
    std::uint32_t hidden_frame = 0;   ///< the renderer said that it is hidden
    std::uint32_t refused_frame = 0;  ///< the renderer did not make an image
};

/// Cells and images by index. References stay good until the next cell is added.
class KeptImages {
  public:
    std::uint32_t frame() const { return frame_; }
    std::uint64_t bytes() const { return bytes_; }
    std::size_t image_count() const { return images_.size() - free_.size(); }

    /// Cells not looked at for long, and without an image, are forgotten where there have come to be many.
    void begin_frame() {
        ++frame_;
        order_.clear();
        is_ordered_ = false;
        if (cells_.size() < sweep_at_) return;
        std::erase_if(cells_, [&](const KeptCell& cell) {
            return cell.image == KeptCell::no_image && cell.fading == KeptCell::no_image &&
                   cell.seen_frame + long_unseen < frame_;
        });
        sweep_at_ = std::max<std::size_t>(least_cells, 2 * cells_.size());
        index_all(slots_.size());
    }

    KeptCell* find(CellId id) {
        // A cell is asked for again at once: whether it is hidden, then how it is drawn.
        if (last_ < cells_.size() && cells_[last_].id.node == id.node && cells_[last_].id.path == id.path)
            return &cells_[last_];
        if (slots_.empty()) return nullptr;
        for (std::size_t at = hash(id) & (slots_.size() - 1);; at = (at + 1) & (slots_.size() - 1)) {
            if (slots_[at] == 0) return nullptr;
            KeptCell& cell = cells_[slots_[at] - 1];
            if (cell.id.node != id.node || cell.id.path != id.path) continue;
            last_ = slots_[at] - 1;
            return &cell;
        }
    }
    /// Adds the cell if it is not there.
    std::uint32_t index_of(CellId id) {
        if (const KeptCell* cell = find(id)) return std::uint32_t(cell - cells_.data());
        cells_.push_back({.id = id});
        if (2 * cells_.size() > slots_.size()) {
            index_all(std::max<std::size_t>(256, 2 * slots_.size()));
        } else {
            index(std::uint32_t(cells_.size()));
        }
        return std::uint32_t(cells_.size() - 1);
    }
    KeptCell& cell(std::uint32_t index) { return cells_[index]; }
    CellImage* image_of(const KeptCell& cell) {
        return cell.image == KeptCell::no_image ? nullptr : &images_[cell.image];
    }
    CellImage* fading_of(const KeptCell& cell) {
        return cell.fading == KeptCell::no_image ? nullptr : &images_[cell.fading];
    }

    /// Frees images that were not drawn in this frame or the last one, those unseen for longest first, until so many
    /// more bytes fit into the budget. False if they do not: what is in use is never freed for something else, so that
    /// images of a working set larger than the budget do not drive out one another.
    template <class Free>
    bool make_room(std::uint64_t bytes, std::uint64_t budget, Free&& free_handle) {
        if (bytes > budget) return false;
        while (bytes_ + bytes > budget) {
            if (!is_ordered_) order_unused();
            if (order_.empty()) return false;
            KeptCell& cell = cells_[order_.back()];
            order_.pop_back();
            if (cell.image != KeptCell::no_image && cell.drawn_frame + 1 < frame_) forget(cell, free_handle);
        }
        return true;
    }
    template <class Free>
    void forget(KeptCell& cell, Free&& free_handle) {
        release(cell.image, free_handle);
        forget_fading(cell, free_handle);
    }
    template <class Free>
    void forget_fading(KeptCell& cell, Free&& free_handle) {
        if (cell.fading == KeptCell::no_image) return;
        release(cell.fading, free_handle);
        --fading_;
    }
    /// The image is kept for as long as it fades; the cell has none until it gets a new one.
    template <class Free>
    void fade(KeptCell& cell, Free&& free_handle) {
        forget_fading(cell, free_handle);
        cell.fading = std::exchange(cell.image, KeptCell::no_image);
        ++fading_;
    }
    /// Forgets images whose successors are so many frames old.
    template <class Free>
    void end_fades(std::uint32_t frames, Free&& free_handle) {
        if (fading_ == 0) return;
        for (KeptCell& cell : cells_) {
            if (cell.fading == KeptCell::no_image) continue;
            const CellImage* image = image_of(cell);
            if (image == nullptr || frame_ - image->made_frame >= frames) forget_fading(cell, free_handle);
        }
    }
    template <class Free>
    void forget_all(Free&& free_handle) {
        for (KeptCell& cell : cells_) {
            if (cell.image != KeptCell::no_image) forget(cell, free_handle);
            forget_fading(cell, free_handle);
        }
    }
    void keep(KeptCell& cell, const CellImage& image) {
        if (free_.empty()) {
            free_.reserve(images_.size() + 1);  // freeing never fails
            images_.push_back(image);
            cell.image = std::uint32_t(images_.size() - 1);
        } else {
            cell.image = free_.back();
            free_.pop_back();
            images_[cell.image] = image;
        }
        bytes_ += image.bytes;
    }

  private:
    template <class Free>
    void release(std::uint32_t& index, Free& free_handle) {
        CellImage& image = images_[index];
        for (int i = 0; i < image.slices; ++i) free_handle(image.handles[std::size_t(i)]);
        bytes_ -= image.bytes;
        free_.push_back(index);
        image.slices = 0;
        index = KeptCell::no_image;
    }

    static constexpr std::uint32_t long_unseen = 64;
    static constexpr std::size_t least_cells = 4096;

    static std::size_t hash(CellId id) { return std::size_t(mixed(id.path, id.node + 1)); }

    void index(std::uint32_t number) {
        std::size_t at = hash(cells_[number - 1].id) & (slots_.size() - 1);
        while (slots_[at] != 0) at = (at + 1) & (slots_.size() - 1);
        slots_[at] = number;
    }
    void index_all(std::size_t size) {
        slots_.assign(size, 0);
        for (std::uint32_t i = 1; i <= cells_.size(); ++i) index(i);
    }
    void order_unused() {
        is_ordered_ = true;
        for (std::uint32_t i = 0; i < cells_.size(); ++i) {
            if (cells_[i].image != KeptCell::no_image && cells_[i].drawn_frame + 1 < frame_) order_.push_back(i);
        }
        std::sort(order_.begin(), order_.end(), [&](std::uint32_t a, std::uint32_t b) {
            return cells_[a].drawn_frame != cells_[b].drawn_frame ? cells_[a].drawn_frame > cells_[b].drawn_frame
                                                                  : a > b;
        });
    }

    std::uint32_t frame_ = 1;
    std::uint64_t bytes_ = 0;
    std::uint32_t last_ = 0;  ///< cell that was found last
    std::size_t fading_ = 0;  ///< images that fade
    std::size_t sweep_at_ = least_cells;
    std::vector<KeptCell> cells_;
    std::vector<std::uint32_t> slots_;  ///< index into cells_ and one more; 0: free. Linear probing
    std::vector<CellImage> images_;
    std::vector<std::uint32_t> free_;   ///< of images_
    std::vector<std::uint32_t> order_;  ///< cells whose images may be freed, the first to go last
    bool is_ordered_ = false;
};

}  // namespace farfield::detail
