// A picture of the cut: what a frame draws as geometry in gray, what stands in for it tinted by level.
#pragma once

#include "farfield/geometry/rgba8.hpp"
#include "farfield/image.hpp"
#include "farfield/viewer.hpp"

namespace farfield::scenes {

/// One of six colors that tell neighboring levels apart: a stand-in's by the depth of its cell.
Rgba8 tint_of_level(unsigned depth);

/// From the picture with every stand-in in black and that with each in its tint: what they share is geometry.
Image geometry_in_gray(const Image& stand_ins_black, const Image& stand_ins_tinted);

/// Premultiplied, coverage in alpha. `image` gives the renderer's last picture.
template <class Viewer, class Selection, class ImageOf>
Image how_drawn(Viewer& viewer, const Selection& selection, ImageOf&& image) {
    viewer.draw(selection, [](const Subtree&) { return Rgba8{0, 0, 0, 255}; });
    const Image black = image();
    viewer.draw(selection, [](const Subtree& subtree) { return tint_of_level(subtree.cell.depth); });
    return geometry_in_gray(black, image());
}

}  // namespace farfield::scenes
