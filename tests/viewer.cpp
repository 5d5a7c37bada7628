#include "farfield/viewer.hpp"

#include <algorithm>
#include <cmath>
#include <concepts>
#include <numeric>
#include <optional>
#include <span>
#include <stdexcept>
#include <thread>
#include <utility>
#include <vector>

#include "catch.hpp"
#include "farfield/approximation/color_cube.hpp"
#include "farfield/approximation/exact.hpp"
#include "farfield/approximation/opacity_tensor.hpp"
#include "farfield/build.hpp"
#include "farfield/cost_model/triangle_count.hpp"
#include "farfield/partition/octree.hpp"
#include "farfield/partition/polygon_bsp.hpp"
#include "farfield/renderer/hierarchical_z_renderer.hpp"
#include "scenes/renderers/coverage_tilers.hpp"
#include "support/pictures.hpp"
#include "support/scenes.hpp"
#include "support/variants.hpp"

using namespace farfield;
using namespace farfield::test;

namespace {

bool finite(const Recording& r) {
    const auto ok = [](glm::vec3 v) { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); };
    return std::all_of(r.faces.begin(), r.faces.end(), [&](const Face& f) { return ok(f.lower) && ok(f.upper); }) &&
           std::all_of(r.splats.begin(), r.splats.end(), [&](const Splat& s) {
               return ok(s.center) && std::isfinite(s.opacity) && std::isfinite(s.size.x * s.size.y) && s.size.x > 0 &&
                      s.size.y > 0;
           });
}

/// A face is seen only from the side it looks to.
std::size_t faces_that_look_away(const Recording& r, const LocalView& view) {
    return std::size_t(std::count_if(r.faces.begin(), r.faces.end(), [&](const Face& f) {
        const int axis = f.side / 2;
        const float along = view.towards_viewer(f.lower)[axis];
        return f.lower[axis] != f.upper[axis] || !(f.side & 1 ? along > 0 : along < 0);
    }));
}

}  // namespace

namespace {

using Exactly = SpatialHierarchy<Octree, Exact, TriangleCount>;

template <class... A>
concept CanBeViewed = requires(A&&... a) {
    make_viewer(std::forward<A>(a)...);
};
template <class... A>
concept MakesAViewer = std::constructible_from<Viewer<Exactly, Triangle, ZBufferRenderer>, A...>;

// What lives on may be borrowed, what is made in the call may not.
using Span = std::span<const Triangle>;
static_assert(CanBeViewed<Exactly&, Triangles&, ZBufferRenderer&> &&
              CanBeViewed<const Exactly&, const Triangles&, ZBufferRenderer&> &&
              CanBeViewed<Exactly&, Span&, ZBufferRenderer&> && CanBeViewed<Exactly&, Span, ZBufferRenderer&>);
static_assert(!CanBeViewed<Exactly, Triangles&, ZBufferRenderer&> && !CanBeViewed<Exactly, Span, ZBufferRenderer&> &&
              !CanBeViewed<Exactly&, Triangles, ZBufferRenderer&> &&
              !CanBeViewed<Exactly, Triangles, ZBufferRenderer&> &&
              !CanBeViewed<Exactly&, const Triangles, ZBufferRenderer&> &&
              !CanBeViewed<Exactly&, Triangles&, ZBufferRenderer> && !CanBeViewed<Exactly&, Span, ZBufferRenderer>);
static_assert(MakesAViewer<Exactly&, Triangles&, ZBufferRenderer&> && MakesAViewer<Exactly&, Span, ZBufferRenderer&>);
static_assert(!MakesAViewer<Exactly, Triangles&, ZBufferRenderer&> &&
              !MakesAViewer<Exactly&, Triangles, ZBufferRenderer&> &&
              !MakesAViewer<Exactly, Triangles, ZBufferRenderer&> &&
              !MakesAViewer<Exactly&, Triangles&, ZBufferRenderer>);
static_assert(!std::move_constructible<ZBufferRenderer> && !std::copy_constructible<ZBufferRenderer>,
              "viewers hold on to where it is");

}  // namespace

