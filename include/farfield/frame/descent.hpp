// The cut is chosen by one descent over a hierarchy and the instances in it. It tells a sink what is to be drawn, and
// in which order; the sink draws it at once or keeps it.
//
//     outside the frustum                                              -> cull
//     has a stand-in whose error from here is within tolerance         -> draw the stand-in
//     hidden as far as the sink can tell                               -> cull
//     no more is wanted than point sampling gives, and costs less      -> draw the subtree's primitives, one run
//     nothing below can stand in and all of it lies in the frustum     -> draw the subtree's primitives, one run (*)
//     otherwise                                                        -> draw the own run, visit the children in order
//
// (*) Where the renderer deposits primitives and the cell's law is known, only if they are few: order matters then.
//
// The Render procedure of Chamberlain et al. 1995, section 3.1, with culling as in 1996; the fourth and fifth lines
// are ours, and make near geometry as cheap as without a hierarchy.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <utility>

#include "farfield/composition.hpp"
#include "farfield/frame/instance_stack.hpp"
#include "farfield/frame/item_runs.hpp"
#include "farfield/frame/left_out_samples.hpp"
#include "farfield/frame/source_table.hpp"
#include "farfield/frame/stand_in_choice.hpp"
#include "farfield/frame/subtree.hpp"
#include "farfield/frame/view_ahead.hpp"
#include "farfield/geometry/area_law.hpp"
#include "farfield/spatial_hierarchy.hpp"

namespace farfield::detail {

enum class CellDrawn : std::uint8_t {
    by_image,     ///< the sink has drawn it
    in_parts,     ///< cells below may be drawn by images
    as_contents,  ///< no cell below is
};

template <class Sink, class H>
inline constexpr bool asks_for_images = requires {
    Sink::keeps_images;
}
&&H::approximation_type::facts.caches_images;

/// A cut that the view's tolerance decides alone.
struct WithinTolerance {
    static constexpr bool is_limited = false;
};

/// Sink is told, in order:
///
///     enter(entered), leave(entered)                what lies between is in that hierarchy's coordinates
///     run(entered, subtree, first, end, law)        positions that lie in a subtree; law unset: draw one by one
///     stand_in(entered, subtree)                    the subtree's stand-in
///     stand_in_for_missing(entered, subtree, weight)   likewise, of a cell whose contents are missing, however near
///     enter_instance(entered, position)             followed by enter() of what it holds; leave_instance(entered)
///     hidden(entered, subtree) -> bool              whether it cannot be seen behind what came before
///
/// and, if it has `keeps_images`, where the approximation caches images, of cells that may have one:
///
///     begin_cell(entered, subtree) -> CellDrawn     what is to be drawn of it
///     end_cell(entered, subtree)                    after its contents, unless it was drawn by its image
///
/// R is the renderer that it is chosen for. All but the sink is a viewer's own and lives from frame to frame.
///
/// A limited Cut (frame/frame_budget.hpp) says of each cell beyond the tolerance whether it is opened: opens(entered,
/// subtree). Where it is not, its stand-in is drawn, or nothing if it has none.
template <class R, class Sink, class Cut = WithinTolerance>
class Descent {
  public:
    /// `deposits`: in this frame runs carry their cells' laws, where they are known.
    Descent(SourceTable<R>& sources, InstanceStack& instances, FrameStats& stats, Sink& sink, bool deposits,
            const Cut& cut = {})
        : sources_(sources),
          stats_(stats),
          sink_(sink),
          deposits_(deposits),
          items_(instances, stats, sink),
          cut_(cut) {}

    template <class H, class Span>
    void enter(const H& h, const Span& primitives, const LocalView& view, std::uint64_t path) {
        using P = PrimitiveIn<Span>;
        static_assert(DrawableWith<H, P, R>, "the renderer must be able to draw what instances hold");
        if (h.item_count() == 0) return;
        SourceState& state = sources_.find(h, primitives);
        if constexpr (H::assignment == Assignment::shared) state.begin_epoch();
        Visit<H, P> v{{h, source_of(h, primitives, state.id), view, path}, state};
        sink_.enter(v);
        Subtree whole = whole_of(h);
        visit(v, whole, LawOf<Visit<H, P>>());
        sink_.leave(v);
    }

