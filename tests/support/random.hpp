// Random numbers that are the same everywhere, always: splitmix64 (Steele, Lea, Flood 2014), never the clock.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <utility>
#include <vector>

#include "farfield/geometry/rgba8.hpp"

namespace farfield::test {

class Random {
  public:
    explicit Random(std::uint64_t seed) : state_(seed) {}

    std::uint64_t bits() {
        std::uint64_t z = (state_ += 0x9e3779b97f4a7c15u);
        z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9u;
        z = (z ^ z >> 27) * 0x94d049bb133111ebu;
        return z ^ z >> 31;
    }
    /// 0 ... n - 1.
    std::uint32_t below(std::uint32_t n) { return std::uint32_t((bits() >> 32) * n >> 32); }
    /// [0, 1), 24 bits.
    float unit() { return float(bits() >> 40) * 0x1p-24f; }
    float between(float a, float b) { return a + (b - a) * unit(); }
    glm::vec3 in_cube(float half) {
        const float x = between(-half, half), y = between(-half, half), z = between(-half, half);
        return {x, y, z};
    }
    glm::vec3 direction() {
        while (true) {
            const glm::vec3 v = in_cube(1);
            const float l = glm::length(v);
            if (l > 0.1f && l <= 1) return v / l;
        }
    }
    Rgba8 color() {
        const std::uint64_t b = bits();
        return {std::uint8_t(b), std::uint8_t(b >> 8), std::uint8_t(b >> 16), 255};
    }
    template <class T>
    void shuffle(std::vector<T>& v) {
        for (std::size_t i = v.size(); i > 1; --i) std::swap(v[i - 1], v[below(std::uint32_t(i))]);
    }

  private:
    std::uint64_t state_;
};

}  // namespace farfield::test
