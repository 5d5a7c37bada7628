// A sampler that paints (PaintsPolygons) stands between a cell's contents and whatever an approximation makes of them.
#pragma once

#include "farfield/settings.hpp"

#include <type_traits>

#include "farfield/geometry/box.hpp"
#include "farfield/geometry/cell.hpp"
#include "farfield/geometry/polygon.hpp"
#include "farfield/sampler.hpp"

namespace farfield::detail {

/// Of a cell's bounds: masks tell 32 places along a side apart, grids of samples fewer. Texels of half that size are
/// opaque or not, but for few at borders, where larger ones would be translucent: of what is translucent masks only
/// know the mean, and not how much of it lies behind one another.
inline constexpr float places_a_side = 64;

template <class Sampler, class Sink>
struct PaintingSink {
    const Sampler& sampler;
    const Box& seen;
    float finest;
    Sink& sink;

    void operator()(const Polygon& polygon) const {
        if (polygon.carried.is_empty()) {
            sink(polygon);
        } else {
            sampler.paint(polygon, seen, finest, sink);
        }
    }
};

/// Calls f(contents) with the contents of a cell, a function that takes a sink, as the sampler paints them; with what
/// is given itself where the sampler does not paint.
template <class Sampler, class Contents, class F>
decltype(auto) with_painted([[maybe_unused]] const Sampler& sampler, [[maybe_unused]] const Cell& cell,
                            const Contents& contents, F&& f) {
    if constexpr (PaintsPolygons<Sampler>) {
        const Box seen = cell.bounds();
        const float finest = seen.largest_side() / places_a_side;
        return f([&](auto&& sink) {
            PaintingSink<Sampler, std::remove_reference_t<decltype(sink)>> painting{sampler, seen, finest, sink};
            contents(painting);
        });
    } else {
        return f(contents);
    }
}

}  // namespace farfield::detail
