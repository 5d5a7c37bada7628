// A body's subtree, whole or cut by planes, drawn as a Viewer would draw it.
#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <utility>
#include <vector>

#include "farfield/body_frame.hpp"
#include "farfield/clip_lists.hpp"
#include "farfield/draw_queue.hpp"
#include "farfield/fingerprint.hpp"
#include "farfield/geometry/frustum.hpp"
#include "farfield/polygon_batch.hpp"
#include "farfield/region_division.hpp"
#include "farfield/spatial_hierarchy.hpp"

namespace farfield {

struct MergedFrameStats : FrameStats {
    std::uint64_t regions = 0;  ///< that more than one body reached into
    std::uint64_t pieces = 0;   ///< polygons cut for this frame; counted as primitives too
};

namespace detail {

/// For MergedViewer: one of its bodies at a time. Hierarchy, renderer and stats are borrowed.
template <class H, class P, class R>
class BodyWalker {
  public:
    ClipLists clips;

    BodyWalker(R& renderer, MergedFrameStats& stats) : renderer_(renderer), stats_(stats), queue_(renderer, stats) {}

    void add(const H& hierarchy, const Source<P>& source) { bodies_.push_back({&hierarchy, source}); }
    const H& hierarchy(std::uint32_t body) const { return *bodies_[body].hierarchy; }
    const BodyFrame& frame(std::uint32_t body) const { return frames_[body]; }
    std::span<const BodyFrame> frames() const { return frames_; }

    void begin_frame() {
        queue_.begin_frame();
        frames_.clear();
        now_ = none;
    }
    /// Of the bodies in turn.
    void add_view(const LocalView& view) { frames_.emplace_back(view); }
    void end_frame() { flush(); }

    BodyPart whole(std::uint32_t body) const {
        BodyPart part;
        part.cell = hierarchy(body).root_cell();
        part.box = part.cell.bounds();
        part.body = body;
        part.end_item = hierarchy(body).item_count();
        return part;
    }

    BodyPart child_of(const BodyPart& parent, unsigned child) const {
        const H& h = hierarchy(parent.body);
        const Node& node = h.nodes()[parent.node];
        const auto rank = unsigned(std::popcount(node.child_mask & ((1u << child) - 1)));
        const bool is_last = rank + 1 == unsigned(std::popcount(node.child_mask));
        BodyPart part = parent;
        part.cell = h.partition_policy().child(parent.cell, h.data_of(parent.node), child);
        part.box = part.cell.bounds();
        part.box.lower = glm::max(part.box.lower, parent.box.lower);
        part.box.upper = glm::min(part.box.upper, parent.box.upper);
        part.node = node.first_child + rank;
        part.end_item = is_last ? parent.end_item : h.nodes()[part.node + 1].first_item;
        part.is_asked_for = false;
        return part;
    }

    /// Takes away what does not matter of the planes of the view and of those that cut it, and shrinks its box. False
    /// if nothing of it can be seen.
    bool may_be_seen(BodyPart& part) {
        ++stats_.cells_visited;
        const Cell& cell = part.cell;
        if (part.mask != 0) {
            part.mask = crossed_planes(frame(part.body).view().planes, cell.bounds_center, cell.bounds_half, part.mask);
            if (part.mask == outside_a_plane) {
                ++stats_.cells_outside;
                return false;
            }
        }
        const H& h = hierarchy(part.body);
        const Node& node = h.nodes()[part.node];
        if (part.clips.count != 0) {
            if (part.box.is_empty()) return false;
            const bool is_leaf = node.child_mask == 0;
            // A leaf's polygons may fill little of its cell.
            if (!clips.narrow(part.clips, is_leaf ? bounds_of(h, node.first_item, part.end_item) : cell.bounds())) {
                return false;
            }
            if (!(is_leaf ? shrink_to_polygons(part, node.first_item) : clips.shrink(part.box, part.clips))) {
                return false;
            }
        }
        if constexpr (R::facts.answers_hidden) {
            if (part.end_item - node.first_item > asking_pays_above) {
                turn_to(part.body);
                flush();
                const std::uint64_t path = part.body == 0 ? 0 : mixed(0, part.body);
                if (renderer_.hidden(cell, CellId{path, part.node})) {
                    ++stats_.cells_hidden;
                    return false;
                }
            }
        }
        part.is_asked_for = true;
        return true;
    }

