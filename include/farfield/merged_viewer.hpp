// Bodies that move through one another, each a hierarchy of its own, merged in one strict front-to-back walk: "if this
// cube does intersect other leaf cubes, we clip their polygons to the frontmost cube" (Greene 1996, section 6.2).
//
// Space is divided by planes, and the parts on the viewer's side of a plane come first. A region that one body alone
// reaches into is in order because its hierarchy is. Any other region is divided further:
//
//     by a face of some body's box that has others beyond it and none (few, of many) across it
//     or, where there is none, by the planes that cut the largest part next
//
// so that leaves come to lie between leaves, and a polygon between the polygons before and behind it. It is the merging
// of BSP trees (Naylor, Amanatides and Thibault 1990) in place of the paper's octrees, and it is lazy: planes go down
// with a subtree, and only leaves that they cross are cut, into polygons that live until they are drawn. Subtrees that
// meet nothing are drawn as a Viewer draws them.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "farfield/fail.hpp"
#include "farfield/frame/source_table.hpp"
#include "farfield/hierarchy/fingerprint.hpp"
#include "farfield/merged_viewer/body_frame.hpp"
#include "farfield/merged_viewer/body_walker.hpp"
#include "farfield/merged_viewer/split_region.hpp"
#include "farfield/primitive/instance.hpp"
#include "farfield/spatial_hierarchy.hpp"

namespace farfield {

template <class H>
concept CutForStrictOrder = H::assignment == Assignment::clipped&& H::ordering == OrderGuarantee::primitives;
template <class P>
concept HasNoInstances = !PrimitiveWithInstance<P>;
template <class R>
concept DrawsPolygonsOfFrames = R::facts.draws_polygons&& DrawsPolygons<R>;

template <class H, class P, class R>
concept MergeableWith = BuildableFrom<H, P> && DrawableWith<H, P, R> && CutForStrictOrder<H> && HasNoInstances<P> &&
    DrawsPolygonsOfFrames<R>;

/// Draws bodies together in strict order, front to back or as the renderer's facts say. Polygons in one plane, or
/// nearer to each other than single precision tells, come in any order. Borrows hierarchies, primitives and renderer,
/// which outlive it; bodies may share a hierarchy. A user's own partition that cuts by several planes at once must put
/// polygons on a plane to a side of it, or to a child of their own.
///
/// Where bodies overlap, a frame takes as long as building a BSP of that part does; elsewhere it takes as long as a
/// Viewer's. A moving body of many polygons needs leaves as small as those of Nested<Octree, PolygonBsp>{.largest_leaf
/// = 32}: in one BSP of a convex body nearly every plane leaves all the rest on one side. Frames do not allocate once
/// buffers have grown to the scene's needs. Two threads must not use one at once.
template <class H, class P, class R>
requires MergeableWith<H, P, R>
class MergedViewer {
  public:
    using Body = Instance<H, P>;

    /// Throws std::invalid_argument naming the first body that has no hierarchy, whose primitives are not those that
    /// its hierarchy was built from, or whose hierarchy does not keep strict order.
    MergedViewer(std::span<const Body> bodies, R& renderer)
        : bodies_(bodies.begin(), bodies.end()), renderer_(renderer), sources_(renderer), walker_(renderer, stats_) {
        for (std::size_t b = 0; b < bodies_.size(); ++b) add(b);
        for (const Body& b : bodies_) {
            const std::uint32_t id = sources_.find(*b.hierarchy, b.primitives).id;
            walker_.add(*b.hierarchy, detail::source_of(*b.hierarchy, b.primitives, id));
        }
    }
    MergedViewer(const MergedViewer&) = delete;
    MergedViewer& operator=(const MergedViewer&) = delete;

    std::span<const Body> bodies() const { return bodies_; }

    /// Places a body from the next frame on. Throws std::invalid_argument if there is no such body or
    /// no such place.
    void place(std::size_t body, const Similarity& to_world) {
        if (body >= bodies_.size()) {
            detail::fail<std::invalid_argument>("farfield::MergedViewer: there is no body " + std::to_string(body) +
                                                " of " + std::to_string(bodies_.size()));
        }
        check_place(body, to_world);
        bodies_[body].to_world = to_world;
    }

