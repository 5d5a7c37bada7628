#include "farfield/hierarchy/node.hpp"

#include <cmath>
#include <type_traits>

#include "catch.hpp"

using namespace farfield;

static_assert(std::is_trivially_copyable_v<Node> && std::has_unique_object_representations_v<Node>);

TEST_CASE("a stand-in in place of others has their error: half for each level") {
    for (unsigned levels = 0; levels < 256; ++levels) {
        const Node node{.levels_replaced = std::uint8_t(levels)};
        const float factor = detail::error_of_replaced_levels(node);
        CHECK(factor > 0);
        if (levels <= 126) CHECK(factor == std::ldexp(1.0f, -int(levels)));
    }
    CHECK(detail::error_of_replaced_levels(Node{}) == 1);
}

TEST_CASE("a node by itself is a leaf with nothing below") {
    const Node node;
    CHECK(node.first_child == 0);
    CHECK(node.child_mask == 0);
    CHECK(node.stand_in_levels_below == Node::nothing_below);
}
