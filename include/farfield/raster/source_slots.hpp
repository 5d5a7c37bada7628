// Keeps a renderer's sources in the form that it draws.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <glm/vec3.hpp>
#include <memory>
#include <unordered_map>
#include <utility>
#include <vector>

#include "farfield/geometry/mixed.hpp"
#include "farfield/geometry/polygon.hpp"
#include "farfield/renderer.hpp"

namespace farfield::detail {

/// A hash of every vertex and color that a source holds, and at which position.
template <PrimitiveWithPolygons P>
std::uint64_t contents_of(const Source<P>& source) {
    const auto word = [](float a, float b) {
        return std::uint64_t(std::bit_cast<std::uint32_t>(a)) << 32 | std::bit_cast<std::uint32_t>(b);
    };
    std::uint64_t hash = source.item_count;
    for (std::uint32_t at = 0; at < source.item_count; ++at) {
        source.prefetch(at);
        source.polygons(at, [&](const Polygon& polygon) {
            const std::size_t count = polygon.vertices.size(), colors = polygon.colors.size();
            hash = mixed(hash, std::uint64_t(at) << 32 | (count << 1 | std::size_t(colors >= count)));
            for (std::size_t i = 0; i < count; ++i) {
                const glm::vec3 v = polygon.vertices[i];
                const Rgba8 color = polygon.colors[colors >= count ? i : 0];
                hash = mixed(hash, word(v.x, v.y) * 0xbf58476d1ce4e5b9u ^
                                       word(v.z, std::bit_cast<float>(color)) * 0x94d049bb133111ebu);
            }
        });
    }
    return hash;
}

/// Numbers each source with the first free slot; equal ones share it, so that viewers of one hierarchy do not each take
/// its memory again. They are told by what they hold and not by where it lies, since addresses are used again. A Stream
/// is constructed from a Source<P> and never changes, so that renderers may share it, on any threads.
template <class Stream>
class SourceSlots {
  public:
    SourceSlots() = default;
    /// Viewers hold on to where their renderer is.
    SourceSlots(const SourceSlots&) = delete;
    SourceSlots& operator=(const SourceSlots&) = delete;

    /// `options` go to the Stream's constructor. If this throws, nothing is kept.
    template <class P, class... Options>
    std::uint32_t upload(const Source<P>& source, const Options&... options) {
        // What changes is told by where it lies.
        const std::uint64_t contents = source.changes
                                           ? mixed(0x706167, std::uint64_t(std::uintptr_t(source.primitives.data())))
                                           : contents_of(source);
        if (const auto found = slot_of_.find(contents); found != slot_of_.end()) {
            ++slots_[found->second].users;
            return found->second;
        }
        return keep(std::make_shared<const Stream>(source, options...), contents);
    }
    /// Uploads what another has in a slot, without a copy. If this throws, nothing is kept.
    std::uint32_t share(const SourceSlots& other, std::uint32_t id) {
        const Slot& theirs = other.slots_[id];
        if (const auto found = slot_of_.find(theirs.contents); found != slot_of_.end()) {
            ++slots_[found->second].users;
            return found->second;
        }
        return keep(theirs.stream, theirs.contents);
    }
    /// Frees the slot once it was released as often as it was uploaded.
    void release(std::uint32_t id) {
        Slot& slot = slots_[id];
        if (--slot.users != 0) return;
        slot_of_.erase(slot.contents);
        slot.stream.reset();
        free_.push_back(id);
        std::push_heap(free_.begin(), free_.end(), std::greater<>());
    }

    const Stream& operator[](std::uint32_t id) const { return *slots_[id].stream; }

    /// The memory that streams take, shared ones included.
    std::size_t bytes() const {
        std::size_t sum = 0;
        for (const Slot& slot : slots_) sum += slot.stream ? slot.stream->bytes() : 0;
        return sum;
    }

    /// Expires when this goes.
    std::weak_ptr<const void> lifetime() const { return alive_; }

  private:
    struct Slot {
        std::shared_ptr<const Stream> stream{};
        std::uint64_t contents = 0;
        std::uint32_t users = 0;
    };

    std::uint32_t keep(std::shared_ptr<const Stream> stream, std::uint64_t contents) {
        if (free_.empty()) {
            // Room for all, so that release() needs no memory.
            if (free_.capacity() == slots_.size()) free_.reserve(2 * slots_.size() + 1);
            slots_.emplace_back();
            free_.push_back(std::uint32_t(slots_.size() - 1));
        }
        slot_of_.emplace(contents, free_.front());
        std::pop_heap(free_.begin(), free_.end(), std::greater<>());
        const std::uint32_t id = free_.back();
        free_.pop_back();
        slots_[id] = {std::move(stream), contents, 1};
        return id;
    }

    std::vector<Slot> slots_;
    std::vector<std::uint32_t> free_;                           ///< a heap, first slot on top
    std::unordered_map<std::uint64_t, std::uint32_t> slot_of_;  ///< by contents
    std::shared_ptr<const char> alive_ = std::make_shared<const char>('\0');
};

}  // namespace farfield::detail
