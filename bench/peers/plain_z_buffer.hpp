// The z-buffer that "times faster" on our pages is counted against. It shares no code with the library's: a loop over
// triangles, as a capable engineer writes it in an afternoon for the machine on the desk.
#pragma once

#include <cstdint>
#include <memory>
#include <span>

#include "farfield/image.hpp"
#include "farfield/view/local_view.hpp"

namespace farfield::bench {

/// A triangle of one color, packed: 40 bytes, and no order of them is needed.
struct PlainTriangle {
    float vertices[3][3];
    Rgba8 rgba;  ///< alpha is not looked at
};

/// Draws both sides of triangles over nothing. Samples lie on a regular grid, and one pixel is the mean of its square
/// of them. Views must be perspective.
class PlainZBuffer {
  public:
    virtual ~PlainZBuffer() = default;
    virtual void begin_frame(const LocalView& view) = 0;
    virtual void set_view(const LocalView& view) = 0;  ///< of an instance
    virtual void draw(std::span<const PlainTriangle> triangles) = 0;
    virtual void end_frame() = 0;
    virtual const Image& image() const = 0;
};

/// `samples_a_side` is 1 or 8. The first is what any program gets from the same compiler, the second is compiled for
/// the processor that compiles it (-march=native) and is the yardstick.
std::unique_ptr<PlainZBuffer> portable_plain_z_buffer(int samples_a_side);
std::unique_ptr<PlainZBuffer> native_plain_z_buffer(int samples_a_side);

}  // namespace farfield::bench
