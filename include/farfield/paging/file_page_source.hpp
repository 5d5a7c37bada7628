// A page file on a disk as a source of pages.
//
// It is read, not mapped. Where a mapped file is cut short, or its disk fails, a touch of its bytes kills the process
// by SIGBUS; and a touch of what is not in memory blocks the thread that draws, which nobody can hurry, cancel or
// count. A read fails with a reason, on a thread that has nothing else to do. The system caches what it reads all the
// same.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <memory>
#include <mutex>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>

#if __has_include(<unistd.h>) && __has_include(<sys/stat.h>)
#define FARFIELD_READS_BY_PREAD 1
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>
#else
#define FARFIELD_READS_BY_PREAD 0
#endif

#include "farfield/fail.hpp"
#include "farfield/paging/page_source.hpp"

namespace farfield {
namespace detail {

[[noreturn]] inline void refuse_page_file(const std::string& name, std::string_view why) {
    fail<std::runtime_error>("farfield::FilePageSource: " + name + ": " + std::string(why));
}

inline ReadResult changed_page_file(const std::string& name, std::string_view how) noexcept {
    return not_read(ReadStatus::changed, {name, ": ", how, " since it was opened: open it again"});
}

#if FARFIELD_READS_BY_PREAD

/// Closes what it holds.
class PageFileDescriptor {
  public:
    explicit PageFileDescriptor(int number) : number_(number) {}
    PageFileDescriptor(PageFileDescriptor&& other) noexcept : number_(std::exchange(other.number_, -1)) {}
    PageFileDescriptor& operator=(PageFileDescriptor&& other) noexcept {
        std::swap(number_, other.number_);
        return *this;
    }
    ~PageFileDescriptor() {
        if (number_ >= 0) ::close(number_);
    }
    int number() const { return number_; }

  private:
    int number_;
};

/// A descriptor, and what the file was when it was opened. Any number of threads read at once.
class PositionedFile {
  public:
    // Without O_NONBLOCK a pipe without a writer would keep open() forever. Regular files do not heed it.
    explicit PositionedFile(const std::filesystem::path& path)
        : name_(path.string()), descriptor_(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK)) {
        struct ::stat status {};
        if (descriptor_.number() < 0 || ::fstat(descriptor_.number(), &status) != 0) {
            refuse_page_file(name_, message_of(errno));
        }
        if (S_ISDIR(status.st_mode)) refuse_page_file(name_, "is a directory");
        if (!S_ISREG(status.st_mode)) refuse_page_file(name_, "is not a regular file");
        opened_ = {std::uint64_t(status.st_size), modified(status)};
    }

    const std::string& name() const { return name_; }
    std::uint64_t size() const { return opened_.size; }

    ReadResult read(std::uint64_t offset, std::span<std::byte> bytes) noexcept {
        while (!bytes.empty()) {
            // Some systems refuse what does not fit an int, others read less.
            const std::size_t count = std::min(bytes.size(), std::size_t(1) << 30);
            const auto got = ::pread(descriptor_.number(), bytes.data(), count, ::off_t(offset));
            if (got < 0 && errno == EINTR) continue;
            if (got < 0) return failed(errno);
            if (got == 0) return changed_page_file(name_, "has been cut short");
            offset += std::uint64_t(got);
            bytes = bytes.subspan(std::size_t(got));
        }
        // Asked after the bytes were read: whoever writes changes the time of the file before he changes its bytes.
        struct ::stat status {};
        if (::fstat(descriptor_.number(), &status) != 0) return failed(errno);
        if (std::uint64_t(status.st_size) < opened_.size) return changed_page_file(name_, "has been cut short");
        if (Opened{std::uint64_t(status.st_size), modified(status)} != opened_) {
            return changed_page_file(name_, "has been written to");
        }
        return {};
    }

  private:
    struct Opened {
        std::uint64_t size = 0;
        std::pair<std::int64_t, std::int64_t> modified{};  ///< seconds and nanoseconds
        friend bool operator==(const Opened&, const Opened&) = default;
    };

    static std::pair<std::int64_t, std::int64_t> modified(const struct ::stat& status) {
#if defined(__APPLE__)
        return {std::int64_t(status.st_mtimespec.tv_sec), std::int64_t(status.st_mtimespec.tv_nsec)};
#else
        return {std::int64_t(status.st_mtim.tv_sec), std::int64_t(status.st_mtim.tv_nsec)};
#endif
    }
    static std::string message_of(int error) {
        return std::generic_category().message(error);
    }
    ReadResult failed(int error) const noexcept {
        // ESTALE: a file system of the network no longer has the file. Whatever else a disk or a network says may pass.
        if (error == ESTALE) return changed_page_file(name_, "has been removed");
        std::string why;
        guarded<std::exception>([&] { why = message_of(error); }, [] {});
        return not_read(ReadStatus::unavailable, {name_, ": cannot be read: ", why});
    }

