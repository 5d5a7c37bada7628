// The far field: splats and faces deposited front to back over the z-buffer.
#include "farfield/raster/samples/sample_buffers.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "catch.hpp"
#include "support/pictures.hpp"
#include "support/scenes.hpp"

using namespace farfield;
using namespace farfield::detail;
using namespace farfield::test;

namespace {

LocalView straight(int size, bool perspective, glm::vec3 eye = {0, 0, 0}) {
    View view = perspective ? looking(eye, glm::dvec3(eye) + glm::dvec3(0, 0, -1), size)
                            : looking_orthographic(eye, glm::dvec3(eye) + glm::dvec3(0, 0, -1), 2, size);
    return LocalView(view, glm::dvec3(0), 10);
}

struct Canvas {
    ZBufferRenderer renderer;
    LocalView view;
    Triangles triangles;
    Source<Triangle> source;

    Canvas(const LocalView& v, int samples, Triangles near = {}, Rgba8 background = {0, 0, 0, 0})
        : renderer(ZBufferOptions{.samples = samples, .background = background}), view(v), triangles(std::move(near)) {
        source = {triangles, {}, std::uint32_t(triangles.size()), {}, 0};
        source.id = renderer.upload(source);
        renderer.begin_frame(view);
        renderer.set_view(view);
    }
    void draw_near() {
        const Range all{0, source.item_count};
        renderer.draw(source, std::span<const Range>(&all, 1));
    }
    /// A splat that is a square of this area when seen squarely.
    struct Squarely {
        glm::vec3 center;
        float area, opacity;
        Rgba8 rgb;
    };
    void draw(const Squarely& s) {
        const Splat splat{s.center, glm::vec2(std::sqrt(s.area * view.stretch(s.center))), s.opacity, s.rgb};
        renderer.draw(std::span<const Splat>(&splat, 1));
    }
    void draw(const Face& f) { renderer.draw(std::span<const Face>(&f, 1)); }
    const Image& done() {
        renderer.end_frame();
        return renderer.image();
    }
};

Rgba8 rgb(int r, int g, int b, AreaLaw law) {
    return {std::uint8_t(r), std::uint8_t(g), std::uint8_t(b), std::uint8_t(law)};
}

constexpr AreaLaw laws[] = {AreaLaw::independent, AreaLaw::mixed, AreaLaw::coherent};

}  // namespace

TEST_CASE("abutting splats of a surface let nothing through", "[raster]") {
    Random random(80);
    for (const bool perspective : {true, false}) {
        for (const int samples : {1, 4, 16}) {
            const LocalView view = straight(48, perspective);
            Canvas canvas(view, samples, sheet({-9, -9, -5}, {18, 0, 0}, {0, 18, 0}, 1, 1, {255, 0, 0, 255}));
            canvas.draw_near();
            // As a grid of cells gives them, squarely seen at one depth; a hair under and over a sample wide.
            const float step =
                1.83f / std::sqrt(float(samples)) * 2 * (perspective ? 2.0f / view.focal_px : 1.0f / view.focal_px);
            std::vector<glm::vec3> places;
            for (float y = -1.6f; y < 1.6f; y += step) {
                for (float x = -1.6f; x < 1.6f; x += step) places.push_back({x, y, -2});
            }
            random.shuffle(places);
            for (const glm::vec3 place : places) {
                // What a face on the plane looks like from the eye: squarely projected.
                const glm::vec3 d = view.towards_viewer(place);
                const float area = step * step * std::abs(d.z) / glm::length(d);
                canvas.draw({place, area, 1, rgb(0, 255, 0, AreaLaw::coherent)});
            }
            const Image& image = canvas.done();
            int through = 0;
            for (const Rgba8 c : image.pixels()) through = std::max<int>(through, c.r);
            INFO((perspective ? "perspective, " : "orthographic, ") << samples << " samples");
            // Single precision adds up edges of squares.
            CHECK(through <= 1);
            CHECK(image.at(24, 24).g >= 254);
        }
    }
}

