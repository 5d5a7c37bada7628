// A type of your own: it plugs in by having members of the right names. Only bounds() is required; polygons() is what
// color cubes and the z-buffer ask for, work() says that a ball costs more than a triangle.
#pragma once

#include <cmath>
#include <glm/vec3.hpp>
#include <numbers>

#include "farfield/primitive.hpp"

struct Ball {
    glm::vec3 center{0};
    float radius = 1;
    farfield::Rgba8 rgba{};

    farfield::Box bounds() const { return {center - radius, center + radius}; }

    farfield::Work work() const { return {.triangles = 2 * rings * slices}; }

    /// Quadrangles between circles of latitude; those at the poles have two corners in one place, which is legal.
    template <class Sink>
    void polygons(Sink&& sink) const {
        for (int ring = 0; ring < rings; ++ring) {
            for (int slice = 0; slice < slices; ++slice) {
                const glm::vec3 corners[] = {at(ring, slice), at(ring, slice + 1), at(ring + 1, slice + 1),
                                             at(ring + 1, slice)};
                sink(farfield::Polygon{corners, {&rgba, 1}});
            }
        }
    }

  private:
    static constexpr int rings = 6, slices = 12;

    glm::vec3 at(int ring, int slice) const {
        const float latitude = std::numbers::pi_v<float> * float(ring) / rings;
        const float longitude = 2 * std::numbers::pi_v<float> * float(slice % slices) / slices;
        return center + radius * glm::vec3(std::sin(latitude) * std::sin(longitude), -std::cos(latitude),
                                           std::sin(latitude) * std::cos(longitude));
    }
};

static_assert(farfield::PrimitiveWithPolygons<Ball> && farfield::PrimitiveWithWork<Ball>);
