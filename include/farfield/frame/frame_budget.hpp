// Frames within a budget: of all that could be drawn better, what gains most for its price comes first, until the
// budget is spent. Prices are known before anything is drawn: there is neither a clock here nor anything that looks
// back at how long the last frame took, so the same view gives the same picture.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <limits>
#include <span>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <vector>

#include "farfield/approximation.hpp"
#include "farfield/drawables.hpp"
#include "farfield/fail.hpp"
#include "farfield/frame/cell_tolerance.hpp"
#include "farfield/frame/descent.hpp"
#include "farfield/frame/frame_prices.hpp"
#include "farfield/frame/source_table.hpp"
#include "farfield/frame/subtree.hpp"
#include "farfield/geometry/length.hpp"
#include "farfield/geometry/mixed.hpp"
#include "farfield/hierarchy/fingerprint.hpp"
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

/// How much is gained by opening a cell for what it costs. Ties are broken by a hash of its place, the same in every
/// frame.
struct Gain {
    float value = 0;
    std::uint64_t place = 0;

    static constexpr Gain infinite() {
        return {std::numeric_limits<float>::infinity(), std::numeric_limits<std::uint64_t>::max()};
    }
    friend bool operator<(const Gain& a, const Gain& b) {
        return a.value != b.value ? a.value < b.value : a.place < b.place;
    }
};

/// Pixels of the picture that a rectangle about the view's axis covers, from `lower` to `upper` in pixels from it.
inline float seen_px(const LocalView& view, glm::vec2 lower, glm::vec2 upper) {
    const glm::vec2 whole(view.part.whole_width, view.part.whole_height);
    const glm::vec2 middle = 0.5f * whole * glm::vec2(view.whole_off_center);
    const glm::vec2 size = glm::min(upper, middle + 0.5f * whole) - glm::max(lower, middle - 0.5f * whole);
    return size.x > 0 && size.y > 0 ? size.x * size.y : 0.0f;
}

/// What boxes cover, flat ones too, about: as much as their silhouettes have from afar; of boxes that cross a side of
/// the picture the part of their rectangle that lies in it.
inline float covered_px(const LocalView& view, glm::vec3 center, glm::vec3 half, bool is_inside) {
    const glm::vec3 d = center - view.eye;
    const glm::vec2 whole(view.part.whole_width, view.part.whole_height);
    const float distance = view.is_perspective ? std::max(length_of(d), length_of(half)) : 1.0f;
    // From inside there is no direction that it is seen from.
    const bool is_around = view.is_perspective && !(length_of(d) > length_of(half));
    const glm::vec3 towards = is_around ? glm::vec3(1) : glm::abs(view.is_perspective ? d / distance : view.forward);
    const glm::vec2 scale = view.squeeze * (view.focal_px / distance);
    const float silhouette = 4 * glm::dot(towards, glm::vec3(half.y * half.z, half.z * half.x, half.x * half.y));
    const float px = std::min(silhouette * scale.x * scale.y, whole.x * whole.y);
    if (is_inside || !(px > 0)) return px > 0 ? px : 0.0f;
    glm::vec2 lower(std::numeric_limits<float>::max()), upper(std::numeric_limits<float>::lowest());
    for (unsigned corner = 0; corner < 8; ++corner) {
        const glm::vec3 c = d + half * glm::vec3(corner & 1 ? 1 : -1, corner & 2 ? 1 : -1, corner & 4 ? 1 : -1);
        const float depth = view.is_perspective ? glm::dot(c, view.forward) : 1.0f;
        if (!(depth > 0)) return 0.5f * px;
        const glm::vec2 at =
            glm::vec2(glm::dot(c, view.right), glm::dot(c, view.up)) * view.squeeze * (view.focal_px / depth);
        lower = glm::min(lower, at);
        upper = glm::max(upper, at);
    }
    const float area = (upper.x - lower.x) * (upper.y - lower.y);
    return area > 0 ? std::min(px, area) * (seen_px(view, lower, upper) / area) : 0.0f;
}
inline float covered_px(const LocalView& view, const Subtree& subtree) {
    return covered_px(view, subtree.cell.bounds_center, subtree.cell.bounds_half, subtree.crossed_planes == 0);
}

/// Adds up what a stand-in covers that is drawn into it.
struct CoverageSink {
    const LocalView& view;
    float& px;
    float splat_limit_px = 0;

