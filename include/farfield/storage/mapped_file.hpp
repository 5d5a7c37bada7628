// A whole file as bytes in memory: mapped where the system can do that, else read.
#pragma once

#include "farfield/settings.hpp"

#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <limits>
#include <memory>
#include <span>
#include <stdexcept>
#include <string>
#include <system_error>
#include <vector>

#if __has_include(<sys/mman.h>) && __has_include(<unistd.h>)
#define FARFIELD_MAPS_FILES 1
#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>
#else
#define FARFIELD_MAPS_FILES 0
#include <fstream>
#endif

#include "farfield/fail.hpp"

namespace farfield::detail {

[[noreturn]] inline void refuse_file(const char* function, const std::filesystem::path& path, const std::string& why) {
    detail::fail<std::runtime_error>(std::string("farfield::") + function + ": " + path.string() + ": " + why);
}

inline std::string system_message(int error) {
    return std::generic_category().message(error);
}

/// Bytes aligned to 64 at least. `memory` keeps them alive.
struct FileBytes {
    std::shared_ptr<const void> memory;
    std::span<const std::byte> bytes;
};

struct alignas(64) FileLine {
    std::byte bytes[64];
};

inline FileBytes aligned_copy(std::span<const std::byte> bytes) {
    const auto lines = std::make_shared<std::vector<FileLine>>(bytes.size() / sizeof(FileLine) + 1);
    if (!bytes.empty()) std::memcpy(lines->data(), bytes.data(), bytes.size());
    return {lines, {reinterpret_cast<const std::byte*>(lines->data()), bytes.size()}};
}

/// Throws std::runtime_error if the file cannot be read or is not a regular one.
inline FileBytes file_bytes(const std::filesystem::path& path) {
#if FARFIELD_MAPS_FILES
    struct Descriptor {
        int number;
        ~Descriptor() {
            if (number >= 0) ::close(number);
        }
    };
    // Without O_NONBLOCK a pipe without a writer would keep open() forever.
    const Descriptor file{::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK)};
    struct ::stat status {};
    if (file.number < 0 || ::fstat(file.number, &status) != 0) refuse_file("open", path, system_message(errno));
    if (S_ISDIR(status.st_mode)) refuse_file("open", path, "is a directory");
    if (!S_ISREG(status.st_mode)) refuse_file("open", path, "is not a regular file");
    if (std::uint64_t(status.st_size) > std::numeric_limits<std::size_t>::max()) {
        refuse_file("open", path, "does not fit this machine's addresses");
    }
    const auto size = std::size_t(status.st_size);
    if (size == 0) return {};
    void* const start = ::mmap(nullptr, size, PROT_READ, MAP_SHARED, file.number, 0);
    if (start == MAP_FAILED) refuse_file("open", path, "cannot be mapped: " + system_message(errno));
    return {std::shared_ptr<const void>(start, [size](void* p) { ::munmap(p, size); }),
            {static_cast<const std::byte*>(start), size}};
#else
    std::error_code error;
    if (std::filesystem::is_directory(path, error)) refuse_file("open", path, "is a directory");
    const std::uintmax_t size = std::filesystem::file_size(path, error);
    if (error) refuse_file("open", path, error.message());
    if (size > std::numeric_limits<std::size_t>::max() - sizeof(FileLine)) {
        refuse_file("open", path, "does not fit this machine's addresses");
    }
    const auto lines = std::make_shared<std::vector<FileLine>>(std::size_t(size) / sizeof(FileLine) + 1);
    std::ifstream in(path, std::ios::binary);
    in.read(reinterpret_cast<char*>(lines->data()), std::streamsize(size));
    if (!in) refuse_file("open", path, "cannot be read");
    return {lines, {reinterpret_cast<const std::byte*>(lines->data()), std::size_t(size)}};
#endif
}

}  // namespace farfield::detail
