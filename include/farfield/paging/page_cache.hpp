// Pages of one file in memory of a fixed size, shared by any number of viewers on any threads. Frames never wait: what
// is missing is asked for and loaded by threads of the cache's own, and until then something coarser is drawn.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <functional>
#include <memory>
#include <mutex>
#include <span>
#include <stdexcept>
#include <string>
#include <thread>
#include <unordered_map>
#include <utility>
#include <vector>

#include "farfield/fail.hpp"
#include "farfield/paging/page_slots.hpp"
#include "farfield/paging/page_source.hpp"

namespace farfield {

struct PageCacheOptions {
    /// A limit that is never exceeded: pages, what is being read, and the cache's own tables together. Every viewer
    /// takes 16 bytes a page beside, and what it asks for.
    std::size_t most_bytes = std::size_t(256) << 20;
    /// Off: nothing is loaded but by load_wanted() and by viewers that wait, on their threads.
    bool loads_in_background = true;
    /// Between two attempts to read what failed: the first wait, doubled each time up to the longest.
    std::chrono::milliseconds first_retry{50}, longest_retry{5000};
};

struct PageCacheStats {
    std::uint64_t loads = 0;  ///< pages
    std::uint64_t reads = 0;  ///< of one page or several
    std::uint64_t bytes_read = 0;
    std::uint64_t failures = 0;  ///< pages that could not be read, or were not sound
    std::uint64_t evictions = 0;
    std::uint64_t reloads = 0;   ///< of a page that went less than 60 frames ago
    std::uint64_t resident = 0;  ///< pages
    std::uint64_t missing = 0;   ///< pages that the last frames asked for
    std::size_t bytes = 0;       ///< that all of it takes, at most
    std::string last_failure{};  ///< one line
};

namespace detail {

/// Where pages lie in a source.
struct PagePlaces {
    std::uint64_t first_page = 0;
    std::uint32_t page_bytes = 0;
    std::uint32_t page_count = 0;
};

/// A page that a frame has missed, or will.
struct WantedPage {
    float weight = 0;
    std::uint32_t page = 0;
    friend bool operator==(const WantedPage&, const WantedPage&) = default;
};

class PageCache {
  public:
    using Read = std::function<ReadResult(std::uint64_t, std::span<std::byte>)>;
    /// Checks a page and readies it for the memory it lies in, which begins at byte `begin` of all; null, or why not.
    using Prepare = std::function<const char*(std::span<std::byte> page, std::uint32_t number, std::uint64_t begin)>;
    using Cancel = std::function<void()>;

    /// Loads page 0, which stays. Throws std::runtime_error if that fails, std::invalid_argument if the limit leaves no
    /// room for two pages; `where` names the file. `cancel`, if there is one, ends reads that run when it goes.
    PageCache(std::string where, PagePlaces places, ReadMerging merging, Read read, Prepare prepare,
              const PageCacheOptions& options, Cancel cancel = {})
        : where_(std::move(where)),
          places_(places),
          merging_(merging),
          read_(std::move(read)),
          prepare_(std::move(prepare)),
          cancel_(std::move(cancel)),
          options_(options),
          threads_wanted_(options.loads_in_background ? std::max(merging.most_reads_at_once, 1u) : 0),
          pages_a_read_(pages_a_read()),
          slots_(places.page_count, slots_within()),
          memory_(std::make_unique_for_overwrite<Line[]>(
              std::size_t(slots_.slot_count()) * places.page_bytes / sizeof(Line) + 1)) {
        options_.first_retry = std::max(options_.first_retry, std::chrono::milliseconds(1));
        options_.longest_retry = std::max(options_.longest_retry, options_.first_retry);
        std::vector<std::byte> no_buffer;
        std::unique_lock lock(mutex_);
        states_.resize(places_.page_count);
        load({{std::numeric_limits<float>::infinity(), 0}}, no_buffer, nullptr, lock);
        if (!slots_.is_resident(0)) {
            fail<std::runtime_error>("farfield::open_pages: " + where_ +
                                     ": its first page cannot be used: " + stats_.last_failure);
        }
        for (unsigned i = 0; i < threads_wanted_; ++i) threads_.emplace_back([this] { load_in_background(); });
    }
    ~PageCache() {
        {
            const std::lock_guard lock(mutex_);
            stops_ = true;
        }
        changed_.notify_all();
        if (cancel_) cancel_();
        for (std::thread& t : threads_) t.join();
    }
    PageCache(const PageCache&) = delete;
    PageCache& operator=(const PageCache&) = delete;

