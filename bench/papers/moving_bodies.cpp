// Greene 1996, section 6.2: bodies that tumble through a static building, 512 x 512 pixels of 64 samples, over several
// moments. What strict order over all bodies costs, which pieces of them have to be cut for every frame, against the
// lazy mode, which takes them in any order, and against the building alone.
#include <benchmark/benchmark.h>

#include <cstdint>
#include <glm/mat4x4.hpp>
#include <memory>
#include <span>
#include <vector>

#include "farfield/approximation/exact.hpp"
#include "farfield/build.hpp"
#include "farfield/cost_model/triangle_count.hpp"
#include "farfield/merged_viewer.hpp"
#include "farfield/partition/nested.hpp"
#include "farfield/partition/octree.hpp"
#include "farfield/partition/polygon_bsp.hpp"
#include "farfield/primitive/instance.hpp"
#include "farfield/renderer/coverage_renderer.hpp"
#include "farfield/viewer.hpp"
#include "scenes/generate/sphere.hpp"
#include "scenes/generate/tumbling_hall.hpp"

using namespace farfield;

namespace {

using P = VertexColoredTriangle;
using H = SpatialHierarchy<Nested<Octree, PolygonBsp>, Exact, TriangleCount>;
using Body = Instance<H, P>;
using Root = SpatialHierarchy<Octree, Exact, TriangleCount>;

constexpr int moments = 6;

/// As the scene has them, or balls of 5120 triangles.
enum Parts : std::int64_t { as_they_are, fine_balls };

class Hall {
  public:
    explicit Hall(Parts parts) : hall_(scenes::tumbling_hall({.bodies = 20})) {
        if (parts == fine_balls) {
            for (scenes::Body& body : hall_.bodies) {
                const Rgba8 color = body.triangles[0].rgba[0];
                body.triangles.clear();
                for (const auto& [a, b, c] : scenes::icosphere(4)) {
                    const float brightness = 0.7f + 0.3f * a.y;
                    const auto byte = [&](std::uint8_t x) { return std::uint8_t(float(x) * brightness); };
                    const Rgba8 lit{byte(color.r), byte(color.g), byte(color.b), 255};
                    body.triangles.push_back({{a * 0.35f, b * 0.35f, c * 0.35f}, {lit, lit, lit}});
                }
            }
        }
        hierarchies_.push_back(build<H>(hall_.building));
        for (const scenes::Body& b : hall_.bodies) {
            // Of one BSP of a convex body nearly every plane leaves the rest on one side: cubes tell better what meets.
            hierarchies_.push_back(build<H>(b.triangles, {.partition = {.largest_leaf = 32}}));
        }
    }

    View view() const {
        return {.camera = scenes::inside_tumbling_hall(hall_), .width = 512, .height = 512, .tolerance_px = 0};
    }
    const H& building() const { return hierarchies_[0]; }
    std::span<const P> building_triangles() const { return hall_.building; }

    std::vector<Body> bodies_at(int moment) const {
        std::vector<Body> bodies{{&hierarchies_[0], hall_.building, Similarity()}};
        const std::vector<glm::mat4> places = scenes::placements_at(hall_, double(moment) / moments);
        for (std::size_t b = 0; b < places.size(); ++b) {
            bodies.push_back({&hierarchies_[b + 1], hall_.bodies[b].triangles, Similarity(places[b])});
        }
        return bodies;
    }

  private:
    scenes::TumblingHall hall_;
    std::vector<H> hierarchies_;
};

const Hall& hall(const benchmark::State& state) {
    static const Hall halls[]{Hall(as_they_are), Hall(fine_balls)};
    return halls[state.range(0)];
}

void building_alone(benchmark::State& state) {
    const Hall& scene = hall(state);
    StrictCoverageRenderer renderer;
    Viewer<H, P, StrictCoverageRenderer> viewer(scene.building(), scene.building_triangles(), renderer);
    FrameStats stats;
    for (auto _ : state) stats = viewer.frame(scene.view());
    state.counters["polygons"] = double(stats.primitives);
}

void merged(benchmark::State& state) {
    const Hall& scene = hall(state);
    StrictCoverageRenderer renderer;
    auto viewer = make_merged_viewer(scene.bodies_at(0), renderer);
    std::vector<std::vector<Body>> bodies;
    for (int m = 0; m < moments; ++m) bodies.push_back(scene.bodies_at(m));
    double frames = 0, polygons = 0, pieces = 0, regions = 0, cells = 0;
    for (auto _ : state) {
        const std::vector<Body>& now = bodies[std::size_t(frames) % moments];
        for (std::size_t b = 0; b < now.size(); ++b) viewer.place(b, now[b].to_world);
        const MergedFrameStats stats = viewer.frame(scene.view());
        polygons += double(stats.primitives);
        pieces += double(stats.pieces);
        regions += double(stats.regions);
        cells += double(stats.cells_visited);
        ++frames;
    }
    state.counters["polygons"] = polygons / frames;
    state.counters["pieces"] = pieces / frames;
    state.counters["regions"] = regions / frames;
    state.counters["cells"] = cells / frames;
}

void lazy(benchmark::State& state) {
    const Hall& scene = hall(state);
    CoverageRenderer renderer;
    /// Of one moment: what a program would keep, and build its root again.
    struct Moment {
        std::vector<Body> bodies;
        Root root;
        Viewer<Root, Body, CoverageRenderer> viewer;

        Moment(std::vector<Body> b, CoverageRenderer& r)
            : bodies(std::move(b)), root(build<Root>(bodies)), viewer(root, bodies, r) {}
    };
    std::vector<std::unique_ptr<Moment>> all;
    for (int m = 0; m < moments; ++m) all.push_back(std::make_unique<Moment>(scene.bodies_at(m), renderer));
    double frames = 0, polygons = 0;
    for (auto _ : state) {
        polygons += double(all[std::size_t(frames) % moments]->viewer.frame(scene.view()).primitives);
        ++frames;
    }
    state.counters["polygons"] = polygons / frames;
}

BENCHMARK(building_alone)->ArgName("fine")->Arg(as_they_are)->Unit(benchmark::kMillisecond);
BENCHMARK(merged)->ArgName("fine")->Arg(as_they_are)->Arg(fine_balls)->Unit(benchmark::kMillisecond);
BENCHMARK(lazy)->ArgName("fine")->Arg(as_they_are)->Arg(fine_balls)->Unit(benchmark::kMillisecond);

}  // namespace
