// "If a hardware graphics accelerator is available to perform shading operations such as texture mapping, we can
// perform visibility operations with software and shading with hardware. We would use the usual hierarchical tiling
// algorithm to maintain the coverage pyramid and perform object-space culling, and we would render visible polygons
// with the graphics accelerator" (Greene 1996, section 5.2).
//
//     farfield::opengl::CulledByCoverage renderer(shading);   // a GlRenderer, or any other
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <unordered_map>
#include <utility>

#include "farfield/geometry/light.hpp"
#include "farfield/renderer.hpp"
#include "farfield/renderer/coverage_renderer.hpp"

namespace farfield::opengl {

/// Draws by `Shading`, which is borrowed and whose picture it is, and asks coverage masks of 64 samples a pixel, on the
/// processor, what is hidden: the answer is there at once, where OpenGL's own comes frames later. Geometry is tiled by
/// both and hides; what stands in is drawn by Shading alone, and hides nothing. It pays where much is hidden and
/// shading is dear, and costs the time of a CoverageRenderer.
template <class Shading, class Visibility = CoverageRenderer>
requires(Shading::facts.keeps_sources&& Shading::facts.draws_faces&& Shading::facts.draws_splats&& Shading::facts
             .tells_light) class CulledByCoverage {
  public:
    static constexpr RendererFacts facts{.order = VisitOrder::front_to_back,
                                         .needs_ordering = Visibility::facts.needs_ordering,
                                         .keeps_sources = true,
                                         .draws_changing_sources = Shading::facts.draws_changing_sources,
                                         .tells_lifetime = true,
                                         .tells_light = true,
                                         .draws_faces = true,
                                         .draws_splats = true,
                                         .answers_hidden = true};

    explicit CulledByCoverage(Shading& shading, const CoverageOptions& options = {})
        : shading_(shading), visibility_(options) {}

    const std::optional<DirectionalLight>& light() const { return shading_.light(); }
    std::weak_ptr<const void> lifetime() const { return lifetime_; }

    template <PrimitiveWithPolygons P>
    std::uint32_t upload(const Source<P>& source) {
        const Both both{shading_.upload(source), visibility_.upload(source)};
        sources_.emplace(++last_source_, both);
        return last_source_;
    }
    void release(std::uint32_t id) {
        const auto both = sources_.find(id);
        shading_.release(both->second.shading);
        visibility_.release(both->second.visibility);
        sources_.erase(both);
    }

    void begin_frame(const LocalView& view) {
        shading_.begin_frame(view);
        visibility_.begin_frame(view);
    }
    void set_view(const LocalView& view) {
        shading_.set_view(view);
        visibility_.set_view(view);
    }
    void end_frame() { shading_.end_frame(); }  // nobody wants the other's picture

    template <class P>
    void draw(const Source<P>& source, std::span<const Range> ranges) {
        const Both both = sources_.at(source.id);
        Source<P> theirs = source;
        theirs.id = both.shading;
        shading_.draw(theirs, ranges);
        theirs.id = both.visibility;
        visibility_.draw(theirs, ranges);
    }
    void draw(std::span<const Face> faces) { shading_.draw(faces); }
    void draw(std::span<const Splat> splats) { shading_.draw(splats); }
    float largest_splat_px() const { return shading_.largest_splat_px(); }

    bool hidden(const Cell& cell, CellId id) { return visibility_.hidden(cell, id); }

  private:
    struct Both {
        std::uint32_t shading, visibility;
    };

    Shading& shading_;
    Visibility visibility_;
    std::unordered_map<std::uint32_t, Both> sources_;
    std::uint32_t last_source_ = 0;
    std::shared_ptr<const int> lifetime_ = std::make_shared<const int>(0);
};

}  // namespace farfield::opengl
