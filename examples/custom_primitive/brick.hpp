// One type for a scene of any depth: a triangle, or an instance of a hierarchy over the very same type.
#pragma once

#include <variant>

#include "farfield/approximation/color_cube.hpp"
#include "farfield/cost_model/triangle_count.hpp"
#include "farfield/partition/octree.hpp"
#include "farfield/primitive/instance.hpp"
#include "farfield/primitive/triangle.hpp"
#include "farfield/spatial_hierarchy.hpp"

using Hierarchy = farfield::SpatialHierarchy<farfield::Octree, farfield::ColorCube, farfield::TriangleCount>;

struct Brick {
    using Instance = farfield::Instance<Hierarchy, Brick>;

    std::variant<farfield::Triangle, Instance> is;

    const farfield::Triangle* triangle() const { return std::get_if<farfield::Triangle>(&is); }
    const Instance* instance() const { return std::get_if<Instance>(&is); }

    // An instance has its bounds in double, so all have.
    farfield::BoxD bounds() const {
        if (instance()) return instance()->bounds();
        const farfield::Box b = triangle()->bounds();
        return {glm::dvec3(b.lower), glm::dvec3(b.upper)};
    }

    farfield::Work work() const { return instance() ? instance()->work() : farfield::Work{.triangles = 1}; }

    template <class Sink>
    void polygons(Sink&& sink) const {
        instance() ? instance()->polygons(sink) : triangle()->polygons(sink);
    }

    /// This is what makes it an instance to the library.
    template <class F>
    bool visit_instance(F&& f) const {
        if (instance()) f(*instance());
        return instance() != nullptr;
    }
};

static_assert(farfield::PrimitiveWithInstance<Brick> && farfield::PrimitiveWithPolygons<Brick>);
static_assert(!farfield::PrimitiveWithInstance<farfield::Triangle>);
