// Ears after Meisters, "Polygons have ears" (1975): every simple polygon has two corners whose triangle holds no other
// corner. Only corners that are not convex can lie in one (Held, "FIST: Fast industrial-strength triangulation of
// polygons", 2001, section 2). Rows of corners find them, and who was in the way is remembered, so that the work of
// spirals and combs is not the square of their corners.
#include "scenes/load/polygon.hpp"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>

namespace farfield::scenes::detail {
namespace {

double cross(const glm::dvec2& a, const glm::dvec2& b) {
    return a.x * b.y - a.y * b.x;
}

/// The power of two that brings numbers up to `largest` to between 1/2 and 1: exact, and no product leaves the range.
double scale_for(double largest) {
    int exponent = 0;
    std::frexp(largest, &exponent);
    return std::ldexp(1.0, std::clamp(-exponent, -1000, 1000));
}

}  // namespace

const std::vector<Triangulator::Triangle>& Triangulator::operator()(std::span<const glm::dvec3> corners) {
    triangles_.clear();
    const auto count = static_cast<std::uint32_t>(corners.size());
    if (count > 3 && flatten(corners)) {
        cut_ears();
    } else {
        for (std::uint32_t i = 2; i < count; ++i) triangles_.push_back({0, i - 1, i});
    }
    return triangles_;
}

/// False if the fan will do.
bool Triangulator::flatten(std::span<const glm::dvec3> corners) {
    double largest = 0.0;
    for (const glm::dvec3& corner : corners) {
        const glm::dvec3 d = glm::abs(corner - corners[0]);
        largest = std::max({largest, d.x, d.y, d.z});
        if (!std::isfinite(d.x + d.y + d.z)) return false;
    }
    if (!(largest > 0.0)) return false;
    const double scale = scale_for(largest);
    // Twice the area vector: the fan's triangles, summed.
    glm::dvec3 normal(0.0), last(0.0);
    for (const glm::dvec3& corner : corners) {
        const glm::dvec3 d = (corner - corners[0]) * scale;
        normal += glm::cross(last, d);
        last = d;
    }
    // To leave out one coordinate keeps corners in line that are in line, which a rotation into the plane would not.
    const glm::dvec3 size = glm::abs(normal);
    const int out = size.x > size.y ? (size.x > size.z ? 0 : 2) : (size.y > size.z ? 1 : 2);
    if (!(size[out] > 0.0)) return false;
    int u = (out + 1) % 3, v = (out + 2) % 3;
    if (normal[out] < 0.0) std::swap(u, v);
    flat_.clear();
    for (const glm::dvec3& corner : corners) {
        const glm::dvec3 d = (corner - corners[0]) * scale;
        flat_.push_back({d[u], d[v]});
    }
    // A corner in line with others may be off it by a rounding in the file; what the fan then has too much is no reason
    // to leave it: 2^-20 of the area.
    double whole = 0.0, too_much = 0.0;
    for (std::size_t i = 2; i < flat_.size(); ++i) {
        const double area = cross(flat_[i - 1], flat_[i]);
        whole += area;
        if (area < 0.0) too_much -= area;
    }
    return too_much > 0x1p-20 * whole;
}

double Triangulator::turn(std::uint32_t a, std::uint32_t b, std::uint32_t c) const {
    return cross(flat_[b] - flat_[a], flat_[c] - flat_[a]);
}

void Triangulator::sort_into_rows() {
    const auto count = static_cast<std::uint32_t>(flat_.size());
    in_rows_.resize(count);
    for (std::uint32_t i = 0; i < count; ++i) in_rows_[i] = i;
    const auto less = [&](int axis) {
        return [this, axis](std::uint32_t i, std::uint32_t k) {
            const glm::dvec2 &p = flat_[i], &q = flat_[k];
            if (p[axis] != q[axis]) return p[axis] < q[axis];
            if (p[1 - axis] != q[1 - axis]) return p[1 - axis] < q[1 - axis];
            return i < k;
        };
    };
    std::sort(in_rows_.begin(), in_rows_.end(), less(1));
    const auto each = static_cast<std::uint32_t>(std::ceil(std::sqrt(static_cast<double>(count))));
    rows_.clear();
    for (std::uint32_t begin = 0; begin < count; begin += each) {
        const std::uint32_t end = std::min(begin + each, count);
        rows_.push_back({begin, end, flat_[in_rows_[begin]].y, flat_[in_rows_[end - 1]].y});
        std::sort(in_rows_.begin() + begin, in_rows_.begin() + end, less(0));
    }
}

/// Whether `f` is true for a corner that may lie in the triangle: row by row those within the triangle's reach there.
template <class F>
bool Triangulator::any_within(const Triangle& ear, F&& f) const {
    const std::array<glm::dvec2, 3> at{flat_[ear[0]], flat_[ear[1]], flat_[ear[2]]};
    const double bottom = std::min({at[0].y, at[1].y, at[2].y}), top = std::max({at[0].y, at[1].y, at[2].y});
    const double margin = 0x1p-40 * (std::max({at[0].x, at[1].x, at[2].x}) - std::min({at[0].x, at[1].x, at[2].x}));
    auto row = std::lower_bound(rows_.begin(), rows_.end(), bottom, [](const Row& r, double y) { return r.upper < y; });
    for (; row != rows_.end() && row->lower <= top; ++row) {
        double left = std::numeric_limits<double>::infinity(), right = -left;
        for (std::size_t k = 0; k < 3; ++k) {
            const glm::dvec2 p = at[k], d = at[(k + 1) % 3] - p;
            if (std::max(p.y, p.y + d.y) < row->lower || std::min(p.y, p.y + d.y) > row->upper) continue;
            const bool level = d.y == 0.0;
            for (const double y : {row->lower, row->upper}) {
                const double x = p.x + d.x * std::clamp(level ? 0.0 : (y - p.y) / d.y, 0.0, 1.0);
                left = std::min({left, x, level ? p.x + d.x : x});
                right = std::max({right, x, level ? p.x + d.x : x});
            }
        }
        const auto end = in_rows_.begin() + row->end;
        auto i = std::lower_bound(in_rows_.begin() + row->begin, end, left - margin,
                                  [this](std::uint32_t p, double x) { return flat_[p].x < x; });
        for (; i != end && flat_[*i].x <= right + margin; ++i) {
            if (f(*i)) return true;
        }
    }
    return false;
}

/// Whether the corner, which is not convex, is in the way of an ear: it lies inside, or an edge at it leads there. One
/// that only touches the ear is in no one's way; `strict` spares those on the cut, too, which would be left in line.
bool Triangulator::blocks(std::uint32_t p, const Triangle& ear, bool strict) const {
    const auto [a, b, c] = ear;
    if (p == a || p == b || p == c) return false;
    const double ab = turn(a, b, p), bc = turn(b, c, p), ca = turn(c, a, p);
    if (!(ab >= 0.0 && bc >= 0.0 && ca >= 0.0)) return false;
    if (strict && ca == 0.0 && ab > 0.0 && bc > 0.0) return true;
    for (const std::uint32_t q : {before_[p], after_[p]}) {
        if ((ab > 0.0 || turn(a, b, q) > 0.0) && (bc > 0.0 || turn(b, c, q) > 0.0) &&
            (ca > 0.0 || turn(c, a, q) > 0.0)) {
            return true;
        }
    }
    return false;
}

/// The corner that is in the way of the ear at `b`, or `nothing`.
std::uint32_t Triangulator::blocker_of(std::uint32_t b, bool strict) const {
    const Triangle ear{before_[b], b, after_[b]};
    std::uint32_t found = nothing;
    any_within(ear, [&](std::uint32_t p) {
        if (convex_[p] || !blocks(p, ear, strict)) return false;
        found = p;
        return true;
    });
    return found;
}

void Triangulator::ask_again(std::uint32_t b) {
    ++asked_[b];  // what is in line or waits already is void
    next_.push_back({b, asked_[b]});
}

/// Those that `p` was in the way of.
void Triangulator::release(std::uint32_t p) {
    for (std::uint32_t w = waiting_[p]; w != nothing; w = waits_[w].next) {
        if (!cut_[waits_[w].corner] && waits_[w].asked == asked_[waits_[w].corner]) ask_again(waits_[w].corner);
    }
    waiting_[p] = nothing;
}

/// There and back, or nowhere: no area, and a wrong idea of what is inside for its neighbors.
bool Triangulator::is_spike(std::uint32_t b) const {
    const glm::dvec2 in = flat_[b] - flat_[before_[b]], out = flat_[after_[b]] - flat_[b];
    return cross(in, out) == 0.0 && glm::dot(in, out) <= 0.0;
}

/// With the spikes that this leaves.
void Triangulator::cut(std::uint32_t b) {
    const std::uint32_t a = before_[b], c = after_[b];
    triangles_.push_back({a, b, c});
    after_[a] = c;
    before_[c] = a;
    cut_[b] = convex_[b] = 1;
    --left_;
    release(b);
    for (const std::uint32_t p : {a, c}) {
        convex_[p] = turn(before_[p], p, after_[p]) > 0.0;
        if (convex_[p]) release(p);
        ask_again(p);
        if (is_spike(p)) spikes_.push_back(p);
    }
}

void Triangulator::cut_spikes() {
    while (!spikes_.empty()) {
        const std::uint32_t p = spikes_.back();
        spikes_.pop_back();
        if (left_ > 3 && !cut_[p] && is_spike(p)) cut(p);
    }
}

void Triangulator::try_ear(std::uint32_t b, double flat, Care care) {
    const glm::dvec2 in = flat_[b] - flat_[before_[b]], out = flat_[after_[b]] - flat_[b];
    const double turned = cross(in, out);
    if (turned != 0.0 || care == Care::strict) {
        if (!(turned > flat * glm::length(in) * glm::length(out))) return;
        const std::uint32_t blocker = care == Care::none ? nothing : blocker_of(b, care == Care::strict);
        if (blocker != nothing) {
            waits_.push_back({b, asked_[b], waiting_[blocker]});
            waiting_[blocker] = static_cast<std::uint32_t>(waits_.size() - 1);
            return;
        }
    }
    cut(b);
    cut_spikes();
}

void Triangulator::cut_ears() {
    const auto count = static_cast<std::uint32_t>(flat_.size());
    before_.resize(count);
    after_.resize(count);
    convex_.resize(count);
    cut_.assign(count, 0);
    asked_.assign(count, 0);
    for (std::uint32_t i = 0; i < count; ++i) {
        before_[i] = i == 0 ? count - 1 : i - 1;
        after_[i] = i + 1 == count ? 0 : i + 1;
    }
    for (std::uint32_t i = 0; i < count; ++i) convex_[i] = turn(before_[i], i, after_[i]) > 0.0;
    waiting_.assign(count, nothing);
    waits_.clear();
    sort_into_rows();

    // A corner nearly in line with its neighbors is not cut off as long as there are others: a triangle of no width
    // would hide it, and the seam to the polygon next door, which has that corner too, would open. `flat` is the sine
    // below which a corner counts as such.
    double flat = 0x1p-8;
    Care care = Care::strict;
    left_ = count;
    next_.clear();
    for (std::uint32_t i = 0; i < count; ++i) {
        if (is_spike(i)) spikes_.push_back(i);
    }
    cut_spikes();
    while (true) {
        // Anew: whose turn it was in vain may be helped by what others left.
        waiting_.assign(count, nothing);
        waits_.clear();
        for (std::uint32_t i = 0; i < count; ++i) {
            if (!cut_[i]) ask_again(i);
        }
        const std::uint32_t left_before = left_;
        while (!next_.empty() && left_ > 3) {
            // In rounds: two corners that are cut off one after the other are no neighbors, so triangles are less thin.
            now_.swap(next_);
            next_.clear();
            for (const auto& [b, asked] : now_) {
                if (left_ > 3 && !cut_[b] && asked == asked_[b]) try_ear(b, flat, care);
            }
        }
        next_.clear();
        if (left_ == 3) break;
        if (left_ < left_before) continue;
        if (flat > 0.0) {
            flat = flat > 0x1p-50 ? flat * 0x1p-12 : 0.0;
        } else if (care == Care::strict) {
            care = Care::touching;
        } else if (care == Care::touching) {
            care = Care::none;  // it crosses itself: any convex corner, which at least is a small triangle
        } else {
            break;
        }
    }
    // A last triangle, or a ring without a convex corner.
    std::uint32_t first = 0;
    while (cut_[first]) ++first;
    for (std::uint32_t b = after_[first]; after_[b] != first; b = after_[b]) {
        triangles_.push_back({first, b, after_[b]});
    }
}

}  // namespace farfield::scenes::detail
