// What the mask tiler is compared with: a sample is covered where exact edge functions say so, and everything else
// follows sample by sample.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "farfield/coverage/tiler/coverage_tiler.hpp"
#include "farfield/image.hpp"
#include "farfield/raster/shading.hpp"
#include "support/random.hpp"

namespace farfield::test {
using namespace detail;

inline constexpr Simd all_simd[] = {Simd::scalar, Simd::four_lanes, Simd::eight_lanes, Simd::sixteen_lanes};

/// Of a clockwise polygon, at (x, y), 1/256 sample. Points on an edge belong to the polygon that has it at its top or
/// left.
inline bool covers(const TilePolygon& p, std::int64_t x, std::int64_t y) {
    for (int c = 0; c < p.corners; ++c) {
        const auto from = std::size_t(c), to = std::size_t((c + 1) % p.corners);
        const std::int64_t dx = p.x[to] - p.x[from], dy = p.y[to] - p.y[from];
        if (dx == 0 && dy == 0) continue;
        const std::int64_t e = dx * (y - p.y[from]) - dy * (x - p.x[from]);
        if (e < 0 || (e == 0 && !(dy < 0 || (dy == 0 && dx > 0)))) return false;
    }
    return true;
}

/// An image of samples and the place of its first one.
struct SampleFrame {
    int width_px = 0, height_px = 0, side = 1;

    int width() const { return width_px * side; }
    int height() const { return height_px * side; }
    int first_x() const { return -(width() / 2); }
    int first_y() const { return -(height() / 2); }
    std::size_t count() const { return std::size_t(width()) * std::size_t(height()); }
    std::size_t at(int x, int y) const { return std::size_t(y) * std::size_t(width()) + std::size_t(x); }
};

/// Every sample by itself.
class BruteForce {
  public:
    explicit BruteForce(const SampleFrame& frame, Rgba8 background = {0, 0, 0, 0})
        : frame_(frame), color_(frame.count(), background), q_(frame.count()), is_covered_(frame.count()) {}

    const std::vector<Rgba8>& colors() const { return color_; }
    bool is_covered(int x, int y) const { return is_covered_[frame_.at(x, y)] != 0; }

    /// The first polygon that covers a sample stays. Returns how many it got.
    std::size_t draw_strict(const TilePolygon& p, const JitterPatterns* patterns = nullptr) {
        return for_covered(p, patterns, [&](std::size_t at, Rgba8 color, int, int) {
            if (is_covered_[at]) return false;
            is_covered_[at] = 1;
            color_[at] = color;
            return true;
        });
    }
    /// The nearer one stays; of two at the same depth the larger color.
    std::size_t draw_lazy(const TilePolygon& p, const JitterPatterns* patterns = nullptr) {
        return for_covered(p, patterns, [&](std::size_t at, Rgba8 color, int x, int y) {
            const float q = p.surface.depth.inside(p.surface.depth.row(y) + p.surface.depth.column(x));
            if (is_covered_[at]) {
                const bool wins = q > q_[at] || (q == q_[at] && std::bit_cast<std::uint32_t>(color) >
                                                                    std::bit_cast<std::uint32_t>(color_[at]));
                if (!wins) return false;
            }
            is_covered_[at] = 1;
            color_[at] = color;
            q_[at] = q;
            return true;
        });
    }

