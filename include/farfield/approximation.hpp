// An approximation says what can be drawn instead of a cell's contents, and how wrong it is: the second of the three
// policies.
//
// An approximation that draws cells by something else (`stands_in`) brings, at the least:
//
//     using stand_in_data    what is kept for a cell that has a stand-in; trivially copyable
//     using stand_in_draft   what a stand-in is while it is made
//     sample(cell, contents, sampler) -> stand_in_draft
//     finish(cell, draft)             -> stand_in_data
//     expected_work()                 -> Work               of drawing one, before any exists
//     error_px(data, cell, view)      -> float              of the picture if it is drawn; infinity: never
//     draw_stand_in(data, cell, view, sink)                 sink(Face), sink(Splat) or sink(OwnRun)
//
// and may bring, taken where it is there:
//
//     work(data)                      -> Work               of drawing this one
//     polygons(data, cell, sink)                            itself, for a hierarchy that holds an instance; without it
//                                                           the faces are taken that are drawn from two opposite
//                                                           corners
//     words_placed, place(data, cell, words), draw_placed(words, count, view, sink)
//                                                           many at once, by splats: see DrawsPlaced
//     placed(words, count) -> PlacedStandIns                what they are, for renderers that make the splats
//     contents_box(data, cell, reach, view) -> ContentsBox  what is drawn of a cell that is too near for its stand-in
//                                                           while its contents are missing, by renderers that have
//                                                           splats; without it the stand-in is. They and what stands
//                                                           in for them lie in the box `reach`, which holds the cell
//
// Facts announce whatever else it has, and make it required.
#pragma once

#include "farfield/settings.hpp"

#include <array>
#include <concepts>
#include <cstdint>
#include <optional>
#include <span>
#include <type_traits>
#include <vector>

#include "farfield/cost_model.hpp"
#include "farfield/drawables.hpp"
#include "farfield/geometry/area_law.hpp"
#include "farfield/geometry/cell.hpp"
#include "farfield/geometry/polygon.hpp"
#include "farfield/geometry/visit_order.hpp"
#include "farfield/image_cache_options.hpp"
#include "farfield/partition.hpp"
#include "farfield/primitive.hpp"
#include "farfield/sampler.hpp"
#include "farfield/view/local_view.hpp"

