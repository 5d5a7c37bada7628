// A primitive and a renderer of your own, as short as they can be; README shows both. Policies of your own are in
// custom_policy/, primitives that hold instances or cannot be changed in custom_primitive/.
#include <array>
#include <cstddef>
#include <cstdint>
#include <iostream>
#include <span>
#include <vector>

#include "farfield/approximation/color_cube.hpp"
#include "farfield/build.hpp"
#include "farfield/cost_model/triangle_count.hpp"
#include "farfield/partition/octree.hpp"
#include "farfield/viewer.hpp"
using namespace farfield;

struct Tile {
    std::array<glm::vec3, 4> corners;  // axis-aligned
    Rgba8 color;
    Box bounds() const { return {glm::min(corners[0], corners[2]), glm::max(corners[0], corners[2])}; }
    void polygons(auto&& sink) const { sink(Polygon{corners, {&color, 1}}); }
};
struct Counter {
    static constexpr RendererFacts facts{.draws_faces = true};
    std::size_t polygons = 0, faces = 0;
    void begin_frame(const LocalView&) { polygons = faces = 0; }
    void set_view(const LocalView&) {}
    void draw(const auto& source, std::span<const Range> ranges) {
        for (const Range& r : ranges)
            for (auto i = r.first; i < r.first + r.count; ++i) source.polygons(i, [&](const Polygon&) { ++polygons; });
    }
    void draw(std::span<const Face> stand_ins) { faces += stand_ins.size(); }
    void end_frame() {}
};

int main() {
    std::vector<Tile> floor;
    for (int i = 0; i < 100'000; ++i) {
        const float x = float(i % 400), z = float(i / 400);
        floor.push_back(
            {{{{x, 0, z}, {x, 0, z + 1}, {x + 1, 0, z + 1}, {x + 1, 0, z}}}, {std::uint8_t(x / 2), 90, 60}});
    }
    const auto hierarchy = build<SpatialHierarchy<Octree, ColorCube, TriangleCount>>(floor);
    Counter counter;
    auto viewer = make_viewer(hierarchy, floor, counter);
    viewer.frame({.camera = Camera::perspective({200, 300, -1800}, {200, 0, 0}, {0, 1, 0}, 0.8f)});
    std::cout << counter.polygons << " polygons and " << counter.faces << " faces\n";
}