TEST_CASE("abutting faces let nothing through", "[raster]") {
    for (const bool perspective : {true, false}) {
        for (const int samples : {1, 4}) {
            Canvas canvas(straight(50, perspective), samples,
                          sheet({-9, -9, -5}, {18, 0, 0}, {0, 18, 0}, 1, 1, {255, 0, 0, 255}));
            canvas.draw_near();
            for (int y = -20; y < 20; ++y) {
                for (int x = -20; x < 20; ++x) {
                    const glm::vec3 low = glm::vec3(float(x), float(y), 0) * 0.0873f + glm::vec3(0, 0, -2);
                    const glm::vec3 high = glm::vec3(float(x + 1), float(y + 1), 0) * 0.0873f + glm::vec3(0, 0, -2);
                    canvas.draw(Face{low, high, {0, 255, 0, 255}, 5});
                }
            }
            const Image& image = canvas.done();
            CHECK(std::all_of(image.pixels().begin(), image.pixels().end(), [](Rgba8 c) {
                return c == Rgba8{0, 255, 0, 255};
            }));
        }
    }
}

TEST_CASE("a translucent face covers its opacity, once where faces abut", "[raster]") {
    for (const int alpha : {10, 60, 95, 96, 128, 190, 191, 220, 254}) {
        Canvas canvas(straight(50, true), 1);
        for (int y = -20; y < 20; ++y) {
            for (int x = -20; x < 20; ++x) {
                const glm::vec3 low = glm::vec3(float(x), float(y), 0) * 0.0873f + glm::vec3(0, 0, -2);
                const glm::vec3 high = glm::vec3(float(x + 1), float(y + 1), 0) * 0.0873f + glm::vec3(0, 0, -2);
                canvas.draw(Face{low, high, {0, std::uint8_t(alpha / 2), 0, std::uint8_t(alpha)}, 5});
            }
        }
        for (const Rgba8 c : canvas.done().pixels()) {
            CHECK(std::abs(c.a - alpha) <= 2);
            CHECK(std::abs(c.g - alpha / 2) <= 1);
        }
    }
}

TEST_CASE("depositing something in parts is depositing it whole", "[raster]") {
    for (const AreaLaw law : laws) {
        for (const int parts : {2, 3, 16}) {
            for (const float share : {0.05f, 0.3f, 0.6f, 0.9f}) {
                Image whole, split;
                const LocalView view = straight(32, false);
                const float pixel = 1 / view.focal_px;
                for (Image* image : {&whole, &split}) {
                    Canvas canvas(view, 1, {}, {0, 0, 200, 255});
                    const int n = image == &whole ? 1 : parts;
                    for (int i = 0; i < n; ++i) {
                        const float footprint = 4 * pixel * pixel;
                        // The opacity of one part alone.
                        const float opacity = 1 - transmitted(1, share / float(n), law);
                        canvas.draw({{0.123f, 0.077f, -2}, footprint, opacity, rgb(250, 100, 0, law)});
                    }
                    *image = canvas.done();
                }
                INFO("law " << int(law) << ", share " << share << " in " << parts);
                // Where an edge cuts a lane, parts fall into what it cuts off independently.
                CHECK(largest_difference(whole, split) <= (law == AreaLaw::independent ? 2 : 1));
                CHECK(coverage(whole) > 0);
            }
        }
    }
}

TEST_CASE("splats in parts of a footprint cover as much as the whole", "[raster]") {
    // A cell's children instead of the cell: four quarters of the area, beside each other.
    for (const AreaLaw law : laws) {
        const LocalView view = straight(32, false);
        const float side = 2 / view.focal_px;
        double alpha[2] = {};
        for (const int n : {1, 2}) {
            Canvas canvas(view, 1);
            for (int y = 0; y < n; ++y) {
                for (int x = 0; x < n; ++x) {
                    const float small = side / float(n);
                    canvas.draw({glm::vec3(0.0123f, 0.0431f, -2) + glm::vec3((float(x) + 0.5f) * small - side / 2,
                                                                             (float(y) + 0.5f) * small - side / 2, 0),
                                 small * small, 0.4f, rgb(255, 255, 255, law)});
                }
            }
            alpha[n - 1] = coverage(canvas.done());
        }
        CHECK(std::abs(alpha[0] - alpha[1]) < 0.02 * alpha[0]);
    }
}