TEST_CASE("viewers of one renderer share what is uploaded, and the last takes it away") {
    const Triangles triangles = random_triangles(1000, 111);
    const Exactly h = build<Exactly>(triangles);
    ZBufferRenderer renderer;
    CHECK(renderer.uploaded_bytes() == 0);
    std::size_t bytes = 0;
    {
        auto one = make_viewer(h, triangles, renderer);
        bytes = renderer.uploaded_bytes();
        CHECK(bytes >= 40 * 1000);
        CHECK(bytes <= 42 * 1000);
        {
            auto other = make_viewer(h, triangles, renderer);
            CHECK(renderer.uploaded_bytes() == bytes);
            const View view = looking({6, 2, 4}, {}, 64);
            other.frame(view);
            const Image image = renderer.image();
            one.frame(view);
            CHECK(renderer.image() == image);
        }
        CHECK(renderer.uploaded_bytes() == bytes);
    }
    CHECK(renderer.uploaded_bytes() == 0);
}

TEST_CASE("a viewer may go after its renderer, and draws nothing without it") {
    const Triangles triangles = random_triangles(100, 112);
    const Exactly h = build<Exactly>(triangles);
    std::optional<Viewer<Exactly, Triangle, ZBufferRenderer>> viewer;
    using Tensors = SpatialHierarchy<Octree, OpacityTensor, TriangleCount>;
    const Tensors tensors = build<Tensors>(triangles);
    std::optional<Viewer<Exactly, Triangle, CoverageRenderer>> of_masks;
    std::optional<Viewer<Tensors, Triangle, ZBufferRenderer>> of_tensors;
    View coarse = looking({60, 20, 40});
    coarse.tolerance_px = 4;
    std::size_t selected = 0;
    {
        ZBufferRenderer renderer;
        CoverageRenderer masks;
        of_tensors.emplace(tensors, triangles, renderer);
        selected = of_tensors->select(coarse).entries().size();
        viewer.emplace(h, triangles, renderer);
        of_masks.emplace(h, triangles, masks);
        viewer->frame(looking({6, 2, 4}));
    }
    CHECK_THROWS_WITH(viewer->frame(looking({6, 2, 4})),
                      "farfield::Viewer: its renderer is gone; declare the renderer before the viewer");
    CHECK_THROWS_AS(of_masks->frame(looking({6, 2, 4})), std::logic_error);
    CHECK(viewer->select(looking({6, 2, 4})).entries().size() > 0);
    CHECK(of_tensors->select(coarse).entries().size() == selected);
}

TEST_CASE("pictures are the same from a renderer's copy and from the user's array") {
    const Triangles triangles = mixed_triangles(3000, 113);
    using Tensors = SpatialHierarchy<Octree, OpacityTensor, TriangleCount>;
    using Bsp = SpatialHierarchy<PolygonBsp, Exact, TriangleCount>;
    const Triangles few = random_triangles(200, 114, 0.5f);
    const auto tensors = build<Tensors>(triangles, {.sampler = DirectionalLight{}});
    const auto bsp = build<Bsp>(few);
    Triangles in_order = triangles;
    const auto in_place = build_in_place<Tensors>(in_order, {.sampler = DirectionalLight{}});
    const auto check = [&]<class R>(std::in_place_type_t<R>, const auto& h, const Triangles& primitives) {
        for (const bool deposits : {false, true}) {
            ZBufferOptions options{.samples = 4, .light = DirectionalLight{}, .deposits_small_triangles = deposits};
            R copying(options);
            options.copies_sources = false;
            R reading(options);
            auto from_copy = make_viewer(h, primitives, copying);
            auto from_array = make_viewer(h, primitives, reading);
            CHECK(reading.uploaded_bytes() <= (h.fragments().empty() ? 0 : 4 * (h.item_count() + 1)));
            CHECK(copying.uploaded_bytes() >= 40 * primitives.size());
            for (int i = 0; i < 8; ++i) {
                const View view =
                    looking({(9 - i) * std::cos(i), 1, (9 - i) * std::sin(i)}, {0.1, 0, 0}, 90, float(i % 3));
                from_copy.frame(view);
                from_array.frame(view);
                CHECK(copying.image() == reading.image());
            }
        }
    };
    check(std::in_place_type<ZBufferRenderer>, tensors, triangles);
    check(std::in_place_type<ZBufferRenderer>, in_place, in_order);
    check(std::in_place_type<ZBufferRenderer>, bsp, few);
    check(std::in_place_type<HierarchicalZRenderer>, tensors, triangles);
    check(std::in_place_type<HierarchicalZRenderer>, bsp, few);
}

