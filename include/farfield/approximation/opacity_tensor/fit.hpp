// Fits the shape that is stored to sums over a cell's surfaces: an ellipsoid of areas, and the law by which they cover.
#pragma once

#include "farfield/settings.hpp"

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

#include "farfield/approximation/opacity_tensor/appearance_lanes.hpp"
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
        const glm::vec3 tight = draft.contents.size() * per_unit;
        box_ = StoredTensor::rounded_extent(tight);
        // Closed surfaces count as they are seen from the end that shows more of them.
        seen_ = closed_surfaces ? 0.5f * (sums_.along_axes + glm::abs(sums_.normal)) : sums_.along_axes;
        seen_ = seen_ * per_unit * per_unit;
        const glm::ivec3 samples = AxisMasks::samples_within(cell.bounds(), draft.contents);
        glm::vec3 apart = cell.bounds_half * (2 * per_unit / float(AxisMasks::side));
        for (int axis = 0; axis < 3; ++axis) {
            // What is thin may lie between two rows of samples: a few share the width of what they could have seen.
            if (samples[axis] < 8) apart[axis] = samples[axis] > 0 ? tight[axis] / float(samples[axis]) : 0.0f;
        }
        for (int view = 0; view < (is_cube() ? AxisMasks::views : 3); ++view) {
            Seen& seen = views_[std::size_t(view)];
            float sample = AxisMasks::sample_area(view);
            if (view < 3) {
                const int u = (view + 1) % 3, v = (view + 2) % 3, within = samples[u] * samples[v];
                outline_[view] = box_[u] * box_[v];
                sample = apart[u] * apart[v];
                // Those of one row see the same.
                const int across = std::min(samples[u], samples[v]);
                seen.samples = float(std::min(within, across * across));
            } else {
                seen.samples = glm::dot(AxisMasks::direction(view), glm::abs(outline_)) / sample;
            }
            seen.covered = float(draft.masks.count(view)) * sample * alpha;
        }
        extent_ = spread(tight);
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
        std::array<float, 6> t = per_area(sums_.tensor);
        // Cauchy: the mean over all directions is half of the areas' sum.
        const float scale = 0.5f / mean_area(root_of(t)) * area;
        const glm::vec3 facing = closed_surfaces_ ? sums_.normal / sums_.area * area : glm::vec3(0);
        const glm::vec3 kept = counts_overlap ? counted_once(s, t, scale, facing) : glm::vec3(1);
        constexpr std::array<int, 6> row{0, 1, 2, 1, 2, 2}, column{0, 0, 0, 1, 1, 2};
        for (std::size_t i = 0; i < 6; ++i) t[i] *= kept[row[i]] * kept[column[i]];
        s.root = root_of(t);
        for (float& v : s.root) v *= scale;
        s.facing = facing * kept;
        if (mean_luminance > 0) s.tone = sums_.tone / sums_.area * (area / mean_luminance) * kept;
        return s;
    }

    /// How much of the contents covered(w) loses or makes up: what it is off the masks, beyond their own noise, in
    /// parts of what is covered; 0 to 1. It is 1 where bounds are not cubes: masks do not know their diagonals.
    template <class Covered>
    float lost_part(Covered&& covered) const {
        if (!is_cube()) return 1;
        float off = 0, sum = 0;
        for (int view = 0; view < AxisMasks::views; ++view) {
            const Seen& seen = views_[std::size_t(view)];
            if (!(seen.samples >= 1)) continue;
            const glm::vec3 w = AxisMasks::direction(view);
            // A mask does not know from which end it is seen.
            const float found = 0.5f * (covered(w) + covered(-w));
            const float outline = std::max(glm::dot(glm::abs(w), outline_), seen.covered);
            off += std::max(std::abs(found - seen.covered) - outline * seen.noise(seen.covered / outline), 0.0f);
            sum += std::max(found, seen.covered);
        }
        return sum > 0 ? off / sum : 0.0f;
    }

    /// Flat contents are coherent. All others get the law by which their areas cover the samples that the masks found
    /// covered. Where samples are too few to tell, contents count as strewn: leaves that are called a sheet thicken.
    AreaLaw fitting_law() const {
        if (normal_of(per_area(sums_.tensor)) != glm::vec3(0)) return AreaLaw::coherent;
        AreaLaw best = AreaLaw::independent;
        float least = std::numeric_limits<float>::infinity();
        for (const AreaLaw law : {AreaLaw::independent, AreaLaw::mixed, AreaLaw::coherent}) {
            float sum = 0;
            for (int axis = 0; axis < 3; ++axis) {
                const Seen& seen = views_[std::size_t(axis)];
                if (!(seen.samples >= 1)) continue;
                const float part = seen.covered / outline_[axis];
                const float off = 1 - transmitted(1, seen_[axis] / outline_[axis], law) - part;
                const float variance = part * std::max(1 - part, 0.0f) / seen.samples;
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
        for (const glm::vec3 w : directions) sum += area_seen_from(shape, w);
        return sum / float(count);
    }

  private:
    /// What a mask tells.
    struct Seen {
        float covered = 0;  ///< area, each place once
        float samples = 0;  ///< that do not depend on one another; below 1 it tells nothing
        /// The deviation of a part that is covered: of samples that hit or miss, and of rows at the borders.
        float noise(float part) const {
            return std::sqrt((std::max(part * (1 - 0.5f * part), 0.0f) + 0.5f / samples) / samples);
        }
    };

    bool is_cube() const {
        const glm::vec3 half = cell_.bounds_half;
        return half.x == half.y && half.x == half.z;
    }

    std::array<float, 6> per_area(std::array<float, 6> sum) const {
        for (float& v : sum) v /= sums_.area;
        return sum;
    }
    static glm::vec3 normal_of(const std::array<float, 6>& tensor) {
        TensorShape shape;
        shape.root = root_of(tensor);
        return sheet_normal(shape);
    }

    /// Sides of the box in which areas that are strewn evenly have the contents' variance, and in which there is room
    /// for what the masks found covered.
    glm::vec3 spread(glm::vec3 tight) const {
        const glm::dvec3 mean = glm::dvec3(sums_.moment) / double(sums_.area);
        const glm::dvec3 variance = glm::max(sums_.squares / double(sums_.area) - mean * mean, glm::dvec3(0));
        const glm::vec3 even = glm::min(glm::vec3(glm::sqrt(12.0 * variance) / double(unit_)), tight);
        const glm::vec3 between = glm::sqrt(even * tight);
        glm::vec3 e = between;
        for (int axis = 0; axis < 3; ++axis) {
            const int u = (axis + 1) % 3, v = (axis + 2) % 3;
            const float area = between[u] * between[v], covered = views_[std::size_t(axis)].covered;
            if (!(area > 0 && covered > area)) continue;
            const float grown = std::sqrt(covered / area);
            e[u] = std::max(e[u], std::min(between[u] * grown, tight[u]));
            e[v] = std::max(e[v], std::min(between[v] * grown, tight[v]));
        }
        return StoredTensor::rounded_extent(e);
    }

    /// Factors along the axes with which the shape covers as much as the masks saw covered, from three axes and two
    /// diagonals: least squares of the areas' logarithms (Gauss and Newton's steps), each weighted by how well its
    /// samples tell it. `t` is the tensor, of which `scale` times the root is the area seen.
    glm::vec3 counted_once(const TensorShape& s, const std::array<float, 6>& t, float scale, glm::vec3 facing) const {
        struct Target {
            glm::vec3 w;
            float area, weight;
            bool is_least;  ///< all is covered: by how much more than once cannot be seen
        };
        std::array<Target, AxisMasks::views> targets;
        std::size_t count = 0;
        // Sheets that close an axis may do so just from elsewhere, as a blind's slats do: between the axes nothing is
        // taken away from them.
        const bool is_coherent = s.law == AreaLaw::coherent, is_flat = is_coherent && normal_of(t) != glm::vec3(0);
        for (int view = 0; view < (is_flat ? 3 : AxisMasks::views); ++view) {
            const Seen& seen = views_[std::size_t(view)];
            if (!(seen.samples >= 1)) continue;
            const glm::vec3 w = AxisMasks::direction(view);
            const float outline = outline_from(s, w), sample = 0.5f / seen.samples;
            const float part = std::min(seen.covered / outline, 1 - sample);
            const float area = std::max(area_of(part, s.law), sample);
            // That of the area's logarithm; a tenth is what the shape itself may be off.
            const float noise = seen.noise(part) * slope_of_area(part, s.law) / area;
            targets[count++] = {w, area * outline, 1 / (noise * noise + 0.01f),
                                part > (is_coherent ? 0.9f - 2 * seen.noise(part) : 1 - 3 * sample)};
        }
        // A sheet that stays too small is closed by its gain; leaves may have more than there is, as others have less.
        const float most = is_coherent && !closed_surfaces_ ? 0.0f : 0.7f;
        glm::vec3 log_kept(0);
        for (int step = 0; step < 4; ++step) {
            const glm::vec3 kept = glm::exp(log_kept);
            // That nothing is hidden counts as one measurement, give or take a factor of e.
            glm::mat3 matrix(1);
            glm::vec3 right = -log_kept;
            for (std::size_t i = 0; i < count; ++i) {
                const glm::vec3 u = targets[i].w * kept;
                const glm::vec3 tu(t[0] * u.x + t[1] * u.y + t[2] * u.z, t[1] * u.x + t[3] * u.y + t[4] * u.z,
                                   t[2] * u.x + t[4] * u.y + t[5] * u.z);
                const float squared = glm::dot(u, tu);
                if (!(squared > 1e-4f)) continue;  // edge-on
                const float root = std::sqrt(squared), ends = glm::dot(facing, u);
                float area = scale * root;
                glm::vec3 slope = u * tu * (scale / root);
                if (closed_surfaces_) {
                    area = 0.5f * (area + std::abs(ends));
                    slope = 0.5f * (slope + (ends < 0 ? -facing : facing) * u);
                }
                if (targets[i].is_least && area > targets[i].area) continue;
                slope = slope / area;
                const float weight = targets[i].weight;
                for (int column = 0; column < 3; ++column) matrix[column] += weight * slope[column] * slope;
                right += weight * std::log(targets[i].area / area) * slope;
            }
            log_kept = glm::clamp(log_kept + glm::inverse(matrix) * right, -4.0f, most);
        }
        return glm::exp(log_kept);
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

    static float slope_of_area(float opacity, AreaLaw law) {
        return law == AreaLaw::independent ? 1 / (1 - opacity) : law == AreaLaw::mixed ? 2 / (2 - opacity) : 1.0f;
    }

    const AreaSums& sums_;
    const Cell& cell_;
    bool closed_surfaces_;
    float unit_;
    glm::vec3 box_{0};      ///< sides of the contents' box
    glm::vec3 extent_{0};   ///< and of the box in which they are strewn
    glm::vec3 seen_{0};     ///< along each axis, if nothing hid anything
    glm::vec3 outline_{0};  ///< of the contents' box
    std::array<Seen, AxisMasks::views> views_{};
};

}  // namespace farfield