  private:
    template <class Draw>
    std::size_t for_covered(const TilePolygon& p, const JitterPatterns* patterns, Draw&& draw) const {
        const auto count = std::ptrdiff_t(p.corners);
        const auto [low_x, high_x] = std::minmax_element(p.x.begin(), p.x.begin() + count);
        const auto [low_y, high_y] = std::minmax_element(p.y.begin(), p.y.begin() + count);
        const int x0 = std::max((*low_x >> 8) - 2 - frame_.first_x(), 0);
        const int y0 = std::max((*low_y >> 8) - 2 - frame_.first_y(), 0);
        const int x1 = std::min((*high_x >> 8) + 2 - frame_.first_x(), frame_.width() - 1);
        const int y1 = std::min((*high_y >> 8) + 2 - frame_.first_y(), frame_.height() - 1);
        std::size_t drawn = 0;
        for (int j = y0; j <= y1; ++j) {
            for (int i = x0; i <= x1; ++i) {
                const int x = i + frame_.first_x(), y = j + frame_.first_y();
                int dx = 0, dy = 0;
                if (patterns != nullptr) {
                    const auto k = unsigned(j % 8 * 8 + i % 8);
                    const JitterPattern& pattern = patterns->pattern_of(i / 8, j / 8);
                    dx = pattern.x(k), dy = pattern.y(k);
                }
                if (!covers(p, std::int64_t(x) * 256 + 128 + dx, std::int64_t(y) * 256 + 128 + dy)) continue;
                const Surface& s = p.surface;
                // With 64 samples a pixel colors are taken near its center, alpha among them.
                const int cx = frame_.side == 1 ? x : x - i % 8 + 4, cy = frame_.side == 1 ? y : y - j % 8 + 4;
                Rgba8 color = s.colors[0];
                if (!s.is_flat && frame_.side != 1) {
                    color = s.gradient.pixel(float(cx), float(cy));
                } else if (!s.is_flat) {
                    const Rgba8 corners[3] = {s.colors[0], s.colors[1], s.colors[2]};
                    color = ColorPlane(s.triangle, s.triangle.doubled_area(), s.color_weight).at(cx, cy, corners);
                }
                if (color.a != 255 && !covered_by_hash(x, y, s.hash, color.a)) continue;
                color.a = 255;
                drawn += draw(frame_.at(i, j), color, x, y) ? 1u : 0u;
            }
        }
        return drawn;
    }

    SampleFrame frame_;
    std::vector<Rgba8> color_;
    std::vector<float> q_;
    std::vector<std::uint8_t> is_covered_;
};

/// A `samples` policy without a far field that keeps every sample and complains about whatever breaks the rules. The
/// picture has a pixel a sample.
template <int side>
class RecordedSamples : public SinglePixels {
  public:
    static constexpr int samples_a_side = side;
    static constexpr bool shades_samples = side == 1;

    void begin(int width_px, int height_px) {
        frame_ = {width_px, height_px, side};
        columns_ = std::size_t(frame_.width() + 63) / 64;
        const std::size_t blocks = columns_ * (std::size_t(frame_.height() + 63) / 64);
        color_.assign(frame_.count(), {});
        times_.assign(frame_.count(), 0);
        state_.assign(blocks, untouched);
        has_samples_.assign(blocks * 64, 0);
        error_ = {};
    }
    void open_block(const MaskBlock& block) {
        check(block);
        if (state_[block.index] == filled) fail("a filled block was opened");
        state_[block.index] = open;
    }
    template <class Stores = void>
    void cover_block(const MaskBlock& block, std::uint64_t masks, const Surface& surface) {
        check(block);
        for (unsigned k = 0; k < 64; ++k) {
            const int x = 64 * block.x + 8 * int(k % 8), y = 64 * block.y + 8 * int(k / 8);
            const bool is_inside = x < frame_.width() && y < frame_.height();
            if (is_inside != ((masks >> k & 1) != 0)) fail("masks of a filled block are not those inside the image");
        }
        const auto first = has_samples_.begin() + std::ptrdiff_t(64 * block.index);
        if (state_[block.index] == filled || std::find(first, first + 64, 1) != first + 64)
            fail("a block was filled that had samples");
        state_[block.index] = filled;
        for (unsigned k = 0; k < 64; ++k) come(block, k, all_subcells, surface);
    }
    template <class Stores = void>
    void cover_masks(const MaskBlock& block, std::uint64_t masks, const Surface& surface) {
        check_open(block);
        for (unsigned k = 0; k < 64; ++k) {
            if ((masks >> k & 1) == 0) continue;
            if (has_samples_[64 * block.index + k]) fail("a mask was covered that had samples");
            has_samples_[64 * block.index + k] = 1;
            come(block, k, all_subcells, surface);
        }
    }
    template <class Stores = void>
    void add(const MaskBlock& block, unsigned k, std::uint64_t samples, int count, const Surface& surface,
             bool is_first) {
        check_open(block);
        if (count != std::popcount(samples)) fail("a wrong count of samples");
        if (is_first == (has_samples_[64 * block.index + k] != 0)) fail("is_first is wrong");
        has_samples_[64 * block.index + k] = 1;
        come(block, k, samples, surface);
    }
    template <class F>
    void add_all(const MaskBlock& block, unsigned k, F&& f) {
        check_open(block);
        if (has_samples_[64 * block.index + k] != 0) fail("a mask was shown that had samples");
        has_samples_[64 * block.index + k] = 1;
        f([&](std::uint64_t samples, Rgba8 color) {
            for_samples(block, k, samples, [&](std::size_t at, int, int) {
                ++times_[at];
                color_[at] = color;
            });
        });
    }
    void replace(const MaskBlock& block, unsigned k, const DeepMask& deep) {
        check_open(block);
        for (unsigned s = 0; s < 64; ++s) {
            for_samples(block, k, std::uint64_t(1) << s, [&](std::size_t at, int, int) {
                ++times_[at];
                color_[at] = deep.color[s];
            });
        }
    }
    void resolve(Image& image) {
        if (image.width() != frame_.width() || image.height() != frame_.height())
            image = Image(frame_.width(), frame_.height());
        std::copy(color_.begin(), color_.end(), image.pixels().begin());
        for (const std::int32_t times : times_) {
            if (times == 0) fail("a sample did not come");
            if (times > 1) fail("a sample came more than once");
        }
        last_error = error_;
    }

