// Placing one hierarchy inside another: rotation, uniform scale, translation.
#pragma once

#include <cmath>
#include <glm/mat3x3.hpp>
#include <glm/mat4x4.hpp>
#include <glm/matrix.hpp>
#include <glm/vec3.hpp>
#include <limits>
#include <stdexcept>

#include "farfield/fail.hpp"
#include "farfield/geometry/box.hpp"

namespace farfield {

/// p -> scale * rotation * p + translation. Only similarities place instances: under any other map an error of one
/// pixel in the instance is not one error in the picture but one for each direction, and a stand-in baked with one
/// bound would lie. Non-uniform scale is therefore refused, not bounded; bake it into the primitives instead.
struct Similarity {
    glm::mat3 rotation{1.0f};  ///< orthonormal, determinant +1
    float scale = 1;           ///< above 0
    glm::dvec3 translation{0.0};

    Similarity() = default;
    /// Throws std::invalid_argument unless the matrix is a similarity that keeps handedness, to within the rounding
    /// of single-precision matrix products.
    explicit Similarity(const glm::dmat4& m) {
        const glm::dmat3 linear(m);
        const double determinant = glm::determinant(linear);
        const double s = std::cbrt(determinant);
        const glm::dmat3 unit = linear * (1.0 / s);
        const glm::dmat3 gram = glm::transpose(unit) * unit;
        constexpr double rounding = 256.0 * double(std::numeric_limits<float>::epsilon());
        bool similar = s > 0 && std::isnormal(float(s)) && m[0][3] == 0 && m[1][3] == 0 && m[2][3] == 0 && m[3][3] == 1;
        for (int i = 0; i < 3; ++i) {
            similar = similar && std::isfinite(m[3][i]);
            for (int j = 0; j < 3; ++j) similar = similar && std::abs(gram[i][j] - (i == j ? 1.0 : 0.0)) <= rounding;
        }
        if (!similar) {
            detail::fail<std::invalid_argument>(
                "farfield::Similarity: an instance's transform must be rotation, uniform scale and translation");
        }
        rotation = glm::mat3(unit);
        scale = float(s);
        translation = glm::dvec3(m[3]);
    }
    explicit Similarity(const glm::mat4& m) : Similarity(glm::dmat4(m)) {}

    glm::dvec3 apply(glm::dvec3 p) const { return glm::dmat3(rotation) * p * double(scale) + translation; }

    /// The smallest box around the image of a box; never smaller than the image of the contents.
    BoxD apply(const BoxD& box) const {
        if (box.is_empty()) return BoxD::empty();
        const glm::dmat3 r(rotation);
        const glm::dmat3 absolute(glm::abs(r[0]), glm::abs(r[1]), glm::abs(r[2]));
        const glm::dvec3 c = apply(box.center());
        const glm::dvec3 half = absolute * (box.size() * 0.5) * double(scale);
        return {c - half, c + half};
    }
};

}  // namespace farfield
