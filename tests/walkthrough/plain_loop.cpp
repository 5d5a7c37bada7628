#include "plain_loop.hpp"

#include <glm/gtc/matrix_transform.hpp>

#include "catch.hpp"

using namespace walkthrough;
namespace scenes = farfield::scenes;

namespace {

scenes::Scene row_of_triangles(int count) {
    scenes::Scene scene;
    scene.groups.resize(2);
    farfield::VertexColoredTriangle t;
    t.vertices = {glm::vec3(0), glm::vec3(1, 0, 0), glm::vec3(0, 1, 0)};
    t.rgba = {farfield::Rgba8{200, 40, 40, 255}, {200, 40, 40, 255}, {200, 40, 40, 255}};
    scene.groups[0].triangles = {t};
    for (int i = 0; i < count; ++i) {
        scene.groups[1].placements.push_back({0, glm::translate(glm::mat4(1), glm::vec3(1.5f * float(i), 0, 0))});
    }
    return scene;
}

farfield::View along_z(double x) {
    farfield::View view;
    view.camera = farfield::Camera::perspective({x, 0.5, 8}, {x, 0.5, 0}, {0, 1, 0}, 1.0f);
    view.width = view.height = 64;
    view.tolerance_px = 0;
    return view;
}

int covered(const farfield::Image& image) {
    int count = 0;
    for (const farfield::Rgba8 c : image.pixels()) count += c.a > 0;
    return count;
}

}  // namespace

TEST_CASE("a plain loop draws every instance of a scene") {
    PlainLoop one(row_of_triangles(1), 1), four(row_of_triangles(4), 1);
    CHECK(four.triangles() == 4);
    CHECK(four.drawn_triangles() == 4);
    CHECK(one.ms(along_z(2.5)) > 0);
    CHECK(four.ms(along_z(2.5)) > 0);
    CHECK(covered(one.image()) > 0);
    CHECK(covered(four.image()) == 4 * covered(one.image()));
}

TEST_CASE("of more triangles than may be drawn an even part is, and said") {
    const PlainLoop loop(row_of_triangles(10'000), 1, 500);
    CHECK(loop.triangles() == 10'000);
    CHECK(loop.drawn_triangles() >= 490);
    CHECK(loop.drawn_triangles() <= 510);
    // Instances of instances, few of which are the root's own.
    scenes::Scene nested = row_of_triangles(10'000);
    nested.groups.push_back({{}, {{1, glm::mat4(1)}, {1, glm::translate(glm::mat4(1), glm::vec3(0, 9, 0))}}});
    PlainLoop both(nested, 1, 500);
    CHECK(both.triangles() == 20'000);
    CHECK(both.drawn_triangles() >= 490);
    CHECK(both.drawn_triangles() <= 510);
    CHECK(PlainLoop(nested, 1, 1).drawn_triangles() > 0);
    CHECK(both.ms(along_z(2.5)) > 0);
    CHECK(PlainLoop::draws(1));
    CHECK(PlainLoop::draws(64));
    CHECK(!PlainLoop::draws(16));
}
