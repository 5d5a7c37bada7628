// A renderer that never touches a hidden sample twice: hierarchical polygon tiling with coverage masks (Greene 1996).
// 64 samples a pixel cost about as much as one does elsewhere, and it tells any hierarchy which cells are hidden.
#pragma once

#include "farfield/settings.hpp"

#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>

#include "farfield/coverage/polygons/far_polygons.hpp"
#include "farfield/coverage/polygons/polygon_setup.hpp"
#include "farfield/coverage/polygons/polygon_stream.hpp"
#include "farfield/coverage/polygons/silhouette.hpp"
#include "farfield/coverage/polygons/surface.hpp"
#include "farfield/coverage/tiler/coverage_tiler.hpp"
#include "farfield/fail.hpp"
#include "farfield/geometry/light.hpp"
#include "farfield/geometry/rgba8.hpp"
#include "farfield/image.hpp"
#include "farfield/raster/light_in_view.hpp"
#include "farfield/raster/sample_projection.hpp"
#include "farfield/raster/source_slots.hpp"
#include "farfield/renderer.hpp"
#include "farfield/simd.hpp"

namespace farfield {

struct CoverageOptions {
    Rgba8 background{0, 0, 0, 0};             ///< premultiplied
    std::optional<DirectionalLight> light{};  ///< in the outermost hierarchy's axes; none: colors as they are
    bool culls_back_faces = false;            ///< for closed surfaces that are counter-clockwise seen from outside
    Simd simd = Simd::automatic;              ///< all give the same picture
    FarCoverage far_coverage = FarCoverage::samples;
};

/// Draws for a Viewer; the picture is image() after the frame. Colors that differ over a primitive are evaluated once a
/// pixel. Primitives with alpha below 255 cover that part of the samples, chosen as ZBufferRenderer does.
///
/// `strict` needs primitives front to back, from hierarchies that promise it: nothing is compared or written twice.
/// `lazy` takes any order and gives the samples of a z-buffer; nearly front to back it costs little more.
template <class Traits>
class BasicCoverageRenderer {
    static constexpr bool is_lazy = Traits::order == CoverageOrder::lazy;
    static constexpr int samples_a_side = Traits::samples::samples_a_side;

  public:
    static constexpr RendererFacts facts{
        .order = VisitOrder::front_to_back,
        .needs_ordering = is_lazy ? OrderGuarantee::none : OrderGuarantee::primitives,
        .keeps_sources = true,
        .draws_changing_sources = true,
        .shares_sources = true,
        .tells_lifetime = true,
        .tells_light = true,
        .draws_faces = is_lazy,
        .draws_splats = is_lazy,
        .draws_polygons = true,
        .answers_hidden = true,
    };

    /// A tile is a part of the whole picture only this far from its borders: pixels get samples from their neighbors.
    static constexpr int reach_px = Traits::samples::reach_px;

    explicit BasicCoverageRenderer(const CoverageOptions& options = {})
        : options_(options), light_(options.light), tiler_(options.simd) {}

    const Image& image() const { return image_; }
    const std::optional<DirectionalLight>& light() const { return options_.light; }
    /// The work of the last frame.
    const typename Traits::work& work() const { return target_.work; }
    /// The size of the coverage pyramid: 1 2/63 bits a sample where the image's sides are powers of 8.
    std::size_t pyramid_bytes() const { return target_.pyramid.bytes(); }

    template <PrimitiveWithPolygons P>
    std::uint32_t upload(const Source<P>& source) {
        return streams_.upload(source);
    }
    std::uint32_t share(const BasicCoverageRenderer& other, std::uint32_t id) {
        return streams_.share(other.streams_, id);
    }
    void release(std::uint32_t id) { streams_.release(id); }
    /// The memory of all that is uploaded: once, however many viewers and renderers draw it.
    std::size_t uploaded_bytes() const { return streams_.bytes(); }
    std::weak_ptr<const void> lifetime() const { return streams_.lifetime(); }

