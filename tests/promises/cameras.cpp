// Cameras as engines have them give the picture that they should in every renderer: tiles, mirrors, pixels that are not
// square, far planes.
#include <array>
#include <cmath>
#include <functional>
#include <glm/ext/matrix_clip_space.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include "catch.hpp"
#include "farfield/approximation/color_cube.hpp"
#include "farfield/approximation/exact.hpp"
#include "farfield/approximation/opacity_tensor.hpp"
#include "farfield/build.hpp"
#include "farfield/cost_model/triangle_count.hpp"
#include "farfield/partition/octree.hpp"
#include "farfield/partition/polygon_bsp.hpp"
#include "farfield/renderer/hierarchical_z_renderer.hpp"
#include "farfield/renderer/painter_renderer.hpp"
#include "farfield/renderer/z_buffer_renderer.hpp"
#include "farfield/viewer.hpp"
#include "scenes/renderers/coverage_tilers.hpp"
#include "support/pictures.hpp"
#include "support/random.hpp"
#include "support/scenes.hpp"

using namespace farfield;
using namespace farfield::test;

namespace {

using Tensors = SpatialHierarchy<Octree, OpacityTensor, TriangleCount>;
using Cubes = SpatialHierarchy<Octree, ColorCube, TriangleCount>;
using Bsp = SpatialHierarchy<PolygonBsp, Exact, TriangleCount>;

constexpr DirectionalLight light{};

/// Translucent ones, large ones and small ones.
Triangles things() {
    Triangles all = mixed_triangles(1500, 171);
    append(all, random_triangles(1500, 172, 0.03f));
    for (std::size_t i = 0; i < all.size(); i += 7) all[i].rgba.a = 128;
    return all;
}

struct World {
    Triangles triangles = things();
    Tensors tensors = build<Tensors>(triangles, {.sampler = light});
    Cubes cubes = build<Cubes>(triangles, {.sampler = light});
    Triangles few = random_triangles(80, 173, 0.7f);
    Bsp bsp = build<Bsp>(few);
};

using Draw = std::function<Image(const View&)>;
struct Drawer {
    std::string name;
    Draw draw;
};

template <class R, class Options, class H>
Draw drawing(const Options& options, const H& hierarchy, const Triangles& triangles) {
    return [=, &hierarchy, &triangles](const View& view) {
        R renderer(options);
        make_viewer(hierarchy, triangles, renderer).frame(view);
        return renderer.image();
    };
}

std::vector<Drawer> renderers(const World& w, bool culls = false) {
    const ZBufferOptions one{.light = light, .culls_back_faces = culls};
    ZBufferOptions nine = one;
    nine.samples = 9;
    const CoverageOptions masks{.light = light, .culls_back_faces = culls},
        deposits{.light = light, .culls_back_faces = culls, .far_coverage = FarCoverage::area_law};
    return {
        {"z-buffer, tensors", drawing<ZBufferRenderer>(one, w.tensors, w.triangles)},
        {"z-buffer, cubes, 9 samples", drawing<ZBufferRenderer>(nine, w.cubes, w.triangles)},
        {"hierarchical z, tensors", drawing<HierarchicalZRenderer>(nine, w.tensors, w.triangles)},
        {"masks, cubes", drawing<CoverageRenderer>(masks, w.cubes, w.triangles)},
        {"masks, tensors", drawing<CoverageRenderer>(deposits, w.tensors, w.triangles)},
        {"strict masks", drawing<StrictCoverageRenderer>(masks, w.bsp, w.few)},
        {"painter", drawing<PainterRenderer>(PainterOptions{.light = light, .culls_back_faces = culls}, w.bsp, w.few)}};
}

View seen(int width, int height, bool parallel, float tolerance) {
    View v = parallel ? looking_orthographic({1.4, 0.9, 2.1}, {}, 2.2f) : looking({1.4, 0.9, 2.1});
    v.width = width;
    v.height = height;
    v.tolerance_px = tolerance;
    return v;
}

Image mirrored(const Image& image) {
    Image out(image.width(), image.height());
    for (int y = 0; y < image.height(); ++y) {
        for (int x = 0; x < image.width(); ++x) out.at(x, y) = image.at(image.width() - 1 - x, y);
    }
    return out;
}

}  // namespace

