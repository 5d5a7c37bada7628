// A hierarchy under a transform is a primitive: scenes larger than memory by repetition, to any depth.
#pragma once

#include "farfield/settings.hpp"

#include <cstdint>
#include <glm/vec3.hpp>
#include <span>

#include "farfield/cost_model.hpp"
#include "farfield/geometry/box.hpp"
#include "farfield/geometry/polygon.hpp"
#include "farfield/geometry/similarity.hpp"
#include "farfield/primitive.hpp"
#include "farfield/primitive_source.hpp"

namespace farfield {

/// `hierarchy` and `primitives` are borrowed and outlive the instance; a Viewer would get the same. P may be a type
/// that holds instances of the same H, so that one type serves any depth (examples/custom_primitive/brick.hpp).
///
/// The hierarchy that holds it sees the bounds of its whole contents, the work of drawing it where it is small, and the
/// polygons of its root's stand-in (or, without one, of its contents), turned.
template <class H, class P>
struct Instance {
    const H* hierarchy = nullptr;
    PrimitiveSpan<P> primitives;
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
