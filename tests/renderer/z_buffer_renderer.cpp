#include "farfield/renderer/z_buffer_renderer.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <glm/vec2.hpp>
#include <numeric>
#include <optional>
#include <span>
#include <stdexcept>
#include <vector>

#include "catch.hpp"
#include "support/pictures.hpp"
#include "support/random.hpp"
#include "support/scenes.hpp"
#include "support/views.hpp"

using namespace farfield;
using namespace farfield::test;

namespace {

/// Where the ray through a sample meets a triangle's plane: distance along `forward` and weights of the corners.
struct Hit {
    double depth = 0;
    glm::dvec3 weights{0};
    /// How far inside, in samples, roughly: negative outside.
    double inside = 0;
};
std::optional<Hit> meet(const std::array<glm::vec3, 3>& v, const LocalView& view, double px, double py) {
    const glm::dvec3 r(view.right), u(view.up), f(view.forward), eye(view.eye);
    const double sx = (px - view.width / 2.0) / double(view.focal_px),
                 sy = (view.height / 2.0 - py) / double(view.focal_px);
    const glm::dvec3 from = view.is_perspective ? eye : eye + r * sx + u * sy;
    const glm::dvec3 along = view.is_perspective ? f + r * sx + u * sy : f;
    const glm::dvec3 a(v[0]), b(v[1]), c(v[2]);
    const glm::dvec3 n = glm::cross(b - a, c - a);
    const double slope = glm::dot(n, along);
    if (slope == 0) return {};
    Hit hit;
    hit.depth = glm::dot(n, a - from) / slope;
    const glm::dvec3 p = from + along * hit.depth;
    const double whole = glm::dot(n, n);
    hit.weights = {glm::dot(n, glm::cross(c - b, p - b)) / whole, glm::dot(n, glm::cross(a - c, p - c)) / whole,
                   glm::dot(n, glm::cross(b - a, p - a)) / whole};
    // Weights to distances from edges on the screen, by looking at the neighbors.
    return hit;
}
/// Covered by a clear margin (1), clearly not (0), or too near to an edge to say (-1).
int clearly_covered(const std::array<glm::vec3, 3>& v, const LocalView& view, double px, double py, double margin) {
    int inside = 0, n = 0;
    for (const double dx : {-margin, 0.0, margin}) {
        for (const double dy : {-margin, 0.0, margin}) {
            const auto hit = meet(v, view, px + dx, py + dy);
            ++n;
            inside += hit && hit->depth >= double(view.near_depth) &&
                      std::min({hit->weights.x, hit->weights.y, hit->weights.z}) >= 0;
        }
    }
    return inside == n ? 1 : inside == 0 ? 0 : -1;
}

/// The picture of each triangle alone.
std::vector<Image> alone(const Triangles& triangles, const View& view, const ZBufferOptions& options = {}) {
    std::vector<Image> out;
    const LocalView local = local_view<Triangle>(triangles, view);
    ZBufferRenderer renderer(options);
    Source<Triangle> source{triangles, {}, std::uint32_t(triangles.size()), {}, 0};
    source.id = renderer.upload(source);
    for (std::uint32_t i = 0; i < triangles.size(); ++i) {
        renderer.begin_frame(local);
        renderer.set_view(local);
        const Range one{i, 1};
        renderer.draw(source, std::span<const Range>(&one, 1));
        renderer.end_frame();
        out.push_back(renderer.image());
    }
    return out;
}

/// How often each pixel is covered, as a count of pixels by number of triangles.
std::vector<int> times_covered(const Triangles& triangles, const View& view) {
    std::vector<int> times(std::size_t(view.width) * std::size_t(view.height));
    for (const Image& image : alone(triangles, view)) {
        for (std::size_t i = 0; i < times.size(); ++i) times[i] += image.pixels()[i].a == 255;
    }
    std::vector<int> histogram(4);
    for (const int t : times) ++histogram[std::size_t(std::min(t, 3))];
    return histogram;
}

View wide_view(glm::dvec3 eye, glm::dvec3 target, int width, int height, float fov = 1.2f) {
    View view;
    view.camera = Camera::perspective(eye, target, {0, 1, 0}, fov);
    view.width = width;
    view.height = height;
    return view;
}

}  // namespace

