// Random numbers for the generators. The distributions of <random> differ between standard libraries; these
// do not, so that a seed names one scene everywhere.
#pragma once

#include <cmath>
#include <cstdint>
#include <glm/vec3.hpp>

namespace farfield::scenes {

/// SplitMix64: Steele, Lea, Flood, "Fast splittable pseudorandom number generators", OOPSLA 2014, figure 16.
class Random {
  public:
    explicit Random(std::uint64_t seed) : state_(seed) {}

    std::uint64_t bits() {
        std::uint64_t z = (state_ += 0x9e3779b97f4a7c15u);
        z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
        z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
        return z ^ (z >> 31);
    }

    /// In [0, 1), a multiple of 2^-24, so exact in float.
    float unit() { return static_cast<float>(bits() >> 40) * 0x1p-24f; }
    float between(float low, float high) { return low + (high - low) * unit(); }
    /// In [0, count); count > 0. The bias is below count / 2^64.
    std::uint64_t below(std::uint64_t count) { return bits() % count; }

    /// Uniform on the unit sphere (Archimedes: height and azimuth are independent).
    glm::vec3 direction() {
        const float y = between(-1.0f, 1.0f);
        const float azimuth = between(0.0f, 6.2831853f);
        const float horizontal = std::sqrt(1.0f - y * y);
        return {horizontal * std::cos(azimuth), y, horizontal * std::sin(azimuth)};
    }

  private:
    std::uint64_t state_;
};

/// A fixed value in [0, 1) for a lattice point: the noise of the terrain.
inline float lattice_value(std::int32_t x, std::int32_t z, std::uint64_t seed) {
    const std::uint64_t key = (std::uint64_t(static_cast<std::uint32_t>(x)) << 32) | static_cast<std::uint32_t>(z);
    return Random(Random(key ^ (seed * 0xd1342543de82ef95u)).bits()).unit();
}

}  // namespace farfield::scenes
