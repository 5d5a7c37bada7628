// Frames within a budget draw the best that it pays for.
#include "farfield/frame/frame_budget.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <glm/common.hpp>
#include <glm/vector_relational.hpp>
#include <limits>
#include <tuple>
#include <vector>

#include "catch.hpp"
#include "farfield/approximation/color_cube.hpp"
#include "farfield/approximation/color_cube_cluster.hpp"
#include "farfield/approximation/exact.hpp"
#include "farfield/approximation/opacity_tensor.hpp"
#include "farfield/approximation/sample_set.hpp"
#include "farfield/build.hpp"
#include "farfield/cost_model/measured_time.hpp"
#include "farfield/cost_model/triangle_count.hpp"
#include "farfield/measure/image_error.hpp"
#include "farfield/partition/gap_bsp.hpp"
#include "farfield/partition/octree.hpp"
#include "farfield/primitive/instance.hpp"
#include "farfield/renderer/z_buffer_renderer.hpp"
#include "farfield/view/local_view.hpp"
#include "farfield/viewer.hpp"
#include "support/pictures.hpp"
#include "support/scenes.hpp"
#include "support/views.hpp"

using namespace farfield;
using namespace farfield::test;

namespace {

template <class A>
using Over = SpatialHierarchy<Octree, A, TriangleCount>;
using Hierarchies =
    std::tuple<Over<Exact>, Over<ColorCube>, Over<ColorCubeCluster<4>>, Over<OpacityTensor>, Over<SampleSet<AreaSplat>>,
               Over<SampleSet<OpacityTensor>>, SpatialHierarchy<SharedOctree, ColorCube, TriangleCount>,
               SpatialHierarchy<GapBsp, ColorCube, MeasuredTime>,
               SpatialHierarchy<ClippedGapBsp, Exact, TriangleCount>>;

std::vector<View> views(float tolerance) {
    return {looking({3, 1.2, 2.2}, {}, 96, tolerance), looking({0.4, 0.3, 0.9}, {-1, 0, 0.2}, 96, tolerance),
            looking_orthographic({5, 2, 3}, {}, 3, 96, tolerance)};
}

/// Draws what a budget of triangles pays for.
template <class H, class P = Triangle>
class Budgeted {
  public:
    Budgeted(const H& h, std::span<const P> primitives) : viewer_(h, primitives, renderer_) {}

    FrameStats frame(const View& view, double most, bool refines = false) {
        const FrameBudget budget{.prices = FramePrices::of_primitives(8), .most = most, .refines_still_views = refines};
        viewer_.select(view, budget, refinement_, selection_);
        return viewer_.draw(selection_);
    }
    Image exact(const View& view) {
        viewer_.frame(view);
        return renderer_.image();
    }
    const Image& image() const { return renderer_.image(); }
    const Refinement& refinement() const { return refinement_; }
    const Selection<H, P>& selection() const { return selection_; }
    /// By the budget's prices.
    double cost() const {
        const Work work = selection_.work();
        return double(work.triangles) + 8 * (double(work.faces) + double(work.splats));
    }

  private:
    ZBufferRenderer renderer_;
    Viewer<H, P, ZBufferRenderer> viewer_;
    Refinement refinement_;
    Selection<H, P> selection_;
};

using Cubes = Over<ColorCube>;

/// A triangle, or an instance of cubes over triangles.
struct Thing {
    Triangle triangle{};
    std::vector<Instance<Cubes, Triangle>> instance{};

    BoxD bounds() const {
        if (!instance.empty()) return instance[0].bounds();
        const Box b = triangle.bounds();
        return {glm::dvec3(b.lower), glm::dvec3(b.upper)};
    }
    Work work() const { return instance.empty() ? Work{.triangles = 1} : instance[0].work(); }
    template <class Sink>
    void polygons(Sink&& sink) const {
        instance.empty() ? triangle.polygons(sink) : instance[0].polygons(sink);
    }
    template <class F>
    bool visit_instance(F&& f) const {
        if (!instance.empty()) f(instance[0]);
        return !instance.empty();
    }
};

}  // namespace

