// A selection keeps what a frame would draw, the cut through a hierarchy: to be looked at, counted, drawn later or
// drawn by another renderer.
#pragma once

#include "farfield/settings.hpp"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <type_traits>
#include <vector>

#include "farfield/cost_model.hpp"
#include "farfield/drawables.hpp"
#include "farfield/frame/descent.hpp"
#include "farfield/frame/source_table.hpp"
#include "farfield/frame/subtree.hpp"
#include "farfield/geometry/area_law.hpp"
#include "farfield/geometry/visit_order.hpp"
#include "farfield/hierarchy/fingerprint.hpp"
#include "farfield/primitive.hpp"
#include "farfield/view.hpp"
#include "farfield/view/local_view.hpp"

namespace farfield {

/// One thing that is to be drawn.
struct Selected {
    enum class Kind : std::uint8_t {
        run,       ///< the primitives at positions [first, end), instances not among them
        stand_in,  ///< the stand-in of `subtree`
        instance   ///< the instance at position `first`: what it holds comes next, up to the entry with index `end`
    };
    Kind kind = Kind::run;
    std::optional<AreaLaw> law{};  ///< of a run whose small primitives may be deposited
    std::uint32_t view = 0;  ///< in whose coordinates, an index into views(); of an instance those of what it holds
    std::uint32_t first = 0, end = 0;
    Subtree subtree{};  ///< of its hierarchy; an instance's is not set
    float weight = 1;   ///< of a stand-in: less where it fades (View::fade)
};

namespace detail {

/// Visits the entries of a selection and nothing else.
template <class F>
struct EntriesOnly {
    F& f;
    void enter(const auto&) {}
    void leave(const auto&) {}
    void leave_instance(const auto&) {}
    void operator()(const auto& entered, const Selected& s) { f(entered, s); }
    std::uint32_t source_id(const auto&, const auto&) const { return 0; }
};

/// A descent's sink that keeps what it is told.
class SelectionSink {
  public:
    SelectionSink(std::vector<Selected>& entries, std::vector<LocalView>& views, std::vector<std::uint32_t>& open)
        : entries_(entries), views_(views), open_(open) {}

    template <class V>
    void enter(const V& v) {
        // The outermost view is there already; an instance's entry waits for its own.
        if (open_.empty()) return;
        entries_[open_.back()].view = std::uint32_t(views_.size());
        views_.push_back(v.view);
    }
    template <class V>
    void leave(const V&) {}
    template <class V>
    void enter_instance(const V&, std::uint32_t position) {
        const std::uint32_t outer_view = current_view();
        open_.push_back(std::uint32_t(entries_.size()));
        entries_.push_back({.kind = Selected::Kind::instance, .view = outer_view, .first = position});
    }
    template <class V>
    void leave_instance(const V&) {
        entries_[open_.back()].end = std::uint32_t(entries_.size());
        open_.pop_back();
    }
    template <class V>
    void run(const V&, const Subtree& subtree, std::uint32_t first, std::uint32_t end, std::optional<AreaLaw> law) {
        entries_.push_back({Selected::Kind::run, law, current_view(), first, end, subtree});
    }
    template <class V>
    void stand_in(const V&, const Subtree& subtree, float weight) {
        entries_.push_back(
            {.kind = Selected::Kind::stand_in, .view = current_view(), .subtree = subtree, .weight = weight});
    }
    template <class V>
    bool hidden(const V&, const Subtree&) const {
        return false;
    }

  private:
    std::uint32_t current_view() const { return open_.empty() ? 0 : entries_[open_.back()].view; }

    std::vector<Selected>& entries_;
    std::vector<LocalView>& views_;
    std::vector<std::uint32_t>& open_;  ///< entries of the instances that were entered and not left
};

}  // namespace detail

/// Entries come in the order in which they are to be drawn, those in an instance right after it. Nothing is left out
/// for being hidden, since nothing has been drawn. Borrows the hierarchy and the primitives, as
/// Viewer does, and is good as long as they are.
template <class H, class P>
class Selection {
  public:
    using hierarchy_type = H;
    using primitive_type = P;

    std::span<const Selected> entries() const { return entries_; }
    /// The outermost hierarchy's, then one an instance that was entered.
    std::span<const LocalView> views() const { return views_; }
    const View& view() const { return view_; }
    /// Counts what selecting did; drawing is counted when it is drawn.
    const FrameStats& stats() const { return stats_; }
    VisitOrder order() const { return order_; }
    const H* hierarchy() const { return hierarchy_; }
    PrimitiveSpan<P> primitives() const { return primitives_; }

