// A mesh as engines keep it, drawn without a copy or a handle a triangle: it answers for the triangle of an index
// (primitive_source.hpp). Its materials are keys, so that a range that is drawn falls into a few draw calls.
#include <array>
#include <cmath>
#include <iostream>
#include <vector>

#include "farfield/farfield.hpp"
using namespace farfield;

struct Mesh {
    std::vector<glm::vec3> vertices;
    std::vector<std::array<std::uint32_t, 3>> triangles;
    std::vector<std::uint8_t> materials;  // one a triangle
    std::array<Rgba8, 4> colors{{{60, 140, 50}, {120, 100, 60}, {130, 130, 130}, {240, 240, 250}}};

    std::array<glm::vec3, 3> corners(std::uint32_t i) const {
        const auto& [a, b, c] = triangles[i];
        return {vertices[a], vertices[b], vertices[c]};
    }
    std::size_t primitive_count() const { return triangles.size(); }
    Box bounds(std::uint32_t i) const { return bounds_of(corners(i)); }
    void polygons(std::uint32_t i, auto&& sink) const { sink(Polygon{corners(i), {&colors[materials[i]], 1}}); }
    std::uint32_t key(std::uint32_t i) const { return materials[i]; }
};
struct DrawCalls {
    static constexpr RendererFacts facts{.keeps_sources = true, .draws_faces = true};
    KeyedOrder by_material;  // what an index buffer would hold
    std::vector<KeyedPart> parts;
    std::size_t calls = 0;
    std::uint32_t upload(const auto& source) { return by_material = KeyedOrder(source), 1u; }
    void release(std::uint32_t) {}
    void begin_frame(const LocalView&) { calls = 0; }
    void set_view(const LocalView&) {}
    void draw(const auto&, std::span<const Range> all) {
        by_material.parts_of(all, parts);
        calls += parts.size();
    }
    void draw(std::span<const Face>) {}
    void end_frame() {}
};
int main() {
    const std::uint32_t side = 600;
    Mesh land;
    for (std::uint32_t i = 0; i < (side + 1) * (side + 1); ++i) {
        const float x = float(i % (side + 1)), z = float(i / (side + 1));
        land.vertices.emplace_back(x, 20 * std::sin(x * 0.05f) * std::cos(z * 0.04f) + float(i * 7 % 5) * 0.2f, z);
        if (x == float(side) || z == float(side)) continue;
        land.triangles.insert(land.triangles.end(), {{i, i + side + 1, i + 1}, {i + 1, i + side + 1, i + side + 2}});
        land.materials.insert(land.materials.end(), 2, std::uint8_t(i * 2654435761u >> 30));
    }
    const auto hierarchy = build<SpatialHierarchy<Octree, OpacityTensor, TriangleCount>>(land);
    DrawCalls renderer;
    auto viewer = make_viewer(hierarchy, land, renderer);
    const auto stats = viewer.frame({.camera = Camera::perspective({300, 60, -20}, {300, 0, 300}, {0, 1, 0}, 0.8f)});
    std::cout << stats.primitives << " triangles in " << stats.runs << " ranges and " << renderer.calls
              << " draw calls of one material\n";
    return renderer.calls > 0 && renderer.calls <= 4 * stats.runs ? 0 : 1;
}
