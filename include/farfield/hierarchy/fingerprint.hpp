// Telling spans of primitives apart by a hash.
#pragma once

#include "farfield/settings.hpp"

#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>

#include "farfield/geometry/mixed.hpp"
#include "farfield/primitive.hpp"
#include "farfield/primitive_source.hpp"

namespace farfield::detail {

template <SomeBox B>
std::uint64_t mixed(std::uint64_t hash, const B& b) {
    // One chain of multiplications a box, not three: the chain is what takes the time.
    const auto word = [](float l, float u) {
        return std::uint64_t(std::bit_cast<std::uint32_t>(l)) << 32 | std::bit_cast<std::uint32_t>(u);
    };
    return mixed(hash, word(float(b.lower.x), float(b.upper.x)) * 0xbf58476d1ce4e5b9u ^
                           word(float(b.lower.y), float(b.upper.y)) * 0x94d049bb133111ebu ^
                           word(float(b.lower.z), float(b.upper.z)));
}

/// A sum of hashes, each of a primitive's bounds and its index: who changes one primitive need not look at the others.
class Fingerprint {
  public:
    template <SomeBox B>
    static std::uint64_t part(std::size_t index, const B& bounds) {
        return mixed(mixed(mixed(0, index), bounds), 0);
    }
    void add(std::uint64_t part) { sum_ += part; }
    void remove(std::uint64_t part) { sum_ -= part; }
    /// Of parts that were added: what another one adds for all of them.
    std::uint64_t sum() const { return sum_; }
    std::uint64_t of(std::size_t count) const { return mixed(sum_, count); }

  private:
    std::uint64_t sum_ = 0;
};

/// In an order of indices, or as they lie if that is empty.
template <class Span>
std::uint64_t fingerprint_of(const Span& primitives, std::span<const std::uint32_t> order = {}) {
    using P = PrimitiveIn<Span>;
    Fingerprint sum;
    for (std::size_t i = 0; i < primitives.size(); ++i) {
        sum.add(Fingerprint::part(i, primitive_traits<P>::bounds(primitives[order.empty() ? i : order[i]])));
    }
    return sum.of(primitives.size());
}

}  // namespace farfield::detail
