// The bytes of a fuzzer as decisions: whoever asks for more than there are gets zeros, so every input is one.
#pragma once

#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <span>

namespace farfield::fuzz {

class Input {
  public:
    explicit Input(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}

    bool is_empty() const { return bytes_.empty(); }
    std::uint8_t byte() {
        if (bytes_.empty()) return 0;
        const std::uint8_t b = bytes_.front();
        bytes_ = bytes_.subspan(1);
        return b;
    }
    std::uint32_t bits() {
        std::uint32_t b = 0;
        for (int i = 0; i < 4; ++i) b = b << 8 | byte();
        return b;
    }
    /// 0 ... n - 1, n at most 256.
    unsigned below(unsigned n) { return byte() * n >> 8; }
    bool one_in(unsigned n) { return below(n) == n - 1; }
    /// [-1, 1], 16 bits; 0 and the ends come often, for much goes wrong there.
    float coordinate() {
        const unsigned kind = byte();
        if (kind < 16) return float(int(kind % 3) - 1);
        const int high = byte();
        return float(high * 256 + byte() - 0x8000) * 0x1p-15f;
    }
    glm::vec3 point() {
        const float x = coordinate(), y = coordinate(), z = coordinate();
        return {x, y, z};
    }
    /// 2^-limit ... 2^limit, 1 in half of all cases.
    double power_of_two(int limit) {
        const unsigned b = byte();
        return b < 128 ? 1.0 : std::ldexp(1.0, int(b - 128) * (2 * limit + 1) / 128 - limit);
    }
    /// Any finite float.
    float finite() {
        const float f = std::bit_cast<float>(bits());
        return std::isfinite(f) ? f : 0.0f;
    }

  private:
    std::span<const std::uint8_t> bytes_;
};

}  // namespace farfield::fuzz
