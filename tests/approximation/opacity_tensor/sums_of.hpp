// Sums of triangles in a cell, for the tests of this folder.
#pragma once

#include "farfield/approximation/opacity_tensor.hpp"
#include "farfield/sampler/grid_sampler.hpp"
#include "support/scenes.hpp"

namespace farfield::test {

/// A cell two units wide at the origin; its bounds are `looseness` times as large.
inline Cell unit_cell(float looseness = 1) {
    Cell c;
    c.half = glm::vec3(1);
    c.bounds_half = glm::vec3(looseness);
    return c;
}

inline TensorSums sums_of(const Cell& cell, const Triangles& triangles, const OpacityTensor& a = {}) {
    GridSampler sampler;
    return a.sample(
        cell,
        [&](auto&& sink) {
            for (const Triangle& t : triangles) t.polygons(sink);
        },
        sampler);
}

}  // namespace farfield::test
