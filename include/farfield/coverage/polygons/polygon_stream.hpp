// Polygons in the layout of the mask tiler: in the hierarchy's order, four corners at a time.
#pragma once

#include "farfield/settings.hpp"

#include <cstddef>
#include <cstdint>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <initializer_list>
#include <vector>

#include "farfield/geometry/length.hpp"
#include "farfield/geometry/rgba8.hpp"
#include "farfield/renderer.hpp"

namespace farfield::detail {

/// A convex polygon of three or four corners, counter-clockwise seen from its front, in local coordinates, in one cache
/// line. A triangle's fourth corner is its third again.
struct alignas(64) PolygonRecord {
    static constexpr std::uint32_t flat = 0xffffffffu;

    float x[4], y[4], z[4];
    Rgba8 color;
    std::uint32_t colors = flat;  ///< index of its corners' colors if they differ
    bool is_triangle = false;
};
static_assert(sizeof(PolygonRecord) == 64);

/// A source as records. Polygons of more corners, or whose colors have no single gradient, are split.
class PolygonStream {
  public:
    PolygonStream() = default;
    template <PrimitiveWithPolygons P>
    explicit PolygonStream(const Source<P>& source) {
        bool one_each = true;
        first_record_.reserve(source.item_count + 1);
        records_.reserve(source.item_count);
        for (std::uint32_t at = 0; at < source.item_count; ++at) {
            first_record_.push_back(std::uint32_t(records_.size()));
            source.prefetch(at);
            source.polygons(at, [&](const Polygon& polygon) { append(polygon); });
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
        return first_record_.empty() ? position : first_record_[position];
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

    std::vector<PolygonRecord> records_;
    std::vector<Rgba8> colors_;
    std::vector<std::uint32_t> first_record_;
};

}  // namespace farfield::detail