    void draw(BodyPart part) {
        const std::size_t clips_before = clips.size();
        if (part.is_asked_for || may_be_seen(part)) {
            const H& h = hierarchy(part.body);
            const Node& node = h.nodes()[part.node];
            if (node.child_mask == 0) {
                draw_items(part, node.first_item);
            } else {
                ChildOrder order;
                h.partition_policy().front_to_back(part.cell, h.data_of(part.node), frame(part.body).view().viewpoint(),
                                                   order);
                if constexpr (R::facts.order == Order::back_to_front) std::reverse(order.begin(), order.end());
                for (const unsigned child : order) {
                    if (node.child_mask >> child & 1) draw(child_of(part, child));
                }
            }
        }
        clips.shrink(clips_before);
    }

  private:
    static constexpr std::uint32_t none = 0xffffffffu;
    /// As a Viewer's.
    static constexpr std::uint32_t asking_pays_above = 24;

    struct Body {
        const H* hierarchy;
        Source<P> source;
    };

    static Box bounds_of(const H& h, std::uint32_t first, std::uint32_t end) {
        Box box = Box::empty();
        for (std::uint32_t at = first; at < end; ++at) {
            for (const glm::vec3& v : h.fragments()[at].vertices) box.add(v);
        }
        return box;
    }

    bool shrink_to_polygons(BodyPart& part, std::uint32_t first) {
        Box box = Box::empty();
        for (std::uint32_t at = first; at < part.end_item; ++at) {
            if (clipper_.clip(hierarchy(part.body).fragments()[at], clips[part.clips]) ==
                PolygonClipper::Left::nothing) {
                continue;
            }
            for (const Corner& c : clipper_.corners()) box.add(c.position);
        }
        part.box = box;
        return !box.is_empty();
    }

    void draw_items(const BodyPart& part, std::uint32_t first) {
        const Body& body = bodies_[part.body];
        if (!body.source.order.empty()) stats_.touched_bytes += (part.end_item - first) * sizeof(std::uint32_t);
        turn_to(part.body);
        if (part.clips.count == 0) {
            add_run(body, first, part.end_item);
            return;
        }
        for (std::uint32_t at = first; at < part.end_item; ++at) {
            switch (clipper_.clip(body.hierarchy->fragments()[at], clips[part.clips])) {
                case PolygonClipper::Left::nothing:
                    break;
                case PolygonClipper::Left::all:
                    add_run(body, at, at + 1);
                    break;
                case PolygonClipper::Left::part:
                    queue_.flush(body.source);
                    pieces_.add(clipper_.corners());
                    ++stats_.pieces;
                    ++stats_.primitives;
                    if (pieces_.is_full()) pieces_.draw(renderer_);
                    break;
            }
        }
    }

    void add_run(const Body& body, std::uint32_t first, std::uint32_t end) {
        pieces_.draw(renderer_);
        queue_.add_run(body.source, first, end, {});
    }

    /// What follows is this body's.
    void turn_to(std::uint32_t body) {
        if (body == now_) return;
        flush();
        now_ = body;
        queue_.set_view(frame(body).view());
    }

    /// Runs or pieces: never do both wait.
    void flush() {
        if (now_ == none) return;
        queue_.flush(bodies_[now_].source);
        pieces_.draw(renderer_);
    }

    R& renderer_;
    MergedFrameStats& stats_;
    std::vector<Body> bodies_;
    std::vector<BodyFrame> frames_;  ///< parallel to bodies_
    std::uint32_t now_ = none;       ///< whose view the renderer has
    DrawQueue<R> queue_;
    PolygonBatch pieces_;
    PolygonClipper clipper_;
};

}  // namespace detail
}  // namespace farfield
