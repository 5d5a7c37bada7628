#include <array>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

#include "farfield/approximation/opacity_tensor.hpp"
#include "farfield/build.hpp"
#include "farfield/cost_model/triangle_count.hpp"
#include "farfield/partition/octree.hpp"
#include "farfield/primitive/triangle.hpp"
#include "farfield/renderer/z_buffer_renderer.hpp"
#include "farfield/viewer.hpp"
#include "opengl/setting.hpp"
#include "support/views.hpp"

using namespace farfield;
using namespace farfield::test;
using opengl::GlOptions;
using opengl::GlRenderer;

static_assert(Renderer<GlRenderer, Triangle>);

namespace {

std::vector<Triangle> strewn(std::size_t count, float size, unsigned seed, bool translucent = false) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<float> in(-1, 1);
    const auto point = [&] { return glm::vec3(in(random), in(random), in(random)); };
    std::vector<Triangle> out(count);
    for (Triangle& t : out) {
        const glm::vec3 p = point();
        t.vertices = {p, p + size * point(), p + size * point()};
        const auto byte = [&] { return std::uint8_t(random() >> 8); };
        t.rgba = {byte(), byte(), byte(), translucent ? byte() : std::uint8_t(255)};
    }
    return out;
}

template <class R>
const Image& plain(R& renderer, const std::vector<Triangle>& triangles, const View& view) {
    Box box = Box::empty();
    for (const Triangle& t : triangles) {
        for (const glm::vec3 v : t.vertices) box.add(v);
    }
    Source<Triangle> source{triangles, {}, std::uint32_t(triangles.size())};
    source.id = renderer.upload(source);
    const Range all{0, source.item_count};
    const Image& image =
        picture_of(renderer, LocalView(view, {}, box), [&](R& r) { r.draw(source, std::span(&all, 1)); });
    renderer.release(source.id);
    return image;
}

using Hierarchy = SpatialHierarchy<Octree, OpacityTensor, TriangleCount>;

}  // namespace

TEST_CASE("OpenGL draws triangles as the z-buffer does", "[opengl]") {
    OpenGl gl;
    if (!gl) return;
    const auto triangles = strewn(300, 0.5f, 1);
    View perspective = looking({1.5, 1, 3}, {}, 64), inside = looking({0.1, 0.2, 0.3}, {1, 0, 0}, 64);
    View odd = perspective, shifted = perspective, cut = perspective, mirrored = perspective;
    odd.width = 77, odd.height = 33;
    shifted.camera.off_center = {0.4, -0.7};
    cut.camera.near_depth = 3, cut.camera.far_depth = 4;
    mirrored.camera.right = -mirrored.camera.right;
    const View far_away = looking({2e4, 1e4, 3e4}, {}, 64);
    View zoomed = far_away;
    zoomed.camera.half_height = 4e-5f;
    const View parallel = looking_orthographic({1, 2, 3}, {}, 3, 64);
    View tile = perspective.tile(10, 20, 40, 30);
    for (const int samples : {1, 4}) {
        for (const bool lit : {false, true}) {
            for (const bool culls : {false, true}) {
                GlOptions options;
                ZBufferOptions of_reference;
                options.samples = of_reference.samples = samples;
                options.culls_back_faces = of_reference.culls_back_faces = culls;
                if (lit) options.light = of_reference.light = DirectionalLight{};
                GlRenderer tested(options);
                ZBufferRenderer reference(of_reference);
                int i = 0;
                for (const View& view : {perspective, inside, odd, shifted, cut, mirrored, zoomed, parallel, tile}) {
                    INFO("view " << i++ << ", " << samples << " samples, lit " << lit << ", culls " << culls);
                    const Image& expected = plain(reference, triangles, view);
                    // Samples on edges, rounded otherwise, and colors by a step of 1/255.
                    CHECK(mean_difference(plain(tested, triangles, view), expected) <= 0.004);
                }
            }
        }
    }
    gl.check_clean();
}

TEST_CASE("OpenGL shows of what is translucent its part", "[opengl]") {
    OpenGl gl;
    if (!gl) return;
    {
        const std::vector<Triangle> one{{{glm::vec3(-9, -9, 0), {9, -9, 0}, {0, 9, 0}}, {200, 100, 50, 64}}};
        GlRenderer renderer({.samples = 64});
        const Image& image = plain(renderer, one, looking({0, 0, 4}, {}, 32));
        double sum = 0;
        for (const Rgba8 c : image.pixels()) sum += c.a;
        CHECK(sum / double(image.pixels().size()) == Approx(64).margin(2));
    }
    gl.check_clean();
}