TEST_CASE("a coherent splat covers its area, in the middle and at the border of a wide view", "[raster]") {
    for (const int samples : {1, 16, 64}) {
        for (const bool perspective : {true, false}) {
            View v =
                perspective ? looking({0, 0, 0}, {0, 0, -1}, 64) : looking_orthographic({0, 0, 0}, {0, 0, -1}, 8, 64);
            if (perspective) v.camera.half_height = 1.2f;
            const LocalView view(v, {}, 10);
            for (const glm::vec3 center : {glm::vec3(0, 0, -2), glm::vec3(1.9f, 0, -2), glm::vec3(-1.5f, 1.5f, -2),
                                           glm::vec3(0.01f, -2.1f, -2)}) {
                Canvas canvas(view, samples);
                // A small sphere: its projected area is that from everywhere.
                const float radius = 0.5f * (perspective ? 2.0f : 1.0f) / view.focal_px;
                const float area = 3.14159265f * radius * radius;
                canvas.draw({center, area, 1, rgb(255, 255, 255, AreaLaw::coherent)});
                const double covered = coverage(canvas.done());
                const double distance = glm::length(glm::dvec3(center)), depth = -double(center.z),
                             f = double(view.focal_px);
                const double expected =
                    perspective ? double(area) * f * f * distance / (depth * depth * depth) : double(area) * f * f;
                INFO(samples << " samples, x " << center.x);
                CHECK(std::abs(covered / expected - 1) < 0.02);
            }
        }
    }
}

TEST_CASE("the far field stands behind what is nearer and in front of what is farther", "[raster]") {
    const Triangles wall = sheet({-9, -9, -3}, {18, 0, 0}, {0, 18, 0}, 1, 1, {255, 0, 0, 255});
    for (const bool perspective : {true, false}) {
        for (const float z : {-2.9f, -3.1f}) {
            for (const bool face : {true, false}) {
                Canvas canvas(straight(20, perspective), 1, wall);
                canvas.draw_near();
                if (face) {
                    canvas.draw(Face{{-9, -9, z}, {9, 9, z}, {0, 255, 0, 255}, 5});
                } else {
                    const float area =
                        16.0f / (canvas.view.focal_px * canvas.view.focal_px) * (perspective ? z * z : 1);
                    canvas.draw({{0, 0, z}, area, 1, rgb(0, 255, 0, AreaLaw::coherent)});
                }
                const Rgba8 c = canvas.done().at(10, 10);
                CHECK(c == (z > -3 ? Rgba8{0, 255, 0, 255} : Rgba8{255, 0, 0, 255}));
            }
        }
    }
}

TEST_CASE("the near plane cuts the far field too", "[raster]") {
    View v = looking({0, 0, 0}, {0, 0, -1}, 20);
    v.camera.near_depth = 2.5f;
    const LocalView view(v, {}, 10);
    Canvas canvas(view, 1);
    canvas.draw(Face{{-9, -9, -2}, {9, 9, -2}, {0, 255, 0, 255}, 5});
    canvas.draw({{0, 0, -2}, 0.1f, 1, rgb(0, 255, 0, AreaLaw::coherent)});
    canvas.draw({{0, 0, 2}, 0.1f, 1, rgb(0, 255, 0, AreaLaw::coherent)});
    CHECK(coverage(canvas.done()) == 0);
}

