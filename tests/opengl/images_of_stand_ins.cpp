// Images of parts of the scene whose contents are shaped on the GPU, in instances and outside.
#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/vec3.hpp>
#include <random>
#include <vector>

#include "farfield/approximation/image_cache.hpp"
#include "farfield/approximation/opacity_tensor.hpp"
#include "farfield/build.hpp"
#include "farfield/cost_model/triangle_count.hpp"
#include "farfield/measure/flip.hpp"
#include "farfield/partition/octree.hpp"
#include "farfield/primitive/instance.hpp"
#include "farfield/primitive/triangle.hpp"
#include "farfield/renderer/z_buffer_renderer.hpp"
#include "farfield/viewer.hpp"
#include "opengl/setting.hpp"
#include "support/views.hpp"

using namespace farfield;
using namespace farfield::test;
using opengl::GlRenderer;

TEST_CASE("OpenGL makes images of what it shapes, in instances too", "[opengl]") {
    OpenGl gl;
    if (!gl) return;
    {
        using H = SpatialHierarchy<Octree, ImageCache<OpacityTensor>, TriangleCount>;
        using Placed = Instance<H, Triangle>;
        std::mt19937 random(6);
        std::uniform_real_distribution<float> in(-1, 1);
        const auto point = [&] { return glm::vec3(in(random), in(random), in(random)); };
        std::vector<Triangle> leaves(6000);
        for (Triangle& t : leaves) {
            const glm::vec3 p = point();
            t = {{p, p + 0.05f * point(), p + 0.05f * point()}, {std::uint8_t(random() >> 8), 150, 40, 255}};
        }
        const auto tree = build<H>(leaves);
        std::vector<Placed> trees;
        for (int i = 0; i < 49; ++i) {
            glm::dmat4 m = glm::translate(glm::dmat4(1), glm::dvec3(4 * (i % 7), double(in(random)), 4 * (i / 7)));
            m = glm::rotate(m, 3 * double(in(random)), glm::dvec3(0.2, 1, double(in(random))));
            trees.push_back({.hierarchy = &tree, .primitives = leaves, .to_world = Similarity(m)});
        }
        const auto grove = build<H>(trees);
        const auto compare = [](const auto& hierarchy, const auto& primitives, View view) {
            GlRenderer renderer;
            ZBufferRenderer reference;
            auto viewer = make_viewer(hierarchy, primitives, renderer);
            auto by_processor = make_viewer(hierarchy, primitives, reference);
            std::uint64_t images = 0;
            for (int i = 0; i < 6; ++i) {
                images += viewer.frame(view).images;
                by_processor.frame(view);
                CHECK(flip(renderer.image(), reference.image()) < 0.03);
                view.camera.eye.x += 0.001;
            }
            return images;
        };
        const std::uint64_t images = compare(tree, leaves, looking({1, 2, 6}, {}, 120, 2)) +
                                     compare(grove, trees, looking({30, 20, 50}, {12, 0, 12}, 160, 1));
        CHECK(images > 0);
    }
    gl.check_clean();
}