namespace farfield {

struct ApproximationFacts {
    Assignments accepts = Assignments::all();
    bool needs_polygons = false;  ///< of the primitive
    OrderGuarantee needs_ordering = OrderGuarantee::none;
    bool stands_in = false;           ///< MakesStandIns is required
    bool merges_octants = false;      ///< MergesOctants is required: parents are made from their children
    bool has_pool = false;            ///< data of varying size: hooks that take or make data get the pool after it
    bool bounds_error = false;        ///< BoundsError is required
    bool expects_error = false;       ///< ExpectsError is required; only where cells have stand-ins
    bool compares = false;            ///< ComparesWithChildren is required; not where there is a pool
    bool provides_area_law = false;   ///< ProvidesAreaLaw is required; only where cells have stand-ins
    bool samples_primitives = false;  ///< SamplesPrimitives is required; only where cells have stand-ins
    bool caches_images = false;       ///< CachesImages is required: viewers draw cells by images of them
    std::uint32_t file_tag = 0;  ///< names the policy in files; change it with the meaning of the data. 0: never stored
};

template <class A>
concept StatesApproximationFacts = requires {
    { A::facts } -> std::convertible_to<ApproximationFacts>;
}
&&std::is_trivially_copyable_v<typename A::stand_in_data>;

/// A child's draft while its parent is made. `child` is the number that the partition gave it.
template <class Draft>
struct ChildDraft {
    unsigned child = 0;
    const Cell* cell = nullptr;
    const Draft* draft = nullptr;
};

/// A box that holds all that a stand-in stands for, what sticks out of its cell too, or there are holes; and how much
/// of its outline is covered, as a Splat says that.
struct ContentsBox {
    glm::vec3 center, half;
    float opacity = 0;
    Rgba8 rgb{};
};

namespace archetype {
/// A sink that a stand-in is drawn into. `splat_limit_px` is 0 where the renderer has no splats.
struct StandInSink {
    float splat_limit_px = 0;
    void operator()(const Face&) const {}
    void operator()(const Splat&) const {}
    void operator()(OwnRun) const {}
};
/// Polygons of a part of the scene in local coordinates: visit(sink) calls sink(Polygon) for each.
struct Contents {
    template <class Sink>
    void operator()(Sink&& sink) const {
        sink(Polygon{});
    }
};
}  // namespace archetype

namespace detail {
struct NoPool {};

template <class A>
struct PoolElement {
    using type = NoPool;
};
template <class A>
requires(A::facts.has_pool&& requires { typename A::pool_element; }) struct PoolElement<A> {
    using type = typename A::pool_element;
};
}  // namespace detail

/// The element of an approximation's pool; an empty record where there is no pool.
template <class A>
using pool_element_of = typename detail::PoolElement<A>::type;

/// Stand-ins are made in steps, so that the costly one runs on any number of threads: sample() of each node by itself,
/// given the polygons of its subtree; finish(), in node order and only for nodes whose stand-in pays.
template <class A>
concept MakesStandIns =
    !std::is_empty_v<typename A::stand_in_data> &&
    requires(const A& a, const Cell& cell, const typename A::stand_in_draft& draft, archetype::Sampler& sampler,
             const typename A::stand_in_data& data, const LocalView& view) {
    { a.sample(cell, archetype::Contents{}, sampler) } -> std::same_as<typename A::stand_in_draft>;
    { a.expected_work() } -> std::same_as<Work>;
    { a.error_px(data, cell, view) } -> std::convertible_to<float>;
};

/// The rest of what stands in, without a pool and with one.
template <class A>
concept FinishesAndDraws = requires(const A& a, const Cell& cell, const typename A::stand_in_draft& draft,
                                    const typename A::stand_in_data& data, const LocalView& view,
                                    archetype::StandInSink& sink) {
    { a.finish(cell, draft) } -> std::same_as<typename A::stand_in_data>;
    a.draw_stand_in(data, cell, view, sink);
};
template <class A>
concept FinishesAndDrawsFromPool = std::is_trivially_copyable_v<typename A::pool_element> &&
    requires(const A& a, const Cell& cell, const typename A::stand_in_draft& draft,
             std::vector<typename A::pool_element>& pool, const typename A::stand_in_data& data,
             std::span<const typename A::pool_element> frozen_pool, const LocalView& view,
             archetype::StandInSink& sink) {
    { a.finish(cell, draft, pool) } -> std::same_as<typename A::stand_in_data>;
    a.draw_stand_in(data, frozen_pool, cell, view, sink);
};

/// Where children are octants, sample() gets only a node's own run and merge(cell, draft, children) adds its children's
/// drafts, bottom up. merges_children() says whether this one does: false has every cell sampled with its subtree.
template <class A>
concept MergesOctants = requires(const A& a, const Cell& cell, typename A::stand_in_draft& draft,
                                 std::span<const ChildDraft<typename A::stand_in_draft>> children) {
    { a.merges_children() } -> std::same_as<bool>;
    a.merge(cell, draft, children);
};

/// A lower bound of error_px over everything in the subtree whose deepest stand-in lies `levels` below the cell: where
/// it exceeds the tolerance, nothing below can stand in and the subtree is drawn as one run. Asked where children are
/// octants.
template <class A>
concept BoundsError = requires(const A& a, const Cell& cell, unsigned levels, const LocalView& view) {
    { a.least_error_px(cell, levels, view) } -> std::convertible_to<float>;
};

/// covered_part(), which takes the pool where there is one and it is needed, says which part of the cell's outline its
/// contents cover, seen from the view; expected_rmse() what the picture errs by over the pixels of a cell so wide, of
/// which so much is covered, if it stands in (wanted_error.hpp).
template <class A>
concept ExpectsError = requires(const A& a) {
    { a.expected_rmse(1.0f, 1.0f) } -> std::same_as<float>;
}
&&(
    requires(const A& a, const typename A::stand_in_data& data, const Cell& cell, const LocalView& view) {
        { a.covered_part(data, cell, view) } -> std::same_as<float>;
    } ||
    requires(const A& a, const typename A::stand_in_data& data, std::span<const pool_element_of<A>> pool,
             const Cell& cell, const LocalView& view) {
        { a.covered_part(data, pool, cell, view) } -> std::same_as<float>;
    });

/// reproduces() says whether a cell's stand-in, drawn in place of its children's, gives their picture. It is asked of
/// cells all of whose children have stand-ins; where it holds these are not kept. The cell's error is halved with its
/// children's, so error_px must be proportional to the cell's size at a given distance.
template <class A>
concept ComparesWithChildren =
    !A::facts.has_pool && requires(const A& a, const Cell& cell, const typename A::stand_in_draft& draft,
                                   std::span<const ChildDraft<typename A::stand_in_draft>> children) {
    { a.reproduces(cell, draft, children) } -> std::same_as<bool>;
};

/// area_law() says how primitives go together that lie in a cell, or in a cell below it without a stand-in of its own:
/// what a renderer needs that deposits those smaller than a sample (geometry/area_law.hpp). Unset: they are drawn one
/// by one.
template <class A>
concept ProvidesAreaLaw = requires(const A& a, const typename A::stand_in_data& data) {
    { a.area_law(data) } -> std::same_as<std::optional<AreaLaw>>;
};

/// What moving samples up has left of a cell. Cells above hold the rest, and it is drawn with them.
struct SampledCell {
    float areas_per_side = 0;       ///< all area that lies in it, in squares of its side: q
    float left = 1;                 ///< in its subtree, as a part of the area of all that lies in it
    float sample = 0;               ///< in its sample: the first items of its own run
    std::uint32_t items = 0;        ///< in its subtree
    std::uint32_t fixed = 0;        ///< of these, items that never move: instances, and what has no area
    std::uint32_t sample_size = 0;  ///< items in its sample
    /// Whether all that lay in it before anything moved lies in children that still hold something.
    bool is_in_children = false;
};

/// Inner cells hold samples of what lies below them, so that a frame refines by adding (Klein et al. 2002). A build
/// gives every primitive sample_key(index, area) and moves those of the least keys up: a cell and the cells above it
/// hold together the sample_size(q) least of all in the cell, where q is their area in squares of the cell's side. Keys
/// are 0 or more, infinity for what never moves. sampled() is told what that has left of a cell whose stand-in was made
/// from all that lies in it. Every primitive is in one cell, and no order of primitives is kept.
template <class A>
concept SamplesPrimitives = A::facts.accepts == Assignments(Assignment::unique) &&
                            A::facts.needs_polygons&& requires(const A& a, const typename A::stand_in_data& data) {
    { a.sample_key(std::uint32_t(), 0.0) } -> std::same_as<float>;
    { a.sample_size(0.0) } -> std::same_as<std::uint32_t>;
    { a.sampled(data, SampledCell{}) } -> std::same_as<typename A::stand_in_data>;
};

/// images() says how a viewer keeps images of cells that this approximation draws.
template <class A>
concept CachesImages = requires(const A& a) {
    { a.images() } -> std::same_as<const ImageCacheOptions&>;
};

namespace detail {
template <class A>
concept SamplesPrimitivesIfStated = !A::facts.samples_primitives || (A::facts.stands_in && SamplesPrimitives<A>);
template <class A>
concept CachesImagesIfStated = !A::facts.caches_images || CachesImages<A>;
template <class A>
concept FinishesAndDrawsAsStated = (A::facts.has_pool && FinishesAndDrawsFromPool<A>) ||
                                   (!A::facts.has_pool && FinishesAndDraws<A>);
template <class A>
concept MakesStandInsIfStated = !A::facts.stands_in || (MakesStandIns<A> && FinishesAndDrawsAsStated<A>);
template <class A>
concept MergesOctantsIfStated = !A::facts.merges_octants || (A::facts.stands_in && MergesOctants<A>);
template <class A>
concept BoundsErrorIfStated = !A::facts.bounds_error || BoundsError<A>;
template <class A>
concept ExpectsErrorIfStated = !A::facts.expects_error || (A::facts.stands_in && ExpectsError<A>);
template <class A>
concept ComparesIfStated = !A::facts.compares || (A::facts.stands_in && ComparesWithChildren<A>);
template <class A>
concept ProvidesAreaLawIfStated = !A::facts.provides_area_law || (A::facts.stands_in && ProvidesAreaLaw<A>);
}  // namespace detail

template <class A>
concept Approximation =
    StatesApproximationFacts<A> && detail::MakesStandInsIfStated<A> && detail::MergesOctantsIfStated<A> &&
    detail::BoundsErrorIfStated<A> && detail::ExpectsErrorIfStated<A> && detail::ComparesIfStated<A> &&
    detail::ProvidesAreaLawIfStated<A> && detail::SamplesPrimitivesIfStated<A> && detail::CachesImagesIfStated<A>;

// --- the one place where hooks are called whose form, or presence, depends on the approximation

namespace detail {

template <class A, class Draft, class Pool>
auto finished_stand_in(const A& a, const Cell& cell, const Draft& draft, std::vector<Pool>& pool) {
    if constexpr (A::facts.has_pool) {
        return a.finish(cell, draft, pool);
    } else {
        return a.finish(cell, draft);
    }
}

template <class A, class Data, class Pool, class Sink>
void draw_stand_in(const A& a, const Data& data, std::span<const Pool> pool, const Cell& cell, const LocalView& view,
                   Sink&& sink) {
    if constexpr (A::facts.has_pool) {
        a.draw_stand_in(data, pool, cell, view, sink);
    } else {
        a.draw_stand_in(data, cell, view, sink);
    }
}

template <class A, class Data, class Pool>
float covered_part(const A& a, const Data& data, std::span<const Pool> pool, const Cell& cell, const LocalView& view) {
    if constexpr (requires { a.covered_part(data, pool, cell, view); }) {
        return a.covered_part(data, pool, cell, view);
    } else {
        return a.covered_part(data, cell, view);
    }
}

/// The class that declares a member.
template <class Class, class Member>
Class class_of(Member Class::*);

/// Stand-ins that become splats can wait until there are many, each as `words_placed` words (12 at most). place()
/// writes word i to words[i * placed_stride]; draw_placed() draws `count` of them in order, may read what lies behind
/// them in each row, and calls sink(Splat) as draw_stand_in() would, or sink(Splat, i) with which of them it is, if the
/// sink takes it. All must be of one class: who derives from an approximation and draws otherwise is not bypassed. One
/// that cannot place all says places(view, splat_limit_px) -> bool, or places(cell, view, splat_limit_px) of a cell.
inline constexpr std::size_t placed_stride = PlacedStandIns::stride, most_words_placed = 12;
template <class A>
concept DrawsPlaced = requires {
    { class_of(&A::place) } -> std::same_as<decltype(class_of(&A::template draw_stand_in<archetype::StandInSink&>))>;
}
&&A::words_placed <= most_words_placed;
/// Says what its words are, for renderers that make splats of them (RendererFacts::shapes_stand_ins).
template <class A>
concept NamesPlaced = DrawsPlaced<A> && requires(const A& a, const std::uint32_t* words) {
    { a.placed(words, std::size_t()) } -> std::same_as<PlacedStandIns>;
};
/// Cells of any size become splats.
template <class A>
concept DrawsLargePlaced = DrawsPlaced<A> && !requires(const A& a, const Cell& cell, const LocalView& view) {
    a.places(cell, view, 0.0f);
};

template <class A>
concept TellsContentsBox = requires(const A& a, const typename A::stand_in_data& data, const Cell& cell,
                                    const Box& reach, const LocalView& view) {
    { a.contents_box(data, cell, reach, view) } -> std::same_as<ContentsBox>;
};

template <class A, class Data>
Work work_of_stand_in(const A& a, const Data& data) {
    if constexpr (requires { a.work(data); }) {
        return a.work(data);
    } else {
        return a.expected_work();
    }
}

/// From outside of a cell's box towards its center, so that three of its sides are seen from one, three from the other.
inline std::array<LocalView, 2> views_from_opposite_corners(const Cell& cell) {
    const glm::dvec3 center(cell.center), corner(1);
    const auto from = [&](const glm::dvec3& eye) {
        View view;
        view.camera = Camera::orthographic(eye, center, {0, 1, 0}, 1);
        return LocalView(view, glm::dvec3(0), 1);
    };
    return {from(center + corner), from(center - corner)};
}

/// Sends faces on as polygons, colors no longer premultiplied. What is nothing but splats has no polygons.
template <class Sink>
struct FacesAsPolygons {
    Sink& sink;
    float splat_limit_px = 0;
    void operator()(const Face& face) const { emit_polygon(face, sink); }
    void operator()(const Splat&) const {}
    void operator()(OwnRun) const {}
};

template <class A, class Data, class Pool, class Sink>
void stand_in_polygons(const A& a, const Data& data, std::span<const Pool> pool, const Cell& cell, Sink&& sink) {
    if constexpr (A::facts.has_pool && requires { a.polygons(data, pool, cell, sink); }) {
        a.polygons(data, pool, cell, sink);
    } else if constexpr (!A::facts.has_pool && requires { a.polygons(data, cell, sink); }) {
        a.polygons(data, cell, sink);
    } else {
        const FacesAsPolygons<std::remove_reference_t<Sink>> faces{sink};
        for (const LocalView& view : views_from_opposite_corners(cell)) draw_stand_in(a, data, pool, cell, view, faces);
    }
}

}  // namespace detail
}  // namespace farfield