TEST_CASE("an oblique sheet of many triangles covers each sample once", "[raster]") {
    Triangles triangles = sheet({-30, -20, -3}, {60, 5, -4}, {-2, 40, 3}, 9, 7, {255, 255, 255, 255});
    // Interior corners anywhere, the same for all that share them.
    for (Triangle& t : triangles) {
        for (glm::vec3& v : t.vertices) {
            Random random(std::uint64_t(std::int64_t(std::lround(v.x * 64))) * 1000003u +
                          std::uint64_t(std::int64_t(std::lround(v.y * 64))));
            v += glm::vec3(random.between(-1, 1), random.between(-1, 1), random.between(-0.2f, 0.2f));
        }
    }
    for (const View& view :
         {wide_view({0, 0, 2}, {0, 0, -3}, 64, 64), wide_view({1, 2, 3}, {0, 1, -3}, 65, 33),
          wide_view({0.5, 0.5, -1.9}, {0, 0, -3}, 17, 64), looking_orthographic({0, 0, 5}, {0.1, 0.2, -3}, 3, 61)}) {
        const auto histogram = times_covered(triangles, view);
        INFO("eye at " << view.camera.eye.z << ": " << histogram[0] << " gaps, " << histogram[2] + histogram[3]
                       << " overlaps");
        CHECK(histogram[1] == view.width * view.height);
    }
}

TEST_CASE("a ground that runs under the eye and behind it has no gap and no overlap", "[raster]") {
    for (const float extent : {30.0f, 3e4f, 3e6f}) {
        const Triangles ground =
            sheet({-extent, 0, extent}, {2 * extent, 0, 0}, {0, 0, -2 * extent}, 5, 5, {255, 255, 255, 255});
        for (const double height : {0.5, 0.01}) {
            // Straight down a part of it is at the feet; the horizon lies above the picture.
            for (const glm::dvec3 at : {glm::dvec3(0, 0, -0.6), glm::dvec3(0.3, 0, -0.2), glm::dvec3(0, 0, 1)}) {
                View view = wide_view({0.1, height, 0.2}, glm::dvec3(0.1, 0, 0.2) + at * height, 64, 48, 0.8f);
                view.camera.near_depth = float(height) * 1e-2f;
                const auto histogram = times_covered(ground, view);
                INFO("extent " << extent << ", height " << height << ": " << histogram[0] << " gaps, "
                               << histogram[2] + histogram[3] << " overlaps");
                CHECK(histogram[1] == 64 * 48);
            }
        }
    }
}

TEST_CASE("triangles much larger than the picture have no gap and no overlap", "[raster]") {
    Random random(60);
    for (int round = 0; round < 30; ++round) {
        const float far = std::pow(10.0f, random.between(1, 6));
        Triangles fan;
        const glm::vec3 center(random.between(-0.5f, 0.5f), random.between(-0.5f, 0.5f), -2);
        std::vector<glm::vec3> rim;
        const int n = 3 + int(random.below(9));
        for (int i = 0; i < n; ++i) {
            const float angle = 6.2831853f * (float(i) + 0.8f * random.unit()) / float(n);
            rim.push_back({far * std::cos(angle), far * std::sin(angle), -2});
        }
        for (int i = 0; i < n; ++i)
            fan.push_back({{center, rim[std::size_t(i)], rim[std::size_t((i + 1) % n)]}, {255, 255, 255, 255}});
        for (View view :
             {wide_view({0, 0, 0}, {0.3, 0.2, -1}, 48, 40), looking_orthographic({0, 0, 0}, {0, 0, -2}, 2, 40)}) {
            view.camera.near_depth = 0.01f;
            const auto histogram = times_covered(fan, view);
            INFO("round " << round << ", " << n << " triangles to " << far);
            CHECK(histogram[1] == view.width * view.height);
        }
    }
}