TEST_CASE("tiles side by side are the whole picture, byte for byte, in every renderer") {
    const World world;
    for (const Drawer& r : renderers(world)) {
        for (const bool parallel : {false, true}) {
            INFO(r.name << (parallel ? ", parallel" : ""));
            const View view = seen(96, 64, parallel, 0);
            const Image whole = r.draw(view);
            for (const auto& [columns, rows] : {std::array{2, 2}, std::array{3, 1}, std::array{1, 4}}) {
                Image tiled(view.width, view.height);
                const int w = view.width / columns, h = view.height / rows;
                for (int ty = 0; ty < rows; ++ty) {
                    for (int tx = 0; tx < columns; ++tx) {
                        const Image tile = r.draw(view.tile(tx * w, ty * h, w, h));
                        for (int y = 0; y < h; ++y) {
                            for (int x = 0; x < w; ++x) tiled.at(tx * w + x, ty * h + y) = tile.at(x, y);
                        }
                    }
                }
                CHECK(different_pixels(tiled, whole) == 0);
            }
        }
    }
}

TEST_CASE("tiles with stand-ins are the whole picture, byte for byte, in every renderer") {
    const World world;
    for (const Drawer& r : renderers(world)) {
        INFO(r.name);
        for (const float tolerance : {1.0f, 2.0f, 5.0f}) {
            const View view = seen(97, 65, false, tolerance);
            const Image whole = r.draw(view);
            Image tiled(view.width, view.height);
            for (int tile = 0; tile < 4; ++tile) {
                const int x0 = tile % 2 * 45, y0 = tile / 2 * 31;
                const int w = x0 == 0 ? 45 : 52, h = y0 == 0 ? 31 : 34;
                const Image part = r.draw(view.tile(x0, y0, w, h));
                for (int y = 0; y < h; ++y) {
                    for (int x = 0; x < w; ++x) tiled.at(x0 + x, y0 + y) = part.at(x, y);
                }
            }
            CHECK(different_pixels(tiled, whole) == 0);
        }
    }
}

TEST_CASE("tiles of tiles are tiles, and what leaves the picture is refused") {
    const World world;
    const Drawer r = renderers(world)[0];
    const View view = seen(96, 64, false, 2);
    const View once = view.tile(20, 12, 50, 30), twice = view.tile(10, 4, 70, 50).tile(10, 8, 50, 30);
    CHECK(different_pixels(r.draw(once), r.draw(twice)) == 0);
    CHECK(twice.part.left == 20);
    CHECK(twice.part.whole_width == 96);
    for (const auto& [left, top, w, h] : {std::array{-1, 0, 5, 5}, std::array{0, -1, 5, 5}, std::array{92, 0, 5, 5},
                                          std::array{0, 60, 5, 5}, std::array{0, 0, 97, 1}}) {
        CHECK_THROWS_WITH(view.tile(left, top, w, h), "farfield::View: a tile must lie in the picture");
    }
    View wrong = once;
    wrong.width = 90;
    CHECK_THROWS_WITH(wrong.validate(), "farfield::View: part must lie in the whole picture");
    wrong = view;
    wrong.part.left = 1;
    CHECK_THROWS_WITH(wrong.validate(), "farfield::View: part must name the whole's size");
}