TEST_CASE("faces that cross the eye's plane are clipped, and splats off the picture cost nothing", "[raster]") {
    Canvas canvas(straight(20, true), 4);
    canvas.draw(Face{{-1, -1, -5}, {-1, 1, 5}, {0, 255, 0, 255}, 1});
    // As small as cells are that come as splats, at any angle.
    for (const float x : {-1e3f, 1e3f, -1e6f, 1e6f, -1e18f, 1e18f}) {
        canvas.draw({{x, 0, -2}, 1e-3f, 1, rgb(255, 255, 0, AreaLaw::coherent)});
        canvas.draw({{0, x, -2}, 1e-3f, 1, rgb(255, 255, 0, AreaLaw::mixed)});
    }
    const Image& image = canvas.done();
    CHECK(std::all_of(image.pixels().begin(), image.pixels().end(), [](Rgba8 c) { return c.r == 0; }));
}

TEST_CASE("nothing that could still change an open sample is said to be hidden", "[raster]") {
    Random random(81);
    std::size_t hidden_cells = 0, asked = 0;
    for (int round = 0; round < 60; ++round) {
        const bool perspective = round % 2 == 0;
        View v = perspective ? looking({0, 0, 3}, {0, 0, 0}, 64) : looking_orthographic({0, 0, 3}, {0, 0, 0}, 2.5f, 64);
        v.tolerance_px = 1;
        const LocalView view(v, {}, 10);
        Canvas canvas(view, round % 3 == 0 ? 4 : 1,
                      sheet({-0.7f, -0.2f, 0.4f}, {0.5f, 0, 0}, {0, 0.7f, 0}, 1, 1, {255, 0, 0, 255}));
        canvas.draw_near();
        // A wall of opaque splats with holes, nearest first.
        for (float z = 0.9f; z > 0; z -= 0.3f) {
            for (int i = 0; i < 900; ++i) {
                const float size = 2 * canvas.renderer.largest_splat_px() / view.focal_px;
                canvas.draw({{random.between(-1, 1), random.between(-1, 1), z},
                             size * size,
                             1,
                             rgb(0, 255, 0, laws[random.below(3)])});
            }
        }
        Image before;
        {
            // What is there so far, without ending the frame that is asked below.
            canvas.renderer.end_frame();
            before = canvas.renderer.image();
        }
        for (int i = 0; i < 150; ++i) {
            Cell cell;
            cell.center = cell.bounds_center =
                glm::vec3(random.between(-1.4f, 1.4f), random.between(-1.4f, 1.4f), random.between(-3, -0.3f));
            cell.half = glm::vec3(random.between(0.005f, 0.1f));
            cell.bounds_half = cell.half * float(1 + i % 2);
            ++asked;
            if (!canvas.renderer.hidden(cell, {})) continue;
            ++hidden_cells;
            // All that such a cell may draw: faces of its bounds, deposits anywhere inside.
            const Box b = cell.bounds();
            for (unsigned side = 0; side < 6; ++side) {
                Face f{b.lower, b.upper, {0, 0, 255, 255}, std::uint8_t(side)};
                (side & 1 ? f.lower : f.upper)[int(side / 2)] = (side & 1 ? f.upper : f.lower)[int(side / 2)];
                canvas.draw(f);
            }
            for (int k = 0; k < 5; ++k) {
                const glm::vec3 at =
                    cell.center +
                    glm::vec3(random.between(-1, 1), random.between(-1, 1), random.between(-1, 1)) * cell.half;
                canvas.draw({at, cell.half.x * cell.half.x, 1, rgb(0, 0, 255, AreaLaw::coherent)});
            }
        }
        canvas.renderer.end_frame();
        INFO("round " << round);
        CHECK(different_pixels(canvas.renderer.image(), before) == 0);
    }
    CHECK(hidden_cells > 50);
    CHECK(hidden_cells < asked);
}