TEST_CASE("the nearest triangle wins, as rays say", "[raster]") {
    Triangles triangles = random_triangles(150, 61, 0.5f);
    append(triangles, random_triangles(10, 62, 3.0f));
    for (const View& view :
         {wide_view({2.5, 1, 2}, {0, 0, 0}, 60, 50), wide_view({0.2, 0.1, 0.1}, {1, 0.2, 0.3}, 60, 50),
          looking_orthographic({2, 2, 3}, {0, 0, 0}, 2.5f, 50), looking_orthographic({0, 0, 0}, {1, 1, 0}, 2, 50)}) {
        const LocalView local = local_view<Triangle>(triangles, view);
        const Image image = plain_picture<Triangle>(triangles, view);
        int wrong = 0, unclear = 0;
        for (int y = 0; y < view.height; ++y) {
            for (int x = 0; x < view.width; ++x) {
                const double px = x + 0.5, py = y + 0.5;
                double nearest = 1e30, maybe = 1e30, second = 1e30;
                Rgba8 color{0, 0, 0, 0};
                for (const Triangle& t : triangles) {
                    const int covered = clearly_covered(t.vertices, local, px, py, 0.01);
                    const auto hit = meet(t.vertices, local, px, py);
                    if (covered < 0 && hit) maybe = std::min(maybe, hit->depth - 1e-3);
                    if (covered != 1) continue;
                    if (hit->depth < nearest) {
                        second = nearest;
                        nearest = hit->depth;
                        color = t.rgba;
                    } else {
                        second = std::min(second, hit->depth);
                    }
                }
                if (maybe < nearest || second - nearest < 2e-4 * (1 + std::abs(nearest))) {
                    ++unclear;
                    continue;
                }
                wrong += image.at(x, y) != color;
            }
        }
        INFO(unclear << " samples too near to an edge");
        CHECK(wrong == 0);
        CHECK(unclear < view.width * view.height / 5);
    }
}

// The near plane stands 2^-16 of the scene's diagonal in front of the eye: there 1/depth is 65536 times what it is at
// the other end of the scene, and must still be right at that end.
TEST_CASE("depth is right far away on a polygon that begins at the near plane", "[raster]") {
    Triangles scene = sheet({-50, 0, 50}, {100, 0, 0}, {0, 0, -100}, 1, 1, {200, 0, 0, 255});
    // A carpet a thousandth of its distance above the ground, at every distance.
    for (float z = -1; z > -45; z *= 1.3f) {
        const float height = -z * 2e-3f;
        append(scene, sheet({-1, height, z}, {2, 0, 0}, {0, 0, 0.2f * z}, 1, 1, {0, 200, 0, 255}));
    }
    for (const double eye : {1.6, 0.5, 0.1}) {
        const View view = wide_view({0, eye, 0}, {0, eye * 0.8, -3}, 400, 400, 0.9f);
        const LocalView local = local_view<Triangle>(scene, view);
        const Image image = plain_picture<Triangle>(scene, view);
        int wrong = 0, on_carpet = 0;
        for (int y = 0; y < view.height; ++y) {
            for (int x = 0; x < view.width; ++x) {
                bool carpet = false;
                for (std::size_t i = 2; i < scene.size() && !carpet; ++i) {
                    carpet = clearly_covered(scene[i].vertices, local, x + 0.5, y + 0.5, 0.1) == 1;
                }
                on_carpet += carpet;
                wrong += carpet && image.at(x, y).g == 0;
            }
        }
        INFO("eye at " << eye << ", " << on_carpet << " samples on a carpet");
        CHECK(on_carpet > 100);
        CHECK(wrong == 0);
    }
}

TEST_CASE("the picture does not depend on the order of primitives", "[raster]") {
    Triangles triangles = mixed_triangles(3000, 63);
    const View view = wide_view({2, 1, 2}, {0, 0, 0}, 90, 80);
    const ZBufferOptions options{.samples = 4, .light = DirectionalLight{}};
    const Image first = plain_picture<Triangle>(triangles, view, options);
    Random random(64);
    for (int i = 0; i < 3; ++i) {
        random.shuffle(triangles);
        CHECK(different_pixels(plain_picture<Triangle>(triangles, view, options), first) == 0);
    }
}

