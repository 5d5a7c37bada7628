// Whatever a descent wants drawn waits here, and is handed to the renderer in batches.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "farfield/approximation.hpp"
#include "farfield/geometry/cell.hpp"
#include "farfield/renderer.hpp"
#include "farfield/view.hpp"
#include "farfield/view/local_view.hpp"

namespace farfield {

/// A viewer's own. Batches belong to one source and one view: flush() before either changes, or what waits lands
/// elsewhere, silently.
///
/// Runs and stand-ins keep their order among one another: otherwise the picture would depend on where batches end, and
/// with it on what else is drawn. For the same reason runs with a law are never made one: a renderer may deposit what
/// is small in a run before it draws the rest. Runs without a law are, and change places among themselves where the
/// renderer takes any order. Runs wait among placed stand-ins, which are looked at together and drawn in turns.
template <class R>
class DrawQueue {
  public:
    /// The renderer can only blend back to front: stand-ins are kept and replayed, reversed, after everything else.
    static constexpr bool defers = R::facts.far_field_order == VisitOrder::back_to_front;

    DrawQueue(R& renderer, FrameStats& stats) : renderer_(renderer), stats_(stats) {}

    /// Forgets what waits: an exception may have ended the last frame.
    void begin_frame() {
        range_count_ = splat_count_ = face_count_ = placed_count_ = 0;
        in_order_ = false;
        deferred_.clear();
        views_.clear();
    }

    /// Sets the view of all that follows.
    void set_view(const LocalView& view) {
        renderer_.set_view(view);
        if constexpr (defers) views_.push_back(view);
    }

    /// Largest side of a stand-in, in pixels, that may come as a splat; 0: none may.
    float splat_limit_px() const {
        if constexpr (R::facts.draws_splats && !defers) {
            return renderer_.largest_splat_px();
        } else {
            return 0;
        }
    }

    /// Positions [first, end).
    template <class P>
    void add_run(const Source<P>& source, std::uint32_t first, std::uint32_t end, std::optional<AreaLaw> law) {
        if (first == end) return;
        stats_.primitives += end - first;
        if (splat_count_ + face_count_ != 0) flush(source);
        if (law) in_order_ = true;
        if (range_count_ != 0 && !law && placed_before_range_[range_count_ - 1] == placed_count_) {
            Range& last = ranges_[range_count_ - 1];
            if (last.first + last.count == first && !last.law) {
                last.count += end - first;
                return;
            }
        }
        placed_before_range_[range_count_] = std::uint16_t(placed_count_);
        ranges_[range_count_++] = {first, end - first, law};
        if (range_count_ == batch) flush(source);
    }

    template <class P>
    void add(const Source<P>& source, const Face& face) {
        ++stats_.faces;
        if constexpr (defers) {
            deferred_.push_back({std::uint32_t(views_.size() - 1), face});
        } else {
            if (placed_count_ + splat_count_ != 0) flush(source);
            faces_[face_count_++] = face;
            if (face_count_ == batch) flush(source);
        }
    }

    template <class P>
    void add(const Source<P>& source, const Splat& splat) {
        ++stats_.splats;
        if (placed_count_ + face_count_ != 0) flush(source);
        splats_[splat_count_++] = splat;
        if (splat_count_ == batch) flush(source);
    }

    /// Keeps a stand-in until there are many (DrawsPlaced). The view, which is the last one set, and the policy are
    /// borrowed until the next flush.
    template <class P, class A, class Data>
    void add_placed(const Source<P>& source, const LocalView& view, const A& policy, const Data& data,
                    const Cell& cell) {
        static_assert(batch == detail::placed_stride);
        if (splat_count_ + face_count_ != 0 || (placed_count_ != 0 && placed_policy_ != &policy)) flush(source);
        if (placed_count_ == 0) {
            placed_policy_ = &policy;
            placed_view_ = &view;
            draw_placed_ = [](DrawQueue& queue) {
                static_cast<const A*>(queue.placed_policy_)
                    ->draw_placed(queue.placed_.data(), std::exchange(queue.placed_count_, 0), *queue.placed_view_,
                                  [&](const Splat& splat, std::size_t i) {
                                      queue.place_of_splat_[queue.splat_count_] = std::uint16_t(i);
                                      queue.splats_[queue.splat_count_++] = splat;
                                  });
            };
        }
        policy.place(data, cell, placed_.data() + placed_count_);
        if (++placed_count_ == batch) flush(source);
    }

