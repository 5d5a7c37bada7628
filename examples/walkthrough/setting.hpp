// The scene that was asked for, and what is known about showing it.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "farfield/camera.hpp"
#include "farfield/geometry/box.hpp"
#include "report/picture.hpp"
#include "scenes/scene.hpp"

namespace walkthrough {

struct Setting {
    farfield::scenes::Scene scene;
    std::string name;      ///< fit for file names
    farfield::Box bounds;  ///< not empty, finite
    farfield::report::Background background;
    /// Where a flight begins and ends that is not the one for any scene: from above down to the ground.
    std::optional<std::pair<farfield::Camera, farfield::Camera>> descent;
    /// A path that goes with the scene, of so many frames. Empty: the one for any scene.
    std::function<std::vector<farfield::Camera>(int frames)> path;
    bool culls_back_faces = false;  ///< all surfaces are closed and counter-clockwise from outside
};

/// A name of the catalog, or a file, with what is up in it; so many times in rows. Throws UsageError.
Setting make_setting(const std::string& scene, std::optional<glm::vec3> up = {}, std::uint32_t copies = 1);

}  // namespace walkthrough