    const std::byte* memory() const { return reinterpret_cast<const std::byte*>(memory_.get()); }
    std::size_t memory_bytes() const { return std::size_t(slots_.slot_count()) * places_.page_bytes; }
    const PagePlaces& places() const { return places_; }

    PageCacheStats stats() const {
        const std::lock_guard lock(mutex_);
        PageCacheStats s = stats_;
        s.evictions = slots_.evictions();
        s.reloads = slots_.reloads();
        s.resident = slots_.resident();
        for (const User* u : users_) s.missing += u->wanted.size();
        s.bytes = bytes_of(slots_.slot_count());
        return s;
    }

    /// One that looks at pages: a viewer, or whoever picks. Not to be used by two threads at once.
    class User {
      public:
        explicit User(std::shared_ptr<PageCache> cache)
            : cache_(std::move(cache)), asked_(cache_->places_.page_count), entered_(cache_->places_.page_count) {
            const std::lock_guard lock(cache_->mutex_);
            cache_->users_.push_back(this);
            cache_->visits_.push_back(&visits);
        }
        ~User() {
            {
                const std::lock_guard lock(cache_->mutex_);
                std::erase(cache_->users_, this);
                std::erase(cache_->visits_, &visits);
            }
            cache_->changed_.notify_all();
        }
        User(const User&) = delete;
        User& operator=(const User&) = delete;

        PageCache& cache() const { return *cache_; }

        void begin_frame() {
            asking_.clear();
            frame_ = cache_->slots_.begin(visits);
        }
        /// What was not found replaces what the frame before wanted.
        void end_frame() {
            PageSlots::end(visits);
            frame_ = 0;
            // More will not be there before the next frame, which asks anew; and the lock is held while they are looked
            // through.
            const std::size_t kept = std::min(asking_.size(), most_wanted);
            std::partial_sort(asking_.begin(), asking_.begin() + std::ptrdiff_t(kept), asking_.end(),
                              [](const WantedPage& a, const WantedPage& b) {
                                  return a.weight != b.weight ? a.weight > b.weight : a.page < b.page;
                              });
            asking_.resize(kept);
            // Some each frame: they are not needed at once, and reading them all would keep what is.
            const auto first_expected =
                std::find_if(asking_.begin(), asking_.end(), [](const WantedPage& w) { return w.weight < needed; });
            if (std::size_t(asking_.end() - first_expected) > most_expected) {
                asking_.erase(first_expected + most_expected, asking_.end());
            }
            {
                const std::lock_guard lock(cache_->mutex_);
                wanted.swap(asking_);
                next = 0;
            }
            cache_->changed_.notify_all();
        }
        /// As if it had never looked: its pages are no longer in use, though it may look again.
        void forget() { PageSlots::forget(visits); }
        bool is_in_frame() const { return frame_ != 0; }
        /// The slot of a page, which stays until the frame ends; PageSlots::none, and it is asked for.
        std::uint32_t find(std::uint32_t page, float weight) {
            weight = ordered(weight);
            const std::uint32_t slot = cache_->slots_.find(page, frame_, weight);
            if (slot == PageSlots::none) ask(page, weight);
            return slot;
        }
        /// The same for what later frames may want: the slot counts as used only a little, and what is missing is
        /// asked for when nothing else is.
        std::uint32_t expect(std::uint32_t page, float weight) {
            weight = ordered(weight);
            weight = 0.125f * (weight < 1 ? weight : 2 - 1 / weight);  // below 0.25, and in order
            const std::uint32_t slot = cache_->slots_.find(page, frame_, weight);
            if (slot == PageSlots::none) ask(page, weight);
            return slot;
        }
        /// Whether a frame may enter one more of a page's `units`. In a file that was built each is entered once, or
        /// twice if it is expected too. A forged one could lead to the same unit by many ways, and those below it by
        /// many times as many, which is not to be seen by looking at any one of its pages.
        bool may_enter(std::uint32_t page, std::uint32_t units) {
            Entered& entered = entered_[page];
            if (entered.frame != frame_) entered = {frame_, 0};
            return entered.count++ < 2 * units;
        }
        /// Loads it now, if there is room.
        std::uint32_t find_or_wait(std::uint32_t page, float weight) {
            weight = ordered(weight);
            const std::uint32_t slot = cache_->slots_.find(page, frame_, weight);
            if (slot != PageSlots::none) return slot;
            cache_->load_now({weight, page}, *this);
            return find(page, weight);
        }
        // The cache's, under its lock.
        PageVisits visits;
        std::vector<WantedPage> wanted{};  ///< most wanted first
        std::size_t next = 0;              ///< before it all are loaded or being loaded

