// One that looks at pages: a viewer, or whoever picks.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "farfield/paging/page_cache.hpp"
#include "farfield/paging/page_demand.hpp"
#include "farfield/paging/page_slots.hpp"
#include "farfield/paging/wanted_pages.hpp"

namespace farfield::detail {

/// Not to be used by two threads at once.
class PageUser {
  public:
    explicit PageUser(std::shared_ptr<PageCache> cache)
        : cache_(std::move(cache)),
          known_(cache_->page_slots().slot_count()),
          asking_(cache_->places().page_count),
          entered_(cache_->places().page_count) {
        cache_->add(known_);
    }
    ~PageUser() { cache_->remove(known_); }
    PageUser(const PageUser&) = delete;
    PageUser& operator=(const PageUser&) = delete;

    PageCache& cache() const { return *cache_; }

    void begin_frame() {
        frame_ = cache_->page_slots().begin(known_.visits);
        asking_.begin(frame_);
    }
    /// What was not found replaces what the frame before wanted.
    void end_frame() {
        PageSlots::end(known_.visits);
        frame_ = 0;
        cache_->want(known_, asking_.in_order());
    }
    /// As if it had never looked: its pages are no longer in use, though it may look again.
    void forget() { PageSlots::forget(known_.visits); }
    bool is_in_frame() const { return frame_ != 0; }
    /// The slot of a page, which stays until the frame ends; PageSlots::none, and it is asked for.
    std::uint32_t find(std::uint32_t page, float weight) {
        weight = ordered(weight);
        const std::uint32_t slot = cache_->page_slots().find(page, known_.visits, weight);
        if (slot == PageSlots::none) asking_.ask(page, weight);
        return slot;
    }
    /// The same for what later frames may want: the slot counts as used only a little, and what is missing is
    /// asked for when nothing else is.
    std::uint32_t expect(std::uint32_t page, float weight) { return find(page, when_expected(weight)); }
    /// Loads it now, if there is room.
    std::uint32_t find_or_wait(std::uint32_t page, float weight) {
        weight = ordered(weight);
        const std::uint32_t slot = cache_->page_slots().find(page, known_.visits, weight);
        if (slot != PageSlots::none) return slot;
        cache_->load_now({weight, page}, known_);
        return find(page, weight);
    }
    /// A weight that is no larger than that of the page by which a frame has come, which is in `slot`: else that page
    /// could go first, and nothing would lead to this one, which counts more.
    float within(std::uint32_t slot, float weight) const {
        return std::min(ordered(weight), PageSlots::weight_of(slot, known_.visits));
    }
    /// Whether a frame may enter one more of a page's `units`. In a file that was built each is entered once, or
    /// twice if it is expected too. A forged one could lead to the same unit by many ways, and those below it by
    /// many times as many, which is not to be seen by looking at any one of its pages.
    bool may_enter(std::uint32_t page, std::uint32_t units) {
        Entered& entered = entered_[page];
        if (entered.frame != frame_) entered = {frame_, 0};
        return entered.count++ < 2 * units;
    }

    /// Without what has no order: a cell without extent errs by 0, which may be divided by a tolerance of 0.
    static float ordered(float weight) { return weight >= 0 ? weight : 1.0f; }
    /// Below 0.25, and in order.
    static float when_expected(float weight) {
        weight = ordered(weight);
        return 0.125f * (weight < 1 ? weight : 2 - 1 / weight);
    }

  private:
    struct Entered {
        std::uint32_t frame = 0, count = 0;
    };

    std::shared_ptr<PageCache> cache_;
    KnownUser known_;
    WantedPages asking_;
    std::vector<Entered> entered_;  ///< by page: how often in a frame
    std::uint32_t frame_ = 0;
};

}  // namespace farfield::detail
