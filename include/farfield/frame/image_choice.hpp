// Which cells are to get an image in a frame, and what is known of that: image_chooser.hpp decides it.
#pragma once

#include "farfield/settings.hpp"

#include <cstddef>
#include <cstdint>
#include <vector>

#include "farfield/cost_model.hpp"
#include "farfield/frame/kept_images.hpp"
#include "farfield/frame/subtree.hpp"
#include "farfield/view/local_view.hpp"

namespace farfield::detail {

/// The price of drawing triangles that are each so many pixels large: that of small ones, or of large ones where the
/// cost model has it.
template <class C>
float price_of(const C& costs, const Work& work, float each_px) {
    if constexpr (requires { costs.cost_of_large(work, each_px); }) {
        return costs.cost_of_large(work, each_px);
    } else {
        return costs.cost(work);
    }
}

/// The price of making an image, without drawing what it shows: as of drawing it, or as the cost model says.
template <class C>
float price_of_making(const C& costs, float texels) {
    if constexpr (requires { costs.making_cost(texels); }) {
        return costs.making_cost(texels);
    } else {
        return costs.cost({.images = 1, .texels = texels});
    }
}

/// A cell that is to get an image, in the coordinates of its hierarchy. `draw` knows their types.
template <class Maker>
struct WantedImage {
    std::uint32_t cell = 0;
    const void* hierarchy = nullptr;
    const void* primitives = nullptr;
    std::size_t primitive_count = 0;
    LocalView view;
    Subtree subtree;
    ImageRect rect;
    int slices = 1;
    float contents_price = 0;  ///< of drawing what the picture shows of it, by images below that are kept
    float whole_price = 0;     ///< of drawing all of it
    float making_price = 0;    ///< of making the image, that included
    std::uint32_t lives = 1;   ///< frames that it will serve
    bool is_new = false;       ///< the cell was not looked at in the last frame: it may be hidden
    bool is_ahead = false;     ///< `view` is one that is expected, and not the frame's
    void (*draw)(Maker&, const WantedImage&, const LocalView& image_view) = nullptr;
};

/// A cell that a descent has begun and not ended, and what had been counted before it.
struct OpenCell {
    std::uint32_t cell;
    double price = 0, present_price = 0, whole_price = 0, usual_making = 0;
    std::size_t images = 0, hidden = 0, wanted = 0, renewals = 0;
    bool is_new = false;
};

/// What is chosen for a frame, and what choosing needs: kept from frame to frame, as memory is.
template <class Maker>
struct ImageChoice {
    std::vector<WantedImage<Maker>> wanted;
    std::vector<WantedImage<Maker>> renewals;  ///< images that are good, and will not be for long
    std::vector<OpenCell> open;
};

}  // namespace farfield::detail
