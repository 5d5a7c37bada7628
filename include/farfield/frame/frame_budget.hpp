// Frames within a budget: of all that could be drawn better, what gains most for its price comes first, until the
// budget is spent. Prices are known before anything is drawn: there is neither a clock here nor anything that looks
// back at how long the last frame took, so the same view gives the same picture.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/common.hpp>
#include <limits>
#include <span>
#include <type_traits>
#include <vector>

#include "farfield/approximation.hpp"
#include "farfield/cost_model.hpp"
#include "farfield/frame/descent.hpp"
#include "farfield/frame/source_table.hpp"
#include "farfield/frame/subtree.hpp"
#include "farfield/geometry/mixed.hpp"
#include "farfield/hierarchy/fingerprint.hpp"
#include "farfield/hierarchy/node.hpp"
#include "farfield/primitive.hpp"
#include "farfield/view.hpp"
#include "farfield/view/local_view.hpp"

namespace farfield {

/// What a frame may cost, in the cost model's unit: with TriangleCount triangles, which is kept to exactly; with
/// MeasuredTime nanoseconds, by prices that calibrate() has measured on this machine. Those know neither what large
/// stand-ins take for each pixel that they cover nor what choosing the cut takes: small budgets of coarse cuts are
/// exceeded several times over.
template <CostModel C>
struct FrameBudget {
    C prices{};
    double most = 0;
    /// Of that, what every frame costs whatever it draws: clearing a picture and finishing it.
    double fixed = 0;
    /// A view that has not changed since the last frame is refined further, by another `most`, until all of it is
    /// within the view's tolerance; then nothing changes any more.
    bool refines_still_views = false;
};

namespace detail {

/// How much is gained by opening a cell for what it costs. Ties are broken by a hash of its place, the same in every
/// frame.
struct Gain {
    float value = 0;
    std::uint64_t place = 0;

    static constexpr Gain infinite() {
        return {std::numeric_limits<float>::infinity(), std::numeric_limits<std::uint64_t>::max()};
    }
    static constexpr Gain none() { return {-1, 0}; }
    friend bool operator<(const Gain& a, const Gain& b) {
        return a.value != b.value ? a.value < b.value : a.place < b.place;
    }
};

/// Pixels that a cell covers, at most all.
inline float area_px(const LocalView& view, const Cell& cell) {
    const float whole = float(view.part.whole_width) * float(view.part.whole_height);
    const float side = view.pixels(cell.largest_side(), view.distance_to(cell));
    return std::min(side * side, whole);
}

/// The same view from inside an instance, as a descent makes it.
template <class E, class I>
LocalView view_inside(const E& outer, const I& instance, std::uint64_t primitive) {
    LocalView inner = outer.view.inside(instance.to_world, outer.hierarchy.origin(), instance.hierarchy->origin());
    inner.seed = std::uint32_t(mixed(outer.path, primitive + 1) >> 32);
    return inner;
}

/// Projected area times error, by the price of opening: "coverage x error removed / cost". Where nothing stands in,
/// everything is missing, and the error is the cell's own size.
template <class E>
Gain gain_of_opening(const E& entered, const Subtree& subtree) {
    using A = typename E::hierarchy_type::approximation_type;
    const auto& h = entered.hierarchy;
    const LocalView& view = entered.view;
    const Node& node = h.nodes()[subtree.node];
    const float whole = std::max(float(view.part.whole_width), float(view.part.whole_height));
    const float side = std::min(view.pixels(subtree.cell.largest_side(), view.distance_to(subtree.cell)), whole);
    float error = side;
    if constexpr (A::facts.stands_in) {
        if (subtree.has_stand_in()) {
            error = h.approximation_policy().error_px(h.stand_ins()[subtree.stand_in], subtree.cell, view) *
                    error_of_replaced_levels(node);
        }
    }
    const unsigned children = bits_set[node.child_mask];
    const std::uint32_t own_end = children == 0 ? subtree.end_item : h.nodes()[node.first_child].first_item;
    const float price = 1 + float(8 * children) + float(own_end - node.first_item);
    return {area_px(view, subtree.cell) * std::min(error, whole) / price, mixed(entered.path, subtree.node)};
}

/// The cut that is left when the budget is spent: cells are opened whose gain is above where refining ended. What was
/// opened on the way down has no smaller gain than what is below it, or would not have been opened (see Refinement).
struct WithinBudget {
    static constexpr bool is_limited = true;
    Gain stop = Gain::infinite();

