// Draws a forest along a path in an engine's own ways and by farfield, and prints what each takes and errs by.
#pragma once

#include <array>
#include <cstddef>
#include <functional>
#include <memory>
#include <string>

#include "engines/forest.hpp"
#include "farfield/image.hpp"
#include "farfield/view.hpp"

namespace farfield::engines {

/// A window that nobody sees, with one scene in it.
class Stage {
  public:
    virtual ~Stage() = default;
    /// In milliseconds, to the end of glFinish or what is like it.
    virtual double frame(const Eye& eye) = 0;
    /// Of the last frame; opaque.
    virtual const Image& picture() const = 0;
    /// Of the last frame, where farfield drew it.
    virtual FrameStats stats() const { return {}; }
};

struct Way {
    std::string name;  ///< its first word names pictures
    std::function<std::unique_ptr<Stage>(int width, int height)> stage;
};

/// The first way is plain, the last farfield; two lie between. Called in processes of their own too, of which each
/// starts the engine if that has to be started.
inline constexpr std::size_t way_count = 4;
using WaysOf = std::function<std::array<Way, way_count>(const Forest&, float tolerance_px)>;

/// A program: what main() returns.
int compare(int argc, char** argv, const std::string& engine, const WaysOf& ways_of);

/// The mean over squares of pixels.
Image mean_picture(const Image& fine, int side);

}  // namespace farfield::engines
