// What the user brings to be drawn: any type with a bounding box. "All that is required is to be able to determine the
// bounding box of each primitive and to render it" (Chamberlain et al. 1996, section 4).
//
// A type plugs in by members or, where it cannot be changed, by a specialization of primitive_traits<T>; an object that
// answers for the primitive of an index, by members that get it (primitive_source.hpp):
//
//   bounds()         -> Box or BoxD       required: finite, lower <= upper; double where the scene is far from 0
//   polygons(sink)   -> void              sink(Polygon) or sink(PolygonD) for each convex polygon it is made of
//   color()          -> glm::vec4         mean color, not premultiplied, channels in [0, 1]
//   work()           -> Work              what drawing it takes; default: one triangle
//   key()            -> std::uint32_t     what it is drawn with, a material: see key_of
//   visit_instance(f)-> bool              f(instance) and true if it is an Instance (instance.hpp), else false
#pragma once

#include "farfield/settings.hpp"

#include <concepts>
#include <cstdint>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <span>
#include <type_traits>

#include "farfield/cost_model.hpp"
#include "farfield/geometry/box.hpp"
#include "farfield/geometry/polygon.hpp"

namespace farfield {

namespace detail {
template <class P>
concept HasBounds = requires(const P& p) {
    p.bounds();
};
template <class P, class Sink>
concept HasPolygons = requires(const P& p, Sink& sink) {
    p.polygons(sink);
};
template <class P>
concept HasColor = requires(const P& p) {
    { p.color() } -> std::convertible_to<glm::vec4>;
};
template <class P>
concept HasWork = requires(const P& p) {
    { p.work() } -> std::same_as<Work>;
};
template <class P>
concept HasKey = requires(const P& p) {
    { p.key() } -> std::same_as<std::uint32_t>;
};
template <class P, class F>
concept HasVisitInstance = requires(const P& p, F& f) {
    { p.visit_instance(f) } -> std::convertible_to<bool>;
};
}  // namespace detail

/// Specialize for types that cannot have members; give static functions of the same names that take the primitive
/// first. A specialization replaces this template whole.
template <class P>
struct primitive_traits {
    // clang-format off
    static auto bounds(const P& p) requires detail::HasBounds<P> { return p.bounds(); }
    template <class Sink>
    static void polygons(const P& p, Sink&& sink) requires detail::HasPolygons<P, Sink> { p.polygons(sink); }
    static glm::vec4 color(const P& p) requires detail::HasColor<P> { return p.color(); }
    static Work work(const P& p) requires detail::HasWork<P> { return p.work(); }
    static std::uint32_t key(const P& p) requires detail::HasKey<P> { return p.key(); }
    template <class F>
    static bool visit_instance(const P& p, F&& f) requires detail::HasVisitInstance<P, F> { return p.visit_instance(f); }
    // clang-format on
};

namespace archetype {
struct PolygonSink {
    void operator()(const Polygon&) const {}
    void operator()(const PolygonD&) const {}
};
struct InstanceVisitor {
    template <class Instance>
    void operator()(const Instance&) const {}
};
}  // namespace archetype

template <class B>
concept SomeBox = std::same_as<B, Box> || std::same_as<B, BoxD>;

template <class P>
concept Primitive = requires(const P& p) {
    { primitive_traits<P>::bounds(p) } -> SomeBox;
};

template <class P>
concept PrimitiveWithPolygons = Primitive<P> && requires(const P& p, archetype::PolygonSink sink) {
    primitive_traits<P>::polygons(p, sink);
};

template <class P>
concept PrimitiveWithColor = Primitive<P> && requires(const P& p) {
    { primitive_traits<P>::color(p) } -> std::convertible_to<glm::vec4>;
};

template <class P>
concept PrimitiveWithWork = Primitive<P> && requires(const P& p) {
    { primitive_traits<P>::work(p) } -> std::same_as<Work>;
};

template <class P>
concept PrimitiveWithKey = Primitive<P> && requires(const P& p) {
    { primitive_traits<P>::key(p) } -> std::same_as<std::uint32_t>;
};

template <class P>
concept PrimitiveWithInstance = Primitive<P> && requires(const P& p, archetype::InstanceVisitor f) {
    { primitive_traits<P>::visit_instance(p, f) } -> std::same_as<bool>;
};

template <Primitive P>
Work work_of(const P& p) {
    if constexpr (PrimitiveWithWork<P>) {
        return primitive_traits<P>::work(p);
    } else {
        return {.triangles = 1};
    }
}

/// What a primitive is drawn with, a material or a texture, as a number: primitives of one key lie side by side in
/// every run of a hierarchy, in the order of their keys, so that a renderer that changes its state with the key does so
/// a few times a run (for_each_key in drawables.hpp), or, in an order of its own, once a range (KeyedOrder). Pieces
/// that a partition cuts, and the runs of sample sets, whose first primitives are their sample, stay in their own
/// order.
template <PrimitiveWithKey P>
std::uint32_t key_of(const P& p) {
    return primitive_traits<P>::key(p);
}

template <Primitive P>
inline constexpr bool has_double_bounds =
    std::same_as<decltype(primitive_traits<P>::bounds(std::declval<const P&>())), BoxD>;

/// A primitive as a hierarchy with this origin sees it.
template <Primitive P>
Box local_bounds(const P& p, glm::dvec3 origin) {
    const auto b = primitive_traits<P>::bounds(p);
    if constexpr (has_double_bounds<P>) {
        return {glm::vec3(b.lower - origin), glm::vec3(b.upper - origin)};
    } else {
        // Not through double: a scene in single precision stays as it is where the origin is 0.
        const glm::vec3 o(origin);
        return {b.lower - o, b.upper - o};
    }
}

namespace detail {
template <class Sink>
struct LocalPolygonSink {
    Sink& sink;
    glm::dvec3 origin;

    void operator()(const Polygon& polygon) const {
        if (origin != glm::dvec3(0)) {
            moved(polygon);
        } else if (polygon.vertices.size() >= 3 && !polygon.colors.empty()) {
            sink(polygon);
        }
    }
    void operator()(const PolygonD& polygon) const { moved(polygon); }

  private:
    void moved(const auto& polygon) const {
        map_polygon<float>(
            polygon, [&](auto v) { return glm::vec3(glm::dvec3(v) - origin); }, sink);
    }
};
}  // namespace detail

/// Calls sink(Polygon) with the primitive's polygons less the origin; where that is 0, vertices in single precision
/// pass through untouched. See map_polygon for what else may happen to them.
template <PrimitiveWithPolygons P, class Sink>
void local_polygons(const P& p, glm::dvec3 origin, Sink&& sink) {
    primitive_traits<P>::polygons(p, detail::LocalPolygonSink<std::remove_reference_t<Sink>>{sink, origin});
}

}  // namespace farfield