    void operator()(const Face& face) const {
        px += covered_px(view, 0.5f * (face.lower + face.upper), 0.5f * glm::abs(face.upper - face.lower), false);
    }
    void operator()(const Splat& splat) const {
        const glm::vec3 d = splat.center - view.eye;
        const float depth = view.is_perspective ? glm::dot(d, view.forward) : 1.0f;
        if (!(depth > 0)) return;
        const glm::vec2 scale = view.squeeze * (view.focal_px / depth);
        const glm::vec2 at = glm::vec2(glm::dot(d, view.right), glm::dot(d, view.up)) * scale;
        px += seen_px(view, at - 0.5f * splat.size * scale, at + 0.5f * splat.size * scale);
    }
    void operator()(OwnRun) const {}
};

/// The same view from inside an instance, as a descent makes it.
template <class E, class I>
LocalView view_inside(const E& outer, const I& instance, std::uint64_t path) {
    LocalView inner = outer.view.inside(instance.to_world, outer.hierarchy.origin(), instance.hierarchy->origin());
    inner.seed = std::uint32_t(path >> 32);
    return inner;
}

/// The work of drawing a run, but for the pixels and for what instances in it hold.
template <class E>
FrameWork work_of_run(const E& e, std::uint32_t first, std::uint32_t end, float px) {
    using P = typename E::primitive_type;
    double triangles = 0;
    FrameWork work;
    if constexpr (PrimitiveWithInstance<P>) {
        for (std::uint32_t at = first; at < end; ++at) {
            const P& p = e.source[at];
            if (!primitive_traits<P>::visit_instance(p, [](const auto&) {})) triangles += double(work_of(p).triangles);
        }
    } else if (!e.source.fragments.empty()) {
        const auto& vertex = e.source.fragments.first_vertex;
        triangles = double(vertex[end] - vertex[first]) - 2.0 * double(end - first);
    } else {
        triangles = double(e.hierarchy.facts().work.triangles) /
                    double(std::max<std::uint64_t>(e.hierarchy.primitive_count(), 1)) * double(end - first);
    }
    if (!(triangles > 0)) return work;
    work[FrameWork::runs] = 1;
    // Others may have drawn every second item: a run is broken where something is left out.
    if (E::hierarchy_type::assignment == Assignment::shared) work[FrameWork::runs] = std::ceil(0.5 * triangles);
    work[double(px) > 2 * triangles ? FrameWork::large_triangles : FrameWork::triangles] = triangles;
    work[FrameWork::triangle_pixels] = double(px);
    return work;
}

template <class A, class Data>
FrameWork work_of_drawing(const A& approximation, const Data& data, float px) {
    const Work w = work_of_stand_in(approximation, data);
    FrameWork work;
    const double drawn = double(w.faces) + double(w.splats);
    work[FrameWork::stand_ins] = std::isfinite(drawn) ? drawn : 1;  // of empty ones, which are kept for their samples
    work[FrameWork::stand_in_pixels] = double(px);
    return work;
}

/// Projected area times error, by the price of opening: "coverage x error removed / cost". Where nothing stands in,
/// everything is missing, and the error is the cell's own size.
template <class E>
Gain gain_of_opening(const E& entered, const Subtree& subtree, const FramePrices& prices, float px) {
    using H = typename E::hierarchy_type;
    using A = typename H::approximation_type;
    const H& h = entered.hierarchy;
    const Node& node = h.nodes()[subtree.node];
    const float whole = std::max(float(entered.view.part.whole_width), float(entered.view.part.whole_height));
    float error = whole;
    if (A::facts.stands_in && subtree.has_stand_in()) {
        if constexpr (A::facts.stands_in) {
            error = h.approximation_policy().error_px(h.stand_ins()[subtree.stand_in], subtree.cell, entered.view) *
                    error_of_replaced_levels(node);
        }
    } else {
        error = entered.view.pixels(subtree.cell.largest_side(), entered.view.distance_to(subtree.cell));
    }
    const auto& each = prices.each;
    const double children = bits_set[node.child_mask];
    const std::uint32_t own_end = children == 0 ? subtree.end_item : h.nodes()[node.first_child].first_item;
    const double an_item = PrimitiveWithInstance<typename E::primitive_type>
                               ? each[FrameWork::instances] + each[FrameWork::stand_ins]
                               : each[FrameWork::triangles];
    const double price = each[FrameWork::openings] + children * (each[FrameWork::cells] + each[FrameWork::stand_ins]) +
                         double(own_end - node.first_item) * an_item;
    return {px * std::min(error, whole) / float(std::max(price, 1e-6)), mixed(entered.path, subtree.node)};
}