TEST_CASE("the picture does not depend on the order of translucent primitives", "[raster]") {
    Triangles triangles = random_triangles(800, 65, 0.3f);
    Random random(66);
    for (Triangle& t : triangles) t.rgba.a = std::uint8_t(30 + random.below(200));
    const View view = wide_view({2, 1, 2}, {0, 0, 0}, 64, 64);
    const Image first = plain_picture<Triangle>(triangles, view);
    random.shuffle(triangles);
    CHECK(different_pixels(plain_picture<Triangle>(triangles, view), first) == 0);
}

TEST_CASE("one, four and eight lanes give the same picture", "[raster]") {
    Triangles triangles = mixed_triangles(5003, 67);
    append(triangles, sheet({-100, -1, 100}, {200, 0, 0}, {0, 0, -200}, 2, 2, {90, 90, 90, 255}));
    for (const View& view : {wide_view({2, 1, 2}, {0, 0, 0}, 111, 77), wide_view({0, 0, 0}, {1, 0.1, 0}, 64, 64),
                             looking_orthographic({1, 1, 1}, {0, 0, 0}, 1, 70)}) {
        Image by_simd[3];
        int i = 0;
        for (const Simd simd : {Simd::scalar, Simd::four_lanes, Simd::eight_lanes}) {
            by_simd[i++] =
                plain_picture<Triangle>(triangles, view, {.samples = 4, .light = DirectionalLight{}, .simd = simd});
        }
        CHECK(by_simd[0] == by_simd[1]);
        CHECK(by_simd[0] == by_simd[2]);
        CHECK(coverage(by_simd[0]) > 100);
    }
}

TEST_CASE("ranges that begin and end anywhere draw just their primitives", "[raster]") {
    const Triangles triangles = random_triangles(64, 68, 0.3f);
    const View view = wide_view({2, 1, 2}, {0, 0, 0}, 40, 40);
    const LocalView local = local_view<Triangle>(triangles, view);
    ZBufferRenderer renderer;
    Source<Triangle> source{triangles, {}, 64, {}, 0};
    source.id = renderer.upload(source);
    for (std::uint32_t first = 0; first < 20; ++first) {
        for (std::uint32_t count = 0; count <= 20; ++count) {
            renderer.begin_frame(local);
            renderer.set_view(local);
            const Range r{first, count};
            renderer.draw(source, std::span<const Range>(&r, 1));
            renderer.end_frame();
            // The same triangles elsewhere: the others stay where they are and go flat.
            Triangles only = triangles;
            for (std::uint32_t i = 0; i < 64; ++i) {
                if (i < first || i >= first + count) only[i].vertices[1] = only[i].vertices[2] = only[i].vertices[0];
            }
            Source<Triangle> other{only, {}, 64, {}, 0};
            ZBufferRenderer plain;
            other.id = plain.upload(other);
            plain.begin_frame(local);
            plain.set_view(local);
            const Range all{0, 64};
            plain.draw(other, std::span<const Range>(&all, 1));
            plain.end_frame();
            CHECK(renderer.image() == plain.image());
        }
    }
}

TEST_CASE("more samples a pixel are the box-filtered picture of so many times the size", "[raster]") {
    const Triangles triangles = random_triangles(300, 69, 0.3f);
    for (const int side : {1, 2, 3, 4, 5, 6, 7, 8}) {
        View view = wide_view({2, 1, 2}, {0, 0, 0}, 24 * side, 18 * side);
        const Image large = plain_picture<Triangle>(triangles, view);
        view.width = 24;
        view.height = 18;
        const Image filtered = plain_picture<Triangle>(triangles, view, {.samples = side * side});
        int wrong = 0;
        for (int y = 0; y < 18; ++y) {
            for (int x = 0; x < 24; ++x) {
                int sum[4] = {};
                for (int i = 0; i < side * side; ++i) {
                    const Rgba8 c = large.at(x * side + i % side, y * side + i / side);
                    sum[0] += c.r, sum[1] += c.g, sum[2] += c.b, sum[3] += c.a;
                }
                const Rgba8 c = filtered.at(x, y);
                const int got[4] = {c.r, c.g, c.b, c.a};
                for (int k = 0; k < 4; ++k) wrong += std::abs(got[k] - double(sum[k]) / (side * side)) > 0.502;
            }
        }
        INFO(side << " samples a side");
        CHECK(wrong == 0);
    }
}

