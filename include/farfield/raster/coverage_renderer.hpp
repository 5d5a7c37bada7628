// A renderer that never touches a hidden sample twice: hierarchical polygon tiling with coverage masks (Greene 1996).
// 64 samples a pixel cost about what one costs others, and it tells any hierarchy which cells are hidden.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <memory>
#include <optional>
#include <span>
#include <stdexcept>
#include <type_traits>
#include <utility>
#include <vector>

#include "farfield/coverage/coverage_tiler.hpp"
#include "farfield/coverage/silhouette.hpp"
#include "farfield/geometry/light.hpp"
#include "farfield/raster/image.hpp"
#include "farfield/raster/light_in_view.hpp"
#include "farfield/raster/polygon_clip.hpp"
#include "farfield/raster/polygon_stream.hpp"
#include "farfield/raster/sample_projection.hpp"
#include "farfield/renderer.hpp"

namespace farfield {

/// How far-field cells meet masks.
enum class FarCoverage : std::uint8_t {
    /// Opacity is a part of the 64 samples, chosen anew for every cell and pixel: in cells of a pixel closed surfaces
    /// stay
    /// closed. In larger ones single sheets get holes.
    samples,
    /// By the area law, transmittances on top of the masks: large cells of sheets leak a quarter as much, but where far
    /// cells adjoin geometry within a pixel a closed surface is torn. For box-filtered images; others take `samples`.
    area_law,
};

struct CoverageOptions {
    Rgba8 background{0, 0, 0, 0};             ///< premultiplied
    std::optional<DirectionalLight> light{};  ///< in the outermost hierarchy's axes; none: colors as they are
    bool culls_back_faces = false;            ///< for closed surfaces that are counter-clockwise seen from outside
    Simd simd = Simd::automatic;              ///< all give the same picture
    FarCoverage far_coverage = FarCoverage::samples;
};

/// Draws what a Viewer hands over; the picture is image() after the frame. Colors that differ over a primitive are
/// taken once a pixel. Primitives with alpha below 255 cover that part of the samples, chosen as ZBufferRenderer does.
///
/// `strict` wants primitives front to back, and hierarchies that promise it: nothing is compared, nothing is written
/// twice. `lazy` takes any order and gives the samples of a z-buffer; what comes nearly front to back costs little
/// more.
template <class Traits>
class BasicCoverageRenderer {
    static constexpr bool is_lazy = Traits::order == CoverageOrder::lazy;
    static constexpr int samples_a_side = Traits::samples::samples_a_side;

  public:
    static constexpr RendererFacts facts{
        .order = Order::front_to_back,
        .needs_ordering = is_lazy ? Ordering::none : Ordering::primitives,
        .keeps_sources = true,
        .draws_faces = is_lazy,
        .draws_splats = is_lazy,
        .draws_polygons = true,
        .answers_hidden = true,
    };

    explicit BasicCoverageRenderer(const CoverageOptions& options = {})
        : options_(options), light_(options.light), tiler_(options.simd) {}

    const Image& image() const { return image_; }
    /// Of the last frame.
    const typename Traits::work& work() const { return target_.work; }
    /// Of the coverage pyramid: 1 2/63 bits a sample where the image's sides are powers of 8.
    std::size_t pyramid_bytes() const { return target_.pyramid.bytes(); }

    template <PrimitiveWithPolygons P>
    std::uint32_t page_in(const Source<P>& source) {
        for (std::size_t i = 0; i < streams_.size(); ++i) {
            if (!streams_[i]) return streams_[i] = std::make_unique<PolygonStream>(source), std::uint32_t(i);
        }
        streams_.push_back(std::make_unique<PolygonStream>(source));
        return std::uint32_t(streams_.size() - 1);
    }
    void page_out(std::uint32_t id) { streams_[id].reset(); }

