// The 64-bit hash by which a damaged file is found: XXH64 by Yann Collet, after its published specification
// (github.com/Cyan4973/xxHash, doc/xxhash_spec.md). It finds accidents; it is no protection from a forger.
#pragma once

#include "farfield/settings.hpp"

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

namespace farfield::detail {

class Xxh64 {
  public:
    /// The hash with seed 0, in the machine's own byte order: files of the other order are refused before.
    static std::uint64_t of(std::span<const std::byte> bytes) {
        const std::byte* p = bytes.data();
        std::size_t left = bytes.size();
        std::uint64_t hash = prime5;
        if (left >= 32) {
            std::uint64_t lanes[4] = {prime1 + prime2, prime2, 0, 0 - prime1};
            for (; left >= 32; left -= 32) {
                for (std::uint64_t& lane : lanes) lane = round(lane, read<std::uint64_t>(p));
            }
            hash = std::rotl(lanes[0], 1) + std::rotl(lanes[1], 7) + std::rotl(lanes[2], 12) + std::rotl(lanes[3], 18);
            for (const std::uint64_t lane : lanes) hash = (hash ^ round(0, lane)) * prime1 + prime4;
        }
        hash += bytes.size();
        for (; left >= 8; left -= 8) {
            hash = std::rotl(hash ^ round(0, read<std::uint64_t>(p)), 27) * prime1 + prime4;
        }
        if (left >= 4) {
            hash = std::rotl(hash ^ read<std::uint32_t>(p) * prime1, 23) * prime2 + prime3;
            left -= 4;
        }
        for (; left > 0; --left) hash = std::rotl(hash ^ read<std::uint8_t>(p) * prime5, 11) * prime1;
        hash = (hash ^ hash >> 33) * prime2;
        hash = (hash ^ hash >> 29) * prime3;
        return hash ^ hash >> 32;
    }

  private:
    static constexpr std::uint64_t prime1 = 0x9e3779b185ebca87u, prime2 = 0xc2b2ae3d27d4eb4fu,
                                   prime3 = 0x165667b19e3779f9u, prime4 = 0x85ebca77c2b2ae63u,
                                   prime5 = 0x27d4eb2f165667c5u;

    static std::uint64_t round(std::uint64_t lane, std::uint64_t word) {
        return std::rotl(lane + word * prime2, 31) * prime1;
    }
    template <class T>
    static std::uint64_t read(const std::byte*& p) {
        T v;
        std::memcpy(&v, p, sizeof v);
        p += sizeof v;
        return v;
    }
};

}  // namespace farfield::detail
