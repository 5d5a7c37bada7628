// One viewer's frames over one hierarchy. All that lives across frames lives here; hierarchies never change.
//
//     outside the frustum                                              -> cull
//     has a stand-in whose error from here is within tolerance         -> draw the stand-in
//     hidden as far as the renderer can tell                           -> cull
//     nothing below can stand in and all of it lies in the frustum     -> draw the subtree's primitives, one run (*)
//     otherwise                                                        -> draw the own run, visit the children in order
//
// (*) Where the renderer deposits primitives and the cell's law is known, only if they are few: order matters then.
//
// The Render procedure of Chamberlain et al. 1995, section 3.1, with culling as in 1996; the third line is ours and
// makes near geometry as cheap as without a hierarchy. Selecting and drawing are one descent as long as no policy keeps
// images across frames.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "farfield/draw_queue.hpp"
#include "farfield/fingerprint.hpp"
#include "farfield/geometry/frustum.hpp"
#include "farfield/instance_stack.hpp"
#include "farfield/policy.hpp"
#include "farfield/source_table.hpp"
#include "farfield/spatial_hierarchy.hpp"

namespace farfield {

/// The order of a descent, settled at compile time. Translucent stand-ins need front to back, so that closed pixels
/// stop work; a renderer that can only blend back to front is replayed them reversed after everything else.
template <class H, class R>
inline constexpr Order traversal_order = H::approximation_type::facts.stands_in ? Order::front_to_back : R::facts.order;

namespace detail {
inline constexpr auto bits_set = [] {
    std::array<std::uint8_t, 256> table{};
    for (unsigned i = 1; i < 256; ++i) table[i] = std::uint8_t(table[i / 2] + i % 2);
    return table;
}();
}  // namespace detail

/// Borrows hierarchy, primitives and renderer, which outlive it. Not to be used by two threads at once; many viewers
/// may share a hierarchy. Frames do not allocate once buffers have grown to what the scene needs.
template <class H, class P, class R>
requires BuildableFrom<H, P> && DrawableWith<H, P, R>
class Viewer {
  public:
    /// Throws std::invalid_argument if the span is not the one (by count; for hierarchies from files also by bounds)
    /// that the hierarchy, or an instance in it, was built from; or if the renderer needs polygons in strict order and
    /// one of them does not keep it.
    Viewer(const H& hierarchy, std::span<const P> primitives, R& renderer)
        : hierarchy_(hierarchy),
          primitives_(primitives),
          renderer_(renderer),
          sources_(renderer),
          queue_(renderer, stats_) {
        sources_.add_all(hierarchy, primitives);
    }
    Viewer(const Viewer&) = delete;
    Viewer& operator=(const Viewer&) = delete;

    /// Draws into the renderer. Throws only what the renderer's begin_frame throws, and for memory.
    FrameStats frame(const View& view) {
        stats_ = {};
        queue_.begin_frame();
        const Box& b = hierarchy_.bounds();
        const float diagonal = b.is_empty() ? 1.0f : std::sqrt(glm::dot(b.size(), b.size()));
        const LocalView local(view, hierarchy_.origin(), diagonal);
        renderer_.begin_frame(local);
        // A tolerance of 0 means every primitive as it is.
        if constexpr (R::facts.deposits_primitives)
            deposits_ = view.tolerance_px > 0 && renderer_.deposits_primitives();
        queue_.set_view(local);
        enter(hierarchy_, primitives_, local, 0);
        queue_.replay();
        stats_.touched_bytes += stats_.cells_visited * sizeof(Node);
        renderer_.end_frame();
        return stats_;
    }

  private:
    /// Whether a cell is hidden is not asked for fewer items: the answer costs about as much as drawing ten.
    static constexpr std::uint32_t asking_pays_above = 24;

    /// What is deposited covers what comes later, in front of it or not. In runs of 128, point sampling told the inner
    /// triangles of a molecule from the outer ones better; 16 is no better than 32.
    static constexpr std::uint32_t order_matters_above = 32;

