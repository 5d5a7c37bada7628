// Which pages are in memory, who uses them, and which goes when room is needed.
//
// Frames look up pages without a lock. A page that goes is first taken off the table; its memory is used again when no
// frame is left that began before (epochs, as in K. Fraser: Practical lock-freedom, 2004, section 5.2.3), since such a
// frame may still walk it.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <atomic>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <vector>

namespace farfield::detail {

/// One user's frames, one after the other.
struct PageVisits {
    explicit PageVisits(std::uint32_t slot_count) : uses(slot_count) {}

    std::atomic<std::uint64_t> epoch{0};       ///< that its frame began in; 0: it has none
    std::atomic<std::uint32_t> last_frame{0};  ///< the number of its last one; 0: there was none
    std::atomic<std::uint32_t> last_ended{0};  ///< the number of the last one that has ended
    bool is_blocked = false;  ///< its frame waits for others; under the lock of those who change tables
    /// By slot: frame << 32 | bits of a weight, which are in order: the last frame that has found its page, and how
    /// much that counted. Each user has its own: what one of them looks at in passing may be all that another one sees.
    std::vector<std::atomic<std::uint64_t>> uses;
};

/// The functions that frames call may run at any time; whatever changes the table is called by one thread at a time.
class PageSlots {
  public:
    static constexpr std::uint32_t none = std::numeric_limits<std::uint32_t>::max();

    PageSlots(std::uint32_t page_count, std::uint32_t slot_count)
        : page_count_(page_count),
          pages_(std::make_unique<Page[]>(page_count)),
          slots_(std::make_unique<Slot[]>(slot_count)),
          slot_count_(slot_count) {
        free_.reserve(slot_count);
        for (std::uint32_t i = slot_count; i-- > 0;) free_.push_back(i);
        retired_.reserve(slot_count);
    }
    /// The memory that it takes itself.
    static std::size_t bytes(std::uint64_t page_count, std::uint64_t slot_count) {
        return std::size_t(page_count * sizeof(Page) + slot_count * (sizeof(Slot) + 2 * sizeof(std::uint64_t)));
    }
    std::uint32_t page_count() const { return page_count_; }
    std::uint32_t slot_count() const { return slot_count_; }
    /// Pages that are there.
    std::uint32_t resident() const { return resident_; }

    // Called by frames.

    /// Numbers frames from 1 on.
    std::uint32_t begin(PageVisits& visits) {
        const std::uint32_t frame = frames_.fetch_add(1, std::memory_order_relaxed) + 1;
        visits.last_frame.store(frame, std::memory_order_relaxed);
        // Before any look at the table, in the one order of all such accesses.
        visits.epoch.store(epoch_.load(std::memory_order_seq_cst), std::memory_order_seq_cst);
        return frame;
    }
    static void end(PageVisits& visits) {
        visits.last_ended.store(visits.last_frame.load(std::memory_order_relaxed), std::memory_order_relaxed);
        visits.epoch.store(0, std::memory_order_release);
    }
    /// As if it had never looked: none of its pages are in use.
    static void forget(PageVisits& visits) {
        visits.last_ended.store(0, std::memory_order_relaxed);
        visits.last_frame.store(0, std::memory_order_relaxed);
    }
    /// The slot of a page, or none. A frame, the last one of `visits`, that sees one may use it until it ends. `weight`
    /// says how much it counts, and is not negative; of several in one frame the largest holds.
    std::uint32_t find(std::uint32_t page, PageVisits& visits, float weight) const {
        const std::uint32_t slot = pages_[page].slot.load(std::memory_order_seq_cst);
        if (slot != none) {
            const std::uint64_t use = use_of(visits.last_frame.load(std::memory_order_relaxed), weight);
            std::atomic<std::uint64_t>& last = visits.uses[slot];
            if (last.load(std::memory_order_relaxed) < use) last.store(use, std::memory_order_relaxed);
        }
        return slot;
    }
    /// How much a frame that runs has counted the page in a slot; infinity if it has not looked it up, as nobody does
    /// with a page that stays.
    static float weight_of(std::uint32_t slot, const PageVisits& visits) {
        const std::uint64_t use = visits.uses[slot].load(std::memory_order_relaxed);
        return use >> 32 == visits.last_frame.load(std::memory_order_relaxed) ? std::bit_cast<float>(std::uint32_t(use))
                                                                              : std::numeric_limits<float>::infinity();
    }