      private:
        static constexpr std::size_t most_wanted = 512;
        static constexpr std::size_t most_expected = 8;
        static constexpr float needed = 0.5f;  ///< what weighs less is expected
        struct Asked {
            std::uint32_t frame = 0, index = 0;
        };
        struct Entered {
            std::uint32_t frame = 0, count = 0;
        };
        friend class PageCache;

        /// Without what has no order: a cell without extent errs by 0, which may be divided by a tolerance of 0.
        static float ordered(float weight) { return weight >= 0 ? weight : 1.0f; }
        void ask(std::uint32_t page, float weight) {
            Asked& asked = asked_[page];
            if (asked.frame == frame_) {
                WantedPage& w = asking_[asked.index];
                w.weight = std::max(w.weight, weight);
                return;
            }
            asked = {frame_, std::uint32_t(asking_.size())};
            asking_.push_back({weight, page});
        }

        std::shared_ptr<PageCache> cache_;
        std::vector<Asked> asked_;      ///< by page: the frame that it was asked for in, and where it is in `asking_`
        std::vector<Entered> entered_;  ///< by page: how often in a frame
        std::vector<WantedPage> asking_;
        std::uint32_t frame_ = 0;
    };

    /// Loads what frames have asked for, on this thread, until nothing is left that can be loaded now. Returns the
    /// number of pages.
    std::size_t load_wanted() {
        // The buffers that are counted are those of the threads, if there are any.
        const std::uint32_t most = threads_wanted_ == 0 ? pages_a_read_ : 1;
        std::vector<std::byte> buffer(buffer_bytes(most));
        std::unique_lock lock(mutex_);
        std::size_t count = 0;
        while (true) {
            const std::vector<WantedPage> batch = next_batch(most);
            if (batch.empty()) {
                if (!is_wanted_page_loading()) return count;
                changed_.wait(lock);
                continue;
            }
            const std::size_t loaded = load(batch, buffer, nullptr, lock);
            if (loaded == 0) return count;
            count += loaded;
        }
    }

  private:
    struct alignas(64) Line {
        std::byte bytes[64];
    };
    enum class State : std::uint8_t { idle, loading, refused };
    struct Retry {
        std::chrono::steady_clock::time_point at;
        std::chrono::milliseconds wait;
    };
    using Lock = std::unique_lock<std::mutex>;

    /// Buffers take an eighth of the memory at most; where that is small, pages are read one by one.
    std::uint32_t pages_a_read() const {
        const std::uint64_t fit = options_.most_bytes / 8 / std::max(threads_wanted_, 1u) / places_.page_bytes;
        return std::uint32_t(
            std::clamp<std::uint64_t>(std::min(merging_.largest_read / places_.page_bytes, fit), 1, 64));
    }
    /// One page is read to where it will lie.
    std::size_t buffer_bytes(std::uint32_t pages) const {
        return pages > 1 ? std::size_t(pages) * places_.page_bytes : 0;
    }
    std::size_t bytes_of(std::uint64_t slot_count) const {
        const std::size_t tables =
            PageSlots::bytes(places_.page_count, slot_count) + places_.page_count * sizeof(State);
        return tables + std::size_t(slot_count) * places_.page_bytes + sizeof(Line) +
               std::max(threads_wanted_, 1u) * buffer_bytes(pages_a_read_);
    }
    std::uint32_t slots_within() const {
        const std::size_t fixed = bytes_of(0), one = bytes_of(1) - fixed;
        const std::size_t fit = options_.most_bytes < fixed ? 0 : (options_.most_bytes - fixed) / one;
        if (fit < std::min<std::size_t>(2, places_.page_count)) {
            fail<std::invalid_argument>("farfield::open_pages: " + where_ + ": most_bytes is " +
                                        std::to_string(options_.most_bytes) + ", which leaves no room for pages of " +
                                        std::to_string(places_.page_bytes) + " bytes: at least " +
                                        std::to_string(fixed + 2 * one) + " are needed");
        }
        return std::uint32_t(std::min<std::size_t>(fit, places_.page_count));
    }

