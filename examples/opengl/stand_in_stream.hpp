// Stand-ins in the order they came in, cut into chunks that are known by their contents.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <glm/common.hpp>
#include <span>
#include <vector>

#include "farfield/geometry/box.hpp"
#include "opengl/chunk_store.hpp"
#include "opengl/stand_in_record.hpp"

namespace farfield::opengl {

/// Consecutive stand-ins of one view and one kind: as Chunk, of records of any length.
struct StandInChunk {
    std::size_t first = 0;    ///< in the picture's list of texels
    std::uint32_t count = 0;  ///< records
    std::uint32_t view = 0;
    std::uint64_t hash = 0;
    Box box = Box::empty();
    std::array<std::uint16_t, 3> of_law{};  ///< how many of each LawClass
    StandInKind kind{};
    std::uint8_t options = 0;  ///< of tensors: which of the picture's
};

inline std::uint64_t hash_of_texels(const std::uint64_t* texels, std::size_t count) {
    std::uint64_t hash = count;
    for (std::size_t i = 0; i < count; ++i) hash = hashed(hash, texels[i]);
    return hash;
}

class StandInStream {
  public:
    std::vector<std::uint64_t> texels;
    std::vector<StandInChunk> chunks;

    void clear() {
        texels.clear();
        chunks.clear();
        spans_.clear();
        is_open_ = false;
    }
    bool is_empty() const { return texels.empty(); }
    /// The next record begins a new chunk.
    void close() { is_open_ = false; }
    template <StandInKind kind>
    void add(const StandInTexels<kind>& record, std::uint32_t view, std::uint8_t options = 0) {
        if (!is_open_ || spans_.back().view != view || spans_.back().kind != kind || spans_.back().options != options) {
            spans_.push_back({.first = texels.size(), .view = view, .kind = kind, .options = options});
            is_open_ = true;
        }
        texels.insert(texels.end(), record.begin(), record.end());
    }
    /// Makes chunks of all records. `stretch`: see box_of().
    void cut(float stretch) {
        chunks.clear();
        std::size_t records = 0;
        for (std::size_t i = 0; i < spans_.size(); ++i) records += texels_in(i) / texels_of(spans_[i].kind);
        const std::uint64_t mask = Chunk::mean(records) - 1;
        for (std::size_t i = 0; i < spans_.size(); ++i) {
            const std::size_t size = texels_of(spans_[i].kind), end = spans_[i].first + texels_in(i);
            StandInChunk chunk = begun(spans_[i], spans_[i].first);
            for (std::size_t at = chunk.first; at < end; at += size) {
                const std::uint64_t* const record = texels.data() + at;
                const std::uint64_t own = hash_of_texels(record, size);
                chunk.hash = hashed(chunk.hash, own);
                ++chunk.count;
                ++chunk.of_law[std::size_t(law_class(chunk.kind, record)) % 3];
                const Box box = box_of(chunk.kind, record, stretch);
                chunk.box = {glm::min(chunk.box.lower, box.lower), glm::max(chunk.box.upper, box.upper)};
                if ((own & mask) != 0 && chunk.count < Chunk::most && at + size < end) continue;
                chunks.push_back(chunk);
                chunk = begun(spans_[i], at + size);
            }
        }
    }

  private:
    std::size_t texels_in(std::size_t span) const {
        return (span + 1 < spans_.size() ? spans_[span + 1].first : texels.size()) - spans_[span].first;
    }
    static StandInChunk begun(const StandInChunk& span, std::size_t first) {
        StandInChunk chunk = span;
        chunk.first = first;
        chunk.hash = std::uint64_t(span.kind);
        return chunk;
    }

    std::vector<StandInChunk> spans_;  ///< as far as they are known
    bool is_open_ = false;
};

}  // namespace farfield::opengl
