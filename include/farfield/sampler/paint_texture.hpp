// A textured polygon is sent to a build as pieces of one color each, so that leaves' alpha becomes area, and walls the
// colors of their texels, in whatever is made of polygons.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <span>

#include "farfield/geometry/box.hpp"
#include "farfield/geometry/length.hpp"
#include "farfield/geometry/polygon.hpp"
#include "farfield/geometry/rgba8.hpp"
#include "farfield/sampler/texture_levels.hpp"

namespace farfield {

namespace detail {

/// A convex polygon in space and in a texture at once. Cut by lines of the texture's grid and by a box's planes.
class TexturedPiece {
  public:
    struct Corner {
        glm::vec3 position;
        glm::vec2 at;  ///< in texture coordinates
    };

    TexturedPiece() = default;
    explicit TexturedPiece(const std::array<Corner, 3>& triangle) {
        for (const Corner& c : triangle) push(c);
    }

    bool is_empty() const { return count_ < 3; }
    std::span<const Corner> corners() const { return {corners_.data(), count_}; }

    /// What lies where height(corner) is at least 0.
    template <class Height>
    TexturedPiece cut(Height&& height) const {
        TexturedPiece out;
        for (std::size_t i = 0; i < count_; ++i) {
            const Corner &a = corners_[i], &b = corners_[i + 1 < count_ ? i + 1 : 0];
            const float h = height(a), k = height(b);
            if (h >= 0) out.push(a);
            if ((h >= 0) != (k >= 0)) {
                const float t = h / (h - k);
                out.push({a.position + (b.position - a.position) * t, a.at + (b.at - a.at) * t});
            }
        }
        return out;
    }
    TexturedPiece inside(const Box& box) const {
        TexturedPiece piece = *this;
        for (int axis = 0; axis < 3; ++axis) {
            piece = piece.cut([&](const Corner& c) { return c.position[axis] - box.lower[axis]; });
            piece = piece.cut([&](const Corner& c) { return box.upper[axis] - c.position[axis]; });
        }
        return piece;
    }
    /// What lies between two coordinates along one of the texture's axes.
    TexturedPiece between(int axis, float lower, float upper) const {
        return cut([&](const Corner& c) { return c.at[axis] - lower; }).cut([&](const Corner& c) {
            return upper - c.at[axis];
        });
    }
    /// The least and the largest coordinate along that axis.
    std::array<float, 2> reach(int axis) const {
        std::array<float, 2> reach{corners_[0].at[axis], corners_[0].at[axis]};
        for (const Corner& c : corners()) {
            reach[0] = std::min(reach[0], c.at[axis]);
            reach[1] = std::max(reach[1], c.at[axis]);
        }
        return reach;
    }

    template <class Sink>
    void send(Rgba8 color, bool is_lit, Sink&& sink) const {
        if (is_empty() || color.a == 0) return;
        std::array<glm::vec3, capacity> positions;
        for (std::size_t i = 0; i < count_; ++i) positions[i] = corners_[i].position;
        sink(Polygon{{positions.data(), count_}, {&color, 1}, is_lit});
    }

  private:
    static constexpr std::size_t capacity = 16;  // a triangle, and one more corner for each of ten cuts

    void push(const Corner& c) {
        if (count_ < capacity) corners_[count_++] = c;
    }

