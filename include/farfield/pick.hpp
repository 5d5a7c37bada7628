// What lies under a pixel, or along a ray: the primitive itself, whatever is drawn in its place.
#pragma once

#include "farfield/settings.hpp"

#include <cstddef>
#include <cstdint>
#include <glm/common.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "farfield/drawables.hpp"
#include "farfield/fail.hpp"
#include "farfield/frame/subtree.hpp"
#include "farfield/geometry/box.hpp"
#include "farfield/geometry/cell.hpp"
#include "farfield/geometry/polygon.hpp"
#include "farfield/geometry/ray.hpp"
#include "farfield/geometry/visit_order.hpp"
#include "farfield/hierarchy/node.hpp"
#include "farfield/primitive.hpp"
#include "farfield/primitive_source.hpp"
#include "farfield/spatial_hierarchy.hpp"
#include "farfield/view.hpp"
#include "farfield/view/pixel_ray.hpp"

namespace farfield {

struct PickedPrimitive {
    double distance = 0;  ///< Ray::at(distance) is the point that was hit
    /// Indices of the instances on the way, the outermost first, each into the primitives that hold it, and last the
    /// index of the primitive. Never empty.
    std::vector<std::uint32_t> path;
    std::uint32_t node = 0;  ///< of the innermost hierarchy: the cell that holds the primitive
};

namespace detail {

struct AcceptAll {
    template <class P>
    bool operator()(const P&, const PickedPrimitive&) const {
        return true;
    }
};

/// One descent along one ray. Cells are skipped that begin behind what was found.
template <class Accept>
class Picking {
  public:
    explicit Picking(Accept& accept) : accept_(accept) {}

    /// `ray` is in the user's coordinates of this hierarchy; distances mean the same in all, for an instance's ray is
    /// made shorter as its contents are made larger.
    template <class H, class Span>
    void search(const H& hierarchy, const Span& primitives, Ray ray) {
        using P = PrimitiveIn<Span>;
        if (!PagedAtRunTime<H> && primitives.size() != hierarchy.primitive_count()) {
            fail<std::invalid_argument>(
                "farfield::pick: a hierarchy is given more or fewer primitives than it was "
                "built from");
        }
        ray.origin -= hierarchy.origin();
        if (hierarchy.item_count() == 0) return;
        const Visit<H, P> visit{{primitives, hierarchy.order(), hierarchy.item_count(), hierarchy.origin()},
                                hierarchy,
                                RayMeeter(ray),
                                glm::vec4(glm::vec3(ray.at(ray.nearest > -missed ? ray.nearest : 0)), 1)};
        const Subtree whole = whole_of(hierarchy);
        if (meets(visit.meeter, whole.cell)) descend(visit, whole);
    }

    std::optional<PickedPrimitive> found() {
        if (nearest_.path.empty()) return std::nullopt;
        return std::move(nearest_);
    }
    /// Where pages that lie along the ray are missing.
    bool is_incomplete() const { return is_incomplete_; }
    /// The position of what was found, in the hierarchy itself.
    std::uint32_t position() const { return nearest_position_; }

  private:
    template <class H, class P>
    struct Visit {
        Source<P> source;
        const H& hierarchy;
        RayMeeter meeter;
        glm::vec4 viewpoint;
    };

    bool meets(const RayMeeter& meeter, const Cell& cell) const {
        return meets(meeter, cell.bounds_center, cell.bounds_half);
    }
    bool meets(const RayMeeter& meeter, glm::vec3 center, glm::vec3 half) const {
        const double distance = meeter.entry_distance(center, half);
        return distance < missed && (nearest_.path.empty() || distance <= nearest_.distance);
    }

    template <class V>
    void descend(const V& v, const Subtree& found) {
        Subtree subtree = found;
        if constexpr (PagedAtRunTime<std::remove_cvref_t<decltype(v.hierarchy)>>) {
            // Nothing in a page counts more than what a ray has come to.
            if (v.hierarchy.is_portal(v.hierarchy.nodes()[subtree.node]) && !v.hierarchy.follow(subtree, 0x1p60f)) {
                is_incomplete_ = true;
                return;
            }
        }
        const Node& node = v.hierarchy.nodes()[subtree.node];
        const std::uint32_t end = end_of_own_run(v.hierarchy, subtree);
        for (std::uint32_t position = node.first_item; position < end; ++position) {
            v.source.prefetch(position);
            test(v, position, subtree.node);
        }
        if (node.first_child == 0) return;
        for_each_child<VisitOrder::front_to_back>(v.hierarchy, subtree, v.viewpoint, [&](const Subtree& child) {
            if (meets(v.meeter, child.cell)) descend(v, child);
        });
    }

