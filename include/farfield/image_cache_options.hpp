// How a viewer keeps images of cells: what an approximation that caches images is asked for.
#pragma once

#include "farfield/settings.hpp"

#include <cstdint>
#include <limits>

namespace farfield {

/// How a viewer keeps images of cells (Shade et al. 1996; frame/kept_images.hpp). Thresholds are those of the view that
/// is drawn, whatever view an image was made for.
struct ImageCacheOptions {
    /// An image is drawn while nothing in it is displaced by more than this many pixels of the picture's center: the
    /// paper's threshold. View::tolerance_px is that of what else stands in.
    float threshold_px = 2;
    /// The paper looks at the corners of a cell, and at the picture's center. True: no point of the cell, anywhere in
    /// the picture, is displaced by more (frame/safety_zone.hpp).
    bool is_conservative = false;
    /// Depth slices an image is made of, 1 to 8: the error falls with their number, and texels become more.
    int slices = 1;
    int samples = 1;  ///< a pixel that images are made with, as the renderer counts them
    /// Images of what instances hold, and of nothing else: a surface beside them, as terrain is, has no cracks.
    bool of_instances_only = false;
    /// Subtrees of fewer items get no image of their own; those that hold instances may.
    std::uint32_t least_items = 1024;
    std::uint64_t budget_bytes = std::uint64_t(64) << 20;  ///< of all images of one viewer; never exceeded
    std::uint32_t most_made = 4096;                        ///< images a frame; other cells are drawn as they are
    /// The most work of making images in a frame, in the unit of the cost model: what a frame may take on top of what
    /// it draws, however many images run out at once.
    float most_making = std::numeric_limits<float>::max();
    /// The work of making images may exceed that of drawing what they show, in a frame, by this part of the frame's
    /// work: an image shows all of a cell where the picture shows a part.
    float most_overhead = 0.25f;
    /// Images may be made anew before they have to, in frames that make less than most do, by this part of their life:
    /// neighbors that were made in one frame would else run out in one. 0: none is.
    float most_early = 0.125f;
    /// Images may be made from where the viewer is expected to be ahead by this part of the time for which an image
    /// made from where it is would serve, if the last frames' motion has been steady: they are then good before and
    /// after. For what stands apart, as trees do: images of neighbors are made from different places then, and a
    /// surface that is split between them opens at once by what it else comes to in the end.
    float most_ahead = 0;
    /// An image that is made anew takes the old one's place over so many frames, sample by sample, where the old one
    /// was seen until now; meanwhile the old one may be displaced by twice the threshold, but not if is_conservative.
    /// 0: at once.
    std::uint32_t fade_frames = 0;
    /// How far the eye moves in a frame at most, in world units, and by how much that may grow from one frame to the
    /// next. With a speed above 0 images are made only if they pay whatever the viewer does within these bounds (Shade
    /// et al. 1996, section 3); 0: the last motion is taken to go on, or the path to be the one that the viewer was
    /// told.
    float most_speed = 0, most_acceleration = 0;
    /// Texels are at most so many times larger, or smaller, than pixels.
    float most_magnified = 1.3f, most_minified = 1.7f;

    /// Null, or what is wrong.
    const char* wrong_option() const {
        const auto is_number = [](float v) { return v >= 0 && v <= std::numeric_limits<float>::max(); };
        if (!is_number(threshold_px)) return "ImageCache: threshold_px must be 0 or more and finite";
        if (slices < 1 || slices > most_slices) return "ImageCache: slices must be 1 to 8";
        if (samples < 1) return "ImageCache: samples must be 1 or more";
        if (!is_number(most_overhead)) return "ImageCache: most_overhead must be 0 or more and finite";
        if (!is_number(most_making)) return "ImageCache: most_making must be 0 or more and finite";
        if (!(most_early >= 0 && most_early <= 1)) return "ImageCache: most_early must be from 0 to 1";
        if (!is_number(most_speed) || !is_number(most_acceleration))
            return "ImageCache: most_speed and most_acceleration must be 0 or more and finite";
        if (!(most_ahead >= 0 && most_ahead <= 1)) return "ImageCache: most_ahead must be from 0 to 1";
        if (!(most_magnified >= 1 && most_minified >= 1))
            return "ImageCache: most_magnified and most_minified must be 1 or more";
        return nullptr;
    }
    static constexpr int most_slices = 8;
};

}  // namespace farfield
