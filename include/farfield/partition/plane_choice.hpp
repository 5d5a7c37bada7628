// The plane that cuts a cell of polygons: of a few dozen candidates one that cuts little and divides evenly.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <limits>
#include <utility>
#include <vector>

#include "farfield/geometry/cell_polygons.hpp"

namespace farfield::detail {

/// Candidates are planes of polygons (autopartition, as in the 1980 paper) and planes along faces of bounding boxes,
/// which are free where they separate: with the former alone a convex body becomes a list. All are scored on a sample,
/// so that the price of a choice does not depend on the number of items.
class PlaneChoice {
  public:
    PlaneChoice(const Cell& cell, const ClippedItems& items, float price_of_cut)
        : cell_(cell), items_(items), price_of_cut_(price_of_cut) {}

    /// False if no candidate divides the items.
    bool choose(CuttingPlane& chosen) {
        gather();
        take_sample();
        float least = infinity;
        for (std::size_t i = 0; i < count_; ++i) {
            candidates_[i].price = price(candidates_[i].plane, least);
            least = std::min(least, candidates_[i].price);
            if (least <= 0 && divides(candidates_[i].plane)) {
                // Nothing is cut and the sides are even: no plane is better.
                chosen = candidates_[i].plane;
                return true;
            }
        }
        // The first one mostly divides, so there is no point in sorting.
        for (std::size_t tried = 0; tried < count_; ++tried) {
            Candidate& best =
                *std::min_element(candidates_.begin(), candidates_.begin() + std::ptrdiff_t(count_),
                                  [](const Candidate& a, const Candidate& b) { return a.price < b.price; });
            if (std::isinf(best.price)) break;
            if (divides(best.plane)) {
                chosen = best.plane;
                return true;
            }
            best.price = infinity;
        }
        return false;
    }

  private:
    static constexpr std::size_t most_planes_of_polygons = 24, most_faces = 24, most_sampled = 96;
    static constexpr std::size_t most_between_instances = 8, most_corners = 8;
    static constexpr float infinity = std::numeric_limits<float>::infinity();
    static constexpr float infinity_but_one = std::numeric_limits<float>::max();
    static constexpr std::size_t capacity = most_planes_of_polygons + most_faces + 3 * most_between_instances + 6;

    struct Candidate {
        CuttingPlane plane;
        float price = 0;
    };

    void add(const CuttingPlane& plane) {
        for (std::size_t i = 0; i < count_; ++i) {
            if (candidates_[i].plane == plane) return;
        }
        candidates_[count_++].plane = plane;
    }
    void add(int axis, float position) {
        CuttingPlane plane;
        plane.normal[axis] = 1;
        plane.offset = float(double(position) - double(cell_.center[axis]));
        add(plane);
    }

    void gather() {
        const std::size_t n = items_.size(), instances = items_.instances(), polygons = n - instances;
        if (instances != 0) gather_between_instances();
        const std::size_t planes = std::min(polygons, most_planes_of_polygons);
        for (std::size_t i = 0; i < planes; ++i) add(items_.plane_of(instances + i * polygons / planes, cell_));
        // Few boxes give six faces each, many give one each.
        const std::size_t faces = std::min(6 * n, most_faces);
        for (std::size_t i = 0; i < faces; ++i) {
            const Box& box = items_[i * n / faces].bounds;
            const int axis = int(i % 3);
            add(axis, i / 3 % 2 == 0 ? box.lower[axis] : box.upper[axis]);
        }
    }

    /// Adds planes that pass between instances, those first that halve their number best, and the faces of the box
    /// around all of them.
    void gather_between_instances() {
        const std::size_t count = items_.instances();
        Box around = Box::empty();
        for (std::size_t i = 0; i < count; ++i) around.add(items_[i].bounds);
        std::vector<std::pair<float, float>> extents(count);
        std::vector<std::pair<std::size_t, float>> gaps;
        for (int axis = 0; axis < 3; ++axis) {
            add(axis, around.lower[axis]);
            add(axis, around.upper[axis]);
            for (std::size_t i = 0; i < count; ++i) {
                extents[i] = {items_[i].bounds.lower[axis], items_[i].bounds.upper[axis]};
            }
            std::sort(extents.begin(), extents.end());
            gaps.clear();
            float end = extents[0].second;
            for (std::size_t i = 1; i < count; ++i) {
                if (extents[i].first >= end) gaps.emplace_back(2 * i > count ? 2 * i - count : count - 2 * i, end);
                end = std::max(end, extents[i].second);
            }
            std::sort(gaps.begin(), gaps.end());
            for (std::size_t i = 0; i < std::min(gaps.size(), most_between_instances); ++i) add(axis, gaps[i].second);
        }
    }