TEST_CASE("no triangle in a cell hidden by geometry changes the picture", "[raster]") {
    Random random(82);
    std::size_t hidden_cells = 0, asked = 0;
    for (int round = 0; round < 80; ++round) {
        const bool perspective = round % 2 == 0;
        View v = perspective ? looking({0, 0, 3}, {0, 0, 0}, 96) : looking_orthographic({0, 0, 3}, {0, 0, 0}, 2.5f, 96);
        const LocalView view(v, {}, 10);
        // Large triangles, slanted, with gaps between them; then cells before, among and behind them, each with some
        // triangles that touch its sides.
        Triangles near = random_triangles(40, std::uint64_t(83 + round), 1.2f);
        std::vector<Cell> cells;
        Triangles inside;
        for (int i = 0; i < 120; ++i) {
            Cell cell;
            cell.center = cell.bounds_center =
                glm::vec3(random.between(-1.4f, 1.4f), random.between(-1.4f, 1.4f), random.between(-3, 1.5f));
            cell.half = cell.bounds_half = glm::vec3(random.between(0.005f, 0.15f));
            cells.push_back(cell);
            for (int k = 0; k < 6; ++k) {
                Triangle t{{}, {0, 0, 255, 255}};
                for (glm::vec3& p : t.vertices) {
                    p = random.in_cube(1);
                    p[k % 3] = k < 3 ? 1.0f : -1.0f;
                    p = cell.center + p * cell.half;
                }
                inside.push_back(t);
            }
        }
        const auto count = std::uint32_t(near.size());
        append(near, inside);
        Canvas canvas(view, round % 3 == 0 ? 4 : 1, near);
        const auto draw = [&](std::uint32_t first, std::uint32_t n) {
            const Range range{first, n};
            canvas.renderer.draw(canvas.source, std::span<const Range>(&range, 1));
        };
        draw(0, count);
        canvas.draw({{0, 0, -2.9f}, 1e-6f, 1, rgb(0, 255, 0, AreaLaw::mixed)});  // the far field begins
        canvas.renderer.end_frame();
        const Image before = canvas.renderer.image();
        for (std::uint32_t i = 0; i < cells.size(); ++i) {
            ++asked;
            if (!canvas.renderer.hidden(cells[i], {})) continue;
            ++hidden_cells;
            draw(count + 6 * i, 6);
        }
        canvas.renderer.end_frame();
        INFO("round " << round);
        CHECK(different_pixels(canvas.renderer.image(), before) == 0);
    }
    CHECK(hidden_cells > asked / 10);
    CHECK(hidden_cells < asked);
}

TEST_CASE("before the first stand-in geometry hides nothing, after it what lies behind", "[raster]") {
    Canvas canvas(straight(20, true), 1, sheet({-9, -9, -3}, {18, 0, 0}, {0, 18, 0}, 1, 1, {255, 0, 0, 255}));
    canvas.draw_near();
    Cell cell;
    cell.center = cell.bounds_center = {0, 0, -5};
    cell.half = cell.bounds_half = glm::vec3(0.1f);
    CHECK_FALSE(canvas.renderer.hidden(cell, {}));
    canvas.draw(Face{{8, 8, -2}, {9, 9, -2}, {0, 255, 0, 255}, 5});  // outside of the picture
    CHECK(canvas.renderer.hidden(cell, {}));
    cell.bounds_center.z = -2.9f;
    CHECK_FALSE(canvas.renderer.hidden(cell, {}));
    canvas.draw(Face{{-9, -9, -2}, {9, 9, -2}, {0, 255, 0, 255}, 5});
    CHECK(canvas.renderer.hidden(cell, {}));
    cell.bounds_half = glm::vec3(6);  // the eye is inside
    CHECK_FALSE(canvas.renderer.hidden(cell, {}));
}

TEST_CASE("background shows through in proportion", "[raster]") {
    Canvas canvas(straight(20, true), 1, {}, {0, 0, 200, 255});
    canvas.draw(Face{{-9, -9, -2}, {9, 9, -2}, {60, 0, 0, 128}, 5});
    const Rgba8 c = canvas.done().at(10, 10);
    CHECK(std::abs(c.r - 60) <= 1);
    CHECK(std::abs(c.b - 200 * 127 / 255) <= 1);
    CHECK(c.a == 255);
}
