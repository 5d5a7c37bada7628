// What the parts of coverage masks cost and are worth, a line each: Greene 1996, section 9. Time over that of the
// defaults (exact masks, box filter, boxes of cells asked about), drawn in turns with them, and the error against the
// samples or the filter that it stands for. 512 x 512 pixels, 64 samples each where nothing else is said.
//
//   table     the paper's table of quantized edges; rmse against exact masks
//   hump      a cosine hump over 3 x 3 pixels; rmse against the box is how much it blurs, no error
//   jitter    samples in random places, 1 or 16 patterns; rmse against regular ones
//   points    one sample a pixel; rmse against 64
//   unasked   no cell is asked whether it is hidden
//   lanes     the same with fewer lanes; the same picture
//   flat      every quadrilateral of one color; its time only
#include <algorithm>
#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "farfield/build.hpp"
#include "farfield/coverage/pixels/cosine_hump_filter.hpp"
#include "farfield/measure/image_error.hpp"
#include "farfield/partition/nested.hpp"
#include "farfield/partition/polygon_bsp.hpp"
#include "farfield/renderer/coverage_renderer.hpp"
#include "scenes/generate/square_cube.hpp"
#include "support/drawer.hpp"
#include "support/office.hpp"
#include "support/pair.hpp"

namespace farfield::bench {
namespace {

using OctreeOfBsps = SpatialHierarchy<Nested<Octree, PolygonBsp>, Exact, TriangleCount>;

struct TableMasks : StrictCoverage {
    static constexpr MaskSource masks = MaskSource::table;
};
struct Hump : StrictCoverage {
    using samples = PixelSamples<CosineHumpFilter>;
};
template <std::size_t patterns>
struct Jittered : StrictCoverage {
    static constexpr MaskSource masks = MaskSource::jittered;
    static constexpr std::size_t jitter_patterns = patterns;
};
struct Points : StrictCoverage {
    using samples = SinglePixels;
};
/// Draws every cell in the frustum.
struct Unasked : StrictCoverageRenderer {
    using StrictCoverageRenderer::StrictCoverageRenderer;
    static constexpr RendererFacts facts = [] {
        RendererFacts f = StrictCoverageRenderer::facts;
        f.answers_hidden = false;
        return f;
    }();
};

/// `time` is the option's over the defaults'.
void add(const Run& run, const std::string& name, const std::vector<View>& views, Drawer& option, Drawer& defaults) {
    std::vector<double> times, errors, ms, default_ms;
    for (const View& view : views) {
        const PairTimes pair = run.pair(view, option, defaults);
        times.push_back(1 / pair.speedup);
        ms.push_back(pair.ms);
        default_ms.push_back(pair.other_ms);
        errors.push_back(rmse(option.image(), defaults.image()));
    }
    std::printf("| %s | %zu | %.3g | %.3g | %.3g | %.4f | %.4f |\n", name.c_str(), views.size(), middle(ms),
                middle(default_ms), middle(times), middle(errors), *std::max_element(errors.begin(), errors.end()));
    std::fflush(stdout);
}

/// The sorted list of scenes::square_cube.
struct Cube {
    std::vector<Quadrilateral> squares = quadrilaterals_of(scenes::square_cube().groups.back().triangles);
    std::vector<View> views{office_view(scenes::square_cube_camera())};

    template <class R>
    std::unique_ptr<Drawer> by(const CoverageOptions& options = {}) const {
        return list_drawer<R>(squares, options);
    }
};

/// From inside with exterior walls, from outside without.
struct Building {
    std::vector<VertexColoredTriangle> triangles;
    std::vector<View> views;
    OctreeOfBsps hierarchy;

    explicit Building(bool is_inside, bool is_flat = false) {
        OfficePlan plan;
        plan.options.exterior_walls = is_inside;
        triangles = scenes::expanded(scenes::building(plan.options)).groups.back().triangles;
        for (std::size_t i = 0; is_flat && i + 1 < triangles.size(); i += 2) {
            triangles[i].rgba.fill(triangles[i].rgba[0]);
            triangles[i + 1].rgba = triangles[i].rgba;
        }
        views = is_inside ? plan.inside() : plan.outside();
        hierarchy = build<OctreeOfBsps>(triangles);
    }
    template <class R>
    std::unique_ptr<Drawer> by(const CoverageOptions& options = {}) const {
        return drawer<R>(hierarchy, triangles, options);
    }
};

template <class Subject>
void add_all(const Run& run, const std::string& name, const Subject& subject) {
    const auto defaults = subject.template by<StrictCoverageRenderer>();
    const auto views = run.some(subject.views);
    const auto row = [&](const char* what, const std::unique_ptr<Drawer>& option) {
        add(run, name + ": " + what, views, *option, *defaults);
    };
    row("defaults again", subject.template by<StrictCoverageRenderer>());
    row("table", subject.template by<BasicCoverageRenderer<TableMasks>>());
    row("hump", subject.template by<BasicCoverageRenderer<Hump>>());
    row("jitter, 1 pattern", subject.template by<BasicCoverageRenderer<Jittered<1>>>());
    row("jitter, 16 patterns", subject.template by<BasicCoverageRenderer<Jittered<16>>>());
    row("points", subject.template by<BasicCoverageRenderer<Points>>());
    row("8 lanes", subject.template by<StrictCoverageRenderer>({.simd = Simd::eight_lanes}));
    row("4 lanes", subject.template by<StrictCoverageRenderer>({.simd = Simd::four_lanes}));
    row("1 lane", subject.template by<StrictCoverageRenderer>({.simd = Simd::scalar}));
}

void add_building(const Run& run, const std::string& name, bool is_inside) {
    const Building building(is_inside);
    add_all(run, name, building);
    const auto views = run.some(building.views);
    const auto defaults = building.by<StrictCoverageRenderer>();
    add(run, name + ": unasked", views, *building.by<Unasked>(), *defaults);
    const Building flat(is_inside, true);
    add(run, name + ": flat", views, *flat.by<StrictCoverageRenderer>(), *defaults);
}

}  // namespace
}  // namespace farfield::bench

int main(int argc, char** argv) {
    using namespace farfield::bench;
    CLI::App app("What the parts of coverage masks cost and are worth.", "coverage_options");
    std::vector<std::string> names;
    bool is_quick = false;
    app.add_option("SCENE", names, "cube, inside, outside; all by default")
        ->check(CLI::IsMember({"cube", "inside", "outside"}));
    app.add_flag("--quick", is_quick, "two views a row and few turns: less to rely on");
    CLI11_PARSE(app, argc, argv);
    Run run;
    if (is_quick) run = {{3, 9, 0.2}, 2, true};
    const auto is_wanted = [&](const char* name) {
        return names.empty() || std::find(names.begin(), names.end(), name) != names.end();
    };
    std::puts("| row | views | ms | defaults, ms | time | rmse | worst |\n|---|---|---|---|---|---|---|");
    if (is_wanted("cube")) add_all(run, "cube", Cube());
    if (is_wanted("inside")) add_building(run, "inside", true);
    if (is_wanted("outside")) add_building(run, "outside", false);
}
