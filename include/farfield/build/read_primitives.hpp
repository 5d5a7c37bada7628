// Before a build divides the scene it learns what holds for the whole, and refuses primitives that cannot be drawn.
#pragma once

#include "farfield/settings.hpp"

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>

#include "farfield/composition.hpp"
#include "farfield/fail.hpp"
#include "farfield/hierarchy/fingerprint.hpp"
#include "farfield/hierarchy/hierarchy_data.hpp"
#include "farfield/primitive_source.hpp"

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

template <Primitive P>
auto checked_bounds(const P& primitive, std::size_t index) {
    if (const char* why = wrong_instance(primitive)) refuse_primitive(index, why);
    const auto bounds = primitive_traits<P>::bounds(primitive);
    if (bounds.is_empty()) refuse_primitive(index, "has an empty bounding box (lower > upper)");
    if (!bounds.is_finite()) refuse_primitive(index, "has a bounding box that is not finite (NaN or infinity)");
    return bounds;
}

/// What a primitive takes of the scene: its item, and the work of drawing it.
template <CostModel C, Primitive P>
std::pair<Item, Work> read_item(const P& primitive, std::size_t index, const C& cost, glm::dvec3 origin) {
    const Work work = work_of(primitive);
    const Item item{local_bounds(primitive, origin), std::uint32_t(index), cost.cost(work)};
    if (!(item.cost >= 0)) refuse_primitive(index, "has a cost below 0 or NaN");
    return {item, work};
}

/// The work of many primitives. A sum of floats stands still at 2^24; this one does not depend on the order either,
/// where work is counted in whole units.
class WorkSum {
  public:
    void add(const Work& w) {
        const std::array<float, 7> counts{w.triangles, w.faces, w.splats, w.images, w.texels, w.cells, w.runs};
        for (std::size_t kind = 0; kind < counts.size(); ++kind) sums_[kind] += double(counts[kind]);
    }
    Work total() const {
        return {float(sums_[0]), float(sums_[1]), float(sums_[2]), float(sums_[3]),
                float(sums_[4]), float(sums_[5]), float(sums_[6])};
    }

  private:
    std::array<double, 7> sums_{};
};

inline void add_bounds(Box& all, const Box& bounds, std::size_t index) {
    all.add(bounds);
    if (!all.is_finite() || !std::isfinite(4 * all.largest_side()))
        refuse_primitive(index, "makes the scene's extent overflow single precision");
}

inline void check_primitive_count(std::size_t count) {
    if (count > 0xfffffff0u) {
        detail::fail<std::invalid_argument>(
            "farfield: more than 2^32 - 16 primitives; use instances or several hierarchies");
    }
}

/// Where the hierarchy's coordinates begin: `whole` has all bounds, as primitives give them.
template <Primitive P>
glm::dvec3 origin_of(const auto& whole, BoxD world) {
    if constexpr (has_double_bounds<P>) {
        world.add(whole);
        if (!world.is_empty()) return world.center();
    }
    return glm::dvec3(0);
}

/// What the root's cell is made for: all that there is, and BuildOptions::world.
inline Box bounds_of_root(const HierarchyFacts& facts, const BoxD& world) {
    Box bounds = facts.bounds;
    if (!world.is_empty()) {
        bounds.add(Box{glm::vec3(world.lower - facts.origin), glm::vec3(world.upper - facts.origin)});
        if (!bounds.is_finite() || !std::isfinite(4 * bounds.largest_side()))
            detail::fail<std::invalid_argument>("farfield: BuildOptions::world overflows single precision");
    }
    return bounds;
}

/// Fills in what `facts` say of the whole scene, except for the root, and calls take(Item) for each primitive.
template <CostModel C, class Span, class Take>
void read_primitives(const Span& primitives, const C& cost, const BoxD& world, HierarchyFacts& facts, Take&& take) {
    using P = PrimitiveIn<Span>;
    check_primitive_count(primitives.size());
    Fingerprint fingerprint;
    auto whole = decltype(primitive_traits<P>::bounds(std::declval<const P&>()))::empty();
    for (std::size_t i = 0; i < primitives.size(); ++i) {
        const auto b = checked_bounds(primitives[i], i);
        whole.add(b);
        fingerprint.add(Fingerprint::part(i, b));
    }
    facts.fingerprint = fingerprint.of(primitives.size());
    facts.origin = origin_of<P>(whole, world);
    WorkSum work_of_all;
    for (std::size_t i = 0; i < primitives.size(); ++i) {
        const auto [item, work] = read_item(primitives[i], i, cost, facts.origin);
        add_bounds(facts.bounds, item.bounds, i);
        work_of_all.add(work);
        take(item);
    }
    facts.work = work_of_all.total();
    facts.primitive_count = primitives.size();
    facts.report.primitives = primitives.size();
}

/// The same of a part of a scene, whose primitives have been read as those of the whole: nothing is summed up again.
template <CostModel C, class Span, class Take>
void read_part(const Span& primitives, const C& cost, glm::dvec3 origin, HierarchyFacts& facts, Take&& take) {
    facts.origin = origin;
    facts.primitive_count = facts.report.primitives = primitives.size();
    for (std::size_t i = 0; i < primitives.size(); ++i) take(read_item(primitives[i], i, cost, origin).first);
}

}  // namespace farfield::detail
