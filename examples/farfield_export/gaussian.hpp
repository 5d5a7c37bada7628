// An opacity tensor as a Gaussian splat, without training: the same area seen from every direction, and about the same
// place.
//
// The Gaussian of a covariance S and an opacity a covers, seen from a unit vector w, the integral of its opacity over
// the picture:
//
//     2 pi a sqrt(w^T adj(S) w)
//
// That is the form of what a tensor's contents show, |L^T w| (Heitz et al. 2015), so the two are equal from everywhere
// if 2 pi a sqrt(adj(S)) = L L^T, whatever `a` is. Along the axes of the tensor, where it shows C1, C2 and C3, the
// variances are
//
//     S1 = C2 C3 / (2 pi a C1), and so on,
//
// and the opacity decides how far the splat reaches: as far as the box that stands for the contents.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <numbers>
#include <utility>

#include "farfield/approximation/opacity_tensor.hpp"
#include "farfield/geometry/cell.hpp"

namespace farfield_export {

/// In the coordinates of its cell.
struct GaussianSplat {
    glm::vec3 center{0};
    glm::vec3 scale{0};              ///< standard deviations along its axes, above 0
    glm::vec4 rotation{0, 0, 0, 1};  ///< of its axes: a unit quaternion x, y, z, w
    float opacity = 0;               ///< at its center, from 0 to 1
    glm::vec3 rgb{0};                ///< 0 to 1, as displays take it

