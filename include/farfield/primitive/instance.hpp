// A hierarchy under a transform is a primitive: scenes larger than memory by repetition, to any depth.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <span>

#include "farfield/cost_model.hpp"
#include "farfield/geometry/box.hpp"
#include "farfield/geometry/polygon.hpp"
#include "farfield/geometry/similarity.hpp"
#include "farfield/primitive.hpp"

namespace farfield {

/// `hierarchy` and `primitives` are borrowed and outlive the instance; they are what a Viewer of them would get. P may
/// be a type that holds instances of the same H, so that one type serves any depth (see the README).
///
/// What it offers to the hierarchy it is put into: bounds of its whole contents; the work of drawing it, not of all it
/// holds; and as polygons the six faces of its root's stand-in, turned (or, without one, of its contents).
template <class H, class P>
struct Instance {
    const H* hierarchy = nullptr;
    std::span<const P> primitives;
    Similarity to_world;

    BoxD bounds() const {
        const Box& local = hierarchy->bounds();
        return to_world.apply(
            BoxD{glm::dvec3(local.lower) + hierarchy->origin(), glm::dvec3(local.upper) + hierarchy->origin()});
    }

    Work work() const { return hierarchy->drawing_work(); }

    template <class Sink>
    void polygons(Sink&& sink) const {
        send(AnyPolygonSink(sink));
    }

    template <class F>
    bool visit_instance(F&& f) const {
        f(*this);
        return true;
    }

  private:
    void send(const AnyPolygonSink& sink) const {
        const auto placed = [&](const auto& polygon) {
            map_polygon<double>(
                polygon, [&](auto p) { return to_world.apply(glm::dvec3(p) + hierarchy->origin()); }, sink);
        };
        const AnyPolygonSink any(placed);
        if (hierarchy->root_polygons(any)) return;
        for (const P& p : primitives) {
            if constexpr (PrimitiveWithPolygons<P>) local_polygons(p, hierarchy->origin(), any);
        }
    }
};

}  // namespace farfield