    /// One entry of a hierarchy: the outermost one, or an instance.
    template <class H2, class P2>
    struct Visit {
        using primitive_type = P2;
        const H2& hierarchy;
        Source<P2> source;
        const LocalView& view;
        std::uint64_t path;
        detail::SourceState& state;
    };
    template <class H2, class P2>
    void enter(const H2& h, std::span<const P2> primitives, const LocalView& view, std::uint64_t path) {
        static_assert(DrawableWith<H2, P2, R>, "the renderer must be able to draw what instances hold");
        if (h.item_count() == 0) return;
        detail::SourceState& state = sources_.find(h, primitives);
        if constexpr (H2::assignment == shared) state.begin_epoch();
        using V = Visit<H2, P2>;
        V v{h, detail::source_of(h, primitives, state.id), view, path, state};
        visit(v, 0, h.root_cell(), h.item_count(), h.root_stand_in(), LawOf<V>(), all_planes);
        queue_.flush(v.source);
    }

    /// Drawing a subtree as one run gives up its order. Instances need it for the stand-ins inside of them, and a
    /// renderer that wants cells front to back hides some behind others.
    template <class V>
    static constexpr bool may_draw_whole =
        !PrimitiveWithInstance<typename V::primitive_type> && R::facts.order == Order::any;

    /// Runs have a law only where both sides know what it is for; elsewhere nothing is carried down.
    struct NoLaw {
        constexpr operator std::optional<AreaLaw>() const { return {}; }
    };
    template <class V>
    static constexpr bool carries_law =
        R::facts.deposits_primitives&& std::remove_cvref_t<decltype(V::hierarchy)>::approximation_type::facts.knows_law;
    template <class V>
    using LawOf = std::conditional_t<carries_law<V>, std::optional<AreaLaw>, NoLaw>;

    /// `law` is that of the nearest ancestor with a stand-in.
    template <class V, class CellData>
    void visit(V& v, std::uint32_t index, const Cell& cell, std::uint32_t end_item, const CellData* data, LawOf<V> law,
               PlaneMask mask) {
        ++stats_.cells_visited;
        if (mask != 0) {
            mask = crossed_planes(v.view.planes, cell.bounds_center, cell.bounds_half, mask);
            if (mask == outside_a_plane) {
                ++stats_.cells_outside;
                return;
            }
        }
        const auto& h = v.hierarchy;
        using A = typename std::remove_cvref_t<decltype(h)>::approximation_type;
        const Node& node = h.nodes()[index];
        // Level 0 is the node itself, whose stand-in is asked first.
        bool may_stand_in_below = node.child_mask != 0 && node.levels_to_last_stand_in != Node::nothing_below &&
                                  node.levels_to_last_stand_in != 0;
        if constexpr (A::facts.stands_in) {
            const A& approximation = h.approximation_policy();
            // A tolerance of 0 means every primitive, also of a cell without extent.
            if (data != nullptr && v.view.tolerance_px > 0 &&
                approximation.error_px(*data, cell, v.view) * detail::error_of_reach(node) <= v.view.tolerance_px) {
                stand_in(v, *data, cell);
                return;
            }
            if constexpr (A::facts.bounds_error && std::remove_cvref_t<decltype(h)>::partition_type::facts.halves) {
                may_stand_in_below =
                    may_stand_in_below &&
                    approximation.least_error_px(cell, node.levels_to_last_stand_in, v.view) <= v.view.tolerance_px;
            }
        }
        if constexpr (R::facts.answers_hidden) {
            if (end_item - node.first_item > asking_pays_above) {
                // What waits lies in front and may be what hides it.
                if constexpr (R::facts.order == Order::front_to_back) queue_.flush(v.source);
                if (renderer_.hidden(cell, CellId{v.path, index})) {
                    ++stats_.cells_hidden;
                    return;
                }
            }
        }
        const std::uint32_t items = end_item - node.first_item;
        bool as_one_run = mask == 0 || items <= detail::culling_pays_above;
        if constexpr (carries_law<V>) {
            if (deposits_ && data != nullptr) law = h.approximation_policy().law(*data);
            if (law) as_one_run = items <= order_matters_above;
        }
        if (node.child_mask == 0 || (!may_stand_in_below && may_draw_whole<V> && as_one_run)) {
            draw_items(v, node.first_item, end_item, law);
            return;
        }
        visit_children(v, index, node, cell, end_item, law, mask);
    }

