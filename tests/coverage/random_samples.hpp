// Frames of random samples, 8 x 8 a pixel, and the pieces that they come in: every sample once, in random order.
#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "farfield/geometry/rgba8.hpp"
#include "support/random.hpp"

namespace farfield::test {

struct RandomSamples {
    struct Piece {
        enum Kind { samples, pixels, rectangle } kind;
        int x, y, width, height;  ///< the latter two of rectangles
        std::uint64_t mask;       ///< of samples or pixels
        Rgba8 color;
    };

    int width, height;
    std::vector<Rgba8> color;  ///< of samples, row by row
    std::vector<Piece> pieces;

    RandomSamples(int w, int h, Random& random) : width(w), height(h), color(std::size_t(w) * std::size_t(h) * 64) {
        for (int y = 0; y < h; y += 64) {
            for (int x = 0; x < w; x += 64) {
                if (random.below(4) == 0) {
                    add({Piece::rectangle, x, y, 64, 64, 0, any_color(random)});
                } else {
                    for (int j = y; j < std::min(y + 64, h); j += 8) {
                        for (int i = x; i < std::min(x + 64, w); i += 8) add_block(i, j, random);
                    }
                }
            }
        }
        random.shuffle(pieces);
    }

    Rgba8 at(int x, int y) const { return color[std::size_t(y) * std::size_t(width * 8) + std::size_t(x)]; }

    /// A frame, but for begin() and resolve().
    template <class Filter>
    void draw(Filter& filter) const {
        std::vector<bool> seen(std::size_t(width) * std::size_t(height));
        for (const Piece& p : pieces) {
            if (p.kind == Piece::rectangle) {
                filter.fill(p.x, p.y, p.width, p.height, p.color);
            } else if (p.kind == Piece::pixels) {
                filter.fill_pixels(p.x, p.y, p.mask, p.color);
            } else {
                auto pixel = seen.begin() + p.y * width + p.x;
                filter.add(p.x, p.y, p.mask, p.color, !*pixel);
                *pixel = true;
            }
        }
    }

    static Rgba8 any_color(Random& random) {
        Rgba8 c = random.color();
        c.a = std::uint8_t(random.below(256));
        if (random.below(4) == 0) c = {255, 255, 255, 255};
        if (random.below(8) == 0) c = {0, 0, 0, 0};
        return c;
    }

  private:
    void add_block(int x, int y, Random& random) {
        if (random.below(3) == 0) return add({Piece::rectangle, x, y, 8, 8, 0, any_color(random)});
        std::uint64_t inside = 0;
        for (int j = 0; j < std::min(8, height - y); ++j) {
            for (int i = 0; i < std::min(8, width - x); ++i) inside |= std::uint64_t(1) << (8 * j + i);
        }
        const std::uint64_t a = random.bits(), b = random.bits(), c = random.bits();
        const std::uint64_t whole = inside & (a | b);
        if ((whole & c) != 0) add({Piece::pixels, x, y, 0, 0, whole & c, any_color(random)});
        if ((whole & ~c) != 0) add({Piece::pixels, x, y, 0, 0, whole & ~c, any_color(random)});
        for (std::uint64_t rest = inside & ~whole; rest != 0; rest &= rest - 1) {
            const int k = std::countr_zero(rest);
            for (std::uint64_t left = ~std::uint64_t(0); left != 0;) {
                const std::uint64_t d = random.bits();
                const std::uint64_t mask = random.below(4) == 0 ? left : left & d;
                if (mask != 0) add({Piece::samples, x + k % 8, y + k / 8, 0, 0, mask, any_color(random)});
                left &= ~mask;
            }
        }
    }

    void add(const Piece& p) {
        pieces.push_back(p);
        const auto set = [&](int x, int y) {
            color[std::size_t(y) * std::size_t(width * 8) + std::size_t(x)] = p.color;
        };
        if (p.kind == Piece::rectangle) {
            for (int y = p.y * 8; y < std::min(p.y + p.height, height) * 8; ++y) {
                for (int x = p.x * 8; x < std::min(p.x + p.width, width) * 8; ++x) set(x, y);
            }
            return;
        }
        for (std::uint64_t mask = p.mask; mask != 0; mask &= mask - 1) {
            const int k = std::countr_zero(mask);
            if (p.kind == Piece::samples) {
                set(p.x * 8 + k % 8, p.y * 8 + k / 8);
            } else {
                for (int i = 0; i < 64; ++i) set((p.x + k % 8) * 8 + i % 8, (p.y + k / 8) * 8 + i / 8);
            }
        }
    }
};

}  // namespace farfield::test