    // Called by one thread at a time.

    bool is_resident(std::uint32_t page) const { return pages_[page].slot.load(std::memory_order_relaxed) != none; }
    std::uint32_t frames() const { return frames_.load(std::memory_order_relaxed); }

    /// Memory for a page of this weight, or none: all is in use for what counts half as much or more, or will be free
    /// when frames end that run now. What weighs less than 1 is not needed yet, and replaces only what was not needed
    /// for long. `own`: the caller's frame, if it runs one, which uses no page but those that it
    /// has found. Visits of users that have drawn nothing for long do not count.
    std::uint32_t take(float weight, const std::vector<PageVisits*>& all, const PageVisits* own) {
        if (!free_.empty()) {
            const std::uint32_t slot = free_.back();
            free_.pop_back();
            return slot;
        }
        if (const std::uint32_t slot = take_retired(all, own); slot != none) return slot;
        if (retired_.size() >= most_retired) return none;
        const std::uint32_t victim = choose_victim(weight, all, own);
        if (victim == none) return none;
        Slot& s = slots_[victim];
        Page& page = pages_[s.page];
        page.slot.store(none, std::memory_order_seq_cst);
        page.evicted_in = frames();
        ++evictions_;
        --resident_;
        retired_.push_back({victim, epoch_.fetch_add(1, std::memory_order_seq_cst)});
        return take_retired(all, own);
    }
    /// Whether memory becomes free as soon as frames of others end, which do not wait themselves. `own` runs one.
    bool will_have_room(const std::vector<PageVisits*>& all, const PageVisits& own) const {
        bool is_held = false;
        for (const Retired& r : retired_) {
            bool is_held_by_others = false;
            for (const PageVisits* v : all) {
                const std::uint64_t epoch = v->epoch.load(std::memory_order_seq_cst);
                if (epoch == 0 || epoch > r.epoch || v == &own) continue;
                if (v->is_blocked) return false;
                is_held_by_others = true;
            }
            if (!is_held_by_others) return false;
            is_held = true;
        }
        return is_held;
    }
    /// Gives back what take() gave.
    void give_back(std::uint32_t slot) { free_.push_back(slot); }

    /// The page is in the slot from now on. It counts as if the last frame of whoever wanted it had found it: the next
    /// one will, unless it does not look for it any more.
    void publish(std::uint32_t page, std::uint32_t slot, float weight, bool stays, PageVisits* wanted_by = nullptr) {
        Slot& s = slots_[slot];
        Page& p = pages_[page];
        const std::uint32_t now = frames();
        const bool again = p.evicted_in != 0 && now - p.evicted_in < frames_between_loads;
        reloads_ += again;
        ++resident_;
        s.page = page;
        s.held_until = stays ? std::numeric_limits<std::uint32_t>::max() : again ? now + frames_between_loads : 0;
        s.loaded = use_of(now, weight);
        if (wanted_by != nullptr) {
            const std::uint64_t use = use_of(frame_that_counts(*wanted_by, nullptr), weight);
            wanted_by->uses[slot].store(use, std::memory_order_relaxed);
        }
        p.slot.store(slot, std::memory_order_seq_cst);
    }

    std::uint64_t evictions() const { return evictions_; }
    std::uint64_t reloads() const { return reloads_; }

    /// A page that comes back sooner than this after it went stays as long: whoever looks to and fro between two places
    /// that do not fit together gets one of them coarser, and the disk is left alone.
    static constexpr std::uint32_t frames_between_loads = 60;

    /// What is not needed yet replaces what was not looked at for so many frames: the cut has left that behind.
    static constexpr std::uint32_t frames_until_stale = 16;

  private:
    static constexpr std::size_t most_retired = 16;

    struct Page {
        std::atomic<std::uint32_t> slot{none};
        std::uint32_t evicted_in = 0;  ///< the frame
    };
    struct Slot {
        std::uint64_t loaded = 0;      ///< when, and how much it was wanted, as a use
        std::uint32_t page = none;     ///< none: its page is being loaded
        std::uint32_t held_until = 0;  ///< the frame before which it does not go
    };
    struct Retired {
        std::uint32_t slot;
        std::uint64_t epoch;  ///< frames that began in it or before may still use the slot
    };

