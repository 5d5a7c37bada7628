// Particles as simulations keep them, in an array for each coordinate, and with a radius: the source makes the Point of
// an index when it is asked for (primitive_source.hpp).
#include <cstddef>
#include <cstdint>
#include <iostream>
#include <random>
#include <string>
#include <vector>

#include "farfield/farfield.hpp"
using namespace farfield;

struct Particles {
    std::vector<float> x, y, z, radius, heat;

    Point point(std::uint32_t i) const {
        const Rgba8 color{std::uint8_t(255 * heat[i]), 80, std::uint8_t(255 - 255 * heat[i])};
        return {{x[i], y[i], z[i]}, radius[i], glm::vec3(0), color};
    }
    std::size_t primitive_count() const { return x.size(); }
    Box bounds(std::uint32_t i) const { return point(i).bounds(); }
    Work work(std::uint32_t i) const { return point(i).work(); }
    void polygons(std::uint32_t i, auto&& sink) const { point(i).polygons(sink); }
};

int main() {
    std::mt19937 random;
    const auto number = [&] { return float(random() % 2000) / 1000 - 1; };
    Particles cloud;
    for (int i = 0; i < 100'000; ++i) {
        cloud.x.push_back(number() * number());
        cloud.y.push_back(number() * number());
        cloud.z.push_back(number() * number());
        cloud.radius.push_back(0.002f + 0.002f * number());  // 0 is no special case
        cloud.heat.push_back(0.5f + 0.5f * number());
    }
    const auto hierarchy = build<SpatialHierarchy<Octree, OpacityTensor, TriangleCount>>(cloud);
    ZBufferRenderer renderer;
    auto viewer = make_viewer(hierarchy, cloud, renderer);
    const View view{.camera = Camera::perspective({0, 0, 6}, {0, 0, 0}, {0, 1, 0}, 0.5f)};
    const auto stats = viewer.frame(view);
    const auto picked = pick(hierarchy, cloud, view, {320, 240});
    std::cout << stats.primitives << " particles and " << stats.approximations << " stand-ins drawn for "
              << cloud.primitive_count() << "; under the middle of the picture lies "
              << (picked ? std::to_string(picked->path[0]) : "none") << "\n";
    return stats.approximations > 0 && stats.primitives < cloud.primitive_count() ? 0 : 1;
}