    /// A part of a hierarchy, as it would be drawn in its place, by a view of its own.
    template <class H, class Span>
    void enter_at(const H& h, const Span& primitives, const LocalView& view, std::uint64_t path, Subtree subtree) {
        using P = PrimitiveIn<Span>;
        SourceState& state = sources_.find(h, primitives);
        if constexpr (H::assignment == Assignment::shared) state.begin_epoch();
        Visit<H, P> v{{h, source_of(h, primitives, state.id), view, path}, state};
        subtree.crossed_planes = all_planes;
        subtree.crossed_borders = all_borders;
        sink_.enter(v);
        visit(v, subtree, LawOf<Visit<H, P>>(), /*may_be_image=*/false);  // but what is below may
        sink_.leave(v);
    }

  private:
    template <class H, class P>
    struct Visit : Entered<H, P> {
        SourceState& state;
    };

    /// Drawing a subtree as one run gives up its order. Instances need it for the stand-ins inside of them, and a
    /// renderer that wants cells front to back hides some behind others.
    template <class V>
    static constexpr bool may_draw_whole =
        !PrimitiveWithInstance<typename V::primitive_type> && R::facts.order == VisitOrder::any;

    /// Runs have a law only where both sides know what it is for; elsewhere nothing is carried down.
    struct NoLaw {
        constexpr operator std::optional<AreaLaw>() const { return {}; }
    };
    template <class V>
    static constexpr bool carries_law =
        R::facts.deposits_primitives&& V::hierarchy_type::approximation_type::facts.provides_area_law;
    template <class V>
    using LawOf = std::conditional_t<carries_law<V>, std::optional<AreaLaw>, NoLaw>;

    /// `law` is that of the nearest ancestor with a stand-in. Planes that the subtree does not cross are taken away.
    template <class V>
    void visit(V& v, Subtree& subtree, LawOf<V> law, bool may_be_image = true) {
        ++stats_.cells_visited;
        if (is_outside(v.view.planes, subtree) || is_beyond_borders(v, subtree)) {
            ++stats_.cells_outside;
            if constexpr (PagedAtRunTime<typename V::hierarchy_type>) expect_outside(v, subtree);
            return;
        }
        const auto& h = v.hierarchy;
        if constexpr (V::hierarchy_type::approximation_type::facts.stands_in) {
            if (may_stand_in(v, subtree)) {
                if (keeps_wanted_error(v, subtree)) return draw_stand_in_and_fade(v, subtree, law);
                ++stats_.cells_too_coarse;
                stats_.cells_needing_samples += needs_more_samples(v, subtree);
            }
        }
        if constexpr (PagedAtRunTime<typename V::hierarchy_type>) {
            // Pages are not loaded for what cannot be seen.
            const Node& portal = h.nodes()[subtree.node];
            if (h.is_portal(portal) && is_hidden(v, subtree, h.items_below(portal))) return;
            if (!is_there(v, subtree)) {
                ++stats_.cells_missing;
                return draw_for_missing(v, subtree);
            }
        }
        const Node& node = h.nodes()[subtree.node];
        if constexpr (Cut::is_limited) {
            if (!cut_.opens(v, subtree)) {
                if constexpr (V::hierarchy_type::approximation_type::facts.stands_in) {
                    if (subtree.has_stand_in()) draw_stand_in(v, subtree);
                }
                return;
            }
        }
        const std::uint32_t items = subtree.end_item - node.first_item;
        if (!PagedAtRunTime<typename V::hierarchy_type> && is_hidden(v, subtree, items)) return;
        if constexpr (V::hierarchy_type::approximation_type::facts.stands_in && may_draw_whole<V> &&
                      !PagedAtRunTime<typename V::hierarchy_type>) {
            if (is_cheaper_exactly(v, subtree)) {
                ++stats_.cells_cheaper;
                draw_whole(v, subtree, node, law);
                return;
            }
        }
        if constexpr (asks_for_images<Sink, typename V::hierarchy_type>) {
            if (may_be_image && may_have_image(v, items)) {
                const CellDrawn drawn = sink_.begin_cell(v, subtree);
                if (drawn == CellDrawn::by_image) return;
                visit_contents(v, subtree, node, items, law, drawn == CellDrawn::in_parts);
                sink_.end_cell(v, subtree);
                return;
            }
        }
        visit_contents(v, subtree, node, items, law, /*has_images_below=*/!may_be_image);
    }

