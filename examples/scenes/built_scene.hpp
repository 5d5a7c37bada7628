// A scene in one variant's hierarchies, as the rest of the program sees it: without knowing their types.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <glm/vec2.hpp>
#include <memory>
#include <optional>
#include <span>
#include <stdexcept>
#include <vector>

#include "farfield/frame/frame_budget.hpp"
#include "farfield/tuning/measure_frame_prices.hpp"
#include "farfield/view.hpp"
#include "scenes/looked_at.hpp"
#include "scenes/renderers/any_renderer.hpp"

namespace farfield::scenes {

struct BuildFacts {
    double seconds = 0;       ///< of building all hierarchies, on one thread
    std::uint64_t bytes = 0;  ///< of all hierarchies; one that is placed many times counts once, like below
    std::uint64_t cells = 0;
    std::uint32_t levels = 0;  ///< of the deepest hierarchy
    /// What is drawn comes in strict order, so that coverage masks need not compare depths.
    bool keeps_strict_order = false;
    std::uint64_t cells_over_piece_budget = 0;  ///< as BuildReport's
};

/// Gets told from time to time what part of a build is done; returning false ends it with BuildCanceled.
using SceneProgress = std::function<bool(double part)>;

/// Draws frames of a BuiltScene, which outlives it.
class SceneViewer {
  public:
    virtual ~SceneViewer() = default;
    virtual FrameStats frame(const View& view) = 0;
    /// The best that a budget pays for. Throws std::invalid_argument where it is not one viewer, on one thread, that
    /// draws.
    virtual FrameStats frame_within(const FrameBudget&, const View&) { refuse_budgets(); }
    /// Draws these views coarser and finer, to learn what frames like them cost. Throws as that does.
    virtual std::vector<MeasuredFrame> measured(std::span<const View>, const FramePriceOptions&) { refuse_budgets(); }
    /// What frame() draws, geometry in gray and stand-ins, if there are any, tinted by level; premultiplied, coverage
    /// in alpha.
    virtual Image how_drawn(const View& view) {
        frame(view);
        return image();
    }
    /// What the last frame drew, from outside, where RendererChoice::looks_on and cells were drawn by images (Shade et
    /// al. 1996, figure 3(c)); null of others. From a view of the caller's own, if there is one, whatever was drawn.
    virtual const Image* from_outside([[maybe_unused]] const View* from = nullptr) { return nullptr; }
    /// The cells that frame(), which was called last, draws a view by, those among them that it knew to be hidden, and
    /// some that were culled beside the picture, if they are wanted: at most `most` of each, the largest.
    virtual std::vector<CellOutline> cells([[maybe_unused]] const View& view, [[maybe_unused]] std::size_t most,
                                           [[maybe_unused]] bool wants_outside) {
        return {};
    }
    /// The last frame; premultiplied, coverage in alpha.
    virtual const Image& image() const = 0;
    /// OpenGL's name of the texture that the last frame was drawn into, rows from the top, in the context that drew it;
    /// 0: there is none.
    virtual unsigned texture() const { return 0; }
    /// What the last frame sent to the GPU.
    virtual std::uint64_t sent_bytes() const { return 0; }
    /// Of the last frame: of coverage masks, null of others.
    virtual const CoverageWork* work() const { return nullptr; }
    /// The same with the places, where RendererChoice::maps_work.
    virtual const CoverageWorkImage* work_map() const { return nullptr; }

  private:
    [[noreturn]] static void refuse_budgets() {
        throw std::invalid_argument("a budget of time is kept by one thread: take --threads 1");
    }
};

class BuiltScene {
  public:
    virtual ~BuiltScene() = default;
    /// Throws std::invalid_argument, one line, where the renderer cannot draw it: where obstacle() of its type says so,
    /// where something lacks the order that the renderer needs, or for samples that it does not take.
    virtual std::unique_ptr<SceneViewer> viewer(const RendererChoice& choice) const = 0;
    /// What lies under a point of the view's picture.
    virtual std::optional<PickedInScene> pick(const View& view, glm::dvec2 pixel) const = 0;
    const BuildFacts& facts() const { return facts_; }

  protected:
    BuildFacts facts_;
};

}  // namespace farfield::scenes
