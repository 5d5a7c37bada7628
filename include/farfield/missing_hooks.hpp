// Assertions that name the hook that is missing; each function here is true if it compiles.
//
// Compilers do not name what a concept misses that is required only if a flag is set. So the types in which
// hierarchies, primitives and renderers meet do not end with a concept: they ask for each hook by an assertion of its
// own, whose text says how the hook looks. Optional hooks of another type, or of a name that is nearly right, are found
// the same way.
#pragma once

#include "farfield/settings.hpp"

#include <concepts>
#include <cstdint>
#include <span>
#include <type_traits>
#include <vector>

#include "farfield/approximation.hpp"
#include "farfield/composition.hpp"
#include "farfield/cost_model.hpp"
#include "farfield/partition.hpp"
#include "farfield/primitive.hpp"
#include "farfield/primitive_source.hpp"
#include "farfield/renderer.hpp"
#include "farfield/sampler.hpp"

namespace farfield::detail {

template <class T>
constexpr bool check_partition() {
    static_assert(
        StatesPartitionFacts<T>,
        "farfield: a partition needs `static constexpr PartitionFacts facts` and a trivially copyable `node_data`");
    if constexpr (StatesPartitionFacts<T>) {
        using Data = typename T::node_data;
        static_assert(
            requires(const T& t) {
                { t.root(Box{}) } -> std::same_as<Cell>;
            },
            "farfield: the partition needs `Cell root(const Box& bounds) const`");
        static_assert(
            requires(const T& t, const Cell& c, const Data& d) {
                { t.child(c, d, 0u) } -> std::same_as<Cell>;
            },
            "farfield: the partition needs `Cell child(const Cell&, const node_data&, unsigned) const`");
        static_assert(
            requires(const T& t, const Cell& c, const Data& d, ChildOrder& order) {
                t.front_to_back(c, d, glm::vec4(), order);
            },
            "farfield: the partition needs `void front_to_back(const Cell&, const node_data&, glm::vec4 viewpoint, "
            "ChildOrder&) const`");
        if constexpr (!(T::facts.offers & (Assignment::shared | Assignment::unique)).is_empty()) {
            static_assert(
                requires(const T& t, const Cell& c, std::span<const Item> items, Data& d) {
                    { t.choose(c, items, d) } -> std::same_as<Split>;
                },
                "farfield: the partition needs `Split choose(const Cell&, std::span<const Item>, node_data&) const`");
            static_assert(
                requires(const T& t, const Cell& c, const Data& d, const Item& item) {
                    t.place(c, d, item, archetype::Touches{}, archetype::Emit{});
                },
                "farfield: the partition needs `place(const Cell&, const node_data&, const Item&, touches, give) "
                "const`");
        }
        if constexpr (T::facts.offers.contains(Assignment::clipped)) {
            static_assert(
                requires(const T& t, const Cell& c, const ClippedItems& items, Data& d) {
                    { t.choose(c, items, d) } -> std::same_as<Split>;
                },
                "farfield: a partition that offers `clipped` needs `Split choose(const Cell&, const ClippedItems&, "
                "node_data&) const`");
            static_assert(
                requires(const T& t, const Cell& c, const Data& d) {
                    { t.cuts(c, d) } -> std::same_as<Cuts>;
                },
                "farfield: a partition that offers `clipped` needs `Cuts cuts(const Cell&, const node_data&) "
                "const`");
            static_assert(
                requires(const T& t, const Data& d) {
                    { t.child_at(d, Sides{}) } -> std::same_as<unsigned>;
                },
                "farfield: a partition that offers `clipped` needs `unsigned child_at(const node_data&, const "
                "Sides&) const`");
            static_assert(
                requires(const T& t, const Cell& c, Data& d, std::span<const Box> children) { t.fit(c, d, children); },
                "farfield: a partition that offers `clipped` needs `void fit(const Cell&, node_data&, "
                "std::span<const Box>) const`");
        }
    }
    return true;
}

template <class A>
constexpr bool check_stand_ins() {
    static_assert(
        requires { typename A::stand_in_draft; },
        "farfield: an approximation with `stands_in` needs `using stand_in_draft = ...`");
    static_assert(!std::is_empty_v<typename A::stand_in_data>,
                  "farfield: an approximation with `stands_in` needs a `stand_in_data` that is not empty");
    if constexpr (requires { typename A::stand_in_draft; }) {
        using Draft = typename A::stand_in_draft;
        using Data = typename A::stand_in_data;
        using Pool = pool_element_of<A>;
        static_assert(
            requires(const A& a, const Cell& c, archetype::Sampler& sampler) {
                { a.sample(c, archetype::Contents{}, sampler) } -> std::same_as<Draft>;
            },
            "farfield: an approximation with `stands_in` needs `stand_in_draft sample(const Cell&, contents, sampler) "
            "const`");
        static_assert(
            requires(const A& a) {
                { a.expected_work() } -> std::same_as<Work>;
            },
            "farfield: an approximation with `stands_in` needs `Work expected_work() const`");
        static_assert(
            requires(const A& a, const Data& data, const Cell& c, const LocalView& view) {
                { a.error_px(data, c, view) } -> std::convertible_to<float>;
            },
            "farfield: an approximation with `stands_in` needs `float error_px(const stand_in_data&, const Cell&, "
            "const "
            "LocalView&) const`");
        if constexpr (A::facts.has_pool) {
            static_assert(
                requires { typename A::pool_element; },
                "farfield: an approximation with `has_pool` needs `using pool_element = ...`");
            static_assert(
                requires(const A& a, const Cell& c, const Draft& draft, std::vector<Pool>& pool) {
                    { a.finish(c, draft, pool) } -> std::same_as<Data>;
                },
                "farfield: an approximation with `has_pool` needs `stand_in_data finish(const Cell&, const "
                "stand_in_draft&, std::vector<pool_element>&) const`");
            static_assert(
                requires(const A& a, const Data& data, std::span<const Pool> pool, const Cell& c, const LocalView& view,
                         archetype::StandInSink& sink) { a.draw_stand_in(data, pool, c, view, sink); },
                "farfield: an approximation with `has_pool` needs `draw_stand_in(const stand_in_data&, "
                "std::span<const pool_element>, const Cell&, const LocalView&, sink) const`");
            static_assert(
                !requires(const A& a, const Data& data, const Cell& c, archetype::PolygonSink sink) {
                    a.polygons(data, c, sink);
                },
                "farfield: where there is a pool, polygons() gets it after the data: `polygons(const stand_in_data&, "
                "std::span<const pool_element>, const Cell&, sink) const`");
        } else {
            static_assert(
                requires(const A& a, const Cell& c, const Draft& draft) {
                    { a.finish(c, draft) } -> std::same_as<Data>;
                },
                "farfield: an approximation with `stands_in` needs `stand_in_data finish(const Cell&, const "
                "stand_in_draft&) const`");
            static_assert(
                requires(const A& a, const Data& data, const Cell& c, const LocalView& view,
                         archetype::StandInSink& sink) { a.draw_stand_in(data, c, view, sink); },
                "farfield: an approximation with `stands_in` needs `draw_stand_in(const stand_in_data&, const Cell&, "
                "const LocalView&, sink) const`");
        }
        static_assert(
            !requires(const A& a, const Data& data) { a.work(data); } ||
                requires(const A& a, const Data& data) {
                    { a.work(data) } -> std::same_as<Work>;
                },
            "farfield: the approximation's work() must be `Work work(const stand_in_data&) const`");
        static_assert(
            !requires(const A& a, const Data& data, const Cell& c, archetype::PolygonSink sink) {
                a.polygon(data, c, sink);
            },
            "farfield: the approximation has polygon(), which nobody asks for: `polygons` is what is meant");
        static_assert(!A::facts.merges_octants || MergesOctants<A>,
                      "farfield: an approximation with `merges_octants` needs `bool merges_children() const` and `void "
                      "merge(const Cell&, stand_in_draft&, std::span<const ChildDraft<stand_in_draft>>) const`");
        static_assert(
            !A::facts.compares || ComparesWithChildren<A>,
            "farfield: an approximation with `compares`, and no pool, needs `bool reproduces(const Cell&, const "
            "stand_in_draft&, std::span<const ChildDraft<stand_in_draft>>) const`");
        static_assert(
            !A::facts.provides_area_law || ProvidesAreaLaw<A>,
            "farfield: an approximation with `provides_area_law` needs `std::optional<AreaLaw> area_law(const "
            "stand_in_data&) const`");
        static_assert(
            !A::facts.expects_error || ExpectsError<A>,
            "farfield: an approximation with `expects_error` needs `float covered_part(const stand_in_data&, const "
            "Cell&, const LocalView&) const` and `float expected_rmse(float side_px, float covered) const`");
        static_assert(
            !A::facts.samples_primitives || SamplesPrimitives<A>,
            "farfield: an approximation with `samples_primitives` needs polygons, accepts `unique` alone, and "
            "has `float sample_key(std::uint32_t, double) const`, `std::uint32_t sample_size(double) const` "
            "and `stand_in_data sampled(const stand_in_data&, SampledCell) const`");
    }
    return true;
}

template <class A>
constexpr bool check_approximation() {
    static_assert(
        StatesApproximationFacts<A>,
        "farfield: an approximation needs `static constexpr ApproximationFacts facts` and a trivially copyable "
        "`stand_in_data`");
    if constexpr (StatesApproximationFacts<A>) {
        if constexpr (A::facts.stands_in) {
            static_assert(check_stand_ins<A>());
        } else {
            static_assert(!A::facts.merges_octants && !A::facts.expects_error && !A::facts.compares &&
                              !A::facts.provides_area_law && !A::facts.samples_primitives,
                          "farfield: `merges_octants`, `expects_error`, `compares`, `provides_area_law` and "
                          "`samples_primitives` go with "
                          "`stands_in` only");
        }
        static_assert(
            !A::facts.caches_images || CachesImages<A>,
            "farfield: an approximation with `caches_images` needs `const ImageCacheOptions& images() const`");
        static_assert(
            !A::facts.bounds_error || BoundsError<A>,
            "farfield: an approximation with `bounds_error` needs `float least_error_px(const Cell&, unsigned "
            "levels, const LocalView&) const`");
    }
    return true;
}

template <class C>
constexpr bool check_cost_model() {
    static_assert(std::is_trivially_copyable_v<C>, "farfield: a cost model must be trivially copyable");
    static_assert(
        requires(const C& c, const Work& work) {
            { c.cost(work) } -> std::convertible_to<float>;
        },
        "farfield: a cost model needs `float cost(const Work&) const`");
    static_assert(
        requires {
            { C::unit } -> std::convertible_to<const char*>;
        },
        "farfield: a cost model needs `static constexpr const char* unit`");
    static_assert(
        requires {
            { C::file_tag } -> std::convertible_to<std::uint32_t>;
        },
        "farfield: a cost model needs `static constexpr std::uint32_t file_tag`, 0 if it is never stored");
    return true;
}

template <class Partition_, class A, class C>
constexpr bool check_policies() {
    static_assert(check_partition<Partition_>());
    static_assert(check_approximation<A>());
    static_assert(check_cost_model<C>());
    if constexpr (StatesPartitionFacts<Partition_> && StatesApproximationFacts<A>) {
        static_assert(AssignmentAgreed<Partition_, A>,
                      "farfield: the partition offers no assignment (unique, shared, clipped) that the approximation "
                      "accepts");
        static_assert(OrderSufficient<Partition_, A>,
                      "farfield: the approximation needs a stricter order (needs_ordering) than the partition gives");
    }
    return true;
}

/// What check_primitive() says of members, said of a source's.
template <class S>
constexpr bool check_source_hooks() {
    static_assert(Primitive<IndexedPrimitive<S>>,
                  "farfield: a source of primitives needs `Box bounds(std::uint32_t i) const`, or a BoxD");
    static_assert(PrimitiveWithPolygons<IndexedPrimitive<S>> ||
                      !((requires(S & s) { s.polygons(0u); }) || requires { &S::polygons; } ||
                        requires(S & s, archetype::PolygonSink sink) { s.polygons(0u, sink); }),
                  "farfield: the source's polygons() must be `template <class Sink> void polygons(std::uint32_t i, "
                  "Sink&& sink) const`");
    static_assert(
        PrimitiveWithColor<IndexedPrimitive<S>> || !requires { &S::color; },
        "farfield: the source's color() must be `glm::vec4 color(std::uint32_t i) const`");
    static_assert(
        PrimitiveWithWork<IndexedPrimitive<S>> || !requires { &S::work; },
        "farfield: the source's work() must be `Work work(std::uint32_t i) const`");
    static_assert(
        PrimitiveWithKey<IndexedPrimitive<S>> || !requires { &S::key; },
        "farfield: the source's key() must be `std::uint32_t key(std::uint32_t i) const`");
    static_assert(PrimitiveWithInstance<IndexedPrimitive<S>> ||
                      !(requires(S & s, archetype::InstanceVisitor f) { s.visit_instance(0u, f); }),
                  "farfield: the source's visit_instance() must be `template <class F> bool "
                  "visit_instance(std::uint32_t i, F&& f) const`");
    return true;
}
template <class P>
inline constexpr bool source_hooks_are_sound = true;
template <class S>
inline constexpr bool source_hooks_are_sound<IndexedPrimitive<S>> = check_source_hooks<S>();

template <class P>
constexpr bool check_primitive() {
    static_assert(source_hooks_are_sound<P>);
    using Traits = primitive_traits<P>;
    static_assert(Primitive<P>,
                  "farfield: a primitive needs `Box bounds() const`, or a BoxD, as a member or in a "
                  "specialization of farfield::primitive_traits");
    static_assert(
        PrimitiveWithPolygons<P> || !(requires(P & p, archetype::PolygonSink sink) { p.polygons(sink); }),
        "farfield: the primitive's polygons() must be `template <class Sink> void polygons(Sink&& sink) const`");
    static_assert(PrimitiveWithPolygons<P> || !(requires(P & p, archetype::PolygonSink sink) { p.polygon(sink); }),
                  "farfield: the primitive has polygon(), which nobody asks for: `polygons` is what is meant");
    static_assert(PrimitiveWithColor<P> || !((requires(P & p) { p.color(); }) || requires(P & p) { Traits::color(p); }),
                  "farfield: the primitive's color() must be `glm::vec4 color() const`");
    static_assert(PrimitiveWithColor<P> || !(requires(P & p) { p.colour(); }),
                  "farfield: the primitive has colour(), which nobody asks for: `color` is what is meant");
    static_assert(PrimitiveWithWork<P> || !((requires(P & p) { p.work(); }) || requires(P & p) { Traits::work(p); }),
                  "farfield: the primitive's work() must be `Work work() const`");
    static_assert(PrimitiveWithKey<P> || !((requires(P & p) { p.key(); }) || requires(P & p) { Traits::key(p); }),
                  "farfield: the primitive's key() must be `std::uint32_t key() const`");
    static_assert(PrimitiveWithInstance<P> || !(requires(P & p, archetype::InstanceVisitor f) { p.visit_instance(f); }),
                  "farfield: the primitive's visit_instance() must be `template <class F> bool visit_instance(F&& f) "
                  "const`");
    static_assert(
        PrimitiveWithInstance<P> || !(requires(P & p, archetype::InstanceVisitor f) { p.visit_instances(f); }),
        "farfield: the primitive has visit_instances(), which nobody asks for: `visit_instance` is what is "
        "meant");
    return true;
}

template <class H, class P>
constexpr bool check_buildable() {
    static_assert(check_primitive<P>());
    static_assert(HasPolygonsIfNeeded<P, typename H::approximation_type>,
                  "farfield: the approximation needs the primitive's `template <class Sink> void polygons(Sink&& sink) "
                  "const`");
    static_assert(CanBeClippedIfNeeded<P, H>,
                  "farfield: the partition cuts the primitive's polygons, which needs `template <class Sink> void "
                  "polygons(Sink&& sink) const`");
    return true;
}

template <class H, class S>
constexpr bool check_sampler() {
    static_assert(
        PaintsPolygons<S> ||
            !(
                requires(S & s, const Polygon& polygon, const Box& seen, archetype::PaintedSink sink) {
                    s.paint(polygon, seen, 1.0f, sink);
                } ||
                requires(S & s, const Polygon& polygon, archetype::PaintedSink sink) { s.paint(polygon, sink); } ||
                requires { &S::paint; }),
        "farfield: the sampler's paint() must be `template <class Sink> void paint(const Polygon&, const Box& "
        "seen, float finest, Sink&& sink) const`");
    static_assert(!PaintsPolygons<S> || !H::approximation_type::facts.stands_in || H::assignment != Assignment::clipped,
                  "farfield: the sampler has paint(), which needs a partition that does not cut polygons: pieces carry "
                  "no values");
    static_assert(LightsPolygons<S> || !(requires(S & s, const Polygon& polygon, glm::vec3 facing_viewer) {
                      s.brightness(polygon, facing_viewer);
                  }),
                  "farfield: the sampler's brightness() must be `float brightness(const Polygon&, glm::vec3 "
                  "facing_viewer) const`");
    return true;
}

template <class R, class P>
constexpr bool check_renderer() {
    static_assert(StatesItsFacts<R>, "farfield: a renderer needs `static constexpr RendererFacts facts`");
    static_assert(
        requires(R & r, const LocalView& view) { r.begin_frame(view); },
        "farfield: a renderer needs `void begin_frame(const LocalView&)`");
    static_assert(
        requires(R & r, const LocalView& view) { r.set_view(view); },
        "farfield: a renderer needs `void set_view(const LocalView&)`");
    static_assert(
        requires(R & r) { r.end_frame(); }, "farfield: a renderer needs `void end_frame()`");
    static_assert(DrawsRuns<R, P>, "farfield: a renderer needs `void draw(const Source<P>&, std::span<const Range>)`");
    if constexpr (StatesItsFacts<R>) {
        static_assert(
            KeepsSourcesIfStated<R, P>,
            "farfield: a renderer with `keeps_sources` needs `std::uint32_t upload(const Source<P>&)` and `void "
            "release(std::uint32_t)`, for this primitive");
        static_assert(SharesSourcesIfStated<R>,
                      "farfield: a renderer with `shares_sources` needs `keeps_sources` and `std::uint32_t share(const "
                      "R& other, std::uint32_t id)`");
        static_assert(TellsLifetimeIfStated<R>,
                      "farfield: a renderer with `tells_lifetime` needs "
                      "`std::weak_ptr<const void> lifetime() const`");
        static_assert(TellsLightIfStated<R>,
                      "farfield: a renderer with `tells_light` needs "
                      "`std::optional<DirectionalLight> light() const`");
        static_assert(DrawsFacesIfStated<R>,
                      "farfield: a renderer with `draws_faces` needs `void draw(std::span<const Face>)`");
        static_assert(DrawsSplatsIfStated<R>,
                      "farfield: a renderer with `draws_splats` needs `void "
                      "draw(std::span<const Splat>)` and `float largest_splat_px() const`");
        static_assert(ShapesStandInsIfStated<R>,
                      "farfield: a renderer with `shapes_stand_ins` needs `draws_splats`, `void draw(const "
                      "PlacedStandIns&)` and `bool shapes_stand_ins() const`");
        static_assert(DrawsPolygonsIfStated<R>,
                      "farfield: a renderer with `draws_polygons` needs `void draw(std::span<const Polygon>)`");
        static_assert(AnswersHiddenIfStated<R>,
                      "farfield: a renderer with `answers_hidden` needs `bool hidden(const Cell&, CellId)`");
        static_assert(DepositsPrimitivesIfStated<R>,
                      "farfield: a renderer with `deposits_primitives` needs `bool deposits_primitives() const`");
        static_assert(
            KeepsImagesIfStated<R>,
            "farfield: a renderer with `keeps_images` needs `void begin_image(const LocalView&, float quad_depth, int "
            "samples)`, `std::uint32_t end_image()`, `void free_image(std::uint32_t)`, `std::size_t image_bytes(int "
            "width, int height) const` and `void draw(std::span<const ImageQuad>)`");
        static_assert(SlicesImagesIfStated<R>,
                      "farfield: a renderer with `slices_images` needs `keeps_images`, `void begin_image(const "
                      "LocalView&, std::span<const ImageSlice>, int samples)` and `void "
                      "end_image(std::span<std::uint32_t>)`");
    }
    return true;
}

template <class H, class P, class R>
constexpr bool check_drawable() {
    static_assert(check_buildable<H, P>());
    static_assert(check_renderer<R, P>());
    if constexpr (StatesItsFacts<R>) {
        static_assert(DrawsStandInsIfAny<R, typename H::approximation_type>,
                      "farfield: the hierarchy has stand-ins, which needs a renderer with `draws_faces`");
        static_assert(KeepsImagesIfCached<R, typename H::approximation_type>,
                      "farfield: the hierarchy caches images, which needs a renderer with `keeps_images`");
        static_assert(OrderGoodEnough<R, H>,
                      "farfield: the renderer needs a stricter order (needs_ordering) than the hierarchy keeps");
    }
    return true;
}

}  // namespace farfield::detail