    /// Whether a subtree of so many items cannot be seen, as far as the renderer knows.
    template <class V>
    bool is_hidden(V& v, const Subtree& subtree, std::uint32_t items) {
        if constexpr (R::facts.answers_hidden) {
            if (items >= min_items_for_occlusion_query && !visits_all<V>() && sink_.hidden(v, subtree)) {
                ++stats_.cells_hidden;
                return true;
            }
        }
        return false;
    }

    /// What replaces a stand-in is drawn as well where it fades.
    template <class V>
    void draw_stand_in_and_fade(V& v, Subtree& subtree, LawOf<V> law) {
        float left = v.view.fade > 0 ? part_replaced(v, subtree) : 0;
        if constexpr (PagedAtRunTime<typename V::hierarchy_type>) {
            expect_contents(v, subtree);
            if (left != 0 && !is_there(v, subtree)) left = 0;
        }
        if (left == 0) return draw_stand_in(v, subtree);
        const Node& node = v.hierarchy.nodes()[subtree.node];
        const float all = std::exchange(items_.weight, items_.weight * (1 - left));
        draw_stand_in(v, subtree);
        items_.weight = all * left;
        visit_contents(v, subtree, node, subtree.end_item - node.first_item, law, /*has_images_below=*/false);
        items_.weight = all;
    }

    /// Goes to where a node's contents are; false if they are missing.
    template <class V>
    static bool is_there(const V& v, Subtree& subtree) {
        return !v.hierarchy.is_portal(v.hierarchy.nodes()[subtree.node]) ||
               v.hierarchy.follow(subtree, urgency(v, subtree));
    }
    /// How far a stand-in is beyond the tolerance: 1 and more where its contents are drawn.
    template <class V>
    static float urgency(const V& v, const Subtree& subtree) {
        return stand_in_error_px(v, subtree) / v.view.tolerance_px;
    }
    /// Contents of cells that the next frames will open are asked for before they are drawn (frame/view_ahead.hpp).
    template <class V>
    static void expect_contents(const V& v, const Subtree& subtree) {
        if (v.hierarchy.is_portal(v.hierarchy.nodes()[subtree.node])) {
            expect_contents_ahead(v, subtree, urgency(v, subtree));
        }
    }
    /// What comes into the picture.
    template <class V>
    static void expect_outside(const V& v, const Subtree& subtree) {
        if (v.hierarchy.view_ahead() != nullptr) {
            expect_contents_ahead(v, subtree, std::numeric_limits<float>::infinity());
        }
    }

    template <class V>
    void visit_contents(V& v, const Subtree& subtree, const Node& node, std::uint32_t items, LawOf<V> law,
                        bool has_images_below) {
        const auto& h = v.hierarchy;
        bool as_one_run = subtree.crossed_planes == 0 || items <= max_items_unculled;
        if constexpr (carries_law<V>) {
            if (deposits_ && subtree.has_stand_in()) {
                law = h.approximation_policy().area_law(h.stand_ins()[subtree.stand_in]);
            }
            if (law) as_one_run = items <= max_items_per_deposited_run;
        }
        if (node.child_mask == 0 ||
            (may_draw_whole<V> && as_one_run && !has_images_below && !may_stand_in_below(v, subtree, node))) {
            draw_whole(v, subtree, node, law);
        } else {
            visit_children(v, subtree, node, law);
        }
    }

