#include "farfield/frame/baked_light.hpp"

#include <glm/gtc/matrix_transform.hpp>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "catch.hpp"
#include "farfield/approximation/color_cube.hpp"
#include "farfield/approximation/exact.hpp"
#include "farfield/build.hpp"
#include "farfield/cost_model/triangle_count.hpp"
#include "farfield/partition/octree.hpp"
#include "farfield/primitive/instance.hpp"
#include "farfield/renderer/hierarchical_z_renderer.hpp"
#include "farfield/renderer/z_buffer_renderer.hpp"
#include "farfield/storage/open.hpp"
#include "farfield/storage/save.hpp"
#include "farfield/viewer.hpp"
#include "scenes/renderers/coverage_tilers.hpp"
#include "support/recorder.hpp"
#include "support/scenes.hpp"

using namespace farfield;
using namespace farfield::test;

namespace {

using Cubes = SpatialHierarchy<Octree, ColorCube, TriangleCount>;
using Exactly = SpatialHierarchy<Octree, Exact, TriangleCount>;
using Placed = Instance<Cubes, Triangle>;

const DirectionalLight light{}, brighter{.ambient = 0.5f, .diffuse = 0.5f}, from_below{.towards = {0, -1, 0}},
    longer{.towards = light.towards * 7.0f};

template <class R = ZBufferRenderer, class H, class P>
std::string refusal(const H& h, const std::vector<P>& primitives, const std::optional<DirectionalLight>& given) {
    R renderer({.light = given});
    try {
        make_viewer(h, primitives, renderer);
        return "taken";
    } catch (const std::invalid_argument& e) {
        return e.what();
    }
}

/// A sampler that says nothing of light.
struct Silent {
    GridSampler inner{};
    void sample(const SampleGrid& grid, auto&& visit, std::span<Rgba8> out) { inner.sample(grid, visit, out); }
};

}  // namespace

TEST_CASE("stand-ins and primitives have one light, or there is no viewer") {
    const Triangles triangles = random_triangles(2000, 190, 0.03f);
    const Cubes lit = build<Cubes>(triangles, {.sampler = light}), unlit = build<Cubes>(triangles);
    REQUIRE(lit.stand_ins().size() > 10);
    const std::string end = ": give the build's options the same, as .sampler = light";
    const std::string name = "towards (0.300000, 0.900000, 0.320000), ambient 0.350000, diffuse 0.650000";
    CHECK(refusal(lit, triangles, light) == "taken");
    CHECK(refusal(lit, triangles, longer) == "taken");
    CHECK(refusal(unlit, triangles, std::nullopt) == "taken");
    CHECK(refusal(unlit, triangles, light) ==
          "farfield::Viewer: the hierarchy's stand-ins were built without a light and the renderer has one " + name +
              end);
    CHECK(refusal(lit, triangles, std::nullopt) ==
          "farfield::Viewer: the hierarchy's stand-ins were built with a light " + name + " and the renderer has none" +
              end);
    CHECK(refusal(lit, triangles, brighter) != "taken");
    CHECK(refusal(lit, triangles, from_below) != "taken");
    CHECK(refusal<HierarchicalZRenderer>(lit, triangles, light) == "taken");
    CHECK(refusal<HierarchicalZRenderer>(unlit, triangles, light) != "taken");
    CHECK(refusal<CoverageRenderer>(lit, triangles, light) == "taken");
    CHECK(refusal<CoverageRenderer>(unlit, triangles, light) != "taken");
    // A renderer that does not tell is not asked.
    Recorder recorder;
    CHECK_NOTHROW(make_viewer(lit, triangles, recorder));
}

TEST_CASE("the light stays with a hierarchy through a file") {
    const Triangles triangles = random_triangles(2000, 191, 0.03f);
    for (const bool is_lit : {false, true}) {
        const Cubes h = build<Cubes>(triangles, {.sampler = is_lit ? GridSampler(light) : GridSampler()});
        std::vector<std::byte> bytes(saved_size(h));
        save(h, std::span(bytes));
        const Cubes opened = open<Cubes>(std::span<const std::byte>(bytes));
        CHECK((refusal(opened, triangles, light) == "taken") == is_lit);
        CHECK((refusal(opened, triangles, std::nullopt) == "taken") == !is_lit);
    }
}

TEST_CASE("where nothing is baked, or nobody knows what, any light will do") {
    const Triangles triangles = random_triangles(2000, 192, 0.03f);
    CHECK(refusal(build<Exactly>(triangles), triangles, light) == "taken");
    CHECK(refusal(build<Cubes>(triangles, BuildOptions<Cubes, Silent>{}), triangles, light) == "taken");
    const Triangles few(3);
    CHECK(refusal(build<Cubes>(few), few, light) == "taken");
}

TEST_CASE("instances have the light as it is outside, or as it comes in their own axes") {
    const Triangles triangles = random_triangles(2000, 193, 0.03f);
    const glm::mat4 turn = glm::rotate(glm::mat4(1), 0.7f, glm::vec3(1, 0, 0));
    const DirectionalLight inside{.towards = glm::transpose(glm::mat3(turn)) * light.towards};
    const Cubes lit = build<Cubes>(triangles, {.sampler = light}), unlit = build<Cubes>(triangles),
                lit_inside = build<Cubes>(triangles, {.sampler = inside}),
                lit_from_below = build<Cubes>(triangles, {.sampler = from_below});
    const auto placed = [&](const Cubes& h) { return std::vector<Placed>{{&h, triangles, Similarity(turn)}}; };
    for (const auto& [h, is_right] : {std::pair(&lit, true), std::pair(&unlit, false), std::pair(&lit_inside, true),
                                      std::pair(&lit_from_below, false)}) {
        const auto scene = placed(*h);
        const auto outer = build<Exactly>(scene);
        CHECK((refusal(outer, scene, light) == "taken") == is_right);
    }
}
