// Before a build divides the scene it learns what holds for the whole, and refuses primitives that cannot be drawn.
#pragma once

#include "farfield/settings.hpp"

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <stdexcept>
#include <string>

#include "farfield/composition.hpp"
#include "farfield/fail.hpp"
#include "farfield/hierarchy/fingerprint.hpp"
#include "farfield/hierarchy/hierarchy_data.hpp"

namespace farfield::detail {

[[noreturn]] inline void refuse_primitive(std::size_t index, const char* why) {
    detail::fail<std::invalid_argument>("farfield: primitive " + std::to_string(index) + " " + why);
}

/// The reason why a primitive cannot be an instance, or null.
template <Primitive P>
const char* wrong_instance([[maybe_unused]] const P& p) {
    const char* why = nullptr;
    if constexpr (PrimitiveWithInstance<P>) {
        primitive_traits<P>::visit_instance(p, [&](const auto& instance) {
            if (instance.hierarchy == nullptr) {
                why = "is an instance without a hierarchy";
            } else if (instance.primitives.size() != instance.hierarchy->primitive_count()) {
                why = "is an instance with fewer or more primitives than its hierarchy was built from";
            }
        });
    }
    return why;
}

/// Fills in what `facts` say of the whole scene, except for the root, and calls take(Item) for each primitive.
template <CostModel C, Primitive P, class Take>
void read_primitives(std::span<const P> primitives, const C& cost, HierarchyFacts& facts, Take&& take) {
    if (primitives.size() > 0xfffffff0u) {
        detail::fail<std::invalid_argument>(
            "farfield: more than 2^32 - 16 primitives; use instances or several hierarchies");
    }
    facts.fingerprint = mixed(0, primitives.size());
    auto whole = decltype(primitive_traits<P>::bounds(std::declval<const P&>()))::empty();
    for (std::size_t i = 0; i < primitives.size(); ++i) {
        if (const char* why = wrong_instance(primitives[i])) refuse_primitive(i, why);
        const auto b = primitive_traits<P>::bounds(primitives[i]);
        if (b.is_empty()) refuse_primitive(i, "has an empty bounding box (lower > upper)");
        if (!b.is_finite()) refuse_primitive(i, "has a bounding box that is not finite (NaN or infinity)");
        whole.add(b);
        facts.fingerprint = mixed(facts.fingerprint, b);
    }
    if constexpr (has_double_bounds<P>) {
        if (!whole.is_empty()) facts.origin = whole.center();
    }
    for (std::size_t i = 0; i < primitives.size(); ++i) {
        const Work work = work_of(primitives[i]);
        const Item item{local_bounds(primitives[i], facts.origin), std::uint32_t(i), cost.cost(work)};
        if (!(item.cost >= 0)) refuse_primitive(i, "has a cost below 0 or NaN");
        facts.bounds.add(item.bounds);
        if (!facts.bounds.is_finite() || !std::isfinite(4 * facts.bounds.largest_side()))
            refuse_primitive(i, "makes the scene's extent overflow single precision");
        facts.work += work;
        take(item);
    }
    facts.primitive_count = primitives.size();
    facts.report.primitives = primitives.size();
}

}  // namespace farfield::detail
