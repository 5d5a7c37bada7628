// Draws a body's subtree, whole or cut by planes, as a Viewer would draw it.
#pragma once

#include "farfield/settings.hpp"

#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <utility>
#include <vector>

#include "farfield/frame/draw_queue.hpp"
#include "farfield/frame/subtree.hpp"
#include "farfield/hierarchy/fingerprint.hpp"
#include "farfield/hierarchy/node.hpp"
#include "farfield/merged_viewer/body_frame.hpp"
#include "farfield/merged_viewer/clip_stack.hpp"
#include "farfield/merged_viewer/polygon_batch.hpp"
#include "farfield/merged_viewer/split_region.hpp"
#include "farfield/spatial_hierarchy.hpp"

namespace farfield {

struct MergedFrameStats : FrameStats {
    std::uint64_t regions = 0;  ///< regions that more than one body reached into
    std::uint64_t pieces = 0;   ///< polygons cut for this frame; they count as primitives too
};

namespace detail {

/// Draws parts of a MergedViewer's bodies, one at a time. Borrows hierarchies, renderer and stats.
template <class H, class P, class R>
class BodyWalker {
  public:
    ClipStack clips;

    BodyWalker(R& renderer, MergedFrameStats& stats) : renderer_(renderer), stats_(stats), queue_(renderer, stats) {}

    void add(const H& hierarchy, const Source<P>& source) { bodies_.push_back({&hierarchy, source}); }
    const H& hierarchy(std::uint32_t body) const { return *bodies_[body].hierarchy; }
    const BodyFrame& frame(std::uint32_t body) const { return frames_[body]; }
    std::span<const BodyFrame> frames() const { return frames_; }

    /// Forgets what waits: an exception may have ended the last frame.
    void begin_frame() {
        queue_.begin_frame();
        pieces_.clear();
        clips.shrink(0);
        frames_.clear();
        active_body_ = none;
    }
    /// Adds the view of the next body; called for each, in order.
    void add_view(LocalView view) {
        view.seed = std::uint32_t(path_of(std::uint32_t(frames_.size())) >> 32);
        frames_.emplace_back(view);
    }
    void end_frame() { flush(); }

    BodyPart whole(std::uint32_t body) const {
        BodyPart part{whole_of(hierarchy(body))};
        part.box = part.cell.bounds();
        part.body = body;
        return part;
    }

    BodyPart child_of(const BodyPart& parent, unsigned child) const {
        const H& h = hierarchy(parent.body);
        return part_of(parent, detail::child_of(h, parent, h.nodes()[parent.node], h.data_of(parent.node), child));
    }

    /// Drops the planes, of the view and of cuts, that the part is clear of, and shrinks its box. Returns false if
    /// nothing of it can be seen.
    bool may_be_seen(BodyPart& part) {
        ++stats_.cells_visited;
        const Cell& cell = part.cell;
        const LocalView& view = frame(part.body).view();
        if (is_outside(view.planes, part) || is_outside_tile(view, part)) {
            ++stats_.cells_outside;
            return false;
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
            if (part.end_item - node.first_item >= min_items_for_occlusion_query) {
                turn_to(part.body);
                flush();
                if (renderer_.hidden(cell, CellId{path_of(part.body), part.node})) {
                    ++stats_.cells_hidden;
                    return false;
                }
            }
        }
        part.visibility_tested = true;
        return true;
    }

    void draw(BodyPart part) {
        const std::size_t clips_before = clips.size();
        if (part.visibility_tested || may_be_seen(part)) {
            const H& h = hierarchy(part.body);
            const Node& node = h.nodes()[part.node];
            if (node.child_mask == 0) {
                draw_items(part, node.first_item);
            } else {
                constexpr VisitOrder order =
                    R::facts.order == VisitOrder::back_to_front ? VisitOrder::back_to_front : VisitOrder::front_to_back;
                for_each_child<order>(h, part, frame(part.body).view().viewpoint(),
                                      [&](const Subtree& child) { draw(part_of(part, child)); });
            }
        }
        clips.shrink(clips_before);
    }

  private:
    static constexpr std::uint32_t none = 0xffffffffu;

    /// As CellId's; the first body, which the others are seen from, has that of an outermost hierarchy.
    static std::uint64_t path_of(std::uint32_t body) { return body == 0 ? 0 : mixed(0, body); }

    struct Body {
        const H* hierarchy;
        Source<P> source;
    };

    /// A child of a part, cut by the planes that cut its parent.
    static BodyPart part_of(const BodyPart& parent, const Subtree& child) {
        BodyPart part{child};
        part.body = parent.body;
        part.clips = parent.clips;
        part.box = part.cell.bounds();
        part.box.lower = glm::max(part.box.lower, parent.box.lower);
        part.box.upper = glm::min(part.box.upper, parent.box.upper);
        return part;
    }

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

    /// Everything added from now on belongs to this body.
    void turn_to(std::uint32_t body) {
        if (body == active_body_) return;
        flush();
        active_body_ = body;
        queue_.set_view(frame(body).view());
    }

    /// Sends on what waits: runs or pieces, never both.
    void flush() {
        if (active_body_ == none) return;
        queue_.flush(bodies_[active_body_].source);
        pieces_.draw(renderer_);
    }

    R& renderer_;
    MergedFrameStats& stats_;
    std::vector<Body> bodies_;
    std::vector<BodyFrame> frames_;     ///< parallel to bodies_
    std::uint32_t active_body_ = none;  ///< the body whose view the renderer has
    DrawQueue<R> queue_;
    PolygonBatch pieces_;
    PolygonClipper clipper_;
};

}  // namespace detail
}  // namespace farfield