    /// Draws into the renderer. Throws only what the renderer's begin_frame throws, and for memory.
    MergedFrameStats frame(const View& view) {
        sources_.check_renderer("farfield::MergedViewer");
        stats_ = {};
        walker_.begin_frame();
        regions_.clear();
        waiting_parts_.clear();
        const LocalView outer = outermost(view);
        renderer_.begin_frame(outer);
        region_parts_.clear();
        for (std::uint32_t b = 0; b < bodies_.size(); ++b) {
            const H& h = *bodies_[b].hierarchy;
            walker_.add_view(outer.inside(bodies_[b].to_world, origin(), h.origin()));
            if (h.item_count() != 0) region_parts_.push_back(walker_.whole(b));
        }
        push(region_parts_, nullptr);
        while (!regions_.empty()) draw_region();
        walker_.end_frame();
        stats_.touched_bytes += stats_.cells_visited * sizeof(Node);
        renderer_.end_frame();
        return stats_;
    }

  private:
    using Part = detail::BodyPart;

    static void check_place(std::size_t body, const Similarity& to_world) {
        if (to_world.is_finite()) return;
        detail::fail<std::invalid_argument>("farfield::MergedViewer: body " + std::to_string(body) +
                                            "'s translation must be finite");
    }

    void add(std::size_t b) {
        const std::string name = "farfield::MergedViewer: body " + std::to_string(b);
        const Body& body = bodies_[b];
        if (body.hierarchy == nullptr) detail::fail<std::invalid_argument>(name + " has no hierarchy");
        check_place(b, body.to_world);
        detail::check_source(name.c_str(), *body.hierarchy, body.primitives, /*needs_strict_order=*/true);
        if (!sources_.has(*body.hierarchy, body.primitives)) {
            detail::check_fingerprint(name.c_str(), *body.hierarchy, body.primitives);
        }
        sources_.add_all(*body.hierarchy, body.primitives);
    }

    glm::dvec3 origin() const { return bodies_.empty() ? glm::dvec3(0) : bodies_[0].hierarchy->origin(); }

    LocalView outermost(const View& view) const {
        BoxD whole = BoxD::empty();
        for (const Body& body : bodies_) whole.add(body.bounds());
        if (whole.is_empty()) return LocalView(view, origin(), Box::empty());
        return LocalView(view, origin(), float(length_of(whole.size())), glm::vec3(whole.center() - origin()));
    }

    // --- regions of more than one body

    /// A part of space that waits to be drawn. The last one waiting is next; its parts are the last ones of
    /// `waiting_parts_`.
    struct Region {
        std::size_t first_part;
        std::size_t clips;  ///< size of the stack of planes that it and the regions after it need
    };

    void push(std::span<const Part> parts, const Part* own) {
        if (parts.empty() && own == nullptr) return;
        regions_.push_back({waiting_parts_.size(), walker_.clips.size()});
        waiting_parts_.insert(waiting_parts_.end(), parts.begin(), parts.end());
        if (own != nullptr) waiting_parts_.push_back(*own);
    }

    void draw_region() {
        const Region region = regions_.back();
        regions_.pop_back();
        walker_.clips.shrink(region.clips);
        region_parts_.assign(waiting_parts_.begin() + std::ptrdiff_t(region.first_part), waiting_parts_.end());
        waiting_parts_.resize(region.first_part);
        if (region_parts_.size() > 1) {
            std::size_t left = 0;
            for (std::size_t i = 0; i < region_parts_.size(); ++i) {
                if (region_parts_[i].visibility_tested || walker_.may_be_seen(region_parts_[i]))
                    region_parts_[left++] = region_parts_[i];
            }
            region_parts_.resize(left);
        }
        if (region_parts_.empty()) return;
        if (region_parts_.size() == 1) return walker_.draw(region_parts_[0]);
        ++stats_.regions;
        if (const auto face = detail::separating_face(region_parts_, walker_.frames())) {
            divide_at_face(*face);
        } else {
            divide_largest();
        }
    }

    /// Whether the side that a plane's normal points to is drawn first.
    bool front_is_first(std::uint32_t body, const LocalPlane& plane) const {
        return (plane.height(walker_.frame(body).view().viewpoint()) > 0) !=
               (R::facts.order == VisitOrder::back_to_front);
    }
    static void test_visibility_again(std::span<Part> parts) {
        for (Part& part : parts) part.visibility_tested = false;
    }