    /// Throws std::invalid_argument for images of no or too many samples: 31,000 on a side.
    void begin_frame(const LocalView& view) {
        constexpr int limit = 31000 / samples_a_side;
        if (view.width < 1 || view.height < 1 || view.width > limit || view.height > limit) {
            throw std::invalid_argument("farfield::CoverageRenderer: an image must have 1 to " + std::to_string(limit) +
                                        " pixels on a side");
        }
        to_ = SampleProjection(view, samples_a_side);
        target_.begin(view.width, view.height, to_.first_x, to_.first_y);
        light_.begin_frame(view);
    }
    void set_view(const LocalView& view) {
        to_ = SampleProjection(view, samples_a_side);
        light_.set_view(view);
    }
    /// "We composite a screen-sized polygon of the desired background color, thereby tiling all remaining vacant
    /// pixels" (section 4.5).
    void end_frame() {
        const std::int32_t left = 256 * to_.first_x, right = 256 * to_.end_x;
        const std::int32_t top = 256 * to_.first_y, bottom = 256 * to_.end_y;
        polygon_.corners = 4;
        polygon_.x = {left, right, right, left};
        polygon_.y = {top, top, bottom, bottom};
        polygon_.surface = {};
        polygon_.surface.is_background = true;
        polygon_.surface.colors.fill(options_.background);
        constexpr float infinity = std::numeric_limits<float>::infinity();
        polygon_.surface.depth.at_corner = -infinity;
        polygon_.surface.depth.lowest = polygon_.surface.depth.highest = -infinity;
        auto work = std::move(target_.work);
        target_.work.begin(target_.pyramid);
        tiler_.tile(target_, polygon_);
        target_.work = std::move(work);
        target_.resolve(image_);
    }

    template <class P>
    void draw(const Source<P>& source, std::span<const Range> ranges) {
        const PolygonStream& stream = *streams_[source.id];
        for (std::size_t i = 0; i < ranges.size(); ++i) {
            if (i + 8 < ranges.size()) stream.prefetch(ranges[i + 8].first, true);
            if (i + 4 < ranges.size()) stream.prefetch(ranges[i + 4].first, false);
            const std::uint32_t end = stream.first_record(ranges[i].first + ranges[i].count);
            for (std::uint32_t at = stream.first_record(ranges[i].first); at < end; ++at) draw(stream, stream[at]);
        }
    }

    void draw(std::span<const Polygon> polygons) {
        scratch_.clear();
        for (const Polygon& polygon : polygons) scratch_.add(polygon);
        for (std::uint32_t at = 0; at < scratch_.size(); ++at) draw(scratch_, scratch_[at]);
    }

    void draw(std::span<const Face> faces) requires(is_lazy) {
        for (const Face& face : faces) draw(face);
    }
    void draw(std::span<const Splat> splats) requires(is_lazy) {
        for (const Splat& splat : splats) draw(splat);
    }
    /// A pixel or two: an upright rectangle is all the shape that shows.
    float largest_splat_px() const { return 2.0f; }

    /// Asked front to back: hidden behind what was drawn before. A box that reaches behind the near plane never is.
    bool hidden(const Cell& cell, CellId) {
        if (!silhouette_.project(cell.bounds_center, cell.bounds_half, to_)) return false;
        // Contents are projected and snapped by themselves, and may lie that much outside.
        constexpr int rounding = 8;
        return !tiler_.is_seen(target_, silhouette_, rounding);
    }

  private:
    using Target = CoverageTarget<Traits>;

    void draw(const PolygonStream& stream, const PolygonRecord& r) {
        // Four corners side by side, as SampleProjection does one.
        typedef float Floats __attribute__((vector_size(16)));
        typedef std::int32_t Ints __attribute__((vector_size(16)));
        constexpr float guard = SampleProjection::guard_band * 256;
        Floats dx, dy, dz;
        std::memcpy(&dx, r.x, sizeof dx);
        std::memcpy(&dy, r.y, sizeof dy);
        std::memcpy(&dz, r.z, sizeof dz);
        dx -= to_.eye.x, dy -= to_.eye.y, dz -= to_.eye.z;
        const Floats depth = dx * to_.forward.x + dy * to_.forward.y + dz * to_.forward.z;
        const Floats inverse = 1.0f / (depth * to_.depth_weight + to_.depth_bias);
        const Floats x = (dx * to_.right.x + dy * to_.right.y + dz * to_.right.z) * inverse + to_.offset_x;
        const Floats y = (dx * to_.down.x + dy * to_.down.y + dz * to_.down.z) * inverse + to_.offset_y;
        const Floats q = inverse * to_.q_of_inverse + depth * to_.q_of_depth;
        const Ints is_behind = depth < to_.near_depth;
        const Ints is_whole = ~is_behind & (x > -guard) & (x < guard) & (y > -guard) & (y < guard);
        if (!is_set(is_whole)) return is_set(is_behind) ? void() : draw_clipped(stream, r);
        Corners corners;
        const Floats snapped_x = x + snap_rounder, snapped_y = y + snap_rounder;
        std::memcpy(corners.x.data(), &snapped_x, sizeof snapped_x);
        std::memcpy(corners.y.data(), &snapped_y, sizeof snapped_y);
        std::memcpy(corners.q.data(), &q, sizeof q);
        for (unsigned c = 0; c < 4; ++c) {
            corners.x[c] -= std::int32_t(snap_rounder_bits);
            corners.y[c] -= std::int32_t(snap_rounder_bits);
        }
        const Rgba8* colors = r.colors == PolygonRecord::flat ? nullptr : stream.colors(r);
        if (r.is_triangle) {
            draw_triangle(r, corners, 0, 1, 2, colors);
        } else {
            draw_quadrilateral(r, corners, colors);
        }
    }