TEST_CASE("what a frame says it did adds up") {
    const Triangles triangles = mixed_triangles(6000, 100);
    for (const Variant& variant : all_variants()) {
        const auto h = variant.build(triangles);
        for (const float tolerance : {0.0f, 1.0f, 8.0f}) {
            for (const glm::dvec3 eye : {glm::dvec3(12, 3, 8), glm::dvec3(0.1, 0.2, 0.3), glm::dvec3(2, 0, 0)}) {
                for (const float splat : {0.0f, 2.0f}) {
                    INFO(variant.name << ", tolerance " << tolerance << ", eye at " << eye.x << ", splats to "
                                      << splat);
                    Recorder recorder;
                    recorder.largest_splat = splat;
                    const View view = looking(eye, {0.3, 0, -0.2}, 200, tolerance);
                    const FrameStats s = h->frame(view, recorder);
                    CHECK(s.primitives == recorder.draws.size());
                    CHECK(s.runs == recorder.ranges);
                    CHECK(s.faces == recorder.faces.size());
                    CHECK(s.splats == recorder.splats.size());
                    CHECK(s.instances == 0);
                    CHECK(s.cells_hidden == 0);
                    CHECK(s.cells_visited >= s.cells_outside + s.approximations);
                    CHECK(s.cells_visited <= h->nodes().size());
                    CHECK(std::accumulate(std::begin(s.approximations_by_level), std::end(s.approximations_by_level),
                                          std::uint64_t(0)) == s.approximations);
                    CHECK(finite(recorder));
                    CHECK(faces_that_look_away(recorder, local_view<Triangle>(triangles, view)) == 0);
                    if (splat == 0) CHECK(recorder.splats.empty());
                }
            }
        }
    }
}

TEST_CASE("the working set counts nodes, stand-ins and item indices") {
    const Triangles triangles = random_triangles(6000, 101, 0.02f);
    for (const Variant& variant : all_variants()) {
        INFO(variant.name);
        const auto h = variant.build(triangles);
        Recorder recorder;
        const FrameStats s = h->frame(looking({6, 2, 4}, {}, 256, 2), recorder);
        CHECK(s.touched_bytes >= (s.cells_visited - s.cells_outside) * sizeof(Node));
        CHECK(s.touched_bytes <= h->bytes().size() + sizeof(Node));
    }
}

TEST_CASE("a viewer who looks away gets nothing") {
    const Triangles triangles = random_triangles(3000, 102, 0.02f);
    for (const Variant& variant : all_variants()) {
        INFO(variant.name);
        const auto h = variant.build(triangles);
        for (const View& view :
             {looking({6, 2, 4}, {12, 4, 8}, 128, 2), looking_orthographic({20, 0, 0}, {20, 1, 0}, 3, 128, 2)}) {
            Recorder recorder;
            const FrameStats s = h->frame(view, recorder);
            CHECK(s.primitives + s.faces + s.splats == 0);
            CHECK(s.cells_outside >= 1);
        }
    }
}

TEST_CASE("an eye on corners, edges and faces of cells, and inside of them, gets numbers") {
    const Triangles triangles = mixed_triangles(4000, 103);
    Random random(104);
    for (const Variant& variant : all_variants()) {
        const auto h = variant.build(triangles);
        const auto nodes = all_nodes(*h);
        Recorder recorder;
        ZBufferRenderer renderer;
        const auto viewer = h->viewer(recorder);
        const auto drawing = h->viewer(renderer);
        for (int i = 0; i < 60; ++i) {
            const Cell& cell = nodes[random.below(std::uint32_t(nodes.size()))].cell;
            glm::vec3 eye = cell.center;
            for (int axis = 0; axis < 3; ++axis) eye[axis] += cell.half[axis] * float(int(random.below(3)) - 1);
            glm::vec3 ahead(0);
            ahead[i % 3] = i % 2 ? 1.0f : -1.0f;
            if (i % 4 == 3) ahead = random.direction();
            View view = i % 5 == 4 ? looking_orthographic(eye, glm::dvec3(eye) + glm::dvec3(ahead), 1, 48, 4)
                                   : looking(eye, glm::dvec3(eye) + glm::dvec3(ahead), 48, 4);
            view.distance = i % 7 == 6 ? DistanceMeasure::depth : DistanceMeasure::nearest_point;
            INFO(variant.name << ", view " << i);
            recorder.clear();
            recorder.largest_splat = i % 2 ? 2.0f : 0.0f;
            viewer->frame(view);
            CHECK(finite(recorder));
            CHECK(faces_that_look_away(recorder, local_view<Triangle>(triangles, view)) == 0);
            drawing->frame(view);
            view.tolerance_px = 0;
            recorder.clear();
            CHECK(viewer->frame(view).approximations == 0);
            drawing->frame(view);
            CHECK(variant.is_plain(renderer.image(), plain_picture<Triangle>(triangles, view)));
        }
    }
}

