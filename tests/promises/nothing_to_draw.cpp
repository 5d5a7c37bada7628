// Primitives without polygons draw nothing, wherever they come: first, last, alone, or not at all. Library assertions,
// which sanitized tests are compiled with, notice who looks one past the end.
#include <array>
#include <cmath>
#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "catch.hpp"
#include "farfield/approximation/color_cube.hpp"
#include "farfield/approximation/exact.hpp"
#include "farfield/approximation/opacity_tensor.hpp"
#include "farfield/build.hpp"
#include "farfield/cost_model/triangle_count.hpp"
#include "farfield/partition/nested.hpp"
#include "farfield/partition/octree.hpp"
#include "farfield/partition/polygon_bsp.hpp"
#include "farfield/primitive/triangle.hpp"
#include "farfield/renderer/coverage_renderer.hpp"
#include "farfield/renderer/hierarchical_z_renderer.hpp"
#include "farfield/renderer/painter_renderer.hpp"
#include "farfield/renderer/z_buffer_renderer.hpp"
#include "farfield/viewer.hpp"
#include "scenes/renderers/coverage_tilers.hpp"
#include "support/scenes.hpp"
#include "support/views.hpp"

using namespace farfield;
using namespace farfield::test;

namespace {

/// A triangle, or a marker that draws nothing.
struct Thing {
    Triangle triangle;
    bool is_marker = false;
    Box bounds() const { return triangle.bounds(); }
    template <class Sink>
    void polygons(Sink&& sink) const {
        if (!is_marker) triangle.polygons(sink);
    }
};
using Things = std::vector<Thing>;

/// Octants of triangles; those whose bits are set in `markers` draw nothing.
Things octants(unsigned markers) {
    Things things;
    for (unsigned octant = 0; octant < 8; ++octant) {
        for (Triangle t : random_triangles(40, 1300 + octant, 0.3f)) {
            for (glm::vec3& v : t.vertices) {
                v += glm::vec3(octant & 1 ? 3 : -3, octant & 2 ? 3 : -3, octant & 4 ? 3 : -3);
            }
            things.push_back({t, (markers >> octant & 1) != 0});
        }
    }
    return things;
}

std::vector<std::pair<std::string, Things>> inputs() {
    std::vector<std::pair<std::string, Things>> all{{"nothing", {}},
                                                    {"markers alone", octants(255)},
                                                    {"the last octant", octants(128)},
                                                    {"the first octant", octants(1)},
                                                    {"but for one octant", octants(255 - 16)}};
    all.push_back({"one marker", {octants(255)[0]}});
    all.push_back({"one marker at the end", octants(0)});
    all.back().second.back().is_marker = true;
    return all;
}

template <class H, class R, class Options>
void check(const std::string& name, const Options& options) {
    for (const auto& [input, things] : inputs()) {
        Things without;
        for (const Thing& t : things) {
            if (!t.is_marker) without.push_back(t);
        }
        INFO(name << ", " << input);
        const H h = build<H>(things), of_others = build<H>(without);
        R renderer(options), other(options);
        auto viewer = make_viewer(h, things, renderer);
        auto viewer_of_others = make_viewer(of_others, without, other);
        for (int i = 0; i < 12; ++i) {
            View view = looking({9 * std::cos(0.5 * i), i - 4, 9 * std::sin(0.5 * i)}, {0.1, 0, 0}, 48);
            view.camera.near_depth = 0.01f;
            viewer.frame(view);
            viewer_of_others.frame(view);
            CHECK(renderer.image() == other.image());
            view.tolerance_px = 4;
            viewer.frame(view);
        }
    }
}

}  // namespace

TEST_CASE("primitives without polygons draw nothing, wherever they come") {
    using Exactly = SpatialHierarchy<Octree, Exact, TriangleCount>;
    using OctreeOfTensors = SpatialHierarchy<Octree, OpacityTensor, TriangleCount>;
    using SharedOctreeOfCubes = SpatialHierarchy<SharedOctree, ColorCube, TriangleCount>;
    using Bsp = SpatialHierarchy<Nested<Octree, PolygonBsp>, Exact, TriangleCount>;
    check<Exactly, CoverageRenderer>("exact, masks", CoverageOptions{});
    check<OctreeOfTensors, CoverageRenderer>("tensors, masks", CoverageOptions{});
    check<SharedOctreeOfCubes, ZBufferRenderer>("shared cubes, z-buffer", ZBufferOptions{});
    check<OctreeOfTensors, ZBufferRenderer>("tensors, z-buffer", ZBufferOptions{.samples = 4});
    check<OctreeOfTensors, ZBufferRenderer>("tensors, read", ZBufferOptions{.copies_sources = false});
    check<Exactly, HierarchicalZRenderer>("exact, hierarchical z", ZBufferOptions{});
    check<Bsp, StrictCoverageRenderer>("BSPs, strict masks", CoverageOptions{});
    check<Bsp, PainterRenderer>("BSPs, painter", PainterOptions{});
}
