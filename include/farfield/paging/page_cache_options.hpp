// What a cache of pages is told, and what it tells.
#pragma once

#include "farfield/settings.hpp"

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <string>

namespace farfield {

struct PageCacheOptions {
    /// A limit that is never exceeded: pages, what is being read, and the cache's own tables together. Every viewer
    /// takes 16 bytes a page of the file and 8 a page of memory beside, and what it asks for.
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

}  // namespace farfield