    /// The work of drawing it, cells that were visited included. Looks at every primitive of every run.
    Work work() const {
        Work sum{.cells = float(stats_.cells_visited)};
        for_each([&](const auto& entered, const Selected& s) {
            const auto& h = entered.hierarchy;
            if (s.kind == Selected::Kind::stand_in) {
                using A = typename std::remove_cvref_t<decltype(h)>::approximation_type;
                if constexpr (A::facts.stands_in) {
                    sum += detail::work_of_stand_in(h.approximation_policy(), h.stand_ins()[s.subtree.stand_in]);
                }
            } else if (s.kind == Selected::Kind::run) {
                sum += {.runs = 1};
                for (std::uint32_t at = s.first; at < s.end; ++at) sum += work_of_position(entered.source, at);
            }
        });
        return sum;
    }
    /// The price of that work, in the unit of the hierarchy's cost model.
    float cost() const { return hierarchy_ != nullptr ? hierarchy_->cost_policy().cost(work()) : 0.0f; }

    /// Calls f(entered, selected) for each entry, with the hierarchy, source, view and path that it belongs to
    /// (detail::Entered).
    template <class F>
    void for_each(F&& f) const {
        walk(detail::EntriesOnly<std::remove_reference_t<F>>{f});
    }

    /// Does what for_each() does, and calls visitor.enter(entered) and visitor.leave(entered) around the entries of
    /// each hierarchy, visitor.leave_instance(entered) after an instance; visitor.source_id(hierarchy, primitives)
    /// names a source.
    template <class Visitor>
    void walk(Visitor visitor) const {
        if (hierarchy_ != nullptr && hierarchy_->item_count() != 0) {
            walk_inside(visitor, *hierarchy_, primitives_, 0, 0, 0, entries_.size());
        }
    }

    /// A Viewer calls this: forgets what was held, and keeps what descend(sink, stats) selects. Memory is used again.
    /// If descend throws, the selection is over no hierarchy.
    template <class Descend>
    void select(const H& hierarchy, PrimitiveSpan<P> primitives, const View& view, const LocalView& local,
                VisitOrder order, Descend&& descend) {
        hierarchy_ = nullptr;
        primitives_ = primitives;
        view_ = view;
        order_ = order;
        stats_ = {};
        entries_.clear();
        views_.clear();
        open_.clear();
        views_.push_back(local);
        detail::SelectionSink sink(entries_, views_, open_);
        descend(sink, stats_);
        hierarchy_ = &hierarchy;
    }

  private:
    template <class Visitor, class H2, class Span>
    void walk_inside(Visitor& visitor, const H2& h, const Span& primitives, std::uint32_t view, std::uint64_t path,
                     std::size_t begin, std::size_t end) const {
        using P2 = detail::PrimitiveIn<Span>;
        const detail::Entered<H2, P2> entered{h, detail::source_of(h, primitives, visitor.source_id(h, primitives)),
                                              views_[view], path};
        visitor.enter(entered);
        for (std::size_t i = begin; i < end; ++i) {
            const Selected& s = entries_[i];
            visitor(entered, s);
            if (s.kind != Selected::Kind::instance) continue;
            if constexpr (PrimitiveWithInstance<P2>) {
                const P2& p = entered.source[s.first];
                primitive_traits<P2>::visit_instance(p, [&](const auto& instance) {
                    if (instance.hierarchy->item_count() == 0) return;
                    walk_inside(visitor, *instance.hierarchy, instance.primitives, s.view,
                                detail::mixed(path, std::uint64_t(entered.source.index_of(s.first)) + 1), i + 1, s.end);
                });
            }
            visitor.leave_instance(entered);
            i = s.end - 1;
        }
        visitor.leave(entered);
    }

    template <class P2>
    static Work work_of_position(const Source<P2>& source, std::uint32_t position) {
        if (source.fragments.empty()) return work_of(source[position]);
        return {.triangles = float(source.fragments[position].vertices.size()) - 2};
    }

    const H* hierarchy_ = nullptr;
    PrimitiveSpan<P> primitives_;
    View view_;
    FrameStats stats_;
    VisitOrder order_ = VisitOrder::any;
    std::vector<LocalView> views_;
    std::vector<Selected> entries_;
    std::vector<std::uint32_t> open_;  ///< empty but while selecting
};

}  // namespace farfield
