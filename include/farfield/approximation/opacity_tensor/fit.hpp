// Fits the shape that is stored to sums over a cell's surfaces: an ellipsoid of areas, and the law by which they cover.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
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
        // Nothing thinner can be stored.
        extent_ = glm::clamp(draft.contents.size() * per_unit, 1.0f / 16, 1.0f);
        // Closed surfaces count as they are seen from the end that shows more of them.
        seen_ = closed_surfaces ? 0.5f * (sums_.along_axes + glm::abs(sums_.normal)) : sums_.along_axes;
        seen_ = seen_ * per_unit * per_unit;
        const glm::vec3 step = cell.bounds_half * (2 * per_unit / float(AxisMasks::side));
        for (int axis = 0; axis < 3; ++axis) {
            const int u = (axis + 1) % 3, v = (axis + 2) % 3;
            outline_[axis] = extent_[u] * extent_[v];
            sample_[axis] = step[u] * step[v];
            covered_[axis] = float(draft.masks.count(axis)) * sample_[axis] * alpha;
        }
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
        s.extent = extent_;
        s.center = (cell_.center + sums_.moment / sums_.area - (cell_.bounds_center - cell_.bounds_half)) / unit_;
        s.rgb = sums_.color / sums_.area;
        const glm::vec3 kept = counts_overlap ? counted_once(s.law) : glm::vec3(1);
        // Scaled to a sum of areas of 1: squares of small ones are too small for single precision.
        const float area = sums_.area / unit_ / unit_, mean_luminance = detail::luminance(s.rgb);
        std::array<float, 6> t;
        for (std::size_t i = 0; i < 6; ++i) t[i] = sums_.tensor[i] / sums_.area;
        // Cauchy: the mean over all directions is half of the areas' sum.
        const float scale = 0.5f / mean_area(root_of(t)) * area;
        constexpr std::array<int, 6> row{0, 1, 2, 1, 2, 2}, column{0, 0, 0, 1, 1, 2};
        for (std::size_t i = 0; i < 6; ++i) t[i] *= kept[row[i]] * kept[column[i]];
        s.root = root_of(t);
        for (float& v : s.root) v *= scale;
        if (closed_surfaces_) s.facing = sums_.normal / sums_.area * area * kept;
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
                const float part = covered_[axis] / outline_[axis];
                const float off = 1 - transmitted(1, seen_[axis] / outline_[axis], law) - part;
                // The variance of samples, of which some three hundred lie in a cell's outline.
                const float chance = law == AreaLaw::independent ? 0.0f : 0.003f * part * std::max(1 - part, 0.0f);
                sum += outline_[axis] * (off * off + chance);
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
        if (l[0] > 0) {
            l[1] = t[1] / l[0];
            l[2] = t[2] / l[0];
        }
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
    glm::vec3 extent_{0};
    glm::vec3 sample_{0};                                 ///< area of one sample, along each axis
    glm::vec3 seen_{0};                                   ///< along each axis, if nothing hid anything
    glm::vec3 outline_{0};                                ///< of the contents' box
    glm::vec3 covered_{0};                                ///< area that the masks found covered, along each axis
    std::array<float, AxisMasks::views - 3> held_out_{};  ///< the same along diagonals
};

}  // namespace farfield
