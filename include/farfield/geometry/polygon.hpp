// Convex polygons, which primitives are tessellated into: seen as spans, never owned.
#pragma once

#include "farfield/settings.hpp"

#include <cstddef>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <span>
#include <type_traits>

#include "farfield/geometry/rgba8.hpp"

namespace farfield {

/// A value of the user's that a polygon takes along to whoever asks for that type: a material, texture coordinates. It
/// is borrowed, as all of the polygon is. What asks for another type gets nothing.
class CarriedValue {
  public:
    CarriedValue() = default;
    template <class T>
    requires(!std::is_same_v<T, CarriedValue>)
        CarriedValue(const T& value)  // NOLINT(google-explicit-constructor): any value is carried
        : value_(&value), type_(&type_of<T>) {}

    bool is_empty() const { return value_ == nullptr; }
    /// Null if none of exactly this type is carried.
    template <class T>
    const T* get() const {
        return type_ == &type_of<T> ? static_cast<const T*>(value_) : nullptr;
    }

  private:
    template <class T>
    static constexpr char type_of = 0;  ///< its address tells types apart

    const void* value_ = nullptr;
    const char* type_ = nullptr;
};

/// A convex planar polygon of three or more vertices, counter-clockwise seen from its front. Both sides are visible.
/// `colors` holds one color for all, or one a vertex, not premultiplied. It is valid only during the call that it is
/// passed to.
template <class T>
struct BasicPolygon {
    std::span<const glm::vec<3, T>> vertices;
    std::span<const Rgba8> colors;
    /// Whether the colors hold the light already, as those of stand-ins do, whose light was baked in by the build.
    bool is_lit = false;
    /// For a sampler or a renderer that knows the type: see PaintsPolygons (sampler.hpp). Vertices keep their numbers
    /// on the way there, but for polygons that map_polygon() divides, and those that a partition cuts: they lose it.
    CarriedValue carried{};
};

using Polygon = BasicPolygon<float>;
using PolygonD = BasicPolygon<double>;

/// Calls f(a, b, c) with the numbers of the corners of each triangle that a convex polygon of that many corners fans
/// out into; a is always 0.
template <class F>
void for_each_triangle(std::size_t corners, F&& f) {
    for (std::size_t i = 2; i < corners; ++i) f(std::size_t(0), i - 1, i);
}

/// Twice the area of a convex polygon along its normal (Newell); position(i) gives corner i. Exactly 0 in double
/// precision where all corners lie on one line, unless single-precision coordinates differ by a factor of 2^29.
template <class T, class Position>
glm::vec<3, T> doubled_area(std::size_t corners, Position&& position) {
    glm::vec<3, T> sum(0);
    for_each_triangle(corners, [&](std::size_t a, std::size_t b, std::size_t c) {
        const glm::vec<3, T> first(position(a));
        sum += glm::cross(glm::vec<3, T>(position(b)) - first, glm::vec<3, T>(position(c)) - first);
    });
    return sum;
}

/// Calls sink(BasicPolygon<To>) with the polygon's vertices mapped, all else as it is; polygons of more than 64
/// vertices come as several that fan out from the first vertex and carry nothing. Polygons of fewer than three
/// vertices, or without a color, are dropped.
template <class To, class From, class Map, class Sink>
void map_polygon(const BasicPolygon<From>& polygon, Map&& map, Sink&& sink) {
    constexpr std::size_t capacity = 64;
    const std::size_t n = polygon.vertices.size();
    if (n < 3 || polygon.colors.empty()) return;
    const bool one_color = polygon.colors.size() < n;
    glm::vec<3, To> vertices[capacity];
    Rgba8 colors[capacity];
    vertices[0] = map(polygon.vertices[0]);
    colors[0] = polygon.colors[0];
    for (std::size_t first = 1; first + 1 < n;) {
        const std::size_t count = n - first < capacity - 1 ? n - first : capacity - 1;
        for (std::size_t i = 0; i < count; ++i) {
            vertices[i + 1] = map(polygon.vertices[first + i]);
            colors[i + 1] = polygon.colors[one_color ? 0 : first + i];
        }
        sink(BasicPolygon<To>{{vertices, count + 1},
                              {colors, one_color ? 1 : count + 1},
                              polygon.is_lit,
                              n <= capacity ? polygon.carried : CarriedValue()});
        first += count - 1;
    }
}

/// A borrowed sink of polygons whose type is erased: where primitives hold primitives of their own type, passing a sink
/// down by its type would make a new type at every level, without end.
class AnyPolygonSink {
  public:
    template <class Sink>
    explicit AnyPolygonSink(Sink& sink)
        : sink_(&sink),
          single_([](const void* s, const Polygon& p) { (*static_cast<Sink*>(const_cast<void*>(s)))(p); }),
          double_([](const void* s, const PolygonD& p) { (*static_cast<Sink*>(const_cast<void*>(s)))(p); }) {}

    void operator()(const Polygon& polygon) const { single_(sink_, polygon); }
    void operator()(const PolygonD& polygon) const { double_(sink_, polygon); }

  private:
    const void* sink_;
    void (*single_)(const void*, const Polygon&);
    void (*double_)(const void*, const PolygonD&);
};

}  // namespace farfield
