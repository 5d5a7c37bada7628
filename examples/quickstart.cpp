// The smallest whole use of farfield: triangles of your own, a hierarchy over them, a picture.
#include <cmath>
#include <fstream>
#include <iostream>
#include <span>
#include <vector>

#include "farfield/approximation/color_cube.hpp"
#include "farfield/cost/triangle_count.hpp"
#include "farfield/geometry/triangle.hpp"
#include "farfield/partition/octree.hpp"
#include "farfield/raster/z_buffer_renderer.hpp"
#include "farfield/viewer.hpp"

using namespace farfield;
using Hierarchy = SpatialHierarchy<Octree, ColorCube, TriangleCount>;

int main() {
    // An orchard: 144 round trees of 10,000 leaves, a leaf being a triangle.
    std::vector<Triangle> leaves;
    for (int i = 0; i < 1'440'000; ++i) {
        const int tree = i / 10'000, leaf = i % 10'000;
        const glm::vec3 crown(float(tree % 12) * 6 - 33, 3, float(tree / 12) * -14);
        // Steps by the golden angle spread points evenly over a ball.
        const float y = float(leaf) / 5000 - 1, radius = 2 * std::sqrt(1 - y * y), angle = 2.39996f * float(leaf);
        const float turn = float(leaf * leaf % 1009);
        const glm::vec3 at = crown + glm::vec3(radius * std::cos(angle), 2 * y, radius * std::sin(angle));
        const glm::vec3 tip(0.2f * std::sin(turn), -0.2f, 0.2f * std::cos(turn));
        leaves.push_back(
            {{at, at + tip, at + glm::vec3(0.2f, 0.1f, 0)}, {80, std::uint8_t(130 + 12 * (leaf % 5)), 40}});
    }

    const DirectionalLight sun;
    const auto hierarchy =
        Hierarchy::build(std::span<const Triangle>(leaves), {}, {}, {}, {}, /*colors of stand-ins:*/ GridSampler(sun));
    ZBufferRenderer renderer({.background = {170, 205, 240}, .light = sun});
    auto viewer = make_viewer(hierarchy, leaves, renderer);

    const auto camera = Camera::perspective({25, 20, 50}, {0, -5, -50}, {0, 1, 0}, 0.8f);
    const FrameStats stats = viewer.frame({.camera = camera, .width = 640, .height = 240, .tolerance_px = 1});
    std::cout << "drawn: " << stats.primitives << " triangles and " << stats.approximations << " stand-ins, for "
              << leaves.size() << " triangles\n";

    std::ofstream ppm("quickstart.ppm", std::ios::binary);
    ppm << "P6 640 240 255\n";
    for (const Rgba8 c : renderer.image().pixels()) ppm.put(char(c.r)).put(char(c.g)).put(char(c.b));
}
