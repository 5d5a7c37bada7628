// What a descent draws as it is: positions of a hierarchy, handed on as runs. Shared items come once a frame, those
// that fade in part, and instances among them wait until what lies before them is drawn.
#pragma once

#include "farfield/settings.hpp"

#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <utility>

#include "farfield/composition.hpp"
#include "farfield/frame/instance_stack.hpp"
#include "farfield/frame/subtree.hpp"
#include "farfield/geometry/mixed.hpp"
#include "farfield/spatial_hierarchy.hpp"

namespace farfield {

/// The order of a descent, settled at compile time. Translucent stand-ins need front to back, so that closed pixels
/// stop work, and images are translucent too; a renderer that can only blend back to front is replayed them reversed
/// after everything else.
template <class H, class R>
inline constexpr VisitOrder traversal_order =
    H::approximation_type::facts.stands_in || H::approximation_type::facts.caches_images ? VisitOrder::front_to_back
                                                                                         : R::facts.order;

namespace detail {

/// Sink is told run(entered, subtree, first, end, law), see Descent.
template <class R, class Sink>
class ItemRuns {
  public:
    ItemRuns(InstanceStack& instances, FrameStats& stats, Sink& sink)
        : instances_(instances), stats_(stats), sink_(sink) {
        instances_.resize(0);  // an exception may have ended the last one
    }

    /// The part of the items that is drawn: less than 1 where something else fades away or comes.
    float weight = 1;

    /// Where the next instances are put.
    std::size_t waiting() const { return instances_.size(); }
    void take_back(std::size_t waiting) { instances_.resize(waiting); }

    /// Hands on whatever is no instance; instances wait, front to back by their centers.
    template <class V, class Law>
    void add(V& v, const Subtree& subtree, std::uint32_t first, std::uint32_t end, const Law& law) {
        if (!v.source.order.empty()) stats_.touched_bytes += std::uint64_t(end - first) * sizeof(std::uint32_t);
        if constexpr (PrimitiveWithInstance<typename V::primitive_type>) {
            instances_.gather(
                v.source, first, end, [&](glm::vec3 p) { return order_key(v, p); },
                [&](std::uint32_t at) { return is_new(v, at); },
                [&](std::uint32_t from, std::uint32_t to) { add_run(v, subtree, from, to, law); });
        } else {
            add_run(v, subtree, first, end, law);
        }
    }

    /// draw(position) of instances that wait, from `next` on, and come before a key; returns the first that does not.
    template <class V, class Draw>
    std::size_t draw_before(std::size_t next, float end_key, Draw&& draw) {
        if constexpr (PrimitiveWithInstance<typename V::primitive_type>) {
            return instances_.draw_before(next, end_key, draw);
        } else {
            return next;
        }
    }

    /// Nearer ones first, or, for a renderer that paints, the other way around.
    template <class V>
    static float order_key(const V& v, glm::vec3 p) {
        const float distance = v.view.order_of(p);
        return traversal_order<typename V::hierarchy_type, R> == VisitOrder::back_to_front ? -distance : distance;
    }

  private:
    /// Shared items are in several cells and are drawn once a frame.
    template <class V>
    static bool is_new(V& v, std::uint32_t position) {
        if constexpr (V::hierarchy_type::assignment == Assignment::shared) {
            return v.state.is_new(v.source.order.empty() ? position : v.source.order[position]);
        } else {
            return true;
        }
    }

    template <class V, class Law>
    void add_run(V& v, const Subtree& subtree, std::uint32_t first, std::uint32_t end, const Law& law) {
        if (weight < 1) return add_part_of_run(v, subtree, first, end, law);
        if constexpr (V::hierarchy_type::assignment == Assignment::shared) {
            std::uint32_t begin = first;
            for (std::uint32_t at = first; at < end; ++at) {
                if (is_new(v, at)) continue;
                if (begin != at) sink_.run(v, subtree, begin, at, law);
                begin = at + 1;
            }
            first = begin;
        }
        if (first != end) sink_.run(v, subtree, first, end, law);
    }

    /// Primitives come one by one as what they replace fades, each where its place in the hierarchy says, or in the
    /// file where pages have no place of their own, so that more of them are more of the same.
    template <class V, class Law>
    void add_part_of_run(V& v, const Subtree& subtree, std::uint32_t first, std::uint32_t end, const Law& law) {
        std::uint32_t begin = first;
        for (std::uint32_t at = first; at < end; ++at) {
            std::uint64_t name = at;
            if constexpr (PagedAtRunTime<typename V::hierarchy_type>) name = v.hierarchy.name_of_item(at);
            const float when = (float(mixed(mixed(v.path, 0x66616465), name) >> 40) + 0.5f) * 0x1p-24f;
            if (when < weight && is_new(v, at)) continue;
            if (begin != at) sink_.run(v, subtree, begin, at, law);
            begin = at + 1;
        }
        if (begin != end) sink_.run(v, subtree, begin, end, law);
    }

    InstanceStack& instances_;
    FrameStats& stats_;
    Sink& sink_;
};

}  // namespace detail
}  // namespace farfield
