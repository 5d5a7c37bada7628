// Draws for a Viewer with OpenGL 4.5 core: a model of every part of the renderer contract, to be copied and changed.
//
//     farfield::opengl::HeadlessContext context;        // or a window's
//     farfield::opengl::GlRenderer renderer;
//     auto viewer = farfield::make_viewer(hierarchy, triangles, renderer);
//     viewer.frame(view);
//     renderer.present(0);                               // or image(), or texture()
//
// README.md says how it works, and what porters to other APIs need.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>

#include "farfield/geometry/light.hpp"
#include "farfield/image.hpp"
#include "farfield/renderer.hpp"
#include "opengl/triangles.hpp"

namespace farfield::opengl {

struct GlOptions {
    int samples = 1;                          ///< a pixel, on a regular grid: 1, 4, 9, 16, 25, 36, 49 or 64
    Rgba8 background{0, 0, 0, 0};             ///< premultiplied
    std::optional<DirectionalLight> light{};  ///< in the outermost hierarchy's axes; none: colors as they are
    bool culls_back_faces = false;            ///< for closed surfaces that are counter-clockwise seen from outside
    /// Triangles smaller than two samples cover a part of each, by their cell's area law, instead of all or nothing.
    /// This holds for ranges with a law only; an exact picture is always point sampled. Those of meshes are never
    /// deposited.
    bool deposits_small_triangles = true;
    /// Cells that were hidden some frames ago, by geometry, are not drawn: what comes into sight may be missing for so
    /// many. Without it nothing is hidden.
    bool asks_what_is_hidden = false;
    /// What stands in covers each sample in lanes x lanes parts, 1, 2 or 4 a side: things side by side in a lane go for
    /// things behind one another.
    int lanes = 2;
    /// Opacity tensors, and color cubes as small as splats, are on the GPU as they are stored, and shaped there.
    /// Without it the processor does so for each view, and what it has made is sent.
    bool shapes_stand_ins = true;
};

/// Counts of the last frame, images made in it included.
struct GlFrameStats {
    std::uint64_t draw_calls = 0;      ///< a draw of many ranges is one call
    std::uint64_t uploaded_bytes = 0;  ///< to the GPU: 0 where nothing changed
};

/// One context's, which must be current in every call and when it goes. Each frame sets all of the state that it needs,
/// and leaves framebuffers, programs, arrays, blending and depth test as they are in a new context.
class GlRenderer {
  public:
    static constexpr RendererFacts facts{.keeps_sources = true,
                                         .draws_changing_sources = true,
                                         .shares_sources = true,
                                         .tells_lifetime = true,
                                         .tells_light = true,
                                         .draws_faces = true,
                                         .draws_splats = true,
                                         .shapes_stand_ins = true,
                                         .answers_hidden = true,
                                         .deposits_primitives = true,
                                         .keeps_images = true,
                                         .slices_images = true};

    /// Throws std::runtime_error, one line, where the context is not OpenGL 4.5 core, and std::invalid_argument for a
    /// number of samples or lanes, or a light, that is none.
    explicit GlRenderer(const GlOptions& options = {});
    ~GlRenderer();
    GlRenderer(const GlRenderer&) = delete;
    GlRenderer& operator=(const GlRenderer&) = delete;

    /// The last frame's picture, premultiplied, coverage in alpha; the first call after a frame reads it back.
    const Image& image() const;
    /// The same where it was drawn: RGBA8, its first row topmost.
    GLuint texture() const;
    /// Copies it into a framebuffer of this size, 0 being the window's, upright.
    void present(GLuint framebuffer, int width, int height) const;
    const GlFrameStats& stats() const;

    const std::optional<DirectionalLight>& light() const;
    /// The memory of all that is uploaded.
    std::size_t uploaded_bytes() const;

    // What a Viewer calls: see farfield/renderer.hpp.

    template <PrimitiveWithPolygons P>
    std::uint32_t upload(const Source<P>& source) {
        return keep(std::make_shared<const TriangleSource>(upload_triangles(source)));
    }
    /// The other's context is this one, or shares objects with it.
    std::uint32_t share(const GlRenderer& other, std::uint32_t id);
    void release(std::uint32_t id);
    std::weak_ptr<const void> lifetime() const;

    /// Throws std::invalid_argument for images of no samples or more than 16,000 on a side.
    void begin_frame(const LocalView& view);
    void set_view(const LocalView& view);
    void end_frame();

    template <class P>
    void draw(const Source<P>& source, std::span<const Range> ranges) {
        if (!source.changes) return draw(source.id, ranges);
        for (const Range& r : ranges) {
            for (std::uint32_t at = r.first; at < r.first + r.count; ++at) {
                source.polygons(at, [&](const Polygon& polygon) { draw(polygon, r.law); });
            }
        }
    }
    void draw(std::span<const Face> faces);
    void draw(std::span<const Splat> splats);
    void draw(const PlacedStandIns& placed);
    bool shapes_stand_ins() const;
    void draw(std::span<const ImageQuad> quads);

    float largest_splat_px() const;
    bool deposits_primitives() const;
    bool hidden(const Cell& cell, CellId id);

    void begin_image(const LocalView& view, float quad_depth, int samples);
    void begin_image(const LocalView& view, std::span<const ImageSlice> slices, int samples);
    std::uint32_t end_image();
    void end_image(std::span<std::uint32_t> handles);
    void free_image(std::uint32_t image);
    std::size_t image_bytes(int width, int height) const;

  private:
    std::uint32_t keep(std::shared_ptr<const TriangleSource> source);
    void draw(std::uint32_t source, std::span<const Range> ranges);
    void draw(const Polygon& polygon, const std::optional<AreaLaw>& law);

    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace farfield::opengl
