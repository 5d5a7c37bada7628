// Turns a hierarchy's polygons into convex ones on the screen, ready to be tiled: projected, snapped, turned clockwise,
// lit, and clipped if they must be.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include "farfield/coverage/polygons/polygon_stream.hpp"
#include "farfield/coverage/polygons/surface.hpp"
#include "farfield/geometry/length.hpp"
#include "farfield/geometry/light.hpp"
#include "farfield/geometry/rgba8.hpp"
#include "farfield/raster/polygon_clip.hpp"
#include "farfield/raster/sample_projection.hpp"
#include "farfield/raster/scan_conversion.hpp"
#include "farfield/raster/shading.hpp"
#include "farfield/raster/snapping.hpp"

namespace farfield::detail {

/// Valid as long as view and stream stay the same. `light` is in the stream's axes; null leaves colors as they are.
///
/// Tile receives the polygons: tile(TilePolygon&) gets `polygon` again and again and may write to its surface.
/// Tile::needs_depth says whether the surface's depth is to be set, Tile::reach_of_samples how far from its regular
/// center a sample may be, in 1/256 sample.
template <class Tile>
class PolygonSetup {
  public:
    PolygonSetup(const PolygonStream& stream, const SampleProjection& projection, const DirectionalLight* light,
                 bool culls_back_faces, TilePolygon& polygon, const Tile& tile)
        : stream_(stream),
          projection_(projection),
          light_(light),
          culls_back_faces_(culls_back_faces),
          polygon_(polygon),
          tile_(tile) {}

    /// Draws a record of the stream. Nothing is tiled if it holds no sample of the image or is turned away; triangles
    /// are tiled if snapping bends it or if it has to be clipped.
    void draw(const PolygonRecord& r) { draw(r, r.is_triangle ? Part::first : Part::both); }
    /// Draws the polygons of positions [first, end).
    void draw(std::uint32_t first, std::uint32_t end) {
        defers_backs_ = Tile::needs_depth && !culls_back_faces_;
        draw_in_order(first, end);
        defers_backs_ = false;
        for (std::size_t i = 0; i < deferred_count_; ++i) draw(*deferred_[i].record, deferred_[i].part);
        deferred_count_ = 0;
    }

  private:
    void draw_in_order(std::uint32_t first, std::uint32_t end) {
        std::uint32_t record = stream_.first_record(first);
        const std::uint32_t last = stream_.first_record(end);
        // Two primitives may share a record.
        if (stream_.begins_within(first) && first != end) draw(stream_[record++], Part::second);
        for (; record < last; ++record) draw(stream_[record]);
        if (stream_.begins_within(end) && first != end && record == last) draw(stream_[last], Part::first);
    }

    using Three = PolygonRecord::Three;

    struct Corners {
        std::array<std::int32_t, 4> x, y;
        std::array<float, 4> q;

        std::int64_t turn(unsigned a, unsigned b, unsigned c) const {
            return std::int64_t(x[b] - x[a]) * (y[c] - y[b]) - std::int64_t(y[b] - y[a]) * (x[c] - x[b]);
        }
        SnappedTriangle triangle(const Three& of) const {
            const auto [a, b, c] = of;
            return {{x[a], x[b], x[c]}, {y[a], y[b], y[c]}, {q[a], q[b], q[c]}};
        }
    };

    enum class Part { first, second, both };
    struct Deferred {
        const PolygonRecord* record;
        Part part;
    };
    /// Whether a polygon is left for later. Of a closed surface the backs are hidden by the fronts, if those come
    /// first; for polygons of a pixel or two that is not worth being projected twice.
    bool defers(const PolygonRecord& r, Part part, const Corners& k, bool is_front) {
        constexpr std::int32_t two_masks = 16 * 256;
        if (!defers_backs_ || is_front != projection_.is_mirrored || deferred_count_ == deferred_.size()) return false;
        if (std::abs(k.x[2] - k.x[0]) < two_masks && std::abs(k.y[2] - k.y[0]) < two_masks) return false;
        deferred_[deferred_count_++] = {&r, part};
        return true;
    }

