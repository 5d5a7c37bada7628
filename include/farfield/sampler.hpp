// A sampler makes the colors of stand-ins: it looks at a part of a scene through the six sides of a box.
//
// "A color-cube is created by rendering its list of associated primitives to the screen, using an orthographic
// projection through each of its six faces" (Chamberlain et al. 1996, section 4). A user's renderer can do that by
// modeling OrthographicSampler; GridSampler (sampler/grid_sampler.hpp) is the one built in.
#pragma once

#include "farfield/settings.hpp"

#include <concepts>
#include <cstddef>
#include <glm/vec3.hpp>
#include <optional>
#include <span>

#include "farfield/geometry/box.hpp"
#include "farfield/geometry/light.hpp"
#include "farfield/geometry/polygon.hpp"
#include "farfield/geometry/rgba8.hpp"

namespace farfield {

/// n x n point samples through each side of a box. With more than one slab the box is cut into as many slices along
/// the viewing axis, each seen by itself.
struct SampleGrid {
    Box box;
    unsigned n = 4;
    unsigned slabs = 1;

    /// Samples lie at [side][slab][v][u]: side 0..5 is seen from -x, +x, -y, +y, -z, +z; u and v run along the two axes
    /// after the side's own, in cyclic order, upwards from the lower corner; slabs run upwards too.
    std::size_t size() const { return std::size_t(6) * slabs * n * n; }
    std::size_t index(unsigned side, unsigned slab, unsigned v, unsigned u) const {
        return ((std::size_t(side) * slabs + slab) * n + v) * n + u;
    }
};

namespace archetype {
struct VisitPolygons {
    template <class Sink>
    void operator()(Sink&& sink) const {
        sink(Polygon{});
    }
};
}  // namespace archetype

/// sample(grid, visit, out): `visit(sink)` calls sink(Polygon) for every polygon that may touch the box; parts outside
/// the box are not seen. `out` has grid.size() elements and gets premultiplied colors, all zero where nothing is seen.
/// Copyable, for every build thread has one of its own; equal input must give equal output.
template <class S>
concept OrthographicSampler = std::copyable<S> &&
    requires(S& s, const SampleGrid& grid, archetype::VisitPolygons visit, std::span<Rgba8> out) {
    s.sample(grid, visit, out);
};

/// A sampler that can tell how bright a polygon's side is without drawing it: what areas and colors are added up from.
template <class S>
concept LightsPolygons = requires(const S& s, const Polygon& polygon, glm::vec3 facing_viewer) {
    { s.brightness(polygon, facing_viewer) } -> std::convertible_to<float>;
};

/// A sampler that tells the light in its colors, if there is one, so that viewers can compare it with the renderer's.
template <class S>
concept TellsItsLight = requires(const S& s) {
    { s.light } -> std::convertible_to<std::optional<DirectionalLight>>;
};

namespace archetype {
struct PaintedSink {
    void operator()(const Polygon&) const {}
};
}  // namespace archetype

/// A sampler that knows more of a polygon's looks than its colors say, from the value that it carries:
///
///     template <class Sink> void paint(const Polygon&, const Box& seen, float finest, Sink&& sink) const
///
/// calls sink(Polygon) for what is seen in the polygon's place, in its plane: pieces of a texture, or nothing where it
/// is transparent. Details below `finest` are lost anyway, and so is all outside of `seen`; both in local coordinates,
/// as the polygon. It is asked about each polygon that carries a value, and all that a build makes of polygons, areas,
/// masks and colors, is made of what it sends. paint_texture() (sampler/paint_texture.hpp) does it for textures.
/// Partitions that cut polygons have none left that carry anything, and are refused.
template <class S>
concept PaintsPolygons = requires(const S& s, const Polygon& polygon, const Box& seen, archetype::PaintedSink sink) {
    s.paint(polygon, seen, 1.0f, sink);
};

namespace archetype {
struct Sampler {
    template <class Visit>
    void sample(const SampleGrid&, Visit&&, std::span<Rgba8>) {}
};
}  // namespace archetype

}  // namespace farfield