    std::span<std::byte> memory_of(std::uint32_t slot) {
        return {reinterpret_cast<std::byte*>(memory_.get()) + std::size_t(slot) * places_.page_bytes,
                places_.page_bytes};
    }
    bool may_load(std::uint32_t page) {
        if (states_[page] != State::idle || slots_.is_resident(page)) return false;
        const auto retry = retries_.find(page);
        return retry == retries_.end() || retry->second.at <= std::chrono::steady_clock::now();
    }

    /// What has failed is read alone: a bad sector must not keep its neighbors away.
    bool may_merge(std::uint32_t page) { return may_load(page) && !retries_.contains(page); }
    bool is_wanted_page_loading() const {
        return std::any_of(users_.begin(), users_.end(), [&](const User* u) {
            return std::any_of(u->wanted.begin(), u->wanted.end(),
                               [&](const WantedPage& w) { return states_[w.page] == State::loading; });
        });
    }

    /// What is wanted most of all that can be loaded, and what lies near it in the file and is wanted too: one read of
    /// `most_pages`.
    std::vector<WantedPage> next_batch(std::uint32_t most_pages) {
        if (is_changed_) return {};
        User* most = nullptr;
        for (User* u : users_) {
            std::size_t at = u->next;
            while (at < u->wanted.size() && slots_.is_resident(u->wanted[at].page)) ++at;
            u->next = at;
            while (at < u->wanted.size() && !may_load(u->wanted[at].page)) ++at;
            if (at == u->wanted.size()) continue;
            std::swap(u->wanted[u->next], u->wanted[at]);
            if (most == nullptr || u->wanted[u->next].weight > most->wanted[most->next].weight) most = u;
        }
        if (most == nullptr) return {};
        std::vector<WantedPage> batch{most->wanted[most->next]};
        const auto gap = std::uint32_t(merging_.largest_gap / places_.page_bytes) + 1;
        if (most_pages > 1 && !retries_.contains(batch[0].page)) {
            std::vector<WantedPage> others(most->wanted.begin() + std::ptrdiff_t(most->next) + 1, most->wanted.end());
            std::sort(others.begin(), others.end(),
                      [](const WantedPage& a, const WantedPage& b) { return a.page < b.page; });
            std::uint32_t first = batch[0].page, last = first;
            const auto above =
                std::upper_bound(others.begin(), others.end(), batch[0],
                                 [](const WantedPage& a, const WantedPage& b) { return a.page < b.page; });
            for (auto i = above; i != others.end() && i->page - last <= gap && i->page - first < most_pages; ++i) {
                if (!may_merge(i->page)) continue;
                batch.push_back(*i);
                last = i->page;
            }
            for (auto i = above; i != others.begin();) {
                --i;
                if (i->page == first) continue;
                if (first - i->page > gap || last - i->page >= most_pages) break;
                if (!may_merge(i->page)) continue;
                batch.push_back(*i);
                first = i->page;
            }
        }
        return batch;
    }