    /// A sampled item in single precision about the cell's center, with eight corners at most: prices may be a little
    /// off.
    struct Sampled {
        glm::vec3 center, half;
        std::uint32_t first_corner, corners;
    };
    void take_sample() {
        sampled_ = std::min(items_.size(), most_sampled);
        std::uint32_t next = 0;
        for (std::size_t k = 0; k < sampled_; ++k) {
            const std::size_t i = k * items_.size() / sampled_;
            const Box& box = items_[i].bounds;
            const auto count = std::min<std::uint32_t>(items_[i].corners, most_corners);
            sample_[k] = {box.center() - cell_.center, box.size() * 0.5f, next, count};
            for (std::uint32_t c = 0; c < count; ++c) corners_[next++] = items_.polygon(i)[c].position - cell_.center;
        }
    }

    /// The price of a plane; almost infinity as soon as it is more than `limit`.
    float price(const CuttingPlane& plane, float limit) const {
        const auto tolerance = float(LocalPlane(plane, cell_).tolerance());
        const glm::vec3 normal = plane.normal, size = glm::abs(normal);
        int cut = 0, on = 0, balance = 0;
        for (std::size_t i = 0; i < sampled_; ++i) {
            const Sampled& s = sample_[i];
            const float middle = glm::dot(normal, s.center) - plane.offset, reach = glm::dot(size, s.half);
            if (middle - reach > tolerance) {
                ++balance;
            } else if (middle + reach < -tolerance) {
                --balance;
            } else {
                float lowest = infinity, highest = -infinity;
                for (std::uint32_t c = s.first_corner; c < s.first_corner + s.corners; ++c) {
                    const float h = glm::dot(normal, corners_[c]) - plane.offset;
                    lowest = std::min(lowest, h);
                    highest = std::max(highest, h);
                }
                const bool behind = lowest<-tolerance, in_front = highest> tolerance;
                if (behind && in_front) {
                    // All that are left may lie on the plane.
                    if (price_of_cut_ * float(++cut) - float(on) - float(sampled_ - i) > limit) return infinity_but_one;
                } else {
                    balance += int(in_front) - int(behind);
                    on += !(behind || in_front);
                }
            }
        }
        // Items on the plane need no further cuts.
        return price_of_cut_ * float(cut) + float(std::abs(balance)) - float(on);
    }

    /// Whether each side gets fewer items than there are, and no instance is cut.
    bool divides(const CuttingPlane& plane) const {
        const LocalPlane local_plane(plane, cell_);
        bool some_not_behind = false, some_not_in_front = false;
        for (std::size_t i = 0; i < items_.size(); ++i) {
            const PlaneRelation relation = items_.relation(i, plane, local_plane, cell_);
            if (i < items_.instances()) {
                if (relation == PlaneRelation::crossing) return false;
            } else if (some_not_behind && some_not_in_front) {
                return true;
            }
            some_not_behind = some_not_behind || relation == PlaneRelation::in_front || relation == PlaneRelation::on;
            some_not_in_front = some_not_in_front || relation == PlaneRelation::behind || relation == PlaneRelation::on;
        }
        return some_not_behind && some_not_in_front;
    }

    const Cell& cell_;
    const ClippedItems& items_;
    float price_of_cut_;
    std::array<Candidate, capacity> candidates_;
    std::size_t count_ = 0;
    std::array<Sampled, most_sampled> sample_;
    std::array<glm::vec3, most_sampled * most_corners> corners_;
    std::size_t sampled_ = 0;
};

inline bool choose_plane(const Cell& cell, const ClippedItems& items, float price_of_cut, CuttingPlane& plane) {
    return PlaneChoice(cell, items, price_of_cut).choose(plane);
}

}  // namespace farfield::detail
