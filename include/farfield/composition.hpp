// These concepts say what goes together: three policies; a hierarchy and a primitive; both and a renderer.
#pragma once

#include "farfield/settings.hpp"

#include <stdexcept>
#include <string>

#include "farfield/approximation.hpp"
#include "farfield/cost_model.hpp"
#include "farfield/fail.hpp"
#include "farfield/geometry/visit_order.hpp"
#include "farfield/partition.hpp"
#include "farfield/primitive.hpp"
#include "farfield/renderer.hpp"

namespace farfield {

template <class Partition_, class A>
concept AssignmentAgreed = !(Partition_::facts.offers & A::facts.accepts).is_empty();
template <class Partition_, class A>
concept OrderSufficient = Partition_::facts.ordering >= A::facts.needs_ordering;

template <class Partition_, class A, class C>
concept Composable = Partition<Partition_> && Approximation<A> && CostModel<C> && AssignmentAgreed<Partition_, A> &&
    OrderSufficient<Partition_, A>;

/// The assignment that partition and approximation agree upon: unique where both can, for it makes one run of every
/// subtree.
template <class Partition_, class A>
requires AssignmentAgreed<Partition_, A>
inline constexpr Assignment agreed_assignment = [] {
    constexpr Assignments both = Partition_::facts.offers & A::facts.accepts;
    if (both.contains(Assignment::unique)) return Assignment::unique;
    return both.contains(Assignment::clipped) ? Assignment::clipped : Assignment::shared;
}();

namespace detail {
/// Throws std::invalid_argument if an option makes no sense.
template <class T>
void check_options(const T& policy) {
    if (const char* why = wrong_option(policy)) detail::fail<std::invalid_argument>(std::string("farfield::") + why);
}

template <class P, class A>
concept HasPolygonsIfNeeded = !A::facts.needs_polygons || PrimitiveWithPolygons<P>;
template <class P, class H>
concept CanBeClippedIfNeeded = H::assignment != Assignment::clipped || PrimitiveWithPolygons<P>;
template <class R, class A>
concept DrawsStandInsIfAny = !A::facts.stands_in || R::facts.draws_faces;
template <class R, class A>
concept KeepsImagesIfCached = !A::facts.caches_images || R::facts.keeps_images;
}  // namespace detail

/// H is a SpatialHierarchy.
template <class H, class P>
concept BuildableFrom = Primitive<P> && detail::HasPolygonsIfNeeded<P, typename H::approximation_type> &&
    detail::CanBeClippedIfNeeded<P, H>;

template <class R, class H>
concept OrderGoodEnough = H::ordering >= R::facts.needs_ordering;

template <class H, class P, class R>
concept DrawableWith = Renderer<R, P> && detail::DrawsStandInsIfAny<R, typename H::approximation_type> &&
    detail::KeepsImagesIfCached<R, typename H::approximation_type> && OrderGoodEnough<R, H>;

}  // namespace farfield
