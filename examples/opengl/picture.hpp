// What is to be drawn into one picture, kept until it is complete: draws of many instances and batches then become few
// calls, and what the last frame drew too is recognized.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <glm/common.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <optional>
#include <span>
#include <type_traits>
#include <unordered_map>
#include <utility>
#include <vector>

#include "farfield/drawables.hpp"
#include "farfield/geometry/light.hpp"
#include "farfield/view/local_view.hpp"
#include "opengl/chunk_store.hpp"
#include "opengl/far_record.hpp"
#include "opengl/triangles.hpp"
#include "opengl/view_row.hpp"

namespace farfield::opengl {

/// A run of a source, in triangles.
struct TriangleRun {
    std::uint32_t first, count, view;
    std::uint32_t local_view;  ///< of the source's own coordinates, if vertices have others
};

/// Law of the cell that triangles lie in, whose small ones are deposited by it; or none, and each is drawn as it is.
using CellLaw = std::uint8_t;
inline constexpr CellLaw no_law = 3;
inline CellLaw cell_law(const std::optional<AreaLaw>& law) {
    return law ? CellLaw(*law) : no_law;
}

struct RunsOfSource {
    std::uint32_t source = 0;
    CellLaw law = no_law;
    std::vector<TriangleRun> runs{};
};

struct PlacedImage {
    ImageQuad quad;
    std::uint32_t view;
    std::size_t first_record;  ///< of the stand-ins that come after it
};

class Picture {
  public:
    /// Records of one type, and the chunks that they make.
    template <class Record>
    class Stream {
      public:
        std::vector<Record> records;
        std::vector<Chunk> chunks;

        void clear() {
            records.clear();
            chunks.clear();
            spans_.clear();
            is_open_ = false;
        }
        /// The next record begins a new chunk.
        void close() { is_open_ = false; }
        void add(const Record& record, std::uint32_t view, std::uint8_t law = 0, bool is_face = false) {
            if (!is_open_ || spans_.back().view != view || spans_.back().cell_law != law ||
                spans_.back().is_of_faces != is_face) {
                spans_.push_back({.first = std::uint32_t(records.size()),
                                  .view = view,
                                  .hash = sizeof(Record),
                                  .cell_law = law,
                                  .is_of_faces = is_face});
                is_open_ = true;
            }
            records.push_back(record);
        }
        /// Makes chunks of all records.
        void cut() {
            chunks.clear();
            const std::uint64_t mask = Chunk::mean(records.size()) - 1;
            for (std::size_t i = 0; i < spans_.size(); ++i) {
                const std::size_t end = i + 1 < spans_.size() ? spans_[i + 1].first : records.size();
                Chunk chunk = spans_[i];
                for (std::size_t at = chunk.first; at < end; ++at) {
                    const std::uint64_t own = hash_of(0, records[at]);
                    chunk.hash = hashed(chunk.hash, own);
                    ++chunk.count;
                    look_at(records[at], chunk);
                    if ((own & mask) != 0 && chunk.count < Chunk::most && at + 1 < end) continue;
                    chunks.push_back(chunk);
                    chunk = spans_[i];
                    chunk.first = std::uint32_t(at + 1);
                }
            }
        }

      private:
        static void look_at(const TriangleVertices& t, Chunk& chunk) {
            for (const Vertex& v : t.corner) chunk.box.add(v.position);
        }
        static void look_at(const FarRecord& record, Chunk& chunk) {
            ++chunk.of_law[std::size_t(law_of(record)) % 3];
            const Box box = box_of(record);
            chunk.box = {glm::min(chunk.box.lower, box.lower), glm::max(chunk.box.upper, box.upper)};
        }

        std::vector<Chunk> spans_;  ///< as far as they are known
        bool is_open_ = false;
    };

    void begin(const LocalView& view) {
        for (RunsOfSource& of_source : runs_) of_source.runs.clear();
        sources_used_ = 0;
        place_of_source_.clear();
        streamed.clear();
        far.clear();
        images.clear();
        rows.clear();
        known_rows_.clear();
        has_translucent_streamed = false;
        set_view(view, nullptr);
    }
    void set_view(const LocalView& view, const DirectionalLight* light) {
        const ViewRow row = view_row(view, light);
        if (row_ && row == *row_) return;
        row_ = row;
        number_ = none;
    }

    void add_run(std::uint32_t source, CellLaw law, glm::vec3 origin, std::uint32_t first, std::uint32_t end) {
        if (first == end) return;
        const auto [found, is_new] = place_of_source_.try_emplace(std::uint64_t(source) << 8 | law, sources_used_);
        if (is_new) {
            if (sources_used_ == runs_.size()) runs_.emplace_back();
            runs_[sources_used_].source = source;
            runs_[sources_used_++].law = law;
        }
        std::vector<TriangleRun>& runs = runs_[found->second].runs;
        const std::uint32_t view = view_from(origin);
        if (!runs.empty() && runs.back().view == view && runs.back().first + runs.back().count == first) {
            runs.back().count += end - first;
        } else {
            runs.push_back({first, end - first, view, this->view()});
        }
    }
    void add(const TriangleVertices& t, CellLaw law) {
        has_translucent_streamed = has_translucent_streamed || is_translucent(t);
        streamed.add(t, view(), law);
    }
    void add(const Face& face) {
        if (face.rgba.a != 0) far.add(record_of(face), view(), 0, /*is_face=*/true);
    }
    void add(const Splat& splat) { far.add(record_of(splat), view()); }
    void add(const ImageQuad& quad) {
        far.close();
        images.push_back({quad, view(), far.records.size()});
    }

    /// Whether small triangles may be deposited; after end().
    bool has_laws() const {
        const auto has_law = [](const auto& of) { return of.law != no_law; };
        const auto chunk_has_law = [](const Chunk& c) { return c.cell_law != no_law; };
        return std::any_of(runs_.begin(), runs_.begin() + std::ptrdiff_t(sources_used_), has_law) ||
               std::any_of(streamed.chunks.begin(), streamed.chunks.end(), chunk_has_law);
    }

    /// The number of the view's row, which is there once however often a descent comes back to it.
    std::uint32_t view() {
        if (number_ == none) number_ = number_of(*row_);
        return number_;
    }

    /// Call it when all is added.
    void end() {
        streamed.cut();
        far.cut();
    }

    std::span<const RunsOfSource> runs() const { return {runs_.data(), sources_used_}; }

    Stream<TriangleVertices> streamed;  ///< of sources that change
    Stream<FarRecord> far;              ///< front to back
    std::vector<PlacedImage> images;
    std::vector<ViewRow> rows;
    bool has_translucent_streamed = false;

  private:
    static constexpr std::uint32_t none = ~std::uint32_t(0);

    std::uint32_t view_from(glm::vec3 origin) {
        if (origin == glm::vec3(0)) return view();
        ViewRow moved = *row_;
        moved.anchor += glm::vec4(origin, 0);
        return number_of(moved);
    }
    std::uint32_t number_of(const ViewRow& row) {
        const auto [found, is_new] = known_rows_.try_emplace(hash_of(0, row), std::uint32_t(rows.size()));
        if (is_new) rows.push_back(row);
        return found->second;
    }

    std::vector<RunsOfSource> runs_;
    std::size_t sources_used_ = 0;
    std::unordered_map<std::uint64_t, std::size_t> place_of_source_;  ///< and law
    std::unordered_map<std::uint64_t, std::uint32_t> known_rows_;
    std::optional<ViewRow> row_;
    std::uint32_t number_ = none;
};

}  // namespace farfield::opengl
