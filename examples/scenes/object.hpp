// One primitive type for scenes of any nesting: a triangle, or an instance of a hierarchy over such objects.
#pragma once

#include <type_traits>
#include <utility>
#include <variant>

#include "farfield/primitive/instance.hpp"
#include "farfield/primitive/triangle.hpp"

namespace farfield::scenes {

/// Groups without placements are hierarchies over plain triangles, which are smaller and quicker to read; so there are
/// two kinds of instances, which may be of two kinds of hierarchies.
template <class Hierarchy, class OfTriangles = Hierarchy>
struct Object {
    using Triangle = VertexColoredTriangle;
    using InstanceOfTriangles = Instance<OfTriangles, Triangle>;
    using InstanceOfObjects = Instance<Hierarchy, Object>;

    std::variant<Triangle, InstanceOfTriangles, InstanceOfObjects> is;

    BoxD bounds() const {
        return std::visit(
            [](const auto& it) {
                const auto b = it.bounds();
                return BoxD{glm::dvec3(b.lower), glm::dvec3(b.upper)};
            },
            is);
    }
    Work work() const {
        return std::visit([](const auto& it) { return work_of(it); }, is);
    }
    template <class Sink>
    void polygons(Sink&& sink) const {
        std::visit([&](const auto& it) { it.polygons(sink); }, is);
    }
    template <class F>
    bool visit_instance(F&& f) const {
        return std::visit(
            [&]<class T>(const T& it) {
                if constexpr (!std::is_same_v<T, Triangle>) f(it);
                return !std::is_same_v<T, Triangle>;
            },
            is);
    }
};

}  // namespace farfield::scenes