    /// In all four lanes.
    template <class Ints>
    static bool is_set(const Ints& lanes) {
        std::uint64_t halves[2];
        std::memcpy(halves, &lanes, sizeof halves);
        return (halves[0] & halves[1]) == ~std::uint64_t(0);
    }

    struct Corners {
        std::array<std::int32_t, 4> x, y;
        std::array<float, 4> q;

        std::int64_t turn(unsigned a, unsigned b, unsigned c) const {
            return std::int64_t(x[b] - x[a]) * (y[c] - y[b]) - std::int64_t(y[b] - y[a]) * (x[c] - x[b]);
        }
        SnappedTriangle triangle(unsigned a, unsigned b, unsigned c) const {
            return {{x[a], x[b], x[c]}, {y[a], y[b], y[c]}, {q[a], q[b], q[c]}};
        }
    };

    void draw_quadrilateral(const PolygonRecord& r, const Corners& k, const Rgba8* colors) {
        const auto [low_x, high_x] = std::minmax({k.x[0], k.x[1], k.x[2], k.x[3]});
        const auto [low_y, high_y] = std::minmax({k.y[0], k.y[1], k.y[2], k.y[3]});
        if (holds_no_sample(low_x, high_x, low_y, high_y)) return;
        const std::int64_t turns[4] = {k.turn(0, 1, 2), k.turn(1, 2, 3), k.turn(2, 3, 0), k.turn(3, 0, 1)};
        const bool is_clockwise = turns[0] >= 0 && turns[1] >= 0 && turns[2] >= 0 && turns[3] >= 0;
        const bool is_front = turns[0] <= 0 && turns[1] <= 0 && turns[2] <= 0 && turns[3] <= 0;
        if (is_clockwise == is_front) {
            // Snapping bent it, or it is nothing: then both were 0 throughout.
            if (is_front) return;
            draw_triangle(r, k, 0, 1, 2, colors);
            draw_triangle(r, k, 0, 2, 3, colors);
            return;
        }
        if (!is_front && options_.culls_back_faces) return;
        polygon_.corners = 4;
        const unsigned order[4] = {0, is_front ? 3u : 1u, 2, is_front ? 1u : 3u};
        for (unsigned c = 0; c < 4; ++c) {
            polygon_.x[c] = k.x[order[c]];
            polygon_.y[c] = k.y[order[c]];
        }
        // Depth and colors are those of the larger half's plane.
        const std::int64_t one = std::abs(k.triangle(0, 1, 2).doubled_area()),
                           other = std::abs(k.triangle(0, 2, 3).doubled_area());
        const unsigned half[3] = {0, one >= other ? 1u : 2u, one >= other ? 2u : 3u};
        SnappedTriangle t = k.triangle(half[0], half[1], half[2]);
        if (is_front) t.flip();
        if constexpr (is_lazy) {
            DepthPlane& plane = polygon_.surface.depth = DepthPlane(t, std::max(one, other));
            const auto [lowest, highest] = std::minmax({k.q[0], k.q[1], k.q[2], k.q[3]});
            plane.lowest = lowest;
            plane.highest = highest;
        }
        if (colors == nullptr) {
            shade(r, is_front, nullptr, t);
        } else {
            const Rgba8 of_half[4] = {colors[0], colors[half[1]], colors[half[2]], colors[one >= other ? 3 : 1]};
            shade(r, is_front, of_half, t);
        }
        tiler_.tile(target_, polygon_);
    }

    void draw_triangle(const PolygonRecord& r, const Corners& k, unsigned a, unsigned b, unsigned c,
                       const Rgba8* colors) {
        SnappedTriangle t = k.triangle(a, b, c);
        const auto [low_x, high_x] = std::minmax({t.x[0], t.x[1], t.x[2]});
        const auto [low_y, high_y] = std::minmax({t.y[0], t.y[1], t.y[2]});
        if (holds_no_sample(low_x, high_x, low_y, high_y)) return;
        if (colors == nullptr) return draw_triangle(r, t, nullptr);
        const Rgba8 own[4] = {colors[a], colors[b], colors[c], colors[c]};
        draw_triangle(r, t, own);
    }

