// Whether stand-ins err as they say (first table), and what a frame costs that is to err no more than point sampling
// (second table), over scenes of the gallery, a tree, a molecule and a building.
//
// First: over cells of every level and six directions each, the root mean square error of the picture over the pixels
// of the cell's box, from 64 samples a pixel, over black or over white, whichever is more, where the stand-in is drawn
// alone and the cell is as many pixels wide. Beside what expected_rmse() says: the rank correlation of both, how many
// err more, and by which factor all but 5 % err at most.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <glm/geometric.hpp>
#include <numbers>
#include <numeric>
#include <span>
#include <string>
#include <vector>

#include "farfield/approximation/area_splat.hpp"
#include "farfield/approximation/color_cube.hpp"
#include "farfield/approximation/color_cube_cluster.hpp"
#include "farfield/approximation/exact.hpp"
#include "farfield/approximation/opacity_tensor.hpp"
#include "farfield/build.hpp"
#include "farfield/cost_model/triangle_count.hpp"
#include "farfield/frame/source_table.hpp"
#include "farfield/frame/subtree.hpp"
#include "farfield/partition/octree.hpp"
#include "farfield/primitive/triangle.hpp"
#include "farfield/renderer/z_buffer_renderer.hpp"
#include "farfield/tuning/measure_error_table.hpp"
#include "farfield/viewer.hpp"
#include "scenes/generate/building.hpp"
#include "scenes/generate/gallery.hpp"
#include "scenes/generate/molecule.hpp"
#include "scenes/generate/tree.hpp"
#include "support/pair.hpp"

