#include <iostream>
#include <random>
#include <vector>

#include "farfield/farfield.hpp"
using namespace farfield;
using Hierarchy = SpatialHierarchy<Octree, OpacityTensor, TriangleCount>;

int main() {
    std::mt19937 random;
    const auto number = [&] { return float(random() % 2000) / 1000 - 1; };
    const auto point = [&] { return glm::vec3{number(), number(), number()}; };
    std::vector<Triangle> leaves;  // of a tree: a ball
    while (leaves.size() < 10'000) {
        const glm::vec3 a = point(), b = a + 0.05f * point(), c = a + 0.05f * point();
        if (glm::length(a) < 1) leaves.push_back({{a, b, c}, {60, std::uint8_t(150 + 80 * a.y), 40}});
    }
    const auto tree = build<Hierarchy>(leaves);

    std::vector<Instance<Hierarchy, Triangle>> forest;
    for (int i = 0; i < 40'000; ++i) {
        Similarity place;
        place.translation = {300 * number(), 0, 300 * number()};
        forest.push_back({&tree, leaves, place});
    }
    const auto hierarchy = build<Hierarchy>(forest);

    ZBufferRenderer renderer;
    auto viewer = make_viewer(hierarchy, forest, renderer);
    const auto camera = Camera::perspective({0, 300, 540}, {0, 0, 0}, {0, 1, 0}, 0.8f);
    const auto stats = viewer.frame({.camera = camera, .width = 640, .height = 360, .tolerance_px = 1});
    std::cout << stats.approximations << " stand-ins and " << stats.primitives << " triangles drawn for "
              << leaves.size() * forest.size() / 1'000'000 << " million\n";  // the picture is renderer.image()
}