    void draw(const PolygonRecord& r, Part part) {
        // Projects four corners side by side, as SampleProjection does one.
        typedef float Floats __attribute__((vector_size(16)));
        typedef std::int32_t Ints __attribute__((vector_size(16)));
        constexpr float guard = SampleProjection::guard_band * 256;
        Floats dx, dy, dz;
        std::memcpy(&dx, r.x, sizeof dx);
        std::memcpy(&dy, r.y, sizeof dy);
        std::memcpy(&dz, r.z, sizeof dz);
        dx -= projection_.anchor.x;
        dy -= projection_.anchor.y;
        dz -= projection_.anchor.z;
        const Floats depth = dx * projection_.forward.x + dy * projection_.forward.y + dz * projection_.forward.z;
        const Floats inverse = 1.0f / (depth * projection_.depth_weight + projection_.depth_bias);
        const Floats x = (dx * projection_.right.x + dy * projection_.right.y + dz * projection_.right.z) * inverse +
                         projection_.offset_x;
        const Floats y = (dx * projection_.down.x + dy * projection_.down.y + dz * projection_.down.z) * inverse +
                         projection_.offset_y;
        const Floats q = inverse * (projection_.q_of_inverse + depth * projection_.q_of_depth);
        const Ints is_behind = depth < projection_.near_depth;
        const Ints is_beyond = depth > projection_.far_depth;
        const Ints is_whole = ~is_behind & ~is_beyond & (x > -guard) & (x < guard) & (y > -guard) & (y < guard);
        if (!is_set(is_whole)) return is_set(is_behind) || is_set(is_beyond) ? void() : draw_clipped(r, part);
        Corners corners;
        const Floats snapped_x = x + snap_rounder, snapped_y = y + snap_rounder;
        std::memcpy(corners.x.data(), &snapped_x, sizeof snapped_x);
        std::memcpy(corners.y.data(), &snapped_y, sizeof snapped_y);
        std::memcpy(corners.q.data(), &q, sizeof q);
        for (unsigned c = 0; c < 4; ++c) {
            corners.x[c] -= std::int32_t(snap_rounder_bits);
            corners.y[c] -= std::int32_t(snap_rounder_bits);
        }
        const Rgba8* colors = r.colors == PolygonRecord::flat ? nullptr : stream_.colors(r);
        if (part == Part::both) {
            draw_quadrilateral(r, corners, colors);
        } else {
            const Three half = r.half(part == Part::first ? 0 : 1);
            if (defers_backs_ && defers(r, part, corners, corners.turn(half[0], half[1], half[2]) < 0)) return;
            draw_triangle(r, corners, half, colors);
        }
    }

    /// Whether all four lanes are set.
    template <class Ints>
    static bool is_set(const Ints& lanes) {
        std::uint64_t halves[2];
        std::memcpy(halves, &lanes, sizeof halves);
        return (halves[0] & halves[1]) == ~std::uint64_t(0);
    }

    void draw_quadrilateral(const PolygonRecord& r, const Corners& k, const Rgba8* colors) {
        const auto [low_x, high_x] = std::minmax({k.x[0], k.x[1], k.x[2], k.x[3]});
        const auto [low_y, high_y] = std::minmax({k.y[0], k.y[1], k.y[2], k.y[3]});
        if (holds_no_sample(low_x, high_x, low_y, high_y)) return;
        const auto draw_halves = [&] {
            draw_triangle(r, k, r.half(0), colors);
            draw_triangle(r, k, r.half(1), colors);
        };
        const std::int64_t turns[4] = {k.turn(0, 1, 2), k.turn(1, 2, 3), k.turn(2, 3, 0), k.turn(3, 0, 1)};
        const bool is_clockwise = turns[0] >= 0 && turns[1] >= 0 && turns[2] >= 0 && turns[3] >= 0;
        const bool is_front = turns[0] <= 0 && turns[1] <= 0 && turns[2] <= 0 && turns[3] <= 0;
        if (is_clockwise == is_front) {
            // Snapping bent it, or both are true because all turns are 0 and nothing is left.
            return is_front ? void() : draw_halves();
        }
        if (is_culled(is_front) || defers(r, Part::both, k, is_front)) return;
        polygon_.corners = 4;
        const unsigned order[4] = {0, is_front ? 3u : 1u, 2, is_front ? 1u : 3u};
        for (unsigned c = 0; c < 4; ++c) {
            polygon_.x[c] = k.x[order[c]];
            polygon_.y[c] = k.y[order[c]];
        }
        // Colors are those of the larger half's plane.
        const bool is_first =
            std::abs(k.triangle(r.half(0)).doubled_area()) >= std::abs(k.triangle(r.half(1)).doubled_area());
        const Three half = r.half(is_first ? 0 : 1);
        SnappedTriangle t = k.triangle(half);
        if (is_front) t.flip();
        if (colors == nullptr) {
            shade(r, r.half(0), is_front, nullptr, t);
        } else {
            const Rgba8 of_half[4] = {colors[half[0]], colors[half[1]], colors[half[2]], colors[is_first ? 3 : 1]};
            shade(r, r.half(0), is_front, of_half, t);
        }
        if constexpr (Tile::needs_depth) {
            SnappedTriangle other = k.triangle(r.half(is_first ? 1 : 0));
            if (is_front) other.flip();
            set_depth(k, t, other, is_first, is_front);
            // Each half has its own normal.
            if (light_ != nullptr && colors == nullptr && !is_lit_as(r, r.half(1), is_front)) return draw_halves();
        }
        tile_(polygon_);
    }