    template <class V>
    bool opens(const V& v, const Subtree& subtree) const {
        using A = typename V::hierarchy_type::approximation_type;
        // What has no stand-in belongs to what was opened above it, if anything was.
        if (A::facts.stands_in && !subtree.has_stand_in()) return stop < Gain::infinite();
        return stop < gain_of_opening(v, subtree);
    }
    template <class V>
    static bool may_stop_below(const V&, const Node& node) {
        if (!V::hierarchy_type::approximation_type::facts.stands_in) return true;
        return node.stand_in_levels_below != Node::nothing_below && node.stand_in_levels_below != 0;
    }
};

/// Whether two views of a hierarchy make the same picture.
inline bool is_same_view(const LocalView& a, const LocalView& b) {
    return a.eye == b.eye && a.right == b.right && a.up == b.up && a.forward == b.forward &&
           a.is_perspective == b.is_perspective && a.is_mirrored == b.is_mirrored && a.focal_px == b.focal_px &&
           a.squeeze == b.squeeze && a.whole_off_center == b.whole_off_center && a.near_depth == b.near_depth &&
           a.far_depth == b.far_depth && a.tolerance_px == b.tolerance_px && a.distance == b.distance &&
           a.width == b.width && a.height == b.height && a.part.left == b.part.left && a.part.top == b.part.top &&
           a.part.whole_width == b.part.whole_width && a.part.whole_height == b.part.whole_height;
}

}  // namespace detail

/// Opens cells of one view, best first. A viewer's own: it keeps its memory from frame to frame, and what it has opened
/// where a still view is refined further.
///
/// A cell below one that was opened counts with no more gain than that one. So gains fall from step to step, and where
/// refining ends is one number, by which a descent finds the same cut again, in the order that is drawn.
class Refinement {
  public:
    /// What the cut costs by the budget's prices, the fixed part included: at most `most` for each frame that went into
    /// it.
    double spent() const { return cost_ + fixed_; }
    /// All of the view is within its tolerance.
    bool is_complete() const { return is_begun_ && steps_.empty(); }
    /// False where the budget does not pay for the coarsest picture. Nothing is drawn then.
    bool is_begun() const { return is_begun_; }
    /// The gain that opening a cell must exceed, for Viewer.
    const detail::Gain& stop() const { return stop_; }

    /// For Viewer: opens cells of a view until the budget is spent.
    template <class H, class P, CostModel C>
    void refine(const H& hierarchy, std::span<const P> primitives, const LocalView& view,
                const FrameBudget<C>& budget) {
        model_ = &budget.prices;
        set_prices(budget.prices);
        const bool goes_on = budget.refines_still_views && !contexts_.empty() && contexts_[0].hierarchy == &hierarchy &&
                             contexts_[0].primitives == primitives.data() &&
                             contexts_[0].open == &Refinement::open_in<H, P, C> &&
                             detail::is_same_view(contexts_[0].view, view);
        const double most = std::max(0.0, budget.most - budget.fixed);
        fixed_ = budget.fixed;
        most_ = goes_on ? most_ + most : most;
        if (!goes_on || !is_begun_) begin<C>(hierarchy, primitives, view);
        if (is_begun_) open_best();
    }

  private:
    /// A hierarchy that was entered.
    struct Context {
        const void* hierarchy;
        const void* primitives;
        std::size_t count;
        LocalView view;
        std::uint64_t path;
        double (*open)(Refinement&, std::uint32_t context, const Subtree&);  ///< adds to shown_, gives the price
    };
    /// A cell that is drawn by its stand-in, or not at all, and could be opened.
    struct Shown {
        Subtree subtree;
        std::uint32_t context;
        double price;  ///< of the stand-in
        detail::Gain gain;
    };
    struct Step {
        detail::Gain gain;
        std::uint32_t shown;  ///< index into shown_
        friend bool operator<(const Step& a, const Step& b) { return a.gain < b.gain; }
    };

