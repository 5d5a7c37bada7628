// One measurement and what its columns are called.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <variant>

#include "statistics.hpp"

namespace farfield::bench {

/// Fields that do not apply are none: the peer has no hierarchy, a frame that is only timed has no errors.
struct Row {
    using Number = std::optional<double>;

    std::string chart;  ///< `accuracy` or `growth`
    std::string scene;
    Number triangles;
    std::string view;
    Number distance_radii;
    Number width_px, height_px;
    std::string variant;
    Number samples;
    Number tolerance_px;
    Number repetitions;
    Number time_ms_first_quartile, time_ms, time_ms_third_quartile;
    Number speedup_first_quartile, speedup, speedup_third_quartile;
    Number rmse, flip, ssim, coverage_bias, coverage_rms;
    Number drawn_triangles, stand_ins, cells_visited, touched_bytes;
    Number hierarchy_bytes, hierarchy_cells, build_seconds;
    std::string note;

    void set_times_ms(const Quartiles& q) {
        time_ms_first_quartile = q.first, time_ms = q.median, time_ms_third_quartile = q.third;
    }
    void set_speedups(const Quartiles& q) {
        speedup_first_quartile = q.first, speedup = q.median, speedup_third_quartile = q.third;
    }

    friend bool operator==(const Row&, const Row&) = default;
};

struct Column {
    std::string_view name;
    std::string_view meaning;
    std::variant<std::string Row::*, Row::Number Row::*> field;
};

/// In the order in which they are written.
inline constexpr std::array columns{
    Column{"chart", "accuracy: time against error; growth: time against number of primitives", &Row::chart},
    Column{"scene", "what is drawn", &Row::scene},
    Column{"triangles", "of the scene, every instance counted", &Row::triangles},
    Column{"view", "from where it is drawn", &Row::view},
    Column{"distance_radii", "eye to center of the bounds, in halves of their largest side", &Row::distance_radii},
    Column{"width_px", "of the picture", &Row::width_px},
    Column{"height_px", "of the picture", &Row::height_px},
    Column{"variant", "approximation, partition, cost model, renderer; peer is the plain z-buffer over all triangles",
           &Row::variant},
    Column{"samples", "a pixel", &Row::samples},
    Column{"tolerance_px", "error that a stand-in may have; empty: no stand-ins", &Row::tolerance_px},
    Column{"repetitions", "frames timed", &Row::repetitions},
    Column{"time_ms_first_quartile", "of a frame", &Row::time_ms_first_quartile},
    Column{"time_ms", "of a frame, median", &Row::time_ms},
    Column{"time_ms_third_quartile", "of a frame", &Row::time_ms_third_quartile},
    Column{"speedup_first_quartile", "exact at 1 sample, drawn right before, over this", &Row::speedup_first_quartile},
    Column{"speedup", "likewise, median of pairs", &Row::speedup},
    Column{"speedup_third_quartile", "likewise", &Row::speedup_third_quartile},
    Column{"rmse", "0 to 1, colors over white, of the object's rectangle against the reference", &Row::rmse},
    Column{"flip", "0 to 1, likewise; Andersson et al. 2020, mean", &Row::flip},
    Column{"ssim", "-1 to 1, 1 is best, likewise", &Row::ssim},
    Column{"coverage_bias", "covered too much, as a part of what the reference covers", &Row::coverage_bias},
    Column{"coverage_rms", "0 to 1, of alpha", &Row::coverage_rms},
    Column{"drawn_triangles", "handed to the renderer in a frame", &Row::drawn_triangles},
    Column{"stand_ins", "drawn in a frame", &Row::stand_ins},
    Column{"cells_visited", "in a frame", &Row::cells_visited},
    Column{"touched_bytes", "of the hierarchy, read in a frame", &Row::touched_bytes},
    Column{"hierarchy_bytes", "of all of the scene's hierarchies, without triangles", &Row::hierarchy_bytes},
    Column{"hierarchy_cells", "of all of them", &Row::hierarchy_cells},
    Column{"build_seconds", "of all of them, on one thread", &Row::build_seconds},
    Column{"note", "what has to be known about the row", &Row::note},
};

}  // namespace farfield::bench
