#include "large_blocks.hpp"

#include <array>
#include <atomic>
#include <cerrno>
#include <cstddef>
#include <cstdlib>
#include <mutex>
#include <new>
#include <string>

#if __has_include(<sys/mman.h>) && __has_include(<unistd.h>)
#define MAPS_FILES 1
#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>
#else
#define MAPS_FILES 0
#endif

namespace farfield::scenes {
namespace {

constexpr std::size_t least_bytes = std::size_t(4) << 20;

struct Block {
    void* begin = nullptr;
    std::size_t bytes = 0;
};

/// It must not allocate: it is what allocates.
class Blocks {
  public:
    bool is_on() const { return is_on_.load(std::memory_order_acquire); }
    void turn_on(const std::filesystem::path& folder) {
        const std::string name = (folder / "farfield-XXXXXX").string();
        if (name.size() >= name_.size()) return;
        name.copy(name_.data(), name.size());
        is_on_.store(true, std::memory_order_release);
    }
    void turn_off() { is_on_.store(false, std::memory_order_release); }
    int error() const { return error_.load(std::memory_order_relaxed); }
    std::uint64_t bytes() const { return bytes_.load(std::memory_order_relaxed); }

    /// Null if it cannot be.
    void* take([[maybe_unused]] std::size_t bytes) {
#if MAPS_FILES
        std::array<char, 4096> name = name_;
        const int file = ::mkstemp(name.data());
        if (file < 0) return refuse(errno);
        ::unlink(name.data());
        // Its room is taken now: a disk that is full later would end the program by SIGBUS.
        void* begin = MAP_FAILED;
        int error = ::posix_fallocate(file, 0, ::off_t(bytes));
        if (error == 0) {
            begin = ::mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
            if (begin == MAP_FAILED) error = errno;
        }
        ::close(file);
        if (begin == MAP_FAILED) return refuse(error);
        const std::lock_guard lock(mutex_);
        for (Block& b : blocks_) {
            if (b.begin != nullptr) continue;
            b = {begin, bytes};
            bytes_ += bytes;
            return begin;
        }
        ::munmap(begin, bytes);
#endif
        return nullptr;
    }
    /// False if it was not taken here.
    bool give_back([[maybe_unused]] void* begin) {
#if MAPS_FILES
        // A mapping begins with a page of memory, and few other blocks do.
        if (bytes() == 0 || reinterpret_cast<std::uintptr_t>(begin) % 4096 != 0) return false;
        const std::lock_guard lock(mutex_);
        for (Block& b : blocks_) {
            if (b.begin != begin) continue;
            ::munmap(b.begin, b.bytes);
            bytes_ -= b.bytes;
            b = {};
            return true;
        }
#endif
        return false;
    }

  private:
    void* refuse(int error) {
        error_.store(error, std::memory_order_relaxed);
        return nullptr;
    }

    std::array<char, 4096> name_{};
    std::atomic<int> error_{0};
    std::atomic<bool> is_on_{false};
    std::atomic<std::uint64_t> bytes_{0};
    std::mutex mutex_;
    std::array<Block, 1024> blocks_{};
};

constinit Blocks blocks;

}  // namespace

LargeBlocksInFiles::LargeBlocksInFiles(const std::filesystem::path& folder) {
    blocks.turn_on(folder);
}
LargeBlocksInFiles::~LargeBlocksInFiles() {
    blocks.turn_off();
}
int error_of_files() {
    return blocks.error();
}
std::uint64_t bytes_in_files() {
    return blocks.bytes();
}

}  // namespace farfield::scenes

void* operator new(std::size_t bytes) {
    using namespace farfield::scenes;
    while (true) {
        void* const block =
            bytes >= least_bytes && blocks.is_on() ? blocks.take(bytes) : std::malloc(bytes != 0 ? bytes : 1);
        if (block != nullptr) return block;
        const std::new_handler handler = std::get_new_handler();
        if (handler == nullptr) throw std::bad_alloc();
        handler();
    }
}
void operator delete(void* block) noexcept {
    if (block != nullptr && !farfield::scenes::blocks.give_back(block)) std::free(block);
}
void operator delete(void* block, std::size_t) noexcept {
    operator delete(block);
}
