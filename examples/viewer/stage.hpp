// What is looked at: a scene, and its hierarchies as far as somebody has asked for them.
#pragma once

#include <cstddef>
#include <functional>
#include <glm/vec3.hpp>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "farfield/camera.hpp"
#include "farfield/geometry/box.hpp"
#include "farfield/view.hpp"
#include "report/picture.hpp"
#include "scenes/built_scene.hpp"
#include "scenes/camera_path.hpp"
#include "scenes/renderers/renderer_choice.hpp"

namespace viewer {

using BuiltPtr = std::shared_ptr<const farfield::scenes::BuiltScene>;

/// One way to draw a scene; exact is the first.
struct StageVariant {
    std::string name, description;
    farfield::DistanceMeasure distance = farfield::DistanceMeasure::nearest_point;
    std::function<BuiltPtr(const farfield::scenes::SceneProgress&)> build;
    /// Empty where the renderer can draw it.
    std::function<std::string(farfield::scenes::RendererKind)> obstacle;
};

struct Stage {
    std::string name;   ///< fit for file names
    std::string where;  ///< as it was asked for
    std::string what;   ///< how much there is
    std::vector<std::string> notes{};
    farfield::BoxD bounds;
    glm::dvec3 up{0, 1, 0};
    farfield::report::Background background{};
    bool culls_back_faces = false;
    bool is_paged = false;  ///< exact is what fits into the cache, and there is one variant
    std::vector<StageVariant> variants;
    /// Through the scene, as the walkthrough flies; empty: there is none.
    std::function<farfield::scenes::CameraPath()> flight{};
    /// Where to look from at first; none: all of it is framed.
    std::optional<farfield::Camera> start{};
};

/// A name of the catalog, a file that the walkthrough takes, or a file of pages, here or at an http:// address. Throws
/// std::runtime_error, one line.
std::shared_ptr<const Stage> open_stage(const std::string& where, std::size_t cache_mib);

}  // namespace viewer
