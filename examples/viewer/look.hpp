// What somebody has chosen to see, whether by keys, widgets or a script.
#pragma once

#include <algorithm>
#include <cstddef>
#include <optional>

#include "comparison.hpp"
#include "farfield/camera.hpp"
#include "scenes/renderers/renderer_choice.hpp"

namespace viewer {

enum class Wanted { any, point_sampling, value };

struct Look {
    std::size_t variant = 0;  ///< index into the stage's; 0 is exact
    farfield::scenes::RendererKind renderer = farfield::scenes::RendererKind::z_buffer;
    int samples = 1;  ///< a pixel
    int threads = 1;
    float tolerance_px = 4;
    Wanted wanted = Wanted::any;
    float wanted_rmse = 0.05f;
    bool has_budget = false;
    float budget_ms = 30;

    bool shows_exact = false;     ///< instead of the variant
    bool compares = false;        ///< exact, the variant, and what tells them apart, side by side
    bool measures_error = false;  ///< of each picture that stands
    Difference difference = Difference::flip;
    /// Where exact ends and the difference begins, in parts of the window's width.
    double exact_until = 1.0 / 3, variant_until = 2.0 / 3;

    bool tints_levels = false, outlines_cells = false;
    std::optional<farfield::Camera> frozen{};  ///< what is drawn is chosen for this camera
    bool flies = false;                        ///< a drag turns the head
    bool hides_panels = false, shows_help = false;

    /// Divider 0 or 1. They do not pass one another.
    void move_divider(int which, double to) {
        if (which == 0) {
            exact_until = std::clamp(to, 0.0, variant_until);
        } else {
            variant_until = std::clamp(to, exact_until, 1.0);
        }
    }
};

}  // namespace viewer