TEMPLATE_LIST_TEST_CASE("a budget is never exceeded, and all is drawn where it suffices", "", Hierarchies) {
    const Triangles triangles = mixed_triangles(3000, 170);
    const TestType h = build<TestType>(triangles);
    Budgeted<TestType> budgeted(h, triangles);
    for (const float tolerance : {0.0f, 1.0f}) {
        for (const View& view : views(tolerance)) {
            const Image exact = budgeted.exact(view);
            INFO("the coarsest picture is drawn for nothing, where something stands in");
            budgeted.frame(view, 0);
            const double least = budgeted.refinement().spent();
            CHECK(budgeted.selection().entries().empty() == (least == 0));
            if (TestType::approximation_type::facts.stands_in) CHECK(least > 0);
            for (const double most : {4.0, 30.0, 200.0, 1000.0, 5000.0}) {
                INFO("budget " << most);
                budgeted.frame(view, most);
                CHECK(budgeted.refinement().spent() <= std::max(most, least));
                CHECK(budgeted.cost() <= 1.001 * std::max(most, least));
                const Image once = budgeted.image();
                budgeted.frame(view, most);
                CHECK(budgeted.image() == once);
            }
            budgeted.frame(view, 1e9);
            CHECK(budgeted.refinement().is_complete());
            CHECK(budgeted.image() == exact);
        }
    }
}

TEMPLATE_LIST_TEST_CASE("the error falls as the budget grows", "", Hierarchies) {
    const Triangles triangles = mixed_triangles(3000, 171);
    const TestType h = build<TestType>(triangles);
    Budgeted<TestType> budgeted(h, triangles);
    for (const View& view : views(0)) {
        const Image exact = budgeted.exact(view);
        double last = std::numeric_limits<double>::infinity(), first = -1;
        for (const double most : {300.0, 1500.0, 7000.0, 40000.0}) {
            INFO("budget " << most);
            budgeted.frame(view, most);
            const double error = mse(budgeted.image(), exact);
            CHECK(error <= 1.02 * last + 1e-6);
            last = error;
            if (first < 0) first = error;
        }
        CHECK(last <= 0.25 * first);
    }
}

TEMPLATE_LIST_TEST_CASE("a still view is refined until nothing changes any more", "", Hierarchies) {
    const Triangles triangles = mixed_triangles(2000, 172);
    const TestType h = build<TestType>(triangles);
    Budgeted<TestType> budgeted(h, triangles);
    const View view = views(0)[0];
    const Image exact = budgeted.exact(view);
    int frames = 0;
    double spent = 0;
    while (frames < 200 && !budgeted.refinement().is_complete()) {
        budgeted.frame(view, 400, true);
        ++frames;
        CHECK(budgeted.refinement().spent() >= spent);
        CHECK(budgeted.refinement().spent() <= 400.0 * frames);
        spent = budgeted.refinement().spent();
    }
    CHECK(frames > 2);
    CHECK(frames < 200);
    CHECK(budgeted.image() == exact);
    const Selected* const entries = budgeted.selection().entries().data();
    for (int i = 0; i < 3; ++i) {
        budgeted.frame(view, 400, true);
        CHECK(budgeted.image() == exact);
        CHECK(budgeted.selection().entries().data() == entries);
    }
    INFO("a view that moves begins anew");
    budgeted.frame(views(0)[1], 400, true);
    CHECK(budgeted.refinement().spent() <= 400);
}

TEST_CASE("budgets reach into instances") {
    const Triangles inner_triangles = random_triangles(2000, 173, 0.05f);
    const Cubes inner = build<Cubes>(inner_triangles);
    std::vector<Thing> things;
    Random random(174);
    for (int i = 0; i < 15; ++i) {
        const Similarity at(glm::mat3(1.0f), random.between(0.2f, 0.6f), glm::dvec3(random.in_cube(2)));
        things.push_back({{}, {Instance<Cubes, Triangle>{&inner, inner_triangles, at}}});
    }
    for (const Triangle& t : random_triangles(500, 175, 0.05f)) things.push_back({t, {}});
    const Cubes outer = build<Cubes>(things);
    Budgeted<Cubes, Thing> budgeted(outer, things);
    for (const View& view : views(0)) {
        const Image exact = budgeted.exact(view);
        double first = -1, last = 0;
        for (const double most : {1e3, 1e4, 1e5}) {
            INFO("budget " << most);
            budgeted.frame(view, most);
            CHECK(budgeted.cost() <= 1.001 * most);
            last = mse(budgeted.image(), exact);
            if (first < 0) first = last;
        }
        CHECK(last < 0.5 * first);
        budgeted.frame(view, 1e9);
        CHECK(budgeted.image() == exact);
    }
}

