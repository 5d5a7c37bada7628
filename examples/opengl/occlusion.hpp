// Which cells were hidden some frames ago: their boxes are drawn against the depths of what was, and the GPU tells when
// it has time.
#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <unordered_map>
#include <utility>
#include <vector>

#include "farfield/drawables.hpp"
#include "farfield/geometry/cell.hpp"
#include "farfield/view/local_view.hpp"
#include "opengl/chunk_store.hpp"
#include "opengl/objects.hpp"

namespace farfield::opengl {

/// Answers hold for a few frames. So what comes into sight is missing for as long: a cell is never hidden by what has
/// gone, but for these. Nothing waits for the GPU.
class Occlusion {
  public:
    /// A box in the coordinates of a view, which has a number in the picture.
    struct Box {
        glm::vec3 center, half_size;
        std::uint32_t view;
    };

    void begin_frame() {
        ++frame_;
        asked_.clear();
        std::erase_if(pending_, [this](Pending& p) {
            GLint is_there = 0;
            glGetQueryObjectiv(p.query.name(), GL_QUERY_RESULT_AVAILABLE, &is_there);
            if (is_there == 0) return false;
            GLint passed = 0;
            glGetQueryObjectiv(p.query.name(), GL_QUERY_RESULT, &passed);
            Known& known = known_[p.cell];
            known = {frame_, known.asked, passed == 0, false};
            free_.push_back(std::move(p.query));
            return true;
        });
        if (frame_ % forgets_after == 0) {
            std::erase_if(known_, [this](const auto& k) { return k.second.asked + forgets_after < frame_; });
        }
    }

    /// `number_of_view()` is called if the cell's box is to be drawn after this frame.
    template <class NumberOfView>
    bool hidden(const Cell& cell, CellId id, const LocalView& view, NumberOfView&& number_of_view) {
        const std::uint64_t key = hashed(hashed(id.node, id.path), id.path);
        Known& known = known_[key];
        known.asked = frame_;
        const bool is_known = known.answered != 0 && frame_ - known.answered <= holds_for;
        if (!known.is_pending && frame_ - known.answered >= asks_after && asked_.size() < most_asked) {
            // What stands in for a cell may reach out of it by some pixels, and flat contents lie in its sides.
            const float depth = view.is_perspective ? view.depth(cell.bounds_center) : 1.0f;
            const float radius = glm::length(cell.bounds_half), spare = 2 * depth / view.focal_px + radius / 64;
            if (!view.is_perspective || depth - radius - spare > view.near_depth) {
                known.is_pending = true;
                asked_.push_back({key, {cell.bounds_center, cell.bounds_half + spare, number_of_view()}});
            }
        }
        return is_known && known.is_hidden;
    }

    /// Calls draw(Box) for each box that is asked about, with the depths of the picture bound.
    template <class Draw>
    void ask(Draw&& draw) {
        for (const Asked& a : asked_) {
            if (free_.empty()) free_.emplace_back(GLenum(GL_ANY_SAMPLES_PASSED));
            Query query = std::move(free_.back());
            free_.pop_back();
            glBeginQuery(GL_ANY_SAMPLES_PASSED, query.name());
            draw(a.box);
            glEndQuery(GL_ANY_SAMPLES_PASSED);
            pending_.push_back({a.cell, std::move(query)});
        }
    }
    bool asks() const { return !asked_.empty(); }

  private:
    static constexpr std::uint32_t holds_for = 8, asks_after = 3, forgets_after = 64;  ///< frames
    static constexpr std::size_t most_asked = 512;                                     ///< a frame

    struct Known {
        std::uint32_t answered = 0, asked = 0;  ///< in which frames
        bool is_hidden = false, is_pending = false;
    };
    struct Pending {
        std::uint64_t cell;
        Query query;
    };
    struct Asked {
        std::uint64_t cell;
        Box box;
    };

    std::uint32_t frame_ = asks_after;
    std::unordered_map<std::uint64_t, Known> known_;  ///< by a hash of CellId
    std::vector<Asked> asked_;
    std::vector<Pending> pending_;
    std::vector<Query> free_;
};

}  // namespace farfield::opengl
