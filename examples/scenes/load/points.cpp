#include "scenes/load/points.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "farfield/geometry/length.hpp"
#include "scenes/light.hpp"

namespace farfield::scenes::detail {
namespace {

/// As many say how dense a cloud is, and where its surface faces: fewer are noise, more round off what is small.
constexpr std::size_t most_neighbors = 16;
using Indices = std::vector<std::uint32_t>;

bool is_finite(const auto& v) {
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

/// Finds the nearest of points, no two of which are at one place: a tree that halves them across the longest side of
/// their box (Friedman, Bentley and Finkel 1977, "An algorithm for finding best matches in logarithmic expected time").
/// A grid was rejected: one point far off makes its box so large that all others are in one cell.
class Neighbors {
  public:
    struct Neighbor {
        double squared_distance;
        std::uint32_t point;

        bool operator<(const Neighbor& other) const {
            return squared_distance != other.squared_distance ? squared_distance < other.squared_distance
                                                              : point < other.point;
        }
    };

    explicit Neighbors(std::vector<glm::vec3> points) : order_(points.size()), halves_(points.size()) {
        std::iota(order_.begin(), order_.end(), std::uint32_t{0});
        halve(points, 0, points.size());
        sorted_.reserve(points.size());
        for (const std::uint32_t i : order_) sorted_.push_back(points[i]);
    }

    /// All points, those that are near each other mostly together.
    const Indices& order() const { return order_; }
    /// The nearest first; of those at one distance, the one with the smaller index. Valid until the next call.
    std::span<const Neighbor> of_ordered(std::size_t place) {
        count_ = 0;
        wanted_ = std::min(most_neighbors, order_.size() - 1);
        if (wanted_ > 0) search(glm::dvec3(sorted_[place]), place, 0, order_.size());
        return {best_.data(), count_};
    }

  private:
    static constexpr std::size_t leaf = 8;
    /// The first half is at or below, the second at or above.
    struct Halves {
        int axis;
        float at;
    };

    void halve(const std::vector<glm::vec3>& points, std::size_t begin, std::size_t end) {
        if (end - begin <= leaf) return;
        Box box = Box::empty();
        for (std::size_t i = begin; i < end; ++i) box.add(points[order_[i]]);
        const glm::vec3 size = box.size();
        const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
        const std::size_t middle = begin + (end - begin) / 2;
        const auto at = [&](std::size_t i) { return order_.begin() + static_cast<std::ptrdiff_t>(i); };
        std::nth_element(at(begin), at(middle), at(end), [&](std::uint32_t a, std::uint32_t b) {
            const float p = points[a][axis], q = points[b][axis];
            return p != q ? p < q : a < b;
        });
        halves_[middle] = {axis, points[order_[middle]][axis]};
        halve(points, begin, middle);
        halve(points, middle, end);
    }

    void search(const glm::dvec3& p, std::size_t self, std::size_t begin, std::size_t end) {
        if (end - begin <= leaf) {
            for (std::size_t i = begin; i < end; ++i) {
                if (i == self) continue;
                const glm::dvec3 d = glm::dvec3(sorted_[i]) - p;
                add({glm::dot(d, d), order_[i]});
            }
            return;
        }
        const std::size_t middle = begin + (end - begin) / 2;
        const Halves halves = halves_[middle];
        const double beyond = p[halves.axis] - static_cast<double>(halves.at);
        const bool upper = beyond >= 0;
        search(p, self, upper ? middle : begin, upper ? end : middle);
        // Equal distances are looked at, too: the smaller index is the nearer.
        if (count_ == wanted_ && beyond * beyond > best_[count_ - 1].squared_distance) return;
        search(p, self, upper ? begin : middle, upper ? middle : end);
    }

    void add(const Neighbor& neighbor) {
        if (count_ == wanted_ && !(neighbor < best_[count_ - 1])) return;
        std::size_t i = count_ < wanted_ ? count_++ : count_ - 1;
        for (; i > 0 && neighbor < best_[i - 1]; --i) best_[i] = best_[i - 1];
        best_[i] = neighbor;
    }

    Indices order_;
    std::vector<Halves> halves_;     ///< at the place of their middle, which no others have
    std::vector<glm::vec3> sorted_;  ///< in that order
    std::array<Neighbor, most_neighbors> best_{};
    std::size_t count_ = 0, wanted_ = 0;
};

/// The smaller of the two in the middle of an even number.
double median(std::span<double> values) {
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>((values.size() - 1) / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

/// The radius of the circle that each point of a surface has to itself. Within the distance of the j-th neighbor there
/// are j such circles. The median of what all neighbors say does not mind that two scans put points next to each other.
double spacing(std::span<const Neighbors::Neighbor> neighbors) {
    std::array<double, most_neighbors> estimates{};
    for (std::size_t j = 0; j < neighbors.size(); ++j) {
        estimates[j] = std::sqrt(neighbors[j].squared_distance / static_cast<double>(j + 1));
    }
    return median({estimates.data(), neighbors.size()});
}

/// Eigenvalues on the diagonal, and eigenvectors as columns: Jacobi's rotations (Golub and Van Loan 1996, section 8.4).
/// They take square roots alone, which are the same everywhere, unlike the cosines of a closed form.
void diagonalize(std::array<std::array<double, 3>, 3>& a, std::array<std::array<double, 3>, 3>& v) {
    v = {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
    for (int sweep = 0; sweep < 8; ++sweep) {
        for (const auto& [p, q] : {std::pair<std::size_t, std::size_t>{0, 1}, {0, 2}, {1, 2}}) {
            if (a[p][q] == 0) continue;
            const double tau = (a[q][q] - a[p][p]) / (2 * a[p][q]);
            const double t = (tau >= 0 ? 1 : -1) / (std::abs(tau) + std::sqrt(1 + tau * tau));
            const double c = 1 / std::sqrt(1 + t * t), s = t * c;
            for (std::size_t k = 0; k < 3; ++k) {
                const double kp = a[k][p], kq = a[k][q];
                a[k][p] = c * kp - s * kq;
                a[k][q] = s * kp + c * kq;
            }
            for (std::size_t k = 0; k < 3; ++k) {
                const double pk = a[p][k], qk = a[q][k];
                a[p][k] = c * pk - s * qk;
                a[q][k] = s * pk + c * qk;
                const double vp = v[k][p], vq = v[k][q];
                v[k][p] = c * vp - s * vq;
                v[k][q] = s * vp + c * vq;
            }
        }
    }
}

/// Of the plane that the offsets, of at most about unit length, lie in or close to; 0 if there is none. Close is where
/// its thickness is at most half its width (standard deviations), and it is more than a line.
glm::vec3 normal_of(std::span<const glm::dvec3> offsets, glm::vec3 up) {
    // The point itself is one of them.
    glm::dvec3 mean(0);
    for (const glm::dvec3& d : offsets) mean += d;
    const double count = static_cast<double>(offsets.size()) + 1;
    mean /= count;
    std::array<std::array<double, 3>, 3> a{}, v{};
    const auto add = [&](const glm::dvec3& d) {
        for (std::size_t i = 0; i < 3; ++i) {
            for (std::size_t j = 0; j < 3; ++j) a[i][j] += d[static_cast<int>(i)] * d[static_cast<int>(j)];
        }
    };
    add(-mean);
    for (const glm::dvec3& d : offsets) add(d - mean);
    diagonalize(a, v);
    std::array<std::size_t, 3> by_size{0, 1, 2};
    std::sort(by_size.begin(), by_size.end(), [&](std::size_t i, std::size_t j) { return a[i][i] < a[j][j]; });
    const auto [thin, wide, widest] = by_size;
    const bool is_line = !(a[wide][wide] > 1e-6 * a[widest][widest]);
    if (is_line || a[thin][thin] > 0.25 * a[wide][wide]) return glm::vec3(0);
    glm::vec3 normal(glm::dvec3(v[0][thin], v[1][thin], v[2][thin]));
    // Which side is outside is not known. Flat ground on which it changes from point to point would look like noise.
    return glm::dot(with_y_up(normal, up), Light{}.to_sun) < 0 ? -normal : normal;
}

/// The first point at each place, and for each point whose place it is at.
Indices places_of(std::span<const Point> points, Indices& firsts) {
    Indices order(points.size()), place(points.size());
    std::iota(order.begin(), order.end(), std::uint32_t{0});
    std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
        const glm::vec3 &p = points[a].position, &q = points[b].position;
        return p.x != q.x ? p.x < q.x : p.y != q.y ? p.y < q.y : p.z != q.z ? p.z < q.z : a < b;
    });
    for (const std::uint32_t i : order) {
        if (firsts.empty() || points[firsts.back()].position != points[i].position) firsts.push_back(i);
        place[i] = static_cast<std::uint32_t>(firsts.size() - 1);
    }
    return place;
}

/// What encloses all but the first and the last hundredth on each axis. Points that mean nothing are often at zero, and
/// must not take from the others, far from there, the bits of single precision.
BoxD without_outliers(std::vector<glm::dvec3> points) {
    BoxD box = BoxD::empty();
    glm::dvec3 lower(0), upper(0);
    for (int axis = 0; axis < 3; ++axis) {
        const auto at = [&](std::size_t i) {
            const auto place = points.begin() + static_cast<std::ptrdiff_t>(i);
            std::nth_element(points.begin(), place, points.end(),
                             [&](const glm::dvec3& p, const glm::dvec3& q) { return p[axis] < q[axis]; });
            return (*place)[axis];
        };
        lower[axis] = at((points.size() - 1) / 100);
        upper[axis] = at(points.size() - 1 - (points.size() - 1) / 100);
    }
    box.add(lower);
    box.add(upper);
    return box;
}

/// Grays from the least to the greatest of the range that the numbers are in: 0 to 1, 0 to 255, Leica's -2048 to 2047,
/// or else their own.
std::vector<Rgba8> grays(std::span<const float> intensities) {
    float least = std::numeric_limits<float>::infinity(), greatest = -least;
    for (const float i : intensities) {
        if (!std::isfinite(i)) continue;
        least = std::min(least, i);
        greatest = std::max(greatest, i);
    }
    if (least >= 0 && greatest <= 255) {
        least = 0;
        greatest = greatest <= 1 ? 1.0f : 255.0f;
    } else if (least < 0 && least >= -2048 && greatest <= 2047) {
        least = -2048;
        greatest = 2047;
    }
    std::vector<Rgba8> result;
    result.reserve(intensities.size());
    for (const float i : intensities) {
        const float half = 0.5f * greatest - 0.5f * least;  // their difference may be too large
        const float gray = half > 0 && std::isfinite(i) ? (0.5f * i - 0.5f * least) / half : 0.5f;
        result.push_back(to_rgba8({gray, gray, gray, 1.0f}));
    }
    return result;
}

void add_triangles(const Point& point, Triangles& triangles) {
    point.polygons([&](const Polygon& polygon) {
        for_each_triangle(polygon.vertices.size(), [&](std::size_t a, std::size_t b, std::size_t c) {
            triangles.push_back({{polygon.vertices[a], polygon.vertices[b], polygon.vertices[c]},
                                 {point.rgba, point.rgba, point.rgba}});
        });
    });
}

}  // namespace

void set_from_neighbors(std::span<Point> points, std::span<const Unknown> unknown, glm::vec3 up) {
    Indices firsts;
    const Indices place = places_of(points, firsts);
    std::vector<glm::vec3> positions;
    positions.reserve(firsts.size());
    for (const std::uint32_t first : firsts) positions.push_back(points[first].position);
    Neighbors tree(positions);
    std::vector<double> spacings(firsts.size());
    std::vector<glm::vec3> normals(firsts.size());
    const std::size_t each = std::min(most_neighbors, firsts.size() - 1);
    Indices neighbors(firsts.size() * each);
    for (std::size_t i = 0; i < firsts.size(); ++i) {
        const std::uint32_t p = tree.order()[i];
        const auto nearest = tree.of_ordered(i);
        if (nearest.empty()) continue;
        spacings[p] = spacing(nearest);
        // Squares of distances in a cloud of any size would leave double precision only beyond 2^500.
        const double unit = 1 / std::sqrt(nearest.back().squared_distance);
        std::array<glm::dvec3, most_neighbors> offsets{};
        for (std::size_t j = 0; j < each; ++j) {
            neighbors[p * each + j] = nearest[j].point;
            offsets[j] = unit * (glm::dvec3(positions[nearest[j].point]) - glm::dvec3(positions[p]));
        }
        normals[p] = normal_of({offsets.data(), each}, up);
    }
    for (std::size_t i = 0; i < points.size(); ++i) {
        const std::uint32_t p = place[i];
        if (unknown[i].normals) points[i].normal = normals[p];
        if (!unknown[i].radii) continue;
        double radius = 1;  // a single place has no scale
        if (each > 0) {
            std::array<double, most_neighbors> around{};
            for (std::size_t j = 0; j < each; ++j) around[j] = spacings[neighbors[p * each + j]];
            // Twice the area that it has to itself: on a square grid the discs overlap until no gap is left, and of a
            // surface sampled at random they leave e^-2 open.
            radius = std::sqrt(2.0) * std::min(spacings[p], 2 * median({around.data(), each}));
        }
        points[i].radius = static_cast<float>(radius);
    }
}

Loaded drawn(Cloud cloud, const LoadOptions& options) {
    std::vector<glm::dvec3> places;
    for (const glm::dvec3& position : cloud.positions) {
        if (is_finite(position)) places.push_back(position);
    }
    const std::size_t seen = places.size(), unseen = cloud.positions.size() - seen;
    if (seen == 0) {
        throw std::runtime_error(unseen == 0 ? "has no points" : "has no points whose coordinates are finite");
    }
    if (cloud.positions.size() > std::uint32_t(-1)) throw std::runtime_error("more than 4,294,967,295 points");
    Loaded loaded;
    loaded.notes = std::move(cloud.notes);
    if (unseen > 0) {
        loaded.notes.push_back(std::to_string(unseen) + " points without finite coordinates are left out");
    }
    BoxD box = BoxD::empty();
    for (const glm::dvec3& place : places) box.add(place);
    check_size(box);
    loaded.origin = origin_of_centers(without_outliers(std::move(places)));
    if (cloud.colors.empty()) cloud.colors = grays(cloud.intensities);
    std::vector<Point> points;
    points.reserve(seen);
    std::vector<Unknown> unknown;
    unknown.reserve(seen);
    bool any = false;
    for (std::size_t i = 0; i < cloud.positions.size(); ++i) {
        if (!is_finite(cloud.positions[i])) continue;
        Point& point = points.emplace_back();
        Unknown& u = unknown.emplace_back(Unknown{true, true});
        point.position = in_single_precision(cloud.positions[i], loaded.origin, "point", i);
        point.rgba = cloud.colors.empty() ? uncolored : cloud.colors[i];
        if (!cloud.radii.empty() && std::isfinite(cloud.radii[i]) && cloud.radii[i] >= 0) {
            if (cloud.radii[i] > 0x1p100f) {
                throw std::runtime_error("point " + std::to_string(i) + " has a radius of more than 2^100");
            }
            point.radius = cloud.radii[i];
            u.radii = false;
        }
        if (!cloud.normals.empty() && is_finite(cloud.normals[i]) && cloud.normals[i] != glm::vec3(0)) {
            point.normal = cloud.normals[i];
            u.normals = false;
        }
        any |= u.radii || u.normals;
    }
    cloud = {};
    if (any) set_from_neighbors(points, unknown, options.up);
    std::size_t triangles = 0;
    for (const Point& point : points) triangles += point.is_disc() ? 4 : 8;
    loaded.triangles.reserve(triangles);
    for (const Point& point : points) add_triangles(point, loaded.triangles);
    return loaded;
}

}  // namespace farfield::scenes::detail
