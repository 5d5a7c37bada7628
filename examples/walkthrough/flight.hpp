// Where the camera is, frame by frame.
#pragma once

#include <vector>

#include "farfield/view.hpp"
#include "options.hpp"
#include "setting.hpp"

namespace walkthrough {

struct Flight {
    std::vector<farfield::Camera> cameras;  ///< one a frame
    std::vector<int> quality_frames;        ///< whose pictures are compared and kept: at most eight, evenly spaced
};

/// A closed path through the scene, the path or the descent where the setting has one, the path that the options name,
/// or the same view again and again where they give a distance.
Flight plan_flight(const Setting& setting, const Options& options);

}  // namespace walkthrough
