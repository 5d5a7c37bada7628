// Above cells that all stand in, samples are left out, and what stands in shows them too.
#include "farfield/frame/left_out_samples.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "catch.hpp"
#include "farfield/approximation/area_splat.hpp"
#include "farfield/approximation/opacity_tensor.hpp"
#include "farfield/approximation/sample_set.hpp"
#include "farfield/build.hpp"
#include "farfield/cost_model/triangle_count.hpp"
#include "farfield/measure/coverage_error.hpp"
#include "farfield/measure/image_error.hpp"
#include "farfield/partition/octree.hpp"
#include "farfield/renderer/z_buffer_renderer.hpp"
#include "farfield/viewer.hpp"
#include "support/scenes.hpp"
#include "support/views.hpp"

using namespace farfield;
using namespace farfield::test;

namespace {

template <class Inner>
using SamplesOver = SpatialHierarchy<Octree, SampleSet<Inner>, TriangleCount>;
using Splats = SamplesOver<AreaSplat>;
using Tensors = SamplesOver<OpacityTensor>;

Triangles wall() {
    return sheet({0.31f, -1, -1}, {0, 2, 0}, {0, 0, 2}, 120, 120, {200, 120, 40});
}

}  // namespace

TEST_CASE("every primitive is drawn, or lies in a cell that stands in", "[frame]") {
    Triangles triangles = wall();
    append(triangles, random_triangles(4000, 31, 0.02f));
    append(triangles, random_triangles(40, 32, 0.7f));  // some that stay with large cells
    const Splats h = build<Splats>(triangles);
    ZBufferRenderer renderer;
    auto viewer = make_viewer(h, triangles, renderer);
    std::uint64_t left_out = 0;
    for (const double distance : {6.0, 10.0, 17.0, 30.0, 60.0, 200.0, 900.0}) {
        const auto selection = viewer.select(looking({distance, 0.2 * distance, -0.3 * distance}, {}, 256, 4));
        std::vector<char> is_drawn(triangles.size(), 0);
        std::vector<Box> stand_ins;
        for (const Selected& s : selection.entries()) {
            if (s.kind == Selected::Kind::run) {
                for (std::uint32_t at = s.first; at < s.end; ++at) {
                    CHECK(is_drawn[h.order()[at]] == 0);
                    is_drawn[h.order()[at]] = 1;
                }
                continue;
            }
            stand_ins.push_back(s.subtree.cell.box());
            left_out += s.subtree.left_out != 0;
            for (std::uint32_t at = h.nodes()[s.subtree.node].first_item; at < s.subtree.end_item; ++at) {
                is_drawn[h.order()[at]] = 2;
            }
        }
        for (std::size_t i = 0; i < triangles.size(); ++i) {
            if (is_drawn[i] != 0) continue;
            const glm::vec3 center = local_bounds(triangles[i], h.origin()).center();
            INFO("from " << distance << ", triangle " << i);
            CHECK(std::any_of(stand_ins.begin(), stand_ins.end(), [&](const Box& box) {
                return box.intersects(Box{center, center});
            }));
        }
    }
    CHECK(left_out > 100);
}

TEST_CASE("a closed wall stays closed where its samples are left out", "[frame]") {
    const Triangles triangles = wall();
    const Tensors h = build<Tensors>(triangles);
    ZBufferRenderer renderer({.samples = 1}), exact_renderer({.samples = 64});
    auto viewer = make_viewer(h, triangles, renderer), exact = make_viewer(h, triangles, exact_renderer);
    for (const double distance : {8.0, 16.0, 32.0}) {
        View view = looking({distance, 0.3 * distance, 0.1 * distance}, {}, 256, 3);
        const FrameStats stats = viewer.frame(view);
        view.tolerance_px = 0;
        exact.frame(view);
        const CoverageError e = coverage_error(renderer.image(), exact_renderer.image());
        INFO("from " << distance << ": " << 100 * e.bias << " %, " << stats.primitives << " triangles, "
                     << stats.approximations << " stand-ins");
        CHECK(stats.primitives < triangles.size() / 8);
        CHECK(std::abs(e.bias) < 0.05);
    }
}

TEST_CASE("samples are kept where they are finer than the picture's samples, and where errors are wanted", "[frame]") {
    const Triangles triangles = wall();
    const Tensors h = build<Tensors>(triangles);
    View view = looking({60, 12, 8}, {}, 256, 1);
    const auto primitives = [&](int samples) {
        ZBufferRenderer renderer({.samples = samples});
        return make_viewer(h, triangles, renderer).frame(view).primitives;
    };
    CHECK(primitives(1) < primitives(64));
    const std::uint64_t all_errors = primitives(1);
    view.wanted = {.rmse = 10.0};
    CHECK(primitives(1) >= all_errors);
}

TEST_CASE("where stand-ins fade, samples come back with what is opened below them", "[frame]") {
    Triangles triangles = wall();
    append(triangles, random_triangles(20000, 33, 0.02f));
    const Tensors h = build<Tensors>(triangles);
    ZBufferRenderer renderer({.samples = 16}), exact_renderer({.samples = 64});
    auto viewer = make_viewer(h, triangles, renderer), exact = make_viewer(h, triangles, exact_renderer);
    std::uint64_t with_samples = 0, without = 0;
    double hard = 0, soft = 0;
    for (int i = 0; i < 200; ++i) {
        const double distance = 14 * std::pow(8, i / 200.0);
        View view = looking({distance, 0.3 * distance, 0.1 * distance}, {}, 128, 2);
        const auto change = [&] {
            viewer.frame(view);
            const Image now = renderer.image();
            View last = view;
            last.tolerance_px /= float(std::pow(8, 1 / 200.0));
            viewer.frame(last);
            return std::sqrt(mse(renderer.image(), now));
        };
        hard = std::max(hard, change());
        view.fade = 0.5f;
        soft = std::max(soft, change());
        without += viewer.frame(view).primitives;
        const Image faded = renderer.image();
        View kept = view;
        kept.wanted = {.rmse = 10.0};  // which keeps samples
        with_samples += viewer.frame(kept).primitives;
        if (i % 20 != 0) continue;
        view.tolerance_px = 0;
        exact.frame(view);
        INFO("from " << distance);
        // A fade covers a little more than a cut does, whatever it draws.
        const Image& truth = exact_renderer.image();
        CHECK(std::abs(coverage_error(faded, truth).bias - coverage_error(renderer.image(), truth).bias) < 0.005);
    }
    INFO(soft << " of " << hard << ", " << without << " triangles of " << with_samples);
    CHECK(without < with_samples);
    CHECK(soft < 0.4 * hard);
}
