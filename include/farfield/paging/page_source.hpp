// Where the bytes of a page file come from: a file, a server, an archive of the user's own. A PageCache (paging/
// page_cache.hpp) reads through this contract alone, from threads of its own.
#pragma once

#include "farfield/settings.hpp"

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

namespace farfield {

/// How a read ended.
enum class ReadStatus : std::uint8_t {
    done,         ///< every byte is there
    unavailable,  ///< not now: the same read may do later, as when a server is busy or a network is down
    changed,      ///< what lies there is no longer what was opened, and never will be again
    refused,      ///< never: beyond the end, not permitted, not spoken
};

struct ReadResult {
    ReadStatus status = ReadStatus::done;
    std::string message{};  ///< one line that names the source, where it was not done
};

/// What is worth one read. Neighboring ranges are read together where a round trip is dear.
struct ReadMerging {
    std::uint64_t largest_gap = 0;          ///< bytes between two ranges that are read and thrown away
    std::uint64_t largest_read = 1u << 20;  ///< bytes
    std::uint32_t most_reads_at_once = 2;   ///< on as many threads
};

/// read() blocks, may be called from several threads at once, and throws nothing. It fills `bytes` with those at
/// `offset` or says why not; then what it has written is undefined.
template <class S>
concept PageSource = requires(S& source, const S& known, std::uint64_t offset, std::span<std::byte> bytes) {
    { known.size() }
    noexcept->std::same_as<std::uint64_t>;  // bytes of the file
    { known.merging() }
    noexcept->std::same_as<ReadMerging>;
    { source.read(offset, bytes) }
    noexcept->std::same_as<ReadResult>;
};

}  // namespace farfield
