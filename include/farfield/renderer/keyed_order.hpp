// A renderer that draws with one state after the other, a material or a texture, wants what has one key in one piece;
// a hierarchy's ranges are pieces of space, with all keys in each. Kept twice, both are pieces: the primitives of a
// range, which are one piece in the hierarchy's order, are at most one piece for each key in the order of keys.
//
// In a cut of 86,680 triangles of four materials, strewn at random, 325 ranges come in 65,095 batches of one material.
// It is 11,307 where each run of the hierarchy is grouped by key, and here 1,299.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <stdexcept>
#include <utility>
#include <vector>

#include "farfield/drawables.hpp"
#include "farfield/fail.hpp"
#include "farfield/primitive.hpp"

namespace farfield {

/// Entries [first, first + count) of KeyedOrder::positions(), which have one key: a draw call.
struct KeyedPart {
    std::uint32_t key = 0, first = 0, count = 0;

    friend bool operator==(const KeyedPart&, const KeyedPart&) = default;
};

/// The positions of a source sorted by the keys of their primitives (key_of), to be made when the source is uploaded:
/// an index buffer in this order is drawn from. Four bytes a position, eight where there are
/// more than 32 keys.
class KeyedOrder {
  public:
    KeyedOrder() = default;
    /// Throws std::invalid_argument for a source whose positions come and go.
    template <PrimitiveWithKey P>
    explicit KeyedOrder(const Source<P>& source) {
        if (source.changes) {
            detail::fail<std::invalid_argument>("farfield::KeyedOrder: the source changes from frame to frame");
        }
        std::vector<std::pair<std::uint32_t, std::uint32_t>> keyed;  // key, position
        keyed.reserve(source.item_count);
        for (std::uint32_t i = 0; i < source.item_count; ++i) keyed.emplace_back(key_of(source[i]), i);
        std::sort(keyed.begin(), keyed.end());
        positions_.reserve(keyed.size());
        for (const auto& [key, position] : keyed) {
            if (runs_.empty() || runs_.back().key != key) {
                runs_.push_back({key, std::uint32_t(positions_.size()), std::uint32_t(positions_.size())});
            }
            ++runs_.back().end;
            positions_.push_back(position);
        }
        if (runs_.size() <= most_keys_searched) return;
        places_.resize(positions_.size());
        for (std::uint32_t i = 0; i < positions_.size(); ++i) places_[positions_[i]] = i;
    }

    /// Positions of the source, by key, those of one key ascending.
    std::span<const std::uint32_t> positions() const { return positions_; }
    std::size_t key_count() const { return runs_.size(); }

    /// What the ranges of a draw() hold, by key, in `parts`, whose memory is used again: at most as many parts as
    /// ranges times keys, and fewer where parts meet, which are made one. The ranges' own order is lost.
    void parts_of(std::span<const Range> ranges, std::vector<KeyedPart>& parts) const {
        parts.clear();
        for (const Range& range : ranges) {
            places_.empty() ? add_by_keys(range, parts) : add_by_items(range, parts);
        }
        // Keys come in the order of places.
        std::sort(parts.begin(), parts.end(), [](const KeyedPart& a, const KeyedPart& b) { return a.first < b.first; });
        std::size_t last = 0;
        for (std::size_t i = 1; i < parts.size(); ++i) {
            KeyedPart& before = parts[last];
            if (before.key == parts[i].key && before.first + before.count == parts[i].first) {
                before.count += parts[i].count;
            } else {
                parts[++last] = parts[i];
            }
        }
        if (!parts.empty()) parts.resize(last + 1);
    }

  private:
    /// Where there are more keys, items are looked up one by one.
    static constexpr std::size_t most_keys_searched = 32;

    struct Run {
        std::uint32_t key, first, end;
    };

    void add_by_keys(const Range& range, std::vector<KeyedPart>& parts) const {
        for (const Run& run : runs_) {
            const auto begin = positions_.begin() + run.first, end = positions_.begin() + run.end;
            const auto from = std::lower_bound(begin, end, range.first),
                       to = std::lower_bound(from, end, range.first + range.count);
            if (from != to) {
                parts.push_back({run.key, std::uint32_t(from - positions_.begin()), std::uint32_t(to - from)});
            }
        }
    }
    void add_by_items(const Range& range, std::vector<KeyedPart>& parts) const {
        for (std::uint32_t at = range.first; at < range.first + range.count; ++at) {
            const std::uint32_t place = places_[at];
            const auto after = std::upper_bound(runs_.begin(), runs_.end(), place,
                                                [](std::uint32_t p, const Run& run) { return p < run.first; });
            parts.push_back({(after - 1)->key, place, 1});
        }
    }

    std::vector<std::uint32_t> positions_;
    std::vector<std::uint32_t> places_;  ///< in it, by position; empty where there are few keys
    std::vector<Run> runs_;              ///< by key
};

}  // namespace farfield