    template <class V>
    static std::uint32_t index_at(const V& v, std::uint32_t position) {
        return v.source.order.empty() ? position : v.source.order[position];
    }

    /// Pieces that a partition cuts are not asked but the primitive itself, because cutting rounds.
    template <class V>
    void test(const V& v, std::uint32_t position, [[maybe_unused]] std::uint32_t node) {
        const auto& primitive = v.source[position];
        using P = std::remove_cvref_t<decltype(primitive)>;
        if constexpr (PrimitiveWithInstance<P>) {
            const bool is_instance = primitive_traits<P>::visit_instance(primitive, [&](const auto& instance) {
                if (instance.hierarchy == nullptr) {
                    fail<std::invalid_argument>("farfield::pick: an instance has no hierarchy");
                }
                const BoxD bounds = instance.bounds();
                const glm::dvec3 center = bounds.center() - v.source.origin;
                if (!meets(v.meeter, glm::vec3(center), glm::vec3(bounds.size() * 0.5))) return;
                path_.push_back(index_at(v, position));
                // The inverse, and not the transpose: a rotation in single precision is none exactly.
                const auto& placed = instance.to_world;
                const glm::dmat3 to_inner = glm::inverse(glm::dmat3(placed.rotation())) / double(placed.scale());
                Ray inner = v.meeter.ray();
                inner.origin = to_inner * (inner.origin + v.source.origin - placed.translation);
                inner.direction = to_inner * inner.direction;
                search(*instance.hierarchy, instance.primitives, inner);
                path_.pop_back();
            });
            if (is_instance) return;
        }
        if constexpr (PrimitiveWithPolygons<P>) {
            double nearest = missed;
            local_polygons(primitive, v.source.origin, [&](const Polygon& polygon) {
                const auto& p = polygon.vertices;
                for_each_triangle(p.size(), [&](std::size_t a, std::size_t b, std::size_t c) {
                    nearest =
                        glm::min(nearest, v.meeter.distance_to(glm::dvec3(p[a]), glm::dvec3(p[b]), glm::dvec3(p[c])));
                });
            });
            if (nearest == missed) return;
            const std::size_t depth = path_.size();
            position_ = position;
            if constexpr (PagedAtRunTime<std::remove_cvref_t<decltype(v.hierarchy)>>) {
                for (const std::uint32_t part : v.hierarchy.place_in_file(position)) path_.push_back(part);
            } else {
                path_.push_back(index_at(v, position));
            }
            keep_nearer(primitive, nearest, node);
            path_.resize(depth);
        }
    }

    /// At one distance the one comes first that has the smaller indices, in whatever order cells were visited.
    template <class P>
    void keep_nearer(const P& primitive, double distance, std::uint32_t node) {
        if (!nearest_.path.empty()) {
            if (distance > nearest_.distance) return;
            if (distance == nearest_.distance && !(path_ < nearest_.path)) return;
        }
        candidate_.distance = distance;
        candidate_.path.assign(path_.begin(), path_.end());
        candidate_.node = node;
        if (!accept_(primitive, std::as_const(candidate_))) return;
        std::swap(nearest_, candidate_);
        nearest_position_ = position_;
    }