    template <CostModel C>
    void set_prices(const C& prices) {
        triangle_ = double(prices.cost({.triangles = 1}));
        cell_ = double(prices.cost({.cells = 1}));
        run_ = double(prices.cost({.runs = 1}));
        pixel_ = 0;
        // A near triangle of the calibration covers a hundred pixels.
        if constexpr (requires { prices.near_triangle; }) {
            pixel_ = 0.01 * std::max(0.0, double(prices.near_triangle) - triangle_);
        }
    }

    template <CostModel C, class H, class P>
    std::uint32_t enter(const H& h, std::span<const P> primitives, const LocalView& view, std::uint64_t path) {
        contexts_.push_back({&h, primitives.data(), primitives.size(), view, path, &Refinement::open_in<H, P, C>});
        return std::uint32_t(contexts_.size() - 1);
    }

    template <CostModel C, class H, class P>
    void begin(const H& hierarchy, std::span<const P> primitives, const LocalView& view) {
        contexts_.clear();
        shown_.clear();
        steps_.clear();
        cost_ = 0;
        stop_ = detail::Gain::infinite();
        const std::uint32_t context = enter<C>(hierarchy, primitives, view, 0);
        if (hierarchy.item_count() != 0) {
            const detail::Entered<H, P> entered{hierarchy, detail::source_of(hierarchy, primitives, 0), view, 0};
            Subtree whole = whole_of(hierarchy);
            cost_ = show<C>(entered, context, whole);
        }
        is_begun_ = cost_ <= most_;
        if (is_begun_) {
            add_steps(0, detail::Gain::infinite());
        } else {
            cost_ = 0;
        }
    }

    void add_steps(std::size_t first_shown, const detail::Gain& limit) {
        for (std::size_t i = first_shown; i < shown_.size(); ++i) {
            steps_.push_back({std::min(shown_[i].gain, limit), std::uint32_t(i)});
            std::push_heap(steps_.begin(), steps_.end());
        }
    }

    void open_best() {
        while (!steps_.empty()) {
            const Step step = steps_.front();
            const std::size_t shown = shown_.size(), contexts = contexts_.size();
            const std::uint32_t context = shown_[step.shown].context;
            const double more =
                contexts_[context].open(*this, context, Subtree(shown_[step.shown].subtree)) - shown_[step.shown].price;
            if (cost_ + more > most_) {
                shown_.erase(shown_.begin() + std::ptrdiff_t(shown), shown_.end());
                contexts_.erase(contexts_.begin() + std::ptrdiff_t(contexts), contexts_.end());
                stop_ = step.gain;
                return;
            }
            cost_ += more;
            std::pop_heap(steps_.begin(), steps_.end());
            steps_.pop_back();
            add_steps(shown, step.gain);
        }
        stop_ = detail::Gain::none();
    }

    template <class H, class P, CostModel C>
    static double open_in(Refinement& self, std::uint32_t context, const Subtree& subtree) {
        const Context c = self.contexts_[context];  // more of them may move it
        const H& h = *static_cast<const H*>(c.hierarchy);
        const std::span<const P> primitives(static_cast<const P*>(c.primitives), c.count);
        const detail::Entered<H, P> entered{h, detail::source_of(h, primitives, 0), c.view, c.path};
        return self.open<C>(entered, context, subtree);
    }

    /// The price of a cell's contents: its own run, and its children as they are shown at first.
    template <CostModel C, class V>
    double open(const V& v, std::uint32_t context, const Subtree& subtree) {
        const auto& h = v.hierarchy;
        const Node& node = h.nodes()[subtree.node];
        const std::uint32_t items = subtree.end_item - node.first_item;
        const bool as_one_run = subtree.crossed_planes == 0 || items <= max_items_unculled;
        if (node.child_mask == 0 || (as_one_run && !detail::WithinBudget::may_stop_below(v, node))) {
            return price_of_items<C>(v, subtree, node.first_item, subtree.end_item);
        }
        const std::uint32_t own_end = h.nodes()[node.first_child].first_item;
        double price = own_end != node.first_item ? price_of_items<C>(v, subtree, node.first_item, own_end) : 0;
        for_each_child<VisitOrder::any>(h, subtree, v.view.viewpoint(),
                                        [&](Subtree& child) { price += show<C>(v, context, child); });
        return price;
    }