    void draw_triangle(const PolygonRecord& r, SnappedTriangle t, const Rgba8* colors) {
        const std::int64_t area = t.doubled_area();
        if (area == 0) return;
        const bool is_front = area < 0;  // counter-clockwise, rows running downwards
        if (!is_front && options_.culls_back_faces) return;
        if (is_front) t.flip();
        polygon_.corners = 3;
        for (unsigned c = 0; c < 3; ++c) {
            polygon_.x[c] = t.x[c];
            polygon_.y[c] = t.y[c];
        }
        if constexpr (is_lazy) polygon_.surface.depth = DepthPlane(t, std::abs(area));
        shade(r, is_front, colors, t);
        tiler_.tile(target_, polygon_);
    }

    bool holds_no_sample(std::int32_t low_x, std::int32_t high_x, std::int32_t low_y, std::int32_t high_y) const {
        constexpr int reach = Target::reach_of_samples;
        const std::int32_t x0 = (low_x - reach + 127) >> 8, x1 = (high_x + reach - 128) >> 8;
        const std::int32_t y0 = (low_y - reach + 127) >> 8, y1 = (high_y + reach - 128) >> 8;
        return x0 > x1 || y0 > y1 || x0 >= to_.end_x || y0 >= to_.end_y || x1 < to_.first_x || y1 < to_.first_y;
    }

    /// Null colors: the record's one. Else four, in the order that corners had before they were turned clockwise: those
    /// of the triangle, and one more that the surface has.
    void shade(const PolygonRecord& r, bool is_front, const Rgba8* colors, const SnappedTriangle& clockwise) {
        Surface& s = polygon_.surface;
        s.is_background = s.is_fraction = s.is_deposit = false;
        s.is_perspective = to_.is_perspective;
        s.is_flat = colors == nullptr;
        s.colors.fill(r.color);
        s.is_solid = r.color.a == 255;
        if (colors != nullptr) {
            s.colors = {colors[0], colors[is_front ? 2 : 1], colors[is_front ? 1 : 2], colors[3]};
            s.is_solid = s.colors[0].a == 255 && s.colors[1].a == 255 && s.colors[2].a == 255;
        }
        const auto corner = [&](unsigned c) { return glm::vec3(r.x[c], r.y[c], r.z[c]); };
        if (!s.is_solid) s.hash = hash_of_triangle(corner(0), corner(1), corner(2));
        if (const DirectionalLight* light = light_.light()) {
            const glm::vec3 n = glm::cross(corner(1) - corner(0), corner(2) - corner(0));
            const float brightness = light->brightness(is_front ? n : -n);
            for (Rgba8& c : s.colors) c = scaled(c, brightness);
        }
        if (colors != nullptr) s.triangle = clockwise;
    }

    void draw_clipped(const PolygonStream& stream, const PolygonRecord& r) {
        const Rgba8* colors = r.colors == PolygonRecord::flat ? nullptr : stream.colors(r);
        ClippedPolygon clipped;
        for (unsigned c = 0; c < (r.is_triangle ? 3u : 4u); ++c) {
            clipped.add({r.x[c], r.y[c], r.z[c]}, to_, colors == nullptr ? glm::vec4(0) : to_vec4(colors[c]));
        }
        clipped.clip(to_);
        for (std::size_t i = 2; i < clipped.size(); ++i) {
            SnappedTriangle t;
            const std::size_t from[3] = {0, i - 1, i};
            Rgba8 corner_colors[4];
            for (unsigned c = 0; c < 3; ++c) {
                clipped.snap(from[c], to_, t, c);
                if (colors != nullptr) corner_colors[c] = to_rgba8(clipped[from[c]].color);
            }
            corner_colors[3] = corner_colors[2];
            draw_triangle(r, t, colors == nullptr ? nullptr : corner_colors);
        }
    }

    // --- the far field

