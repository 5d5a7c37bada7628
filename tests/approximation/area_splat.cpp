#include "farfield/approximation/area_splat.hpp"

#include <cmath>
#include <string>
#include <vector>

#include "catch.hpp"
#include "farfield/sampler/grid_sampler.hpp"
#include "support/pictures.hpp"
#include "support/scenes.hpp"

using namespace farfield;
using namespace farfield::test;

namespace {

Cell cell_at(glm::vec3 center, float half) {
    Cell c;
    c.center = c.bounds_center = center;
    c.half = glm::vec3(half);
    c.bounds_half = glm::vec3(2 * half);
    return c;
}
AreaSplat::stand_in_draft sampled(const AreaSplat& a, const Cell& cell, const Triangles& triangles) {
    GridSampler sampler;
    return a.sample(
        cell,
        [&](auto&& sink) {
            for (const Triangle& t : triangles) t.polygons(sink);
        },
        sampler);
}
struct Sink {
    float splat_limit_px = 2;
    std::vector<Face>* faces;
    std::vector<Splat>* splats;
    void operator()(const Face& f) const { faces->push_back(f); }
    void operator()(const Splat& s) const { splats->push_back(s); }
};
struct Drawn {
    std::vector<Face> faces;
    std::vector<Splat> splats;
};
Drawn drawn(const AreaSplat& a, const AreaSplat::stand_in_data& data, const Cell& cell, glm::dvec3 eye,
            float splat_limit_px = 2) {
    const LocalView view(looking(eye, glm::dvec3(cell.center), 256, 1), glm::dvec3(0),
                         Box{glm::vec3(-4), glm::vec3(4)});
    Drawn out;
    a.draw_stand_in(data, cell, view, Sink{splat_limit_px, &out.faces, &out.splats});
    return out;
}

}  // namespace

TEST_CASE("a splat is as large as what surfaces show, at their center", "[approximation]") {
    const Cell cell = cell_at({0.5f, 0, 0}, 1);
    const Triangles wall = sheet({0.75f, -0.5f, -0.5f}, {0, 1, 0}, {0, 0, 1}, 3, 3, {200, 100, 50});
    const AreaSplat a;
    const auto data = a.finish(cell, sampled(a, cell, wall));
    const Drawn d = drawn(a, data, cell, {300, 0, 0});
    REQUIRE(d.splats.size() == 1);
    CHECK(d.faces.empty());
    const Splat& s = d.splats[0];
    CHECK(s.opacity == 1);
    CHECK(std::abs(s.size.x * s.size.y - 1) < 0.02f);
    CHECK(glm::length(s.center - glm::vec3(0.75f, 0, 0)) < 0.03f);
    CHECK(s.rgb.r == 200);
    CHECK(s.rgb.g == 100);
    CHECK(s.rgb.b == 50);
    const AreaSplat whole{.size = AreaSplat::Size::of_cell};
    const Drawn all = drawn(whole, whole.finish(cell, sampled(whole, cell, wall)), cell, {300, 0, 0});
    CHECK(std::abs(all.splats[0].size.x - 2) < 1e-3f);
    CHECK(drawn(a, data, cell, {300, 0, 0}, 0).faces.size() == 1);
}

