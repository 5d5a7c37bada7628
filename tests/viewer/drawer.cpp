// The threads that build and draw, without a window.
#include "drawer.hpp"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <fstream>
#include <functional>
#include <memory>
#include <optional>
#include <stdexcept>
#include <thread>
#include <vector>

#include "builder.hpp"
#include "catch.hpp"
#include "farfield/build.hpp"
#include "farfield/measure/flip.hpp"
#include "farfield/paging/write_pages.hpp"
#include "navigator.hpp"
#include "report/picture.hpp"
#include "scenes/paged_variants.hpp"
#include "support/random.hpp"
#include "support/temporary_directory.hpp"

using namespace viewer;
using farfield::FrameStats;
using farfield::View;
using farfield::scenes::CellOutline;
using farfield::scenes::RendererKind;

namespace {

/// Fails rather than wait for ever.
template <class T>
T wait_for(const std::function<std::optional<T>()>& news) {
    const auto end = std::chrono::steady_clock::now() + std::chrono::minutes(5);
    while (std::chrono::steady_clock::now() < end) {
        if (auto found = news()) return std::move(*found);
        std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
    throw std::runtime_error("nothing came");
}

BuilderNews news_of(Builder& builder) {
    return wait_for<BuilderNews>([&] { return builder.news(); });
}
Drawn drawn_by(Drawer& drawer, Order order) {
    drawer.draw(std::move(order));
    return wait_for<Drawn>([&] { return drawer.drawn(); });
}

View view_of(const Stage& stage, int width, int height) {
    View view;
    view.camera = Navigator(stage.bounds, stage.up).camera();
    view.width = width;
    view.height = height;
    return view;
}

std::size_t variant_of(const Stage& stage, const std::string& name) {
    for (std::size_t i = 0; i < stage.variants.size(); ++i) {
        if (stage.variants[i].name == name) return i;
    }
    throw std::runtime_error("no variant " + name);
}

}  // namespace

TEST_CASE("what is opened, built and drawn on threads is what is drawn without them") {
    std::atomic<int> woken = 0;
    Builder builder([&] { ++woken; });
    Drawer drawer([&] { ++woken; });
    builder.open("tree", 64);
    const auto opened = news_of(builder);
    REQUIRE(std::holds_alternative<Opened>(opened));
    const auto stage = std::get<Opened>(opened).stage;
    CHECK(stage->name == "tree");
    CHECK(stage->variants[0].name == "exact");
    Order order{.stage = stage, .view = view_of(*stage, 160, 120), .difference = Difference::flip, .number = 7};
    for (const std::size_t variant : {std::size_t(0), variant_of(*stage, "color-cube")}) {
        builder.build(stage, variant);
        const auto built = news_of(builder);
        REQUIRE(std::holds_alternative<Built>(built));
        (variant == 0 ? order.exact : order.variant) = std::get<Built>(built).built;
    }
    CHECK(woken > 0);
    order.view.tolerance_px = 4;
    order.most_cells = 50;
    const Drawn drawn = drawn_by(drawer, order);
    CHECK(drawn.problem.empty());
    CHECK(drawn.order.number == 7);
    CHECK(drawn.stats.approximations > 0);

    const auto viewer = order.variant->viewer({});
    viewer->frame(order.view);
    const farfield::Image variant = farfield::report::over_background(viewer->image(), order.background);
    const auto exact_viewer = order.exact->viewer({});
    View exact_view = order.view;
    exact_view.tolerance_px = 0;
    exact_viewer->frame(exact_view);
    const farfield::Image exact = farfield::report::over_background(exact_viewer->image(), order.background);
    CHECK(drawn.variant == variant);
    CHECK(drawn.exact == exact);
    CHECK(drawn.difference.width() == 160);
    CHECK(drawn.flip == Approx(farfield::flip(variant, exact)).epsilon(1e-4));
    CHECK(drawn.flip > 0);

    SECTION("cells are those of the frame") {
        CHECK_FALSE(drawn.cells.empty());
        CHECK(drawn.cells.size() <= 50);
        CHECK(std::any_of(drawn.cells.begin(), drawn.cells.end(), [](const auto& c) { return c.is_stand_in; }));
        const glm::dvec3 size = stage->bounds.size();
        const double longest = std::max({size.x, size.y, size.z});
        for (const auto& cell : drawn.cells) {
            for (int i = 0; i < 3; ++i) {
                // Cells are cubes, and a little loose.
                const double half = cell.half[std::size_t(i)][i];
                CHECK(half <= 0.75 * longest);
                CHECK(std::abs(cell.center[i] - stage->bounds.center()[i]) < half + 0.5 * size[i]);
            }
        }
    }
    SECTION("a frozen view looks the same from where it was frozen, and like itself from elsewhere") {
        Order from_outside = order;
        from_outside.exact = nullptr;
        from_outside.frozen = order.view;
        const Drawn same = drawn_by(drawer, from_outside);
        CHECK(same.problem.empty());
        CHECK(farfield::flip(same.variant, variant) < 0.03);  // the frustum's outline is seen end on
        Navigator navigator(stage->bounds, stage->up);
        navigator.orbit({0.4, 0});
        from_outside.view.camera = navigator.camera();
        const Drawn aside = drawn_by(drawer, from_outside);
        CHECK(aside.problem.empty());
        CHECK(farfield::flip(aside.variant, variant) > 0.03);
        CHECK(aside.stats.approximations == drawn.stats.approximations);
    }
    SECTION("of what was culled beside a frozen view and behind something there are outlines") {
        Navigator navigator(stage->bounds, stage->up);
        navigator.zoom(8, {0, 0});
        Order near_by = order;
        near_by.exact = nullptr;
        near_by.view.camera = navigator.camera();
        near_by.most_cells = 200;
        const auto count = [](const Drawn& of, bool CellOutline::*what) {
            return std::count_if(of.cells.begin(), of.cells.end(), [&](const auto& c) { return c.*what; });
        };
        const Drawn within = drawn_by(drawer, near_by);
        CHECK(within.stats.cells_outside > 0);
        CHECK(count(within, &CellOutline::is_outside) == 0);
        CHECK((within.stats.cells_hidden == 0 || count(within, &CellOutline::is_hidden) > 0));
        near_by.frozen = near_by.view;
        near_by.view.camera = order.view.camera;
        const Drawn outside = drawn_by(drawer, near_by);
        CHECK(outside.problem.empty());
        CHECK(count(outside, &CellOutline::is_outside) > 0);
        for (const auto& cell : outside.cells) {
            if (cell.is_outside) CHECK(farfield::scenes::is_outside(*near_by.frozen, cell));
        }
    }
    SECTION("levels are drawn in colors") {
        Order levels = order;
        levels.tints_levels = true;
        levels.exact = nullptr;
        CHECK_FALSE(drawn_by(drawer, levels).variant == variant);
    }
    SECTION("a budget is kept by one thread, whatever was asked for") {
        Order within = order;
        within.exact = nullptr;
        within.renderer.threads = 2;
        within.budget_ms = 50;
        within.like = {within.view, exact_view};
        const Drawn in_time = drawn_by(drawer, within);
        CHECK(in_time.problem.empty());
        CHECK_FALSE(in_time.variant.pixels().empty());
    }
    SECTION("what cannot be drawn is told, and the next picture comes") {
        Order wrong = order;
        wrong.renderer.kind = RendererKind::painter;
        CHECK_FALSE(drawn_by(drawer, wrong).problem.empty());
        CHECK(drawn_by(drawer, order).variant == variant);
    }
    SECTION("of many orders the last is drawn") {
        for (std::size_t i = 0; i < 100; ++i) {
            order.number = i;
            drawer.draw(order);
        }
        Drawn last;
        do {
            last = wait_for<Drawn>([&] { return drawer.drawn(); });
        } while (last.order.number != 99);
        CHECK(last.variant == variant);
    }
    SECTION("what lies under a pixel is told with its cell") {
        std::optional<farfield::scenes::PickedInScene> picked;
        for (int x = 0; x < 160 && !picked; ++x) picked = order.variant->pick(order.view, {x + 0.5, 60.5});
        REQUIRE(picked);
        REQUIRE(picked->corners.size() == 3);
        REQUIRE(picked->cell);
        CHECK(picked->cell_primitives > 0);
        const auto& cell = *picked->cell;
        for (const glm::dvec3& corner : picked->corners) {
            for (int i = 0; i < 3; ++i) {
                CHECK(std::abs(corner[i] - cell.center[i]) <= 1.001 * cell.half[std::size_t(i)][i] + 1e-4);
            }
        }
    }
}

TEST_CASE("pages are drawn by OpenGL as by the z-buffer, and by no one else") {
    using Pages = farfield::scenes::PagedOver<farfield::OpacityTensor>;
    std::vector<farfield::scenes::PagedPrimitive> triangles;
    farfield::test::Random random(5);
    for (int i = 0; i < 20000; ++i) {
        const glm::vec3 at = random.in_cube(1);
        farfield::scenes::PagedPrimitive t;
        for (auto& v : t.vertices) v = at + random.in_cube(0.02f);
        t.rgba.fill(random.color());
        triangles.push_back(t);
    }
    const auto hierarchy = farfield::build<Pages>(triangles);
    const auto bytes = farfield::paged<Pages, farfield::scenes::PagedPrimitive>(hierarchy, triangles);
    const farfield::test::TemporaryDirectory directory;
    {
        std::ofstream file(directory / "some.farfield", std::ios::binary);
        file.write(reinterpret_cast<const char*>(bytes.data()), std::streamsize(bytes.size()));
    }
    const auto stage = open_stage((directory / "some.farfield").string(), 64);
    const auto built = stage->variants[1].build({});
    CHECK_FALSE(stage->variants[1].obstacle(RendererKind::coverage).empty());
    CHECK_THROWS_AS(built->viewer({.kind = RendererKind::coverage}), std::invalid_argument);
    if (!stage->variants[1].obstacle(RendererKind::opengl).empty()) {
        WARN("skipped: there is no OpenGL in this program");
        return;
    }
    const auto expected = built->viewer({});
    std::unique_ptr<farfield::scenes::SceneViewer> tested;
    try {
        tested = built->viewer({.kind = RendererKind::opengl});
    } catch (const std::runtime_error& error) {
        WARN("skipped: " << error.what());
        return;
    }
    View view = view_of(*stage, 160, 120);
    view.tolerance_px = 10;  // where stand-ins pay
    // Until all pages are there.
    FrameStats stats;
    do {
        stats = expected->frame(view);
    } while (stats.cells_missing > 0);
    CHECK(stats.approximations > 0);
    CHECK(tested->frame(view).approximations > 0);  // hidden cells are others: each renderer asks in its own way
    CHECK(farfield::flip(farfield::report::over_background(tested->image(), stage->background),
                         farfield::report::over_background(expected->image(), stage->background)) <= 0.03);
}

TEST_CASE("what is picked in an instance is told in the scene's coordinates, with its cell around it") {
    const auto stage = open_stage("forest-instanced", 64);
    const auto built = stage->variants[variant_of(*stage, "color-cube")].build({});
    const View view = view_of(*stage, 320, 240);
    int picks = 0;
    for (int x = 8; x < 320; x += 16) {
        for (int y = 8; y < 240; y += 16) {
            const auto picked = built->pick(view, {x, y});
            if (!picked) continue;
            ++picks;
            REQUIRE(picked->corners.size() == 3);
            const auto& c = picked->corners;
            // The point lies in the triangle's plane, and the triangle in its cell.
            const glm::dvec3 normal = glm::cross(c[1] - c[0], c[2] - c[0]);
            const double size = glm::length(c[1] - c[0]) + glm::length(c[2] - c[0]);
            CHECK(std::abs(glm::dot(normal, picked->point - c[0])) <= 1e-3 * glm::length(normal) * size);
            REQUIRE(picked->cell);
            for (const glm::dvec3& corner : c) {
                for (const glm::dvec3& half : picked->cell->half) {
                    const double along = glm::dot(corner - picked->cell->center, half);
                    CHECK(std::abs(along) <= 1.001 * glm::dot(half, half) + 1e-3 * glm::length(half) * size);
                }
            }
        }
    }
    CHECK(picks > 20);
}

TEST_CASE("a build that nobody wants any more ends, and the next begins") {
    Builder builder([] {});
    const auto stage = open_stage("molecule", 64);
    builder.build(stage, variant_of(*stage, "opacity-tensor"));
    while (builder.part() < 0) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    builder.open("cube", 64);
    const auto news = news_of(builder);
    REQUIRE(std::holds_alternative<Opened>(news));
    CHECK(std::get<Opened>(news).stage->name == "cube");
    CHECK_FALSE(builder.is_busy());
}

TEST_CASE("what cannot be opened is told in one line") {
    Builder builder([] {});
    const farfield::test::TemporaryDirectory directory;
    for (const std::string& where : {std::string("no such scene"), directory.write("a.ply", "nothing").string(),
                                     directory.write("a.farfield", "nothing").string()}) {
        builder.open(where, 64);
        const auto news = news_of(builder);
        REQUIRE(std::holds_alternative<Failed>(news));
        const std::string message = std::get<Failed>(news).message;
        CHECK_FALSE(message.empty());
        CHECK(message.find('\n') == std::string::npos);
    }
}
