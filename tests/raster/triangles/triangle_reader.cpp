// What is read a piece at a time lies where it lies in a stream that keeps everything.
#include "farfield/raster/triangles/triangle_reader.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "catch.hpp"
#include "farfield/geometry/box.hpp"
#include "support/random.hpp"

using namespace farfield;
using namespace farfield::detail;
using namespace farfield::test;

namespace {

/// Some polygons, or none.
struct Some {
    std::vector<std::vector<glm::vec3>> vertices;
    std::vector<std::vector<Rgba8>> colors;
    Box bounds() const { return {glm::vec3(-1), glm::vec3(1)}; }
    template <class Sink>
    void polygons(Sink&& sink) const {
        for (std::size_t i = 0; i < vertices.size(); ++i) sink(Polygon{vertices[i], colors[i]});
    }
};

std::vector<Some> primitives(std::uint64_t seed, std::uint32_t most_polygons, bool several_colors) {
    Random random(seed);
    std::vector<Some> all(700);
    for (Some& one : all) {
        const std::uint32_t polygons = most_polygons == 1 ? 1 : random.below(most_polygons + 1);
        for (std::uint32_t i = 0; i < polygons; ++i) {
            const std::uint32_t corners = most_polygons == 1 ? 3 : 3 + random.below(random.below(9) == 0 ? 62 : 3);
            auto& vertices = one.vertices.emplace_back();
            for (std::uint32_t c = 0; c < corners; ++c) vertices.push_back(random.in_cube(1));
            auto& colors = one.colors.emplace_back();
            const std::uint32_t count = several_colors && random.below(2) == 0 ? corners : 1;
            for (std::uint32_t c = 0; c < count; ++c) colors.push_back(random.color());
        }
    }
    return all;
}

}  // namespace

TEST_CASE("triangles that are read come once, in order, in the lanes and blocks of a stream that keeps them",
          "[raster]") {
    Random random(830);
    TriangleReader reader;
    for (const std::uint32_t most_polygons : {1u, 4u}) {
        for (const bool several_colors : {false, true}) {
            const auto all = primitives(831 + most_polygons, most_polygons, several_colors);
            const Source<Some> source{all, {}, std::uint32_t(all.size())};
            const TriangleStream kept(source), index(source, false);
            REQUIRE(index.size() == kept.size());
            REQUIRE(index.several_colors() == several_colors);
            REQUIRE(kept.several_colors() == several_colors);
            CHECK(index.bytes() == (most_polygons == 1 ? 0 : 4 * (all.size() + 1)));
            CHECK(kept.bytes() > 40 * all.size());
            for (int round = 0; round < 100; ++round) {
                Range range{random.below(700), 0};
                range.count = random.below(round % 4 == 0 ? 701 - range.first : std::min(701 - range.first, 20u));
                if (round == 0) range = {0, 700};
                const std::uint32_t begin = kept.first_triangle(range.first),
                                    end = kept.first_triangle(range.first + range.count);
                std::uint32_t next = begin, largest = 0;
                std::size_t wrong = 0;
                reader.read(source, index, range,
                            [&](const TriangleStream& window, std::uint32_t from, std::uint32_t to) {
                                const std::uint32_t shift = next - from;
                                // Blocks are those of the kept stream, and none is cut but at the range's ends.
                                wrong += shift % TriangleBlock::lanes != 0;
                                wrong += from % TriangleBlock::lanes != 0 && next != begin;
                                wrong += window.several_colors() != several_colors;
                                for (std::uint32_t t = from; t < to; ++t) {
                                    for (unsigned c = 0; c < 3; ++c) {
                                        wrong += window.vertex(t, c) != kept.vertex(t + shift, c);
                                        if (c == 0 || several_colors)
                                            wrong += window.colors(t)[c] != kept.colors(t + shift)[c];
                                    }
                                }
                                next += to - from;
                                wrong += to % TriangleBlock::lanes != 0 && next != end;
                                largest = std::max(largest, window.size());
                            });
                CHECK(wrong == 0);
                CHECK(next == end);
                CHECK(largest < 1000);
            }
        }
    }
}
