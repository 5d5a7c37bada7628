// Fits the shape that is stored to sums over a cell's surfaces: an ellipsoid of areas, and the law by which they cover.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <glm/common.hpp>
#include <glm/exponential.hpp>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>
#include <glm/vec3.hpp>
#include <limits>
#include <numbers>

#include "farfield/approximation/opacity_tensor/area_sums.hpp"
#include "farfield/approximation/opacity_tensor/axis_masks.hpp"
#include "farfield/approximation/opacity_tensor/stored_tensor.hpp"
#include "farfield/geometry/area_law.hpp"
#include "farfield/geometry/cell.hpp"

namespace farfield {

/// Turns sums into a shape. Areas are in squares of the bounds' side. Borrows the sums and the cell.
class TensorFit {
  public:
    TensorFit(const TensorSums& draft, const Cell& cell, bool closed_surfaces)
        : sums_(draft.sums), cell_(cell), closed_surfaces_(closed_surfaces), unit_(tensor_unit(cell)) {
        if (is_empty()) return;
        const float per_unit = 1 / unit_, alpha = sums_.area / sums_.opaque_area;
        box_ = StoredTensor::rounded_extent(draft.contents.size() * per_unit);
        // Closed surfaces count as they are seen from the end that shows more of them.
        seen_ = closed_surfaces ? 0.5f * (sums_.along_axes + glm::abs(sums_.normal)) : sums_.along_axes;
        seen_ = seen_ * per_unit * per_unit;
        const Box bounds = cell.bounds();
        const glm::vec3 tight = draft.contents.size() * per_unit;
        const glm::ivec3 samples = AxisMasks::samples_within(bounds, draft.contents);
        for (int axis = 0; axis < 3; ++axis) {
            const int u = (axis + 1) % 3, v = (axis + 2) % 3;
            outline_[axis] = box_[u] * box_[v];
            // Of the samples that could have seen something: what is thin may lie between two rows of them.
            const int within = samples[u] * samples[v];
            sample_[axis] = within > 0 ? tight[u] * tight[v] / float(within) : 0.0f;
            covered_[axis] = float(draft.masks.count(axis)) * sample_[axis] * alpha;
            // Samples of one row see the same.
            const int across = std::min(samples[u], samples[v]);
            told_by_[axis] = float(std::min(within, across * across));
        }
        extent_ = spread(tight);
        for (std::size_t i = 0; i < held_out_.size(); ++i) {
            const int view = 3 + int(i);
            held_out_[i] = float(draft.masks.count(view)) * AxisMasks::sample_area(view) * alpha;
        }
    }

    /// True where single precision cannot tell the areas from 0, or from infinity.
    bool is_empty() const {
        return !(sums_.area >= std::numeric_limits<float>::min() && std::isfinite(sums_.area) && unit_ > 0);
    }

    /// `counts_overlap`: areas that hide one another along an axis are counted once. Call it only if not is_empty().
    TensorShape shape(bool counts_overlap) const {
        TensorShape s;
        s.law = fitting_law();
        s.extent = s.law == AreaLaw::coherent ? box_ : extent_;
        s.center = (cell_.center + sums_.moment / sums_.area - (cell_.bounds_center - cell_.bounds_half)) / unit_;
        s.rgb = sums_.color / sums_.area;
        // Scaled to a sum of areas of 1: squares of small ones are too small for single precision.
        const float area = sums_.area / unit_ / unit_, mean_luminance = detail::luminance(s.rgb);
        std::array<float, 6> t;
        for (std::size_t i = 0; i < 6; ++i) t[i] = sums_.tensor[i] / sums_.area;
        // Cauchy: the mean over all directions is half of the areas' sum.
        const float scale = 0.5f / mean_area(root_of(t)) * area;
        const glm::vec3 facing = closed_surfaces_ ? sums_.normal / sums_.area * area : glm::vec3(0);
        const glm::vec3 kept = !counts_overlap                ? glm::vec3(1)
                                                            : fitted(s, t, scale, facing);
        constexpr std::array<int, 6> row{0, 1, 2, 1, 2, 2}, column{0, 0, 0, 1, 1, 2};
        for (std::size_t i = 0; i < 6; ++i) t[i] *= kept[row[i]] * kept[column[i]];
        s.root = root_of(t);
        for (float& v : s.root) v *= scale;
        s.facing = facing * kept;
        if (mean_luminance > 0) s.tone = sums_.tone / sums_.area * (area / mean_luminance) * kept;
        return s;
    }

    /// The mean error of covered(w) along the diagonals, which nothing was fitted to, in parts of the area that the
    /// contents' box shows there: 0 to 1. It is 1 where bounds are not cubes: masks do not know their diagonals.
    template <class Covered>
    float held_out_error(Covered&& covered) const {
        const glm::vec3 half = cell_.bounds_half;
        if (half.x != half.y || half.x != half.z) return 1;
        float sum = 0;
        for (std::size_t i = 0; i < held_out_.size(); ++i) {
            const glm::vec3 w = AxisMasks::direction(3 + int(i));
            // A mask does not know from which end it is seen.
            const float off = 0.5f * (covered(w) + covered(-w)) - held_out_[i];
            sum += std::min(std::abs(off) / glm::dot(glm::abs(w), outline_), 1.0f);
        }
        return sum / float(held_out_.size());
    }

