// A scene in one variant's hierarchies, as the rest of the program sees it: without knowing their types.
#pragma once

#include <cstdint>
#include <memory>

#include "farfield/raster/image.hpp"
#include "farfield/raster/z_buffer_renderer.hpp"
#include "farfield/view.hpp"

namespace farfield::scenes {

struct BuildFacts {
    double seconds = 0;       ///< of building all hierarchies, on one thread
    std::uint64_t bytes = 0;  ///< of all hierarchies; one that is placed many times counts once, like below
    std::uint64_t cells = 0;
    std::uint32_t levels = 0;  ///< of the deepest hierarchy
};

/// Draws frames of a BuiltScene, which outlives it.
class SceneViewer {
  public:
    virtual ~SceneViewer() = default;
    virtual FrameStats frame(const View& view) = 0;
    /// Of the last frame; premultiplied, coverage in alpha.
    virtual const Image& image() const = 0;
};

class BuiltScene {
  public:
    virtual ~BuiltScene() = default;
    virtual std::unique_ptr<SceneViewer> viewer(const ZBufferOptions& options) const = 0;
    const BuildFacts& facts() const { return facts_; }

  protected:
    BuildFacts facts_;
};

}  // namespace farfield::scenes