    /// How far it reaches along the coordinates' axes: three standard deviations.
    glm::vec3 reach() const;
};

/// Its columns are orthonormal and right-handed; `values` are those of a symmetric matrix along them.
struct PrincipalAxes {
    glm::mat3 axes{1};
    glm::vec3 values{0};
};

/// By rotations that take one element off the diagonal each (Jacobi 1846). A matrix that is not symmetric counts by its
/// lower triangle.
inline PrincipalAxes principal_axes(glm::mat3 m) {
    glm::mat3 axes(1);
    for (int sweep = 0; sweep < 6; ++sweep) {
        for (const auto& [p, q] : {std::pair{0, 1}, std::pair{0, 2}, std::pair{1, 2}}) {
            const float off = m[p][q];
            if (std::abs(off) <= 1e-7f * (std::abs(m[p][p]) + std::abs(m[q][q]))) continue;
            const float theta = (m[q][q] - m[p][p]) / (2 * off);
            const float t = (theta < 0 ? -1.0f : 1.0f) / (std::abs(theta) + std::sqrt(theta * theta + 1));
            const float c = 1 / std::sqrt(t * t + 1), s = t * c;
            const int r = 3 - p - q;
            const float pr = m[std::min(p, r)][std::max(p, r)], qr = m[std::min(q, r)][std::max(q, r)];
            m[p][p] -= t * off;
            m[q][q] += t * off;
            m[p][q] = 0;
            m[std::min(p, r)][std::max(p, r)] = c * pr - s * qr;
            m[std::min(q, r)][std::max(q, r)] = s * pr + c * qr;
            const glm::vec3 a = axes[p], b = axes[q];
            axes[p] = c * a - s * b;
            axes[q] = s * a + c * b;
        }
    }
    return {axes, {m[0][0], m[1][1], m[2][2]}};
}

/// Of a rotation; its columns are orthonormal and right-handed (Shepperd 1978: by the largest of four).
inline glm::vec4 quaternion_of(const glm::mat3& m) {
    const float trace = m[0][0] + m[1][1] + m[2][2];
    glm::vec4 q;
    if (trace > std::max(m[0][0], std::max(m[1][1], m[2][2]))) {
        q = {m[1][2] - m[2][1], m[2][0] - m[0][2], m[0][1] - m[1][0], 1 + trace};
    } else {
        const int i = m[0][0] >= m[1][1] && m[0][0] >= m[2][2] ? 0 : m[1][1] >= m[2][2] ? 1 : 2;
        const int j = (i + 1) % 3, k = (i + 2) % 3;
        q[i] = 1 + m[i][i] - m[j][j] - m[k][k];
        q[j] = m[i][j] + m[j][i];
        q[k] = m[i][k] + m[k][i];
        q.w = m[j][k] - m[k][j];
    }
    return glm::normalize(q);
}

inline glm::mat3 matrix_of(glm::vec4 q) {
    const float x = q.x, y = q.y, z = q.z, w = q.w;
    return {1 - 2 * (y * y + z * z), 2 * (x * y + z * w),     2 * (x * z - y * w),
            2 * (x * y - z * w),     1 - 2 * (x * x + z * z), 2 * (y * z + x * w),
            2 * (x * z + y * w),     2 * (y * z - x * w),     1 - 2 * (x * x + y * y)};
}

inline glm::vec3 GaussianSplat::reach() const {
    const glm::mat3 m = matrix_of(rotation);
    const float largest = std::max(scale.x, std::max(scale.y, scale.z));
    if (!(largest > 0)) return glm::vec3(0);
    // Squares of lengths that single precision holds may lie beyond it.
    glm::vec3 squares(0);
    for (int i = 0; i < 3; ++i) {
        const glm::vec3 along = m[i] * (scale[i] / largest);
        squares += along * along;
    }
    return 3.0f * largest * glm::sqrt(squares);
}

struct GaussianOptions {
    /// A surface is cut into splats that meet, and what is drawn by blending leaves gaps where they do: an area of X a
    /// pixel leaves exp(-X). Covariances of sheets (AreaLaw::coherent) grow by this factor.
    float sheet_gain = 2;
    /// No area is less than this part of the largest: what is thinner is mostly rounding of the stored tensor, and a
    /// Gaussian's axes are quotients of areas.
    float least_area = 0.1f;
};

/// The splat of a stored tensor. An opacity of 0: it shows nothing.
inline GaussianSplat gaussian_of(const farfield::OpacityTensor& policy, const farfield::StoredTensor& data,
                                 const farfield::Cell& cell, const GaussianOptions& options = {}) {
    if (data == farfield::StoredTensor{}) return {};
    const farfield::TensorAppearance look{data.unpacked(), policy.closed_surfaces, policy.counts_overlap};
    const auto& root = look.shape.root;  // xx, yx, zx, yy, zy, zz
    const glm::mat3 lower{root[0], root[1], root[2], 0, root[3], root[4], 0, 0, root[5]};
    const PrincipalAxes tensor = principal_axes(lower * glm::transpose(lower));
    const float unit = farfield::tensor_unit(cell);

    glm::vec3 area, rgb(0);
    for (int i = 0; i < 3; ++i) {
        const auto front = look.seen_from(tensor.axes[i]), back = look.seen_from(-tensor.axes[i]);
        area[i] = 0.5f * (front.area + back.area);
        rgb += front.area * front.rgb + back.area * back.rgb;
    }
    const float sum = area.x + area.y + area.z, largest = std::max(area.x, std::max(area.y, area.z));
    GaussianSplat splat;
    splat.center = look.center_in(cell);
    if (!(largest > 0)) return splat;
    splat.rgb = glm::clamp(rgb / (2 * sum * 255), 0.0f, 1.0f);
    area = glm::max(area, glm::vec3(options.least_area * largest));

    // Variances of a Gaussian that is opaque at its center; the box's are those of what fills it evenly.
    const glm::vec3 opaque = glm::vec3(area.y * area.z / area.x, area.z * area.x / area.y, area.x * area.y / area.z) *
                             (1 / (2 * std::numbers::pi_v<float>));
    const float in_box = glm::dot(look.shape.extent, look.shape.extent) / 12;
    splat.opacity = std::min((opaque.x + opaque.y + opaque.z) / in_box, 1.0f);
    glm::vec3 variance = opaque / splat.opacity;
    if (look.shape.law == farfield::AreaLaw::coherent) variance *= options.sheet_gain;
    splat.scale = glm::sqrt(variance) * unit;
    splat.rotation = quaternion_of(tensor.axes);
    return splat;
}

}  // namespace farfield_export
