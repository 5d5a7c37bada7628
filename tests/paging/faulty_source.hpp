// Sources of pages for tests: bytes in memory, and any source with faults put between.
#pragma once

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <mutex>
#include <span>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "farfield/paging/page_source.hpp"
#include "support/random.hpp"

namespace farfield::test {

/// The bytes must outlive it.
class MemorySource {
  public:
    explicit MemorySource(std::span<const std::byte> bytes, ReadMerging merging = {})
        : bytes_(bytes), merging_(merging) {}

    std::uint64_t size() const noexcept { return bytes_.size(); }
    ReadMerging merging() const noexcept { return merging_; }
    ReadResult read(std::uint64_t offset, std::span<std::byte> bytes) noexcept {
        if (!detail::lies_within(size(), offset, bytes.size())) {
            return detail::beyond_the_end("memory", size(), offset, bytes.size());
        }
        if (!bytes.empty()) std::memcpy(bytes.data(), bytes_.data() + offset, bytes.size());
        return {};
    }

  private:
    std::span<const std::byte> bytes_;
    ReadMerging merging_;
};
static_assert(PageSource<MemorySource>);

/// What happens to a read. The first that applies: it is held, delayed, answered in place of the source, damaged.
struct Fault {
    std::chrono::microseconds delay{0};
    ReadStatus status = ReadStatus::done;  ///< if it is another, the source is not asked
    std::uint32_t flipped_bits = 0;        ///< of what is delivered as done
};

/// Another source, with faults: one for all reads, by ranges of bytes, or at random by a seed. It counts what is asked
/// of it, and can hold all reads at a gate. Faults may be changed while others read.
template <PageSource S>
class FaultySource {
  public:
    struct Read {
        std::uint64_t offset = 0, count = 0;
        friend bool operator==(const Read&, const Read&) = default;
    };

    explicit FaultySource(S& source, std::uint64_t seed = 1) : source_(source), random_(seed) {}

    /// For every read from now on.
    void fail(Fault fault) {
        const std::lock_guard lock(mutex_);
        all_ = fault;
    }
    /// For reads that touch [begin, end), before what holds for all.
    void fail_at(std::uint64_t begin, std::uint64_t end, Fault fault) {
        const std::lock_guard lock(mutex_);
        ranges_.push_back({begin, end, fault});
    }
    /// For the next `count` reads, before all others.
    void fail_next(std::uint32_t count, Fault fault) {
        const std::lock_guard lock(mutex_);
        next_count_ = count;
        next_ = fault;
    }
    /// For `per_mille` of the reads, drawn in the order in which they begin, after all others.
    void fail_sometimes(std::uint32_t per_mille, Fault fault) {
        const std::lock_guard lock(mutex_);
        sometimes_per_mille_ = per_mille;
        sometimes_ = fault;
    }
    /// The server recovers: no more faults, the gate is open.
    void recover() {
        const std::lock_guard lock(mutex_);
        all_ = next_ = sometimes_ = {};
        ranges_.clear();
        next_count_ = sometimes_per_mille_ = 0;
        is_held_ = false;
    }
    /// While it holds, reads begin and do not end.
    void hold(bool is_held = true) { is_held_ = is_held; }

    std::uint64_t size() const noexcept { return source_.size(); }
    ReadMerging merging() const noexcept { return source_.merging(); }
    ReadResult read(std::uint64_t offset, std::span<std::byte> bytes) noexcept {
        Fault fault;
        std::uint64_t seed = 0;
        {
            const std::lock_guard lock(mutex_);
            reads_.push_back({offset, bytes.size()});
            most_in_flight_ = std::max(most_in_flight_, ++in_flight_);
            fault = fault_of(offset, bytes.size());
            seed = random_.bits();
        }
        const std::chrono::microseconds slice(200);
        while (is_held_ && !is_cancelled_) std::this_thread::sleep_for(slice);
        for (; fault.delay.count() > 0 && !is_cancelled_; fault.delay -= slice) {
            std::this_thread::sleep_for(std::min(slice, fault.delay));
        }
        ReadResult result = is_cancelled_                      ? not_read(ReadStatus::unavailable, {"given up"})
                            : fault.status != ReadStatus::done ? not_read(fault.status, {"a fault of the test"})
                                                               : source_.read(offset, bytes);
        if (result.status != ReadStatus::done) {
            // What a read that failed has written is undefined: nobody may look at it.
            std::fill(bytes.begin(), bytes.end(), std::byte(0xa5));
        } else if (!bytes.empty()) {
            Random random(seed);
            for (std::uint32_t i = 0; i < fault.flipped_bits; ++i) {
                bytes[random.bits() % bytes.size()] ^= std::byte(1u << random.below(8));
            }
        }
        const std::lock_guard lock(mutex_);
        --in_flight_;
        return result;
    }
    /// Those that are held or will come end as unavailable.
    void cancel() noexcept { is_cancelled_ = true; }

    std::vector<Read> reads() const {
        const std::lock_guard lock(mutex_);
        return reads_;
    }
    void forget_reads() {
        const std::lock_guard lock(mutex_);
        reads_.clear();
        most_in_flight_ = in_flight_;
    }
    std::uint64_t bytes_asked() const {
        std::uint64_t sum = 0;
        for (const Read& r : reads()) sum += r.count;
        return sum;
    }
    std::uint32_t in_flight() const {
        const std::lock_guard lock(mutex_);
        return in_flight_;
    }
    std::uint32_t most_in_flight() const {
        const std::lock_guard lock(mutex_);
        return most_in_flight_;
    }

  private:
    struct Range {
        std::uint64_t begin = 0, end = 0;
        Fault fault;
    };

    Fault fault_of(std::uint64_t offset, std::uint64_t count) {
        if (next_count_ > 0) {
            --next_count_;
            return next_;
        }
        for (const Range& r : ranges_) {
            if (offset < r.end && r.begin < offset + count) return r.fault;
        }
        if (sometimes_per_mille_ > 0 && random_.below(1000) < sometimes_per_mille_) return sometimes_;
        return all_;
    }

    S& source_;
    mutable std::mutex mutex_;
    std::atomic<bool> is_held_{false}, is_cancelled_{false};
    Random random_;
    Fault all_, next_, sometimes_;
    std::uint32_t next_count_ = 0, sometimes_per_mille_ = 0, in_flight_ = 0, most_in_flight_ = 0;
    std::vector<Range> ranges_;
    std::vector<Read> reads_;
};
static_assert(CancellablePageSource<FaultySource<MemorySource>>);

/// The same everywhere, and nowhere the same twice in a row of 64 bytes.
inline std::vector<std::byte> random_bytes(std::size_t count, std::uint64_t seed = 1) {
    Random random(seed);
    std::vector<std::byte> bytes(count);
    for (std::byte& b : bytes) b = std::byte(random.bits());
    return bytes;
}

}  // namespace farfield::test