    std::array<Corner, capacity> corners_;
    std::size_t count_ = 0;
};

/// The level whose texels are just smaller than `finest` in space, and that has not too many of them.
template <SomeTexture T>
int level_of_detail(const T& texture, const std::array<TexturedPiece::Corner, 3>& triangle, glm::vec2 reach,
                    float finest) {
    constexpr double most_texels = 1 << 14;
    const glm::vec3 e1 = triangle[1].position - triangle[0].position, e2 = triangle[2].position - triangle[0].position;
    const glm::vec2 d1 = triangle[1].at - triangle[0].at, d2 = triangle[2].at - triangle[0].at;
    const float doubled = d1.x * d2.y - d1.y * d2.x;
    const float across = length_of((e1 * d2.y - e2 * d1.y) / doubled),
                down = length_of((e2 * d1.x - e1 * d2.x) / doubled);
    int level = texture.levels() - 1;
    while (level > 0) {
        const glm::ivec2 size = texture.size(level - 1), now = texture.size(level);
        const bool is_fine = across <= finest * float(now.x) && down <= finest * float(now.y);
        const bool fits = double(reach.x) * size.x * double(reach.y) * size.y <= most_texels &&
                          double(reach.y) * size.y <= most_texels;
        if (is_fine || !fits) break;
        --level;
    }
    return level;
}

/// The texels [first, end) that coordinates lie in, at least one.
inline std::array<int, 2> texels_between(const std::array<float, 2>& coordinates, int size) {
    const auto bounded = [](float v) { return int(std::clamp(v, -0x1p30f, 0x1p30f)); };
    const int first = bounded(std::floor(coordinates[0] * float(size)));
    return {first, std::max(bounded(std::ceil(coordinates[1] * float(size))), first + 1)};
}

}  // namespace detail

/// Calls sink(Polygon) with the pieces of a polygon that its texture's texels cover, those of one color in a row
/// together, cut off at the box `seen`; texels that are transparent leave gaps. `at` has the texture coordinates of
/// each vertex. Texels are taken as coarse as `finest` allows, means of color and alpha. The polygon's own colors are
/// not used.
///
/// Where there is no texture, where coordinates are too few, or one is NaN or infinite, the polygon is sent as it is.
template <SomeTexture T, class Sink>
void paint_texture(const Polygon& polygon, std::span<const glm::vec2> at, const T& texture, const Box& seen,
                   float finest, Sink&& sink) {
    using Piece = detail::TexturedPiece;
    const std::size_t corners = polygon.vertices.size();
    glm::vec2 zero(0);
    for (std::size_t i = 0; i < std::min(corners, at.size()); ++i) zero += at[i] * 0.0f;
    if (at.size() < corners || texture.levels() <= 0 || zero != glm::vec2(0)) return sink(polygon);
    for_each_triangle(corners, [&](std::size_t a, std::size_t b, std::size_t c) {
        const std::array<Piece::Corner, 3> triangle{
            {{polygon.vertices[a], at[a]}, {polygon.vertices[b], at[b]}, {polygon.vertices[c], at[c]}}};
        const Piece piece = Piece(triangle).inside(seen);
        if (piece.is_empty()) return;
        const auto u = piece.reach(0), v = piece.reach(1);
        const int level = detail::level_of_detail(texture, triangle, {u[1] - u[0], v[1] - v[0]}, finest);
        const glm::ivec2 size = texture.size(level);
        if (size == glm::ivec2(1)) return piece.send(texture.texel(level, 0, 0), polygon.is_lit, sink);
        const auto rows = detail::texels_between(v, size.y);
        for (int row = rows[0]; row < rows[1]; ++row) {
            const Piece strip = rows[1] - rows[0] == 1
                                    ? piece
                                    : piece.between(1, float(row) / float(size.y), float(row + 1) / float(size.y));
            if (strip.is_empty()) continue;
            const auto columns = detail::texels_between(strip.reach(0), size.x);
            for (int begin = columns[0], end; begin < columns[1]; begin = end) {
                const Rgba8 color = texture.texel(level, begin, row);
                for (end = begin + 1; end < columns[1] && texture.texel(level, end, row) == color;) ++end;
                if (color.a == 0) continue;
                if (end - begin == columns[1] - columns[0]) {
                    strip.send(color, polygon.is_lit, sink);
                } else {
                    strip.between(0, float(begin) / float(size.x), float(end) / float(size.x))
                        .send(color, polygon.is_lit, sink);
                }
            }
        }
    });
}

}  // namespace farfield
