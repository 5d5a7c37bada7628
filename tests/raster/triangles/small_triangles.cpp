// Triangles smaller than a sample, deposited: against area, against 64 samples, and against what lies before and
// behind them.
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <optional>
#include <vector>

#include "catch.hpp"
#include "farfield/approximation/color_cube.hpp"
#include "farfield/approximation/exact.hpp"
#include "farfield/build.hpp"
#include "farfield/cost_model/triangle_count.hpp"
#include "farfield/partition/octree.hpp"
#include "farfield/renderer/z_buffer_renderer.hpp"
#include "farfield/viewer.hpp"
#include "support/pictures.hpp"
#include "support/scenes.hpp"

using namespace farfield;
using namespace farfield::detail;
using namespace farfield::test;

namespace {

/// Ranges of one source, one after the other.
template <class P>
Image picture(const std::vector<P>& primitives, std::vector<Range> ranges, const View& view,
              const ZBufferOptions& options = {}) {
    const LocalView local = local_view<P>(primitives, view);
    ZBufferRenderer renderer(options);
    Source<P> source{primitives, {}, std::uint32_t(primitives.size()), {}, 0};
    source.id = renderer.upload(source);
    renderer.begin_frame(local);
    renderer.set_view(local);
    for (const Range& r : ranges) renderer.draw(source, std::span<const Range>(&r, 1));
    renderer.end_frame();
    return renderer.image();
}
template <class P>
Image deposited(const std::vector<P>& primitives, AreaLaw law, const View& view, const ZBufferOptions& options = {}) {
    return picture(primitives, {{0, std::uint32_t(primitives.size()), law}}, view, options);
}

/// `size` samples of 1 seen squarely.
View facing(int size, double turned = 0) {
    return looking_orthographic({100 * std::sin(turned), 0, 100 * std::cos(turned)}, {0, 0, 0}, float(size), size, 1);
}

/// A square wall of n x n quads with corners shaken, the same for all that share them.
Triangles shaken_wall(float side, int n) {
    const float e = side / float(n);
    const auto at = [&](int i, int j) {
        Random random(std::uint64_t(i * 10007 + j));
        return glm::vec3((float(i) - 0.5f * float(n)) * e + e * random.between(-0.35f, 0.35f),
                         (float(j) - 0.5f * float(n)) * e + e * random.between(-0.35f, 0.35f), 0);
    };
    Triangles out;
    for (int j = 0; j < n; ++j) {
        for (int i = 0; i < n; ++i) {
            out.push_back({{at(i, j), at(i + 1, j), at(i + 1, j + 1)}, {200, 100, 50, 255}});
            out.push_back({{at(i, j), at(i + 1, j + 1), at(i, j + 1)}, {200, 100, 50, 255}});
        }
    }
    return out;
}

/// Right triangles of this area in the plane z, each at a place of its own, strewn over a square.
Triangles strewn(std::size_t count, float area, float side, std::uint64_t seed, float depth = 0) {
    Random random(seed);
    Triangles out(count);
    const float leg = std::sqrt(2 * area);
    for (std::size_t i = 0; i < count; ++i) {
        const glm::vec3 p(random.between(-0.5f, 0.5f) * side, random.between(-0.5f, 0.5f) * side,
                          depth * (0.5f - float(i) / float(count)));
        out[i] = {{p, p + glm::vec3(leg, 0, 0), p + glm::vec3(0, leg, 0)}, {255, 255, 255, 255}};
    }
    return out;
}

double mean_alpha(const Image& image, int margin) {
    double sum = 0;
    int n = 0;
    for (int y = margin; y < image.height() - margin; ++y) {
        for (int x = margin; x < image.width() - margin; ++x) sum += image.at(x, y).a, ++n;
    }
    return sum / (255.0 * n);
}

}  // namespace

TEST_CASE("a coherent wall of triangles of any size has no hole", "[raster]") {
    for (const float quad : {0.1f, 0.25f, 0.5f, 0.8f, 1.2f, 1.5f, 1.8f, 2.2f, 2.6f}) {
        const Triangles wall = shaken_wall(60, int(60 / quad));
        for (const double turned : {0.0, 0.5, 1.0}) {
            const Image image = deposited(wall, AreaLaw::coherent, facing(64, turned));
            const int reach = int(28 * std::cos(turned)) - 1;
            int least = 255, off_color = 0;
            for (int y = 5; y < 59; ++y) {
                for (int x = 32 - reach; x < 32 + reach; ++x) {
                    least = std::min<int>(least, image.at(x, y).a);
                    off_color += std::abs(image.at(x, y).r - 200) > 2 || std::abs(image.at(x, y).b - 50) > 2;
                }
            }
            INFO("quads of " << quad << " samples, turned by " << turned);
            CHECK(least >= 254);
            CHECK(off_color == 0);
        }
    }
}

