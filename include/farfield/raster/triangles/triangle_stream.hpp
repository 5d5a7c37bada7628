// Triangles in the layout of the rasterizer: in the hierarchy's order, eight at a time, coordinate by coordinate.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "farfield/geometry/polygon.hpp"
#include "farfield/geometry/rgba8.hpp"
#include "farfield/primitive.hpp"
#include "farfield/renderer.hpp"

namespace farfield::detail {

/// Eight triangles, structure of arrays: v[3 * corner + axis][lane]. Small runs start anywhere, so blocks are short.
struct TriangleBlock {
    static constexpr std::uint32_t lanes = 8;
    float v[9][lanes];
};

/// A source in triangles: each takes 36 bytes of coordinates and 4 of color (12 if any triangle has several colors).
class TriangleStream {
  public:
    TriangleStream() = default;
    /// A stream that does not keep triangles knows only how many there are, which are whose, and whether any has
    /// several colors: 4 bytes a position, or none where each holds one triangle.
    template <PrimitiveWithPolygons P>
    explicit TriangleStream(const Source<P>& source, bool keeps_triangles = true) {
        if (source.changes) return;  // the blocks of any position, and any colors
        bool one_each = true, several_colors = false;
        first_triangle_.reserve(source.item_count + 1);
        if (keeps_triangles) blocks_.reserve(source.item_count / TriangleBlock::lanes + 1);
        for (std::uint32_t at = 0; at < source.item_count; ++at) {
            first_triangle_.push_back(count_);
            source.prefetch(at);
            source.polygons(at, [&](const Polygon& polygon) {
                several_colors = several_colors || has_several_colors(polygon);
                if (keeps_triangles) {
                    add(polygon);
                } else {
                    for_each_triangle(polygon.vertices.size(), [&](auto...) { ++count_; });
                }
            });
            one_each = one_each && count_ == at + 1;
        }
        if (one_each) {
            first_triangle_ = std::vector<std::uint32_t>();  // not {}, which keeps the memory
        } else {
            first_triangle_.push_back(count_);
        }
        if (!several_colors) {
            // Colors were kept by vertex until now; one a triangle is enough.
            colors_each_ = 1;
            if (!keeps_triangles) return;
            for (std::size_t t = 0; t < count_; ++t) colors_[t] = colors_[3 * t];
            colors_.resize(count_);
            colors_.shrink_to_fit();
        }
    }

    /// Makes a stream of its own, to be filled by add(): `unused` triangles without area. Keeps its memory.
    void restart(std::uint32_t unused, bool several_colors) {
        blocks_.clear();
        if (unused != 0) blocks_.resize((unused - 1) / TriangleBlock::lanes + 1);
        count_ = unused;
        colors_each_ = several_colors ? 3 : 1;
        colors_.assign(colors_each_ * std::size_t(unused), {});
    }
    /// Adds the triangles that a polygon fans out into.
    void add(const Polygon& polygon) {
        const bool one_color = polygon.colors.size() < polygon.vertices.size();
        for_each_triangle(polygon.vertices.size(), [&](std::size_t a, std::size_t b, std::size_t c) {
            const std::uint32_t lane = count_ % TriangleBlock::lanes;
            if (lane == 0) blocks_.emplace_back();  // zeroed: unused lanes are degenerate
            const std::size_t corner[3] = {a, b, c};
            for (unsigned k = 0; k < 3; ++k) {
                for (int axis = 0; axis < 3; ++axis) {
                    blocks_.back().v[3 * k + unsigned(axis)][lane] = polygon.vertices[corner[k]][axis];
                }
                if (k < colors_each_) colors_.push_back(polygon.colors[one_color ? 0 : corner[k]]);
            }
            ++count_;
        });
    }
    /// Drops the first triangles, a multiple of TriangleBlock::lanes.
    void drop(std::uint32_t triangles) {
        blocks_.erase(blocks_.begin(), blocks_.begin() + std::ptrdiff_t(triangles / TriangleBlock::lanes));
        colors_.erase(colors_.begin(), colors_.begin() + std::ptrdiff_t(colors_each_ * std::size_t(triangles)));
        count_ -= triangles;
    }

    std::uint32_t size() const { return count_; }
    std::size_t bytes() const {
        return blocks_.capacity() * sizeof(TriangleBlock) + colors_.capacity() * sizeof(Rgba8) +
               first_triangle_.capacity() * sizeof(std::uint32_t);
    }
    const TriangleBlock* blocks() const { return blocks_.data(); }
    bool several_colors() const { return colors_each_ != 1; }
    /// The colors of one triangle: three if several_colors(), else one.
    const Rgba8* colors(std::uint32_t triangle) const { return &colors_[colors_each_ * std::size_t(triangle)]; }
    /// The first triangle of the primitive at a position.
    std::uint32_t first_triangle(std::uint32_t position) const {
        return first_triangle_.empty() ? position : first_triangle_[position];
    }
    glm::vec3 vertex(std::uint32_t triangle, unsigned corner) const {
        const TriangleBlock& b = blocks_[triangle / TriangleBlock::lanes];
        const std::uint32_t lane = triangle % TriangleBlock::lanes;
        return {b.v[3 * corner][lane], b.v[3 * corner + 1][lane], b.v[3 * corner + 2][lane]};
    }

  private:
    static bool has_several_colors(const Polygon& polygon) {
        return polygon.colors.size() >= polygon.vertices.size() &&
               std::any_of(polygon.colors.begin(), polygon.colors.end(),
                           [&](Rgba8 c) { return c != polygon.colors[0]; });
    }

    std::vector<TriangleBlock> blocks_;
    std::vector<Rgba8> colors_;
    std::vector<std::uint32_t> first_triangle_;
    std::uint32_t count_ = 0;
    std::uint32_t colors_each_ = 3;
};

}  // namespace farfield::detail
