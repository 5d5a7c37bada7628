#include "farfield/tuning/tuned_viewer.hpp"

#include <array>
#include <limits>
#include <memory>
#include <span>
#include <stdexcept>
#include <vector>

#include "catch.hpp"
#include "farfield/approximation/opacity_tensor.hpp"
#include "farfield/build.hpp"
#include "farfield/cost_model/triangle_count.hpp"
#include "farfield/paging/open_pages.hpp"
#include "farfield/paging/write_pages.hpp"
#include "farfield/partition/octree.hpp"
#include "farfield/primitive/triangle.hpp"
#include "farfield/renderer/z_buffer_renderer.hpp"
#include "farfield/tuning/kept_error_table.hpp"
#include "farfield/tuning/measure_error_table.hpp"
#include "support/scenes.hpp"
#include "support/temporary_directory.hpp"
#include "support/views.hpp"

using namespace farfield;
using namespace farfield::test;

namespace {

using Hierarchy = SpatialHierarchy<Octree, OpacityTensor, TriangleCount>;

const auto make = [](int samples) { return ZBufferRenderer({.samples = samples}); };

/// Errors of 0.1 at 2 px and one sample, 0.01 at four samples and 1 px; exact is dear.
SampledErrorTable table() {
    return SampledErrorTable(
        {{1, 1, ErrorTable({{0, 0.08, 1}, {2, 0.1, 0.2}})}, {4, 3, ErrorTable({{0, 0.005, 1}, {1, 0.01, 0.5}})}});
}

template <class H>
Image drawn_by(const H& hierarchy, const Triangles& triangles, View view, float tolerance_px, int samples) {
    ZBufferRenderer renderer({.samples = samples});
    view.tolerance_px = tolerance_px;
    view.wanted = WantedError::any();
    make_viewer(hierarchy, triangles, renderer).frame(view);
    return renderer.image();
}

}  // namespace

TEST_CASE("a tuned viewer draws what a view's wanted error takes by its table") {
    const Triangles triangles = random_triangles(2500, 195);
    const auto hierarchy = build<Hierarchy>(triangles);
    auto viewer = make_tuned_viewer(hierarchy, triangles, table(), make);
    View view = looking({3, 2, 3}, {}, 64, 16);
    const auto draws = [&](WantedError wanted, float tolerance_px, int samples) {
        view.wanted = wanted;
        viewer.frame(view);
        CHECK(viewer.renderer().image() == drawn_by(hierarchy, triangles, view, tolerance_px, samples));
    };
    CHECK_FALSE(viewer.choice());
    draws({.rmse = 0.1}, 2, 1);
    CHECK(viewer.choice()->tolerance.reason == ToleranceReason::pays);
    draws({.rmse = 0.02}, 1, 4);
    CHECK(viewer.choice()->samples == 4);
    draws({.rmse = 0.001}, 0, 4);
    CHECK_FALSE(viewer.choice()->tolerance.keeps_error());
    draws({}, 0, 1);  // point sampling
    draws({.samples = 4}, 0, 4);
    draws(WantedError::any(), 16, 1);  // the view's own
    CHECK_FALSE(viewer.choice());
    view.wanted = {.samples = 9};
    CHECK_THROWS_AS(viewer.frame(view), std::invalid_argument);
    view.wanted = {.rmse = -1};
    CHECK_THROWS_AS(viewer.frame(view), std::invalid_argument);
    draws({.rmse = 0.1}, 2, 1);
}

TEST_CASE("what lies in pages is measured, and draws by the table in its file as the hierarchy in memory does") {
    const TemporaryDirectory directory;
    const Triangles triangles = random_triangles(2500, 195);
    const auto hierarchy = build<Hierarchy>(triangles);
    const auto path = directory / "scene.farfield";
    save_pages<Hierarchy, Triangle>(hierarchy, triangles, path, {.page_bytes = 4096});
    const std::vector<View> views{looking({4, 2, 3}, {}, 48), looking({9, -3, 6}, {}, 48)};
    const std::array samples{1, 4};
    const HierarchyErrorOptions options{{.tolerances_px = {1, 4}, .repetitions = 1}, std::nullopt, {.samples = 16}};
    const auto pages = open_pages<Hierarchy, Triangle>(path, {.most_bytes = 64u << 20, .loads_in_background = false});
    const auto of_pages = measure_sampled_error_table(pages, pages.primitives(), samples, make, views, options);
    const auto of_memory =
        measure_sampled_error_table(hierarchy, std::span<const Triangle>(triangles), samples, make, views, options);
    for (const int count : samples) {
        const auto a = of_pages.at(count).trials(), b = of_memory.at(count).trials();
        REQUIRE(a.size() == b.size());
        for (std::size_t i = 0; i < a.size(); ++i) CHECK(a[i].rmse == Approx(b[i].rmse).epsilon(1e-6).margin(1e-6));
    }
    CHECK_FALSE(pages.waits_for_pages());  // what was measured was a copy
    const MeasuredWith with{"z-buffer", 48, 48};
    keep_error_table(table(), with, pages, path);

    auto again = open_pages<Hierarchy, Triangle>(path, {.most_bytes = 64u << 20, .loads_in_background = false});
    again.wait_for_pages(true);
    auto viewer = make_tuned_viewer(again, kept_error_table(with, again).value(), make);
    View view = looking({3, 2, 3}, {}, 64, 16);
    view.wanted = {.rmse = 0.02};
    CHECK(viewer.frame(view).cells_missing == 0);
    CHECK(viewer.choice()->samples == 4);
    ZBufferRenderer alone({.samples = 4});
    view.tolerance_px = 1;
    view.wanted = WantedError::any();
    make_viewer(again, alone).frame(view);
    CHECK(viewer.renderer().image() == alone.image());
    // A cache that is too small for exact frames measures nothing.
    const auto cramped = open_pages<Hierarchy, Triangle>(path, {.most_bytes = 32768, .loads_in_background = false});
    CHECK_THROWS_WITH(measure_sampled_error_table(cramped, cramped.primitives(), samples, make, views, options),
                      Catch::Matchers::Contains("pages are missing"));
}
