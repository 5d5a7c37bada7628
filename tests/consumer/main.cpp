// A program of somebody else, built against farfield as its users build it.
#include <cstdio>
#include <span>
#include <vector>

#include "farfield/approximation/color_cube.hpp"
#include "farfield/build.hpp"
#include "farfield/cost_model/triangle_count.hpp"
#include "farfield/partition/octree.hpp"
#include "farfield/primitive/triangle.hpp"
#include "farfield/renderer/z_buffer_renderer.hpp"
#include "farfield/viewer.hpp"

int main() {
    std::vector<farfield::Triangle> grass;
    for (int i = 0; i < 10000; ++i) {
        const glm::vec3 root(float(i % 100), 0, float(i / 100));
        grass.push_back({{root, root + glm::vec3(0.5f, 0, 0), root + glm::vec3(0.2f, 1, 0.3f)}, {60, 160, 40, 255}});
    }
    using Hierarchy = farfield::SpatialHierarchy<farfield::Octree, farfield::ColorCube, farfield::TriangleCount>;
    const auto hierarchy = farfield::build<Hierarchy>(grass);
    farfield::ZBufferRenderer renderer;
    auto viewer = farfield::make_viewer(hierarchy, grass, renderer);
    const auto camera = farfield::Camera::perspective({50, 40, 900}, {50, 0, 50}, {0, 1, 0}, 0.5f);
    const farfield::FrameStats stats = viewer.frame({.camera = camera, .width = 128, .height = 128});
    std::printf("%llu stand-ins and %llu primitives drawn\n", static_cast<unsigned long long>(stats.approximations),
                static_cast<unsigned long long>(stats.primitives));
    return stats.approximations > 0 && renderer.image().width() == 128 ? 0 : 1;
}
