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
#include "opengl/stand_in_record.hpp"
#include "opengl/stand_in_stream.hpp"
#include "opengl/triangles.hpp"
#include "opengl/view_places.hpp"
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
    std::size_t first_texel;  ///< of the stand-ins that come after it
};

class Picture {
  public:
    /// Triangles of sources that change, and the chunks that they make.
    class TriangleStream {
      public:
        std::vector<TriangleVertices> records;
        std::vector<Chunk> chunks;

        void clear() {
            records.clear();
            chunks.clear();
            spans_.clear();
        }
        void add(const TriangleVertices& t, std::uint32_t view, std::uint8_t law) {
            if (spans_.empty() || spans_.back().view != view || spans_.back().cell_law != law) {
                spans_.push_back({.first = std::uint32_t(records.size()),
                                  .view = view,
                                  .hash = sizeof(TriangleVertices),
                                  .cell_law = law});
            }
            records.push_back(t);
        }
        /// Makes chunks of all.
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
                    for (const Vertex& v : records[at].corner) chunk.box.add(v.position);
                    if ((own & mask) != 0 && chunk.count < Chunk::most && at + 1 < end) continue;
                    chunks.push_back(chunk);
                    chunk = spans_[i];
                    chunk.first = std::uint32_t(at + 1);
                }
            }
        }

      private:
        std::vector<Chunk> spans_;  ///< as far as they are known
    };

    /// `makes_rows`: the rows of its views are made on the GPU.
    explicit Picture(bool makes_rows) : may_make_rows_(makes_rows) {}

    void begin(const LocalView& view, const DirectionalLight* light) {
        for (RunsOfSource& of_source : runs_) of_source.runs.clear();
        sources_used_ = 0;
        place_of_source_.clear();
        streamed.clear();
        far.clear();
        tensor_options.clear();
        images.clear();
        known_rows_.clear();
        has_translucent_streamed = false;
        makes_rows_ = may_make_rows_ && ViewPlace(view).is_outermost();
        if (!makes_rows_) rows.clear();
        places.begin();
        row_.reset();
        set_view(view, light);
        outermost = *row_;
    }
    void set_view(const LocalView& view, const DirectionalLight* light) {
        const ViewRow row = view_row(view, light);
        if (row_ && row == *row_) return;
        row_ = row;
        place_ = ViewPlace(view);
        number_ = none;
    }
    bool makes_rows() const { return makes_rows_; }

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
        constexpr StandInKind kind = StandInKind::face;
        if (face.rgba.a != 0) far.add<kind>(texels_of<kind>(record_of(face)), view());
    }
    void add(const Splat& splat) {
        constexpr StandInKind kind = StandInKind::splat;
        far.add<kind>(texels_of<kind>(record_of(splat)), view());
    }
    void add(const PlacedStandIns& placed) {
        const std::uint32_t row = view();
        if (placed.kind == PlacedStandIns::Kind::cubes) {
            for (std::size_t i = 0; i < placed.count; ++i)
                far.add<StandInKind::cube>(texels_of_cube(placed.words + i), row);
            return;
        }
        const TensorOptions options{placed.closed_surfaces, placed.counts_overlap, placed.sheet_gain};
        const std::uint8_t number = number_of(options);
        for (std::size_t i = 0; i < placed.count; ++i)
            far.add<StandInKind::tensor>(texels_of_tensor(placed.words + i), row, number);
    }
    void add(const ImageQuad& quad) {
        far.close();
        images.push_back({quad, view(), far.texels.size()});
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
        if (number_ == none) number_ = number_of(*row_, glm::vec3(0));
        return number_;
    }

    /// Call it when all is added.
    void end() {
        streamed.cut();
        far.cut(stretch_of(outermost));
    }

    std::span<const RunsOfSource> runs() const { return {runs_.data(), sources_used_}; }

    TriangleStream streamed;
    StandInStream far;                          ///< front to back
    std::vector<TensorOptions> tensor_options;  ///< that stand-ins have
    std::vector<PlacedImage> images;
    std::vector<ViewRow> rows;  ///< by number, of views that are used
    ViewRow outermost{};        ///< that the frame began with
    ViewPlaces places;          ///< of the rows, where they are made on the GPU
    bool has_translucent_streamed = false;

  private:
    static constexpr std::uint32_t none = ~std::uint32_t(0);

    std::uint32_t view_from(glm::vec3 origin) {
        if (origin == glm::vec3(0)) return view();
        ViewRow moved = *row_;
        moved.anchor += glm::vec4(origin, 0);
        return number_of(moved, origin);
    }
    /// The 256th and those after it go by the rules of the first.
    std::uint8_t number_of(const TensorOptions& options) {
        const auto same = [&](const TensorOptions& o) {
            return o.closed_surfaces == options.closed_surfaces && o.counts_overlap == options.counts_overlap &&
                   o.sheet_gain == options.sheet_gain;
        };
        const auto found = std::find_if(tensor_options.begin(), tensor_options.end(), same);
        const auto number = std::size_t(found - tensor_options.begin());
        if (number > 255) return 0;
        if (found == tensor_options.end()) tensor_options.push_back(options);
        return std::uint8_t(number);
    }
    std::uint32_t number_of(const ViewRow& row, glm::vec3 origin) {
        if (makes_rows_) {
            const std::uint32_t number = places.number_of(placed_row(place_, origin));
            if (number >= rows.size()) rows.resize(number + 1);
            rows[number] = row;
            return number;
        }
        const auto [found, is_new] = known_rows_.try_emplace(hash_of(0, row), std::uint32_t(rows.size()));
        if (is_new) rows.push_back(row);
        return found->second;
    }

    std::vector<RunsOfSource> runs_;
    std::size_t sources_used_ = 0;
    std::unordered_map<std::uint64_t, std::size_t> place_of_source_;  ///< and law
    std::unordered_map<std::uint64_t, std::uint32_t> known_rows_;
    bool may_make_rows_, makes_rows_ = false;
    std::optional<ViewRow> row_;
    ViewPlace place_;
    std::uint32_t number_ = none;
};

}  // namespace farfield::opengl
