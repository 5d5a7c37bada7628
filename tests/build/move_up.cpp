#include "farfield/build/move_up.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <functional>
#include <vector>

#include "catch.hpp"
#include "farfield/approximation/sample_set.hpp"
#include "farfield/build.hpp"
#include "farfield/cost_model/triangle_count.hpp"
#include "farfield/partition/octree.hpp"
#include "farfield/storage/soundness.hpp"
#include "support/scenes.hpp"

using namespace farfield;
using namespace farfield::test;

namespace {

using Samples = SpatialHierarchy<Octree, SampleSet<>, TriangleCount>;

struct Found {
    Cell cell;
    std::uint32_t first = 0, own_end = 0, end = 0;
    std::vector<std::size_t> ancestors{};  ///< outermost first
    bool is_leaf = true;
};

std::vector<Found> nodes_of(const Samples& h) {
    std::vector<Found> out;
    const std::function<void(std::uint32_t, const Cell&, std::uint32_t, std::vector<std::size_t>)> visit =
        [&](std::uint32_t n, const Cell& cell, std::uint32_t end, std::vector<std::size_t> above) {
            const Node& node = h.nodes()[n];
            const auto children = unsigned(std::popcount(node.child_mask));
            const std::uint32_t own_end = children != 0 ? h.nodes()[node.first_child].first_item : end;
            out.push_back({cell, node.first_item, own_end, end, above, children == 0});
            above.push_back(out.size() - 1);
            unsigned rank = 0;
            for (unsigned c = 0; c < 8; ++c) {
                if ((node.child_mask >> c & 1) == 0) continue;
                const std::uint32_t at = node.first_child + rank++;
                visit(at, h.partition_policy().child(cell, {}, c), rank < children ? h.nodes()[at + 1].first_item : end,
                      above);
            }
        };
    visit(0, h.root_cell(), h.item_count(), {});
    return out;
}

float key_of(const Samples& h, const Triangles& t, std::uint32_t position) {
    const std::uint32_t primitive = h.order()[position];
    const double area = t[primitive].area();
    return area > 0 ? h.approximation_policy().sample_key(primitive, area) : INFINITY;
}

bool is_permutation_of_all(const Samples& h) {
    std::vector<std::uint32_t> order(h.order().begin(), h.order().end());
    std::sort(order.begin(), order.end());
    for (std::uint32_t i = 0; i < order.size(); ++i) {
        if (order[i] != i) return false;
    }
    return order.size() == h.primitive_count();
}

}  // namespace

TEST_CASE("a cell and those above hold the least keys of all that lies in it", "[build]") {
    // Small triangles, so that none is in an inner cell but by moving.
    const Triangles triangles = random_triangles(20000, 5, 0.004f);
    for (const float c : {1.0f, 4.0f, 13.8f}) {
        const Samples h = build<Samples>(triangles, {.approximation = {.c = c}});
        REQUIRE(is_permutation_of_all(h));
        const std::vector<Found> nodes = nodes_of(h);
        std::size_t inner = 0, wrong_order = 0, not_least = 0, wrong_size = 0;
        for (std::size_t n = 0; n < nodes.size(); ++n) {
            const Found& node = nodes[n];
            for (std::uint32_t at = node.first + 1; at < node.own_end; ++at) {
                if (!node.is_leaf) wrong_order += key_of(h, triangles, at - 1) > 1.00001f * key_of(h, triangles, at);
            }
            if (node.is_leaf) continue;
            ++inner;
            // Items of the cell that moved above it: by their centers, as the octree does.
            double area = 0;
            std::size_t above = 0;
            for (const std::size_t a : node.ancestors) {
                for (std::uint32_t at = nodes[a].first; at < nodes[a].own_end; ++at) {
                    const Triangle& t = triangles[h.order()[at]];
                    if (!node.cell.box().intersects(Box{t.bounds().center(), t.bounds().center()})) continue;
                    area += t.area();
                    ++above;
                }
            }
            for (std::uint32_t at = node.first; at < node.end; ++at) area += triangles[h.order()[at]].area();
            float last = 0, next = INFINITY;
            for (std::uint32_t at = node.first; at < node.own_end; ++at) last = key_of(h, triangles, at);
            for (std::uint32_t at = node.own_end; at < node.end; ++at) {
                next = std::min(next, key_of(h, triangles, at));
            }
            not_least += last > next * 1.00001f;  // areas are summed in single precision there
            const double side = double(node.cell.largest_side());
            const std::size_t wanted = sample_size(area / (side * side), double(c));
            wrong_size += above + (node.own_end - node.first) != wanted;
        }
        INFO("c = " << c << ", " << inner << " inner cells");
        CHECK(inner > 20);
        CHECK(wrong_order == 0);
        CHECK(not_least == 0);
        // Centers on a cell's border, and areas that rounding puts on one or the other side of a step.
        CHECK(double(wrong_size) <= 0.02 * double(inner));
    }
}

TEST_CASE("moving leaves no empty cell and nothing twice, whatever there is", "[build]") {
    const auto check = [](const char* name, const Triangles& triangles) {
        for (const float c : {0.5f, 13.8f, 500.0f}) {
            const Samples h = build<Samples>(triangles, {.approximation = {.c = c}});
            INFO(name << ", c = " << c);
            CHECK(is_permutation_of_all(h));
            CHECK(detail::unsound<Samples>(h.partition_policy(), h.approximation_policy(), h.facts(), h.arrays()) ==
                  nullptr);
            for (const Found& node : nodes_of(h)) CHECK((node.end > node.first || triangles.empty()));
        }
    };
    check("nothing", {});
    check("one", random_triangles(1, 1));
    check("two", random_triangles(2, 1));
    check("mixed", mixed_triangles(5000, 3));
    check("duplicates", Triangles(3000, random_triangles(1, 1, 0.01f)[0]));
    Triangles flat = random_triangles(3000, 4, 0.01f);
    for (Triangle& t : flat) t.vertices[2] = t.vertices[1];
    check("no area at all", flat);
    flat.push_back({{glm::vec3(-1), glm::vec3(1, -1, 1), glm::vec3(1)}, {255, 255, 255, 255}});
    check("all area in one, as large as the scene", flat);
    flat.back() = {{glm::vec3(0.1f), glm::vec3(0.101f, 0.1f, 0.1f), glm::vec3(0.1f, 0.101f, 0.1f)}, {}};
    check("all area in a small one", flat);
    Triangles line;
    for (int i = 0; i < 2000; ++i) {
        const float x = float(i) / 1000 - 1;
        line.push_back({{glm::vec3(x, 0, 0), glm::vec3(x + 0.001f, 0, 0), glm::vec3(x, 0.001f, 0)}, {}});
    }
    check("in a row", line);
}

TEST_CASE("samples depend on contents and seed, not on scale or threads", "[build]") {
    const Triangles triangles = mixed_triangles(4000, 8);
    const auto order = [](const Triangles& t, const BuildOptions<Samples>& options) {
        const Samples h = build<Samples>(t, options);
        return std::vector<std::uint32_t>(h.order().begin(), h.order().end());
    };
    const auto one = order(triangles, {});
    CHECK(order(triangles, {.executor = ThreadExecutor(3)}) == one);
    CHECK(order(triangles, {.approximation = {.seed = 1}}) != one);
    for (const int exponent : {-90, -20, 20, 60}) {
        Triangles scaled = triangles;
        for (Triangle& t : scaled) {
            for (glm::vec3& v : t.vertices) v *= std::ldexp(1.0f, exponent);
        }
        INFO("scaled by 2^" << exponent);
        CHECK(order(scaled, {}) == one);
    }
}
