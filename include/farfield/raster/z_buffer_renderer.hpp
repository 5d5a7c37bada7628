// The reference renderer: scan conversion of triangles and convex polygons into a z-buffer of 1 to 64 samples a pixel,
// with far-field cells composited over it front to back.
//
// It is the yardstick of every ratio in this house, so it must be honest competition: eight triangles at a step, those
// without a sample rejected before set-up, only what was drawn cleared and resolved.
#pragma once

#include <bit>
#include <cmath>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "farfield/geometry/light.hpp"
#include "farfield/raster/image.hpp"
#include "farfield/raster/polygon_clip.hpp"
#include "farfield/raster/sample_buffers.hpp"
#include "farfield/raster/scan_conversion.hpp"
#include "farfield/raster/shading.hpp"
#include "farfield/raster/triangle_stream.hpp"
#include "farfield/raster/triangle_triage.hpp"
#include "farfield/renderer.hpp"

namespace farfield {

struct ZBufferOptions {
    int samples = 1;                          ///< a pixel, on a regular grid: 1, 4, 9, 16, 25, 36, 49 or 64
    Rgba8 background{0, 0, 0, 0};             ///< premultiplied
    std::optional<DirectionalLight> light{};  ///< in the outermost hierarchy's axes; none: colors as they are
    bool culls_back_faces = false;            ///< for closed surfaces that are counter-clockwise seen from outside
    Simd simd = Simd::automatic;              ///< all give the same picture
};

/// Draws what a Viewer hands over; the picture is image() after the frame. The result does not depend on the order of
/// primitives: of two at the same depth the larger color wins. Primitives with alpha below 255 cover that part of the
/// samples, chosen by a hash of sample and primitive: stable from frame to frame, needing no order (after Wyman and
/// McGuire 2017, "Hashed alpha testing").
class ZBufferRenderer {
  public:
    static constexpr RendererFacts facts{
        .keeps_sources = true, .draws_faces = true, .draws_splats = true, .answers_hidden = true};

    /// Throws std::invalid_argument for a number of samples that is not a square of 1 to 8.
    explicit ZBufferRenderer(const ZBufferOptions& options = {}) : options_(options) {
        while (side_ * side_ < options.samples) ++side_;
        if (options.samples < 1 || side_ > 8 || side_ * side_ != options.samples) {
            throw std::invalid_argument(
                "farfield::ZBufferRenderer: samples must be 1, 4, 9, 16, 25, 36, 49 or 64, not " +
                std::to_string(options.samples));
        }
        triage_ = triage_function(options.simd);
    }

    const Image& image() const { return image_; }

    template <PrimitiveWithPolygons P>
    std::uint32_t page_in(const Source<P>& source) {
        for (std::size_t i = 0; i < streams_.size(); ++i) {
            if (!streams_[i]) return streams_[i] = std::make_unique<TriangleStream>(source), std::uint32_t(i);
        }
        streams_.push_back(std::make_unique<TriangleStream>(source));
        return std::uint32_t(streams_.size() - 1);
    }
    void page_out(std::uint32_t id) { streams_[id].reset(); }

    /// Throws std::invalid_argument for images of no or too many samples: 16,000 on a side.
    void begin_frame(const LocalView& view) {
        const double limit = SampleProjection::guard_band;
        if (view.width < 1 || view.height < 1 || double(view.width) * side_ > limit ||
            double(view.height) * side_ > limit) {
            throw std::invalid_argument("farfield::ZBufferRenderer: an image must have 1 to 16000 samples on a side");
        }
        to_ = SampleProjection(view, side_);
        buffers_.begin(to_, side_, options_.background);
        if (options_.light) {
            const glm::vec3 l = options_.light->towards;
            light_in_view_ = {glm::dot(l, view.right), glm::dot(l, view.up), glm::dot(l, view.forward)};
        }
    }
    void set_view(const LocalView& view) {
        to_ = SampleProjection(view, side_);
        if (options_.light) {
            light_ = *options_.light;
            light_.towards =
                view.right * light_in_view_.x + view.up * light_in_view_.y + view.forward * light_in_view_.z;
        }
    }
    void end_frame() { buffers_.resolve(image_); }

