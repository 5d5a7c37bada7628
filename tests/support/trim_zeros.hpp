// A codec of pages, for tests.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

namespace farfield::test {

/// Leaves out the zeros that a page ends with, and nothing else.
struct TrimZeros {
    static constexpr std::uint32_t file_tag = 0x5a45524fu;
    static constexpr const char* name = "trim";
    std::size_t pack(std::span<const std::byte> from, std::span<std::byte> to) const {
        std::size_t size = from.size();
        while (size > 1 && from[size - 1] == std::byte(0)) --size;
        if (size > to.size()) return 0;
        std::memcpy(to.data(), from.data(), size);
        return size;
    }
    bool unpack(std::span<const std::byte> from, std::span<std::byte> to) const noexcept {
        if (from.size() > to.size()) return false;
        std::memset(to.data(), 0, to.size());
        std::memcpy(to.data(), from.data(), from.size());
        return true;
    }
};

}  // namespace farfield::test
