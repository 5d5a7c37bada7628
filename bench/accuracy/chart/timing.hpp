// How frames are timed: in pairs with exact ones, for the machine has slow and fast phases, and only ratios within one
// run mean something.
#pragma once

#include <algorithm>
#include <cstddef>
#include <glm/vec3.hpp>
#include <span>
#include <utility>
#include <vector>

#include "farfield/view.hpp"
#include "row.hpp"
#include "scenes/built_scene.hpp"
#include "support/seconds.hpp"

namespace farfield::bench {

/// One of those that take turns.
struct Contestant {
    scenes::SceneViewer* viewer = nullptr;
    View view;
    FrameStats stats{};
    /// Its eye strolls to one side and back, by this a frame: images of cells pay by what frames share, and frames from
    /// one place share all. Other contestants' frames cost the same wherever nearby they are drawn.
    double step = 0;
    std::vector<double> seconds{};   ///< of each frame
    std::vector<double> speedups{};  ///< of each, over the first contestant's frame of the same turn

    double draw() {
        const std::size_t turn = seconds.size();
        const auto drawn = [&] { stats = viewer->frame(at(turn)); };
        if (step == 0) {
            seconds.push_back(seconds_in_turn(turn == 0 ? 0 : seconds.back(), drawn));
        } else {
            // The one before is drawn again, for a frame that is drawn twice finds its images made.
            if (turn > 0) viewer->frame(at(turn - 1));
            seconds.push_back(bench::seconds(drawn));
        }
        return seconds.back();
    }
    View at(std::size_t turn) const {
        constexpr std::size_t steps = 16;
        const std::size_t along = turn % (2 * steps);
        View from = view;
        from.camera.eye += glm::dvec3(view.camera.right) * (step * double(std::min(along, 2 * steps - along)));
        return from;
    }
    /// Draws what it looks at for a picture, where it has strolled away from it.
    void return_to_view() {
        if (step != 0) viewer->frame(view);
    }
};

/// Draws each once a turn, in their order. There are fewer turns than asked for where they take longer than
/// `limit_seconds` altogether, but three, or one where that is three times the limit. Where `is_over` says so no
/// further turn begins.
template <class IsOver>
void take_turns(std::span<Contestant> contestants, int turns, double limit_seconds, IsOver&& is_over) {
    double spent = 0;
    for (int turn = 0; turn < turns && spent < (turn < 3 ? 3 : 1) * limit_seconds && !is_over(); ++turn) {
        spent += seconds([&] {
            for (Contestant& c : contestants) c.speedups.push_back(1 / c.draw());
        });
        for (Contestant& c : contestants) c.speedups.back() *= contestants.front().seconds.back();
    }
}

/// What is known of a contestant without a hierarchy after its last turn.
inline void set_measured(Row& row, const Contestant& turn) {
    std::vector<double> milliseconds = turn.seconds;
    for (double& t : milliseconds) t *= 1e3;
    row.repetitions = double(milliseconds.size());
    row.set_times_ms(quartiles(std::move(milliseconds)));
    row.set_speedups(quartiles(turn.speedups));
    row.drawn_triangles = double(turn.stats.primitives);
}

/// What is known of one with a hierarchy.
inline void set_measured(Row& row, const Contestant& turn, const scenes::BuildFacts& built) {
    set_measured(row, turn);
    row.stand_ins = double(turn.stats.approximations);
    row.cells_visited = double(turn.stats.cells_visited);
    row.touched_bytes = double(turn.stats.touched_bytes);
    row.hierarchy_bytes = double(built.bytes);
    row.hierarchy_cells = double(built.cells);
    row.build_seconds = built.seconds;
}

}  // namespace farfield::bench
