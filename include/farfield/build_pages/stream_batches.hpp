// A stream of primitives is taken in batches, which threads look at while they are at hand.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "farfield/build/build_control.hpp"

namespace farfield::detail {

/// The batches of a stream are the same on any number of threads: all but the last hold as many.
inline constexpr std::size_t stream_batch = 4096;
inline constexpr std::size_t stream_batches_at_once = 32;

/// Calls take(block, index of the first) for blocks of the stream, all but the last of `most` primitives, and returns
/// the number of primitives.
template <class P, class Stream, class Take>
std::uint64_t in_blocks(Stream& stream, std::size_t most, Take&& take) {
    std::vector<P> waiting;
    waiting.reserve(most);
    std::uint64_t done = 0;
    const auto flush = [&] {
        take(std::span<const P>(waiting), done);
        done += waiting.size();
        waiting.clear();
    };
    stream([&](const P& p) {
        waiting.push_back(p);
        if (waiting.size() == most) flush();
    });
    if (!waiting.empty()) flush();
    return done;
}

/// Calls look(batch, first index, slot) for batches of the stream, any number of them at once, `slot` below
/// stream_batches_at_once and different for those; then take(batch, first index, slot) for each in order, on this
/// thread. Returns the number of primitives.
template <class P, class Stream, class Look, class Take>
std::uint64_t in_batches(Stream& stream, const BuildControl& control, Look&& look, Take&& take) {
    return in_blocks<P>(stream, stream_batch * stream_batches_at_once, [&](std::span<const P> all, std::uint64_t done) {
        const std::size_t count = (all.size() + stream_batch - 1) / stream_batch;
        const auto batch = [&](std::size_t i) {
            return all.subspan(i * stream_batch, std::min(stream_batch, all.size() - i * stream_batch));
        };
        control.run_quietly(count, [&](std::size_t i) { look(batch(i), done + i * stream_batch, i); });
        for (std::size_t i = 0; i < count; ++i) take(batch(i), done + i * stream_batch, i);
    });
}

}  // namespace farfield::detail
