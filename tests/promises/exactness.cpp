// Without tolerance a hierarchy must change nothing: every composable triple against a plain loop over the primitives.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "catch.hpp"
#include "support/pictures.hpp"
#include "support/scenes.hpp"
#include "support/variants.hpp"

using namespace farfield;
using namespace farfield::test;

namespace {

std::vector<View> views_of(int size) {
    std::vector<View> views{looking({3, 1, 2}, {}, size),
                            looking({0.2, 0.1, 0.3}, {1, 0.3, -0.4}, size),
                            looking({1.2, -0.4, 0.1}, {0, 0, 0}, size),
                            looking({0, 9, 0}, {0, 0, 0.1}, size),
                            looking_orthographic({2, 3, 4}, {}, 3, size),
                            looking_orthographic({0, 0, 0}, {1, 0, 0}, 0.7f, size)};
    views[1].height = size / 2 + 5;
    views[4].width = size + 33;
    return views;
}

/// Is a part of the triangle inside the frustum, by a margin? Clipped in double against planes moved inwards.
bool reaches_into_frustum(const Triangle& t, const LocalView& view, double margin) {
    std::vector<glm::dvec3> polygon(t.vertices.begin(), t.vertices.end());
    for (const glm::vec4& plane : view.planes) {
        std::vector<glm::dvec3> out;
        const auto inside = [&](glm::dvec3 p) { return glm::dot(glm::dvec3(plane), p) + double(plane.w) - margin; };
        for (std::size_t i = 0; i < polygon.size(); ++i) {
            const glm::dvec3 a = polygon[i], b = polygon[(i + 1) % polygon.size()];
            const double da = inside(a), db = inside(b);
            if (da >= 0) out.push_back(a);
            if ((da >= 0) != (db >= 0)) out.push_back(a + (b - a) * (da / (da - db)));
        }
        polygon = out;
    }
    return !polygon.empty();
}

}  // namespace

TEST_CASE("without tolerance the picture is that of a plain loop, byte for byte") {
    const Triangles triangles = mixed_triangles(6000, 1);
    for (const int samples : {1, 4}) {
        const ZBufferOptions options{.samples = samples, .background = {20, 40, 60, 255}, .light = DirectionalLight{}};
        std::vector<Image> plain;
        const std::vector<View> views = views_of(96);
        for (const View& view : views) plain.push_back(plain_picture<Triangle>(triangles, view, options));
        for (const Variant& variant : all_variants()) {
            const auto h = variant.build(triangles, *options.light);
            ZBufferRenderer renderer(options);
            const auto viewer = h->viewer(renderer);
            for (std::size_t i = 0; i < views.size(); ++i) {
                INFO(variant.name << ", view " << i << ", " << samples << " samples");
                const FrameStats stats = viewer->frame(views[i]);
                CHECK(stats.approximations == 0);
                CHECK(variant.is_plain(renderer.image(), plain[i]));
            }
        }
    }
}

TEST_CASE("without tolerance translucent triangles too look as in a plain loop") {
    Triangles triangles = random_triangles(1500, 2, 0.2f);
    Random random(3);
    for (Triangle& t : triangles) t.rgba.a = std::uint8_t(random.below(256));
    const View view = looking({3, 1, 2}, {}, 96);
    const Image plain = plain_picture<Triangle>(triangles, view);
    for (const Variant& variant : all_variants()) {
        INFO(variant.name);
        const Image picture = variant.build(triangles)->picture(view);
        if (variant.is_clipped) {
            // Which samples are let through is a hash of the polygon's own: of fragments others are, but as many.
            CHECK(std::abs(coverage(picture) / coverage(plain) - 1) < 0.02);
        } else {
            CHECK(picture == plain);
        }
    }
}

TEST_CASE("without tolerance every primitive in the frustum is handed over exactly once") {
    const Triangles triangles = mixed_triangles(5000, 4);
    for (const Variant& variant : all_variants()) {
        const auto h = variant.build(triangles);
        std::size_t view_index = 0;
        for (View view : views_of(200)) {
            INFO(variant.name << ", view " << view_index++);
            Recorder recorder;
            const FrameStats stats = h->frame(view, recorder);
            std::vector<int> times(triangles.size()), times_at(h->item_count());
            for (const auto& draw : recorder.draws) ++times[draw.primitive], ++times_at[draw.position];
            const std::vector<int>& once = variant.is_clipped ? times_at : times;
            CHECK(std::count_if(once.begin(), once.end(), [](int n) { return n > 1; }) == 0);
            CHECK(recorder.faces.empty());
            CHECK(recorder.splats.empty());
            CHECK(stats.primitives == recorder.draws.size());
            const LocalView local = local_view<Triangle>(triangles, view);
            std::size_t missing = 0;
            for (std::size_t i = 0; i < triangles.size(); ++i) {
                missing += times[i] == 0 && reaches_into_frustum(triangles[i], local, 1e-5);
            }
            CHECK(missing == 0);
        }
    }
}

TEST_CASE("with tolerance no primitive is handed over twice, nor stands in a cell's place twice") {
    const Triangles triangles = mixed_triangles(5000, 5);
    for (const Variant& variant : all_variants()) {
        const auto h = variant.build(triangles);
        for (const float tolerance : {0.5f, 2.0f, 8.0f}) {
            INFO(variant.name << ", tolerance " << tolerance);
            Recorder recorder;
            const FrameStats stats = h->frame(looking({20, 5, 10}, {}, 256, tolerance), recorder);
            std::vector<int> times(variant.is_clipped ? h->item_count() : triangles.size());
            for (const auto& draw : recorder.draws) ++times[variant.is_clipped ? draw.position : draw.primitive];
            CHECK(std::count_if(times.begin(), times.end(), [](int n) { return n > 1; }) == 0);
            CHECK(stats.primitives == recorder.draws.size());
            CHECK(stats.faces == recorder.faces.size());
            CHECK(stats.splats == recorder.splats.size());
            CHECK(stats.runs == recorder.ranges);
            if (tolerance == 8) CHECK((stats.approximations > 0) == variant.stands_in);
        }
    }
}

TEST_CASE("a frozen camera sees the same picture") {
    const Triangles triangles = random_triangles(6000, 8, 0.03f);
    for (const Variant& variant : all_variants()) {
        INFO(variant.name);
        const auto h = variant.build(triangles);
        ZBufferRenderer renderer(ZBufferOptions{.samples = 4});
        const auto viewer = h->viewer(renderer);
        const View view = looking({5, 1, 2}, {}, 128, 1.5f);
        viewer->frame(view);
        const Image first = renderer.image();
        viewer->frame(looking({-3, 0, 0}, {}, 128, 1.5f));
        viewer->frame(view);
        CHECK(renderer.image() == first);
    }
}
