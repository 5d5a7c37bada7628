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
/// renderer takes any order.
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
        if (placed_count_ + splat_count_ + face_count_ != 0) flush(source);
        if (law) in_order_ = true;
        if (range_count_ != 0 && !law) {
            Range& last = ranges_[range_count_ - 1];
            if (last.first + last.count == first && !last.law) {
                last.count += end - first;
                return;
            }
        }
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
                const A& placing = *static_cast<const A*>(queue.placed_policy_);
                const std::uint32_t* const words = queue.placed_.data();
                const std::size_t count = std::exchange(queue.placed_count_, 0);
                if constexpr (R::facts.shapes_stand_ins && detail::NamesPlaced<A>) {
                    if (queue.renderer_.shapes_stand_ins()) {
                        queue.stats_.splats += count;
                        return queue.renderer_.draw(placing.placed(words, count));
                    }
                }
                placing.draw_placed(words, count, *queue.placed_view_,
                                    [&](const Splat& splat) { queue.splats_[queue.splat_count_++] = splat; });
            };
        }
        policy.place(data, cell, placed_.data() + placed_count_);
        if (++placed_count_ == batch) flush(source);
    }

    template <class P>
    void flush(const Source<P>& source) {
        if (range_count_ != 0) {
            if constexpr (R::facts.order == VisitOrder::any) {
                if (!std::exchange(in_order_, false)) merge_ranges();
            }
            stats_.runs += range_count_;
            renderer_.draw(source, std::span<const Range>(ranges_.data(), std::exchange(range_count_, 0)));
        }
        if constexpr (R::facts.draws_splats) {
            if (placed_count_ != 0) {
                draw_placed_(*this);
                stats_.splats += splat_count_;
            }
            if (splat_count_ != 0) {
                renderer_.draw(std::span<const Splat>(splats_.data(), std::exchange(splat_count_, 0)));
            }
        }
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

    /// Cells come front to back, which tears neighbors in memory apart; the renderer does not mind their order.
    void merge_ranges() {
        const auto begin = ranges_.begin(), end = begin + std::ptrdiff_t(range_count_);
        std::sort(begin, end, [](Range a, Range b) { return a.first < b.first; });
        auto last = begin;
        for (auto r = begin + 1; r != end; ++r) {
            if (last->first + last->count == r->first) {
                last->count += r->count;
            } else {
                *++last = *r;
            }
        }
        range_count_ = std::size_t(last - begin) + 1;
    }

    R& renderer_;
    FrameStats& stats_;
    std::array<Range, batch> ranges_;
    std::array<Splat, batch> splats_;
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
