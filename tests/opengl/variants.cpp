// Every variant of the catalog, drawn by OpenGL and by the z-buffer.
#include "walkthrough/variants.hpp"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <memory>
#include <numeric>
#include <string>

#include "farfield/measure/flip.hpp"
#include "opengl/setting.hpp"
#include "scenes/catalog.hpp"
#include "scenes/generate/tree.hpp"
#include "scenes/scene.hpp"

using namespace farfield;
using namespace farfield::test;

namespace {

Image over(const Image& premultiplied, glm::vec3 background) {
    Image image = premultiplied;
    for (Rgba8& c : image.pixels()) {
        const auto channel = [&](std::uint8_t v, float b) {
            return std::uint8_t(std::min(255.0f, float(v) + b * float(255 - c.a) / 255));
        };
        c = {channel(c.r, background.x), channel(c.g, background.y), channel(c.b, background.z), 255};
    }
    return image;
}

scenes::Scene grove() {
    scenes::Scene scene;
    scenes::TreeOptions tree;
    tree.triangles = 4000;
    scene.groups.resize(2);
    scene.groups[0] = scenes::tree(tree).groups.back();
    for (int i = 0; i < 9; ++i) {
        glm::mat4 place(1);
        const float turn = 0.7f * float(i), c = std::cos(turn), s = std::sin(turn);
        place[0] = {c, 0, -s, 0};
        place[2] = {s, 0, c, 0};
        place[3] = {9.0f * float(i % 3), 0, 9.0f * float(i / 3), 1};
        scene.groups[1].placements.push_back({0, place});
    }
    return scene;
}

}  // namespace

TEST_CASE("OpenGL draws every variant as the z-buffer does", "[opengl]") {
    if (!OpenGl()) return;  // each renderer below makes its context, or has that of another
    const auto scene_name = GENERATE(as<std::string>(), "cube", "grove");
    const scenes::Scene scene = scene_name == "cube" ? scenes::make(scene_name) : grove();
    const auto bounds = scenes::bounds(scene);
    const glm::dvec3 center(bounds.center()), towards = glm::normalize(glm::dvec3(0.4, 0.5, 1));
    const double radius = 0.5 * double(glm::length(bounds.size()));
    int drawn = 0;
    for (const walkthrough::Variant& variant : walkthrough::variants()) {
        if (!variant.obstacle(scenes::RendererKind::opengl).empty()) continue;
        const auto built = variant.build(scene);
        for (const int samples : {1, 4}) {
            const auto viewer = [&](scenes::RendererKind kind) {
                return built->viewer({.kind = kind, .samples = samples});
            };
            const auto reference = viewer(scenes::RendererKind::z_buffer),
                       tested = viewer(scenes::RendererKind::opengl);
            for (const double distance : {1.6, 4.0, 14.0}) {
                for (const float tolerance : {1.0f, 4.0f}) {
                    const View view{
                        .camera = Camera::perspective(center + towards * (distance * radius), center, {0, 1, 0}, 0.9f),
                        .width = 96,
                        .height = 72,
                        .tolerance_px = tolerance,
                        .distance = variant.distance};
                    reference->frame(view);
                    const FrameStats stats = tested->frame(view);
                    for (const glm::vec3 background : {glm::vec3(0), glm::vec3(150, 190, 230)}) {
                        const double error =
                            flip(over(tested->image(), background), over(reference->image(), background));
                        INFO(scene_name << " " << variant.name << ", " << samples << " samples, " << distance
                                        << " radii, " << tolerance << " px, " << stats.splats << " splats, "
                                        << stats.faces << " faces, " << stats.images << " images");
                        CHECK(error <= 0.03);
                    }
                    ++drawn;
                }
            }
            CHECK(glGetError() == GLenum(GL_NO_ERROR));
        }
    }
    CHECK(drawn >= 12 * 5);  // with the variants that a first look has
    const auto live = opengl::live_objects();
    CHECK(std::accumulate(live.begin(), live.end(), std::size_t(0)) == 0);
}
