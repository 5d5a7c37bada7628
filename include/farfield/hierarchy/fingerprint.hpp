// Telling spans of primitives, and paths of instances, apart by a hash.
#pragma once

#include <bit>
#include <cstdint>
#include <span>

#include "farfield/primitive.hpp"

namespace farfield::detail {

inline std::uint64_t mixed(std::uint64_t hash, std::uint64_t value) {
    hash = (hash ^ value) * 0x9e3779b97f4a7c15u;  // splitmix64's increment and half of its finalizer
    return hash ^ hash >> 29;
}

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

template <Primitive P>
std::uint64_t fingerprint_of(std::span<const P> primitives) {
    std::uint64_t hash = mixed(0, primitives.size());
    for (const P& p : primitives) hash = mixed(hash, primitive_traits<P>::bounds(p));
    return hash;
}

}  // namespace farfield::detail
