// What pictures to draw, and of what: what the window asks the thread for that draws.
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <vector>

#include "comparison.hpp"
#include "farfield/camera.hpp"
#include "farfield/view.hpp"
#include "report/picture.hpp"
#include "scenes/renderers/renderer_choice.hpp"
#include "stage.hpp"

namespace viewer {

struct Order {
    std::shared_ptr<const Stage> stage{};  ///< outlives what is drawn of it
    BuiltPtr variant{}, exact{};           ///< null: it is not drawn
    farfield::scenes::RendererChoice renderer{}, exact_renderer{};
    farfield::View view{};                   ///< of the variant
    std::optional<farfield::View> frozen{};  ///< what is drawn is chosen for this view, and seen from the other
    std::optional<double> budget_ms{};
    std::vector<farfield::View> like{};  ///< from which it is learned what frames cost
    bool tints_levels = false;
    std::size_t most_cells = 0;  ///< whose outlines are wanted
    std::optional<Difference> difference{};
    farfield::report::Background background{};
    int side = 1;            ///< pixels of the window on the side of one of the picture
    std::size_t number = 0;  ///< of the order, for whoever gave it
};

inline bool is_same(const farfield::Camera& a, const farfield::Camera& b) {
    return a.eye == b.eye && a.right == b.right && a.up == b.up && a.forward == b.forward &&
           a.half_height == b.half_height;
}
inline bool is_same(const farfield::View& a, const farfield::View& b) {
    return is_same(a.camera, b.camera) && a.width == b.width && a.height == b.height &&
           a.tolerance_px == b.tolerance_px && a.distance == b.distance && a.wanted == b.wanted;
}
/// Whether they ask for the same pictures. What frames cost is learned once.
inline bool is_same(const Order& a, const Order& b) {
    const bool both_frozen = a.frozen && b.frozen;
    return a.stage == b.stage && a.variant == b.variant && a.exact == b.exact && a.renderer == b.renderer &&
           a.exact_renderer == b.exact_renderer && is_same(a.view, b.view) &&
           a.frozen.has_value() == b.frozen.has_value() && (!both_frozen || is_same(*a.frozen, *b.frozen)) &&
           a.budget_ms == b.budget_ms && a.tints_levels == b.tints_levels && a.most_cells == b.most_cells &&
           a.difference == b.difference && a.side == b.side;
}

}  // namespace viewer
