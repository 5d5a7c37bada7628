// Small scenes of triangles that are easy to say something exact about.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <vector>

#include "farfield/primitive/triangle.hpp"
#include "support/random.hpp"

namespace farfield::test {

using Triangles = std::vector<Triangle>;

/// Centers in [-1, 1] on each axis; corners within `size` of them.
inline Triangles random_triangles(std::size_t count, std::uint64_t seed, float size = 0.06f) {
    Random random(seed);
    Triangles out(count);
    for (Triangle& t : out) {
        const glm::vec3 center = random.in_cube(1);
        for (glm::vec3& v : t.vertices) v = center + random.in_cube(size);
        t.rgba = random.color();
    }
    return out;
}

/// Everything at once: many tiny, some medium, a few as large as the scene, in clusters; with duplicates.
inline Triangles mixed_triangles(std::size_t count, std::uint64_t seed) {
    Random random(seed);
    Triangles out(count);
    glm::vec3 cluster(0);
    for (std::size_t i = 0; i < count; ++i) {
        if (i % 97 == 0) cluster = random.in_cube(1);
        const float size = i % 401 == 0 ? 1.0f : i % 53 == 0 ? 0.2f : 0.02f;
        const glm::vec3 center = i % 2 == 0 ? cluster + random.in_cube(0.12f) : random.in_cube(1);
        for (glm::vec3& v : out[i].vertices) v = center + random.in_cube(size);
        out[i].rgba = random.color();
        if (i % 89 == 88) out[i] = out[i - 1];
    }
    return out;
}

/// The rectangle corner + [0, 1] u + [0, 1] v as nu x nv quads of two triangles, counter-clockwise about u x v.
inline Triangles sheet(glm::vec3 corner, glm::vec3 u, glm::vec3 v, int nu, int nv, Rgba8 color) {
    Triangles out;
    const auto at = [&](int i, int j) { return corner + u * (float(i) / float(nu)) + v * (float(j) / float(nv)); };
    for (int j = 0; j < nv; ++j) {
        for (int i = 0; i < nu; ++i) {
            out.push_back({{at(i, j), at(i + 1, j), at(i + 1, j + 1)}, color});
            out.push_back({{at(i, j), at(i + 1, j + 1), at(i, j + 1)}, color});
        }
    }
    return out;
}

/// A closed sphere of about 2 * n * n triangles.
inline Triangles sphere(glm::vec3 center, float radius, int n, Rgba8 color) {
    Triangles out;
    const auto at = [&](int i, int j) {
        const float polar = 3.14159265f * float(j) / float(n), azimuth = 6.2831853f * float(i % (2 * n)) / float(2 * n);
        if (j == 0) return center + glm::vec3(0, radius, 0);
        if (j == n) return center - glm::vec3(0, radius, 0);
        return center + radius * glm::vec3(std::sin(polar) * std::cos(azimuth), std::cos(polar),
                                           std::sin(polar) * std::sin(azimuth));
    };
    for (int j = 0; j < n; ++j) {
        for (int i = 0; i < 2 * n; ++i) {
            if (j + 1 < n) out.push_back({{at(i, j), at(i + 1, j + 1), at(i, j + 1)}, color});
            if (j > 0) out.push_back({{at(i, j), at(i + 1, j), at(i + 1, j + 1)}, color});
        }
    }
    return out;
}

/// p -> scale * p + offset.
inline Triangles moved(Triangles triangles, float scale, glm::vec3 offset = glm::vec3(0)) {
    for (Triangle& t : triangles) {
        for (glm::vec3& v : t.vertices) v = v * scale + offset;
    }
    return triangles;
}

inline void append(Triangles& to, const Triangles& from) {
    to.insert(to.end(), from.begin(), from.end());
}

}  // namespace farfield::test