    /// Sets the surface's depth to bounds of both halves' planes, of which the larger one is the first if `is_first`.
    void set_depth(const Corners& k, const SnappedTriangle& larger, const SnappedTriangle& other, bool is_first,
                   bool is_front) {
        Surface& s = polygon_.surface;
        const std::int64_t area = larger.doubled_area(), other_area = other.doubled_area();
        if (other_area == 0) return set_depth(larger, area);
        s.depth = DepthPlane(larger, area);
        // Clockwise, the larger one goes around the diagonal this way.
        const unsigned from = is_first == is_front ? 0 : 2, to = 2 - from, fourth = is_first ? 3 : 1;
        s.fold = {0, {s.depth, DepthPlane(other, other_area)}, {k.x[from], k.y[from]}, {k.x[to], k.y[to]}};
        const auto [lowest, highest] = std::minmax({k.q[0], k.q[1], k.q[2], k.q[3]});
        const auto [low_x, high_x] = std::minmax({k.x[0], k.x[1], k.x[2], k.x[3]});
        const auto [low_y, high_y] = std::minmax({k.y[0], k.y[1], k.y[2], k.y[3]});
        const std::int64_t box = std::int64_t(high_x - low_x) * (high_y - low_y);
        const float most = std::max(std::abs(lowest), std::abs(highest));
        const auto rounding = [&](const SnappedTriangle& half, std::int64_t doubled_area) {
            return 0x1p-20f * (rounding_of_plane(half, box, doubled_area) + most);
        };
        const auto [other_lowest, other_highest] = std::minmax({other.q[0], other.q[1], other.q[2]});
        const float at_fourth = s.depth.at_corner + s.depth.by_x * (float(k.x[fourth] - larger.x[0]) * (1.0f / 256)) +
                                s.depth.by_y * (float(k.y[fourth] - larger.y[0]) * (1.0f / 256));
        const float off = std::abs(at_fourth - k.q[fourth]) + rounding(larger, area) +
                          std::min(rounding(other, other_area), 0x1p-20f * most + (other_highest - other_lowest));
        s.depth.lowest = lowest;
        s.depth.highest = highest;
        s.depth.at_corner += off;
        s.fold.thickness = 2 * off;
    }

    /// The same for one triangle. A sliver's slopes are differences of large numbers, and what rounding leaves of them
    /// may lead beyond its corners, where q is clamped: then it has bounds too, and samples ask for the depth itself.
    void set_depth(const SnappedTriangle& t, std::int64_t area) {
        Surface& s = polygon_.surface;
        s.depth = DepthPlane(t, area);
        s.fold.thickness = 0;
        const auto [low_x, high_x] = std::minmax({t.x[0], t.x[1], t.x[2]});
        const auto [low_y, high_y] = std::minmax({t.y[0], t.y[1], t.y[2]});
        const float off = rounding_of_plane(t, std::int64_t(high_x - low_x) * (high_y - low_y), area);
        // Samples grant two planes that much: see nearer_than in lazy_masks.inl.
        if (off <= 4 * s.depth.lowest) return;
        s.fold = {0x1p-19f * off, {s.depth, s.depth}, {}, {}};
        s.depth.at_corner += 0x1p-20f * off;
    }

    /// What single precision may make of the q of a triangle's plane anywhere in a box of that area, in units of 2^-20
    /// and generously.
    static float rounding_of_plane(const SnappedTriangle& t, std::int64_t box, std::int64_t doubled_area) {
        const float slopes = std::abs(t.q[1] - t.q[0]) + std::abs(t.q[2] - t.q[0]);
        return slopes * (2 * float(box) / float(doubled_area));
    }

    /// Whether those corners of a record of one color get the color that the surface has.
    bool is_lit_as(const PolygonRecord& r, const Three& of, bool is_front) const {
        return scaled(r.color, brightness(r, of, is_front)) == polygon_.surface.colors[0];
    }

    void draw_triangle(const PolygonRecord& r, const Corners& k, const Three& of, const Rgba8* colors) {
        SnappedTriangle t = k.triangle(of);
        const auto [low_x, high_x] = std::minmax({t.x[0], t.x[1], t.x[2]});
        const auto [low_y, high_y] = std::minmax({t.y[0], t.y[1], t.y[2]});
        if (holds_no_sample(low_x, high_x, low_y, high_y)) return;
        if (colors == nullptr) return draw_triangle(r, of, t, nullptr);
        const Rgba8 own[4] = {colors[of[0]], colors[of[1]], colors[of[2]], colors[of[2]]};
        draw_triangle(r, of, t, own);
    }