TEST_CASE("what lies in all directions shows its mean, and nothing shows more than it has", "[approximation]") {
    const Cell cell = cell_at({}, 1);
    const AreaSplat a;
    const auto area_from = [&](const AreaSplat::stand_in_data& data, glm::dvec3 direction) {
        const Drawn d = drawn(a, data, cell, 300.0 * glm::normalize(direction));
        return d.splats.empty() ? 0.0f : d.splats[0].size.x * d.splats[0].size.y;
    };
    const auto directions = [](const auto& f) {
        for (int i = 0; i < 400; ++i) {  // evenly over the sphere
            const double z = (2 * i + 1) / 400.0 - 1, r = std::sqrt(1 - z * z), turn = 2.39996 * i;
            f(glm::dvec3(r * std::cos(turn), r * std::sin(turn), z));
        }
    };
    Triangles cloud = random_triangles(300, 7, 0.05f);
    Triangles one(cloud.begin(), cloud.begin() + 1), ground = sheet({-1, -1, 0}, {2, 0, 0}, {0, 2, 0}, 1, 1, {9, 9, 9});
    for (const Triangles* scene : {&cloud, &one, &ground}) {
        const auto draft = sampled(a, cell, *scene);
        const auto data = a.finish(cell, draft);
        double sum = 0, truth = 0;
        directions([&](glm::dvec3 d) {
            sum += double(area_from(data, d)) / 400;
            for (const Triangle& t : *scene) {
                truth += std::abs(glm::dot(
                             glm::dvec3(glm::cross(t.vertices[1] - t.vertices[0], t.vertices[2] - t.vertices[0])), d)) /
                         800;
            }
        });
        CHECK(std::abs(sum / truth - 1) < (scene == &one ? 0.2 : 0.04));  // bytes round what is small
    }
}

TEST_CASE("ground that goes on is closed from everywhere", "[approximation]") {
    const AreaSplat a;
    const Cell cell = cell_at({}, 1);
    for (const float height : {0.0f, 0.1f, 0.3f}) {
        Triangles ridge = sheet({-1, -height, -1}, {1, 2 * height, 0}, {0, 0, 2}, 2, 2, {9, 9, 9});
        append(ridge, sheet({0, height, -1}, {1, -2 * height, 0}, {0, 0, 2}, 2, 2, {9, 9, 9}));
        const auto data = a.finish(cell, sampled(a, cell, ridge));
        for (const double turn : {0.0, 0.4, 0.785}) {
            for (const double slope : {0.05, 0.15, 0.5, 1.2}) {
                const glm::dvec3 eye(std::cos(turn) * std::cos(slope), std::sin(slope),
                                     std::sin(turn) * std::cos(slope));
                const Drawn d = drawn(a, data, cell, 300.0 * eye);
                REQUIRE(d.splats.size() == 1);
                // Neighboring cells, and so their splats, are a side of the cell apart, which is 2.
                const glm::vec2 size = d.splats[0].size;
                INFO(height << ", " << turn << ", " << slope << ": " << size.x << " x " << size.y);
                CHECK(size.x >= 1.8f * float(std::cos(turn)));
                CHECK(size.y >= 1.8f * float(std::cos(turn) * std::sin(slope)));
            }
        }
    }
}

TEST_CASE("what is flat shows next to nothing from its edge, but as a whole cell it has no holes from anywhere",
          "[approximation]") {
    const Cell cell = cell_at({}, 1);
    const Triangles ground = sheet({-1, 0, -1}, {2, 0, 0}, {0, 0, 2}, 2, 2, {9, 9, 9});
    const AreaSplat areas, whole{.size = AreaSplat::Size::of_cell};
    const auto data = areas.finish(cell, sampled(areas, cell, ground));
    // Its center, in a byte a coordinate, is not quite its own, and may be where nothing at all is seen of it.
    const double height = double(drawn(whole, data, cell, {300, 0, 0}).splats.at(0).center.y);
    for (const Splat& splat : drawn(areas, data, cell, {300, 0, 0}).splats) CHECK(splat.size.x * splat.size.y < 0.01f);
    CHECK(drawn(areas, data, cell, {300, height, 0}).splats.empty());
    const Drawn all = drawn(whole, data, cell, {300, height, 0});
    REQUIRE(all.splats.size() == 1);
    CHECK(std::abs(all.splats[0].size.x - 2) < 1e-3f);
}