TEST_CASE("a triangle alone covers its area, wherever it lies", "[raster]") {
    Random random(210);
    for (int i = 0; i < 300; ++i) {
        Triangle t;
        const glm::vec3 center(random.between(-5, 5), random.between(-5, 5), random.between(-5, 5));
        for (glm::vec3& v : t.vertices) v = center + random.in_cube(0.7f);
        t.rgba = {255, 255, 255, 255};
        const glm::vec3 n = glm::cross(t.vertices[1] - t.vertices[0], t.vertices[2] - t.vertices[0]);
        const double area = 0.5 * std::abs(double(n.z));
        for (const AreaLaw law : {AreaLaw::independent, AreaLaw::mixed}) {
            const double got = coverage(deposited(Triangles{t}, law, facing(16)));
            // Three by three samples, each rounded to 1/255, lanes before.
            CHECK(std::abs(got - area) < 0.02 + 0.02 * area);
        }
    }
}

TEST_CASE("leaves cover what 64 samples say they do, and less noisily than one", "[raster]") {
    for (const float area : {0.02f, 0.1f, 0.3f, 0.8f}) {
        for (const double density : {0.3, 1.0, 2.0}) {
            const Triangles leaves = strewn(std::size_t(density * 60 * 60 / double(area)), area, 60, 211, 5);
            const View view = facing(64);
            const std::vector<Range> all{{0, std::uint32_t(leaves.size()), {}}};
            const Image finest = picture(leaves, all, view, {.samples = 64}), point = picture(leaves, all, view);
            const Image image = deposited(leaves, AreaLaw::independent, view);
            INFO("area " << area << ", density " << density);
            CHECK(mean_alpha(image, 4) == Approx(mean_alpha(finest, 4)).epsilon(0.03));
            CHECK(mean_alpha(finest, 4) == Approx(1 - std::exp(-density)).epsilon(0.04));
            CHECK(rms_difference(image, finest) < 0.5 * rms_difference(point, finest));
        }
    }
}

TEST_CASE("through a hierarchy leaves are less than half as wrong as with one sample", "[raster]") {
    using Cubes = SpatialHierarchy<Octree, ColorCube, TriangleCount>;
    const Triangles leaves = random_triangles(20000, 212, 0.012f);
    const Cubes h = build<Cubes>(leaves, {.partition = Octree{}, .approximation = ColorCube{.guesses_area_law = true}});
    for (const double distance : {2.5, 4.0, 6.0}) {
        const View view = looking({distance, 0.4 * distance, 0.5 * distance}, {}, 96, 0.5f);
        const auto drawn = [&](const ZBufferOptions& options) {
            ZBufferRenderer renderer(options);
            make_viewer(h, leaves, renderer).frame(view);
            return renderer.image();
        };
        const Image finest = plain_picture<Triangle>(leaves, view, {.samples = 64});
        const double with = rms_difference(drawn({}), finest),
                     without = rms_difference(drawn({.deposits_small_triangles = false}), finest);
        INFO("from " << distance << ": " << with << " with deposits, " << without << " without");
        CHECK(with < 0.5 * without);
    }
}

TEST_CASE("one, four and eight lanes deposit the same", "[raster]") {
    Triangles triangles = mixed_triangles(5003, 213);
    append(triangles, random_triangles(9001, 214, 0.02f));
    for (const View& view : {looking({2, 1, 2}, {}, 77), looking({0, 0, 0}, {1, 0.1, 0}, 64),
                             looking_orthographic({1, 1, 1}, {}, 1, 70)}) {
        for (const AreaLaw law : {AreaLaw::independent, AreaLaw::mixed, AreaLaw::coherent}) {
            for (const bool culls : {false, true}) {
                ZBufferOptions options{.light = DirectionalLight{}, .culls_back_faces = culls, .simd = Simd::scalar};
                const Image one = deposited(triangles, law, view, options);
                options.simd = Simd::four_lanes;
                CHECK(deposited(triangles, law, view, options) == one);
                options.simd = Simd::eight_lanes;
                CHECK(deposited(triangles, law, view, options) == one);
                CHECK(coverage(one) > 100);
            }
        }
    }
}

