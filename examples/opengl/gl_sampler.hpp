// The samples that color cubes are built from, taken by OpenGL: "a color-cube is created by rendering its list of
// associated primitives to the screen, using an orthographic projection through each of its six faces" (Chamberlain et
// al. 1996, section 4).
//
//     using H = SpatialHierarchy<Octree, ColorCube, TriangleCount>;
//     build<H>(triangles, BuildOptions<H, GlSampler>{.sampler = GlSampler(light)})
#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "farfield/geometry/length.hpp"
#include "farfield/geometry/light.hpp"
#include "farfield/geometry/polygon.hpp"
#include "farfield/sampler.hpp"

namespace farfield::opengl {

/// Models OrthographicSampler as GridSampler does, whose samples these are but at edges, where each driver rounds in
/// its own way, and where colors between vertices differ by one or are translucent. A context is of one thread: build
/// on the one that it is current in, without an executor. All sides and slabs of a cell are one draw and one read-back,
/// and waiting for that is what takes the time: it pays where leaves hold many triangles.
class GlSampler {
  public:
    std::optional<DirectionalLight> light;

    /// Throws std::runtime_error, one line, where the current context is not OpenGL 4.5 core.
    explicit GlSampler(std::optional<DirectionalLight> l = {});

    const char* wrong_option() const { return light ? wrong_light(*light) : nullptr; }
    float brightness(const Polygon& polygon, glm::vec3 facing_viewer) const {
        return brightness_of(light, polygon, facing_viewer);
    }

    /// Throws std::runtime_error for a grid of more samples along a side than textures have texels.
    template <class Visit>
    void sample(const SampleGrid& grid, Visit&& visit, std::span<Rgba8> out) {
        corners_.clear();
        visit([&](const Polygon& polygon) { add(polygon); });
        draw(grid, out);
    }

    /// A triangle's corner: its colors as its two sides show it, premultiplied.
    struct Corner {
        glm::vec3 place;
        Rgba8 front, back;
    };

  private:
    struct Objects;

    void add(const Polygon& polygon);
    void draw(const SampleGrid& grid, std::span<Rgba8> out);

    std::shared_ptr<Objects> objects_;  ///< one set for all copies, which are of one context
    std::vector<Corner> corners_;
};

}  // namespace farfield::opengl