TEST_CASE("a viewer draws at once what it would select within a budget") {
    const Triangles triangles = mixed_triangles(3000, 176);
    const Cubes h = build<Cubes>(triangles);
    ZBufferRenderer renderer;
    Viewer<Cubes, Triangle, ZBufferRenderer> viewer(h, triangles, renderer);
    Refinement refinement;
    Selection<Cubes, Triangle> selection;
    double last = 0;
    const View view = views(0)[0];
    for (const double ns : {0.0, 1e5, 3e5, 1e6, 1e9}) {
        const FrameBudget budget{.most = ns};
        viewer.select(view, budget, refinement, selection);
        viewer.draw(selection);
        const Image selected = renderer.image();
        const FrameStats stats = viewer.frame(view, budget, refinement);
        CHECK(renderer.image() == selected);
        CHECK(stats.primitives + stats.approximations > 0);
        CHECK(refinement.spent() >= last);
        CHECK(refinement.work()[FrameWork::frames] == 1);
        CHECK(refinement.spent() == Approx(budget.prices.cost(refinement.work())));
        last = refinement.spent();
    }
    CHECK(refinement.is_complete());
}

TEST_CASE("something is seen from inside, however small the budget") {
    const Triangles triangles = random_triangles(4000, 182, 0.1f);
    const Cubes h = build<Cubes>(triangles);
    ZBufferRenderer renderer;
    auto viewer = make_viewer(h, triangles, renderer);
    Refinement refinement;
    for (const glm::dvec3& eye : {glm::dvec3(0.01), glm::dvec3(0.3, 0.2, -0.4)}) {
        viewer.frame(looking(eye, eye + glm::dvec3(1, 0.1, 0.2), 64, 0), FrameBudget{.most = 0}, refinement);
        int covered = 0;
        for (const Rgba8 c : renderer.image().pixels()) covered += c.a != 0;
        CHECK(covered > 64 * 64 / 8);
    }
}

TEST_CASE("a face beside the eye covers what is seen of it") {
    Random random(187);
    int partly_seen = 0;
    for (int i = 0; i < 400; ++i) {
        View view = looking(glm::dvec3(random.in_cube(1)), glm::dvec3(random.in_cube(1)), 64, 1);
        if (i % 4 == 0) view = looking_orthographic(glm::dvec3(random.in_cube(1)), glm::dvec3(3, 1, 2), 1, 64, 1);
        const LocalView local(view, glm::dvec3(0), 4.0f);
        const auto axis = std::uint8_t(i % 3);
        const glm::vec3 a(random.in_cube(1)), b(random.in_cube(1));
        Face face{glm::min(a, b), glm::max(a, b), {255, 255, 255, 255}, std::uint8_t(2 * axis)};
        face.upper[axis] = face.lower[axis];
        // Through the middles of pixels.
        int seen = 0;
        for (int y = 0; y < 64; ++y) {
            for (int x = 0; x < 64; ++x) {
                const glm::vec3 aside =
                    (local.right * (float(x) - 31.5f) + local.up * (float(y) - 31.5f)) / local.focal_px;
                const glm::vec3 from = local.is_perspective ? local.eye : local.eye + aside;
                const glm::vec3 way = local.is_perspective ? local.forward + aside : local.forward;
                const float t = (face.lower[axis] - from[axis]) / way[axis];
                if (!(t > local.near_depth)) continue;
                glm::vec3 hit = from + t * way;
                hit[axis] = face.lower[axis];
                seen +=
                    glm::all(glm::greaterThanEqual(hit, face.lower)) && glm::all(glm::lessThanEqual(hit, face.upper));
            }
        }
        partly_seen += seen > 100 && seen < 4000;
        INFO("face " << i);
        CHECK(std::abs(detail::seen_px(local, face) - float(seen)) <= 0.02f * float(seen) + 40);
    }
    CHECK(partly_seen > 40);
}

TEST_CASE("budgets that are none are refused") {
    const Triangles triangles = mixed_triangles(20, 177);
    const Cubes h = build<Cubes>(triangles);
    Budgeted<Cubes> budgeted(h, triangles);
    const View view = views(0)[0];
    for (const double most : {-1.0, std::nan("")}) {
        CHECK_THROWS_WITH(budgeted.frame(view, most), "farfield::FrameBudget: most must be 0 or more");
    }
    ZBufferRenderer renderer;
    Viewer<Cubes, Triangle, ZBufferRenderer> viewer(h, triangles, renderer);
    Refinement refinement;
    FrameBudget budget{.most = 1};
    budget.prices.each[FrameWork::cells] = -1;
    CHECK_THROWS_WITH(viewer.frame(view, budget, refinement),
                      "farfield::FramePrices: prices must be 0 or more and finite");
}