TEST_CASE("stand-ins drawn have at most the error that is tolerated, and those above them have more") {
    const Triangles triangles = random_triangles(6000, 105, 0.02f);
    for (const Variant& variant : all_variants()) {
        if (!variant.stands_in) continue;
        const auto h = variant.build(triangles);
        const auto nodes = all_nodes(*h);
        for (const DistanceMeasure measure : {DistanceMeasure::nearest_point, DistanceMeasure::depth}) {
            for (const bool orthographic : {false, true}) {
                View view =
                    orthographic ? looking_orthographic({6, 2, 4}, {}, 40, 256, 4) : looking({17, 6, 12}, {}, 256, 4);
                view.distance = measure;
                const LocalView local = local_view<Triangle>(triangles, view);
                // The cut by definition, without shortcuts: the topmost stand-ins within tolerance.
                std::vector<int> covered(h->nodes().size());
                std::uint64_t cut = 0;
                for (const NodeRef& n : nodes) {
                    if (n.index != n.parent && covered[n.parent]) {
                        covered[n.index] = 1;
                        continue;
                    }
                    const PlaneMask crossed =
                        crossed_planes(local.planes, n.cell.bounds_center, n.cell.bounds_half, all_planes);
                    if (crossed == outside_a_plane) {
                        covered[n.index] = 1;
                    } else if (n.stand_in >= 0 &&
                               h->error_px(std::size_t(n.stand_in), n.cell, local) <= view.tolerance_px) {
                        covered[n.index] = 1;
                        ++cut;
                    }
                }
                INFO(variant.name << (orthographic ? ", orthographic" : ", perspective")
                                  << (measure == DistanceMeasure::depth ? ", depth" : ", nearest point"));
                Recorder recorder;
                CHECK(h->frame(view, recorder).approximations == cut);
                CHECK((cut > 0 || !variant.has_octants));
            }
        }
    }
}

TEST_CASE("what a renderer calls hidden is not drawn") {
    const Triangles triangles = random_triangles(3000, 106, 0.02f);
    for (const Variant& variant : all_variants()) {
        INFO(variant.name);
        const auto h = variant.build(triangles);
        Recorder recorder;
        recorder.hides_everything = true;
        const FrameStats s = h->frame(looking({2, 1, 1}, {}, 256, 0), recorder);
        CHECK(s.primitives == 0);
        CHECK(s.cells_hidden == 1);
    }
}

TEST_CASE("two viewers on two threads see what they see one after the other") {
    const Triangles triangles = mixed_triangles(5000, 107);
    std::vector<View> path;
    for (int i = 0; i < 8; ++i)
        path.push_back(looking({6 * std::cos(i * 0.3), 1, 6 * std::sin(i * 0.3)}, {}, 96, float(i % 3)));
    for (const Variant& variant : all_variants()) {
        INFO(variant.name);
        const auto h = variant.build(triangles);
        const auto images = [&](int first) {
            std::vector<Image> out;
            ZBufferRenderer renderer(ZBufferOptions{.samples = 4});
            const auto viewer = h->viewer(renderer);
            for (std::size_t i = 0; i < path.size(); ++i) {
                viewer->frame(path[(i + std::size_t(first)) % path.size()]);
                out.push_back(renderer.image());
            }
            return out;
        };
        const auto a = images(0), b = images(3);
        std::vector<Image> c, d;
        std::thread other([&] { c = images(0); });
        d = images(3);
        other.join();
        CHECK(a == c);
        CHECK(b == d);
    }
}