TEST_CASE("OpenGL deposits by the area law", "[opengl]") {
    OpenGl gl;
    if (!gl) return;
    {
        const View view = looking({0, 0, 4}, {}, 32);
        const LocalView local(view, {}, 3.0f);
        const float pixel = 4 / local.focal_px;
        for (const int lanes : {1, 2, 4}) {
            GlRenderer renderer({.lanes = lanes});
            // One splat on a pixel; two, one behind the other; two side by side in it, which are one.
            const auto alpha = [&](AreaLaw law, std::vector<glm::vec3> splats) {
                std::vector<Splat> all;
                for (const glm::vec3 s : splats) {
                    all.push_back({{pixel * (0.5f + s.x), pixel * 0.5f, 0},
                                   {pixel * s.y, pixel},
                                   s.z,
                                   Rgba8{255, 255, 255, std::uint8_t(law)}});
                }
                const Image& image =
                    picture_of(renderer, local, [&](GlRenderer& r) { r.draw(std::span<const Splat>(all)); });
                return image.at(16, 15).a / 255.0;
            };
            const AreaLaw coherent = AreaLaw::coherent, mixed = AreaLaw::mixed, strewn_law = AreaLaw::independent;
            for (const AreaLaw law : {coherent, mixed, strewn_law}) {
                CHECK(alpha(law, {{0, 1, 0.3f}}) == Approx(0.3).margin(0.003));
                CHECK(alpha(law, {{0, 1, 1}}) == Approx(1).margin(0.003));
            }
            CHECK(alpha(coherent, {{0, 1, 0.3f}, {0, 1, 0.5f}}) == Approx(0.8).margin(0.004));
            CHECK(alpha(coherent, {{0, 1, 0.8f}, {0, 1, 0.8f}}) == Approx(1).margin(0.004));
            CHECK(alpha(strewn_law, {{0, 1, 0.3f}, {0, 1, 0.5f}}) == Approx(0.65).margin(0.004));
            const double two =
                double(transmitted(transmitted(1, loss_of_opacity(0.3f, mixed)), loss_of_opacity(0.5f, mixed)));
            CHECK(alpha(mixed, {{0, 1, 0.3f}, {0, 1, 0.5f}}) == Approx(1 - two).margin(0.004));
            if (lanes > 1) CHECK(alpha(strewn_law, {{-0.25f, 0.5f, 1}, {0.25f, 0.5f, 1}}) == Approx(1).margin(0.004));
        }
        // What is nearer hides it, what lies behind shows through.
        GlRenderer renderer;
        const std::vector<Triangle> sheet{{{glm::vec3(-9, -9, 0), {9, -9, 0}, {0, 9, 0}}, {0, 255, 0}}};
        Source<Triangle> source{sheet, {}, 1};
        source.id = renderer.upload(source);
        for (const float z : {-1.0f, 1.0f}) {
            const Splat splat{{0, 0, z}, {3, 3}, 0.5f, {255, 0, 0, std::uint8_t(AreaLaw::coherent)}};
            const Range all{0, 1};
            const Image& image = picture_of(renderer, local, [&](GlRenderer& r) {
                r.draw(std::span(&splat, 1));
                r.draw(source, std::span(&all, 1));
            });
            CHECK(std::abs(image.at(16, 16).r - (z > 0 ? 128 : 0)) <= 1);
            CHECK(std::abs(image.at(16, 16).g - (z > 0 ? 127 : 255)) <= 1);
            CHECK(image.at(16, 16).a == 255);
        }
        renderer.release(source.id);
    }
    gl.check_clean();
}