    /// Of the last frame that was resolved; empty: none.
    static inline std::string last_error;

  private:
    enum State : std::uint8_t { untouched, open, filled };

    void fail(const char* what) {
        if (error_.empty()) error_ = what;
    }
    void check(const MaskBlock& b) {
        const bool is_right = b.index == std::size_t(b.y) * columns_ + std::size_t(b.x) && b.index < state_.size() &&
                              b.sample_x == 64 * b.x + frame_.first_x() && b.sample_y == 64 * b.y + frame_.first_y();
        if (!is_right) fail("a block is not where it says");
    }
    void check_open(const MaskBlock& block) {
        check(block);
        if (state_[block.index] != open) fail("a block was written that is not open");
    }
    void come(const MaskBlock& block, unsigned k, std::uint64_t samples, const Surface& surface) {
        for_samples(block, k, samples, [&](std::size_t at, int x, int y) {
            ++times_[at];
            color_[at] = color_of(surface, block, k, x, y);
        });
    }
    static Rgba8 color_of(const Surface& surface, const MaskBlock& block, unsigned k, int x, int y) {
        if (surface.is_flat) return surface.seen_color();
        if (shades_samples) return surface.seen_color_at(block.sample_x + x, block.sample_y + y);
        return surface.seen_color_of_pixel(block.sample_x_of(k), block.sample_y_of(k));
    }
    /// Those inside the image: f(index, x, y), the latter in the block.
    template <class F>
    void for_samples(const MaskBlock& block, unsigned k, std::uint64_t samples, F&& f) {
        for (; samples != 0; samples &= samples - 1) {
            const auto s = unsigned(std::countr_zero(samples));
            const int x = int(8 * (k % 8) + s % 8), y = int(8 * (k / 8) + s / 8);
            if (64 * block.x + x >= frame_.width() || 64 * block.y + y >= frame_.height()) continue;
            f(frame_.at(64 * block.x + x, 64 * block.y + y), x, y);
        }
    }

    SampleFrame frame_;
    std::size_t columns_ = 0;
    std::vector<Rgba8> color_;
    std::vector<std::int32_t> times_;
    std::vector<State> state_;
    std::vector<std::uint8_t> has_samples_;
    std::string error_;
};

template <int side>
struct RecordedStrict : StrictCoverage {
    using samples = RecordedSamples<side>;
};
template <int side>
struct RecordedLazy : LazyCoverage {
    using samples = RecordedSamples<side>;
};

/// All that remains, as CoverageRenderer::end_frame().
inline TilePolygon background_polygon(const SampleFrame& frame, Rgba8 color) {
    TilePolygon p;
    const std::int32_t left = 256 * frame.first_x(), right = left + 256 * frame.width();
    const std::int32_t top = 256 * frame.first_y(), bottom = top + 256 * frame.height();
    p.corners = 4;
    p.x = {left, right, right, left};
    p.y = {top, top, bottom, bottom};
    p.surface.kind = SurfaceKind::background;
    p.surface.colors.fill(color);
    p.surface.depth.at_corner = p.surface.depth.lowest = p.surface.depth.highest =
        -std::numeric_limits<float>::infinity();
    return p;
}

/// Frames of polygons that are on the screen already.
template <class Traits>
class TiledFrames {
  public:
    using Target = CoverageTarget<Traits>;

    explicit TiledFrames(Simd simd) : tiler_(simd) {}

    Target& target() { return target_; }