    /// Flat contents are coherent. All others get the law by which their areas cover the samples that the masks found
    /// covered. Where samples are too few to tell, contents count as strewn: leaves that are called a sheet thicken.
    AreaLaw fitting_law() const {
        TensorShape shape;
        for (std::size_t i = 0; i < 6; ++i) shape.root[i] = sums_.tensor[i] / sums_.area;
        shape.root = root_of(shape.root);
        if (shape.sheet_normal() != glm::vec3(0)) return AreaLaw::coherent;
        AreaLaw best = AreaLaw::independent;
        float least = std::numeric_limits<float>::infinity();
        for (const AreaLaw law : {AreaLaw::independent, AreaLaw::mixed, AreaLaw::coherent}) {
            float sum = 0;
            for (int axis = 0; axis < 3; ++axis) {
                if (!(told_by_[axis] > 0)) continue;
                const float part = covered_[axis] / outline_[axis];
                const float off = 1 - transmitted(1, seen_[axis] / outline_[axis], law) - part;
                const float variance = part * std::max(1 - part, 0.0f) / told_by_[axis];
                sum += outline_[axis] * (off * off + (law == AreaLaw::independent ? 0.0f : variance));
            }
            if (sum <= least) {  // of equals the one that closes, as for contents that are covered many times
                least = sum;
                best = law;
            }
        }
        return best;
    }

    /// The Cholesky root L of a tensor L L^T that may be singular: lower triangle by columns.
    static std::array<float, 6> root_of(const std::array<float, 6>& t) {
        std::array<float, 6> l{};
        // A pivot that may be rounding counts as 0.
        const auto pivot = [](float rest, float of) { return rest > 1e-5f * of ? std::sqrt(rest) : 0.0f; };
        const float largest = std::max(t[0], std::max(t[3], t[5]));
        l[0] = pivot(t[0], largest);
        if (l[0] > 0) l[1] = t[1] / l[0], l[2] = t[2] / l[0];
        l[3] = pivot(t[3] - l[1] * l[1], largest);
        if (l[3] > 0) l[4] = (t[4] - l[2] * l[1]) / l[3];
        l[5] = pivot(t[5] - l[2] * l[2] - l[4] * l[4], largest);
        return l;
    }

    /// The mean of |L^T w| over all directions.
    static float mean_area(const std::array<float, 6>& root) {
        constexpr int count = 96;
        static const auto directions = [] {  // a Fibonacci lattice
            std::array<glm::vec3, count> all;
            for (int i = 0; i < count; ++i) {
                const float z = 1 - (2 * float(i) + 1) / float(count), r = std::sqrt(1 - z * z);
                const float turn = 2 * std::numbers::pi_v<float> * float(i) / std::numbers::phi_v<float>;
                all[std::size_t(i)] = {r * std::cos(turn), r * std::sin(turn), z};
            }
            return all;
        }();
        TensorShape shape;
        shape.root = root;
        float sum = 0;
        for (const glm::vec3 w : directions) sum += shape.area_seen_from(w);
        return sum / float(count);
    }

  private:
    /// Sides of the box in which areas that are strewn evenly have the contents' variance, and in which there is room
    /// for what the masks found covered.
    glm::vec3 spread(glm::vec3 tight) const {
        const float per_area = 1 / sums_.area;
        const glm::vec3 mean = sums_.moment * per_area;
        const glm::vec3 variance = glm::max(sums_.squares * per_area - mean * mean, glm::vec3(0));
        const glm::vec3 even = glm::min(glm::sqrt(12.0f * variance) / unit_, tight);
        glm::vec3 e = even;
        for (int axis = 0; axis < 3; ++axis) {
            const int u = (axis + 1) % 3, v = (axis + 2) % 3;
            const float area = even[u] * even[v];
            if (!(area < covered_[axis])) continue;
            const float grown = area > 0 ? std::sqrt(covered_[axis] / area) : std::numeric_limits<float>::infinity();
            e[u] = std::max(e[u], std::min(even[u] * grown, tight[u]));
            e[v] = std::max(e[v], std::min(even[v] * grown, tight[v]));
        }
        return StoredTensor::rounded_extent(e);
    }