    template <class P>
    void draw(const Source<P>& source, std::span<const Range> ranges) {
        const TriangleStream& stream = *streams_[source.id];
        for (const Range r : ranges)
            draw(stream, stream.first_triangle(r.first), stream.first_triangle(r.first + r.count));
    }

    void draw(std::span<const Face> faces) {
        buffers_.begin_far();
        for (const Face& face : faces) draw(face);
    }

    void draw(std::span<const Splat> splats) {
        buffers_.begin_far();
        for (const Splat& splat : splats) {
            switch (AreaLaw(splat.rgb.a)) {
                case AreaLaw::coherent:
                    deposit<AreaLaw::coherent>(splat);
                    break;
                case AreaLaw::mixed:
                    deposit<AreaLaw::mixed>(splat);
                    break;
                case AreaLaw::independent:
                    deposit<AreaLaw::independent>(splat);
                    break;
            }
        }
    }
    /// Two samples: a deposit then touches at most three by three.
    float largest_splat_px() const { return 2.0f / float(side_); }

    /// Asked in front-to-back order. Geometry drawn before hides what lies behind all of it, and that exactly; where
    /// the far field closed a sample, contents of a loose cell that reach in front of a cell already drawn may be lost
    /// with it, by less than a cell. Before the first stand-in of a frame nothing is hidden: without a far field every
    /// primitive in the frustum is drawn.
    bool hidden(const Cell& cell, CellId) {
        if (!buffers_.has_far()) return false;
        const glm::vec3 p = to_.project(cell.bounds_center);
        const float radius = std::sqrt(glm::dot(cell.bounds_half, cell.bounds_half));
        // A point of the sphere is off by at most radius (focal + |x|) / (depth - radius) from its center's image.
        const float nearest = to_.is_perspective ? p.z - radius : 1.0f;
        if (!(nearest > 0)) return false;
        const float inverse = to_.inverse_w(p.z) * (1.0f / 256), x = p.x * inverse, y = p.y * inverse;
        const float skew = to_.is_perspective ? 1.0f : 0.0f, reach = radius / nearest;
        const float rx = reach * (to_.focal + skew * std::abs(x)), ry = reach * (to_.focal + skew * std::abs(y));
        if (!(rx < 64 && ry < 64)) return false;  // large ones are seldom hidden and their children are asked again
        const float cx = x + to_.offset_x * (1.0f / 256), cy = y + to_.offset_y * (1.0f / 256);
        // Nearer than any corner, roundings included: vertices are snapped, hence the sample added around.
        const float front = to_.is_perspective ? nearest : p.z - radius;
        const float rounding = (std::abs(p.z) + radius) * 0x1p-16f;
        const float q = to_.q(front - rounding, to_.inverse_w(std::max(front - rounding, 0.5f * nearest)));
        return buffers_.all_settled(int(std::floor(cx - rx)) - 1, int(std::floor(cy - ry)) - 1,
                                    int(std::floor(cx + rx)) + 1, int(std::floor(cy + ry)) + 1, q);
    }

  private:
    void draw(const TriangleStream& stream, std::uint32_t first, std::uint32_t end) {
        if (first >= end) return;
        constexpr std::uint32_t lanes = TriangleBlock::lanes;
        TriagedBlock triaged;
        for (std::uint32_t block = first / lanes; block <= (end - 1) / lanes; ++block) {
            const TriageMasks masks = triage_(stream.blocks()[block], to_, triaged);
            unsigned wanted = masks.draw | masks.clip;
            if (block * lanes < first) wanted &= ~0u << (first - block * lanes);
            if ((block + 1) * lanes > end) wanted &= (1u << (end - block * lanes)) - 1;
            for (; wanted != 0; wanted &= wanted - 1) {
                const auto lane = unsigned(std::countr_zero(wanted));
                const std::uint32_t triangle = block * lanes + lane;
                if (masks.clip >> lane & 1) {
                    draw_clipped(stream, triangle);
                } else {
                    SnappedTriangle t;
                    for (unsigned c = 0; c < 3; ++c) {
                        t.x[c] = snapped_to_256th(triaged.x[c][lane]);
                        t.y[c] = snapped_to_256th(triaged.y[c][lane]);
                        t.q[c] = triaged.q[c][lane];
                    }
                    const Rgba8* colors = stream.colors(triangle);
                    Rgba8 corners[3] = {colors[0], colors[0], colors[0]};
                    if (stream.several_colors()) corners[1] = colors[1], corners[2] = colors[2];
                    draw(stream, triangle, t, corners);
                }
            }
        }
    }

