// What threads have made in any order is used in one order, by whichever of them is at hand.
#pragma once

#include "farfield/settings.hpp"

#include <cstddef>
#include <mutex>
#include <optional>
#include <utility>
#include <vector>

namespace farfield::detail {

template <class T>
class OrderedResults {
  public:
    explicit OrderedResults(std::size_t most) : waiting_(most) {}
    /// For the next row of results, the first of which is number 0.
    void restart() {
        for (auto& w : waiting_) w.reset();
        next_ = 0;
        is_used_ = false;
    }

    /// Takes result number i, and calls use(result) for all whose turn it is, one after the other: here, or on a thread
    /// that does so already. Any number of threads may add at once. If use throws, nothing is used any more.
    template <class Use>
    void add(std::size_t i, T result, Use&& use) {
        std::unique_lock lock(mutex_);
        waiting_[i].emplace(std::move(result));
        if (is_used_) return;
        is_used_ = true;
        for (; next_ < waiting_.size() && waiting_[next_]; ++next_) {
            T mine = std::move(*waiting_[next_]);
            waiting_[next_].reset();
            lock.unlock();
            use(mine);
            lock.lock();
        }
        is_used_ = false;
    }

  private:
    std::mutex mutex_;
    std::vector<std::optional<T>> waiting_;
    std::size_t next_ = 0;
    bool is_used_ = false;  ///< by some thread
};

}  // namespace farfield::detail
