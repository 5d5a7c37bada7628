// What a viewer keeps of cells from frame to frame: their images, and what is known of them (Shade et al. 1996, section
// 2). It is keyed by the path of instances and the node, and never goes into a hierarchy.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

#include "farfield/drawables.hpp"
#include "farfield/frame/cell_image.hpp"
#include "farfield/geometry/mixed.hpp"

namespace farfield::detail {

/// What is known of a cell that may have an image.
struct KeptCell {
    static constexpr std::uint32_t no_image = std::numeric_limits<std::uint32_t>::max();

    CellId id;
    std::uint32_t image = no_image;   ///< index into images
    std::uint32_t fading = no_image;  ///< the one that was renewed, and is still seen in part
    std::uint32_t seen_frame = 0;     ///< it was looked at last
    std::uint32_t drawn_frame = 0;    ///< its image is drawn in
    std::uint32_t parts_frame = 0;    ///< images of cells below are drawn in, or some are hidden
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
