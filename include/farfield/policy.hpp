// The three policies and what goes together. Every condition is a named concept, so that compilers name what is
// missing. Each policy announces itself by a `facts` constant; a flag set there makes the hook beside it required, so
// that a misspelt hook does not compile instead of drawing nothing.
#pragma once

#include <array>
#include <concepts>
#include <cstdint>
#include <glm/vec4.hpp>
#include <optional>
#include <span>
#include <type_traits>
#include <vector>

#include "farfield/cell.hpp"
#include "farfield/clipped_items.hpp"
#include "farfield/geometry/area_law.hpp"
#include "farfield/geometry/orthographic_sampler.hpp"
#include "farfield/primitive.hpp"
#include "farfield/renderer.hpp"

namespace farfield {

// --- Partition: how is space divided, and in which order are the parts visited? --------------------------------------

/// Into which cells a primitive goes: every cell it touches; one; or its polygons cut into fragments.
enum Assignment : unsigned { shared = 1, unique = 2, clipped = 4 };

/// At most eight children a node.
using ChildOrder = std::array<std::uint8_t, 8>;

struct PartitionFacts {
    unsigned offers = unique;            ///< set of Assignment
    Ordering ordering = Ordering::none;  ///< what front_to_back guarantees
    bool splits_for_order = false;       ///< split whether it pays or not
    bool halves =
        false;  ///< children are the octants of their cell: bit 0, 1, 2 of the index is the upper x, y, z half
    std::uint32_t file_tag = 0;  ///< names the policy in files; change it with the meaning of the data
};

/// One primitive as a builder sees it. 32 bytes, for building is a matter of streaming these.
struct Item {
    Box bounds;                ///< local coordinates, content that may stick out of its cell included
    std::uint32_t source = 0;  ///< index of the primitive
    float cost = 0;            ///< of drawing it, in the cost model's unit
};

/// Answer of Partition::choose.
enum class Split : std::uint8_t {
    yes,     ///< the node's data is set and place() may be asked; whether it happens is the builder's question of cost
    always,  ///< likewise, whatever it costs
    no,      ///< the partition's own limit, as wished (a uniform depth)
    too_deep,     ///< a safety limit that the build report counts
    inseparable,  ///< likewise: of a partition that cuts, no plane tells the items apart
};

template <class T>
concept StatesPartitionFacts = requires {
    { T::facts } -> std::convertible_to<PartitionFacts>;
}
&&std::is_trivially_copyable_v<typename T::node_data>;

/// place(cell, data, item, touches, emit): calls emit(child) for each child that gets the item, or emit.keep() to leave
/// it in the node's own run. touches(box) says whether the primitive itself, not just its bounds, meets a box;
/// of an instance it is always true.
namespace archetype {
struct Emit {
    void operator()(unsigned) const {}
    void keep() const {}
};
struct Touches {
    bool operator()(const Box&) const { return true; }
};
}  // namespace archetype

template <class T>
concept DescendsInOrder = requires(const T& t, const Cell& cell, const typename T::node_data& frozen,
                                   ChildOrder& order) {
    { t.root(Box{}) } -> std::same_as<Cell>;              // the tight bounds of everything
    { t.child(cell, frozen, 0u) } -> std::same_as<Cell>;  // computed again at every descent
    t.front_to_back(cell, frozen, glm::vec4(), order);  // all children, present or not; viewpoint as LocalView gives it
};

template <class T>
concept PlacesItems = requires(const T& t, const Cell& cell, typename T::node_data& data,
                               const typename T::node_data& frozen, const Item& item, std::span<const Item> items) {
    { t.choose(cell, items, data) } -> std::same_as<Split>;
    t.place(cell, frozen, item, archetype::Touches{}, archetype::Emit{});
};

/// Of partitions that offer `clipped`. An item goes to child(data, side of each plane), cut where it crosses one; what
/// lies on a plane, up to rounding, goes undivided. Cells stay around what is in them: fit() may use that.
template <class T>
concept CutsItems = requires(const T& t, const Cell& cell, typename T::node_data& data,
                             const typename T::node_data& frozen, const ClippedItems& items,
                             std::span<const Box> children) {
    { t.choose(cell, items, data) } -> std::same_as<Split>;  // no: the items are in order as they are
    { t.cuts(cell, frozen) } -> std::same_as<Cuts>;
    { t.child_at(frozen, Sides{}) } -> std::same_as<unsigned>;
    t.fit(cell, data, children);  // bounds of what each child got, empty boxes included
};

template <class T>
concept PlacesItemsIfOffered = (T::facts.offers & (shared | unique)) == 0 || PlacesItems<T>;
template <class T>
concept CutsItemsIfOffered = (T::facts.offers & clipped) == 0 || CutsItems<T>;

template <class T>
concept Partition = StatesPartitionFacts<T> && DescendsInOrder<T> && PlacesItemsIfOffered<T> && CutsItemsIfOffered<T>;

// --- Approximation: what can be drawn instead, and how wrong is it? --------------------------------------------------

enum Need : unsigned { needs_nothing = 0, needs_polygons = 1 };

struct ApproximationFacts {
    unsigned accepts = shared | unique | clipped;  ///< set of Assignment
    unsigned needs = needs_nothing;                ///< of the primitive: set of Need
    Ordering needs_ordering = Ordering::none;
    bool stands_in = false;     ///< MakesStandIns is required
    bool has_pool = false;      ///< finish() may append to a pool of pool_element
    bool bounds_error = false;  ///< least_error_px is required
    bool compares = false;      ///< reproduces is required; not where there is a pool
    bool knows_law = false;     ///< law is required; only where cells have stand-ins
    std::uint32_t file_tag = 0;
};

template <class A>
concept StatesApproximationFacts = requires {
    { A::facts } -> std::convertible_to<ApproximationFacts>;
}
&&std::is_trivially_copyable_v<typename A::cell_data>&& std::is_trivially_copyable_v<typename A::pool_element>;

/// What a stand-in is drawn into. `splat_limit_px` is 0 where the renderer has no splats.
namespace archetype {
struct StandInSink {
    float splat_limit_px = 0;
    void operator()(const Face&) const {}
    void operator()(const Splat&) const {}
};
/// Polygons of a part of the scene in local coordinates: visit(sink) calls sink(Polygon) for each.
struct Contents {
    template <class Sink>
    void operator()(Sink&& sink) const {
        sink(Polygon{});
    }
};
}  // namespace archetype

/// A child's draft while its parent is made. `child` is the index the partition gave it.
template <class Draft>
struct ChildDraft {
    unsigned child = 0;
    const Cell* cell = nullptr;
    const Draft* draft = nullptr;
};

/// Stand-ins are made in three steps, so that the costly one runs on any number of threads: sample(), each node by
/// itself; merge(), bottom up; finish(), in node order and only for nodes whose stand-in pays.
template <class A>
concept MakesStandIns =
    !std::is_empty_v<typename A::cell_data> &&
    requires(
        const A& a, const Cell& cell, typename A::draft& draft, std::span<const ChildDraft<typename A::draft>> children,
        GridSampler& sampler, std::vector<typename A::pool_element>& pool, const typename A::cell_data& data,
        std::span<const typename A::pool_element> frozen_pool, const LocalView& view, archetype::StandInSink& sink) {
    { a.wants_all_contents(PartitionFacts{}) } -> std::same_as<bool>;  // of the subtree, not just of the own run
    { a.sample(cell, archetype::Contents{}, sampler) } -> std::same_as<typename A::draft>;
    a.merge(cell, draft, children);
    { a.finish(cell, draft, pool) } -> std::same_as<typename A::cell_data>;
    { a.expected_work() } -> std::same_as<Work>;  // of drawing one, before any exists
    { a.work(data) } -> std::same_as<Work>;
    { a.error_px(data, cell, view) } -> std::convertible_to<float>;  // of the picture if it is drawn; infinity: never
    a.stand_in(data, frozen_pool, cell, view, sink);
    a.polygons(data, frozen_pool, cell, archetype::PolygonSink{});  // itself, for a hierarchy that holds an instance
};

/// A lower bound of error_px over everything in the subtree whose deepest stand-in lies `levels` below the cell: where
/// it exceeds the tolerance, nothing below can stand in and the subtree is drawn as one run.
template <class A>
concept BoundsError = requires(const A& a, const Cell& cell, unsigned levels, const LocalView& view) {
    { a.least_error_px(cell, levels, view) } -> std::convertible_to<float>;
};

/// Whether a cell's stand-in, drawn in place of its children's, gives their picture: whether they all tell one story.
/// Asked of cells all of whose children have stand-ins; where it holds these are not kept. The cell's error is halved
/// with its children's, so error_px must be proportional to the cell's size at a given distance.
template <class A>
concept ComparesWithChildren =
    !A::facts.has_pool && requires(const A& a, const Cell& cell, const typename A::draft& draft,
                                   std::span<const ChildDraft<typename A::draft>> children) {
    { a.reproduces(cell, draft, children) } -> std::same_as<bool>;
};

/// How primitives go together that lie in a cell, or in a cell below it without a stand-in of its own: what a renderer
/// needs that deposits those smaller than a sample (geometry/area_law.hpp). Unset: they are drawn one by one.
template <class A>
concept KnowsLaw = requires(const A& a, const typename A::cell_data& data) {
    { a.law(data) } -> std::same_as<std::optional<AreaLaw>>;
};

template <class A>
concept MakesStandInsIfStated = !A::facts.stands_in || MakesStandIns<A>;
template <class A>
concept BoundsErrorIfStated = !A::facts.bounds_error || BoundsError<A>;
template <class A>
concept ComparesIfStated = !A::facts.compares || (A::facts.stands_in && ComparesWithChildren<A>);

template <class A>
concept KnowsLawIfStated = !A::facts.knows_law || (A::facts.stands_in && KnowsLaw<A>);

template <class A>
concept Approximation = StatesApproximationFacts<A> && MakesStandInsIfStated<A> && BoundsErrorIfStated<A> &&
    ComparesIfStated<A> && KnowsLawIfStated<A>;

// --- CostModel: what is a unit of each kind of work worth?
// ------------------------------------------------------------

template <class C>
concept CostModel = std::is_trivially_copyable_v<C> && requires(const C& c, const Work& work) {
    { c.cost(work) } -> std::convertible_to<float>;
    { C::unit } -> std::convertible_to<const char*>;
    { C::file_tag } -> std::convertible_to<std::uint32_t>;
};

// --- What goes together
// -----------------------------------------------------------------------------------------------

template <class P, class A>
concept AssignmentAgreed = (P::facts.offers & A::facts.accepts) != 0;
template <class P, class A>
concept OrderSufficient = P::facts.ordering >= A::facts.needs_ordering;

template <class P, class A, class C>
concept Composable =
    Partition<P> && Approximation<A> && CostModel<C> && AssignmentAgreed<P, A> && OrderSufficient<P, A>;

template <class P, class A>
concept HasPolygonsIfNeeded = (A::facts.needs & needs_polygons) == 0 || PrimitiveWithPolygons<P>;

template <class P, class H>
concept CanBeClippedIfNeeded = H::assignment != clipped || PrimitiveWithPolygons<P>;

/// H is a SpatialHierarchy.
template <class H, class P>
concept BuildableFrom =
    Primitive<P> && HasPolygonsIfNeeded<P, typename H::approximation_type> && CanBeClippedIfNeeded<P, H>;

template <class R, class A>
concept DrawsStandInsIfAny = !A::facts.stands_in || R::facts.draws_faces;
template <class R, class H>
concept OrderGoodEnough = H::ordering >= R::facts.needs_ordering;

template <class H, class P, class R>
concept DrawableWith = Renderer<R, P> && DrawsStandInsIfAny<R, typename H::approximation_type> && OrderGoodEnough<R, H>;

}  // namespace farfield
