// Greene 1996, section 6.2: bodies that move through a static building. The lazy mode draws them from one hierarchy
// that has an instance of each; nothing of the building is built again.
#include "catch.hpp"
#include "farfield/approximation/exact.hpp"
#include "farfield/cost_model/triangle_count.hpp"
#include "farfield/partition/octree.hpp"
#include "scenes/generate/tumbling_hall.hpp"
#include "scenes/placed_scene.hpp"
#include "support/pictures.hpp"

using namespace farfield;
using namespace farfield::test;
using scenes::RendererKind;

TEST_CASE("gallery: tumbling parts through a building look the same by masks and by the z-buffer") {
    using Built = scenes::PlacedScene<SpatialHierarchy<Octree, Exact, TriangleCount>>;
    const scenes::TumblingHall hall = scenes::tumbling_hall();
    View view{.camera = scenes::inside_tumbling_hall(hall), .width = 96, .height = 64, .tolerance_px = 0};
    std::vector<View> views{view};
    view.camera = Camera::perspective({0.5, 1.6, -4}, {0.2, 1.2, 5}, {0, 1, 0}, 1.2f);  // in a room, through its door
    views.push_back(view);
    view.camera = Camera::perspective({14, 9, 17}, {}, {0, 1, 0}, 0.9f);  // from outside
    views.push_back(view);
    std::uint64_t hidden = 0;
    Image before;
    for (const double t : {0.0, 0.13, 0.4, 0.405, 0.77}) {
        const Built built(
            scenes::scene_at(hall, t), [](std::size_t) { return Octree{}; }, Exact{});
        const auto z_buffer = built.viewer({.samples = 64});
        const auto pyramid = built.viewer({.kind = RendererKind::hierarchical_z, .samples = 64});
        const auto masks = built.viewer({.kind = RendererKind::coverage, .samples = 64});
        for (std::size_t v = 0; v < views.size(); ++v) {
            INFO("time " << t << ", view " << v);
            z_buffer->frame(views[v]);
            pyramid->frame(views[v]);
            hidden += masks->frame(views[v]).cells_hidden;
            CHECK(different_pixels(masks->image(), z_buffer->image()) == 0);
            CHECK(different_pixels(pyramid->image(), z_buffer->image()) == 0);
            if (v != 0) continue;
            CHECK(masks->image() != before);  // something moves
            before = masks->image();
        }
    }
    CHECK(hidden > 100);
}
