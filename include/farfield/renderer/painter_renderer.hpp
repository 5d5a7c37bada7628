// The painter's algorithm, a yardstick of N. Greene, "Hierarchical Polygon Tiling with Coverage Masks", SIGGRAPH 1996:
// section 9 compares with one that "maintained a color triplet for each point in the image raster and performed tiling
// by incremental scan conversion, overwriting the image at every pixel encountered".
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>

#include "farfield/geometry/light.hpp"
#include "farfield/geometry/rgba8.hpp"
#include "farfield/image.hpp"
#include "farfield/raster/light_in_view.hpp"
#include "farfield/raster/sample_count.hpp"
#include "farfield/raster/sample_projection.hpp"
#include "farfield/raster/samples/color_samples.hpp"
#include "farfield/raster/scan_conversion.hpp"
#include "farfield/raster/source_slots.hpp"
#include "farfield/raster/triangles/sample_rows.hpp"
#include "farfield/raster/triangles/triangle_painter.hpp"
#include "farfield/raster/triangles/triangle_runs.hpp"
#include "farfield/raster/triangles/triangle_stream.hpp"
#include "farfield/raster/triangles/triangle_triage.hpp"
#include "farfield/renderer.hpp"
#include "farfield/simd.hpp"

namespace farfield {

struct PainterOptions {
    int samples = 1;                          ///< a pixel, on a regular grid: 1, 4, 9, 16, 25, 36, 49 or 64
    Rgba8 background{0, 0, 0, 0};             ///< premultiplied
    std::optional<DirectionalLight> light{};  ///< in the outermost hierarchy's axes; none: colors as they are
    bool culls_back_faces = false;            ///< for closed surfaces that are counter-clockwise seen from outside
    Simd simd = Simd::automatic;              ///< all give the same picture
};

namespace detail {

/// Overwrites: anything that comes later lies in front.
class OverwritingFill {
  public:
    OverwritingFill(const SampleProjection& projection, ColorSamples& samples, const SampleRows& rows)
        : projection_(projection), samples_(samples), rows_(rows) {}

    static constexpr bool rejects(const SnappedTriangle&) { return false; }

    /// See DepthTestedFill.
    template <class Prepare, class Shade>
    void operator()(const SnappedTriangle& t, std::int64_t, Prepare&& prepare, const Shade& shade) const {
        bool prepared = false;
        scan_convert(t, projection_, [&](int y, int begin, int end) {
            if (!prepared) {
                prepared = true;
                prepare();
            }
            samples_.drawn(begin, y, end, y + 1);
            Rgba8* color = samples_.row(y);
            if constexpr (Shade::is_one_color) {
                std::fill(color + begin, color + end, shade(begin, y));
            } else {
                if (end - begin >= SampleRows::shortest && rows_.painted_colors != nullptr && shade.are_opaque() &&
                    rows_.painted_colors(color, begin, end, ColorsOfRow(*shade.plane, shade.corners, y))) {
                    return;
                }
                for (int x = begin; x < end; ++x) {
                    Rgba8 c = shade(x, y);
                    if (c.a == 0) continue;
                    c.a = 255;
                    color[x] = c;
                }
            }
        });
    }

  private:
    const SampleProjection& projection_;
    ColorSamples& samples_;
    const SampleRows& rows_;
};

}  // namespace detail

/// Draws the picture of ZBufferRenderer if no two primitives meet in a sample at the same depth and each lies behind
/// all later ones wherever they overlap. It keeps no depth, and nothing is hidden.
class PainterRenderer {
  public:
    static constexpr RendererFacts facts{.order = VisitOrder::back_to_front,
                                         .needs_ordering = OrderGuarantee::primitives,
                                         .keeps_sources = true,
                                         .shares_sources = true,
                                         .tells_lifetime = true,
                                         .tells_light = true};

    /// Throws std::invalid_argument for a number of samples that is not a square of 1 to 8.
    explicit PainterRenderer(const PainterOptions& options = {})
        : options_(options),
          side_(detail::checked_samples_a_side(options.samples, "PainterRenderer")),
          triage_(detail::triage_function<false>(options.simd)),
          rows_(options.simd),
          light_(options.light) {}

    const Image& image() const { return image_; }
    const std::optional<DirectionalLight>& light() const { return options_.light; }

    template <PrimitiveWithPolygons P>
    std::uint32_t upload(const Source<P>& source) {
        return streams_.upload(source);
    }
    std::uint32_t share(const PainterRenderer& other, std::uint32_t id) { return streams_.share(other.streams_, id); }
    void release(std::uint32_t id) { streams_.release(id); }
    /// The memory of all that is uploaded: once, however many viewers and renderers draw it.
    std::size_t uploaded_bytes() const { return streams_.bytes(); }
    std::weak_ptr<const void> lifetime() const { return streams_.lifetime(); }

    /// Throws std::invalid_argument for images of no samples or more than 16,000 on a side.
    void begin_frame(const LocalView& view) {
        detail::check_image_size(view, side_, "PainterRenderer");
        projection_ = detail::SampleProjection(view, side_);
        samples_.begin(projection_, side_, options_.background);
        light_.begin_frame(view);
    }
    void set_view(const LocalView& view) {
        projection_ = detail::SampleProjection(view, side_);
        light_.set_view(view);
    }
    void end_frame() { samples_.resolve(image_); }

    /// Draws in the order of the ranges and of the positions in them.
    template <class P>
    void draw(const Source<P>& source, std::span<const Range> ranges) {
        const detail::TriangleStream& stream = streams_[source.id];
        const detail::OverwritingFill fill(projection_, samples_, rows_);
        detail::TrianglePainter<detail::OverwritingFill> painter(stream, projection_, light_.light(),
                                                                 options_.culls_back_faces, fill);
        for (const Range& r : ranges) {
            detail::draw_triangles(stream, stream.first_triangle(r.first), stream.first_triangle(r.first + r.count),
                                   projection_, triage_, painter);
        }
    }

  private:
    PainterOptions options_;
    int side_;
    detail::TriageFunction triage_;
    detail::SampleRows rows_;
    detail::LightInView light_;
    detail::SampleProjection projection_;
    detail::ColorSamples samples_;
    detail::SourceSlots<detail::TriangleStream> streams_;
    Image image_;
};

}  // namespace farfield