    template <class V>
    void visit_children(V& v, std::uint32_t index, const Node& node, const Cell& cell, std::uint32_t end_item,
                        LawOf<V> law, PlaneMask mask) {
        const auto& h = v.hierarchy;
        using H2 = std::remove_cvref_t<decltype(h)>;
        const std::span<const Node> nodes = h.nodes();
        const auto& node_data = h.data_of(index);
        h.prefetch_data_of(node.first_child);
        const std::size_t own_instances = instances_.size();
        const std::uint32_t own_end = nodes[node.first_child].first_item;
        if (own_end != node.first_item) gather_items(v, node.first_item, own_end, law);
        ChildOrder order{0, 1, 2, 3, 4, 5, 6, 7};
        if constexpr (traversal_order<H2, R> != Order::any) {
            h.partition_policy().front_to_back(cell, node_data, v.view.viewpoint(), order);
        }
        if constexpr (traversal_order<H2, R> == Order::back_to_front) std::reverse(order.begin(), order.end());
        const unsigned children = detail::bits_set[node.child_mask];
        std::size_t next_instance = own_instances;
        for (const unsigned child : order) {
            if ((node.child_mask >> child & 1) == 0) continue;
            const unsigned below = (1u << child) - 1;
            const unsigned rank = detail::bits_set[node.child_mask & below];
            const std::uint32_t at = node.first_child + rank;
            const typename H2::cell_data* data = nullptr;
            if constexpr (H2::approximation_type::facts.stands_in) {
                if (node.stand_in_mask >> child & 1) {
                    data = &h.stand_ins()[node.first_child_data + detail::bits_set[node.stand_in_mask & below]];
                }
            }
            const Cell child_cell = h.partition_policy().child(cell, node_data, child);
            next_instance = draw_gathered(v, next_instance, order_key(v, child_cell.bounds_center));
            visit(v, at, child_cell, rank + 1 < children ? nodes[at + 1].first_item : end_item, data, law, mask);
        }
        draw_gathered(v, next_instance, std::numeric_limits<float>::infinity());
        instances_.resize(own_instances);
    }

    template <class V, class CellData>
    void stand_in(V& v, const CellData& data, const Cell& cell) {
        struct Sink {
            Viewer& viewer;
            V& v;
            float splat_limit_px;
            void operator()(const Face& face) const { viewer.queue_.add(v.source, face); }
            void operator()(const Splat& splat) const { viewer.queue_.add(v.source, splat); }
        };
        ++stats_.approximations;
        ++stats_.approximations_by_level[std::min<int>(cell.depth, FrameStats::max_levels - 1)];
        stats_.touched_bytes += sizeof data;
        v.hierarchy.approximation_policy().stand_in(data, v.hierarchy.pool(), cell, v.view,
                                                    Sink{*this, v, queue_.splat_limit_px()});
    }

    /// Positions [first, end), of instances what they hold.
    template <class V>
    void draw_items(V& v, std::uint32_t first, std::uint32_t end, LawOf<V> law) {
        const std::size_t base = instances_.size();
        gather_items(v, first, end, law);
        draw_gathered(v, base, std::numeric_limits<float>::infinity());
        instances_.resize(base);
    }

