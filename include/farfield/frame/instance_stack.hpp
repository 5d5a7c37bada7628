// Instances that a descent has met and not drawn yet: their stand-ins must come after those of what lies before them.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "farfield/primitive.hpp"
#include "farfield/renderer.hpp"

namespace farfield::detail {

/// A stack of runs, each sorted by its key. A viewer's own.
class InstanceStack {
  public:
    std::size_t size() const { return entries_.size(); }
    void resize(std::size_t size) { entries_.resize(size); }

    /// Positions [first, end): draw_range(begin, end) of what is no instance; instances that is_new(position) does not
    /// deny go on the stack, smallest key(center of bounds) first.
    template <class P, class Key, class IsNew, class DrawRange>
    void gather(const Source<P>& source, std::uint32_t first, std::uint32_t end, Key&& key, IsNew&& is_new,
                DrawRange&& draw_range) {
        const auto base = std::ptrdiff_t(entries_.size());
        std::uint32_t begin = first;
        for (std::uint32_t at = first; at < end; ++at) {
            if (!primitive_traits<P>::visit_instance(source[at], [](const auto&) {})) continue;
            draw_range(begin, at);
            begin = at + 1;
            const Box box = local_bounds(source[at], source.origin);
            if (is_new(at)) entries_.push_back({key(box.center()), at});
        }
        draw_range(begin, end);
        std::sort(entries_.begin() + base, entries_.end());
    }

    /// Calls draw(position) for those from `next` on that come before a key; returns the first that does not. What
    /// draw() puts on the stack it takes away.
    template <class Draw>
    std::size_t draw_before(std::size_t next, float end_key, Draw&& draw) {
        for (; next < entries_.size() && entries_[next].first < end_key; ++next) draw(entries_[next].second);
        return next;
    }

  private:
    std::vector<std::pair<float, std::uint32_t>> entries_;  ///< key, position
};

}  // namespace farfield::detail
