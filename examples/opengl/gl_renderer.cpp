#include "opengl/gl_renderer.hpp"

#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "opengl/context.hpp"
#include "opengl/painter.hpp"

namespace farfield::opengl {
namespace {

int side_of(int samples) {
    int side = 1;
    while (side < 8 && side * side < samples) ++side;
    if (side * side != samples) {
        throw std::invalid_argument("GlRenderer: samples must be 1, 4, 9, 16, 25, 36, 49 or 64, not " +
                                    std::to_string(samples));
    }
    return side;
}

void check_size(const LocalView& view, int side) {
    constexpr int most = 16000;
    if (view.width < 1 || view.height < 1 || view.width > most / side || view.height > most / side)
        throw std::invalid_argument("GlRenderer: an image must have 1 to 16000 samples on a side");
}

/// Where a depth from the eye lies in the depth buffer.
float buffer_depth(const LocalView& view, float depth) {
    const float from_anchor = depth - view.anchor_depth;
    const ViewRow row = view_row(view, nullptr);
    const float w = view.is_perspective ? depth : 1.0f;
    if (!(w > 0)) return std::numeric_limits<float>::infinity();
    if (!std::isfinite(depth)) return -std::numeric_limits<float>::infinity();
    return (row.depths.x + row.depths.y * from_anchor) / w;
}

/// The picture's first sample, relative to the whole's middle: what is decided by a hash is the same in all tiles.
glm::ivec2 first_sample(const LocalView& view, int side) {
    const glm::dvec2 whole(view.part.whole_width * side, view.part.whole_height * side);
    const glm::dvec2 shift = view.whole_off_center * glm::dvec2(1, -1) * whole * 0.5;
    return glm::ivec2(glm::round(shift)) - glm::ivec2(whole) / 2 + glm::ivec2(view.part.left, view.part.top) * side;
}

PaintOptions paint_options(const LocalView& view, int side) {
    PaintOptions o;
    o.width = view.width;
    o.height = view.height;
    o.side = side;
    o.depth = depth_rule(view);
    o.is_mirrored = view.is_mirrored;
    o.first_sample = first_sample(view, side);
    o.beside = glm::ivec2(view.part.left, view.part.top) * side;
    return o;
}

}  // namespace

struct GlRenderer::State {
    explicit State(const GlOptions& o) : options(o), side(side_of(o.samples)) {
        if (o.lanes != 1 && o.lanes != 2 && o.lanes != 4)
            throw std::invalid_argument("GlRenderer: lanes must be 1, 2 or 4, not " + std::to_string(o.lanes));
        if (const char* why = o.light ? wrong_light(*o.light) : nullptr) throw std::invalid_argument(why);
    }

    GlOptions options;
    int side;
    Painter painter;
    Painter::Sources sources;
    std::shared_ptr<const char> alive = std::make_shared<const char>('\0');

    Picture frame{/*makes_rows=*/true}, image{/*makes_rows=*/false};
    Picture* now = &frame;
    Target frame_target, image_target;
    Texture resolved;
    Framebuffer resolved_framebuffer;
    int resolved_width = 0, resolved_height = 0, width = 0, height = 0;
    std::optional<LocalView> frame_view, image_view, local_view;
    int image_side = 1;
    std::vector<ImageSlice> slices;
    KeptImages images;

    glm::vec3 light_in_view{0};
    DirectionalLight local_light;
    GlFrameStats stats;
    mutable Image read;
    mutable bool is_read = true;

