// Placing one hierarchy inside another: rotation, uniform scale, translation.
#pragma once

#include "farfield/settings.hpp"

#include <cmath>
#include <glm/mat3x3.hpp>
#include <glm/mat4x4.hpp>
#include <glm/matrix.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <limits>
#include <stdexcept>

#include "farfield/fail.hpp"
#include "farfield/geometry/box.hpp"

namespace farfield {

/// p -> scale * rotation * p + translation. Only similarities place instances: under any other map an error of one
/// pixel in the instance is not one error in the picture but one for each direction, and a stand-in baked with one
/// bound would lie. Non-uniform scale is therefore refused, not bounded; bake it into the primitives instead.
class Similarity {
  public:
    glm::dvec3 translation{0.0};  ///< builds and viewers refuse what is not finite

    /// The identity.
    Similarity() = default;
    /// Throws std::invalid_argument unless the matrix is a similarity that keeps handedness, to within the rounding
    /// of single-precision matrix products.
    explicit Similarity(const glm::dmat4& m) {
        const glm::dmat3 linear(m);
        const double s = std::cbrt(glm::determinant(linear));
        if (!(s > 0) || glm::dvec4(m[0].w, m[1].w, m[2].w, m[3].w) != glm::dvec4(0, 0, 0, 1)) refuse();
        *this = Similarity(glm::mat3(linear * (1.0 / s)), float(s), glm::dvec3(m[3]));
    }
    explicit Similarity(const glm::mat4& m) : Similarity(glm::dmat4(m)) {}
    /// Throws std::invalid_argument unless `rotation` is orthonormal with determinant +1, to within the same rounding,
    /// `scale` above 0 and all finite.
    Similarity(const glm::mat3& rotation, float scale, const glm::dvec3& moved_by)
        : translation(moved_by), rotation_(rotation), scale_(scale) {
        const glm::dmat3 unit(rotation);
        const glm::dmat3 gram = glm::transpose(unit) * unit;
        constexpr double rounding = 256.0 * double(std::numeric_limits<float>::epsilon());
        bool similar = scale > 0 && std::isnormal(scale) && glm::determinant(unit) > 0;
        for (int i = 0; i < 3; ++i) {
            similar = similar && std::isfinite(translation[i]);
            for (int j = 0; j < 3; ++j) similar = similar && std::abs(gram[i][j] - (i == j ? 1.0 : 0.0)) <= rounding;
        }
        if (!similar) refuse();
    }

    const glm::mat3& rotation() const { return rotation_; }  ///< orthonormal, determinant +1
    float scale() const { return scale_; }                   ///< above 0

    bool is_finite() const {
        return std::isfinite(translation.x) && std::isfinite(translation.y) && std::isfinite(translation.z);
    }

    glm::dvec3 apply(glm::dvec3 p) const { return glm::dmat3(rotation_) * p * double(scale_) + translation; }

    /// The smallest box around the image of a box; never smaller than the image of the contents.
    BoxD apply(const BoxD& box) const {
        if (box.is_empty()) return BoxD::empty();
        const glm::dmat3 r(rotation_);
        const glm::dmat3 absolute(glm::abs(r[0]), glm::abs(r[1]), glm::abs(r[2]));
        const glm::dvec3 c = apply(box.center());
        const glm::dvec3 half = absolute * (box.size() * 0.5) * double(scale_);
        return {c - half, c + half};
    }

  private:
    [[noreturn]] static void refuse() {
        detail::fail<std::invalid_argument>(
            "farfield::Similarity: an instance's transform must be rotation, uniform scale and translation");
    }

    glm::mat3 rotation_{1.0f};
    float scale_ = 1;
};

}  // namespace farfield
