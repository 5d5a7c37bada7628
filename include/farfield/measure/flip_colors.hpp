// The colors of FLIP and how far apart they are; see flip.hpp for the paper.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>
#include <glm/vec3.hpp>

#include "farfield/geometry/rgba8.hpp"

namespace farfield::detail {

/// YCxCz is used without its factors and offsets (Y here is (Y + 16) / 116 there): filters take means, which do not see
/// them.
struct FlipColors {
    /// Linear sRGB to X, Y and Z, each over that of white, D65.
    const glm::dmat3 xyz_from_rgb = glm::transpose(glm::dmat3(glm::dvec3(10135552, 8788810, 4435075) / 23359437.0,
                                                              glm::dvec3(2613072, 8788810, 887015) / 12288897.0,
                                                              glm::dvec3(1425312, 8788810, 70074185) / 80288307.0));
    const glm::dmat3 opponent_from_xyz{0, 1, 0, 1, -1, 1, 0, 0, -1};  ///< Y, X - Y and Y - Z; by columns
    const glm::dmat3 opponent_from_rgb = opponent_from_xyz * xyz_from_rgb;
    const glm::dmat3 rgb_from_opponent = glm::inverse(opponent_from_rgb);
    std::array<double, 256> linear{};
    double largest_distance = 0;

    FlipColors() {
        for (std::size_t i = 0; i < linear.size(); ++i) {
            const double c = static_cast<double>(i) / 255;
            linear[i] = c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4);
        }
        largest_distance = distance(hunt_lab({0, 1, 0}), hunt_lab({0, 0, 1}));
    }

    glm::dvec3 opponent(Rgba8 c) const { return opponent_from_rgb * glm::dvec3(linear[c.r], linear[c.g], linear[c.b]); }

    /// L*a*b* with the dark colors less colorful, Hunt's effect (section "Perceptually Uniform Color Space").
    glm::dvec3 hunt_lab(const glm::dvec3& rgb) const {
        const auto f = [](double t) {
            constexpr double delta = 6.0 / 29;
            return t > delta * delta * delta ? std::cbrt(t) : t / (3 * delta * delta) + 4.0 / 29;
        };
        const glm::dvec3 xyz = xyz_from_rgb * rgb;
        const double y = f(xyz.y);
        const double lightness = 116 * y - 16;
        return {lightness, 0.01 * lightness * 500 * (f(xyz.x) - y), 0.01 * lightness * 200 * (y - f(xyz.z))};
    }

    /// HyAB to the power 0.7 (section "Color Metric"): city block in lightness, Euclidean in the plane of hues.
    static double distance(const glm::dvec3& a, const glm::dvec3& b) {
        const glm::dvec3 d = a - b;
        return std::pow(std::abs(d.x) + std::sqrt(d.y * d.y + d.z * d.z), 0.7);
    }

    /// Distances redistributed to [0, 1]: those below 0.4 of the largest get 0.95 of the range.
    double error(const glm::dvec3& a, const glm::dvec3& b) const {
        constexpr double knee = 0.4, at_knee = 0.95;
        const double part = distance(a, b) / largest_distance;
        if (part < knee) return part * (at_knee / knee);
        return std::min(at_knee + (part - knee) / (1 - knee) * (1 - at_knee), 1.0);
    }
};

}  // namespace farfield::detail