TEST_CASE("what lies in front of small triangles hides them, and they hide what lies behind, in any order of runs",
          "[raster]") {
    const Rgba8 red{200, 0, 0, 255}, green{0, 200, 0, 255};
    for (const AreaLaw law : {AreaLaw::coherent, AreaLaw::independent}) {
        for (const bool in_front : {false, true}) {
            // Enough of them to close every sample, whatever the law.
            Triangles triangles;
            for (int sheets = 0; sheets < 12; ++sheets) {
                append(triangles, sheet({-6, -6, -0.01f * float(sheets)}, {12, 0, 0}, {0, 12, 0}, 30, 30, green));
            }
            const auto small = std::uint32_t(triangles.size());
            append(triangles, sheet({-6, -6, in_front ? 1.0f : -1.0f}, {12, 0, 0}, {0, 12, 0}, 1, 1, red));
            const auto all = std::uint32_t(triangles.size());
            for (const std::optional<AreaLaw>& of_large : {std::optional<AreaLaw>(), std::optional<AreaLaw>(law)}) {
                const Range deposits{0, small, law}, large{small, all - small, of_large};
                const Image one = picture(triangles, {deposits, large}, facing(10));
                const Image other = picture(triangles, {large, deposits}, facing(10));
                INFO("law " << int(law) << (in_front ? ", in front" : ", behind"));
                for (int y = 0; y < 10; ++y) {
                    for (int x = 0; x < 10; ++x) {
                        for (const Image* image : {&one, &other}) {
                            const Rgba8 c = image->at(x, y);
                            CHECK(c.a == 255);
                            CHECK((in_front ? c == red : c.g >= 195 && c.r <= 5));
                        }
                    }
                }
            }
        }
    }
}

TEST_CASE("half-covering leaves let half of what lies behind through", "[raster]") {
    // One square of two triangles in the middle of every sample, half as large.
    Triangles triangles;
    for (int y = -6; y < 6; ++y) {
        for (int x = -6; x < 6; ++x) {
            const float side = std::sqrt(0.5f), corner = 0.5f - 0.5f * side;
            append(triangles, sheet({float(x) + corner, float(y) + corner, 0}, {side, 0, 0}, {0, side, 0}, 1, 1,
                                    {255, 0, 0, 255}));
        }
    }
    const auto small = std::uint32_t(triangles.size());
    append(triangles, sheet({-9, -9, -1}, {18, 0, 0}, {0, 18, 0}, 1, 1, {0, 0, 255, 255}));
    const Image image = picture(triangles, {{0, small, AreaLaw::independent}, {small, 2, {}}}, facing(10));
    double red = 0, blue = 0;
    for (const Rgba8 c : image.pixels()) red += c.r / 25500.0, blue += c.b / 25500.0;
    CHECK(red + blue == Approx(1).margin(0.01));
    // The two halves' squares overlap: independent ones cover 1 - (1 - 1/4)^2 where both are.
    CHECK(red > 0.40);
    CHECK(red < 0.51);
}

TEST_CASE("with the option off, or no law, samples are points", "[raster]") {
    const Triangles triangles = mixed_triangles(4000, 215);
    for (const View& view : {looking({3, 1, 2}, {}, 64), looking_orthographic({1, 1, 1}, {}, 3, 70)}) {
        const Image plain = plain_picture<Triangle>(triangles, view);
        CHECK(deposited(triangles, AreaLaw::independent, view, {.deposits_small_triangles = false}) == plain);
        CHECK(plain_picture<Triangle>(triangles, view, {.deposits_small_triangles = false}) == plain);
        CHECK(deposited(triangles, AreaLaw::independent, view) != plain);
    }
}

TEST_CASE("back faces are not deposited where they are culled", "[raster]") {
    const Triangles wall = sheet({-5, -5, 0}, {10, 0, 0}, {0, 10, 0}, 30, 30, {200, 100, 40, 255});
    Triangles turned = wall;
    for (Triangle& t : turned) std::swap(t.vertices[1], t.vertices[2]);
    const ZBufferOptions options{.culls_back_faces = true};
    for (const AreaLaw law : {AreaLaw::coherent, AreaLaw::independent}) {
        CHECK(coverage(deposited(turned, law, facing(8), options)) == 0);
        CHECK(coverage(deposited(wall, law, facing(8), options)) > 30);
        CHECK(coverage(deposited(turned, law, facing(8))) > 30);
        CHECK(deposited(wall, law, facing(8), options) == deposited(wall, law, facing(8)));
    }
}