    const DirectionalLight* light_of(const LocalView& view) {
        if (!options.light) return nullptr;
        local_light = *options.light;
        local_light.towards = view.right * light_in_view.x + view.up * light_in_view.y + view.forward * light_in_view.z;
        return &local_light;
    }
    void set_view(const LocalView& view) {
        local_view = view;
        now->set_view(view, light_of(view));
    }
};

GlRenderer::GlRenderer(const GlOptions& options) : state_((require_opengl(), std::make_unique<State>(options))) {}
GlRenderer::~GlRenderer() = default;

const std::optional<DirectionalLight>& GlRenderer::light() const {
    return state_->options.light;
}
const GlFrameStats& GlRenderer::stats() const {
    return state_->stats;
}
std::weak_ptr<const void> GlRenderer::lifetime() const {
    return state_->alive;
}
float GlRenderer::largest_splat_px() const {
    return 2.0f / float(state_->side);
}
bool GlRenderer::deposits_primitives() const {
    return state_->options.deposits_small_triangles;
}
bool GlRenderer::hidden(const Cell& cell, CellId id) {
    State& s = *state_;
    if (!s.options.asks_what_is_hidden || s.now != &s.frame) return false;
    return s.painter.occlusion.hidden(cell, id, *s.local_view, [&] { return s.frame.view(); });
}

std::uint32_t GlRenderer::keep(std::shared_ptr<const TriangleSource> source) {
    auto& sources = state_->sources;
    std::size_t slot = 0;
    while (slot < sources.size() && sources[slot]) ++slot;
    if (slot == sources.size()) sources.emplace_back();
    sources[slot] = std::move(source);
    return std::uint32_t(slot);
}
std::uint32_t GlRenderer::share(const GlRenderer& other, std::uint32_t id) {
    return keep(other.state_->sources[id]);
}
void GlRenderer::release(std::uint32_t id) {
    state_->sources[id].reset();
}
std::size_t GlRenderer::uploaded_bytes() const {
    std::size_t sum = 0;
    for (const auto& source : state_->sources) sum += source ? source->bytes() : 0;
    return sum;
}

void GlRenderer::begin_frame(const LocalView& view) {
    State& s = *state_;
    check_size(view, s.side);
    s.now = &s.frame;  // an exception may have ended the last frame in an image
    s.frame_view = view;
    s.painter.stats = {};
    if (s.options.asks_what_is_hidden) s.painter.occlusion.begin_frame();
    if (s.options.light) {
        const glm::vec3 l = s.options.light->towards;
        s.light_in_view = {glm::dot(l, view.right), glm::dot(l, view.up), glm::dot(l, view.forward)};
    }
    s.frame.begin(view, s.light_of(view));
    s.set_view(view);
}
void GlRenderer::set_view(const LocalView& view) {
    state_->set_view(view);
}

void GlRenderer::end_frame() {
    State& s = *state_;
    const LocalView& view = *s.frame_view;
    s.width = view.width;
    s.height = view.height;
    if (s.width != s.resolved_width || s.height != s.resolved_height) {
        s.resolved = make_texture(GL_RGBA8, s.width, s.height);
        s.resolved_framebuffer = make_framebuffer();
        glNamedFramebufferTexture(s.resolved_framebuffer.name(), GL_COLOR_ATTACHMENT0, s.resolved.name(), 0);
        Target::check(s.resolved_framebuffer);
        s.resolved_width = s.width;
        s.resolved_height = s.height;
    }
    s.frame.end();
    PaintOptions options = paint_options(view, s.side);
    options.lanes = s.options.lanes;
    options.background = to_vec4(s.options.background);
    options.light = s.options.light;
    options.culls_back_faces = s.options.culls_back_faces;
    s.painter.paint(s.frame, s.sources, s.images, s.frame_target, s.resolved_framebuffer.name(), options);
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, 0);
    s.stats = {s.painter.stats.draw_calls, s.painter.stats.uploaded_bytes};
    s.is_read = false;
}

GLuint GlRenderer::texture() const {
    return state_->resolved.name();
}

const Image& GlRenderer::image() const {
    const State& s = *state_;
    if (!std::exchange(s.is_read, true)) {
        if (s.read.width() != s.width || s.read.height() != s.height) s.read = Image(s.width, s.height);
        glPixelStorei(GL_PACK_ALIGNMENT, 4);
        glGetTextureImage(s.resolved.name(), 0, GL_RGBA, GL_UNSIGNED_BYTE, GLsizei(s.read.pixels().size_bytes()),
                          s.read.pixels().data());
    }
    return s.read;
}

