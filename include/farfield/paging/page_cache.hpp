// Pages of one file in memory of a fixed size, shared by any number of viewers on any threads. Frames never wait: what
// is missing is asked for and loaded by threads of the cache's own, and until then something coarser is drawn.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <functional>
#include <limits>
#include <memory>
#include <mutex>
#include <span>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "farfield/fail.hpp"
#include "farfield/paging/page_attempts.hpp"
#include "farfield/paging/page_cache_options.hpp"
#include "farfield/paging/page_demand.hpp"
#include "farfield/paging/page_room.hpp"
#include "farfield/paging/page_slots.hpp"
#include "farfield/paging/page_source.hpp"
#include "farfield/paging/wanted_pages.hpp"

namespace farfield::detail {

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
          threads_wanted_(options.loads_in_background ? std::max(merging.most_reads_at_once, 1u) : 0),
          room_(where_, places, options.most_bytes, threads_wanted_, merging.largest_read),
          slots_(places.page_count, room_.slot_count()),
          memory_(std::make_unique_for_overwrite<Line[]>(room_.page_bytes() / sizeof(Line) + 1)),
          attempts_(places.page_count, options.first_retry, options.longest_retry) {
        std::vector<std::byte> no_buffer;
        std::unique_lock lock(mutex_);
        load({{{std::numeric_limits<float>::infinity(), 0}}}, no_buffer, nullptr, lock);
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
    std::size_t memory_bytes() const { return room_.page_bytes(); }
    const PagePlaces& places() const { return places_; }

    PageCacheStats stats() const {
        const std::lock_guard lock(mutex_);
        PageCacheStats s = stats_;
        s.evictions = slots_.evictions();
        s.reloads = slots_.reloads();
        s.resident = slots_.resident();
        s.missing = demand_.count();
        s.bytes = room_.bytes();
        return s;
    }

    // Of those who look at pages (page_user.hpp).

    PageSlots& page_slots() { return slots_; }
    void add(KnownUser& user) {
        const std::lock_guard lock(mutex_);
        demand_.add(user);
    }
    void remove(KnownUser& user) {
        {
            const std::lock_guard lock(mutex_);
            demand_.remove(user);
        }
        changed_.notify_all();
    }
    /// What a frame that has ended has not found, the most wanted first. It is exchanged for what one before wanted.
    void want(KnownUser& user, std::vector<WantedPage>& pages) {
        {
            const std::lock_guard lock(mutex_);
            user.wanted.swap(pages);
            user.next = 0;
        }
        changed_.notify_all();
    }
    /// Reads a page for a frame that waits, if there is room.
    void load_now(const WantedPage& wanted, KnownUser& user) {
        std::vector<std::byte> no_buffer;
        Lock lock(mutex_);
        while (attempts_.is_loading(wanted.page)) changed_.wait(lock);
        while (may_load(wanted.page) && !is_changed_ &&
               load({{wanted}, &user.visits}, no_buffer, &user.visits, lock) == 0 &&
               slots_.will_have_room(demand_.visits(), user.visits)) {
            // All that could go is in use by frames of others, which end; but not if they wait for this one, or if this
            // thread runs them too.
            user.visits.is_blocked = true;
            const bool has_room = changed_.wait_for(
                lock, attempts_.longest_wait(), [&] { return !slots_.will_have_room(demand_.visits(), user.visits); });
            user.visits.is_blocked = false;
            if (!has_room) return;
        }
    }

    /// Loads what frames have asked for, on this thread, until nothing is left that can be loaded now. Returns the
    /// number of pages.
    std::size_t load_wanted() {
        // The buffers that are counted are those of the threads, if there are any.
        const std::uint32_t most = threads_wanted_ == 0 ? room_.pages_a_read() : 1;
        std::vector<std::byte> buffer(room_.buffer_bytes(most));
        std::unique_lock lock(mutex_);
        std::size_t count = 0;
        while (true) {
            const NextRead read = next_read(most);
            if (read.pages.empty()) {
                if (!demand_.any([&](std::uint32_t page) { return attempts_.is_loading(page); })) return count;
                changed_.wait(lock);
                continue;
            }
            const std::size_t loaded = load(read, buffer, nullptr, lock);
            if (loaded == 0) return count;
            count += loaded;
        }
    }

  private:
    struct alignas(PageRoom::alignment) Line {
        std::byte bytes[PageRoom::alignment];
    };
    using Lock = std::unique_lock<std::mutex>;

    std::span<std::byte> memory_of(std::uint32_t slot) {
        return {reinterpret_cast<std::byte*>(memory_.get()) + std::size_t(slot) * places_.page_bytes,
                places_.page_bytes};
    }
    bool may_load(std::uint32_t page) const { return attempts_.may_begin(page) && !slots_.is_resident(page); }

    /// Pages that are read together, and whose frame wants them.
    struct NextRead {
        std::vector<WantedPage> pages{};
        PageVisits* by = nullptr;
    };
    /// What is wanted most of all that can be loaded, and what lies near it in the file and the same user wants too.
    NextRead next_read(std::uint32_t most_pages) {
        if (is_changed_) return {};
        KnownUser* const user = demand_.next([&](std::uint32_t page) { return slots_.is_resident(page); },
                                             [&](std::uint32_t page) { return may_load(page); });
        if (user == nullptr) return {};
        const auto first = user->wanted.begin() + std::ptrdiff_t(user->next);
        // What has failed is read alone: a bad sector must not keep its neighbors away.
        if (most_pages <= 1 || attempts_.has_failed(first->page)) return {{*first}, &user->visits};
        return {pages_of_one_read(*first, {first + 1, user->wanted.end()}, most_pages,
                                  std::uint32_t(merging_.largest_gap / places_.page_bytes) + 1,
                                  [&](std::uint32_t page) { return may_load(page) && !attempts_.has_failed(page); }),
                &user->visits};
    }

    /// Reads pages that lie near one another together, the most wanted one first if there is not room for all. The lock
    /// is not held meanwhile. Returns how many are there now.
    std::size_t load(const NextRead& read, std::vector<std::byte>& buffer, const PageVisits* own, Lock& lock) {
        struct Loading {
            WantedPage wanted;
            std::uint32_t slot;
            const char* fault;
        };
        std::vector<Loading> loading;
        std::uint32_t first = PageSlots::none, last = 0;
        for (const WantedPage& w : read.pages) {
            const std::uint32_t slot = slots_.take(w.weight, demand_.visits(), own);
            if (slot == PageSlots::none) break;
            loading.push_back({w, slot, nullptr});
            attempts_.begin(w.page);
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
            if (result.status == ReadStatus::done && l.fault == nullptr) {
                attempts_.succeed(page);
                slots_.publish(page, l.slot, l.wanted.weight, page == 0, demand_.has(read.by) ? read.by : nullptr);
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
        attempts_.fail(page, result.status == ReadStatus::refused && was_alone);
    }

    void load_in_background() {
        std::vector<std::byte> buffer(room_.buffer_bytes(room_.pages_a_read()));
        Lock lock(mutex_);
        while (!stops_) {
            const NextRead read = next_read(room_.pages_a_read());
            if (!read.pages.empty() && load(read, buffer, nullptr, lock) != 0) continue;
            // Something new is wanted, a frame has ended, or it is time to try again.
            changed_.wait_for(lock, attempts_.first_wait());
        }
    }

    std::string where_;
    PagePlaces places_;
    ReadMerging merging_;
    Read read_;
    Prepare prepare_;
    Cancel cancel_;
    unsigned threads_wanted_;
    PageRoom room_;
    PageSlots slots_;
    std::unique_ptr<Line[]> memory_;
    mutable std::mutex mutex_;
    std::condition_variable changed_;
    PageAttempts attempts_;
    PageDemand demand_;
    PageCacheStats stats_;
    bool is_changed_ = false, stops_ = false;
    std::vector<std::thread> threads_;
};

}  // namespace farfield::detail