    /// Images are kept of cells that hold much, or instances. What an instance holds is under a path of its own.
    template <class V>
    static bool may_have_image(const V& v, std::uint32_t items) {
        const ImageCacheOptions& options = v.hierarchy.approximation_policy().images();
        if (options.of_instances_only && v.path == 0) return false;
        return PrimitiveWithInstance<typename V::primitive_type> || items >= options.least_items;
    }

    /// Items that are shared are deposited with the first of their cells, by its law: none may be passed over.
    template <class V>
    bool visits_all() const {
        if constexpr (carries_law<V> && V::hierarchy_type::assignment == Assignment::shared) return deposits_;
        return false;
    }
    template <class V>
    bool is_beyond_borders(const V& v, Subtree& subtree) const {
        return !visits_all<V>() && is_outside_tile(v.view, subtree);
    }

    /// False only if no cell below can be drawn by its stand-in.
    template <class V>
    static bool may_stand_in_below(const V& v, const Subtree& subtree, const Node& node) {
        using H = typename V::hierarchy_type;
        using A = typename H::approximation_type;
        if constexpr (Cut::is_limited) return Cut::may_stop_below(v, node);
        // What lies in other pages is no part of the run.
        if constexpr (PagedAtRunTime<H>) {
            return node.stand_in_levels_below != Node::nothing_below && node.stand_in_levels_below != 0;
        }
        // Level 0 is the node itself, whose stand-in was asked first.
        if (node.stand_in_levels_below == Node::nothing_below || node.stand_in_levels_below == 0) return false;
        if constexpr (A::facts.bounds_error && H::partition_type::facts.children_are_octants) {
            return v.hierarchy.approximation_policy().least_error_px(subtree.cell, node.stand_in_levels_below,
                                                                     v.view) <= v.view.tolerance_px;
        } else {
            return true;
        }
    }

    template <class V>
    void visit_children(V& v, const Subtree& subtree, const Node& node, LawOf<V> law) {
        const auto& h = v.hierarchy;
        h.prefetch_data_of(node.first_child);
        const std::size_t own_instances = items_.waiting();
        const std::uint32_t own_end = end_of_own_run(h, subtree);
        const float sampled = own_end != node.first_item ? part_sampled(v, subtree) : 1;
        if (own_end != node.first_item && sampled != 0) {
            const float all = std::exchange(items_.weight, items_.weight * sampled);
            items_.add(v, subtree, node.first_item, own_end, law);
            items_.weight = all;
        }
        std::size_t next_instance = own_instances;
        for_each_child<traversal_order<typename V::hierarchy_type, R>>(
            h, subtree, v.view.viewpoint(), [&](Subtree& child) {
                next_instance = draw_instances(v, next_instance, Items::order_key(v, child.cell.bounds_center));
                tell_what_is_left_out(v, subtree, child, sampled);
                visit(v, child, law);
            });
        draw_instances(v, next_instance, std::numeric_limits<float>::infinity());
        items_.take_back(own_instances);
    }

    /// How much of a subtree's own run is drawn before its children.
    template <class V>
    float part_sampled(const V& v, const Subtree& subtree) const {
        using A = typename V::hierarchy_type::approximation_type;
        if constexpr (LeavesOutSamples<A> && !Cut::is_limited && R::facts.draws_splats) {
            if (subtree.is_without_samples) return 0;
            if (v.view.wanted.is_any() &&
                v.hierarchy.approximation_policy().leaves_out_samples(v.view, sources_.largest_splat_px())) {
                return part_opened_below(v, subtree, levels_without_samples);
            }
        }
        return 1;
    }
    template <class V>
    static void tell_what_is_left_out(const V& v, const Subtree& subtree, Subtree& child, float sampled) {
        using A = typename V::hierarchy_type::approximation_type;
        if constexpr (LeavesOutSamples<A> && !Cut::is_limited && R::facts.draws_splats) {
            child.left_out = subtree.left_out;
            child.is_without_samples = sampled == 0;
            if (sampled == 1 || !child.has_stand_in()) return;
            const A& policy = v.hierarchy.approximation_policy();
            const auto left = [&](const Subtree& s) { return policy.left(v.hierarchy.stand_ins()[s.stand_in]); };
            child.left_out += (1 - sampled) * (left(subtree) - left(child));
        }
    }

