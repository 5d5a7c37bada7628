// A texture at all resolutions, as a sampler looks it up: means over whole texels, by area, alpha weighing colors.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <span>
#include <stdexcept>
#include <vector>

#include "farfield/fail.hpp"
#include "farfield/geometry/rgba8.hpp"

namespace farfield {

/// The coordinates (0, 0) to (1, 1) are covered once by each level's texels, and by the coarsest by one; beyond them
/// columns and rows, which may be any number, go on as the texture does: repeated, or as its border. Colors are not
/// premultiplied.
template <class T>
concept SomeTexture = requires(const T& t, int level, int column, int row) {
    { t.levels() } -> std::convertible_to<int>;  // 0: there is no texture
    { t.size(level) } -> std::same_as<glm::ivec2>;
    { t.texel(level, column, row) } -> std::same_as<Rgba8>;
};

/// Repeats beyond its borders. Sizes need not be powers of two: each level has half the columns and rows of the last,
/// rounded down, and its texels are means over whole areas.
class TextureLevels {
  public:
    TextureLevels() = default;
    /// Rows from v = 0 on. Throws std::invalid_argument if there are not width * height texels. A width or height of 0
    /// makes no texture.
    TextureLevels(int width, int height, std::span<const Rgba8> texels) {
        if (width < 0 || height < 0 || texels.size() != std::size_t(width) * std::size_t(height)) {
            detail::fail<std::invalid_argument>("farfield::TextureLevels: there must be width * height texels");
        }
        if (texels.empty()) return;
        levels_.push_back({{width, height}, {}});
        std::vector<glm::vec4> sums;
        for (const Rgba8 c : texels) {
            const glm::vec4 v = to_vec4(c);
            sums.emplace_back(glm::vec3(v) * v.w, v.w);
        }
        levels_.back().texels.assign(texels.begin(), texels.end());
        for (glm::ivec2 size(width, height); size != glm::ivec2(1);) {
            const glm::ivec2 half(std::max(size.x / 2, 1), std::max(size.y / 2, 1));
            sums = means(sums, size, half);
            size = half;
            levels_.push_back({size, {}});
            for (const glm::vec4& c : sums) levels_.back().texels.push_back(color_of(c));
        }
    }

    int levels() const { return int(levels_.size()); }
    glm::ivec2 size(int level) const { return levels_[std::size_t(level)].size; }
    Rgba8 texel(int level, int column, int row) const {
        const Level& l = levels_[std::size_t(level)];
        return l.texels[std::size_t(wrapped(row, l.size.y)) * std::size_t(l.size.x) +
                        std::size_t(wrapped(column, l.size.x))];
    }

  private:
    struct Level {
        glm::ivec2 size;
        std::vector<Rgba8> texels;
    };

    static int wrapped(int i, int size) {
        const int rest = i % size;
        return rest < 0 ? rest + size : rest;
    }
    static Rgba8 color_of(glm::vec4 premultiplied) {
        if (!(premultiplied.w > 0)) return {0, 0, 0, 0};
        return to_rgba8(glm::vec4(glm::vec3(premultiplied) / premultiplied.w, premultiplied.w));
    }

    static std::vector<glm::vec4> means(const std::vector<glm::vec4>& from, glm::ivec2 size, glm::ivec2 half) {
        std::vector<glm::vec4> rows(std::size_t(half.x) * std::size_t(size.y)),
            all(std::size_t(half.x) * std::size_t(half.y));
        for (int y = 0; y < size.y; ++y) {
            for (int x = 0; x < half.x; ++x) {
                rows[at(x, y, half.x)] =
                    mean_along(x, size.x, half.x, [&](int column) { return from[at(column, y, size.x)]; });
            }
        }
        for (int y = 0; y < half.y; ++y) {
            for (int x = 0; x < half.x; ++x) {
                all[at(x, y, half.x)] =
                    mean_along(y, size.y, half.y, [&](int row) { return rows[at(x, row, half.x)]; });
            }
        }
        return all;
    }
    static std::size_t at(int x, int y, int width) { return std::size_t(y) * std::size_t(width) + std::size_t(x); }
    /// Over the i-th of `parts` equal parts of `size` values.
    template <class Value>
    static glm::vec4 mean_along(int i, int size, int parts, Value&& value) {
        const float step = float(size) / float(parts), begin = float(i) * step, end = begin + step;
        glm::vec4 sum(0);
        for (int k = int(begin); k < std::min(int(std::ceil(end)), size); ++k) {
            const float part = std::min(end, float(k + 1)) - std::max(begin, float(k));
            sum += value(k) * std::max(part, 0.0f);
        }
        return sum * (1 / step);
    }

    std::vector<Level> levels_;  ///< the finest first
};

}  // namespace farfield
