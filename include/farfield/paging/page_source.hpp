// Where the bytes of a page file come from: a file, a server, an archive of the user's own. A PageCache (paging/
// page_cache.hpp) reads through this contract alone, from threads of its own.
#pragma once

#include "farfield/settings.hpp"

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <initializer_list>
#include <span>
#include <string>
#include <string_view>

#include "farfield/fail.hpp"

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
    std::string message{};  ///< one line that names the source, where it was not done and there was memory for it
};

/// What is worth one read. Neighboring ranges are read together where a round trip is dear.
struct ReadMerging {
    std::uint64_t largest_gap = 0;          ///< bytes between two ranges that are read and thrown away
    std::uint64_t largest_read = 1u << 20;  ///< bytes
    std::uint32_t most_reads_at_once = 2;   ///< on as many threads
};

/// read() blocks, may be called from several threads at once, and throws nothing. It fills `bytes` with those at
/// `offset` or says why not; then what it has written is undefined. It tries once: whoever calls it decides whether and
/// when to try again what was unavailable. A read of no bytes is done wherever it lies up to the end.
template <class S>
concept PageSource = requires(S& source, const S& known, std::uint64_t offset, std::span<std::byte> bytes) {
    { known.size() }
    noexcept->std::same_as<std::uint64_t>;  // bytes of the file
    { known.merging() }
    noexcept->std::same_as<ReadMerging>;
    { source.read(offset, bytes) }
    noexcept->std::same_as<ReadResult>;
};

/// A source whose reads may take long can be told to give up: those that have begun end soon, and they and all later
/// ones are unavailable. A PageCache that is destroyed need not wait for a server that does not answer.
template <class S>
concept CancellablePageSource = PageSource<S> && requires(S& source) {
    { source.cancel() }
    noexcept->std::same_as<void>;
};

/// The result of a read that was not done: the parts of its message in a row. It is for read() to return, and loses the
/// message rather than throw where there is no memory for it.
inline ReadResult not_read(ReadStatus status, std::initializer_list<std::string_view> message) noexcept {
    ReadResult result{status};
    detail::guarded<std::exception>(
        [&] {
            for (const std::string_view part : message) result.message += part;
        },
        [&] { result.message.clear(); });
    return result;
}

namespace detail {

/// Whether `count` bytes at `offset` lie within a file of `size`; nothing overflows.
constexpr bool lies_within(std::uint64_t size, std::uint64_t offset, std::uint64_t count) {
    return offset <= size && count <= size - offset;
}

/// What a read says that does not lie within.
inline ReadResult beyond_the_end(std::string_view source, std::uint64_t size, std::uint64_t offset,
                                 std::uint64_t count) noexcept {
    ReadResult result{ReadStatus::refused};
    guarded<std::exception>(
        [&] {
            const auto text = [](std::uint64_t n) { return std::to_string(n); };
            result.message = std::string(source) + ": " + text(count) + " bytes at " + text(offset) +
                             " are asked for, beyond its end at " + text(size);
        },
        [&] { result.message.clear(); });
    return result;
}

}  // namespace detail
}  // namespace farfield
