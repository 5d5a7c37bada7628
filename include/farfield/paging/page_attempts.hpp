// Which pages are being read, and when those are tried again that could not be.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <unordered_map>
#include <vector>

namespace farfield::detail {

class PageAttempts {
  public:
    /// Between two attempts: the first wait, doubled each time up to the longest.
    PageAttempts(std::uint32_t page_count, std::chrono::milliseconds first, std::chrono::milliseconds longest)
        : states_(page_count),
          first_(std::max(first, std::chrono::milliseconds(1))),
          longest_(std::max(longest, first_)) {}
    /// The memory that it takes while nothing fails.
    static std::size_t bytes(std::size_t page_count) { return page_count * sizeof(State); }

    std::chrono::milliseconds first_wait() const { return first_; }
    std::chrono::milliseconds longest_wait() const { return longest_; }

    bool is_loading(std::uint32_t page) const { return states_[page] == State::loading; }
    bool has_failed(std::uint32_t page) const { return retries_.contains(page); }
    /// Neither being read, nor refused, nor to wait.
    bool may_begin(std::uint32_t page) const {
        if (states_[page] != State::idle) return false;
        const auto retry = retries_.find(page);
        return retry == retries_.end() || retry->second.at <= std::chrono::steady_clock::now();
    }

    void begin(std::uint32_t page) { states_[page] = State::loading; }
    void succeed(std::uint32_t page) {
        states_[page] = State::idle;
        retries_.erase(page);
    }
    /// A page that is refused is not tried again.
    void fail(std::uint32_t page, bool is_refused) {
        states_[page] = is_refused ? State::refused : State::idle;
        Retry& retry = retries_[page];
        retry.wait = retry.wait.count() == 0 ? first_ : std::min(2 * retry.wait, longest_);
        retry.at = std::chrono::steady_clock::now() + retry.wait;
    }

  private:
    enum class State : std::uint8_t { idle, loading, refused };
    struct Retry {
        std::chrono::steady_clock::time_point at;
        std::chrono::milliseconds wait;
    };
    std::vector<State> states_;
    std::chrono::milliseconds first_, longest_;
    std::unordered_map<std::uint32_t, Retry> retries_{};  ///< of pages that failed
};

}  // namespace farfield::detail
