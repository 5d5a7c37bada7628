// The viewer, the picture's size and its tolerance: everything that a user says once a frame.
#pragma once

#include "farfield/settings.hpp"

#include <cmath>
#include <cstdint>
#include <glm/vec2.hpp>
#include <stdexcept>
#include <string>

#include "farfield/camera.hpp"
#include "farfield/camera_from_matrices.hpp"
#include "farfield/fail.hpp"

namespace farfield {

/// The distance of a cell that its error depends on. `nearest_point` of its box is safe in every direction of view;
/// `depth` along the viewing direction is that of Chamberlain 1995, section 3.1, whose levels change at planes.
enum class DistanceMeasure : std::uint8_t { nearest_point, depth };

/// The settings of one frame.
struct View {
    Camera camera;
    int width = 512;  ///< image size in pixels
    int height = 512;
    /// A stand-in is drawn where its error is at most this many pixels; 0 draws every primitive exactly.
    float tolerance_px = 1;
    DistanceMeasure distance = DistanceMeasure::nearest_point;

    /// Throws std::invalid_argument that names the first field, the camera's included, that makes no picture. Every
    /// frame begins with it, whatever the renderer.
    void validate() const {
        const auto demand = [](bool holds, const char* what) {
            if (!holds) detail::fail<std::invalid_argument>(std::string("farfield::View: ") + what);
        };
        camera.validate();
        demand(width >= 1, "width must be 1 or more");
        demand(height >= 1, "height must be 1 or more");
        demand(tolerance_px >= 0 && std::isfinite(tolerance_px), "tolerance_px must be 0 or more and finite");
        demand(distance == DistanceMeasure::nearest_point || distance == DistanceMeasure::depth,
               "distance must be nearest_point or depth");
    }

    /// The view of a rectangle of this view's pixels, first row topmost: pictures of tiles, side by side, are the whole
    /// picture. Throws std::invalid_argument for a rectangle without pixels.
    View tile(int left, int top, int tile_width, int tile_height) const {
        validate();
        if (tile_width < 1 || tile_height < 1)
            detail::fail<std::invalid_argument>("farfield::View: a tile must have 1 pixel or more");
        View v = *this;
        const glm::dvec2 part(double(tile_width) / width, double(tile_height) / height);
        const glm::dvec2 center((2.0 * left + tile_width - width) / tile_width,
                                (height - 2.0 * top - tile_height) / tile_height);
        v.width = tile_width;
        v.height = tile_height;
        v.camera.half_height = float(double(camera.half_height) * part.y);
        // Pixels that are square stay so without a width.
        v.camera.half_width = float(double(camera.half_width) * part.x);
        v.camera.off_center = center + camera.off_center / part;
        return v;
    }
};

/// The work that a frame did, in counts. Times are for the caller to take.
struct FrameStats {
    static constexpr int max_levels = 64;

    std::uint64_t primitives = 0;      ///< primitives handed to the renderer, instances excluded
    std::uint64_t runs = 0;            ///< ranges they were handed over in
    std::uint64_t approximations = 0;  ///< stand-ins drawn
    std::uint64_t faces = 0;           ///< far-field faces handed over
    std::uint64_t splats = 0;          ///< far-field deposits handed over
    std::uint64_t cells_visited = 0;
    std::uint64_t cells_outside = 0;                         ///< culled by the frustum
    std::uint64_t cells_hidden = 0;                          ///< culled because the renderer said so
    std::uint64_t instances = 0;                             ///< instances entered
    std::uint64_t touched_bytes = 0;                         ///< working set: nodes, stand-ins and item indices read
    std::uint64_t approximations_by_level[max_levels] = {};  ///< by depth in their own hierarchy
};

}  // namespace farfield
