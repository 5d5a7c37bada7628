// Stand-ins that stay on the GPU: each once, however many instances show it, and lists of four bytes each that say what
// a picture shows.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <unordered_map>
#include <vector>

#include "opengl/chunk_store.hpp"
#include "opengl/objects.hpp"
#include "opengl/stand_in_record.hpp"
#include "opengl/stand_in_stream.hpp"

namespace farfield::opengl {

/// A chunk is a list of places of records, those of one law after those of another. Records and chunks are found by
/// hashes of all that they hold, so that what comes into a picture is sent as 24 to 48 bytes a stand-in the first time,
/// and as 4 with its neighbors of the same chunk later. New ones are put one behind the other; where there is no room
/// all are forgotten, and those in use come anew. There is room for the lists of eight pictures, and for twice the
/// records of one.
class StandInStore {
  public:
    GLuint records() const { return records_.buffer.name(); }
    GLuint lists() const { return lists_.buffer.name(); }

    /// Finds room for a picture's chunks and uploads what is missing. Returns the bytes. place_of(chunk) is then where
    /// its list begins.
    std::size_t update(std::span<const StandInChunk> chunks, std::span<const std::uint64_t> texels) {
        std::size_t all = 0, missing = 0, missing_texels = 0;  // too many where one is missing twice
        for (const StandInChunk& c : chunks) {
            all += c.count;
            if (places_.contains(c.hash)) continue;
            missing += c.count;
            missing_texels += c.count * texels_of(c.kind);
        }
        if (missing == 0) return 0;
        if (missing > lists_.left() || missing_texels > records_.left()) {
            places_.clear();
            place_of_record_.clear();
            lists_.forget(all, 8);
            records_.forget(texels.size(), 2);
        }
        for (const StandInChunk& c : chunks) {
            if (places_.try_emplace(c.hash, std::uint32_t(lists_.end())).second) add(c, texels.data() + c.first);
        }
        return lists_.upload() + records_.upload();
    }
    std::uint32_t place_of(const StandInChunk& chunk) const { return places_.find(chunk.hash)->second; }

  private:
    /// A buffer that is written from one end to the other.
    template <class T>
    struct Filled {
        Buffer buffer;
        std::size_t capacity = 0, used = 0;
        std::vector<T> staged{};  ///< to be uploaded

        std::size_t left() const { return capacity - used; }
        std::size_t end() const { return used + staged.size(); }
        /// Room for so many pictures.
        void forget(std::size_t wanted, std::size_t pictures) {
            used = 0;
            if (pictures * wanted > capacity) {
                capacity = 2 * pictures * wanted;
                buffer = make_buffer();
            }
            // The old memory may still be drawn from.
            glNamedBufferData(buffer.name(), GLsizeiptr(capacity * sizeof(T)), nullptr, GL_DYNAMIC_DRAW);
        }
        std::size_t upload() {
            const std::size_t bytes = staged.size() * sizeof(T);
            if (bytes == 0) return 0;
            glNamedBufferSubData(buffer.name(), GLintptr(used * sizeof(T)), GLsizeiptr(bytes), staged.data());
            used += staged.size();
            staged.clear();
            return bytes;
        }
    };

    void add(const StandInChunk& chunk, const std::uint64_t* texels) {
        std::array<std::size_t, 3> next{lists_.staged.size(), 0, 0};
        next[1] = next[0] + chunk.of_law[0];
        next[2] = next[1] + chunk.of_law[1];
        lists_.staged.resize(lists_.staged.size() + chunk.count);
        const std::size_t size = texels_of(chunk.kind);
        for (std::size_t i = 0; i < chunk.count; ++i, texels += size) {
            const auto [found, is_new] =
                place_of_record_.try_emplace(hash_of_texels(texels, size), std::uint32_t(records_.end()));
            if (is_new) records_.staged.insert(records_.staged.end(), texels, texels + size);
            lists_.staged[next[std::size_t(law_class(chunk.kind, texels)) % 3]++] = found->second;
        }
    }

    Filled<std::uint64_t> records_;
    Filled<std::uint32_t> lists_;
    std::unordered_map<std::uint64_t, std::uint32_t> places_, place_of_record_;
};

}  // namespace farfield::opengl