TEST_CASE("OpenGL is sent splats that the processor makes for a camera that moves, and nothing for a still one",
          "[opengl]") {
    OpenGl gl;
    if (!gl) return;
    {
        const auto triangles = strewn(20'000, 0.02f, 2);
        const auto hierarchy = build<Hierarchy>(triangles);
        GlRenderer renderer({.shapes_stand_ins = false});
        auto viewer = make_viewer(hierarchy, triangles, renderer);
        View view = looking({0.3, 0.4, 6}, {}, 200, 12);
        const FrameStats stats = viewer.frame(view);
        CHECK(stats.splats > 100);
        CHECK(renderer.stats().uploaded_bytes > 24 * stats.splats);
        const Image first = renderer.image();
        for (int i = 0; i < 3; ++i) {
            viewer.frame(view);
            CHECK(renderer.stats().uploaded_bytes == 0);
            CHECK(renderer.image() == first);
        }
        // A splat is shaped for one view: those are sent again, and nothing else is.
        view.camera.eye.x += 0.0005;
        const FrameStats moved = viewer.frame(view);
        INFO(renderer.stats().uploaded_bytes << " bytes for " << moved.splats << " splats");
        CHECK(moved.splats > 100);
        CHECK(renderer.stats().uploaded_bytes < 36 * moved.splats + 1024);
    }
    gl.check_clean();
}

TEST_CASE("OpenGL is sent only the faces around a change", "[opengl]") {
    OpenGl gl;
    if (!gl) return;
    {
        std::vector<Face> faces;
        for (int i = 0; i < 10'000; ++i) {
            const glm::vec3 at(0.01f * float(i % 100), 0.01f * float(i / 100), 0);
            faces.push_back({at, at + glm::vec3(0.01f, 0.01f, 0), {std::uint8_t(i), 20, 30, 255}, 5});
        }
        GlRenderer renderer;
        const LocalView view(looking({0.5, 0.5, 3}, {0.5, 0.5, 0}, 64), {}, 2.0f);
        const auto draw = [&](GlRenderer& r) { r.draw(std::span<const Face>(faces)); };
        picture_of(renderer, view, draw);
        picture_of(renderer, view, draw);
        CHECK(renderer.stats().uploaded_bytes == 0);
        faces.erase(faces.begin() + 5000, faces.begin() + 5003);
        picture_of(renderer, view, draw);
        CHECK(renderer.stats().uploaded_bytes > 0);
        CHECK(renderer.stats().uploaded_bytes < 4096);  // a chunk's list, and the block of its command
    }
    gl.check_clean();
}

TEST_CASE("OpenGL draws ten times as much in as many calls", "[opengl]") {
    OpenGl gl;
    if (!gl) return;
    {
        std::array<std::uint64_t, 2> calls{};
        for (const std::size_t i : {std::size_t(0), std::size_t(1)}) {
            const auto triangles = strewn(i == 0 ? 3'000 : 30'000, 0.02f, 3);
            const auto hierarchy = build<Hierarchy>(triangles);
            GlRenderer renderer;
            auto viewer = make_viewer(hierarchy, triangles, renderer);
            View view = looking({0.3, 0.4, 6}, {}, 200, 0);
            const FrameStats stats = viewer.frame(view);
            CHECK(stats.primitives == triangles.size());
            calls[i] = renderer.stats().draw_calls;
        }
        CHECK(calls[0] == calls[1]);
        CHECK(calls[0] <= 2);
    }
    gl.check_clean();
}

TEST_CASE("OpenGL uploads what is shared once, and frees what is released", "[opengl]") {
    OpenGl gl;
    if (!gl) return;
    {
        const auto triangles = strewn(100, 0.5f, 4);
        const Source<Triangle> source{triangles, {}, 100};
        GlRenderer one, other;
        const std::uint32_t id = one.upload(source);
        CHECK(one.uploaded_bytes() == 100 * sizeof(opengl::TriangleVertices));
        const std::size_t buffers = opengl::live_objects()[std::size_t(opengl::ObjectKind::buffer)];
        const std::uint32_t shared = other.share(one, id);
        CHECK(opengl::live_objects()[std::size_t(opengl::ObjectKind::buffer)] == buffers);
        one.release(id);
        CHECK(one.uploaded_bytes() == 0);
        CHECK(opengl::live_objects()[std::size_t(opengl::ObjectKind::buffer)] == buffers);
        other.release(shared);
        CHECK(opengl::live_objects()[std::size_t(opengl::ObjectKind::buffer)] == buffers - 1);
        CHECK(one.upload(source) == id);
    }
    gl.check_clean();
}

TEST_CASE("OpenGL tells some frames later what a wall hides, and it is not missed", "[opengl]") {
    OpenGl gl;
    if (!gl) return;
    {
        auto triangles = strewn(20'000, 0.02f, 5);
        for (Triangle& t : triangles) {
            for (glm::vec3& v : t.vertices) v.z -= 2;
        }
        const Rgba8 gray{99, 99, 99, 255};
        triangles.push_back({{glm::vec3(-3, -3, 0.5f), {3, -3, 0.5f}, {3, 3, 0.5f}}, gray});
        triangles.push_back({{glm::vec3(-3, -3, 0.5f), {3, 3, 0.5f}, {-3, 3, 0.5f}}, gray});
        const auto hierarchy = build<Hierarchy>(triangles);
        GlRenderer renderer({.asks_what_is_hidden = true}), reference;
        auto viewer = make_viewer(hierarchy, triangles, renderer),
             plain_viewer = make_viewer(hierarchy, triangles, reference);
        const View front = looking({0, 0, 6}, {}, 100, 0), beside = looking({6, 0, -1}, {0, 0, -2}, 100, 0);
        FrameStats stats;
        for (int i = 0; i < 40; ++i) {
            stats = viewer.frame(front);
            plain_viewer.frame(front);
            CHECK(renderer.image() == reference.image());
        }
        CHECK(stats.cells_hidden > 0);
        CHECK(stats.primitives < triangles.size() / 2);
        for (int i = 0; i < 20; ++i) viewer.frame(beside);
        plain_viewer.frame(beside);
        CHECK(mean_difference(renderer.image(), reference.image()) < 0.01);
    }
    gl.check_clean();
}

TEST_CASE("OpenGL refuses what no renderer takes", "[opengl]") {
    OpenGl gl;
    if (!gl) return;
    {
        CHECK_THROWS_AS(GlRenderer({.samples = 3}), std::invalid_argument);
        CHECK_THROWS_AS(GlRenderer({.lanes = 3}), std::invalid_argument);
        CHECK_THROWS_AS(GlRenderer({.light = DirectionalLight{.towards = glm::vec3(0)}}), std::invalid_argument);
        GlRenderer renderer;
        LocalView view(looking({0, 0, 4}, {}, 32), {}, 3.0f);
        view.width = 20'000;
        CHECK_THROWS_AS(renderer.begin_frame(view), std::invalid_argument);
    }
    gl.check_clean();
}