    /// Throws std::invalid_argument for images of no samples or more than 31,000 on a side.
    void begin_frame(const LocalView& view) {
        constexpr int limit = 31000 / samples_a_side;
        if (view.width < 1 || view.height < 1 || view.width > limit || view.height > limit) {
            detail::fail<std::invalid_argument>("farfield::CoverageRenderer: an image must have 1 to " +
                                                std::to_string(limit) + " pixels on a side");
        }
        projection_ = detail::SampleProjection(view, samples_a_side);
        target_.begin(view.width, view.height, projection_.first_x, projection_.first_y);
        target_.left_px = view.part.left;
        target_.top_px = view.part.top;
        light_.begin_frame(view);
    }
    void set_view(const LocalView& view) {
        projection_ = detail::SampleProjection(view, samples_a_side);
        light_.set_view(view);
    }
    /// "We composite a screen-sized polygon of the desired background color, thereby tiling all remaining vacant
    /// pixels" (section 4.5).
    void end_frame() {
        polygon_.surface = {};
        polygon_.set_rectangle(256 * projection_.first_x, 256 * projection_.first_y, 256 * projection_.end_x,
                               256 * projection_.end_y, -std::numeric_limits<float>::infinity());
        polygon_.surface.kind = SurfaceKind::background;
        polygon_.surface.colors.fill(options_.background);
        auto work = std::move(target_.work);
        target_.work.begin(target_.pyramid);
        tiler_.tile(target_, polygon_);
        target_.work = std::move(work);
        target_.resolve(image_);
    }

    template <class P>
    void draw(const Source<P>& source, std::span<const Range> ranges) {
        if (source.changes) {
            scratch_.clear();
            for (const Range& r : ranges) {
                for (std::uint32_t at = r.first; at < r.first + r.count; ++at) {
                    source.polygons(at, [&](const Polygon& polygon) { scratch_.add(polygon); });
                }
            }
            return draw_scratch();
        }
        const detail::PolygonStream& stream = streams_[source.id];
        auto setup = setup_of(stream);
        for (std::size_t i = 0; i < ranges.size(); ++i) {
            if (i + 8 < ranges.size()) stream.prefetch(ranges[i + 8].first, true);
            if (i + 4 < ranges.size()) stream.prefetch(ranges[i + 4].first, false);
            setup.draw(ranges[i].first, ranges[i].first + ranges[i].count);
        }
    }

    void draw(std::span<const Polygon> polygons) {
        scratch_.clear();
        for (const Polygon& polygon : polygons) scratch_.add(polygon);
        draw_scratch();
    }

    void draw(std::span<const Face> faces) requires(is_lazy) {
        auto polygons = far_polygons();
        for (const Face& face : faces) polygons.add(face);
    }
    void draw(std::span<const Splat> splats) requires(is_lazy) {
        auto polygons = far_polygons();
        for (const Splat& splat : splats) polygons.add(splat);
    }
    /// In a pixel or two no more shape shows than an upright rectangle's.
    float largest_splat_px() const { return 2.0f; }

    /// Whether a cell is hidden by what was drawn before; ask front to back. No box that crosses the near plane is.
    bool hidden(const Cell& cell, CellId) {
        if (!silhouette_.project(cell.bounds_center, cell.bounds_half, projection_)) return false;
        return !tiler_.is_seen(target_, silhouette_, int(256 * projection_.reach));
    }

  private:
    using Target = detail::CoverageTarget<Traits>;

    /// Passes polygons to the tiler.
    struct Tile {
        static constexpr bool needs_depth = is_lazy;
        static constexpr int reach_of_samples = Target::reach_of_samples;
        const detail::CoverageTiler<Target>& tiler;
        Target& target;

        void operator()(detail::TilePolygon& polygon) const { tiler.tile(target, polygon); }
    };

    detail::PolygonSetup<Tile> setup_of(const detail::PolygonStream& stream) {
        return {stream, projection_, light_.light(), options_.culls_back_faces, polygon_, Tile{tiler_, target_}};
    }
    detail::FarPolygons<Tile> far_polygons() {
        const auto coverage = Target::samples_type::takes_deposits ? options_.far_coverage : FarCoverage::samples;
        return {projection_, coverage, polygon_, Tile{tiler_, target_}};
    }

    CoverageOptions options_;
    detail::LightInView light_;
    detail::CoverageTiler<Target> tiler_;
    Target target_;
    detail::SampleProjection projection_;
    detail::TilePolygon polygon_;  ///< the one at work
    detail::Silhouette silhouette_;
    void draw_scratch() {
        auto setup = setup_of(scratch_);
        for (std::uint32_t at = 0; at < scratch_.size(); ++at) setup.draw(scratch_[at]);
    }

    detail::SourceSlots<detail::PolygonStream> streams_;
    detail::PolygonStream scratch_;  ///< polygons made for this frame
    Image image_;
};

/// Takes any hierarchy, in any order.
using CoverageRenderer = BasicCoverageRenderer<LazyCoverage>;
/// Takes hierarchies that keep strict order: SpatialHierarchy<PolygonBsp, Exact, ...> and the like.
using StrictCoverageRenderer = BasicCoverageRenderer<StrictCoverage>;

/// This is strict for hierarchies that promise strict order and lazy for others.
template <class H>
using CoverageRendererFor =
    std::conditional_t<H::ordering == OrderGuarantee::primitives, StrictCoverageRenderer, CoverageRenderer>;

}  // namespace farfield
