// Frames within a budget: of all that could be drawn better, what gains most for its price comes first, until the
// budget is spent. Prices are known before anything is drawn: there is neither a clock here nor anything that looks
// back at how long the last frame took, so the same view gives the same picture.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <vector>

#include "farfield/approximation.hpp"
#include "farfield/fail.hpp"
#include "farfield/frame/descent.hpp"
#include "farfield/frame/frame_prices.hpp"
#include "farfield/frame/opened_cells.hpp"
#include "farfield/frame/source_table.hpp"
#include "farfield/frame/stand_in_choice.hpp"
#include "farfield/frame/subtree.hpp"
#include "farfield/frame/work_of_cut.hpp"
#include "farfield/geometry/mixed.hpp"
#include "farfield/hierarchy/node.hpp"
#include "farfield/primitive.hpp"
#include "farfield/view.hpp"
#include "farfield/view/local_view.hpp"

namespace farfield {

/// What a frame may cost, in the unit of its prices: nanoseconds, or primitives (FramePrices::of_primitives).
struct FrameBudget {
    FramePrices prices{};
    double most = 0;
    /// A view that has not changed since the last frame is refined further, by another `most`, until all of it is
    /// within the view's tolerance; then nothing changes any more. Frames of it take longer from one to the next, as
    /// all is drawn that has been paid for.
    bool refines_still_views = false;
};

namespace detail {
/// Whether two views of a hierarchy make the same picture.
inline bool is_same_view(const LocalView& a, const LocalView& b) {
    return a.eye == b.eye && a.right == b.right && a.up == b.up && a.forward == b.forward &&
           a.is_perspective == b.is_perspective && a.is_mirrored == b.is_mirrored && a.focal_px == b.focal_px &&
           a.squeeze == b.squeeze && a.whole_off_center == b.whole_off_center && a.near_depth == b.near_depth &&
           a.far_depth == b.far_depth && a.tolerance_px == b.tolerance_px && a.tolerance_jitter == b.tolerance_jitter &&
           a.fade == b.fade && a.splat_limit_px == b.splat_limit_px && a.wanted == b.wanted &&
           a.distance == b.distance && a.width == b.width && a.height == b.height && a.part.left == b.part.left &&
           a.part.top == b.part.top && a.part.whole_width == b.part.whole_width &&
           a.part.whole_height == b.part.whole_height;
}
}  // namespace detail

/// Opens cells of one view, best first. A viewer's own: it keeps its memory from frame to frame, and what it has opened
/// where a still view is refined further.
///
/// In which order cells are opened does not depend on the budget, but for its prices: a larger one opens all that a
/// smaller one does. Large stand-ins near the viewer cost more than what they are opened into, so that the way to a
/// cheap picture may lead over dear ones: some steps are tried beyond the budget, and taken if one leads back into it.
class Refinement {
  public:
    /// What the cut takes: at most `most` for each frame that went into it. Where that pays for no picture, the
    /// cheapest one is drawn.
    double spent() const { return prices_.cost(work_); }
    /// The same in counts.
    const FrameWork& work() const { return work_; }
    /// All of the view is within its tolerance.
    bool is_complete() const { return !contexts_.empty() && steps_.empty() && beyond_.empty(); }

    /// For Viewer: opens cells of a view until the budget is spent. Stand-ins are drawn by splats where the limit is
    /// above 0. Throws std::invalid_argument for a budget or a
    /// price that is no number, or negative.
    template <class H, class Span>
    void refine(const H& hierarchy, const Span& primitives, const LocalView& view, const FrameBudget& budget,
                float splat_limit_px) {
        using P = detail::PrimitiveIn<Span>;
        splat_limit_px_ = splat_limit_px;
        if (const char* why = budget.prices.wrong_option()) {
            detail::fail<std::invalid_argument>(std::string("farfield::") + why);
        }
        if (!(budget.most >= 0)) {
            detail::fail<std::invalid_argument>("farfield::FrameBudget: most must be 0 or more");
        }
        const bool goes_on = budget.refines_still_views && !contexts_.empty() && contexts_[0].hierarchy == &hierarchy &&
                             contexts_[0].primitives == primitives.data() && prices_.each.of == budget.prices.each.of &&
                             contexts_[0].open == &Refinement::open_in<H, P> &&
                             detail::is_same_view(contexts_[0].view, view);
        prices_ = budget.prices;
        most_ = goes_on ? most_ + budget.most : budget.most;
        if (!goes_on) begin(hierarchy, primitives, view);
        open_best();
    }
    /// For Viewer: which cells a descent opens.
    detail::WithinBudget cut() const { return {&opened_}; }

