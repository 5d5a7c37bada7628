// Polygons as the mask tiler wants them: in the hierarchy's order, four corners at a time.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "farfield/geometry/rgba8.hpp"
#include "farfield/renderer.hpp"

namespace farfield {

/// A convex polygon of three or four corners, counter-clockwise seen from its front, in local coordinates; the fourth
/// of a triangle is its third again. A cache line.
struct alignas(64) PolygonRecord {
    static constexpr std::uint32_t flat = 0xffffffffu;

    float x[4], y[4], z[4];
    Rgba8 color;
    std::uint32_t colors = flat;  ///< where its corners' colors are, if they differ: triangles only
    bool is_triangle = false;
};
static_assert(sizeof(PolygonRecord) == 64);

/// A source as records. Polygons of more corners, and those of several colors, come in parts.
class PolygonStream {
  public:
    template <PrimitiveWithPolygons P>
    explicit PolygonStream(const Source<P>& source) {
        bool one_each = true;
        first_record_.reserve(source.item_count + 1);
        records_.reserve(source.item_count);
        for (std::uint32_t at = 0; at < source.item_count; ++at) {
            first_record_.push_back(std::uint32_t(records_.size()));
            source.polygons(at, [&](const Polygon& polygon) { add(polygon); });
            one_each = one_each && records_.size() == at + 1;
        }
        if (one_each) {
            first_record_ = {};
        } else {
            first_record_.push_back(std::uint32_t(records_.size()));
        }
    }

    const PolygonRecord& operator[](std::uint32_t record) const { return records_[record]; }
    /// Positions to records.
    std::uint32_t first_record(std::uint32_t position) const {
        return first_record_.empty() ? position : first_record_[position];
    }
    /// Three, of a record whose corners differ.
    const Rgba8* colors(const PolygonRecord& record) const { return &colors_[record.colors]; }

  private:
    void add(const Polygon& polygon) {
        const std::size_t corners = polygon.vertices.size();
        bool is_flat = true;
        if (polygon.colors.size() >= corners) {
            for (const Rgba8 c : polygon.colors) is_flat = is_flat && c == polygon.colors[0];
        }
        // Which samples a translucent triangle covers goes by the triangle (raster/shading.hpp).
        const bool in_quadrilaterals = is_flat && polygon.colors[0].a == 255;
        const std::size_t step = in_quadrilaterals ? 2 : 1;
        for (std::size_t i = 1; i + 1 < corners; i += step) {
            const bool is_triangle = !in_quadrilaterals || i + 2 >= corners;
            const std::size_t of[4] = {0, i, i + 1, is_triangle ? i + 1 : i + 2};
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
            for (unsigned c = 0; c < 3; ++c) colors_.push_back(polygon.colors[of[c]]);
        }
    }

    std::vector<PolygonRecord> records_;
    std::vector<Rgba8> colors_;
    std::vector<std::uint32_t> first_record_;
};

}  // namespace farfield