    void draw_clipped(const TriangleStream& stream, std::uint32_t triangle) {
        ClippedPolygon polygon;
        const Rgba8* colors = stream.colors(triangle);
        for (unsigned c = 0; c < 3; ++c) {
            polygon.add(stream.vertex(triangle, c), to_, to_vec4(colors[stream.several_colors() ? c : 0]));
        }
        polygon.clip(to_);
        for (std::size_t i = 2; i < polygon.size(); ++i) {
            SnappedTriangle t;
            Rgba8 corners[3];
            const std::size_t from[3] = {0, i - 1, i};
            for (unsigned c = 0; c < 3; ++c) {
                polygon.snap(from[c], to_, t, c);
                corners[c] = to_rgba8(polygon[from[c]].color);
            }
            draw(stream, triangle, t, corners);
        }
    }

    void draw(const TriangleStream& stream, std::uint32_t triangle, SnappedTriangle& t, Rgba8 (&colors)[3]) {
        const std::int64_t signed_area = t.doubled_area();
        if (signed_area == 0) return;
        const bool front = signed_area < 0;  // counter-clockwise, rows running downwards
        if (front) {
            t.flip();
            std::swap(colors[1], colors[2]);
        } else if (options_.culls_back_faces) {
            return;
        }
        const std::int64_t doubled_area = front ? -signed_area : signed_area;
        const auto light = [&] {
            if (!options_.light) return;
            const glm::vec3 a = stream.vertex(triangle, 0);
            const glm::vec3 normal = glm::cross(stream.vertex(triangle, 1) - a, stream.vertex(triangle, 2) - a);
            const float brightness = light_.brightness(front ? normal : -normal);
            for (Rgba8& c : colors) c = scaled(c, brightness);
        };
        const bool one_color = colors[0] == colors[1] && colors[0] == colors[2];
        if (one_color && colors[0].a == 255) {
            fill(t, doubled_area, light, [&](int, int) { return colors[0]; });
        } else {
            const ColorPlane plane(t, doubled_area, to_.is_perspective);
            const std::uint32_t hash =
                hash_of_triangle(stream.vertex(triangle, 0), stream.vertex(triangle, 1), stream.vertex(triangle, 2));
            fill(t, doubled_area, light, [&](int x, int y) {
                Rgba8 c = one_color ? colors[0] : plane.at(x, y, colors);
                if (c.a != 255 && !covered_by_hash(x, y, hash, c.a)) c.a = 0;
                return c;
            });
        }
    }

    /// shade(x, y) gives the sample's color; with alpha 0 it is not covered after all. What is not needed before a
    /// sample is known to be covered comes after: half of the triangles that get here cover none.
    template <class Light, class Shade>
    void fill(const SnappedTriangle& t, std::int64_t doubled_area, Light&& light, Shade&& shade) {
        DepthPlane plane;
        bool prepared = false;
        scan_convert(t, to_, [&](int y, int begin, int end) {
            if (!prepared) {
                prepared = true;
                plane = DepthPlane(t, doubled_area);
                light();
            }
            float* depth = buffers_.depth_row(y);
            Rgba8* color = buffers_.color_row(y);
            const float row = plane.row(y);
            buffers_.near_drawn(begin, y, end, y + 1);
            for (int x = begin; x < end; ++x) {
                const float q = plane.at(row, x);
                if (q < depth[x]) continue;
                Rgba8 c = shade(x, y);
                if (c.a == 0) continue;
                c.a = 255;
                if (q == depth[x] && std::bit_cast<std::uint32_t>(c) <= std::bit_cast<std::uint32_t>(color[x]))
                    continue;
                depth[x] = q;
                color[x] = c;
            }
        });
    }