TEST_CASE("a viewer refuses other primitives than the hierarchy was built from, by number") {
    const Triangles triangles = random_triangles(100, 108);
    for (const Variant& variant : all_variants()) {
        INFO(variant.name);
        const auto h = variant.build(triangles);
        Recorder recorder;
        for (const std::size_t count : {0u, 1u, 99u}) {
            CHECK_THROWS_AS(h->viewer_of(std::span<const Triangle>(triangles).first(count), recorder),
                            std::invalid_argument);
        }
        Triangles more = triangles;
        more.push_back(triangles[0]);
        CHECK_THROWS_AS(h->viewer_of(more, recorder), std::invalid_argument);
        CHECK_NOTHROW(h->viewer_of(triangles, recorder));
        CHECK(recorder.paged_in == recorder.paged_out);
    }
}

TEST_CASE("a renderer that blends back to front gets stand-ins after everything else, farthest first") {
    using Cubes = SpatialHierarchy<Octree, ColorCube, TriangleCount>;
    const Triangles triangles = random_triangles(8000, 109, 0.02f);
    const Cubes h = build<Cubes>(triangles);
    const View view = looking({7, 2, 5}, {0, 0, 0}, 256, 7.5f);
    BackToFrontRecorder reversed;
    Recorder straight;
    const FrameStats stats = make_viewer(h, triangles, reversed).frame(view);
    make_viewer(h, triangles, straight).frame(view);
    CHECK(stats.faces == reversed.faces.size());
    CHECK(reversed.faces.size() > 100);
    CHECK(reversed.draws.size() > 100);
    for (const auto& draw : reversed.draws) REQUIRE(draw.faces_before == 0);
    REQUIRE(straight.faces.size() == reversed.faces.size());
    // The same faces, by cells in the opposite order.
    std::size_t different = 0;
    for (std::size_t i = 0; i < straight.faces.size(); ++i) {
        const Face &a = straight.faces[i], &b = reversed.faces[reversed.faces.size() - 1 - i];
        different += a.lower != b.lower || a.side != b.side;
    }
    CHECK(different == 0);
}

TEST_CASE("stand-ins come front to back: no cell's before that of a cell in front of it") {
    for (const Variant& variant : all_variants()) {
        if (!variant.stands_in || variant.is_shared) continue;
        const Triangles triangles = random_triangles(8000, 110, 0.02f);
        const auto h = variant.build(triangles);
        for (const bool orthographic : {false, true}) {
            Recorder recorder;
            recorder.largest_splat = 100;
            const View view =
                orthographic ? looking_orthographic({5, 2, 3}, {}, 20, 256, 8) : looking({7, 2, 5}, {}, 256, 8);
            h->frame(view, recorder);
            const LocalView local = local_view<Triangle>(triangles, view);
            // Tensors measure an error, which in cells of any shape is mostly above the tolerance.
            if (!variant.is_clipped && variant.has_octants) REQUIRE(recorder.splats.size() > 20);
            // Of two boxes on one ray, apart on an axis, the nearer one on that axis is in front. Same for all axes:
            // nothing later may be nearer on all of them.
            std::size_t wrong = 0;
            for (std::size_t i = 0; i < recorder.splats.size(); i += 7) {
                for (std::size_t j = i + 1; j < recorder.splats.size(); ++j) {
                    const glm::vec3 first = local.towards_viewer(recorder.splats[i].center),
                                    later = local.towards_viewer(recorder.splats[j].center);
                    const float side = std::max(recorder.splats[i].size.x, recorder.splats[j].size.x);
                    const glm::vec3 towards = glm::normalize(first);
                    // Later, straight in front of the first, by more than a cell: never.
                    const glm::vec3 d = recorder.splats[j].center - recorder.splats[i].center;
                    const float ahead = glm::dot(d, towards);
                    wrong +=
                        ahead > 2 * side && glm::length(d - towards * ahead) < 0.1f * side && glm::length(later) > 0;
                }
            }
            INFO(variant.name);
            CHECK(wrong == 0);
        }
    }
}
