// Where the camera is, frame by frame.
#pragma once

#include <optional>
#include <vector>

#include "farfield/measure/pixel_rect.hpp"
#include "farfield/view.hpp"
#include "options.hpp"
#include "setting.hpp"

namespace walkthrough {

struct Flight {
    std::vector<farfield::Camera> cameras;  ///< one a frame
    std::vector<int> quality_frames;        ///< whose pictures are compared and kept: at most eight, evenly spaced
};

/// A closed path through the scene, or the same view again and again where the options give a distance.
Flight plan_flight(const Setting& setting, const Options& options);

/// The pixels that the box may take: its corners' extent. None if one of them is behind the camera.
std::optional<farfield::PixelRect> projected_rect(const farfield::Box& box, const farfield::View& view);

}  // namespace walkthrough