TEST_CASE("small triangles have the light of the side that is seen, the mean of their colors, and their alpha",
          "[raster]") {
    const DirectionalLight light{{0, 0, 1}, 0.25f, 0.5f};
    const Triangles wall = sheet({-5, -5, 0}, {10, 0, 0}, {0, 10, 0}, 30, 30, {200, 100, 40, 255});
    const auto color = [&](const Triangles& triangles, double turned) {
        const Rgba8 c = deposited(triangles, AreaLaw::coherent, facing(8, turned), {.light = light}).at(4, 4);
        CHECK(c.a == 255);
        return c;
    };
    const auto close = [](Rgba8 a, Rgba8 b) {
        return std::abs(a.r - b.r) <= 1 && std::abs(a.g - b.g) <= 1 && std::abs(a.b - b.b) <= 1;
    };
    CHECK(close(color(wall, 0), {150, 75, 30, 255}));
    CHECK(close(color(wall, 3.14159265), {50, 25, 10, 255}));

    std::vector<VertexColoredTriangle> shaded;
    for (const Triangle& t : wall) {
        shaded.push_back({t.vertices, {Rgba8{240, 0, 0, 255}, Rgba8{0, 120, 0, 255}, Rgba8{0, 0, 60, 255}}});
    }
    CHECK(close(deposited(shaded, AreaLaw::independent, facing(8)).at(4, 4), [&] {
        const double a = deposited(shaded, AreaLaw::independent, facing(8)).at(4, 4).a / 255.0;
        return Rgba8{std::uint8_t(80 * a + 0.5), std::uint8_t(40 * a + 0.5), std::uint8_t(20 * a + 0.5), 255};
    }()));

    for (const int alpha : {0, 1, 64, 200, 255}) {
        Triangles one = strewn(1, 0.5f, 0, 216);
        one[0].rgba.a = std::uint8_t(alpha);
        const double got = coverage(deposited(one, AreaLaw::independent, facing(8)));
        CHECK(got == Approx(0.5 * alpha / 255).margin(0.02));
    }
}

TEST_CASE("triangles without area, outside of the picture or behind the eye deposit nothing", "[raster]") {
    const Rgba8 white{255, 255, 255, 255};
    const Triangles nothing{{{glm::vec3(0.3f), glm::vec3(0.3f), glm::vec3(0.3f)}, white},
                            {{glm::vec3(0), glm::vec3(0.25f, 0, 0), glm::vec3(0.5f, 0, 0)}, white},
                            {{glm::vec3(0), glm::vec3(0, 0, 0.5f), glm::vec3(0, 0, 1)}, white},
                            {{glm::vec3(60, 0, 0), glm::vec3(60.4f, 0, 0), glm::vec3(60, 0.4f, 0)}, white},
                            {{glm::vec3(0, -60, 0), glm::vec3(0.4f, -60, 0), glm::vec3(0, -60.4f, 0)}, white}};
    for (const AreaLaw law : {AreaLaw::coherent, AreaLaw::mixed, AreaLaw::independent}) {
        CHECK(coverage(deposited(nothing, law, facing(16))) == 0);
        const Triangles behind{{{glm::vec3(0, 0, 5), glm::vec3(0.01f, 0, 5), glm::vec3(0, 0.01f, 5)}, white}};
        CHECK(coverage(deposited(behind, law, looking({0, 0, 2}, {}, 16))) == 0);
    }
    // At the picture's edge the part inside counts.
    const Triangles edge{{{glm::vec3(8, 0, 0), glm::vec3(8.6f, -0.3f, 0), glm::vec3(7.4f, -0.3f, 0)}, white},
                         {{glm::vec3(8, 0, 0), glm::vec3(7.4f, 0.3f, 0), glm::vec3(8.6f, 0.3f, 0)}, white}};
    CHECK(coverage(deposited(edge, AreaLaw::independent, facing(16))) == Approx(0.18).margin(0.04));
}

TEST_CASE("nothing is hidden before the first deposit, and a closed sample hides what comes after", "[raster]") {
    Triangles triangles = sheet({-6, -6, 0}, {12, 0, 0}, {0, 12, 0}, 40, 40, {200, 100, 40, 255});
    const auto small = std::uint32_t(triangles.size());
    append(triangles, sheet({-6, -6, 0}, {12, 0, 0}, {0, 12, 0}, 1, 1, {200, 100, 40, 255}));
    const LocalView local = local_view<Triangle>(triangles, facing(10));
    Cell behind;
    behind.center = behind.bounds_center = {0, 0, -5};
    behind.half = behind.bounds_half = glm::vec3(1);
    ZBufferRenderer renderer;
    Source<Triangle> source{triangles, {}, std::uint32_t(triangles.size()), {}, 0};
    source.id = renderer.upload(source);
    const auto draw = [&](Range r) { renderer.draw(source, std::span<const Range>(&r, 1)); };
    for (int frame = 0; frame < 2; ++frame) {
        renderer.begin_frame(local);
        renderer.set_view(local);
        draw({small, 2, AreaLaw::coherent});  // large: no deposit, whatever its law
        CHECK(!renderer.hidden(behind, {}));
        draw({0, small, AreaLaw::coherent});
        CHECK(renderer.hidden(behind, {}));
        renderer.end_frame();
    }
}
