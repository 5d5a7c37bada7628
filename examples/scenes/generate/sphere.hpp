// Closed spheres made of triangles, counter-clockwise seen from outside.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <utility>
#include <vector>

namespace farfield::scenes {

/// Three unit vectors a triangle.
using UnitSphere = std::vector<std::array<glm::vec3, 3>>;

/// Latitude and longitude, poles on y: 2 * slices * (bands - 1) triangles; slices >= 3, bands >= 2. Twenty
/// slices and twenty-one bands make 800.
inline UnitSphere latitude_longitude_sphere(std::size_t slices, std::size_t bands) {
    constexpr double pi = 3.14159265358979323846;
    const auto point = [&](std::size_t band, std::size_t slice) {
        if (band == 0) return glm::vec3(0, 1, 0);
        if (band == bands) return glm::vec3(0, -1, 0);
        const double polar = pi * static_cast<double>(band) / static_cast<double>(bands);
        // The last slice ends on the very bits the first begins with: no crack.
        const double azimuth = 2.0 * pi * static_cast<double>(slice % slices) / static_cast<double>(slices);
        return glm::vec3(static_cast<float>(std::sin(polar) * std::cos(azimuth)), static_cast<float>(std::cos(polar)),
                         static_cast<float>(std::sin(polar) * std::sin(azimuth)));
    };
    UnitSphere sphere;
    for (std::size_t band = 0; band < bands; ++band) {
        for (std::size_t slice = 0; slice < slices; ++slice) {
            const glm::vec3 a = point(band, slice), b = point(band + 1, slice);
            const glm::vec3 c = point(band + 1, slice + 1), d = point(band, slice + 1);
            if (band + 1 < bands) sphere.push_back({a, c, b});
            if (band > 0) sphere.push_back({a, d, c});
        }
    }
    return sphere;
}

/// An icosahedron with every triangle split into four `levels` times: 20 * 4^levels triangles.
inline UnitSphere icosphere(int levels) {
    const float p = 0.5f * (1.0f + std::sqrt(5.0f));
    const glm::vec3 v[12] = {{-1, p, 0},  {1, p, 0},  {-1, -p, 0}, {1, -p, 0}, {0, -1, p},  {0, 1, p},
                             {0, -1, -p}, {0, 1, -p}, {p, 0, -1},  {p, 0, 1},  {-p, 0, -1}, {-p, 0, 1}};
    constexpr int faces[20][3] = {{0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
                                  {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
                                  {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}};
    UnitSphere sphere;
    for (const auto& f : faces) {
        sphere.push_back({glm::normalize(v[f[0]]), glm::normalize(v[f[1]]), glm::normalize(v[f[2]])});
    }
    for (int level = 0; level < levels; ++level) {
        UnitSphere finer;
        finer.reserve(4 * sphere.size());
        for (const auto& [a, b, c] : sphere) {
            const glm::vec3 ab = glm::normalize(a + b), bc = glm::normalize(b + c), ca = glm::normalize(c + a);
            finer.push_back({a, ab, ca});
            finer.push_back({ab, b, bc});
            finer.push_back({ca, bc, c});
            finer.push_back({ab, bc, ca});
        }
        sphere = std::move(finer);
    }
    return sphere;
}

}  // namespace farfield::scenes
