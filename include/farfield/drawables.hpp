// A renderer is handed these: ranges of primitives, the source they come from, and what stands in for a cell.
#pragma once

#include "farfield/settings.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <limits>
#include <optional>
#include <span>
#include <utility>

#include "farfield/geometry/area_law.hpp"
#include "farfield/geometry/fragments.hpp"
#include "farfield/geometry/polygon.hpp"
#include "farfield/geometry/rgba8.hpp"
#include "farfield/primitive.hpp"
#include "farfield/primitive_source.hpp"

namespace farfield {

/// Positions [first, first + count) in a hierarchy's order of items.
struct Range {
    std::uint32_t first = 0;
    std::uint32_t count = 0;
    /// The law by which the primitives of its cell go together, for a renderer that deposits the small ones.
    /// Unset: unknown, or nobody asked; each primitive is then drawn for itself.
    std::optional<AreaLaw> law{};
};

/// Where the primitives of a run come from. Spans stay valid as long as the viewer that hands it over.
template <class P>
struct Source {
    PrimitiveSpan<P> primitives;
    std::span<const std::uint32_t> order;  ///< position -> index into primitives; empty: positions are indices
    std::uint32_t item_count = 0;          ///< number of positions; larger than primitives.size() where shared or cut
    glm::dvec3 origin{0};                  ///< subtract it from the primitive's coordinates to get the local ones
    std::uint32_t id = 0;                  ///< what upload returned for it
    Fragments fragments{};                 ///< what positions hold instead of whole primitives, if the partition cuts
    /// Positions come and go from frame to frame, and most may hold nothing: only those in ranges are primitives, while
    /// the frame lasts, and nothing may be kept of them.
    bool changes = false;

    /// The primitive, or the one that the position's fragment is a piece of.
    decltype(auto) operator[](std::uint32_t position) const { return primitives[index_of(position)]; }
    /// The number of that primitive among all that there are.
    std::uint32_t index_of(std::uint32_t position) const { return order.empty() ? position : order[position]; }

    /// Tells that positions from this one on are wanted in turn: in memory they lie all over, where there is an order.
    void prefetch(std::uint32_t position) const {
        constexpr std::uint32_t ahead = 12;
        if (order.empty() || !fragments.empty() || order.size() - position <= ahead) return;
        detail::prefetch_primitive<P>(primitives, order[position + ahead]);
    }

    /// Calls sink(Polygon) with what the position holds, in local coordinates: prefer it to the primitive's own
    /// polygons, which a partition may have cut. Of an instance nothing.
    template <class Sink>
    void polygons(std::uint32_t position, Sink&& sink) const requires PrimitiveWithPolygons<P> {
        if (!fragments.empty()) {
            if (const Polygon fragment = fragments[position]; !fragment.vertices.empty()) sink(fragment);
            return;
        }
        const P& primitive = (*this)[position];
        if constexpr (PrimitiveWithInstance<P>) {
            if (primitive_traits<P>::visit_instance(primitive, [](const auto&) {})) return;
        }
        local_polygons(primitive, origin, sink);
    }
};

/// Calls f(key, part) for the parts of a range whose primitives have one key each (key_of), in their order: a draw call
/// each, in the same state.
template <PrimitiveWithKey P, class F>
void for_each_key(const Source<P>& source, const Range& range, F&& f) {
    Range part = range;
    for (std::uint32_t at = range.first, end = at + range.count; at < end; at = part.first + part.count) {
        const std::uint32_t key = key_of(source[at]);
        part.first = at++;
        while (at < end && key_of(source[at]) == key) ++at;
        part.count = at - part.first;
        f(key, std::as_const(part));
    }
}

/// A node of a hierarchy, unique over all paths of instances and stable from frame to frame.
struct CellId {
    std::uint64_t path = 0;  ///< a hash of the primitives entered from the outermost hierarchy on; 0: none
    std::uint32_t node = 0;
};

/// A far-field face: an axis-aligned rectangle in local coordinates, lower == upper on its axis.
struct Face {
    glm::vec3 lower;
    glm::vec3 upper;
    Rgba8 rgba;         ///< premultiplied; alpha is the opacity seen squarely
    std::uint8_t side;  ///< 0..5: looks to -x, +x, -y, +y, -z, +z
};

/// A far-field cell small enough to have no shape: something of this opacity, deposited over an upright rectangle of
/// the picture by the area law (geometry/area_law.hpp).
struct Splat {
    glm::vec3 center;
    glm::vec2 size;  ///< width and height, as local lengths at the center's depth; above 0
    float opacity;   ///< of what lies in it, 0 to 1
    Rgba8 rgb;       ///< of what covers, not premultiplied; alpha holds the area law's class
};

/// Stand-ins as they are stored, each in its cell, for a renderer that makes splats of them itself. They are the same
/// words in every view and every frame: what a renderer has seen of them it can keep, and know by its words.
struct PlacedStandIns {
    enum class Kind : std::uint8_t {
        tensors,  ///< words of PlacedTensor (approximation/opacity_tensor/appearance_lanes.hpp)
        cubes,    ///< words of PlacedCube (approximation/color_cube/cube_lanes.hpp)
    };
    /// Words of one kind lie side by side: word i of number k is words[i * stride + k].
    static constexpr std::size_t stride = 256;