    /// As a polygon, sample by sample: adjoining faces leave no gap.
    void draw(const Face& face) {
        if (face.rgba.a == 0) return;
        ClippedPolygon polygon;
        const int axis = face.side / 2, u = (axis + 1) % 3, v = (axis + 2) % 3;
        for (int corner = 0; corner < 4; ++corner) {
            glm::vec3 p = face.lower;
            if (corner == 1 || corner == 2) p[u] = face.upper[u];
            if (corner >= 2) p[v] = face.upper[v];
            polygon.add(p, to_);
        }
        polygon.clip(to_);
        switch (law_of_opacity(float(face.rgba.a) * (1 / 255.0f))) {
            case AreaLaw::coherent:
                return deposit<AreaLaw::coherent>(polygon, face.rgba);
            case AreaLaw::mixed:
                return deposit<AreaLaw::mixed>(polygon, face.rgba);
            case AreaLaw::independent:
                return deposit<AreaLaw::independent>(polygon, face.rgba);
        }
    }

    template <AreaLaw law>
    void deposit(const ClippedPolygon& polygon, Rgba8 premultiplied) {
        const float area = area_of_opacity(float(premultiplied.a) * (1 / 255.0f), law);
        const glm::vec3 rgb = glm::vec3(float(premultiplied.r), float(premultiplied.g), float(premultiplied.b)) *
                              (1.0f / float(premultiplied.a));
        for (std::size_t i = 2; i < polygon.size(); ++i) {
            SnappedTriangle t;
            const std::size_t from[3] = {0, i - 1, i};
            for (unsigned c = 0; c < 3; ++c) polygon.snap(from[c], to_, t, c);
            std::int64_t doubled_area = t.doubled_area();
            if (doubled_area == 0) continue;
            if (doubled_area < 0) {
                t.flip();
                doubled_area = -doubled_area;
            }
            const DepthPlane plane(t, doubled_area);
            scan_convert(t, to_, [&](int y, int begin, int end) {
                const float row = plane.row(y);
                buffers_.deposit_row<law>(
                    y, begin, end, [&](int x) { return plane.at(row, x); }, area, rgb);
            });
        }
    }

    /// A square of the footprint's area about the cell's center, each sample's share by overlap.
    template <AreaLaw law>
    void deposit(const Splat& splat) {
        const glm::vec3 p = to_.project(splat.center);
        if (!(p.z > to_.near_depth)) return;
        const float inverse = to_.inverse_w(p.z), q = to_.q(p.z, inverse);
        const float x = (p.x * inverse + to_.offset_x) * (1.0f / 256),
                    y = (p.y * inverse + to_.offset_y) * (1.0f / 256);
        // Seen under an angle, a squarely projected area is stretched: focal^2 distance / depth^3 (solid angle to
        // image).
        float samples_per_area = to_.focal * to_.focal;
        if (to_.is_perspective) {
            const glm::vec3 d = splat.center - to_.eye;
            samples_per_area *= std::sqrt(glm::dot(d, d)) * inverse * inverse * inverse;
        }
        const float footprint = splat.footprint * samples_per_area;
        const float half = 0.5f * std::sqrt(footprint);
        const float share = splat.area / splat.footprint;  // deposited where it covers a whole sample
        const glm::vec3 rgb = glm::vec3(float(splat.rgb.r), float(splat.rgb.g), float(splat.rgb.b)) * (1 / 255.0f);
        buffers_.deposit_square<law>(x - half, y - half, x + half, y + half, q, share, rgb);
    }

    ZBufferOptions options_;
    int side_ = 1;
    TriageFunction triage_;
    SampleProjection to_;
    SampleBuffers buffers_;
    DirectionalLight light_;
    glm::vec3 light_in_view_{0};
    std::vector<std::unique_ptr<TriangleStream>> streams_;
    Image image_;
};

}  // namespace farfield