  private:
    /// A hierarchy that was entered.
    struct Context {
        const void* hierarchy;
        const void* primitives;
        std::size_t count;
        LocalView view;
        std::uint64_t path;
        void (*open)(Refinement&, std::uint32_t context, const Subtree&);  ///< adds to shown_ and more_
    };
    /// A cell that is drawn by its stand-in, or not at all, and could be opened.
    struct Shown {
        Subtree subtree;
        std::uint32_t context;
        float stand_ins, px;  ///< of the stand-in: what opening saves
        detail::Gain gain;
    };
    /// A cell that was opened although the budget does not pay for it.
    struct Tried {
        std::uint64_t place;
        FrameWork work;  ///< of the cut with it
    };
    static constexpr std::size_t most_tried = 512;
    struct Step {
        detail::Gain gain;
        std::uint32_t shown;  ///< index into shown_
        friend bool operator<(const Step& a, const Step& b) { return a.gain < b.gain; }
    };

    template <class H, class Span>
    std::uint32_t enter(const H& h, const Span& primitives, const LocalView& view, std::uint64_t path) {
        using P = detail::PrimitiveIn<Span>;
        contexts_.push_back({&h, primitives.data(), primitives.size(), view, path, &Refinement::open_in<H, P>});
        return std::uint32_t(contexts_.size() - 1);
    }

    template <class H, class Span>
    void begin(const H& hierarchy, const Span& primitives, const LocalView& view) {
        using P = detail::PrimitiveIn<Span>;
        contexts_.clear();
        shown_.clear();
        steps_.clear();
        beyond_.clear();
        opened_.clear();
        more_ = {};
        more_[FrameWork::frames] = 1;
        more_[FrameWork::pixels] = double(view.width) * double(view.height);
        enter(hierarchy, primitives, view, 0);
        if (hierarchy.item_count() != 0) {
            const detail::Entered<H, P> entered{hierarchy, detail::source_of(hierarchy, primitives, 0), view, 0};
            Subtree whole = whole_of(hierarchy);
            show(entered, 0, whole);
        }
        work_ = more_;
        add_steps(0, detail::Gain::infinite());
    }

    void add_steps(std::size_t first_shown, const detail::Gain& limit) {
        for (std::size_t i = first_shown; i < shown_.size(); ++i) {
            steps_.push_back({std::min(shown_[i].gain, limit), std::uint32_t(i)});
            std::push_heap(steps_.begin(), steps_.end());
        }
    }

    void open_best() {
        for (std::size_t i = beyond_.size(); i-- > 0;) {
            if (is_paid(beyond_[i].work)) {
                take(i + 1);
                break;
            }
        }
        while (!steps_.empty() && beyond_.size() < most_tried) {
            const Step step = steps_.front();
            std::pop_heap(steps_.begin(), steps_.end());
            steps_.pop_back();
            const std::size_t shown = shown_.size();
            const Shown opened = shown_[step.shown];  // more of them may move it
            const Context& in = contexts_[opened.context];
            const std::uint64_t place = detail::mixed(in.path, opened.subtree.node);
            more_ = beyond_.empty() ? work_ : beyond_.back().work;
            more_[FrameWork::openings] += 1;
            more_[FrameWork::stand_ins] -= double(opened.stand_ins);
            more_[FrameWork::stand_in_pixels] -= double(opened.px);
            in.open(*this, opened.context, opened.subtree);
            add_steps(shown, step.gain);
            beyond_.push_back({place, more_});
            if (is_paid(more_)) take(beyond_.size());
        }
        if (is_paid(work_)) return;
        const auto cheapest = std::min_element(beyond_.begin(), beyond_.end(), [&](const Tried& a, const Tried& b) {
            return prices_.cost(a.work) < prices_.cost(b.work);
        });
        if (cheapest != beyond_.end() && prices_.cost(cheapest->work) < spent()) {
            take(std::size_t(cheapest - beyond_.begin()) + 1);
        }
    }
    bool is_paid(const FrameWork& work) const { return prices_.cost(work) <= most_; }
    void take(std::size_t count) {
        work_ = beyond_[count - 1].work;
        for (std::size_t i = 0; i < count; ++i) opened_.add(beyond_[i].place);
        beyond_.erase(beyond_.begin(), beyond_.begin() + std::ptrdiff_t(count));
    }

    template <class H, class P>
    static void open_in(Refinement& self, std::uint32_t context, const Subtree& subtree) {
        const Context c = self.contexts_[context];  // more of them may move it
        const H& h = *static_cast<const H*>(c.hierarchy);
        const auto primitives = detail::span_at<P>(c.primitives, c.count);
        const detail::Entered<H, P> entered{h, detail::source_of(h, primitives, 0), c.view, c.path};
        self.open(entered, context, subtree);
    }

