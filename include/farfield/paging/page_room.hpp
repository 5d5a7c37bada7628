// How a limit in bytes is shared out among pages, what is being read, and tables.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <string>

#include "farfield/fail.hpp"
#include "farfield/paging/page_attempts.hpp"
#include "farfield/paging/page_slots.hpp"

namespace farfield::detail {

/// Where pages lie in a source.
struct PagePlaces {
    std::uint64_t first_page = 0;
    std::uint32_t page_bytes = 0;
    std::uint32_t page_count = 0;
};

class PageRoom {
  public:
    /// For `readers` at once, each of which reads up to `largest_read` bytes. Throws std::invalid_argument, which names
    /// `where`, if there is no room for two pages.
    PageRoom(const std::string& where, const PagePlaces& places, std::size_t most_bytes, unsigned readers,
             std::uint64_t largest_read)
        : places_(places), readers_(std::max(readers, 1u)) {
        // Buffers take an eighth at most; where that is small, pages are read one by one.
        const std::uint64_t fit = most_bytes / 8 / readers_ / places.page_bytes;
        pages_a_read_ =
            std::uint32_t(std::clamp<std::uint64_t>(std::min(largest_read / places.page_bytes, fit), 1, 64));
        const std::size_t fixed = bytes_of(0), one = bytes_of(1) - fixed;
        const std::size_t slots_that_fit = most_bytes < fixed ? 0 : (most_bytes - fixed) / one;
        if (slots_that_fit < std::min<std::size_t>(2, places.page_count)) {
            fail<std::invalid_argument>("farfield::open_pages: " + where + ": most_bytes is " +
                                        std::to_string(most_bytes) + ", which leaves no room for pages of " +
                                        std::to_string(places.page_bytes) + " bytes: at least " +
                                        std::to_string(fixed + 2 * one) + " are needed");
        }
        slots_ = std::uint32_t(std::min<std::size_t>(slots_that_fit, places.page_count));
    }

    std::uint32_t slot_count() const { return slots_; }
    /// Those of the slots, which lie in a row.
    std::size_t page_bytes() const { return std::size_t(slots_) * places_.page_bytes; }
    std::uint32_t pages_a_read() const { return pages_a_read_; }
    /// That one reader needs beside: a single page is read to where it will lie.
    std::size_t buffer_bytes(std::uint32_t pages) const {
        return pages > 1 ? std::size_t(pages) * places_.page_bytes : 0;
    }
    /// Of all.
    std::size_t bytes() const { return bytes_of(slots_); }

    static constexpr std::size_t alignment = 64;

  private:
    std::size_t bytes_of(std::uint64_t slot_count) const {
        return PageSlots::bytes(places_.page_count, slot_count) + PageAttempts::bytes(places_.page_count) +
               std::size_t(slot_count) * places_.page_bytes + alignment + readers_ * buffer_bytes(pages_a_read_);
    }

    PagePlaces places_;
    unsigned readers_;
    std::uint32_t pages_a_read_ = 1, slots_ = 0;
};

}  // namespace farfield::detail