TEST_CASE("left-handed matrices of a left-handed world give the picture of the right-handed one, light and backs too") {
    World world;
    for (Triangle& t : world.triangles) t.rgba.a = 255;  // what is translucent is decided by coordinates
    world.tensors = build<Tensors>(world.triangles, {.sampler = light});
    // The same scene with z turned round, corners in the order that keeps their fronts in front.
    World turned = world;
    const auto turn = [](Triangles& triangles) {
        for (Triangle& t : triangles) {
            for (glm::vec3& v : t.vertices) v.z = -v.z;
            std::swap(t.vertices[1], t.vertices[2]);
        }
    };
    turn(turned.triangles);
    turn(turned.few);
    const DirectionalLight turned_light{.towards = light.towards * glm::vec3(1, 1, -1)};
    turned.tensors = build<Tensors>(turned.triangles, {.sampler = turned_light});
    turned.bsp = build<Bsp>(turned.few);
    const View view = seen(90, 60, false, 0);
    View other = view;
    other.camera.eye.z = -other.camera.eye.z;
    for (glm::vec3* axis : {&other.camera.right, &other.camera.up, &other.camera.forward}) axis->z = -axis->z;
    REQUIRE(other.camera.is_mirrored());
    for (const bool culls : {false, true}) {
        const ZBufferOptions here{.samples = 4, .light = light, .culls_back_faces = culls},
            there{.samples = 4, .light = turned_light, .culls_back_faces = culls};
        CHECK(largest_difference(drawing<ZBufferRenderer>(here, world.tensors, world.triangles)(view),
                                 drawing<ZBufferRenderer>(there, turned.tensors, turned.triangles)(other)) <= 1);
        CHECK(largest_difference(drawing<HierarchicalZRenderer>(here, world.tensors, world.triangles)(view),
                                 drawing<HierarchicalZRenderer>(there, turned.tensors, turned.triangles)(other)) <= 1);
        const CoverageOptions masks{.light = light, .culls_back_faces = culls},
            turned_masks{.light = turned_light, .culls_back_faces = culls};
        CHECK(largest_difference(drawing<StrictCoverageRenderer>(masks, world.bsp, world.few)(view),
                                 drawing<StrictCoverageRenderer>(turned_masks, turned.bsp, turned.few)(other)) <= 8);
        const PainterOptions painter{.light = light, .culls_back_faces = culls},
            turned_painter{.light = turned_light, .culls_back_faces = culls};
        CHECK(different_pixels(drawing<PainterRenderer>(painter, world.bsp, world.few)(view),
                               drawing<PainterRenderer>(turned_painter, turned.bsp, turned.few)(other)) < 20);
    }
    // A mirror shows the other way round what is in front of it.
    View mirror = view;
    mirror.camera.right = -mirror.camera.right;
    const ZBufferOptions options{.samples = 4, .light = light, .culls_back_faces = true};
    const auto draw = drawing<ZBufferRenderer>(options, world.tensors, world.triangles);
    // Samples on an edge belong to the other side of it.
    CHECK(different_pixels(mirrored(draw(mirror)), draw(view)) < 30);
}

TEST_CASE("a picture that is half as wide in pixels is one of pixels twice as wide") {
    const Triangles triangles = random_triangles(60, 175, 1.0f);
    const auto h = build<Tensors>(triangles);
    View square = seen(128, 64, false, 0), wide = square;
    square.width = 256;
    wide.width = 128;
    wide.camera.half_width = square.camera.half_height * 4;
    for (const Drawer& r : {Drawer{"z", drawing<ZBufferRenderer>(ZBufferOptions{.samples = 64}, h, triangles)},
                            Drawer{"masks", drawing<CoverageRenderer>(CoverageOptions{}, h, triangles)}}) {
        INFO(r.name);
        const Image fine = r.draw(square), coarse = r.draw(wide);
        double difference = 0;
        for (int y = 0; y < 64; ++y) {
            for (int x = 0; x < 128; ++x) {
                difference += std::abs((fine.at(2 * x, y).r + fine.at(2 * x + 1, y).r) / 2.0 - coarse.at(x, y).r);
            }
        }
        CHECK(difference / (64 * 128) < 1.5);
    }
}

TEST_CASE("nothing beyond the far plane is drawn, and all before it") {
    // Sheets across the view at depths 1, 2 and 3, and one that runs from 0.5 to 3.5.
    Triangles sheets;
    for (int i = 1; i <= 3; ++i) {
        const float z = -float(i), x = 0.3f * float(i - 2);
        append(sheets, sheet({x - 0.1f, -0.2f, z}, {0.2f, 0, 0}, {0, 0.2f, 0}, 3, 3, {200, 20, 20, 255}));
    }
    append(sheets, sheet({-0.4f, -0.3f, -0.5f}, {0.8f, 0, 0}, {0, 0, -3}, 1, 1, {20, 200, 20, 255}));
    const Tensors h = build<Tensors>(sheets);
    const Bsp bsp = build<Bsp>(sheets);
    const std::vector<Drawer> all{{"z", drawing<ZBufferRenderer>(ZBufferOptions{}, h, sheets)},
                                  {"hierarchical z", drawing<HierarchicalZRenderer>(ZBufferOptions{}, h, sheets)},
                                  {"masks", drawing<CoverageRenderer>(CoverageOptions{}, h, sheets)},
                                  {"strict", drawing<StrictCoverageRenderer>(CoverageOptions{}, bsp, sheets)},
                                  {"painter", drawing<PainterRenderer>(PainterOptions{}, bsp, sheets)}};
    for (const Drawer& r : all) {
        for (const bool parallel : {false, true}) {
            View v = parallel ? looking_orthographic({0, 0, 0}, {0, 0, -1}, 1.2f) : looking({0, 0, 0}, {0, 0, -1});
            v.camera.far_depth = 2.5f;
            Triangles before;
            for (Triangle t : sheets) {
                if (t.vertices[0].z > -2.4f && t.rgba.r == 200) before.push_back(t);
            }
            append(before, sheet({-0.4f, -0.3f, -0.5f}, {0.8f, 0, 0}, {0, 0, -2}, 1, 1, {20, 200, 20, 255}));
            INFO(r.name << (parallel ? ", parallel" : ""));
            const Image expected =
                plain_picture<Triangle>(before, v, {.samples = r.name == "masks" || r.name == "strict" ? 64 : 1});
            CHECK(coverage(expected) > 500);
            CHECK(different_pixels(r.draw(v), expected) < 8);
        }
    }
}

