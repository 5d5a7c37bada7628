#include "farfield/merged_viewer/polygon_batch.hpp"

#include <vector>

#include "catch.hpp"

using namespace farfield;
using farfield::detail::PolygonBatch;

namespace {

/// Counts corners of each polygon, and notes the first.
struct Counting {
    std::vector<std::size_t> corners;
    std::vector<float> first;
    std::size_t calls = 0;
    void draw(std::span<const Polygon> polygons) {
        ++calls;
        for (const Polygon& p : polygons) {
            CHECK(p.colors.size() == p.vertices.size());
            CHECK_FALSE(p.is_lit);
            corners.push_back(p.vertices.size());
            first.push_back(p.vertices[0].x);
            CHECK(p.colors[0].r == std::uint8_t(p.vertices[0].x));
        }
    }
};

std::vector<Corner> polygon(std::size_t corners, int number) {
    std::vector<Corner> out(corners);
    for (Corner& c : out) c = {glm::vec3(float(number), 0, 0), {std::uint8_t(number), 0, 0, 255}};
    return out;
}

}  // namespace

TEST_CASE("polygons are drawn once, in the order in which they came") {
    PolygonBatch batch;
    Counting renderer;
    batch.draw(renderer);
    CHECK(renderer.calls == 0);
    for (int round = 0; round < 2; ++round) {
        renderer = {};
        std::vector<std::size_t> corners;
        for (int i = 0; !batch.is_full(); ++i) {
            corners.push_back(3 + std::size_t(i % 7));
            batch.add(polygon(corners.back(), i % 200));
            CHECK_FALSE(batch.empty());
        }
        CHECK(corners.size() == 256);
        batch.draw(renderer);
        CHECK(batch.empty());
        CHECK(renderer.calls == 1);
        CHECK(renderer.corners == corners);
        for (std::size_t i = 0; i < renderer.first.size(); ++i) CHECK(renderer.first[i] == float(i % 200));
        batch.draw(renderer);
        CHECK(renderer.calls == 1);
    }
}
