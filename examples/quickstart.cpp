#include <iostream>
#include <random>
#include <vector>

#include "farfield/approximation/opacity_tensor.hpp"
#include "farfield/build.hpp"
#include "farfield/cost_model/triangle_count.hpp"
#include "farfield/partition/octree.hpp"
#include "farfield/primitive/instance.hpp"
#include "farfield/primitive/triangle.hpp"
#include "farfield/renderer/z_buffer_renderer.hpp"
#include "farfield/viewer.hpp"
using namespace farfield;
using Hierarchy = SpatialHierarchy<Octree, OpacityTensor, TriangleCount>;

int main() {
    std::mt19937 random;
    const auto number = [&] { return float(random() % 2000) / 1000 - 1; };  // between -1 and 1
    std::vector<Triangle> leaves;                                           // 10,000 in a ball: a tree
    while (leaves.size() < 10'000) {
        const glm::vec3 at{number(), number(), number()};
        const glm::vec3 a{number(), number(), number()}, b{number(), number(), number()};
        if (glm::length(at) > 1) continue;
        leaves.push_back({{at, at + 0.05f * a, at + 0.05f * b}, {60, std::uint8_t(150 + 80 * at.y), 40}});
    }
    const auto tree = build<Hierarchy>(leaves);

    std::vector<Instance<Hierarchy, Triangle>> forest;
    for (int i = 0; i < 40'000; ++i) {
        Similarity place;
        place.translation = {300 * number(), 0, 300 * number()};
        forest.push_back({&tree, leaves, place});
    }
    const auto hierarchy = build<Hierarchy>(forest);

    ZBufferRenderer renderer;  // or one of your own
    auto viewer = make_viewer(hierarchy, forest, renderer);
    const auto camera = Camera::perspective({0, 300, 540}, {0, 0, 0}, {0, 1, 0}, 0.8f);
    const auto stats = viewer.frame({.camera = camera, .width = 640, .height = 360, .tolerance_px = 1});
    std::cout << stats.approximations << " stand-ins and " << stats.primitives << " triangles drawn for "
              << leaves.size() * forest.size() / 1'000'000 << " million\n";  // the picture is renderer.image()
}