    /// Reads pages that lie near one another together, the most wanted one first if there is not room for all. The lock
    /// is not held meanwhile. Returns how many are there now.
    std::size_t load(const std::vector<WantedPage>& batch, std::vector<std::byte>& buffer, const PageVisits* own,
                     Lock& lock) {
        struct Loading {
            WantedPage wanted;
            std::uint32_t slot;
            const char* fault;
        };
        std::vector<Loading> loading;
        std::uint32_t first = PageSlots::none, last = 0;
        for (const WantedPage& w : batch) {
            const std::uint32_t slot = slots_.take(w.weight, visits_, own);
            if (slot == PageSlots::none) break;
            loading.push_back({w, slot, nullptr});
            states_[w.page] = State::loading;
            first = std::min(first, w.page);
            last = std::max(last, w.page);
        }
        if (loading.empty()) return 0;
        const bool is_alone = first == last;
        const auto bytes = is_alone ? memory_of(loading[0].slot)
                                    : std::span(buffer).first(std::size_t(last - first + 1) * places_.page_bytes);
        lock.unlock();
        const ReadResult result = read_(places_.first_page + std::uint64_t(first) * places_.page_bytes, bytes);
        for (Loading& l : loading) {
            if (result.status != ReadStatus::done) break;
            const std::span<std::byte> page = memory_of(l.slot);
            if (!is_alone) {
                std::memcpy(page.data(), bytes.data() + std::size_t(l.wanted.page - first) * places_.page_bytes,
                            page.size());
            }
            l.fault = prepare_(page, l.wanted.page, std::uint64_t(l.slot) * places_.page_bytes);
        }
        lock.lock();
        ++stats_.reads;
        stats_.bytes_read += bytes.size();
        std::size_t loaded = 0;
        for (const Loading& l : loading) {
            const std::uint32_t page = l.wanted.page;
            states_[page] = State::idle;
            if (result.status == ReadStatus::done && l.fault == nullptr) {
                retries_.erase(page);
                slots_.publish(page, l.slot, l.wanted.weight, page == 0);
                ++stats_.loads;
                ++loaded;
                continue;
            }
            slots_.give_back(l.slot);
            failed(page, result, l.fault, is_alone);
        }
        changed_.notify_all();
        return loaded;
    }
    void failed(std::uint32_t page, const ReadResult& result, const char* fault, bool was_alone) {
        ++stats_.failures;
        if (!is_changed_) {
            stats_.last_failure =
                fault != nullptr ? where_ + ": page " + std::to_string(page) + ": " + fault : result.message;
        }
        if (result.status == ReadStatus::changed) is_changed_ = true;
        if (result.status == ReadStatus::refused && was_alone) states_[page] = State::refused;
        Retry& retry = retries_[page];
        retry.wait = retry.wait.count() == 0 ? options_.first_retry : std::min(2 * retry.wait, options_.longest_retry);
        retry.at = std::chrono::steady_clock::now() + retry.wait;
    }

    void load_now(const WantedPage& wanted, User& user) {
        std::vector<std::byte> no_buffer;
        Lock lock(mutex_);
        while (states_[wanted.page] == State::loading) changed_.wait(lock);
        while (may_load(wanted.page) && !is_changed_ && load({wanted}, no_buffer, &user.visits, lock) == 0 &&
               slots_.will_have_room(visits_, user.visits)) {
            // All that could go is in use by frames of others, which end; but not if they wait for this one, or if this
            // thread runs them too.
            user.visits.is_blocked = true;
            const bool has_room = changed_.wait_for(lock, options_.longest_retry,
                                                    [&] { return !slots_.will_have_room(visits_, user.visits); });
            user.visits.is_blocked = false;
            if (!has_room) return;
        }
    }

    void load_in_background() {
        std::vector<std::byte> buffer(buffer_bytes(pages_a_read_));
        Lock lock(mutex_);
        while (!stops_) {
            const std::vector<WantedPage> batch = next_batch(pages_a_read_);
            if (!batch.empty() && load(batch, buffer, nullptr, lock) != 0) continue;
            // Something new is wanted, a frame has ended, or it is time to try again.
            changed_.wait_for(lock, options_.first_retry);
        }
    }

    std::string where_;
    PagePlaces places_;
    ReadMerging merging_;
    Read read_;
    Prepare prepare_;
    Cancel cancel_;
    PageCacheOptions options_;
    unsigned threads_wanted_;
    std::uint32_t pages_a_read_;
    PageSlots slots_;
    std::unique_ptr<Line[]> memory_;
    mutable std::mutex mutex_;
    std::condition_variable changed_;
    std::vector<State> states_;
    std::unordered_map<std::uint32_t, Retry> retries_;  ///< of pages that failed
    std::vector<User*> users_;
    std::vector<PageVisits*> visits_;
    PageCacheStats stats_;
    bool is_changed_ = false, stops_ = false;
    std::vector<std::thread> threads_;
};

}  // namespace detail
}  // namespace farfield