TEST_CASE("reversed depth changes nothing, and two eyes see what cameras that stand there see") {
    const World world;
    const glm::dvec3 eye(1.4, 0.9, 2.1);
    const glm::dmat4 view = glm::lookAt(eye, glm::dvec3(0), glm::dvec3(0, 1, 0)),
                     projection = glm::perspectiveRH_ZO(0.9, 1.5, 0.1, 50.0),
                     reversed = glm::perspectiveRH_ZO(0.9, 1.5, 50.0, 0.1);
    View v = seen(90, 60, false, 1), r = v, plain = v;
    v.camera = Camera::from_matrices(view, projection, ClipDepth::zero_to_one);
    r.camera = Camera::from_matrices(view, reversed, ClipDepth::zero_to_one);
    plain.camera = Camera::perspective(eye, {}, {0, 1, 0}, 0.9f);
    for (const Drawer& renderer : renderers(world)) {
        INFO(renderer.name);
        const Image picture = renderer.draw(v);
        CHECK(coverage(picture) > 300);
        CHECK(picture == renderer.draw(r));
        // Numbers that are computed another way: a sample on an edge here and there.
        CHECK(different_pixels(picture, renderer.draw(plain)) < 60);
    }
    // Eyes side by side that look past each other at one window: a point of the window is seen in one pixel by both.
    for (const double side : {-0.06, 0.06}) {
        const double window = 2.0, half = 0.6;
        const glm::dmat4 of_eye = glm::translate(glm::dmat4(1), glm::dvec3(-side, 0, 0)) * view;
        const double scale = 0.1 / window;
        View s = v;
        s.camera = Camera::from_matrices(of_eye, glm::frustumRH_ZO((-half - side) * scale, (half - side) * scale,
                                                                   -0.4 * scale, 0.4 * scale, 0.1, 50.0));
        const LocalView local(s, {}, 4.0f);
        const detail::SampleProjection to(local, 1);
        const glm::dvec3 p = glm::dvec3(glm::inverse(view) * glm::dvec4(0.3, 0.2, -window, 1));
        const glm::vec3 w = to.project(glm::vec3(p));
        const double x = double(w.x * to.inverse_w(w.z) + to.offset_x) / 256 - to.first_x;
        CHECK(x == Approx((0.3 / half + 1) / 2 * 90).margin(0.01));
    }
}

TEST_CASE("every renderer refuses what makes no picture, in one voice") {
    const World world;
    View view = seen(40, 30, false, 1);
    view.camera.forward *= 2.0f;
    for (const Drawer& r : renderers(world)) {
        CHECK_THROWS_WITH(r.draw(view), "farfield::Camera: forward must have length 1");
    }
    view = seen(40, 30, false, 1);
    view.camera.off_center = {5000, 0};
    for (const Drawer& r : renderers(world)) {
        CHECK_THROWS_AS(r.draw(view), std::invalid_argument);
    }
    ZBufferRenderer renderer({.light = light});
    auto viewer = make_viewer(world.tensors, world.triangles, renderer);
    view = seen(40, 30, false, std::numeric_limits<float>::infinity());
    CHECK_THROWS_WITH(viewer.select(view), "farfield::View: tolerance_px must be 0 or more and finite");
}