    void draw_triangle(const PolygonRecord& r, const Three& of, SnappedTriangle t, const Rgba8* colors) {
        const std::int64_t area = t.doubled_area();
        if (area == 0) return;
        const bool is_front = area < 0;  // counter-clockwise, rows running downwards
        if (is_culled(is_front)) return;
        if (is_front) t.flip();
        polygon_.set_triangle(t);
        if constexpr (Tile::needs_depth) set_depth(t, std::abs(area));
        shade(r, of, is_front, colors, t);
        tile_(polygon_);
    }

    /// `is_front` is told of the screen, where mirrored pictures show it the other way round.
    bool is_culled(bool is_front) const { return is_front == projection_.is_mirrored && culls_back_faces_; }

    bool holds_no_sample(std::int32_t low_x, std::int32_t high_x, std::int32_t low_y, std::int32_t high_y) const {
        constexpr int reach = Tile::reach_of_samples;
        const std::int32_t x0 = (low_x - reach + 127) >> 8, x1 = (high_x + reach - 128) >> 8;
        const std::int32_t y0 = (low_y - reach + 127) >> 8, y1 = (high_y + reach - 128) >> 8;
        return x0 > x1 || y0 > y1 || x0 >= projection_.end_x || y0 >= projection_.end_y || x1 < projection_.first_x ||
               y1 < projection_.first_y;
    }

    /// The corners `of` give the normal. Null `colors` stand for the record's one. Otherwise there are four: those of
    /// the triangle, in the order of corners before they were turned clockwise, and one more that the surface has.
    void shade(const PolygonRecord& r, const Three& of, bool is_front, const Rgba8* colors,
               const SnappedTriangle& clockwise) {
        Surface& s = polygon_.surface;
        s.color_weight = projection_.color_weight;
        s.is_flat = colors == nullptr;
        s.has_gradient = false;
        s.colors.fill(r.color);
        bool is_opaque = r.color.a == 255;
        if (colors != nullptr) {
            s.colors = {colors[0], colors[is_front ? 2 : 1], colors[is_front ? 1 : 2], colors[3]};
            is_opaque = s.colors[0].a == 255 && s.colors[1].a == 255 && s.colors[2].a == 255;
        }
        s.kind = is_opaque ? SurfaceKind::opaque : SurfaceKind::translucent;
        if (!is_opaque)
            s.hash = hash_of_triangle(corner(r, of[0]), corner(r, of[1]), corner(r, of[2])) + projection_.seed;
        if (light_ != nullptr) {
            const float lit = brightness(r, of, is_front);
            for (Rgba8& c : s.colors) c = scaled(c, lit);
        }
        if (colors != nullptr) s.triangle = clockwise;
    }

    static glm::vec3 corner(const PolygonRecord& r, unsigned c) { return {r.x[c], r.y[c], r.z[c]}; }
    float brightness(const PolygonRecord& r, const Three& of, bool is_front) const {
        const glm::vec3 a = corner(r, of[0]), n = normal_to(corner(r, of[1]) - a, corner(r, of[2]) - a);
        return light_->brightness(is_front != projection_.is_mirrored ? n : -n);
    }

    void draw_clipped(const PolygonRecord& r, Part part) {
        if (part == Part::both && !Tile::needs_depth) {
            return draw_clipped(r, r.half(0), std::array<unsigned, 4>{0, 1, 2, 3});
        }
        if (part != Part::second) draw_clipped(r, r.half(0), r.half(0));
        if (part != Part::first) draw_clipped(r, r.half(1), r.half(1));
    }

    /// Draws the polygon of those corners `of` a record; three of them give the normal.
    template <std::size_t n>
    void draw_clipped(const PolygonRecord& r, const Three& normal, const std::array<unsigned, n>& of) {
        const Rgba8* colors = r.colors == PolygonRecord::flat ? nullptr : stream_.colors(r);
        ClippedPolygon clipped;
        for (const unsigned c : of) {
            clipped.add({r.x[c], r.y[c], r.z[c]}, projection_, colors == nullptr ? glm::vec4(0) : to_vec4(colors[c]));
        }
        clipped.clip(projection_);
        for (std::size_t i = 2; i < clipped.size(); ++i) {
            SnappedTriangle t;
            const std::size_t from[3] = {0, i - 1, i};
            Rgba8 corner_colors[4];
            for (unsigned c = 0; c < 3; ++c) {
                clipped.snap(from[c], projection_, t, c);
                if (colors != nullptr) corner_colors[c] = to_rgba8(clipped[from[c]].color);
            }
            corner_colors[3] = corner_colors[2];
            draw_triangle(r, normal, t, colors == nullptr ? nullptr : corner_colors);
        }
    }

    const PolygonStream& stream_;
    const SampleProjection& projection_;
    const DirectionalLight* light_;
    bool culls_back_faces_;
    TilePolygon& polygon_;
    Tile tile_;
    bool defers_backs_ = false;
    std::size_t deferred_count_ = 0;
    std::array<Deferred, 64> deferred_;
};

}  // namespace farfield::detail