    /// The price of the coarsest picture of a cell: its stand-in; without one all that it holds; and nothing at all
    /// where there are no stand-ins.
    template <CostModel C, class V>
    double show(const V& v, std::uint32_t context, Subtree& subtree) {
        using A = typename V::hierarchy_type::approximation_type;
        if (is_outside(v.view.planes, subtree) || is_outside_tile(v.view, subtree)) return cell_;
        if constexpr (A::facts.stands_in) {
            if (!subtree.has_stand_in()) return cell_ + open<C>(v, context, subtree);
            const auto& data = v.hierarchy.stand_ins()[subtree.stand_in];
            const auto& approximation = v.hierarchy.approximation_policy();
            const double price =
                double(static_cast<const C*>(model_)->cost(detail::work_of_stand_in(approximation, data)));
            const float error = approximation.error_px(data, subtree.cell, v.view) *
                                detail::error_of_replaced_levels(v.hierarchy.nodes()[subtree.node]);
            const bool is_good = v.view.tolerance_px > 0 && error <= v.view.tolerance_px;
            if (!is_good) shown_.push_back({subtree, context, price, detail::gain_of_opening(v, subtree)});
            return cell_ + price;
        } else {
            shown_.push_back({subtree, context, 0, detail::gain_of_opening(v, subtree)});
            return cell_;
        }
    }

    template <CostModel C, class V>
    double price_of_items(const V& v, const Subtree& subtree, std::uint32_t first, std::uint32_t end) {
        using P = typename V::primitive_type;
        double triangles = 0, inside = 0;
        if constexpr (PrimitiveWithInstance<P>) {
            for (std::uint32_t at = first; at < end; ++at) {
                const P& p = v.source[at];
                const bool is_instance = primitive_traits<P>::visit_instance(p, [&](const auto& instance) {
                    inside += show_instance<C>(v, instance, std::uint64_t(&p - v.source.primitives.data()));
                });
                if (!is_instance) triangles += double(work_of(p).triangles);
            }
        } else if (!v.source.fragments.empty()) {
            const auto& vertex = v.source.fragments.first_vertex;
            triangles = double(vertex[end] - vertex[first]) - 2.0 * double(end - first);
        } else {
            triangles = double(v.hierarchy.facts().work.triangles) /
                        double(std::max<std::uint64_t>(v.hierarchy.primitive_count(), 1)) * double(end - first);
        }
        if (!(triangles > 0)) return inside;
        double runs = 1;
        if constexpr (V::hierarchy_type::assignment == Assignment::shared) {
            // Others may have drawn every second item: a run is broken where something is left out.
            if (run_ > triangle_) runs = std::ceil(0.5 * triangles);
            triangles -= runs - 1;
        }
        inside += run_ * runs + triangle_ * triangles + pixel_ * double(detail::area_px(v.view, subtree.cell));
        return inside;
    }

    template <CostModel C, class V, class I>
    double show_instance(const V& v, const I& instance, std::uint64_t primitive) {
        using H = std::remove_cvref_t<decltype(*instance.hierarchy)>;
        using P = std::remove_cvref_t<decltype(instance.primitives[0])>;
        const H& h = *instance.hierarchy;
        if (h.item_count() == 0) return 0;
        const LocalView view = detail::view_inside(v, instance, primitive);
        const std::span<const P> primitives(instance.primitives);
        const std::uint64_t path = detail::mixed(v.path, primitive + 1);
        const std::uint32_t context = enter<C>(h, primitives, view, path);
        const detail::Entered<H, P> entered{h, detail::source_of(h, primitives, 0), view, path};
        Subtree whole = whole_of(h);
        return show<C>(entered, context, whole);
    }

    const void* model_ = nullptr;  ///< of this call of refine()
    double triangle_ = 0, pixel_ = 0, cell_ = 0, run_ = 0, most_ = 0, cost_ = 0, fixed_ = 0;
    bool is_begun_ = false;
    detail::Gain stop_ = detail::Gain::infinite();
    std::vector<Context> contexts_{};  ///< the outermost first
    std::vector<Shown> shown_{};
    std::vector<Step> steps_{};  ///< a heap
};

}  // namespace farfield
