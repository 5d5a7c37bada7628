// Orders in which the parts of a scene are visited, and how strict they are.
#pragma once

#include "farfield/settings.hpp"

#include <array>
#include <cstdint>

namespace farfield {

/// The order in which cells are visited.
enum class VisitOrder : std::uint8_t { any, front_to_back, back_to_front };

/// The strictness of an order: it holds nowhere, between cells, or between primitives.
enum class OrderGuarantee : std::uint8_t { none, cells, primitives };

/// Numbers of a node's children, of which there are at most eight, in the order in which they are to be visited.
using ChildOrder = std::array<std::uint8_t, 8>;

}  // namespace farfield
