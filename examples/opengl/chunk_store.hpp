// Records that stay on the GPU from frame to frame, in chunks that are found by their contents.
#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <unordered_map>
#include <vector>

#include "farfield/geometry/box.hpp"
#include "opengl/objects.hpp"

namespace farfield::opengl {

/// A step of a hash of contents.
inline std::uint64_t hashed(std::uint64_t hash, std::uint64_t word) {
    hash = (hash ^ word) * 0x9e3779b97f4a7c15u;
    return hash ^ hash >> 32;
}

template <class Record>
std::uint64_t hash_of(std::uint64_t hash, const Record& record) {
    static_assert(sizeof(Record) % 8 == 0);
    for (std::size_t i = 0; i < sizeof(Record); i += 8) {
        std::uint64_t word;
        std::memcpy(&word, reinterpret_cast<const char*>(&record) + i, sizeof word);
        hash = hashed(hash, word);
    }
    return hash;
}

/// Consecutive records of one view, so many that a hash of the last one says that it ends here: where something comes
/// or goes, only the chunk around it changes, and not all that follow.
struct Chunk {
    static constexpr std::uint32_t most = 512;  ///< records
    /// How many hold a picture, about; and how many records each then has on average, a power of two.
    static constexpr std::size_t wanted = 512;
    static std::uint32_t mean(std::size_t records) {
        return std::uint32_t(std::bit_floor(std::clamp<std::size_t>(records / wanted, 8, 128)));
    }

    std::uint32_t first = 0, count = 0;  ///< in the picture's list of records
    std::uint32_t view = 0;
    std::uint64_t hash = 0;  ///< of the records, equal for equal ones: 2^-64 times the square of their number is what
                             ///< may go wrong
    Box box = Box::empty();  ///< that holds them
    std::uint8_t cell_law = 0;  ///< CellLaw
};

/// Instances that show the same part of a hierarchy have equal chunks, which are there once. New chunks are put one
/// behind the other; at the end of the buffer all are forgotten, and those in use come anew: as it has room for eight
/// pictures, that adds a seventh to what is uploaded at most.
template <class Record>
class ChunkStore {
  public:
    GLuint name() const { return buffer_.name(); }
    std::size_t capacity() const { return capacity_; }

    /// Finds room for a picture's chunks and uploads those that are missing. Returns the bytes. place_of(chunk) is then
    /// the number of its first record.
    std::size_t update(std::span<const Chunk> chunks, std::span<const Record> records) {
        if (missing(chunks) > capacity_ - used_) {
            places_.clear();
            used_ = 0;
            if (8 * records.size() > capacity_) {
                capacity_ = 16 * records.size();
                buffer_ = make_buffer();
            }
            // The old memory may still be drawn from.
            glNamedBufferData(buffer_.name(), GLsizeiptr(capacity_ * sizeof(Record)), nullptr, GL_DYNAMIC_DRAW);
        }
        staged_.clear();
        const std::size_t begin = used_;
        for (const Chunk& c : chunks) {
            if (!places_.try_emplace(c.hash, std::uint32_t(used_)).second) continue;
            const auto of_chunk = records.subspan(c.first, c.count);
            staged_.insert(staged_.end(), of_chunk.begin(), of_chunk.end());
            used_ += c.count;
        }
        const std::size_t bytes = staged_.size() * sizeof(Record);
        if (bytes != 0) {
            glNamedBufferSubData(buffer_.name(), GLintptr(begin * sizeof(Record)), GLsizeiptr(bytes), staged_.data());
        }
        return bytes;
    }
    std::uint32_t place_of(const Chunk& chunk) const { return places_.find(chunk.hash)->second; }

  private:
    std::size_t missing(std::span<const Chunk> chunks) const {
        std::size_t count = 0;  // too many where one is missing twice
        for (const Chunk& c : chunks) count += places_.contains(c.hash) ? 0 : c.count;
        return count;
    }

    Buffer buffer_;
    std::size_t capacity_ = 0, used_ = 0;  ///< records
    std::unordered_map<std::uint64_t, std::uint32_t> places_;
    std::vector<Record> staged_;
};

}  // namespace farfield::opengl
