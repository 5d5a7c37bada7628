// How long an image will serve a viewer who goes where it is expected to go (Shade et al. 1996, section 3).
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <optional>
#include <span>

#include "farfield/frame/cell_image.hpp"
#include "farfield/frame/safety_zone.hpp"
#include "farfield/image_cache_options.hpp"
#include "farfield/view/local_view.hpp"

namespace farfield::detail {

/// Where the viewer will be, from the current frame on, in world units along right, up and forward of its view.
struct ExpectedPath {
    glm::vec3 step{0};                   ///< a frame, as in the last one
    std::uint32_t steady_frames = 0;     ///< for so many it has been about the same
    std::span<const glm::vec3> known{};  ///< where it is known: from here to the next frame's eye, the one after, ...
    static constexpr std::uint32_t farthest = 1024;  ///< frames looked ahead

    /// The displacement after k frames, k >= 1.
    glm::vec3 after(std::uint32_t k) const {
        if (known.empty()) return step * float(k);
        return known[std::min<std::size_t>(k, known.size()) - 1];
    }
    /// Frames for which it can be relied on: whoever swings to and fro is never where the last motion leads for long.
    std::uint32_t sure_frames() const {
        return known.empty() ? steady_frames : std::uint32_t(std::min<std::size_t>(known.size(), farthest));
    }
};

/// An image serves while it is good. How the viewer turns is not foreseen: that cells may be out of sight before is
/// left out, which gained nothing (0.97 to 1.05 times as fast).
class ImageLife {
  public:
    ImageLife(const ImageCacheOptions& options, const ExpectedPath& path) : options_(options), path_(path) {}

    /// False only if an image serves for at most so many frames, the one that it is made in among them.
    bool may_serve(const CellImage& image, const LocalView& view, float frames) const {
        if (!(frames < float(ExpectedPath::farthest + 1))) return false;
        const auto later = std::uint32_t(frames);
        return later == 0 || is_bounded(view) || serves_after(later, image, view);
    }
    /// The number of frames to come in which an image serves.
    std::uint32_t frames_served(CellImage image, const LocalView& view) const {
        if (is_bounded(view)) {
            set_safety_zone(image, view, options_);
            return frames_within(image.safe_radius * view.scale, options_.most_speed, options_.most_acceleration,
                                 ExpectedPath::farthest);
        }
        return life_span(ExpectedPath::farthest, [&](std::uint32_t k) { return serves_after(k, image, view); });
    }
    /// Whether it is no longer good so many frames from now.
    bool is_over_after(std::uint32_t frames, const CellImage& image, const LocalView& view) const {
        return !serves_after(frames, image, view);
    }

    /// From where an image is made and for how many frames it then serves, the one that it is made in among them.
    struct Service {
        std::uint32_t ahead = 0, lives = 1;
    };
    /// An image is good around where it is made from. Made from where the viewer will be in a while, it is good before
    /// and after. `planned` is the image that `view` would make, `planned_from(view)` one that another would, if there
    /// is one.
    template <class PlannedFrom>
    Service service(const CellImage& planned, const LocalView& view, PlannedFrom&& planned_from) const {
        const std::uint32_t served = frames_served(planned, view);
        Service best{0, 1 + served};
        const std::uint32_t ahead = frames_ahead(served, view, planned_from);
        if (ahead == 0) return best;
        const CellImage image = *planned_from(view.moved(way(ahead, view)));
        const Service from_there{ahead, 1 + frames_served(image, view)};
        return from_there.lives > best.lives ? from_there : best;
    }
    /// From how many frames ahead to make an image that, made from here, serves for so many. 0: from here.
    template <class PlannedFrom>
    std::uint32_t frames_ahead(std::uint32_t served, const LocalView& view, PlannedFrom&& planned_from) const {
        if (!view.is_perspective || is_bounded(view)) return 0;
        const auto most = std::uint32_t(std::ceil(options_.most_ahead * float(served)));
        for (std::uint32_t frames = std::min(most, path_.sure_frames()); frames > 0; frames /= 2) {
            const glm::vec3 moved = way(frames, view);
            if (moved == glm::vec3(0)) return 0;
            const std::optional<CellImage> image = planned_from(view.moved(moved));
            if (image && is_good(*image, view, options_)) return frames;
        }
        return 0;
    }
    /// How the viewer moves in so many frames, in the view's own units.
    glm::vec3 way(std::uint32_t frames, const LocalView& view) const {
        const glm::vec3 moved = path_.after(frames);
        return (view.right * moved.x + view.up * moved.y + view.forward * moved.z) / view.scale;
    }

  private:
    /// Only the speed is known.
    bool is_bounded(const LocalView& view) const { return options_.most_speed > 0 && view.is_perspective; }
    bool serves_after(std::uint32_t frames, const CellImage& image, const LocalView& view) const {
        LocalView later = view;
        later.eye += way(frames, view);
        return is_good(image, later, options_);
    }

    const ImageCacheOptions& options_;
    const ExpectedPath& path_;
};

}  // namespace farfield::detail
