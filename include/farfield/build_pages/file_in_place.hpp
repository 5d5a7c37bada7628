// A file of a build that is written in place, by any number of threads, and stays when something goes wrong: the next
// build goes on with it.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <mutex>
#include <span>
#include <string>

#include "farfield/storage/mapped_file.hpp"

namespace farfield::detail {

/// Throws std::runtime_error that names the file wherever it cannot do what it is asked to.
class FileInPlace {
  public:
    FileInPlace(const std::filesystem::path& path, bool is_new) : path_(path) {
#if FARFIELD_MAPS_FILES
        file_ = ::open(path.c_str(), O_RDWR | O_CLOEXEC | (is_new ? O_CREAT | O_TRUNC : 0), 0666);
        const bool is_open = file_ >= 0;
#else
        file_ = std::fopen(path.string().c_str(), is_new ? "w+b" : "r+b");
        const bool is_open = file_ != nullptr;
#endif
        if (!is_open) refuse_file("build_pages", path_, "cannot be opened: " + system_message(errno));
    }
    ~FileInPlace() {
#if FARFIELD_MAPS_FILES
        ::close(file_);
#else
        std::fclose(file_);
#endif
    }
    FileInPlace(const FileInPlace&) = delete;
    FileInPlace& operator=(const FileInPlace&) = delete;

    /// Nothing of it is left in this process: a kill right afterwards loses none of it.
    void write_at(std::uint64_t offset, std::span<const std::byte> bytes) {
#if FARFIELD_MAPS_FILES
        while (!bytes.empty()) {
            const auto done = ::pwrite(file_, bytes.data(), std::min(bytes.size(), most_at_once), ::off_t(offset));
            if (done < 0 && errno == EINTR) continue;
            if (done <= 0) refuse_to_write();
            offset += std::uint64_t(done);
            bytes = bytes.subspan(std::size_t(done));
        }
#else
        const std::lock_guard lock(mutex_);
        const bool is_written = std::fseek(file_, long(offset), SEEK_SET) == 0 &&
                                std::fwrite(bytes.data(), 1, bytes.size(), file_) == bytes.size();
        if (!is_written || std::fflush(file_) != 0) refuse_to_write();
#endif
    }
    void read_at(std::uint64_t offset, std::span<std::byte> bytes) {
        if (!reads_at(offset, bytes)) refuse_file("build_pages", path_, "cannot be read, or is shorter than it was");
    }
    /// False if there is less than that.
    bool reads_at(std::uint64_t offset, std::span<std::byte> bytes) {
#if FARFIELD_MAPS_FILES
        while (!bytes.empty()) {
            const auto done = ::pread(file_, bytes.data(), std::min(bytes.size(), most_at_once), ::off_t(offset));
            if (done < 0 && errno == EINTR) continue;
            if (done <= 0) return false;
            offset += std::uint64_t(done);
            bytes = bytes.subspan(std::size_t(done));
        }
        return true;
#else
        const std::lock_guard lock(mutex_);
        return std::fseek(file_, long(offset), SEEK_SET) == 0 &&
               std::fread(bytes.data(), 1, bytes.size(), file_) == bytes.size();
#endif
    }
    /// Everything is on the disk when it returns.
    void sync() {
#if FARFIELD_MAPS_FILES
        if (::fsync(file_) != 0) refuse_to_write();
#else
        if (std::fflush(file_) != 0) refuse_to_write();
#endif
    }
    /// What has been written there will not be written again before sync(), so the disk may begin with it.
    void begin_to_sync([[maybe_unused]] std::uint64_t offset, [[maybe_unused]] std::uint64_t bytes) const {
#if defined(SYNC_FILE_RANGE_WRITE)
        static_cast<void>(::sync_file_range(file_, ::off64_t(offset), ::off64_t(bytes), SYNC_FILE_RANGE_WRITE));
#endif
    }
    /// What lies there is of no use any more, and reads as zeros, or as it was: what has not come to the disk yet need
    /// not, and the disk has its room again.
    void forget([[maybe_unused]] std::uint64_t offset, [[maybe_unused]] std::uint64_t bytes) const {
#if defined(FALLOC_FL_PUNCH_HOLE)
        if (bytes == 0) return;
        static_cast<void>(
            ::fallocate(file_, FALLOC_FL_PUNCH_HOLE | FALLOC_FL_KEEP_SIZE, ::off_t(offset), ::off_t(bytes)));
#endif
    }

  private:
    [[noreturn]] void refuse_to_write() const {
        refuse_file("build_pages", path_, "cannot be written: " + system_message(errno));
    }

    /// Some systems refuse what does not fit an int.
    static constexpr std::size_t most_at_once = std::size_t(1) << 30;

    std::filesystem::path path_;
#if FARFIELD_MAPS_FILES
    int file_ = -1;
#else
    std::FILE* file_ = nullptr;
    std::mutex mutex_;
#endif
};

}  // namespace farfield::detail
