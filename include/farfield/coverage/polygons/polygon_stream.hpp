// Polygons in the layout of the mask tiler: in the hierarchy's order, four corners at a time.
#pragma once

#include "farfield/settings.hpp"

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <initializer_list>
#include <span>
#include <vector>

#include "farfield/geometry/length.hpp"
#include "farfield/geometry/rgba8.hpp"
#include "farfield/renderer.hpp"

namespace farfield::detail {

/// A convex polygon of three or four corners, counter-clockwise seen from its front, in local coordinates, in one cache
/// line. A triangle's fourth corner is its third again.
struct alignas(64) PolygonRecord {
    static constexpr std::uint32_t flat = 0xffffffffu;
    /// The numbers of three corners.
    using Three = std::array<unsigned, 3>;

    float x[4], y[4], z[4];
    Rgba8 color;
    std::uint32_t colors = flat;  ///< index of its corners' colors if they differ
    bool is_triangle = false;
    std::uint8_t turns[2]{};  ///< how far the corners of each half are turned to come as they did

    /// The corners of one of the two triangles that a z-buffer makes of it, in its order.
    Three half(unsigned which) const {
        constexpr Three halves[2][3] = {{{0, 1, 2}, {1, 2, 0}, {2, 0, 1}}, {{0, 2, 3}, {2, 3, 0}, {3, 0, 2}}};
        return halves[which][turns[which]];
    }
};
static_assert(sizeof(PolygonRecord) == 64);

/// A source as records. Polygons of more corners, or whose colors have no single gradient, are split. Two triangles in
/// a row that make a plane quadrilateral, as most have been one, become one again: its diagonal, along which every mask
/// would be visited twice, is gone, and so is half of the work before.
class PolygonStream {
  public:
    PolygonStream() = default;
    template <PrimitiveWithPolygons P>
    explicit PolygonStream(const Source<P>& source) {
        if (source.changes) return;
        bool one_each = true, may_join = false;
        first_record_.reserve(source.item_count + 1);
        records_.reserve(source.item_count);
        for (std::uint32_t at = 0; at < source.item_count; ++at) {
            const auto first = std::uint32_t(records_.size());
            source.prefetch(at);
            source.polygons(at, [&](const Polygon& polygon) { append(polygon); });
            const bool is_one = records_.size() == first + 1;
            if (is_one && may_join && join_last()) {
                first_record_.push_back((first - 1) | within);
                may_join = false;
            } else {
                first_record_.push_back(first);
                may_join = is_one;
            }
            one_each = one_each && records_.size() == at + 1;
        }
        if (one_each) {
            first_record_ = std::vector<std::uint32_t>();  // not {}, which keeps the memory
        } else {
            first_record_.push_back(std::uint32_t(records_.size()));
        }
    }

    /// Empties a stream that is filled by add() every frame anew. Keeps its memory.
    void clear() {
        records_.clear();
        colors_.clear();
    }
    /// The polygon must have three vertices or more.
    void add(const Polygon& polygon) { append(polygon); }
    std::uint32_t size() const { return std::uint32_t(records_.size()); }
    std::size_t bytes() const {
        return records_.capacity() * sizeof(PolygonRecord) + colors_.capacity() * sizeof(Rgba8) +
               first_record_.capacity() * sizeof(std::uint32_t);
    }

    const PolygonRecord& operator[](std::uint32_t record) const { return records_[record]; }
    /// The first record of the primitive at a position.
    std::uint32_t first_record(std::uint32_t position) const {
        return first_record_.empty() ? position : first_record_[position] & ~within;
    }
    /// Whether that record is the last primitive's too, of which this one is the second half.
    bool begins_within(std::uint32_t position) const {
        return !first_record_.empty() && (first_record_[position] & within) != 0;
    }
    /// Prefetches a position's records, because front-to-back orders jump about in memory: `far_ahead` their index,
    /// later the records themselves.
    void prefetch(std::uint32_t position, bool far_ahead) const {
        // The last positions may have no record.
        if (far_ahead) {
            __builtin_prefetch(first_record_.empty() ? static_cast<const void*>(records_.data() + position)
                                                     : static_cast<const void*>(first_record_.data() + position));
        } else {
            __builtin_prefetch(records_.data() + first_record(position));
        }
    }
    /// The four colors of a record whose corners differ.
    const Rgba8* colors(const PolygonRecord& record) const { return &colors_[record.colors]; }

