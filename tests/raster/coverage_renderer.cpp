#include "farfield/raster/coverage_renderer.hpp"

#include "catch.hpp"
#include "farfield/geometry/triangle.hpp"
#include "farfield/raster/z_buffer_renderer.hpp"
#include "support/pictures.hpp"
#include "support/random.hpp"
#include "support/scenes.hpp"

namespace farfield::test {
namespace {

/// Every primitive in the user's order.
template <class R, class P>
Image picture(R& renderer, std::span<const P> primitives, const View& view) {
    glm::dvec3 origin;
    const LocalView local = local_view(primitives, view, origin);
    Source<P> source{primitives, {}, std::uint32_t(primitives.size()), origin, 0};
    source.id = renderer.page_in(source);
    renderer.begin_frame(local);
    renderer.set_view(local);
    const Range all{0, source.item_count};
    renderer.draw(source, std::span<const Range>(&all, 1));
    renderer.end_frame();
    renderer.page_out(source.id);
    return renderer.image();
}

struct Points : LazyCoverage {
    using samples = SinglePixels;
};
using LazyPoints = BasicCoverageRenderer<Points>;

const std::vector<View>& views() {
    static const std::vector<View> all = [] {
        std::vector<View> v{looking({0, 0, 4}), looking({2, 1.5, 2.5}), looking({0.1, 0.2, 0.3}, {1, 0.5, 0.2}),
                            looking_orthographic({1, 2, 3})};
        v.push_back(looking({1.5, 0.3, 0.2}, {0, 0, 0}, 200));
        v.back().width = 333;
        return v;
    }();
    return all;
}

}  // namespace

TEST_CASE("lazy masks give the samples of a z-buffer, whatever the order") {
    const std::vector<std::pair<const char*, Triangles>> scenes = {
        {"small", random_triangles(3000, 1)},  {"large", random_triangles(200, 2, 0.7f)},
        {"mixed", mixed_triangles(2000, 3)},   {"sphere", sphere(glm::vec3(0.1f), 0.8f, 20, {200, 100, 50, 255})},
        {"one", random_triangles(1, 4, 0.9f)}, {"huge", random_triangles(40, 5, 30.0f)},
    };
    for (const auto& [name, triangles] : scenes) {
        for (const View& view : views()) {
            CAPTURE(name, view.camera.eye.x, view.width);
            const std::span<const Triangle> all(triangles);
            for (const Simd simd : {Simd::scalar, Simd::four_lanes, Simd::eight_lanes, Simd::sixteen_lanes}) {
                CAPTURE(int(simd));
                CoverageRenderer filtered({.simd = simd});
                CHECK(different_pixels(picture(filtered, all, view), plain_picture(all, view, {.samples = 64})) == 0);
                LazyPoints points({.simd = simd});
                CHECK(different_pixels(picture(points, all, view), plain_picture(all, view)) == 0);
            }
        }
    }
}

}  // namespace farfield::test