    /// The factors along the axes with which what is strewn covers as much as the masks saw covered from three axes and
    /// two diagonals: least squares of the areas' logarithms, each weighted by how well its samples tell the area.
    glm::vec3 fitted(const TensorShape& s, const std::array<float, 6>& t, float scale, glm::vec3 facing) const {
        const bool is_cube = cell_.bounds_half.x == cell_.bounds_half.y && cell_.bounds_half.x == cell_.bounds_half.z;
        glm::vec3 log_kept(0);
        for (int iteration = 0; iteration < 4; ++iteration) {
            const glm::vec3 kept = glm::exp(log_kept);
            // Normal equations; that nothing is hidden counts as one measurement, give or take a factor of e.
            glm::mat3 matrix(1);
            glm::vec3 right = -log_kept;
            for (int view = 0; view < (is_cube ? AxisMasks::views : 3); ++view) {
                const glm::vec3 w = AxisMasks::direction(view), u = w * kept;
                const glm::vec3 tu(t[0] * u.x + t[1] * u.y + t[2] * u.z, t[1] * u.x + t[3] * u.y + t[4] * u.z,
                                   t[2] * u.x + t[4] * u.y + t[5] * u.z);
                const float squared = glm::dot(u, tu);
                if (!(squared > 1e-4f)) continue;  // edge-on
                const float both = std::sqrt(squared), ends = glm::dot(facing, u);
                float area = scale * both;
                glm::vec3 slope = u * tu * (scale / both);
                if (closed_surfaces_) {
                    area = 0.5f * (area + std::abs(ends));
                    slope = 0.5f * (slope + (ends < 0 ? -facing * u : facing * u));
                }
                slope = slope / area;
                const float outline = s.outline_from(w), covered = view < 3 ? covered_[view] : held_out_[std::size_t(view - 3)];
                const float samples = view < 3 ? told_by_[view] : outline / AxisMasks::sample_area(view);
                if (!(samples >= 1)) continue;
                const float part = covered / outline, most = 1 - 0.5f / samples;
                const float open = 1 - std::min(part, most);
                const float target = area_of(1 - open, s.law) * outline;
                // All is covered, and by how much more cannot be seen.
                if (part > 1 - 1.5f / samples && area > target) continue;
                const float steep = s.law == AreaLaw::independent ? 1 / open : s.law == AreaLaw::mixed ? 2 / (1 + open) : 1.0f;
                const float step = steep * outline / std::max(target, 0.5f * outline / samples);
                const float variance = (open * (1 - open) + 0.5f / samples) / samples * (step * step) + 0.01f;
                const float weight = 1 / variance;
                const float off = std::log(std::max(target, 0.5f * outline / samples) / area);
                for (int i = 0; i < 3; ++i) matrix[i] += weight * slope * slope[i];
                right += weight * off * slope;
            }
            log_kept = glm::clamp(log_kept + glm::inverse(matrix) * right, -4.0f, s.law == AreaLaw::coherent && !closed_surfaces_ ? 0.0f : 0.7f);
        }
        return glm::exp(log_kept);
    }

    /// The part of the area along each axis with which the law covers as much as the masks saw covered.
    glm::vec3 counted_once(AreaLaw law) const {
        glm::vec3 kept(1);
        for (int axis = 0; axis < 3; ++axis) {
            if (!(sample_[axis] > 0)) continue;
            const float opacity = std::min(covered_[axis] / outline_[axis], 1 - 0.5f * sample_[axis] / outline_[axis]);
            const float fitting = area_of(opacity, law) * outline_[axis];
            const float prior = sample_[axis];  // point samples of little are noise
            // More area than there is means too few samples. Leaves may have it, since others have less; a sheet that
            // stays too small is closed by its gain.
            const float most = law == AreaLaw::coherent && !closed_surfaces_ ? 1.0f : 1.25f;
            kept[axis] = std::min((fitting + prior) / (seen_[axis] + prior), most);
            // More than enough from here may be just enough from elsewhere: a blind's slats.
            if (law == AreaLaw::coherent && opacity > 0.9f) kept[axis] = std::max(kept[axis], 1.0f);
        }
        return kept;
    }

    /// The area that has this opacity by a law.
    static float area_of(float opacity, AreaLaw law) {
        switch (law) {
            case AreaLaw::coherent:
                return opacity;
            case AreaLaw::mixed:
                return -2 * std::log(1 - 0.5f * opacity);
            case AreaLaw::independent:
                return -std::log(1 - opacity);
        }
        return opacity;
    }

    const AreaSums& sums_;
    const Cell& cell_;
    bool closed_surfaces_;
    float unit_;
    glm::vec3 box_{0};                                    ///< sides of the contents' box
    glm::vec3 extent_{0};                                 ///< of that in which they are strewn
    glm::vec3 sample_{0};                                 ///< area of one sample, along each axis
    glm::vec3 told_by_{0};                                ///< samples that do not depend on one another, along each axis
    glm::vec3 seen_{0};                                   ///< along each axis, if nothing hid anything
    glm::vec3 outline_{0};                                ///< of the contents' box
    glm::vec3 covered_{0};                                ///< area that the masks found covered, along each axis
    std::array<float, AxisMasks::views - 3> held_out_{};  ///< the same along diagonals
};

}  // namespace farfield
