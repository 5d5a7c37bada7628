// The step of every hash that tells things apart: spans of primitives, paths of instances, what was uploaded.
#pragma once

#include "farfield/settings.hpp"

#include <cstdint>

namespace farfield::detail {

/// One to one in either argument while the other stays.
inline std::uint64_t mixed(std::uint64_t hash, std::uint64_t value) {
    hash = (hash ^ value) * 0x9e3779b97f4a7c15u;  // splitmix64's increment and half of its finalizer
    return hash ^ hash >> 29;
}

/// The value that mixed() has made of a hash what it is now.
inline std::uint64_t unmixed(std::uint64_t hash, std::uint64_t result) {
    constexpr std::uint64_t inverse = 0xf1de83e19937733du;
    static_assert(inverse * 0x9e3779b97f4a7c15u == 1);
    return ((result ^ result >> 29 ^ result >> 58) * inverse) ^ hash;
}

}  // namespace farfield::detail