  private:
    void append(const Polygon& polygon) {
        const std::size_t corners = polygon.vertices.size();
        bool is_flat = true, is_solid = polygon.colors[0].a == 255;
        if (polygon.colors.size() >= corners) {
            for (const Rgba8 c : polygon.colors) {
                is_flat = is_flat && c == polygon.colors[0];
                is_solid = is_solid && c.a == 255;
            }
        }
        for (std::size_t i = 1; i + 1 < corners;) {
            // The samples that a translucent polygon covers are chosen by triangle (raster/shading.hpp).
            const bool is_triangle = !is_solid || i + 2 >= corners || !(is_flat || has_one_gradient(polygon, i));
            const std::size_t of[4] = {0, i, i + 1, is_triangle ? i + 1 : i + 2};
            i += is_triangle ? 1 : 2;
            PolygonRecord& r = records_.emplace_back();
            for (unsigned c = 0; c < 4; ++c) {
                r.x[c] = polygon.vertices[of[c]].x;
                r.y[c] = polygon.vertices[of[c]].y;
                r.z[c] = polygon.vertices[of[c]].z;
            }
            r.color = polygon.colors[0];
            r.is_triangle = is_triangle;
            if (is_flat) continue;
            r.colors = std::uint32_t(colors_.size());
            for (const std::size_t c : of) colors_.push_back(polygon.colors[c]);
        }
    }