TEST_CASE("only squares of 1 to 8 are numbers of samples, and pictures have a size", "[raster]") {
    for (const int samples : {-1, 0, 2, 3, 5, 8, 63, 65, 81, 100}) {
        CHECK_THROWS_AS(ZBufferRenderer(ZBufferOptions{.samples = samples}), std::invalid_argument);
    }
    const Triangles triangles = random_triangles(3, 70);
    for (const int width : {-1, 0, 16001, 2'000'000'000}) {
        View view;
        view.width = width;
        CHECK_THROWS_AS(plain_picture<Triangle>(triangles, view), std::invalid_argument);
    }
}

TEST_CASE("colors at corners are interpolated as rays say", "[raster]") {
    Random random(71);
    for (int round = 0; round < 40; ++round) {
        VertexColoredTriangle t;
        // The last ones pass the eye.
        for (glm::vec3& v : t.vertices) v = random.in_cube(1) + glm::vec3(0, 0, -2.2f);
        if (round >= 30) t.vertices[2] += glm::vec3(0, 0, 4);
        for (Rgba8& c : t.rgba) c = random.color();
        const std::vector<VertexColoredTriangle> triangles{t};
        View view = round % 5 == 4 ? looking_orthographic({0, 0, 2}, {0, 0, -2}, 2, 100)
                                   : wide_view({0, 0, 0}, {0, 0, -1}, 100, 100);
        const LocalView local = local_view<VertexColoredTriangle>(triangles, view);
        const Image image = plain_picture<VertexColoredTriangle>(triangles, view);
        int wrong = 0, compared = 0;
        for (int y = 0; y < 100; ++y) {
            for (int x = 0; x < 100; ++x) {
                if (clearly_covered(t.vertices, local, x + 0.5, y + 0.5, 0.2) != 1) continue;
                const auto hit = meet(t.vertices, local, x + 0.5, y + 0.5);
                // Corners are snapped by half of 1/256 sample: what the color changes over that.
                const auto beside = meet(t.vertices, local, x + 0.5 + 1.0 / 256, y + 0.5 + 1.0 / 256);
                const Rgba8 got = image.at(x, y);
                const auto channel = [&](std::uint8_t Rgba8::*c, const Hit& h) {
                    return h.weights.x * t.rgba[0].*c + h.weights.y * t.rgba[1].*c + h.weights.z * t.rgba[2].*c;
                };
                ++compared;
                for (const auto c : {&Rgba8::r, &Rgba8::g, &Rgba8::b}) {
                    const double slack = std::abs(channel(c, *beside) - channel(c, *hit));
                    wrong += std::abs(channel(c, *hit) - double(got.*c)) > 1.01 + slack;
                }
            }
        }
        INFO("round " << round << ", " << compared << " samples");
        CHECK(wrong == 0);
    }
}

TEST_CASE("what is translucent covers its part of the samples", "[raster]") {
    for (const int alpha : {1, 13, 64, 128, 200, 254}) {
        Triangles wall = sheet({-9, -9, -3}, {18, 0, 0}, {0, 18, 0}, 1, 1, {255, 255, 255, std::uint8_t(alpha)});
        const View view = wide_view({0, 0, 0}, {0, 0, -1}, 64, 64);
        const ZBufferOptions options{.samples = 64};
        const double samples = 64 * 64 * 64;
        const double one = coverage(plain_picture<Triangle>(wall, view, options)) / (64 * 64);
        const double a = alpha / 255.0;
        CHECK(std::abs(one - a) < 5 * std::sqrt(a * (1 - a) / samples) + 0.004);
        // A second one covers others.
        append(wall, moved(wall, 1, {0, 0, -0.5f}));
        const double two = coverage(plain_picture<Triangle>(wall, view, options)) / (64 * 64);
        const double both = 1 - (1 - a) * (1 - a);
        CHECK(std::abs(two - both) < 5 * std::sqrt(both * (1 - both) / samples) + 0.006);
    }
}

TEST_CASE("a polygon is lit on the side that is seen", "[raster]") {
    const DirectionalLight light{{0, 0, 1}, 0.25f, 0.5f};
    const Triangles wall = sheet({-9, -9, 0}, {18, 0, 0}, {0, 18, 0}, 1, 1, {200, 100, 40, 255});
    Triangles turned = wall;
    for (Triangle& t : turned) std::swap(t.vertices[1], t.vertices[2]);
    for (const Triangles& triangles : {wall, turned}) {
        for (const bool orthographic : {false, true}) {
            const auto from = [&](double z) {
                const View view =
                    orthographic ? looking_orthographic({0, 0, z}, {0, 0, 0}, 1, 8) : looking({0, 0, z}, {0, 0, 0}, 8);
                return plain_picture<Triangle>(triangles, view, {.light = light}).at(4, 4);
            };
            CHECK(from(3) == Rgba8{150, 75, 30, 255});
            CHECK(from(-3) == Rgba8{50, 25, 10, 255});
        }
    }
}

TEST_CASE("back faces are culled where that was asked for", "[raster]") {
    const Triangles wall = sheet({-9, -9, 0}, {18, 0, 0}, {0, 18, 0}, 1, 1, {200, 100, 40, 255});
    const ZBufferOptions options{.culls_back_faces = true};
    CHECK(coverage(plain_picture<Triangle>(wall, looking({0, 0, 3}, {}, 8), options)) == 64);
    CHECK(coverage(plain_picture<Triangle>(wall, looking({0, 0, -3}, {}, 8), options)) == 0);
    CHECK(coverage(plain_picture<Triangle>(wall, looking({0, 0, -3}, {}, 8))) == 64);
    const Triangles ball = sphere({0, 0, 0}, 1, 20, {255, 255, 255, 255});
    const View view = looking({3, 1, 2}, {}, 64);
    CHECK(plain_picture<Triangle>(ball, view, options) == plain_picture<Triangle>(ball, view));
}

TEST_CASE("nothing nearer than the near plane is drawn, and nothing is too far", "[raster]") {
    const Triangles walls = [] {
        Triangles t = sheet({-1, -1, -1}, {2, 0, 0}, {0, 2, 0}, 1, 1, {255, 0, 0, 255});
        append(t, sheet({-1e7f, -1e7f, -1e6f}, {2e7f, 0, 0}, {0, 2e7f, 0}, 1, 1, {0, 255, 0, 255}));
        return t;
    }();
    View view = wide_view({0, 0, 0}, {0, 0, -1}, 8, 8, 0.5f);
    // Default: 2^-16 of a scene of 30,000 km lies behind the wall in front.
    view.camera.near_depth = 0.99f;
    CHECK(plain_picture<Triangle>(walls, view).at(4, 4) == Rgba8{255, 0, 0, 255});
    view.camera.near_depth = 1.01f;
    CHECK(plain_picture<Triangle>(walls, view).at(4, 4) == Rgba8{0, 255, 0, 255});
    view.camera.near_depth = 1.01e6f;
    CHECK(plain_picture<Triangle>(walls, view).at(4, 4).a == 0);
}

TEST_CASE("one frame after the other is as good as each by a renderer of its own", "[raster]") {
    const Triangles triangles = mixed_triangles(600, 72);
    Random random(73);
    const ZBufferOptions options{.samples = 4, .background = {30, 10, 50, 200}};
    ZBufferRenderer kept(options);
    Source<Triangle> source{triangles, {}, std::uint32_t(triangles.size()), {}, 0};
    source.id = kept.upload(source);
    for (int frame = 0; frame < 60; ++frame) {
        View view = wide_view(random.in_cube(4), random.in_cube(1), 64, 48);
        if (frame % 7 == 6) view.camera.forward = -view.camera.forward;  // often nothing in sight
        if (frame % 11 == 10) view.width = 40 + int(random.below(30));
        const LocalView local = local_view<Triangle>(triangles, view);
        std::vector<Splat> splats;
        std::vector<Face> faces;
        for (int i = 0; i < (frame % 3 == 0 ? 0 : 40); ++i) {
            splats.push_back(
                {random.in_cube(1), glm::vec2(0.03f), 0.8f, {200, 100, 50, std::uint8_t(random.below(3))}});
            const glm::vec3 low = random.in_cube(1);
            faces.push_back({low, low + glm::vec3(0.2f, 0.2f, 0), {100, 100, 20, 120}, std::uint8_t(5)});
        }
        Range some{random.below(300), random.below(300)};
        if (frame % 5 < 3) some.law = AreaLaw(frame % 5);
        const auto draw = [&](ZBufferRenderer& renderer, const Source<Triangle>& from) {
            renderer.begin_frame(local);
            renderer.set_view(local);
            renderer.draw(from, std::span<const Range>(&some, 1));
            renderer.draw(std::span<const Splat>(splats));
            if (frame % 2 == 0) renderer.draw(std::span<const Face>(faces));
            renderer.end_frame();
        };
        draw(kept, source);
        ZBufferRenderer fresh(options);
        Source<Triangle> again = source;
        again.id = fresh.upload(again);
        draw(fresh, again);
        INFO("frame " << frame);
        CHECK(kept.image() == fresh.image());
    }
}

TEST_CASE("a source that goes makes room for the next", "[raster]") {
    const Triangles one = random_triangles(10, 74), other = random_triangles(20, 75);
    ZBufferRenderer renderer;
    Source<Triangle> a{one, {}, 10, {}, 0}, b{other, {}, 20, {}, 0};
    a.id = renderer.upload(a);
    b.id = renderer.upload(b);
    CHECK(a.id != b.id);
    renderer.release(a.id);
    CHECK(renderer.upload(a) == a.id);
}

TEST_CASE("what is hidden in every sample changes none of them", "[renderer]") {
    Random random(31);
    for (const int samples : {1, 4}) {
        ZBufferRenderer all(ZBufferOptions{.samples = samples}), seen(ZBufferOptions{.samples = samples});
        const LocalView view(looking({0, 0, 6}, {}, 64), {}, 4.0f);
        std::vector<Splat> splats(6000);
        for (Splat& s : splats) {
            s.center = random.in_cube(1);
            s.size = glm::vec2(random.between(0.02f, 0.12f), random.between(0.02f, 0.12f));
            s.opacity = random.between(0.2f, 1);
            s.rgb = random.color();
            s.rgb.a = std::uint8_t(random.below(3));
        }
        std::sort(splats.begin(), splats.end(), [](const Splat& a, const Splat& b) { return a.center.z > b.center.z; });
        for (ZBufferRenderer* r : {&all, &seen}) {
            r->begin_frame(view);
            r->set_view(view);
        }
        int hidden = 0, hidden_cells = 0, by_tiles = 0;
        for (const Splat& s : splats) {
            all.draw(std::span(&s, 1));
            // A cell that holds no more than the splat says less, and squares of 8 x 8 less still.
            Cell cell;
            cell.bounds_center = s.center;
            cell.bounds_half = glm::vec3(0.5f * s.size, 0);
            const bool is_hidden = seen.hidden_in_samples(s), is_hidden_cell = seen.hidden_in_samples(cell);
            CHECK((is_hidden || !is_hidden_cell));
            CHECK((is_hidden_cell || !seen.hidden(cell, {})));
            hidden += is_hidden;
            hidden_cells += is_hidden_cell;
            by_tiles += seen.hidden(cell, {});
            if (!is_hidden) seen.draw(std::span(&s, 1));
        }
        all.end_frame();
        seen.end_frame();
        CHECK(all.image() == seen.image());
        INFO(hidden << " splats, " << hidden_cells << " cells, " << by_tiles << " by tiles");
        CHECK(hidden > 1000);
        CHECK(hidden_cells > 100);
    }
}
