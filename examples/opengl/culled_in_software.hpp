// Software says what is hidden, and hardware shades: "If a hardware graphics accelerator is available to perform
// shading operations such as texture mapping, we can perform visibility operations with software and shading with
// hardware. We would use the usual hierarchical tiling algorithm to maintain the coverage pyramid and perform
// object-space culling, and we would render visible polygons with the graphics accelerator" (Greene 1996, section 5.2).
//
//     farfield::opengl::CulledInSoftware renderer(shading, ZBufferOptions{.samples = 4});   // by deposits, too
//     farfield::opengl::CulledByCoverage renderer(shading);                                 // by coverage masks
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <type_traits>
#include <unordered_map>
#include <vector>

#include "farfield/approximation/color_cube.hpp"
#include "farfield/approximation/opacity_tensor.hpp"
#include "farfield/geometry/light.hpp"
#include "farfield/image.hpp"
#include "farfield/renderer.hpp"
#include "farfield/renderer/coverage_renderer.hpp"
#include "farfield/renderer/z_buffer_renderer.hpp"

namespace farfield::opengl {

namespace detail {

/// What both draw: geometry by `Shading`, what stands in by it too, and images by it alone.
template <class Shading, class Visibility>
constexpr RendererFacts facts_culled_by() {
    RendererFacts f = Shading::facts;
    f.order = Visibility::facts.order == VisitOrder::any ? f.order : Visibility::facts.order;
    if (f.needs_ordering < Visibility::facts.needs_ordering) f.needs_ordering = Visibility::facts.needs_ordering;
    f.keeps_sources = true;
    f.draws_changing_sources =
        farfield::detail::DrawsChangingSources<Shading> && farfield::detail::DrawsChangingSources<Visibility>;
    f.shares_sources = Shading::facts.shares_sources && Visibility::facts.shares_sources;
    f.tells_lifetime = true;
    f.draws_polygons = false;
    f.answers_hidden = true;
    return f;
}

}  // namespace detail

struct CulledStats {
    std::uint64_t stand_ins = 0;  ///< that came: those of cells that are hidden do not
    std::uint64_t seen = 0;       ///< of them, by Shading then
};

/// Draws by `Shading`, which is borrowed and whose picture it is, and asks `Visibility`, on the processor, what is
/// hidden: the answer is there at once, where OpenGL's own comes frames later. All that is drawn is drawn by both, but
/// for images. The z-buffer closes samples by deposits as well, which nothing tells OpenGL of: where cells stand in
/// behind one another most of them are hidden by those in front. It needs the number of samples that Shading has, and
/// takes a part of the time that it takes to draw alone; nothing where all is drawn exactly, for it then hides nothing.
/// Coverage masks of 64 samples a pixel pay where much is hidden by geometry and shading is dear.
///
/// Sources are kept by both: 40 bytes a triangle in memory.
template <class Shading, class Visibility = ZBufferRenderer>
requires(Shading::facts.keeps_sources&& Visibility::facts.answers_hidden) class CulledInSoftware {
  public:
    static constexpr RendererFacts facts = detail::facts_culled_by<Shading, Visibility>();

    template <class Options>
    CulledInSoftware(Shading& shading, const Options& options) : shading_(shading), visibility_(options) {}
    explicit CulledInSoftware(Shading& shading) : shading_(shading) {}

    const Image& image() const requires(requires(const Shading& s) { s.image(); }) { return shading_.image(); }
    auto texture() const requires(requires(const Shading& s) { s.texture(); }) { return shading_.texture(); }
    const auto& light() const requires(Shading::facts.tells_light) { return shading_.light(); }
    std::weak_ptr<const void> lifetime() const { return lifetime_; }
    /// Of the last frame.
    const CulledStats& stats() const { return stats_; }

    template <PrimitiveWithPolygons P>
    std::uint32_t upload(const Source<P>& source) {
        return keep({shading_.upload(source), visibility_.upload(source)});
    }
    std::uint32_t share(const CulledInSoftware& other, std::uint32_t id) requires(facts.shares_sources) {
        const Both& both = other.sources_.at(id);
        return keep(
            {shading_.share(other.shading_, both.shading), visibility_.share(other.visibility_, both.visibility)});
    }
    void release(std::uint32_t id) {
        const auto both = sources_.find(id);
        shading_.release(both->second.shading);
        visibility_.release(both->second.visibility);
        sources_.erase(both);
    }

    void begin_frame(const LocalView& view) {
        makes_image_ = false;  // an exception may have ended the last frame in an image
        looks_ = !hides_by_deposits || view.tolerance_px > 0;
        stats_ = {};
        shading_.begin_frame(view);
        if (looks_) visibility_.begin_frame(view);
    }
    void set_view(const LocalView& view) {
        shading_.set_view(view);
        view_ = view;
        if (is_looking()) visibility_.set_view(view);
    }
    void end_frame() { shading_.end_frame(); }  // nobody wants the other's picture

    template <class P>
    void draw(const Source<P>& source, std::span<const Range> ranges) {
        const Both both = sources_.at(source.id);
        Source<P> theirs = source;
        theirs.id = both.shading;
        shading_.draw(theirs, ranges);
        if (!is_looking()) return;
        theirs.id = both.visibility;
        visibility_.draw(theirs, ranges);
    }
    void draw(std::span<const Face> faces) requires(Shading::facts.draws_faces) { draw_seen(faces, faces_seen_); }
    void draw(std::span<const Splat> splats) requires(Shading::facts.draws_splats) { draw_seen(splats, splats_seen_); }
    /// Who is hidden is asked of the splats that they are from here.
    void draw(const PlacedStandIns& placed) requires(Shading::facts.shapes_stand_ins) {
        stats_.stand_ins += placed.count;
        PlacedStandIns seen = placed;
        if constexpr (hides_by_deposits) {
            if (is_looking()) seen = seen_of(placed);
        }
        stats_.seen += seen.count;
        if (seen.count != 0) shading_.draw(seen);
    }
    bool shapes_stand_ins() const requires(Shading::facts.shapes_stand_ins) { return shading_.shapes_stand_ins(); }
    float largest_splat_px() const requires(Shading::facts.draws_splats) { return shading_.largest_splat_px(); }
    bool deposits_primitives() const requires(Shading::facts.deposits_primitives) {
        return shading_.deposits_primitives();
    }

    bool hidden(const Cell& cell, CellId id) {
        if (is_looking()) {
            if constexpr (hides_by_deposits) {
                if (visibility_.hidden_in_samples(cell)) return true;
            } else if (visibility_.hidden(cell, id)) {
                return true;
            }
        }
        if constexpr (Shading::facts.answers_hidden) return shading_.hidden(cell, id);
        return false;
    }

    // Images are made and drawn by Shading alone, and hide nothing.

    void begin_image(const LocalView& view, float quad_depth, int samples) requires(Shading::facts.keeps_images) {
        makes_image_ = true;
        shading_.begin_image(view, quad_depth, samples);
    }
    void begin_image(const LocalView& view, std::span<const ImageSlice> slices, int samples)  //
        requires(Shading::facts.slices_images) {
        makes_image_ = true;
        shading_.begin_image(view, slices, samples);
    }
    std::uint32_t end_image() requires(Shading::facts.keeps_images) {
        makes_image_ = false;
        return shading_.end_image();
    }
    void end_image(std::span<std::uint32_t> handles) requires(Shading::facts.slices_images) {
        makes_image_ = false;
        shading_.end_image(handles);
    }
    void free_image(std::uint32_t image) requires(Shading::facts.keeps_images) { shading_.free_image(image); }
    std::size_t image_bytes(int width, int height) const requires(Shading::facts.keeps_images) {
        return shading_.image_bytes(width, height);
    }
    void draw(std::span<const ImageQuad> quads) requires(Shading::facts.keeps_images) { shading_.draw(quads); }

  private:
    static constexpr bool hides_by_deposits = std::is_same_v<Visibility, ZBufferRenderer>;

    struct Both {
        std::uint32_t shading, visibility;
    };
    std::uint32_t keep(Both both) {
        sources_.emplace(++last_source_, both);
        return last_source_;
    }
    bool is_looking() const { return looks_ && !makes_image_; }

    bool is_hidden(const Splat& splat) requires(hides_by_deposits) { return visibility_.hidden_in_samples(splat); }
    bool is_hidden(const Face& face) requires(hides_by_deposits) {
        Cell around;
        around.bounds_center = 0.5f * (face.lower + face.upper);
        around.bounds_half = 0.5f * (face.upper - face.lower);
        return visibility_.hidden_in_samples(around);
    }
    /// Cells are culled by what was drawn before them; of a batch each is culled by those before it, for deposits have
    /// no faster way to tell.
    template <class Drawable>
    void draw_seen(std::span<const Drawable> drawables, std::vector<Drawable>& seen) {
        stats_.stand_ins += drawables.size();
        if (!is_looking()) {
            stats_.seen += drawables.size();
            return shading_.draw(drawables);
        }
        if constexpr (hides_by_deposits) {
            seen.clear();
            for (const Drawable& one : drawables) {
                if (is_hidden(one)) continue;
                visibility_.draw(std::span(&one, 1));
                seen.push_back(one);
            }
            drawables = seen;
        } else if constexpr (requires { visibility_.draw(drawables); }) {
            visibility_.draw(drawables);
        }
        stats_.seen += drawables.size();
        if (!drawables.empty()) shading_.draw(drawables);
    }

    PlacedStandIns seen_of(const PlacedStandIns& placed) requires(hides_by_deposits) {
        constexpr std::size_t stride = PlacedStandIns::stride;
        words_seen_.resize(stride * placed.word_count());
        PlacedStandIns seen = placed;
        seen.words = words_seen_.data();
        seen.count = 0;
        const auto look = [&](const Splat& splat, std::size_t i) {
            if (is_hidden(splat)) return;
            visibility_.draw(std::span(&splat, 1));
            for (std::size_t w = 0; w < placed.word_count(); ++w)
                words_seen_[w * stride + seen.count] = placed.words[w * stride + i];
            ++seen.count;
        };
        if (placed.kind == PlacedStandIns::Kind::cubes) {
            ColorCube{}.draw_placed(placed.words, placed.count, *view_, look);
        } else {
            OpacityTensor tensor{.closed_surfaces = placed.closed_surfaces, .counts_overlap = placed.counts_overlap};
            tensor.sheet_gain = tensor.closed_sheet_gain = placed.sheet_gain;
            tensor.draw_placed(placed.words, placed.count, *view_, look);
        }
        return seen;
    }

    Shading& shading_;
    Visibility visibility_;
    std::optional<LocalView> view_;
    std::unordered_map<std::uint32_t, Both> sources_;
    std::uint32_t last_source_ = 0;
    bool looks_ = true;  ///< in this frame
    bool makes_image_ = false;
    CulledStats stats_;
    std::vector<Face> faces_seen_;  ///< of a batch
    std::vector<Splat> splats_seen_;
    std::vector<std::uint32_t> words_seen_;
    std::shared_ptr<const int> lifetime_ = std::make_shared<const int>(0);
};

/// By geometry alone, seen by coverage masks.
template <class Shading>
class CulledByCoverage : public CulledInSoftware<Shading, CoverageRenderer> {
  public:
    explicit CulledByCoverage(Shading& shading, const CoverageOptions& options = {})
        : CulledInSoftware<Shading, CoverageRenderer>(shading, options) {}
};

}  // namespace farfield::opengl