    void divide_at_face(const detail::SeparatingFace& face) {
        const Part part = region_parts_[face.part];
        const LocalPlane plane = detail::face_of_box(part.box, face.face, part.cell);
        region_parts_.erase(region_parts_.begin() + std::ptrdiff_t(face.part));
        detail::SidesOfPlane& sides = sides_[0];
        detail::divide(region_parts_, walker_.frames(), part.body, plane, walker_.clips, sides);
        sides.behind.push_back(part);
        const bool front_first = front_is_first(part.body, plane);
        std::vector<Part>& last = front_first ? sides.behind : sides.in_front;
        test_visibility_again(last);
        push(last, nullptr);
        push(front_first ? sides.in_front : sides.behind, nullptr);
    }

    void divide_largest() {
        const auto size = [&](const Part& part) {
            return glm::length(part.box.size()) * walker_.frame(part.body).view().scale;
        };
        const auto largest = std::max_element(region_parts_.begin(), region_parts_.end(),
                                              [&](const Part& a, const Part& b) { return size(a) < size(b); });
        own_ = *largest;
        region_parts_.erase(largest);
        const H& h = *bodies_[own_.body].hierarchy;
        if (h.nodes()[own_.node].child_mask != 0) {
            divide(h, h.partition_policy().cuts(own_.cell, h.data_of(own_.node)), 0, Sides{}, region_parts_);
            return;
        }
        // The plane of its polygons divides the other parts into those before and behind them.
        const LocalPlane plane =
            detail::plane_of_polygons(h.fragments(), h.nodes()[own_.node].first_item, own_.end_item, own_.cell);
        detail::divide(region_parts_, walker_.frames(), own_.body, plane, walker_.clips, sides_[0]);
        const bool front_first = front_is_first(own_.body, plane);
        std::vector<Part>& last = front_first ? sides_[0].behind : sides_[0].in_front;
        test_visibility_again(last);
        push(last, nullptr);
        push({}, &own_);
        push(front_first ? sides_[0].in_front : sides_[0].behind, nullptr);
    }

    /// Divides others by cuts [plane, count). Regions are a stack, so the last to be drawn is pushed first.
    void divide(const H& h, const Cuts& cuts, unsigned plane, Sides sides, std::span<const Part> others) {
        if (plane == sides.size() || plane >= cuts.count) {
            push_child(h, cuts, sides, others);
            return;
        }
        const LocalPlane local_plane(cuts.planes[plane], own_.cell);
        detail::SidesOfPlane& their = sides_[plane];
        detail::divide(others, walker_.frames(), own_.body, local_plane, walker_.clips, their);
        const bool front_first = front_is_first(own_.body, local_plane);
        std::vector<Part>& last = front_first ? their.behind : their.in_front;
        test_visibility_again(last);
        sides[plane] = front_first ? Side::behind : Side::in_front;
        divide(h, cuts, plane + 1, sides, last);
        sides[plane] = Side::on;
        divide(h, cuts, plane + 1, sides, {});
        sides[plane] = front_first ? Side::in_front : Side::behind;
        divide(h, cuts, plane + 1, sides, front_first ? their.in_front : their.behind);
    }

    void push_child(const H& h, const Cuts& cuts, const Sides& sides, std::span<const Part> others) {
        const typename H::node_data data = h.data_of(own_.node);
        const unsigned child = h.partition_policy().child_at(data, sides);
        const auto used = sides.begin() + cuts.count;
        if (std::find(sides.begin(), used, Side::on) != used) {
            // Partitions may put polygons on a plane to one of its sides.
            for (const Side instead : {Side::behind, Side::in_front}) {
                Sides other = sides;
                std::replace(other.begin(), other.end(), Side::on, instead);
                if (h.partition_policy().child_at(data, other) == child) return;
            }
        }
        if ((h.nodes()[own_.node].child_mask >> child & 1) == 0) return push(others, nullptr);
        const Part part = walker_.child_of(own_, child);
        push(others, &part);
    }

    std::vector<Body> bodies_;
    R& renderer_;
    MergedFrameStats stats_;
    detail::SourceTable<R> sources_;
    detail::BodyWalker<H, P, R> walker_;
    std::vector<Region> regions_;
    std::vector<Part> waiting_parts_;  ///< of all regions that wait, one after the other
    std::vector<Part> region_parts_;   ///< of the region at work
    Part own_;                         ///< the one that divides it
    std::array<detail::SidesOfPlane, 3> sides_;
};

/// Prefer this to naming the type: where something is missing, compilers say what.
template <class H, class P, class R>
requires MergeableWith<H, P, R>
auto make_merged_viewer(const std::vector<Instance<H, P>>& bodies, R& renderer) {
    return MergedViewer<H, P, R>(std::span<const Instance<H, P>>(bodies), renderer);
}

}  // namespace farfield
