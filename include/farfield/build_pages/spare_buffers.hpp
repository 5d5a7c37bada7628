// Memory that one group after the other is built in. What is given back to the system is cleared anew each time.
#pragma once

#include "farfield/settings.hpp"

#include <mutex>
#include <utility>
#include <vector>

namespace farfield::detail {

/// Vectors of no particular size or contents. Any number of threads may take and give back at once.
template <class T>
class SpareBuffers {
  public:
    std::vector<T> take() {
        const std::lock_guard lock(mutex_);
        if (spare_.empty()) return {};
        std::vector<T> buffer = std::move(spare_.back());
        spare_.pop_back();
        return buffer;
    }
    void give_back(std::vector<T> buffer) {
        const std::lock_guard lock(mutex_);
        spare_.push_back(std::move(buffer));
    }

  private:
    std::mutex mutex_;
    std::vector<std::vector<T>> spare_;
};

}  // namespace farfield::detail
