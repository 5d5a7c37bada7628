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
#include "farfield/wanted_error.hpp"

namespace farfield {

/// The distance of a cell that its error depends on. `nearest_point` of its box is safe in every direction of view;
/// `depth` along the viewing direction is that of Chamberlain 1995, section 3.1, whose levels change at planes.
enum class DistanceMeasure : std::uint8_t { nearest_point, depth };

/// Where a picture lies in a larger one, in pixels, first row topmost.
struct PartOfPicture {
    int left = 0, top = 0;
    int whole_width = 0, whole_height = 0;  ///< 0: it is no part, but whole
    bool is_whole() const { return whole_width == 0; }
};

/// The settings of one frame.
struct View {
    Camera camera;
    int width = 512;  ///< image size in pixels
    int height = 512;
    /// A stand-in is drawn where its error is at most this many pixels; 0 draws every primitive exactly.
    float tolerance_px = 1;
    /// 0 to 1: each cell's own tolerance is smaller by up to this part, chosen by a hash of its place. Cells of a level
    /// then change one by one, over a range of distances, and not all in one frame. 0: all have the same.
    float tolerance_jitter = 0;
    /// 0 to 1: where a stand-in's error is within this part of its tolerance, what replaces it is drawn as well, both
    /// fainter, so that one becomes the other over a range of distances. Primitives are not drawn faintly: they come
    /// and go one by one. 0: stand-ins are drawn, or not.
    float fade = 0;
    DistanceMeasure distance = DistanceMeasure::nearest_point;
    /// Set by tile(): the camera then shows the larger picture, and this is a part of it.
    PartOfPicture part{};
    /// Nothing stands in that is expected to err more, whatever the tolerance allows, where the approximation says what
    /// it errs by (ApproximationFacts::expects_error). Where no more is wanted than point sampling gives, primitives
    /// are point sampled, small ones included, and stand-ins are drawn only where that costs less: a frame is then
    /// seldom slower than an exact one, though what is expected is not always so (bench/README.md). FrameStats says
    /// what was chosen.
    WantedError wanted = WantedError::any();

    /// The size of the picture that the camera shows.
    int whole_width() const { return part.is_whole() ? width : part.whole_width; }
    int whole_height() const { return part.is_whole() ? height : part.whole_height; }

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
        demand(tolerance_jitter >= 0 && tolerance_jitter <= 1, "tolerance_jitter must be 0 to 1");
        demand(fade >= 0 && fade <= 1, "fade must be 0 to 1");
        demand(distance == DistanceMeasure::nearest_point || distance == DistanceMeasure::depth,
               "distance must be nearest_point or depth");
        demand(!wanted.rmse || *wanted.rmse >= 0, "a wanted error must be 0 or more");
        demand(wanted.samples >= 1, "wanted samples must be 1 or more");
        if (part.is_whole()) {
            demand(part.left == 0 && part.top == 0 && part.whole_height == 0, "part must name the whole's size");
        } else {
            const auto lies_in = [](int first, int size, int whole) { return first >= 0 && first <= whole - size; };
            demand(lies_in(part.left, width, part.whole_width) && lies_in(part.top, height, part.whole_height),
                   "part must lie in the whole picture");
        }
    }

    /// The view of a rectangle of this view's pixels, first row topmost. Pictures of tiles, side by side, are the whole
    /// picture, byte for byte: what stands in is chosen for the whole, and every sample lies where it lies in the
    /// whole. (Not so in a MergedViewer: it cuts bodies for what a tile shows, and cuts round.) Throws
    /// std::invalid_argument for a rectangle that has no pixels or leaves the picture.
    View tile(int left, int top, int tile_width, int tile_height) const {
        validate();
        if (tile_width < 1 || tile_height < 1)
            detail::fail<std::invalid_argument>("farfield::View: a tile must have 1 pixel or more");
        if (left < 0 || top < 0 || left > width - tile_width || top > height - tile_height)
            detail::fail<std::invalid_argument>("farfield::View: a tile must lie in the picture");
        View v = *this;
        v.part = {part.left + left, part.top + top, whole_width(), whole_height()};
        v.width = tile_width;
        v.height = tile_height;
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
    std::uint64_t images = 0;          ///< cells drawn by an image of them
    std::uint64_t images_made = 0;     ///< of them in this frame, or of cells whose image another holds
    std::uint64_t image_bytes = 0;     ///< the memory of all that are kept, at most
    std::uint64_t cells_visited = 0;
    std::uint64_t cells_outside = 0;                         ///< culled by the frustum
    std::uint64_t cells_hidden = 0;                          ///< culled because the renderer said so
    std::uint64_t cells_too_coarse = 0;                      ///< whose stand-ins err more than is wanted
    std::uint64_t cells_needing_samples = 0;                 ///< of these: the error cannot be had, see WantedError
    std::uint64_t cells_cheaper = 0;                         ///< drawn exactly because that costs less
    std::uint64_t cells_missing = 0;                         ///< drawn coarser than wanted: their page is not there
    std::uint64_t instances = 0;                             ///< instances entered
    std::uint64_t touched_bytes = 0;                         ///< working set: nodes, stand-ins and item indices read
    std::uint64_t approximations_by_level[max_levels] = {};  ///< by depth in their own hierarchy

    /// Whether all that was drawn are primitives.
    bool is_exact() const { return approximations == 0 && images == 0; }

    FrameStats& operator+=(const FrameStats& other) {
        for (const auto count :
             {&FrameStats::primitives, &FrameStats::runs, &FrameStats::approximations, &FrameStats::faces,
              &FrameStats::splats, &FrameStats::images, &FrameStats::images_made, &FrameStats::image_bytes,
              &FrameStats::cells_visited, &FrameStats::cells_outside, &FrameStats::cells_hidden,
              &FrameStats::cells_too_coarse, &FrameStats::cells_needing_samples, &FrameStats::cells_cheaper,
              &FrameStats::cells_missing, &FrameStats::instances, &FrameStats::touched_bytes}) {
            this->*count += other.*count;
        }
        for (int i = 0; i < max_levels; ++i) approximations_by_level[i] += other.approximations_by_level[i];
        return *this;
    }
};

}  // namespace farfield