TEST_CASE("sheets of two colors show the one in front", "[approximation]") {
    const Cell cell = cell_at({}, 1);
    Triangles sheets = sheet({-0.1f, -1, -1}, {0, 2, 0}, {0, 0, 2}, 4, 4, {0, 0, 255});
    append(sheets, sheet({0.1f, -1, -1}, {0, 2, 0}, {0, 0, 2}, 4, 4, {255, 0, 0}));
    const AreaSplat a;
    const auto data = a.finish(cell, sampled(a, cell, sheets));
    CHECK(drawn(a, data, cell, {300, 0, 0}).splats[0].rgb.r == 255);
    CHECK(drawn(a, data, cell, {300, 0, 0}).splats[0].rgb.b == 0);
    CHECK(drawn(a, data, cell, {-300, 0, 0}).splats[0].rgb.b == 255);
    // The paper's color is one of both.
    const AreaSplat mean{.samples = 0};
    CHECK(drawn(mean, mean.finish(cell, sampled(mean, cell, sheets)), cell, {300, 0, 0}).splats[0].rgb.b > 100);
}

TEST_CASE("children's areas and centers add up", "[approximation]") {
    const Cell parent = cell_at({0, 0, 0}, 1), left = cell_at({-0.5f, -0.5f, -0.5f}, 0.5f),
               right = cell_at({0.5f, -0.5f, -0.5f}, 0.5f);
    const Triangles one = sheet({-0.7f, -0.7f, -0.7f}, {0.3f, 0, 0}, {0, 0.3f, 0}, 2, 2, {255, 255, 255}),
                    two = sheet({0.3f, -0.7f, -0.7f}, {0.4f, 0, 0}, {0, 0.3f, 0}, 2, 2, {255, 255, 255});
    Triangles both = one;
    append(both, two);
    const AreaSplat a;
    const auto l = sampled(a, left, one), r = sampled(a, right, two), all = sampled(a, parent, both);
    AreaSplat::stand_in_draft merged{};
    const std::vector<ChildDraft<AreaSplat::stand_in_draft>> children{{0, &left, &l}, {1, &right, &r}};
    a.merge(parent, merged, children);
    CHECK(std::abs(merged.area - all.area) < 1e-5f);
    CHECK(glm::length(merged.moment - all.moment) < 1e-5f);
}

TEST_CASE("what is without area has no splat that pays, and what is drawn already leaves less", "[approximation]") {
    const AreaSplat a;
    const Cell cell = cell_at({}, 1);
    const auto nothing = a.finish(cell, sampled(a, cell, {Triangle{{glm::vec3(0), glm::vec3(0), glm::vec3(0)}, {}}}));
    CHECK(a.is_sound(nothing));
    CHECK(std::isinf(a.work(nothing).splats));
    CHECK(a.rest_of(nothing, 0.5f) == nothing);
    CHECK(drawn(a, nothing, cell, {300, 0, 0}).splats.empty());

    const auto thin = a.finish(cell, sampled(a, cell, sheet({0, -1, -1}, {0, 0.1f, 0}, {0, 0, 2}, 1, 1, {9, 9, 9})));
    CHECK(drawn(a, thin, cell, {300, 0, 0}).splats[0].rgb.r == 9);  // no sample has hit it
    const auto area = [&](const AreaSplat::stand_in_data& d) {
        const glm::vec2 size = drawn(a, d, cell, {300, 0, 0}).splats[0].size;
        return size.x * size.y;
    };
    CHECK(std::abs(area(a.rest_of(thin, 0.5f)) / area(thin) - 0.5f) < 0.02f);  // little hides little
    const auto solid = a.finish(cell, sampled(a, cell, random_triangles(4000, 3, 0.5f)));
    CHECK(area(a.rest_of(solid, 0.5f)) == area(solid));  // what covers all has no gaps, whatever is drawn
    CHECK(std::string(AreaSplat{.samples = 9}.wrong_option()).find("samples") != std::string::npos);
    CHECK(AreaSplat{.shown = 0}.wrong_option() != nullptr);
}
