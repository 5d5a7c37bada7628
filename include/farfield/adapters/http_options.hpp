// How a HttpPageSource (adapters/http_page_source.hpp) reads.
#pragma once

#include "farfield/settings.hpp"

#include <chrono>
#include <cstddef>
#include <cstdint>

#include "farfield/paging/page_source.hpp"

namespace farfield {

struct HttpOptions {
    std::chrono::milliseconds connect_timeout{5'000};
    /// A read is unavailable if it stays below the least speed for about this time (curl counts that in seconds, and
    /// over five), and in any case after both of these times and the time that its bytes take at the least speed.
    std::chrono::milliseconds answer_timeout{10'000};
    std::uint64_t least_bytes_per_second = 16u << 10;
    /// These are asked for when the file is opened, and kept: its head and a first page of 64 KiB, so that there is
    /// something to draw after one round trip; after two where the file has notes, which lie at its end.
    std::size_t head_bytes = 72u << 10;
    /// A gap takes as long as a round trip of 20 ms at 100 Mbit/s. With such a delay, 100 pages of 64 KiB take 2.1 s
    /// one by one, 0.52 s four at once, 0.27 s eight at once.
    ReadMerging merging{.largest_gap = 256u << 10, .largest_read = 2u << 20, .most_reads_at_once = 8};
};

}  // namespace farfield