/// Cells that were opened, by hashes of their places.
class OpenedCells {
  public:
    void clear() {
        for (const std::size_t at : used_) slots_[at] = 0;
        used_.clear();
    }
    void add(std::uint64_t place) {
        if (2 * (used_.size() + 1) > slots_.size()) grow();
        put(place | 1);
    }
    bool has(std::uint64_t place) const {
        if (slots_.empty()) return false;
        for (std::size_t at = place >> shift_;; at = (at + 1) & (slots_.size() - 1)) {
            if (slots_[at] == (place | 1)) return true;
            if (slots_[at] == 0) return false;
        }
    }

  private:
    void put(std::uint64_t key) {
        std::size_t at = key >> shift_;
        while (slots_[at] != 0) at = (at + 1) & (slots_.size() - 1);
        slots_[at] = key;
        used_.push_back(at);
    }
    void grow() {
        std::vector<std::uint64_t> keys;
        for (const std::size_t at : used_) keys.push_back(slots_[at]);
        const std::size_t size = std::max<std::size_t>(1024, 2 * slots_.size());
        slots_.assign(size, 0);
        shift_ = 64 - int(std::bit_width(size - 1));
        used_.clear();
        for (const std::uint64_t key : keys) put(key);
    }

    std::vector<std::uint64_t> slots_{};  ///< a power of two of them, at most half of them used; 0: free
    std::vector<std::size_t> used_{};
    int shift_ = 64;
};

/// The cut that a budget has paid for.
struct WithinBudget {
    static constexpr bool is_limited = true;
    const OpenedCells* opened = nullptr;

    template <class V>
    bool opens(const V& v, const Subtree& subtree) const {
        using A = typename V::hierarchy_type::approximation_type;
        // What has no stand-in belongs to what was opened above it.
        if (A::facts.stands_in && !subtree.has_stand_in()) return true;
        return opened->has(mixed(v.path, subtree.node));
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
           a.far_depth == b.far_depth && a.tolerance_px == b.tolerance_px && a.tolerance_jitter == b.tolerance_jitter &&
           a.fade == b.fade && a.wanted == b.wanted && a.distance == b.distance && a.width == b.width &&
           a.height == b.height && a.part.left == b.part.left && a.part.top == b.part.top &&
           a.part.whole_width == b.part.whole_width && a.part.whole_height == b.part.whole_height;
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
    template <class H, class P>
    void refine(const H& hierarchy, std::span<const P> primitives, const LocalView& view, const FrameBudget& budget,
                float splat_limit_px) {
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

    template <class H, class P>
    std::uint32_t enter(const H& h, std::span<const P> primitives, const LocalView& view, std::uint64_t path) {
        contexts_.push_back({&h, primitives.data(), primitives.size(), view, path, &Refinement::open_in<H, P>});
        return std::uint32_t(contexts_.size() - 1);
    }

    template <class H, class P>
    void begin(const H& hierarchy, std::span<const P> primitives, const LocalView& view) {
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
        const std::span<const P> primitives(static_cast<const P*>(c.primitives), c.count);
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
        const std::uint32_t own_end = h.nodes()[node.first_child].first_item;
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
            const float error = approximation.error_px(data, subtree.cell, v.view) *
                                detail::error_of_replaced_levels(v.hierarchy.nodes()[subtree.node]);
            const bool is_good =
                v.view.tolerance_px > 0 && error <= detail::cell_tolerance(v.view, v.path, subtree.node);
            if (!is_good) {
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
                primitive_traits<P>::visit_instance(p, [&](const auto& instance) {
                    show_instance(v, instance, std::uint64_t(&p - v.source.primitives.data()));
                });
            }
        }
    }

    template <class V, class I>
    void show_instance(const V& v, const I& instance, std::uint64_t primitive) {
        using H = std::remove_cvref_t<decltype(*instance.hierarchy)>;
        using P = std::remove_cvref_t<decltype(instance.primitives[0])>;
        const H& h = *instance.hierarchy;
        more_[FrameWork::instances] += 1;
        if (h.item_count() == 0) return;
        const std::uint64_t path = detail::mixed(v.path, primitive + 1);
        const LocalView view = detail::view_inside(v, instance, path);
        const std::span<const P> primitives(instance.primitives);
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