    Kind kind = Kind::tensors;
    bool closed_surfaces = false, counts_overlap = true;  ///< of tensors, as is the next: see OpacityTensor
    float sheet_gain = 1;
    const std::uint32_t* words = nullptr;
    std::size_t count = 0;  ///< `stride` at most

    /// Of one.
    constexpr std::size_t word_count() const { return kind == Kind::tensors ? 10 : 12; }
};

/// The first `count` of the primitives in a cell's subtree, own ones first, or as many as there are: what a stand-in
/// may be made of where cells hold samples of their contents.
struct OwnRun {
    std::uint32_t count = 0;
};

/// A depth slice of an image that is to be kept: it holds what lies between two depths, and its rectangle will lie at
/// `depth`; local units. Slices overlap a little, so that surfaces that go through several have no gaps.
struct ImageSlice {
    float depth = 1;
    float nearest = -std::numeric_limits<float>::infinity(), farthest = std::numeric_limits<float>::infinity();
};

/// An image that a renderer keeps, as a rectangle in space, in local coordinates: the image's upper left corner lies at
/// `corner`, its width along `across`, its height along `down` (Shade et al. 1996, section 2). Colors are premultiplied
/// and drawn over what lies behind.
struct ImageQuad {
    std::uint32_t image = 0;  ///< what end_image returned
    glm::vec3 corner{0}, across{0}, down{0};
    /// Drawn into this part of all samples and into no others, so that of two images one gives way to the other and
    /// nothing shows through both: into samples whose fade_order(), in 64ths, lies in [first_part, end_part).
    float first_part = 0, end_part = 1;
};

/// An order in which an image appears, evenly all over the picture, a number below 64 for a sample of the whole
/// picture: B. Bayer, "An optimum method for two-level rendition of continuous-tone pictures", ICC 1973.
constexpr int fade_order(int x, int y) {
    int order = 0;
    for (int bit = 0; bit < 3; ++bit) {
        order |= ((((x ^ y) >> bit & 1) << 1) | (y >> bit & 1)) << (2 * (2 - bit));
    }
    return order;
}

/// Calls sink(Polygon) with a face, its color no longer premultiplied; not where nothing would be seen of it.
template <class Sink>
void emit_polygon(const Face& face, Sink&& sink) {
    if (face.rgba.a == 0) return;
    const int axis = face.side / 2, u = (axis + 1) % 3, v = (axis + 2) % 3;
    std::array<glm::vec3, 4> corners{face.lower, face.lower, face.upper, face.lower};
    corners[1][u] = face.upper[u];
    corners[3][v] = face.upper[v];
    if ((face.side & 1) == 0) std::swap(corners[1], corners[3]);  // counter-clockwise seen from outside
    const glm::vec4 c = to_vec4(face.rgba);
    const Rgba8 color = to_rgba8(glm::vec4(glm::vec3(c) / c.w, c.w));
    sink(Polygon{corners, {&color, 1}, /*is_lit=*/true});
}

}  // namespace farfield