void GlRenderer::present(GLuint framebuffer, int width, int height) const {
    const State& s = *state_;
    glBlitNamedFramebuffer(s.resolved_framebuffer.name(), framebuffer, 0, 0, s.width, s.height, 0, height, width, 0,
                           GL_COLOR_BUFFER_BIT, GL_NEAREST);
}

void GlRenderer::draw(std::uint32_t source, std::span<const Range> ranges) {
    const TriangleSource& triangles = *state_->sources[source];
    for (const Range& r : ranges) {
        state_->now->add_run(source, cell_law(r.law), triangles.origin, triangles.first_of(r.first),
                             triangles.first_of(r.first + r.count));
    }
}
void GlRenderer::draw(const Polygon& polygon, const std::optional<AreaLaw>& law) {
    for_triangles_of(polygon, [&](const TriangleVertices& t) { state_->now->add(t, cell_law(law)); });
}
void GlRenderer::draw(std::span<const Face> faces) {
    for (const Face& face : faces) state_->now->add(face);
}
void GlRenderer::draw(std::span<const Splat> splats) {
    for (const Splat& splat : splats) state_->now->add(splat);
}
void GlRenderer::draw(const PlacedStandIns& placed) {
    state_->now->add(placed);
}
bool GlRenderer::shapes_stand_ins() const {
    return state_->options.shapes_stand_ins;
}
void GlRenderer::draw(std::span<const ImageQuad> quads) {
    for (const ImageQuad& quad : quads) state_->now->add(quad);
}

void GlRenderer::begin_image(const LocalView& view, float quad_depth, int samples) {
    const ImageSlice all{.depth = quad_depth};
    begin_image(view, {&all, 1}, samples);
}
void GlRenderer::begin_image(const LocalView& view, std::span<const ImageSlice> slices, int samples) {
    State& s = *state_;
    s.image_side = side_of(samples);
    check_size(view, s.image_side);
    s.image_view = view;
    s.slices.assign(slices.begin(), slices.end());
    s.now = &s.image;
    s.image.begin(view, s.light_of(view));
    s.set_view(view);
}
std::uint32_t GlRenderer::end_image() {
    std::uint32_t handle = 0;
    end_image({&handle, 1});
    return handle;
}
void GlRenderer::end_image(std::span<std::uint32_t> handles) {
    State& s = *state_;
    s.now = &s.frame;
    s.image.end();
    const LocalView& view = *s.image_view;
    bool is_solid = s.image_side == 1 && s.image.far.chunks.empty() && !s.image.has_laws();
    for (const PlacedImage& placed : s.image.images) is_solid = is_solid && s.images[placed.quad.image].is_solid;
    for (std::size_t i = 0; i < handles.size(); ++i) {
        const ImageSlice& slice = s.slices[i];
        handles[i] = s.images.make(view.width, view.height, is_solid);
        PaintOptions options = paint_options(view, s.image_side);
        options.lanes = s.options.lanes;
        options.light = s.options.light;
        options.culls_back_faces = s.options.culls_back_faces;
        options.quad_depth = buffer_depth(view, slice.depth);
        constexpr float all = std::numeric_limits<float>::infinity();
        if (slice.nearest != -all || slice.farthest != all) {
            options.slice = glm::vec2(buffer_depth(view, slice.farthest), buffer_depth(view, slice.nearest));
        }
        s.painter.paint(s.image, s.sources, s.images, s.image_target, s.images[handles[i]].framebuffer.name(), options);
    }
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, 0);
}
void GlRenderer::free_image(std::uint32_t image) {
    state_->images.free(image);
}
std::size_t GlRenderer::image_bytes(int width, int height) const {
    return KeptImages::bytes(width, height);
}

}  // namespace farfield::opengl