    /// Turns the last two records, if they are triangles that make a plane quadrilateral of one gradient, into one.
    bool join_last() {
        PolygonRecord& one = records_[records_.size() - 2];
        const PolygonRecord& other = records_.back();
        if (!one.is_triangle || !other.is_triangle || one.color.a != 255 || other.color.a != 255) return false;
        if ((one.colors == PolygonRecord::flat) != (other.colors == PolygonRecord::flat)) return false;
        if (one.colors == PolygonRecord::flat && one.color != other.color) return false;
        for (unsigned i = 0; i < 3; ++i) {
            for (unsigned j = 0; j < 3; ++j) {
                // One's edge from i is the other's edge from j, the other way.
                const unsigned next = (i + 1) % 3, other_next = (j + 1) % 3;
                if (!is_same(one, i, other, other_next) || !is_same(one, next, other, j)) continue;
                return join(one, next, other, (j + 2) % 3);
            }
        }
        return false;
    }
    /// The diagonal leads from corner `from` of one to the one before, and `fourth` of the other is beyond.
    bool join(PolygonRecord& one, unsigned from, const PolygonRecord& other, unsigned fourth) {
        const auto at = [](const PolygonRecord& r, unsigned c) { return glm::vec3(r.x[c], r.y[c], r.z[c]); };
        const glm::vec3 corners[4] = {at(one, from), at(one, (from + 1) % 3), at(one, (from + 2) % 3),
                                      at(other, fourth)};
        Rgba8 colors[4];
        const bool is_flat = one.colors == PolygonRecord::flat;
        if (!is_flat) {
            for (unsigned c = 0; c < 3; ++c) colors[c] = colors_[one.colors + (from + c) % 3];
            colors[3] = colors_[other.colors + fourth];
            for (const Rgba8 c : colors) {
                if (c.a != 255) return false;
            }
            // Both have the same colors along the diagonal.
            const unsigned end = (fourth + 1) % 3;
            if (colors_[other.colors + end] != colors[0] || colors_[other.colors + (end + 1) % 3] != colors[2])
                return false;
        }
        const Polygon joined{{corners, 4},
                             is_flat ? std::span<const Rgba8>(&one.color, 1) : std::span<const Rgba8>(colors, 4)};
        if (!is_plane(joined.vertices) || !(is_flat || has_one_gradient(joined, 1))) return false;
        for (unsigned c = 0; c < 4; ++c) {
            one.x[c] = corners[c].x;
            one.y[c] = corners[c].y;
            one.z[c] = corners[c].z;
            if (!is_flat) colors_[one.colors + c] = colors[c];
        }
        if (!is_flat) colors_.resize(one.colors + 4);
        one.is_triangle = false;
        one.color = is_flat ? one.color : colors[0];
        // Where the corner that came first is now.
        one.turns[0] = std::uint8_t((3 - from) % 3);
        const unsigned first_of_other = (3 - fourth + 2) % 3;
        one.turns[1] = std::uint8_t(first_of_other);
        records_.pop_back();
        return true;
    }
    static bool is_same(const PolygonRecord& a, unsigned i, const PolygonRecord& b, unsigned j) {
        return a.x[i] == b.x[j] && a.y[i] == b.y[j] && a.z[i] == b.z[j];
    }
    /// Whether a quadrilateral is convex and no more bent than its corners' rounding explains.
    static bool is_plane(std::span<const glm::vec3> corners) {
        glm::vec3 u = corners[1] - corners[0], v = corners[2] - corners[0], w = corners[3] - corners[0];
        const float longest = glm::max(largest_component(u), glm::max(largest_component(v), largest_component(w)));
        const int exponent = -exponent_of(longest);
        for (glm::vec3* side : {&u, &v, &w}) *side = times_power_of_two(*side, exponent);
        const glm::vec3 one = glm::cross(u, v), other = glm::cross(v, w);
        const float one_length = glm::length(one), other_length = glm::length(other);
        if (!(one_length > 0) || !(other_length > 0)) return false;
        const glm::vec3 normal = one_length >= other_length ? one / one_length : other / other_length;
        float largest = longest;
        for (const glm::vec3& c : corners) largest = glm::max(largest, largest_component(c));
        const float rounding = 0x1p-20f * std::ldexp(largest, exponent);
        if (std::abs(glm::dot(normal, one_length >= other_length ? w : u)) > rounding) return false;
        // It turns the same way at all four.
        return glm::dot(one, normal) > 0 && glm::dot(other, normal) > 0 && glm::dot(glm::cross(u, w), normal) > 0 &&
               glm::dot(glm::cross(w - v, u - v), normal) > 0;
    }

    /// Whether corner i + 2 has, up to one step, the color that corners 0, i and i + 1 give linearly.
    static bool has_one_gradient(const Polygon& polygon, std::size_t i) {
        const glm::vec3 p = polygon.vertices[0];
        glm::vec3 u = polygon.vertices[i] - p, v = polygon.vertices[i + 1] - p, w = polygon.vertices[i + 2] - p;
        // What follows are products of four lengths.
        const int exponent = -exponent_of(glm::max(largest_component(u), largest_component(v)));
        for (glm::vec3* side : {&u, &v, &w}) *side = times_power_of_two(*side, exponent);
        const float uu = glm::dot(u, u), uv = glm::dot(u, v), vv = glm::dot(v, v);
        const float wu = glm::dot(w, u), wv = glm::dot(w, v), determinant = uu * vv - uv * uv;
        if (!(determinant > 0)) return false;
        const float s = (wu * vv - wv * uv) / determinant, t = (wv * uu - wu * uv) / determinant;
        const glm::vec4 c = to_vec4(polygon.colors[0]);
        const glm::vec4 expected = c + s * (to_vec4(polygon.colors[i]) - c) + t * (to_vec4(polygon.colors[i + 1]) - c);
        const glm::vec4 off = glm::abs(to_vec4(polygon.colors[i + 2]) - expected) * 255.0f;
        return off.x <= 1 && off.y <= 1 && off.z <= 1 && off.w <= 1;
    }

    static constexpr std::uint32_t within = 0x80000000u;

    std::vector<PolygonRecord> records_;
    std::vector<Rgba8> colors_;
    std::vector<std::uint32_t> first_record_;  ///< by position; empty where all have one record
};

}  // namespace farfield::detail
