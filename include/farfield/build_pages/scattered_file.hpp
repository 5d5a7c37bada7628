// Primitives on their way into parts: a file with a place for each part, in which they come to lie in the order that
// they were read in. They are put in order block by block, so that all threads move them, and each part's piece of a
// block is written at once.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <span>
#include <vector>

#include "farfield/build/build_control.hpp"
#include "farfield/build_pages/file_in_place.hpp"
#include "farfield/geometry/mixed.hpp"

namespace farfield::detail {

/// A sum over primitives and where each lies, which tells whether a file still holds what was written: nobody waits for
/// the disk to have it.
template <class P>
std::uint64_t sum_of_scattered(std::span<const P> primitives, std::uint64_t first) {
    std::uint64_t sum = 0;
    for (std::size_t i = 0; i < primitives.size(); ++i) {
        const auto* bytes = reinterpret_cast<const std::byte*>(&primitives[i]);
        std::uint64_t hash = mixed(0, first + i), word = 0;
        std::size_t at = 0;
        for (; at + sizeof word <= sizeof(P); at += sizeof word) {
            std::memcpy(&word, bytes + at, sizeof word);
            hash = mixed(hash, word);
        }
        word = 0;
        if constexpr (sizeof(P) % sizeof word != 0) std::memcpy(&word, bytes + at, sizeof(P) % sizeof word);
        sum += mixed(hash, word);
    }
    return sum;
}

/// Borrows file and control.
template <class P>
class ScatterWriter {
  public:
    static constexpr std::uint32_t nowhere = std::numeric_limits<std::uint32_t>::max();

    /// `counts`: the number of primitives of each part.
    ScatterWriter(FileInPlace& file, std::span<const std::uint64_t> counts, const BuildControl& control)
        : file_(file), control_(control), parts_(counts.size()) {
        std::uint64_t at = 0;
        for (std::size_t p = 0; p < counts.size(); ++p) {
            parts_[p].next = at;
            parts_[p].end = at += counts[p];
        }
    }

    /// Puts the primitives of a block behind those that their parts have already, or nowhere. False if a part gets more
    /// than it has room for.
    bool add(std::span<const P> block, std::span<const std::uint32_t> part_of) {
        const std::size_t slices = std::min<std::size_t>(most_slices, (block.size() + 4095) / 4096);
        const auto begin_of = [&](std::size_t slice) { return block.size() * slice / slices; };
        places_.assign(slices * parts_.size(), 0);
        control_.run_quietly(slices, [&](std::size_t s) {
            const auto counts = std::span(places_).subspan(s * parts_.size(), parts_.size());
            for (std::size_t i = begin_of(s); i < begin_of(s + 1); ++i) {
                if (part_of[i] != nowhere) ++counts[part_of[i]];
            }
        });
        pieces_.clear();
        std::uint32_t at = 0;
        for (std::size_t p = 0; p < parts_.size(); ++p) {
            const std::uint32_t begin = at;
            for (std::size_t s = 0; s < slices; ++s) {
                std::uint32_t& count = places_[s * parts_.size() + p];
                const std::uint32_t place = at;
                at += count;
                count = place;
            }
            if (at - begin > parts_[p].end - parts_[p].next) return false;
            if (at != begin) pieces_.push_back({std::uint32_t(p), begin, at - begin});
        }
        if (sorted_.size() < at) sorted_.resize(block.size());
        control_.run_quietly(slices, [&](std::size_t s) {
            const auto places = std::span(places_).subspan(s * parts_.size(), parts_.size());
            for (std::size_t i = begin_of(s); i < begin_of(s + 1); ++i) {
                if (part_of[i] != nowhere) sorted_[places[part_of[i]]++] = block[i];
            }
        });
        control_.run_quietly(pieces_.size(), [&](std::size_t i) {
            Part& part = parts_[pieces_[i].part];
            const auto piece = std::span<const P>(sorted_).subspan(pieces_[i].begin, pieces_[i].count);
            part.sum += sum_of_scattered(piece, part.next);
            file_.write_at(part.next * sizeof(P), std::as_bytes(piece));
            part.next += piece.size();
        });
        return true;
    }
    /// Of what has been written of a part.
    std::uint64_t sum(std::size_t part) const { return parts_[part].sum; }

  private:
    static constexpr std::size_t most_slices = 64;
    struct Part {
        std::uint64_t next = 0, end = 0;  ///< in primitives
        std::uint64_t sum = 0;
    };
    struct Piece {
        std::uint32_t part, begin, count;  ///< in sorted_
    };

    FileInPlace& file_;
    const BuildControl& control_;
    std::vector<Part> parts_;
    std::vector<std::uint32_t> places_;  ///< by slice and part
    std::vector<Piece> pieces_;
    std::vector<P> sorted_;
};

}  // namespace farfield::detail
