// Triangles in the layout of the rasterizer: in the hierarchy's order, eight at a time, coordinate by coordinate.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

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
    template <PrimitiveWithPolygons P>
    explicit TriangleStream(const Source<P>& source) {
        bool one_each = true;
        first_triangle_.reserve(source.item_count + 1);
        blocks_.reserve(source.item_count / TriangleBlock::lanes + 1);
        for (std::uint32_t at = 0; at < source.item_count; ++at) {
            first_triangle_.push_back(count_);
            source.polygons(at, [&](const Polygon& polygon) { add(polygon); });
            one_each = one_each && count_ == at + 1;
        }
        if (one_each) {
            first_triangle_ = {};
        } else {
            first_triangle_.push_back(count_);
        }
        if (!several_colors_) {
            // Colors were kept by vertex until now; one a triangle is enough.
            for (std::size_t t = 0; t < count_; ++t) colors_[t] = colors_[3 * t];
            colors_.resize(count_);
            colors_.shrink_to_fit();
        }
    }

    std::uint32_t size() const { return count_; }
    std::size_t bytes() const {
        return blocks_.capacity() * sizeof(TriangleBlock) + colors_.capacity() * sizeof(Rgba8) +
               first_triangle_.capacity() * sizeof(std::uint32_t);
    }
    const TriangleBlock* blocks() const { return blocks_.data(); }
    bool several_colors() const { return several_colors_; }
    /// The colors of one triangle: three if several_colors(), else one.
    const Rgba8* colors(std::uint32_t triangle) const {
        return &colors_[several_colors_ ? 3 * std::size_t(triangle) : triangle];
    }
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
    void add(const Polygon& polygon) {
        const bool one_color = polygon.colors.size() < polygon.vertices.size();
        for (std::size_t i = 2; i < polygon.vertices.size(); ++i) {
            const std::uint32_t lane = count_ % TriangleBlock::lanes;
            if (lane == 0) blocks_.emplace_back();  // zeroed: unused lanes are degenerate
            const std::size_t corner[3] = {0, i - 1, i};
            for (unsigned c = 0; c < 3; ++c) {
                for (int axis = 0; axis < 3; ++axis) {
                    blocks_.back().v[3 * c + unsigned(axis)][lane] = polygon.vertices[corner[c]][axis];
                }
                colors_.push_back(polygon.colors[one_color ? 0 : corner[c]]);
            }
            const std::size_t n = colors_.size();
            several_colors_ = several_colors_ || colors_[n - 1] != colors_[n - 3] || colors_[n - 2] != colors_[n - 3];
            ++count_;
        }
    }

    std::vector<TriangleBlock> blocks_;
    std::vector<Rgba8> colors_;
    std::vector<std::uint32_t> first_triangle_;
    std::uint32_t count_ = 0;
    bool several_colors_ = false;
};

}  // namespace farfield::detail
