// Commands of draws that stay on the GPU from frame to frame, in blocks that are found by their contents.
#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <unordered_map>
#include <vector>

#include "opengl/chunk_store.hpp"
#include "opengl/objects.hpp"

namespace farfield::opengl {

/// Commands that follow one another on the GPU.
struct CommandDraw {
    std::size_t first = 0;    ///< word
    std::uint32_t count = 0;  ///< commands
};

/// Commands are cut where a hash of one says so: where one comes or goes, its block is sent, and not all that follow. A
/// block is a draw call of its own, unless it lies behind the one before it; there are some 256 at most.
class CommandStore {
  public:
    GLuint name() const { return buffer_.name(); }

    void begin(std::size_t words) {
        blocks_.clear();
        staged_.clear();
        mask_ = std::bit_floor(std::max<std::size_t>(words / (5 * 256), 32)) - 1;
    }
    /// Cuts the commands of a call, `size` words each.
    void add(std::span<const std::uint32_t> words, std::size_t size) {
        Block block = begun(size);
        for (; !words.empty(); words = words.subspan(size)) {
            std::uint64_t own = 0;
            for (const std::uint32_t word : words.first(size)) own = hashed(own, word);
            block.hash = hashed(block.hash, own);
            ++block.count;
            staged_.insert(staged_.end(), words.begin(), words.begin() + std::ptrdiff_t(size));
            if ((own & mask_) != 0 && words.size() > size) continue;
            blocks_.push_back(block);
            block = begun(size);
        }
        if (!blocks_.empty()) blocks_.back().ends_call = true;
    }
    /// Uploads what is missing, and returns the bytes. Of each call that was added, in turn, then come its draws.
    std::size_t update(std::vector<CommandDraw>& draws, std::vector<std::size_t>& ends) {
        std::size_t missing = 0;
        for (const Block& b : blocks_) missing += places_.contains(b.hash) ? 0 : b.words();
        if (missing > capacity_ - used_) {
            places_.clear();
            used_ = 0;
            if (8 * staged_.size() > capacity_) {
                capacity_ = 16 * staged_.size();
                buffer_ = make_buffer();
            }
            // The old memory may still be drawn from.
            glNamedBufferData(buffer_.name(), GLsizeiptr(capacity_ * sizeof(std::uint32_t)), nullptr, GL_DYNAMIC_DRAW);
        }
        const std::size_t begin = used_;
        std::size_t kept = 0;  // what is missing moves to the front
        bool follows = false;
        for (const Block& b : blocks_) {
            const auto [found, is_new] = places_.try_emplace(b.hash, used_);
            if (is_new) {
                const auto from = staged_.begin() + std::ptrdiff_t(b.first);
                std::copy(from, from + std::ptrdiff_t(b.words()), staged_.begin() + std::ptrdiff_t(kept));
                kept += b.words();
                used_ += b.words();
            }
            if (follows && draws.back().first + draws.back().count * b.size == found->second) {
                draws.back().count += b.count;
            } else {
                draws.push_back({found->second, b.count});
            }
            follows = !b.ends_call;
            if (b.ends_call) ends.push_back(draws.size());
        }
        if (kept != 0) {
            glNamedBufferSubData(buffer_.name(), GLintptr(begin * sizeof(std::uint32_t)),
                                 GLsizeiptr(kept * sizeof(std::uint32_t)), staged_.data());
        }
        return kept * sizeof(std::uint32_t);
    }

  private:
    struct Block {
        std::uint64_t hash;
        std::size_t first, size;  ///< first word of those staged; words in a command
        std::uint32_t count = 0;
        bool ends_call = false;
        std::size_t words() const { return count * size; }
    };
    Block begun(std::size_t size) const { return {.hash = size, .first = staged_.size(), .size = size}; }

    Buffer buffer_;
    std::size_t capacity_ = 0, used_ = 0;  ///< words
    std::unordered_map<std::uint64_t, std::size_t> places_;
    std::vector<Block> blocks_;
    std::vector<std::uint32_t> staged_;
    std::uint64_t mask_ = 0;
};

}  // namespace farfield::opengl