    template <class P>
    void flush(const Source<P>& source) {
        std::size_t next_range = 0, next_splat = 0;
        if constexpr (R::facts.draws_splats) {
            if (placed_count_ != 0) {
                draw_placed_(*this);
                stats_.splats += splat_count_;
                while (next_range < range_count_) {
                    const std::uint16_t before = placed_before_range_[next_range];
                    std::size_t end_splat = next_splat, end_range = next_range + 1;
                    while (end_splat < splat_count_ && place_of_splat_[end_splat] < before) ++end_splat;
                    while (end_range < range_count_ && placed_before_range_[end_range] == before) ++end_range;
                    draw_splats(std::exchange(next_splat, end_splat), end_splat);
                    draw_ranges(source, std::exchange(next_range, end_range), end_range);
                }
            }
        }
        draw_ranges(source, next_range, range_count_);
        range_count_ = 0;
        in_order_ = false;
        if constexpr (R::facts.draws_splats) draw_splats(next_splat, std::exchange(splat_count_, 0));
        if constexpr (R::facts.draws_faces) {
            if (face_count_ != 0) renderer_.draw(std::span<const Face>(faces_.data(), std::exchange(face_count_, 0)));
        }
    }

    /// After the last flush.
    void replay() {
        if constexpr (defers && R::facts.draws_faces) {
            for (std::size_t end = deferred_.size(); end > 0;) {
                std::size_t count = 0;
                const std::uint32_t view = deferred_[end - 1].view;
                while (end > 0 && deferred_[end - 1].view == view && count < batch) {
                    faces_[count++] = deferred_[--end].face;
                }
                renderer_.set_view(views_[view]);
                renderer_.draw(std::span<const Face>(faces_.data(), count));
            }
        }
    }

  private:
    static constexpr std::size_t batch = 256;

    struct Deferred {
        std::uint32_t view;
        Face face;
    };

    template <class P>
    void draw_ranges(const Source<P>& source, std::size_t begin, std::size_t end) {
        if (begin == end) return;
        if constexpr (R::facts.order == VisitOrder::any) {
            if (!in_order_) end = merge_ranges(begin, end);
        }
        stats_.runs += end - begin;
        renderer_.draw(source, std::span<const Range>(ranges_.data() + begin, end - begin));
    }
    void draw_splats(std::size_t begin, std::size_t end) {
        if (begin != end) renderer_.draw(std::span<const Splat>(splats_.data() + begin, end - begin));
    }

    /// Cells come front to back, which tears neighbors in memory apart; the renderer does not mind their order. Returns
    /// where the merged ranges end.
    std::size_t merge_ranges(std::size_t first, std::size_t last_one) {
        const auto begin = ranges_.begin() + std::ptrdiff_t(first), end = ranges_.begin() + std::ptrdiff_t(last_one);
        std::sort(begin, end, [](Range a, Range b) { return a.first < b.first; });
        auto last = begin;
        for (auto r = begin + 1; r != end; ++r) {
            if (last->first + last->count == r->first) {
                last->count += r->count;
            } else {
                *++last = *r;
            }
        }
        return std::size_t(last - ranges_.begin()) + 1;
    }

    R& renderer_;
    FrameStats& stats_;
    std::array<Range, batch> ranges_;
    std::array<std::uint16_t, batch> placed_before_range_;  ///< how many stand-ins were placed before each range
    std::array<Splat, batch> splats_;
    std::array<std::uint16_t, batch> place_of_splat_;  ///< which of those that were placed it is, if any was
    std::array<Face, batch> faces_;
    std::array<std::uint32_t, batch * detail::most_words_placed> placed_{};  ///< word by word
    const void* placed_policy_ = nullptr;                                    ///< the approximation that placed them
    const LocalView* placed_view_ = nullptr;
    void (*draw_placed_)(DrawQueue&) = nullptr;
    std::size_t placed_count_ = 0;
    std::size_t range_count_ = 0, splat_count_ = 0, face_count_ = 0;
    bool in_order_ = false;  ///< a range that waits has a law
    std::vector<Deferred> deferred_;
    std::vector<LocalView> views_;
};

}  // namespace farfield