    Accept& accept_;
    std::vector<std::uint32_t> path_;
    PickedPrimitive nearest_, candidate_;
    std::uint32_t position_ = 0, nearest_position_ = 0;
    bool is_incomplete_ = false;
};

template <class H, class Span, class Accept>
std::optional<PickedPrimitive> pick(const H& hierarchy, const Span& primitives, const Ray& ray, Accept accept) {
    using P = PrimitiveIn<Span>;
    static_assert(PrimitiveWithPolygons<P> || PrimitiveWithInstance<P>,
                  "farfield::pick: the primitive needs polygons(sink), see farfield/primitive.hpp");
    if (!ray.is_valid()) {
        detail::fail<std::invalid_argument>("farfield::pick: a ray needs an origin and a direction that are finite");
    }
    Picking<Accept> picking(accept);
    picking.search(hierarchy, primitives, ray);
    return picking.found();
}

}  // namespace detail

/// The first primitive along a ray, in the coordinates that the hierarchy was built from, or nothing. It is found among
/// all primitives, as if every one was tested in double precision, and not by what a frame draws in their place; those
/// at one distance are told apart by their indices. Both sides of a polygon are hit. Primitives without polygons are
/// not.
///
/// `accept(primitive, picked)` may refuse what the ray is to pass through, such as glass or the picked thing's own
/// handles. It is asked about each primitive that is nearer than the nearest accepted so far, in no order.
///
/// Throws std::invalid_argument for a ray without a direction or with NaN, and if primitives are not as many as the
/// hierarchy was built from. Any number of threads may pick in one hierarchy.
template <class H, class P, class Accept = detail::AcceptAll>
std::optional<PickedPrimitive> pick(const H& hierarchy, std::span<const P> primitives, const Ray& ray,
                                    Accept accept = {}) {
    return detail::pick(hierarchy, primitives, ray, std::move(accept));
}
template <class H, CountsPrimitives S, class Accept = detail::AcceptAll>
std::optional<PickedPrimitive> pick(const H& hierarchy, const S& source, const Ray& ray, Accept accept = {}) {
    return detail::pick(hierarchy, IndexedSpan<S>(source), ray, std::move(accept));
}
template <class H, class P, class Accept = detail::AcceptAll>
std::optional<PickedPrimitive> pick(const H& hierarchy, const std::vector<P>& primitives, const Ray& ray,
                                    Accept accept = {}) {
    return pick(hierarchy, std::span<const P>(primitives), ray, std::move(accept));
}

/// What lies under a point of a view's picture: {0.5, 0.5} is the center of the topmost row's first pixel. Throws
/// std::invalid_argument as View::validate does, too.
template <class H, class P, class Accept = detail::AcceptAll>
std::optional<PickedPrimitive> pick(const H& hierarchy, std::span<const P> primitives, const View& view,
                                    glm::dvec2 pixel, Accept accept = {}) {
    return pick(hierarchy, primitives, ray_through(view, pixel), std::move(accept));
}
template <class H, class P, class Accept = detail::AcceptAll>
std::optional<PickedPrimitive> pick(const H& hierarchy, const std::vector<P>& primitives, const View& view,
                                    glm::dvec2 pixel, Accept accept = {}) {
    return pick(hierarchy, std::span<const P>(primitives), view, pixel, std::move(accept));
}

template <class H, CountsPrimitives S, class Accept = detail::AcceptAll>
std::optional<PickedPrimitive> pick(const H& hierarchy, const S& source, const View& view, glm::dvec2 pixel,
                                    Accept accept = {}) {
    return detail::pick(hierarchy, IndexedSpan<S>(source), ray_through(view, pixel), std::move(accept));
}

/// What was picked in pages, which know no indices.
template <class P>
struct PickedFromPages {
    double distance = 0;  ///< Ray::at(distance) is the point that was hit
    P primitive;
    std::uint32_t page = 0, item = 0;  ///< where it lies in the file
};

/// The first primitive along a ray through a hierarchy that lies in pages, as above; pages along the ray are loaded,
/// and waited for. Of those at one distance the first in the file is found. `pages` is a copy of the caller's own,
/// which draws no frame meanwhile. Throws std::runtime_error, with the reason, if a page that lies along the ray cannot
/// be had: nothing is known then.
template <PagedAtRunTime H, class Accept = detail::AcceptAll>
std::optional<PickedFromPages<typename H::primitive_type>> pick(H& pages, const Ray& ray, Accept accept = {}) {
    if (!ray.is_valid()) {
        detail::fail<std::invalid_argument>("farfield::pick: a ray needs an origin and a direction that are finite");
    }
    detail::Picking<Accept> picking(accept);
    std::optional<PickedFromPages<typename H::primitive_type>> out;
    {
        const WaitingFrame<H> frame(pages);
        picking.search(pages, pages.primitives(), ray);
        if (const auto found = picking.found()) {
            out = {found->distance, pages.primitives()[picking.position()], found->path[0], found->path[1]};
        }
    }
    if (picking.is_incomplete()) {
        const std::string why = pages.cache_stats().last_failure;
        detail::fail<std::runtime_error>("farfield::pick: a page on the way is missing: " +
                                         (why.empty() ? "the cache has no room for all that lie along the ray" : why));
    }
    return out;
}
template <PagedAtRunTime H, class Accept = detail::AcceptAll>
std::optional<PickedFromPages<typename H::primitive_type>> pick(H& pages, const View& view, glm::dvec2 pixel,
                                                                Accept accept = {}) {
    return pick(pages, ray_through(view, pixel), std::move(accept));
}

}  // namespace farfield
