// The error that a picture may have, and what is known of it before anything is drawn.
//
// A tolerance in pixels bounds how far an outline is off. What the picture then errs by depends on the approximation
// and on how much of its cell it covers: a stand-in of twigs is all but right where that of a wall is not. Whoever
// makes stand-ins knows both, so it says what to expect, in the same words for all approximations: the root mean square
// error of channels in [0, 1], coverage's among them, over the pixels that the cell's box takes, if nothing lies before
// it or behind it. bench/accuracy/wanted_error.cpp measures it, over cells and directions, and what comes of it.
//
// What whole pictures err by may be measured instead, once a hierarchy, and be kept in its file:
// tuning/tuned_viewer.hpp draws by that whatever is wanted.
#pragma once

#include "farfield/settings.hpp"

#include <cmath>
#include <limits>
#include <optional>

namespace farfield {

/// The largest error that a picture may have. One that stand-ins do not keep is what primitives, drawn with so many
/// samples, err by; where these are expected to err more as well, it cannot be had, and
/// FrameStats::cells_needing_samples is above 0.
struct WantedError {
    /// A root mean square error of channels in [0, 1] over the pixels that objects take. None: no worse than point
    /// sampling, which is what exact geometry errs by. Infinity: any.
    std::optional<double> rmse{};
    int samples = 1;  ///< a pixel, that the renderer draws with

    static constexpr WantedError any() { return {.rmse = std::numeric_limits<double>::infinity()}; }
    bool is_any() const { return rmse && std::isinf(*rmse); }
    bool is_point_sampling() const { return !rmse; }

    friend bool operator==(const WantedError&, const WantedError&) = default;
};

/// What point sampling errs by over a cell that is `side_px` wide and of which its contents cover a part: edges, of
/// which there are the fewer in a pixel the larger things are. A sum over samples that do not depend on one another
/// errs less by the root of their number. Constants are fitted (bench/accuracy/wanted_error.cpp); roots are all that is
/// taken, as no two machines round powers alike.
inline float point_sampling_rmse(float side_px, float covered, int samples) {
    const float side = std::sqrt(float(samples)), eighth_root = std::sqrt(std::sqrt(std::sqrt(covered)));
    return 0.75f * eighth_root / ((std::sqrt(side_px * side) + 0.45f) * side);
}

/// The largest error that a stand-in may have, of a cell that is so wide and covered.
inline float largest_rmse(const WantedError& wanted, float side_px, float covered) {
    return wanted.rmse ? float(*wanted.rmse) : point_sampling_rmse(side_px, covered, wanted.samples);
}

}  // namespace farfield