    /// Draws whatever is no instance; instances go on the stack, front to back by their centers.
    template <class V>
    void gather_items(V& v, std::uint32_t first, std::uint32_t end, LawOf<V> law) {
        if (!v.source.order.empty()) stats_.touched_bytes += std::uint64_t(end - first) * sizeof(std::uint32_t);
        if constexpr (PrimitiveWithInstance<typename V::primitive_type>) {
            instances_.gather(
                v.source, first, end, [&](glm::vec3 p) { return order_key(v, p); },
                [&](std::uint32_t at) { return is_new(v, at); },
                [&](std::uint32_t from, std::uint32_t to) { add_range(v, from, to, law); });
        } else {
            add_range(v, first, end, law);
        }
    }

    /// Those of the stack from `next` on that come before a key; returns the first that does not.
    template <class V>
    std::size_t draw_gathered(V& v, std::size_t next, float end_key) {
        using P2 = typename V::primitive_type;
        if constexpr (PrimitiveWithInstance<P2>) {
            return instances_.draw_before(next, end_key, [&](std::uint32_t position) {
                const P2& p = v.source[position];
                primitive_traits<P2>::visit_instance(p, [&](const auto& instance) {
                    draw_instance(v, instance, std::uint64_t(&p - v.source.primitives.data()));
                });
            });
        } else {
            return next;
        }
    }

    /// Nearer ones first, or, for a renderer that paints, the other way around.
    template <class V>
    static float order_key(const V& v, glm::vec3 p) {
        const float distance = v.view.is_perspective ? glm::distance(p, v.view.eye) : v.view.depth(p);
        return traversal_order<std::remove_cvref_t<decltype(v.hierarchy)>, R> == Order::back_to_front ? -distance
                                                                                                      : distance;
    }

    template <class V, class I>
    void draw_instance(V& v, const I& instance, std::uint64_t primitive) {
        queue_.flush(v.source);
        ++stats_.instances;
        const LocalView inner = v.view.inside(instance.to_world, v.hierarchy.origin(), instance.hierarchy->origin());
        queue_.set_view(inner);
        enter(*instance.hierarchy, instance.primitives, inner, detail::mixed(v.path, primitive + 1));
        queue_.set_view(v.view);
    }

    /// Shared items are in several cells and are drawn once a frame.
    template <class V>
    bool is_new(V& v, std::uint32_t position) {
        if constexpr (std::remove_cvref_t<decltype(v.hierarchy)>::assignment == shared) {
            return v.state.is_new(v.source.order.empty() ? position : v.source.order[position]);
        } else {
            return true;
        }
    }

    template <class V>
    void add_range(V& v, std::uint32_t first, std::uint32_t end, LawOf<V> law) {
        if constexpr (std::remove_cvref_t<decltype(v.hierarchy)>::assignment == shared) {
            std::uint32_t begin = first;
            for (std::uint32_t at = first; at < end; ++at) {
                if (is_new(v, at)) continue;
                queue_.add_run(v.source, begin, at, law);
                begin = at + 1;
            }
            first = begin;
        }
        queue_.add_run(v.source, first, end, law);
    }

    const H& hierarchy_;
    std::span<const P> primitives_;
    R& renderer_;
    FrameStats stats_;
    detail::SourceTable<R> sources_;
    DrawQueue<R> queue_;
    bool deposits_ = false;  ///< in this frame, where a law is known
    detail::InstanceStack instances_;
};

/// Prefer this to naming the type: where something is missing, compilers say what.
template <class H, class P, class R>
requires BuildableFrom<H, P> && DrawableWith<H, P, R>
auto make_viewer(const H& hierarchy, std::span<const P> primitives, R& renderer) {
    return Viewer<H, P, R>(hierarchy, primitives, renderer);
}
template <class H, class P, class R>
requires BuildableFrom<H, P> && DrawableWith<H, P, R>
auto make_viewer(const H& hierarchy, const std::vector<P>& primitives, R& renderer) {
    return Viewer<H, P, R>(hierarchy, std::span<const P>(primitives), renderer);
}

}  // namespace farfield