namespace farfield::bench {
namespace {

using Primitive = VertexColoredTriangle;
struct Subject {
    std::string name;
    std::vector<Primitive> triangles;
};

std::vector<Subject> subjects() {
    std::vector<Subject> all;
    for (const scenes::GalleryEntry& entry : scenes::gallery()) {
        const auto scene = scenes::make_gallery(entry.name, 0.5f, 30'000);
        all.push_back({scene.name, scenes::vertex_colored(scene.triangles)});
    }
    const auto last_of = [](scenes::Scene scene) { return std::move(scene.groups.back().triangles); };
    all.push_back({"tree", last_of(scenes::tree())});
    all.push_back({"molecule", last_of(scenes::molecule())});
    all.back().triangles.resize(400'000);
    all.push_back({"building", scenes::expanded(scenes::building({})).groups.back().triangles});
    return all;
}

/// What was measured of one cell from one direction, and what it says.
struct Measured {
    double rmse, expected;
};

template <class H>
void collect(const H& h, const Subtree& subtree, std::vector<std::vector<Subtree>>& by_level) {
    if (subtree.has_stand_in()) by_level[subtree.cell.depth].push_back(subtree);
    if (h.nodes()[subtree.node].child_mask == 0) return;
    for_each_child<VisitOrder::any>(h, subtree, glm::vec4(0), [&](Subtree& s) { collect(h, s, by_level); });
}

/// Draws one cell, by its stand-in and by its contents.
template <class A>
class CellPictures {
    using H = SpatialHierarchy<Octree, A, TriangleCount>;

  public:
    explicit CellPictures(std::span<const Primitive> triangles)
        : hierarchy_(build<H>(triangles)),
          source_(detail::source_of(hierarchy_, triangles, 0)),
          finest_({.samples = 64}) {
        source_.id = finest_.upload(source_);
    }

    /// As many cells of each level, evenly over the hierarchy.
    std::vector<Subtree> cells(std::size_t most_a_level) const {
        std::vector<std::vector<Subtree>> by_level(FrameStats::max_levels);
        collect(hierarchy_, whole_of(hierarchy_), by_level);
        std::vector<Subtree> some;
        for (const auto& level : by_level) {
            const std::size_t count = std::min(level.size(), most_a_level);
            for (std::size_t i = 0; i < count; ++i) some.push_back(level[i * level.size() / count]);
        }
        return some;
    }

    Measured measure(const Subtree& subtree, glm::dvec3 w, double side_px) {
        const A& approximation = hierarchy_.approximation_policy();
        const auto& data = hierarchy_.stand_ins()[subtree.stand_in];
        const Cell& cell = subtree.cell;
        const double side = cell.largest_side();
        const glm::dvec3 center = glm::dvec3(cell.center) + hierarchy_.origin();
        double squares = 0, pixels = 0;
        float expected = 0;
        for (int place = 0; place < 4; ++place) {  // in the pixels' grid
            const glm::dvec3 at = center + glm::dvec3(place % 2, place / 2, 0.7 * (place % 2)) * (0.5 * side / side_px);
            View view;
            view.width = view.height = 4 * int(std::ceil(side_px)) + 4;
            const glm::dvec3 up = std::abs(w.y) < 0.9 ? glm::dvec3(0, 1, 0) : glm::dvec3(1, 0, 0);
            view.camera = Camera::orthographic(at + w * (10 * side), at, up, float(view.height * side / (2 * side_px)));
            const LocalView local(view, hierarchy_.origin(), hierarchy_.bounds());
            finest_.begin_frame(local);
            finest_.set_view(local);
            const std::uint32_t first = hierarchy_.nodes()[subtree.node].first_item;
            const Range contents{first, subtree.end_item - first};
            finest_.draw(source_, std::span(&contents, 1));
            finest_.end_frame();
            renderer_.begin_frame(local);
            renderer_.set_view(local);
            detail::draw_stand_in(approximation, data, hierarchy_.pool(), cell, local,
                                  Sink{renderer_, renderer_.largest_splat_px()});
            renderer_.end_frame();
            squares += detail::object_error(renderer_.image(), finest_.image()).sum;
            const double px = side_px / side;
            pixels += double(outline_of(cell.half, glm::vec3(w))) * px * px;
            expected = approximation.expected_rmse(
                float(side_px), detail::covered_part(approximation, data, hierarchy_.pool(), cell, local));
        }
        return {std::sqrt(squares / pixels), double(expected)};
    }

  private:
    struct Sink {
        ZBufferRenderer& renderer;
        float splat_limit_px;
        void operator()(const Face& face) const { renderer.draw(std::span(&face, 1)); }
        void operator()(const Splat& splat) const { renderer.draw(std::span(&splat, 1)); }
        void operator()(OwnRun) const {}
    };

    H hierarchy_;
    Source<Primitive> source_;
    ZBufferRenderer finest_, renderer_;
};

/// Equal numbers share a rank.
std::vector<double> ranks(const std::vector<Measured>& all, double Measured::*number) {
    std::vector<std::size_t> order(all.size());
    std::iota(order.begin(), order.end(), std::size_t(0));
    std::sort(order.begin(), order.end(), [&](auto a, auto b) { return all[a].*number < all[b].*number; });
    std::vector<double> rank(all.size());
    for (std::size_t i = 0, end = 0; i < order.size(); i = end) {
        while (end < order.size() && all[order[end]].*number == all[order[i]].*number) ++end;
        for (std::size_t k = i; k < end; ++k) rank[order[k]] = 0.5 * double(i + end - 1);
    }
    return rank;
}

/// Spearman's.
double rank_correlation(const std::vector<Measured>& all) {
    const std::vector<double> a = ranks(all, &Measured::rmse), b = ranks(all, &Measured::expected);
    const double mean = 0.5 * double(all.size() - 1);
    double ab = 0, aa = 0, bb = 0;
    for (std::size_t i = 0; i < all.size(); ++i) {
        ab += (a[i] - mean) * (b[i] - mean);
        aa += (a[i] - mean) * (a[i] - mean);
        bb += (b[i] - mean) * (b[i] - mean);
    }
    return ab / std::sqrt(std::max(aa * bb, 1e-300));
}

template <class A>
void print_errors(const char* name, std::span<const Subject> all) {
    constexpr std::array<double, 4> sides{0.5, 1, 2, 4};
    std::array<std::vector<Measured>, sides.size()> measured;
    for (const Subject& subject : all) {
        CellPictures<A> pictures(subject.triangles);
        std::size_t turn = 0;
        for (const Subtree& cell : pictures.cells(8)) {
            ++turn;
            for (int d = 0; d < 6; ++d) {  // a Fibonacci lattice, turned from cell to cell
                const double z = 1 - (2 * d + 1) / 6.0, r = std::sqrt(1 - z * z);
                const double angle = 2 * std::numbers::pi * (d / std::numbers::phi + double(turn % 97) / 97);
                for (std::size_t s = 0; s < sides.size(); ++s) {
                    const glm::dvec3 w(r * std::cos(angle), z, r * std::sin(angle));
                    measured[s].push_back(pictures.measure(cell, w, sides[s]));
                }
            }
        }
    }
    for (std::size_t s = 0; s < sides.size(); ++s) {
        std::vector<double> errors, factors;
        for (const Measured& m : measured[s]) {
            errors.push_back(m.rmse);
            factors.push_back(m.rmse / m.expected);
        }
        std::sort(factors.begin(), factors.end());
        const auto worse = factors.end() - std::upper_bound(factors.begin(), factors.end(), 1.0);
        std::printf("| %s | %g | %.3f | %.2f | %.0f %% | %.1f |\n", name, sides[s], middle(errors),
                    rank_correlation(measured[s]), 100 * double(worse) / double(factors.size()),
                    factors[factors.size() * 95 / 100]);
    }
}

template <class A>
void print_choice(const char* name, std::span<const Subject> all) {
    for (const Subject& subject : all) {
        const std::span<const Primitive> triangles(subject.triangles);
        const auto exact = build<SpatialHierarchy<Octree, Exact, TriangleCount>>(triangles);
        const auto hierarchy = build<SpatialHierarchy<Octree, A, TriangleCount>>(triangles);
        ZBufferRenderer exact_renderer, renderer, finest({.samples = 64});
        auto exact_viewer = make_viewer(exact, triangles, exact_renderer),
             finest_viewer = make_viewer(exact, triangles, finest);
        auto viewer = make_viewer(hierarchy, triangles, renderer);
        const glm::dvec3 center = glm::dvec3(exact.bounds().center()) + exact.origin();
        const double radius = 0.5 * double(glm::length(exact.bounds().size()));
        std::printf("| %s | %s |", subject.name.c_str(), name);
        for (const double distance : {1.75, 3.5, 7.0, 14.0, 28.0}) {
            View view;
            view.width = view.height = 256;
            view.tolerance_px = 4;
            const glm::dvec3 eye = center + glm::normalize(glm::dvec3(0.6, 0.3, 1)) * (radius * distance);
            view.camera = Camera::perspective(eye, center, {0, 1, 0}, std::numbers::pi_v<float> / 3);
            View wanted = view, exactly = view;
            wanted.wanted = WantedError{};
            exactly.tolerance_px = 0;
            FrameStats stats;
            const PairTimes times = in_turns(
                {.seconds = 0.3}, [&] { stats = viewer.frame(wanted); }, [&] { exact_viewer.frame(exactly); });
            finest_viewer.frame(exactly);
            const auto rmse = [&](const ZBufferRenderer& r) {
                return detail::object_error(r.image(), finest.image()).root_mean();
            };
            std::printf(" %s%.2f (%.3f; %.3f) |", stats.is_exact() ? "exact " : "", times.speedup, rmse(renderer),
                        rmse(exact_renderer));
        }
        std::printf("\n");
        std::fflush(stdout);
    }
}

int run() {
    const std::vector<Subject> all = subjects();
    std::printf(
        "| stands in | px wide | median RMSE | rank correlation | err more | 95 %% within "
        "|\n|---|---|---|---|---|---|\n");
    print_errors<OpacityTensor>("tensor", all);
    print_errors<ColorCube>("cube", all);
    print_errors<ColorCubeCluster<4>>("cluster", all);
    print_errors<AreaSplat>("area splat", all);
    std::printf(
        "\n| scene | stands in | 1.75 radii: times as fast as exact (RMSE; exact's) | 3.5 | 7 | 14 | 28 |\n"
        "|---|---|---|---|---|---|---|\n");
    print_choice<OpacityTensor>("tensor", all);
    print_choice<ColorCube>("cube", all);
    return 0;
}

}  // namespace
}  // namespace farfield::bench

int main() {
    return farfield::bench::run();
}
