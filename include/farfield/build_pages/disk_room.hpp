// Room on the disk for a build outside of memory: what it takes is known before anything is moved.
#pragma once

#include "farfield/settings.hpp"

#include <cstdint>
#include <filesystem>
#include <string>
#include <system_error>

#include "farfield/storage/mapped_file.hpp"

namespace farfield {

/// Bytes of the disk that a build takes at most, roughly, or a share of so many primitives: as much as they take
/// themselves in a temporary file, and the pages.
template <class P>
constexpr std::uint64_t disk_bytes_of_build(std::uint64_t primitives) {
    return primitives * (sizeof(P) + sizeof(P) + sizeof(P) / 8);
}

namespace detail {

/// Throws std::runtime_error that names the file to be if there is no room for it: on its disk, as far as the system
/// says, or in `most_bytes`.
inline void check_disk_room(const std::filesystem::path& path, std::uint64_t needed, std::uint64_t most_bytes) {
    const auto refuse = [&](const char* has, std::uint64_t bytes, const char* after) {
        // Rounded so that what is refused never looks as if it fitted.
        refuse_file("build_pages", path,
                    "needs about " + std::to_string((needed >> 20) + 1) + " MiB of the disk, and " + has + " " +
                        std::to_string(bytes >> 20) + after);
    };
    if (needed > most_bytes) refuse("may take", most_bytes, " (most_disk_bytes)");
    std::error_code error;
    const std::filesystem::path folder = path.parent_path();
    const std::filesystem::space_info space = std::filesystem::space(folder.empty() ? "." : folder, error);
    if (!error && needed > space.available) refuse("there are", space.available, " left");
}

}  // namespace detail
}  // namespace farfield