    std::string name_;
    PageFileDescriptor descriptor_;
    Opened opened_;
};

#endif

/// The same by the standard library alone: one thread reads at a time, and what counts as the file is what goes by its
/// name.
class StreamedFile {
  public:
    explicit StreamedFile(const std::filesystem::path& path) : state_(std::make_unique<State>()) {
        state_->path = path;
        state_->name = path.string();
        std::error_code error;
        const auto status = std::filesystem::status(path, error);
        if (std::filesystem::is_directory(status)) refuse_page_file(name(), "is a directory");
        if (std::filesystem::exists(status) && !std::filesystem::is_regular_file(status)) {
            refuse_page_file(name(), "is not a regular file");
        }
        state_->opened = state_->now(error);
        if (error) refuse_page_file(name(), error.message());
        state_->stream.open(path, std::ios::binary);
        if (!state_->stream) refuse_page_file(name(), "cannot be read");
    }

    const std::string& name() const { return state_->name; }
    std::uint64_t size() const { return state_->opened.size; }

    ReadResult read(std::uint64_t offset, std::span<std::byte> bytes) noexcept {
        bool is_read = false;
        std::error_code error;
        Facts found;
        guarded(
            [&] {
                const std::lock_guard lock(state_->mutex);
                state_->stream.clear();
                state_->stream.seekg(std::streamoff(offset));
                state_->stream.read(reinterpret_cast<char*>(bytes.data()), std::streamsize(bytes.size()));
                is_read = state_->stream.good();
                found = state_->now(error);
            },
            [&] { is_read = false; });
        if (!error && found.size < size()) return changed_page_file(name(), "has been cut short");
        if (error == std::errc::no_such_file_or_directory) return changed_page_file(name(), "has been removed");
        if (error || !is_read) return not_read(ReadStatus::unavailable, {name(), ": cannot be read"});
        if (found != state_->opened) return changed_page_file(name(), "has been written to");
        return {};
    }

  private:
    struct Facts {
        std::uint64_t size = 0;
        std::filesystem::file_time_type modified{};
        friend bool operator==(const Facts&, const Facts&) = default;
    };
    struct State {
        std::filesystem::path path;
        std::string name;
        Facts opened;
        std::mutex mutex;
        std::ifstream stream;

        Facts now(std::error_code& error) const {
            Facts facts;
            const auto size = std::filesystem::file_size(path, error);
            if (!error) facts = {size, std::filesystem::last_write_time(path, error)};
            return facts;
        }
    };
    std::unique_ptr<State> state_;
};

}  // namespace detail

/// Models PageSource. A file that has been cut short or written to since it was opened is found changed by its size and
/// its time, as finely as the system counts that: what was written within some milliseconds of the opening, through a
/// mapping, or with the time set back, only checksums find. A file that was replaced by another of its name, as editors
/// and save() do, goes on as the old one. Reading is unavailable where the disk or the network behind it says so. It
/// can be moved, as long as nobody reads.
class FilePageSource {
  public:
    /// Throws std::runtime_error, which names the file and why, if it cannot be read or is not a regular file. An empty
    /// one has a size of 0.
    explicit FilePageSource(const std::filesystem::path& path) : file_(path) {}

    std::uint64_t size() const noexcept { return file_.size(); }

    /// Measured on a disk that gives a page of 64 KiB in 140 microseconds: two reads take twice as long as one over a
    /// gap of up to 64 KiB, no longer than one from 128 KiB on; a page that the system keeps takes 4, and a gap of 64
    /// KiB 3 more. Four threads get 2.3 times the bytes of one, eight little more.
    ReadMerging merging() const noexcept {
        return {.largest_gap = 64u << 10, .largest_read = 1u << 20, .most_reads_at_once = 4};
    }

    ReadResult read(std::uint64_t offset, std::span<std::byte> bytes) noexcept {
        if (!detail::lies_within(size(), offset, bytes.size())) {
            return detail::beyond_the_end(file_.name(), size(), offset, bytes.size());
        }
        return bytes.empty() ? ReadResult{} : file_.read(offset, bytes);
    }

  private:
#if FARFIELD_READS_BY_PREAD
    detail::PositionedFile file_;
#else
    detail::StreamedFile file_;
#endif
};

static_assert(PageSource<FilePageSource>);

}  // namespace farfield