    static std::uint64_t use_of(std::uint32_t frame, float weight) {
        return std::uint64_t(frame) << 32 | std::bit_cast<std::uint32_t>(weight);
    }

    /// A slot that no frame can use any more. `own` began before, and has not used what was taken from it since: its
    /// pages count as used.
    std::uint32_t take_retired(const std::vector<PageVisits*>& all, const PageVisits* own) {
        for (std::size_t i = 0; i < retired_.size(); ++i) {
            const bool is_free = std::all_of(all.begin(), all.end(), [&](const PageVisits* v) {
                const std::uint64_t epoch = v->epoch.load(std::memory_order_seq_cst);
                if (epoch == 0 || epoch > retired_[i].epoch) return true;
                return v == own && own->uses[retired_[i].slot].load(std::memory_order_relaxed) >> 32 <
                                       own->last_frame.load(std::memory_order_relaxed);
            });
            if (!is_free) continue;
            const std::uint32_t slot = retired_[i].slot;
            retired_.erase(retired_.begin() + std::ptrdiff_t(i));
            slots_[slot].page = none;
            for (PageVisits* v : all) v->uses[slot].store(0, std::memory_order_relaxed);
            return slot;
        }
        return none;
    }

    /// The least recently used page; if all are in use, the one that counts least, and less than half as much. What a
    /// frame that runs has not come to yet may still be wanted, so that until it ends the one before it counts: else
    /// whoever stands still would lose pages in every frame, and load them in the next. `own` takes what it needs.
    std::uint32_t choose_victim(float weight, const std::vector<PageVisits*>& all, const PageVisits* own) const {
        const std::uint32_t now = frames(), in_use = now + 1;
        const std::uint64_t most = weight < 1 ? use_of(now > frames_until_stale ? now - frames_until_stale : 0, 0)
                                              : use_of(in_use, weight * 0.5f);
        std::uint32_t victim = none;
        std::uint64_t least = std::numeric_limits<std::uint64_t>::max();
        for (std::uint32_t i = 0; i < slot_count_; ++i) {
            const Slot& s = slots_[i];
            if (s.page == none || pages_[s.page].slot.load(std::memory_order_relaxed) != i) continue;
            if (s.held_until > now) continue;
            // What several look at now counts as for the one to whom it counts most.
            const auto as_of_now = [&](std::uint64_t use, bool is_in_use) {
                return is_in_use ? std::uint64_t(in_use) << 32 | (use & 0xffffffffu) : use;
            };
            std::uint64_t use = 0;
            for (const PageVisits* v : all) {
                const std::uint64_t of_user = v->uses[i].load(std::memory_order_relaxed);
                if (of_user == 0 || v->last_frame.load(std::memory_order_relaxed) == 0) continue;
                use = std::max(
                    use, as_of_now(of_user, is_active(*v, now, own) && of_user >> 32 >= frame_that_counts(*v, own)));
            }
            if (use == 0) use = s.loaded;
            // Of pages that were last used together a child's goes before its parent's, which comes before it in the
            // file.
            if (use < least || (use == least && s.page > slots_[victim].page)) {
                least = use;
                victim = i;
            }
        }
        return least < most ? victim : none;
    }
    /// Which of a user's frames says what it uses: the last one that has ended.
    static std::uint32_t frame_that_counts(const PageVisits& v, const PageVisits* own) {
        const std::uint32_t ended = v.last_ended.load(std::memory_order_relaxed);
        return &v == own || ended == 0 ? v.last_frame.load(std::memory_order_relaxed) : ended;
    }
    /// Whether it has drawn something lately.
    static bool is_active(const PageVisits& v, std::uint32_t now, const PageVisits* own) {
        const std::uint32_t last = frame_that_counts(v, own);
        return last != 0 && now - last < frames_between_loads;
    }

    std::uint32_t page_count_;
    std::unique_ptr<Page[]> pages_;
    std::unique_ptr<Slot[]> slots_;
    std::uint32_t slot_count_;
    std::vector<std::uint32_t> free_;
    std::vector<Retired> retired_;
    std::atomic<std::uint32_t> frames_{0};
    std::atomic<std::uint64_t> epoch_{1};
    std::uint64_t evictions_ = 0, reloads_ = 0;
    std::uint32_t resident_ = 0;
};

}  // namespace farfield::detail
