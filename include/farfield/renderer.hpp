// What the user brings to draw with: ranges of primitives always; faces, splats, deposits of primitives and answers
// about occlusion where the renderer's facts say so.
#pragma once

#include <concepts>
#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <optional>
#include <span>

#include "farfield/cell.hpp"
#include "farfield/fragments.hpp"
#include "farfield/geometry/area_law.hpp"
#include "farfield/geometry/polygon.hpp"
#include "farfield/geometry/rgba8.hpp"
#include "farfield/local_view.hpp"
#include "farfield/primitive.hpp"

namespace farfield {

/// In which order cells are visited.
enum class Order : std::uint8_t { any, front_to_back, back_to_front };

/// How strict an order is: none, between cells, or between primitives.
enum class Ordering : std::uint8_t { none, cells, primitives };

/// Positions [first, first + count) in a hierarchy's order of items.
struct Range {
    std::uint32_t first = 0;
    std::uint32_t count = 0;
    /// How the primitives of the cell that it belongs to go together, for a renderer that deposits the small ones.
    /// Unset: unknown, or nobody asked; each primitive is then drawn for itself.
    std::optional<AreaLaw> law{};
};

/// Where the primitives of a run come from. Spans stay valid as long as the viewer that hands it over.
template <class P>
struct Source {
    std::span<const P> primitives;
    std::span<const std::uint32_t> order;  ///< position -> index into primitives; empty: positions are indices
    std::uint32_t item_count = 0;          ///< number of positions; larger than primitives.size() where shared or cut
    glm::dvec3 origin{0};                  ///< subtract it from the primitive's coordinates to get the local ones
    std::uint32_t id = 0;                  ///< what page_in returned for it
    Fragments fragments{};                 ///< what positions hold instead of whole primitives, if the partition cuts

    /// The primitive, or the one that the position's fragment is a piece of.
    const P& operator[](std::uint32_t position) const { return primitives[order.empty() ? position : order[position]]; }

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

/// What a renderer promises and asks. Each flag makes the hook beside it required, so that a misspelt hook is an
/// error and not silence.
struct RendererFacts {
    Order order = Order::any;                      ///< in which cells' primitives are wanted
    Ordering needs_ordering = Ordering::none;      ///< how strict that order has to be, within ranges too
    Order far_field_order = Order::front_to_back;  ///< back_to_front: stand-ins are replayed after everything else
    bool keeps_sources = false;   ///< std::uint32_t page_in(Source<P>) once a source, page_out(id) when it goes
    bool draws_faces = false;     ///< draw(std::span<const Face>)
    bool draws_splats = false;    ///< draw(std::span<const Splat>), float largest_splat_px()
    bool draws_polygons = false;  ///< draw(std::span<const Polygon>): pieces made for this frame, local coordinates
    bool answers_hidden = false;  ///< bool hidden(const Cell&, CellId): may err only towards false
    /// bool deposits_primitives() const, asked after begin_frame: whether in this frame ranges carry their cell's law
    /// where it is known. Cells with a law come front to back, in order with the stand-ins among them.
    bool deposits_primitives = false;
};

template <class R>
concept StatesItsFacts = requires {
    { R::facts } -> std::convertible_to<RendererFacts>;
};

template <class R>
concept HasFrames = requires(R& r, const LocalView& view) {
    r.begin_frame(view);  // the outermost hierarchy's coordinates
    r.set_view(view);     // what follows is in this view's coordinates
    r.end_frame();
};

/// Ranges come in groups, which are in the order that `facts` asks for; within a group it is free for Order::any.
template <class R, class P>
concept DrawsRuns = requires(R& r, const Source<P>& source, std::span<const Range> ranges) {
    r.draw(source, ranges);
};

template <class R, class P>
concept KeepsSources = requires(R& r, const Source<P>& source, std::uint32_t id) {
    { r.page_in(source) } -> std::same_as<std::uint32_t>;
    r.page_out(id);
};

template <class R>
concept DrawsFaces = requires(R& r, std::span<const Face> faces) {
    r.draw(faces);
};

template <class R>
concept DrawsSplats = requires(R& r, std::span<const Splat> splats) {
    r.draw(splats);
    { r.largest_splat_px() } -> std::convertible_to<float>;
};

template <class R>
concept DrawsPolygons = requires(R& r, std::span<const Polygon> polygons) {
    r.draw(polygons);
};

template <class R>
concept AnswersHidden = requires(R& r, const Cell& cell, CellId id) {
    { r.hidden(cell, id) } -> std::same_as<bool>;
};

template <class R>
concept DepositsPrimitives = requires(const R& r) {
    { r.deposits_primitives() } -> std::same_as<bool>;
};

template <class R, class P>
concept KeepsSourcesIfStated = !R::facts.keeps_sources || KeepsSources<R, P>;
template <class R>
concept DrawsFacesIfStated = !R::facts.draws_faces || DrawsFaces<R>;
template <class R>
concept DrawsSplatsIfStated = !R::facts.draws_splats || DrawsSplats<R>;
template <class R>
concept DrawsPolygonsIfStated = !R::facts.draws_polygons || DrawsPolygons<R>;
template <class R>
concept AnswersHiddenIfStated = !R::facts.answers_hidden || AnswersHidden<R>;

template <class R>
concept DepositsPrimitivesIfStated = !R::facts.deposits_primitives || DepositsPrimitives<R>;

template <class R, class P>
concept Renderer =
    StatesItsFacts<R> && HasFrames<R> && DrawsRuns<R, P> && KeepsSourcesIfStated<R, P> && DrawsFacesIfStated<R> &&
    DrawsSplatsIfStated<R> && DrawsPolygonsIfStated<R> && AnswersHiddenIfStated<R> && DepositsPrimitivesIfStated<R>;

}  // namespace farfield
