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

}  // namespace farfield::detail
