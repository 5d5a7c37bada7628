#include "farfield/approximation/sided_tensor.hpp"

#include <string>
#include <vector>

#include "catch.hpp"
#include "farfield/approximation/sample_set.hpp"
#include "farfield/build.hpp"
#include "farfield/cost_model/triangle_count.hpp"
#include "farfield/partition/octree.hpp"
#include "farfield/renderer/z_buffer_renderer.hpp"
#include "farfield/sampler/grid_sampler.hpp"
#include "farfield/viewer.hpp"
#include "support/scenes.hpp"
#include "support/views.hpp"

using namespace farfield;
using namespace farfield::test;

namespace {

/// Red in front of blue, as seen from +x.
Triangles two_walls(float gap) {
    Triangles walls = sheet({0.3101f, -1, -1}, {0, 2, 0}, {0, 0, 2}, 20, 20, {255, 0, 0, 255});
    const Triangles behind = sheet({0.3101f - gap, -1, -1}, {0, 2, 0}, {0, 0, 2}, 20, 20, {0, 0, 255, 255});
    walls.insert(walls.end(), behind.begin(), behind.end());
    return walls;
}
struct Sink {
    float splat_limit_px;
    std::vector<Splat>* splats;
    std::vector<Face>* faces;
    void operator()(const Splat& s) const { splats->push_back(s); }
    void operator()(const Face& f) const { faces->push_back(f); }
    void operator()(OwnRun) const {}
};

template <class H>
double hidden_part(const Triangles& walls, float side) {
    const H h = build<H>(walls);
    ZBufferRenderer renderer;
    auto viewer = make_viewer(h, walls, renderer);
    View view = looking({20 * side, 0.3, 0.2}, {}, 96, 4);
    view.camera = Camera::perspective(view.camera.eye, {0, 0, 0}, {0, 1, 0}, 0.15f);
    viewer.frame(view);
    double shown = 0, hidden = 0;
    for (const Rgba8 c : renderer.image().pixels()) {
        shown += c.a > 250;
        hidden += c.a > 250 && (side > 0 ? c.b > c.r : c.r > c.b);
    }
    CHECK(shown > 100);
    return hidden / shown;
}

}  // namespace

TEST_CASE("what is in front gives the color, the tensor everything else", "[approximation]") {
    Cell cell;
    cell.center = cell.bounds_center = {0.3f, 0, 0};
    cell.half = cell.bounds_half = glm::vec3(1);
    const Triangles walls = two_walls(0.1f);
    const SidedTensor sided;
    GridSampler sampler;
    const auto contents = [&](auto&& sink) {
        for (const Triangle& t : walls) t.polygons(sink);
    };
    const auto data = sided.finish(cell, sided.sample(cell, contents, sampler));
    const auto plain = sided.tensor.finish(cell, sided.tensor.sample(cell, contents, sampler));
    CHECK(data.tensor == plain);
    for (const float side : {1.0f, -1.0f}) {
        const LocalView view(looking({9 * side, 0.5, 0.3}, {0.3, 0, 0}, 256, 1), glm::dvec3(0),
                             Box{glm::vec3(-4), glm::vec3(4)});
        for (const float limit : {2.0f, 0.0f}) {
            std::vector<Splat> splats, plain_splats;
            std::vector<Face> faces, plain_faces;
            sided.draw_stand_in(data, cell, view, Sink{limit, &splats, &faces});
            sided.tensor.draw_stand_in(plain, cell, view, Sink{limit, &plain_splats, &plain_faces});
            REQUIRE(splats.size() == plain_splats.size());
            REQUIRE(faces.size() == plain_faces.size());
            CHECK(splats.size() + faces.size() > 0);
            for (std::size_t i = 0; i < splats.size(); ++i) {
                CHECK(splats[i].size == plain_splats[i].size);
                CHECK(splats[i].opacity == plain_splats[i].opacity);
                CHECK(splats[i].rgb.a == plain_splats[i].rgb.a);
                CHECK((side > 0 ? splats[i].rgb.r : splats[i].rgb.b) > 230);
                CHECK((side > 0 ? splats[i].rgb.b : splats[i].rgb.r) < 25);
            }
            for (std::size_t i = 0; i < faces.size(); ++i) {
                CHECK(faces[i].rgba.a == plain_faces[i].rgba.a);
                CHECK((side > 0 ? faces[i].rgba.b : faces[i].rgba.r) <= faces[i].rgba.a / 10);
            }
        }
    }
}

TEST_CASE("a wall behind another one in the same cells is hidden", "[approximation]") {
    const Triangles walls = two_walls(0.001f);
    using Sided = SpatialHierarchy<Octree, SidedTensor, TriangleCount>;
    using SidedSamples = SpatialHierarchy<Octree, SampleSet<SidedTensor>, TriangleCount>;
    for (const float side : {1.0f, -1.0f}) {
        CHECK(hidden_part<Sided>(walls, side) <= 0.05);
        CHECK(hidden_part<SidedSamples>(walls, side) <= 0.05);
    }
}

TEST_CASE("numbers of samples that cannot be are refused", "[approximation]") {
    for (const std::uint32_t samples : {0u, 9u}) {
        CHECK(SidedTensor{.samples = samples}.wrong_option() == std::string("SidedTensor: samples must be 1 to 8"));
    }
    CHECK(SidedTensor{}.wrong_option() == nullptr);
}