    /// A cell's contents: its own run, and its children as they are shown at first.
    template <class V>
    void open(const V& v, std::uint32_t context, const Subtree& subtree) {
        const auto& h = v.hierarchy;
        const Node& node = h.nodes()[subtree.node];
        const std::uint32_t items = subtree.end_item - node.first_item;
        const bool as_one_run = subtree.crossed_planes == 0 || items <= max_items_unculled;
        if (node.child_mask == 0 || (as_one_run && !detail::WithinBudget::may_stop_below(v, node))) {
            add_items(v, subtree, node.first_item, subtree.end_item, 1);
            return;
        }
        const std::uint32_t own_end = end_of_own_run(h, subtree);
        if (own_end != node.first_item) {
            add_items(v, subtree, node.first_item, own_end, float(own_end - node.first_item) / float(items));
        }
        for_each_child<VisitOrder::any>(h, subtree, v.view.viewpoint(),
                                        [&](Subtree& child) { show(v, context, child); });
    }

    /// The coarsest picture of a cell: its stand-in; without one all that it holds; and nothing at all where there are
    /// no stand-ins.
    template <class V>
    void show(const V& v, std::uint32_t context, Subtree& subtree) {
        using A = typename V::hierarchy_type::approximation_type;
        more_[FrameWork::cells] += 1;
        if (is_outside(v.view.planes, subtree) || is_outside_tile(v.view, subtree)) return;
        const float px = detail::covered_px(v.view, subtree);
        if constexpr (A::facts.stands_in) {
            if (!subtree.has_stand_in()) return open(v, context, subtree);
            const auto& data = v.hierarchy.stand_ins()[subtree.stand_in];
            const auto& approximation = v.hierarchy.approximation_policy();
            // What is large is what costs, and has to be known better.
            float drawn_px = px;
            if (px > 64) {
                drawn_px = 0;
                const detail::CoverageSink sink{v.view, drawn_px, splat_limit_px_};
                detail::draw_stand_in(approximation, data, v.hierarchy.pool(), subtree.cell, v.view, sink);
            }
            // From inside, cubes and splats show nothing, which would be the cheapest picture of all. A cell that is
            // not drawn after all, since none above it is opened, does no harm here.
            if (px > 64 && drawn_px == 0 && v.view.is_perspective && v.view.distance_to(subtree.cell) == 0) {
                opened_.add(detail::mixed(v.path, subtree.node));
                return open(v, context, subtree);
            }
            const FrameWork work = detail::work_of_drawing(approximation, data, drawn_px);
            more_ += work;
            if (!detail::may_stand_in(v, subtree)) {
                shown_.push_back({subtree, context, float(work[FrameWork::stand_ins]), drawn_px,
                                  detail::gain_of_opening(v, subtree, prices_, px)});
            }
        } else {
            shown_.push_back({subtree, context, 0, 0, detail::gain_of_opening(v, subtree, prices_, px)});
        }
    }

    /// `part` of the cell's pixels are theirs.
    template <class V>
    void add_items(const V& v, const Subtree& subtree, std::uint32_t first, std::uint32_t end, float part) {
        using P = typename V::primitive_type;
        more_ += detail::work_of_run(v, first, end, part * detail::covered_px(v.view, subtree));
        if constexpr (PrimitiveWithInstance<P>) {
            for (std::uint32_t at = first; at < end; ++at) {
                const P& p = v.source[at];
                primitive_traits<P>::visit_instance(
                    p, [&](const auto& instance) { show_instance(v, instance, std::uint64_t(v.source.index_of(at))); });
            }
        }
    }

    template <class V, class Placed>
    void show_instance(const V& v, const Placed& instance, std::uint64_t primitive) {
        using H = std::remove_cvref_t<decltype(*instance.hierarchy)>;
        using P = std::remove_cvref_t<decltype(instance.primitives[0])>;
        const H& h = *instance.hierarchy;
        more_[FrameWork::instances] += 1;
        if (h.item_count() == 0) return;
        const std::uint64_t path = detail::path_inside(v, primitive);
        const LocalView view = detail::view_inside(v, instance, path);
        const PrimitiveSpan<P> primitives(instance.primitives);
        const std::uint32_t context = enter(h, primitives, view, path);
        const detail::Entered<H, P> entered{h, detail::source_of(h, primitives, 0), view, path};
        Subtree whole = whole_of(h);
        show(entered, context, whole);
    }

    FramePrices prices_{};
    double most_ = 0;
    float splat_limit_px_ = 0;
    FrameWork work_{}, more_{};  ///< more_: of the step that is made
    detail::OpenedCells opened_{};
    std::vector<Tried> beyond_{};      ///< of steps after those that were taken
    std::vector<Context> contexts_{};  ///< the outermost first
    std::vector<Shown> shown_{};
    std::vector<Step> steps_{};  ///< a heap
};

}  // namespace farfield
