#include <iostream>
#include <span>
#include <vector>

#include "farfield/approximation/color_cube.hpp"
#include "farfield/build.hpp"
#include "farfield/cost_model/triangle_count.hpp"
#include "farfield/partition/octree.hpp"
#include "farfield/primitive/triangle.hpp"
#include "farfield/renderer/z_buffer_renderer.hpp"
#include "farfield/viewer.hpp"
using namespace farfield;

int main() {
    std::vector<Triangle> grass;  // a meadow of a million blades
    for (int i = 0; i < 1'000'000; ++i) {
        const glm::vec3 root(float(i % 1000), 0, float(i / 1000));
        const glm::vec3 tip(root + glm::vec3(0.3f, 1 + 0.2f * float(i % 7), 0.2f * float(i % 5)));
        grass.push_back({{root, root + glm::vec3(0.5f, 0, 0), tip}, {60, std::uint8_t(120 + i % 80), 40}});
    }
    using Hierarchy = SpatialHierarchy<Octree, ColorCube, TriangleCount>;
    const Hierarchy hierarchy = build<Hierarchy>(grass);

    ZBufferRenderer renderer;  // or one of your own
    auto viewer = make_viewer(hierarchy, grass, renderer);
    const auto camera = Camera::perspective({500, 200, 3000}, {500, 0, 0}, {0, 1, 0}, 0.8f);
    const auto stats = viewer.frame({.camera = camera, .width = 640, .height = 360, .tolerance_px = 1});
    std::cout << stats.approximations << " stand-ins and " << stats.primitives << " triangles drawn for "
              << grass.size() << " triangles\n";  // the picture is renderer.image()
}