    void begin(const SampleFrame& frame) {
        frame_ = frame;
        target_.begin(frame.width_px, frame.height_px, frame.first_x(), frame.first_y());
    }
    bool tile(TilePolygon polygon) { return tiler_.tile(target_, polygon); }
    /// Of something with this outline, nowhere nearer than q.
    bool is_seen(const TilePolygon& outline, float q, int grown_by) {
        Silhouette box;
        box.outline = outline;
        box.fronts = BoxFronts(q);
        return tiler_.is_seen(target_, box, grown_by);
    }
    const Image& end(Rgba8 background = {0, 0, 0, 0}) {
        tile(background_polygon(frame_, background));
        target_.resolve(image_);
        return image_;
    }
    const Image& draw(const SampleFrame& frame, const std::vector<TilePolygon>& polygons) {
        begin(frame);
        for (const TilePolygon& p : polygons) tile(p);
        return end();
    }

  private:
    CoverageTiler<Target> tiler_;
    Target target_;
    SampleFrame frame_;
    Image image_;
};

// --- polygons

struct ScreenPoint {
    std::int32_t x, y;
};

/// Clockwise, without corners of 180 degrees; empty: of no area, or of more corners than a tiler takes.
inline std::vector<ScreenPoint> hull_of(std::vector<ScreenPoint> points) {
    const auto turn = [](ScreenPoint a, ScreenPoint b, ScreenPoint c) {
        return std::int64_t(b.x - a.x) * (c.y - b.y) - std::int64_t(b.y - a.y) * (c.x - b.x);
    };
    // Gift wrapping: slow, and hard to get wrong.
    std::size_t first = 0;
    for (std::size_t i = 1; i < points.size(); ++i) {
        if (points[i].x < points[first].x || (points[i].x == points[first].x && points[i].y < points[first].y))
            first = i;
    }
    std::vector<ScreenPoint> hull;
    ScreenPoint at = points[first];
    do {
        hull.push_back(at);
        ScreenPoint next = at;
        for (const ScreenPoint p : points) {
            if (p.x == at.x && p.y == at.y) continue;
            const bool is_none = next.x == at.x && next.y == at.y;
            const std::int64_t t = is_none ? -1 : turn(at, next, p);
            const auto length = [&](ScreenPoint q) {
                return std::int64_t(q.x - at.x) * (q.x - at.x) + std::int64_t(q.y - at.y) * (q.y - at.y);
            };
            if (t < 0 || (t == 0 && length(p) > length(next))) next = p;
        }
        at = next;
    } while ((at.x != points[first].x || at.y != points[first].y) && hull.size() <= points.size());
    if (hull.size() < 3 || hull.size() > std::size_t(TilePolygon::most_corners)) return {};
    return hull;
}

/// Of points of which the first three span an area, clockwise; their depths make the plane.
inline TilePolygon tile_polygon(const std::vector<ScreenPoint>& corners, std::array<float, 3> q, Rgba8 color) {
    TilePolygon p;
    p.corners = int(corners.size());
    for (std::size_t c = 0; c < corners.size(); ++c) {
        p.x[c] = corners[c].x;
        p.y[c] = corners[c].y;
    }
    const SnappedTriangle t{{p.x[0], p.x[1], p.x[2]}, {p.y[0], p.y[1], p.y[2]}, {q[0], q[1], q[2]}};
    DepthPlane& d = p.surface.depth = DepthPlane(t, t.doubled_area());
    for (std::size_t c = 3; c < corners.size(); ++c) {
        const float at =
            d.at_corner + d.by_x * (float(p.x[c] - p.x[0]) / 256) + d.by_y * (float(p.y[c] - p.y[0]) / 256);
        d.lowest = std::min(d.lowest, at);
        d.highest = std::max(d.highest, at);
    }
    p.surface.colors.fill(color);
    p.surface.triangle = t;
    return p;
}

/// 24 bits of a number, never transparent.
inline Rgba8 numbered(std::uint32_t i) {
    i = (i + 1) * 0x9e3779b1u;
    return {std::uint8_t(i >> 8), std::uint8_t(i >> 16), std::uint8_t(i >> 24), 255};
}

/// Any convex polygon anywhere: from specks to what reaches beyond the guard band's corners, slivers, corners and edges
/// through samples' centers, edges along rows and columns, corners twice and corners of 180 degrees.
inline TilePolygon random_polygon(Random& random, const SampleFrame& frame, std::uint32_t number) {
    constexpr std::int32_t limit = (1 << 22) - 1;
    while (true) {
        const std::uint32_t kind = random.below(8);
        const unsigned log2_size = 6 + random.below(random.below(4) == 0 ? 17 : 11);
        const auto size = std::int32_t(1) << log2_size;
        const auto margin = std::int32_t(600);
        const std::int32_t cx = std::int32_t(random.below(std::uint32_t(frame.width() * 256 + 2 * margin))) - margin +
                                256 * frame.first_x();
        const std::int32_t cy = std::int32_t(random.below(std::uint32_t(frame.height() * 256 + 2 * margin))) - margin +
                                256 * frame.first_y();
        const auto near = [&](std::int32_t center) {
            std::int32_t v = center + std::int32_t(random.below(std::uint32_t(2 * size))) - size;
            if (kind == 0) v = (v & ~127);          // centers and borders of samples
            if (kind == 1) v = (v & ~255) + 128;    // centers
            if (kind == 2) v = (v & ~2047);         // borders of masks
            if (kind == 3) v = (v & ~16383) + 128;  // first samples of blocks
            return std::clamp(v, -limit, limit);
        };
        std::vector<ScreenPoint> points;
        const std::uint32_t count = kind == 4 ? 2 : 3 + random.below(4);
        for (std::uint32_t i = 0; i < count; ++i) {
            const std::int32_t x = near(cx), y = near(cy);
            points.push_back({x, y});
        }
        if (kind == 4) {  // slivers
            for (int i = 0; i < 2; ++i) {
                const float t = random.between(-0.2f, 1.2f);
                const std::int32_t dx = std::int32_t(random.below(9)) - 4, dy = std::int32_t(random.below(9)) - 4;
                points.push_back(
                    {std::clamp(points[0].x + std::int32_t(t * float(points[1].x - points[0].x)) + dx, -limit, limit),
                     std::clamp(points[0].y + std::int32_t(t * float(points[1].y - points[0].y)) + dy, -limit, limit)});
            }
        }
        if (kind == 5) {  // rectangles
            points.resize(2);
            points.push_back({points[0].x, points[1].y});
            points.push_back({points[1].x, points[0].y});
        }
        std::vector<ScreenPoint> corners = hull_of(points);
        if (corners.empty()) continue;
        if (corners.size() < std::size_t(TilePolygon::most_corners) && random.below(4) == 0) {
            const ScreenPoint a = corners.back(), b = corners.front();
            const bool is_twice = random.below(2) == 0 || ((a.x ^ b.x) & 1) != 0 || ((a.y ^ b.y) & 1) != 0;
            corners.push_back(is_twice ? a : ScreenPoint{(a.x + b.x) / 2, (a.y + b.y) / 2});
        }
        const float base = random.between(0.1f, 1), tilt = random.below(3) == 0 ? 0.0f : random.unit();
        std::array<float, 3> q;
        for (float& v : q) v = base + tilt * random.between(-0.09f, 0.9f);
        return tile_polygon(corners, q, numbered(number));
    }
}

inline std::vector<TilePolygon> random_polygons(Random& random, const SampleFrame& frame, std::uint32_t count) {
    std::vector<TilePolygon> out;
    for (std::uint32_t i = 0; i < count; ++i) out.push_back(random_polygon(random, frame, i));
    return out;
}

/// A float in [center - half, center + half], that taken exactly; often an end.
inline float inside_of(Random& random, float center, float half) {
    constexpr float infinity = std::numeric_limits<float>::infinity();
    const double low = double(center) - double(half), high = double(center) + double(half);
    const std::uint32_t kind = random.below(4);
    const double between = low + (high - low) * double(random.unit());
    auto v = float(kind == 0 ? low : kind == 1 ? high : between);
    if (double(v) < low) v = std::nextafter(v, infinity);
    if (double(v) > high) v = std::nextafter(v, -infinity);
    return v;
}

/// Samples that differ.
inline std::size_t different_samples(const Image& image, const std::vector<Rgba8>& samples) {
    if (image.pixels().size() != samples.size()) return std::numeric_limits<std::size_t>::max();
    std::size_t count = 0;
    for (std::size_t i = 0; i < samples.size(); ++i) count += image.pixels()[i] != samples[i] ? 1u : 0u;
    return count;
}

}  // namespace farfield::test
