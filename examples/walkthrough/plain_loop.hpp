// What a scene takes without any hierarchy: the plain z-buffer that benchmarks are counted against
// (bench/peers/plain_z_buffer.hpp), in one loop over all triangles.
#pragma once

#include <cstdint>
#include <memory>

#include "farfield/geometry/box.hpp"
#include "farfield/image.hpp"
#include "farfield/view.hpp"
#include "scenes/scene.hpp"

namespace walkthrough {

class PlainLoop {
  public:
    /// Nothing is copied but the triangles of groups, each once. Of instances so many are drawn that no more than
    /// about `most_triangles` are; the rest is counted.
    PlainLoop(const farfield::scenes::Scene& scene, int samples, std::uint64_t most_triangles = 32'000'000);
    ~PlainLoop();

    /// Whether pictures may have so many samples a pixel.
    static bool draws(int samples) { return samples == 1 || samples == 64; }

    /// The time of a frame of all triangles: that of those which are drawn, times triangles over triangles drawn.
    double ms(const farfield::View& view);
    /// Of those which are drawn.
    const farfield::Image& image() const;

    std::uint64_t triangles() const;        ///< in the scene
    std::uint64_t drawn_triangles() const;  ///< fewer: the rest is counted

  private:
    struct Parts;
    std::unique_ptr<Parts> parts_;
};

}  // namespace walkthrough