    void draw(const Face& face) {
        if (face.rgba.a == 0) return;
        ClippedPolygon clipped;
        const int axis = face.side / 2, u = (axis + 1) % 3, v = (axis + 2) % 3;
        for (int corner = 0; corner < 4; ++corner) {
            glm::vec3 p = face.lower;
            if (corner == 1 || corner == 2) p[u] = face.upper[u];
            if (corner >= 2) p[v] = face.upper[v];
            clipped.add(p, to_);
        }
        clipped.clip(to_);
        const float opacity = float(face.rgba.a) * (1 / 255.0f);
        const glm::vec3 rgb =
            glm::vec3(float(face.rgba.r), float(face.rgba.g), float(face.rgba.b)) * (1.0f / float(face.rgba.a));
        shade_far(rgb, opacity, law_of_opacity(opacity),
                  hash_of_triangle(face.lower, face.upper, glm::vec3(face.side)));
        for (std::size_t i = 2; i < clipped.size(); ++i) {
            SnappedTriangle t;
            const std::size_t from[3] = {0, i - 1, i};
            for (unsigned c = 0; c < 3; ++c) clipped.snap(from[c], to_, t, c);
            std::int64_t area = t.doubled_area();
            if (area == 0) continue;
            if (area < 0) t.flip(), area = -area;
            polygon_.corners = 3;
            for (unsigned c = 0; c < 3; ++c) {
                polygon_.x[c] = t.x[c];
                polygon_.y[c] = t.y[c];
            }
            polygon_.surface.depth = DepthPlane(t, area);
            tiler_.tile(target_, polygon_);
        }
    }

    void draw(const Splat& splat) {
        const glm::vec3 p = to_.project(splat.center);
        if (!(p.z > to_.near_depth)) return;
        const float inverse = to_.inverse_w(p.z);
        const float x = p.x * inverse + to_.offset_x, y = p.y * inverse + to_.offset_y;
        const glm::vec2 half = splat.size * (128.0f * to_.focal * inverse);
        const float guard = SampleProjection::guard_band * 256;
        if (!(x - half.x > -guard && x + half.x < guard && y - half.y > -guard && y + half.y < guard)) return;
        const glm::vec3 rgb = glm::vec3(float(splat.rgb.r), float(splat.rgb.g), float(splat.rgb.b)) * (1 / 255.0f);
        const auto law = AreaLaw(splat.rgb.a);
        // A rectangle narrower than a sample would fall between samples: what it lacks in opacity it has in size.
        const glm::vec2 grown = glm::max(half, glm::vec2(128));
        const float opacity = splat.opacity * (half.x * half.y) / (grown.x * grown.y);
        const std::int32_t left = snapped_to_256th(x - grown.x), right = snapped_to_256th(x + grown.x);
        const std::int32_t top = snapped_to_256th(y - grown.y), bottom = snapped_to_256th(y + grown.y);
        shade_far(rgb, opacity, law, hash_of_triangle(splat.center, splat.center, splat.center));
        polygon_.corners = 4;
        polygon_.x = {left, right, right, left};
        polygon_.y = {top, top, bottom, bottom};
        polygon_.surface.depth = {};
        polygon_.surface.depth.at_corner = polygon_.surface.depth.lowest = polygon_.surface.depth.highest =
            to_.q(p.z, inverse);
        tiler_.tile(target_, polygon_);
    }

    /// `rgb` in [0, 1], not premultiplied.
    void shade_far(glm::vec3 rgb, float opacity, AreaLaw law, std::uint32_t hash) {
        Surface& s = polygon_.surface;
        s = {};
        s.is_solid = false;
        if (Target::samples_type::takes_deposits && options_.far_coverage == FarCoverage::area_law) {
            s.is_deposit = s.is_background = true;
            s.colors.fill({0, 0, 0, 0});
            s.loss = loss_of_opacity(opacity, law);
            s.far_rgb = glm::min(rgb, glm::vec3(1));
        } else {
            s.is_fraction = true;
            s.hash = hash;
            s.colors.fill(to_rgba8(glm::vec4(rgb, opacity)));
        }
    }

    CoverageOptions options_;
    LightInView light_;
    CoverageTiler<Target> tiler_;
    Target target_;
    SampleProjection to_;
    TilePolygon polygon_;  ///< the one at work
    Silhouette silhouette_;
    std::vector<std::unique_ptr<PolygonStream>> streams_;
    PolygonStream scratch_;  ///< polygons made for this frame
    Image image_;
};

/// Any hierarchy, any order.
using CoverageRenderer = BasicCoverageRenderer<LazyCoverage>;
/// Hierarchies that keep strict order: SpatialHierarchy<PolygonBsp, Exact, ...> and the like.
using StrictCoverageRenderer = BasicCoverageRenderer<StrictCoverage>;

/// Strict where the hierarchy promises strict order, lazy elsewhere.
template <class H>
using CoverageRendererFor =
    std::conditional_t<H::ordering == Ordering::primitives, StrictCoverageRenderer, CoverageRenderer>;

}  // namespace farfield