    template <class V>
    void count_stand_in(const V&, const Subtree& subtree) {
        ++stats_.approximations;
        ++stats_.approximations_by_level[std::min<int>(subtree.cell.depth, FrameStats::max_levels - 1)];
        stats_.touched_bytes += sizeof(typename V::hierarchy_type::stand_in_data);
    }
    /// What is missing may be as near as the eye.
    template <class V>
    void draw_for_missing(V& v, const Subtree& subtree) {
        if constexpr (requires { sink_.stand_in_for_missing(v, subtree, items_.weight); }) {
            count_stand_in(v, subtree);
            sink_.stand_in_for_missing(v, subtree, items_.weight);
        } else {
            draw_stand_in(v, subtree);
        }
    }
    template <class V>
    void draw_stand_in(V& v, const Subtree& subtree) {
        count_stand_in(v, subtree);
        if constexpr (requires { sink_.stand_in(v, subtree, items_.weight); }) {
            sink_.stand_in(v, subtree, items_.weight);
        } else {
            sink_.stand_in(v, subtree);
        }
    }

    /// Draws a subtree as one run, less what lies beyond a tile's borders. A run with a law is short, and its order
    /// counts.
    template <class V>
    void draw_whole(V& v, const Subtree& subtree, const Node& node, LawOf<V> law) {
        const bool is_uncut = v.view.borders_used == 0 || subtree.crossed_borders == 0 || node.child_mask == 0 ||
                              subtree.end_item - node.first_item <= max_items_unculled ||
                              std::optional<AreaLaw>(law).has_value();
        if (is_uncut) return draw_items(v, subtree, node.first_item, law);
        const auto& h = v.hierarchy;
        const std::uint32_t own_end = end_of_own_run(h, subtree);
        if (own_end != node.first_item) items_.add(v, subtree, node.first_item, own_end, law);
        for_each_child<VisitOrder::any>(h, subtree, v.view.viewpoint(), [&](Subtree& child) {
            ++stats_.cells_visited;
            if (is_beyond_borders(v, child)) {
                ++stats_.cells_outside;
            } else {
                draw_whole(v, child, h.nodes()[child.node], law);
            }
        });
    }

    /// Positions from `first` to the subtree's end, and what the instances among them hold.
    template <class V>
    void draw_items(V& v, const Subtree& subtree, std::uint32_t first, LawOf<V> law) {
        const std::size_t base = items_.waiting();
        items_.add(v, subtree, first, subtree.end_item, law);
        draw_instances(v, base, std::numeric_limits<float>::infinity());
        items_.take_back(base);
    }

    /// Draws instances that wait, from `next` on, and come before a key; returns the first that does not.
    template <class V>
    std::size_t draw_instances(V& v, std::size_t next, float end_key) {
        using P = typename V::primitive_type;
        return items_.template draw_before<V>(next, end_key, [&](std::uint32_t position) {
            if constexpr (PrimitiveWithInstance<P>) {
                const P& p = v.source[position];
                primitive_traits<P>::visit_instance(p, [&](const auto& instance) {
                    draw_instance(v, instance, position, std::uint64_t(v.source.index_of(position)));
                });
            }
        });
    }

    template <class V, class Instance_>
    void draw_instance(V& v, const Instance_& instance, std::uint32_t position, std::uint64_t primitive) {
        ++stats_.instances;
        const std::uint64_t path = path_inside(v, primitive);
        const LocalView inner = view_inside(v, instance, path);
        sink_.enter_instance(v, position);
        enter(*instance.hierarchy, instance.primitives, inner, path);
        sink_.leave_instance(v);
    }

    using Items = ItemRuns<R, Sink>;

    SourceTable<R>& sources_;
    FrameStats& stats_;
    Sink& sink_;
    bool deposits_;
    Items items_;
    Cut cut_;
};

}  // namespace farfield::detail
