// The randomized sample tree of Klein et al. 2002 at their size of picture, 640 x 480: how time grows with a
// chessboard, errors of one object at a distance, coverage of leaves, wrong cells, uniform subsets at equal time,
// instances, building.
//
//     bench_samples [--quick] [PART...]        parts: chessboard object leaves cells uniform sheets instances building
//
// The object is the happy buddha where FARFIELD_SHARED_DATA names the folder that has it, else a tree.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <functional>
#include <glm/gtc/matrix_transform.hpp>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include "farfield/approximation/exact.hpp"
#include "farfield/approximation/opacity_tensor.hpp"
#include "farfield/approximation/sample_set.hpp"
#include "farfield/approximation/sided_tensor.hpp"
#include "farfield/build.hpp"
#include "farfield/cost_model/triangle_count.hpp"
#include "farfield/partition/octree.hpp"
#include "farfield/primitive/instance.hpp"
#include "farfield/renderer/z_buffer_renderer.hpp"
#include "farfield/viewer.hpp"
#include "scenes/generate/chessboard.hpp"
#include "scenes/generate/tree.hpp"
#include "scenes/load/load.hpp"
#include "support/pair.hpp"

namespace farfield::bench {
namespace {

template <class A>
using Over = SpatialHierarchy<Octree, A, TriangleCount>;
using Tensors = SampleSet<OpacityTensor>;
using Splats = SampleSet<AreaSplat>;
using Triangles = std::vector<VertexColoredTriangle>;

bool is_quick = false;
constexpr float fov = std::numbers::pi_v<float> / 4;

View paper_view(const glm::dvec3& eye, const glm::dvec3& target, float tolerance_px) {
    return {.camera = Camera::perspective(eye, target, {0, 1, 0}, fov),
            .width = 640,
            .height = 480,
            .tolerance_px = tolerance_px};
}

/// A hierarchy, its primitives, and a viewer with a renderer of its own.
template <class H, class P>
struct Drawn {
    std::vector<P> primitives;
    H hierarchy;
    ZBufferRenderer renderer;
    Viewer<H, P, ZBufferRenderer> viewer;

    Drawn(std::vector<P> p, const typename H::approximation_type& approximation, int samples)
        : primitives(std::move(p)),
          hierarchy(build<H>(primitives, {.approximation = approximation})),
          renderer({.samples = samples}),
          viewer(hierarchy, std::span<const P>(primitives), renderer) {}
    const Image& picture(const View& view) {
        viewer.frame(view);
        return renderer.image();
    }
};
template <class A>
auto drawn(const Triangles& triangles, const A& approximation, int samples) {
    return std::make_unique<Drawn<Over<A>, VertexColoredTriangle>>(triangles, approximation, samples);
}

struct ObjectError {
    double rmse = 0;  ///< over pixels that are not background in one of the two
    double bias = 0;  ///< of coverage
};
ObjectError object_error(const Image& a, const Image& reference) {
    double squares = 0, channels = 0, alpha = 0, alpha_of_reference = 0;
    for (std::size_t i = 0; i < a.pixels().size(); ++i) {
        const Rgba8 p = a.pixels()[i], q = reference.pixels()[i];
        if (p.a == 0 && q.a == 0) continue;
        for (const int d : {p.r - q.r, p.g - q.g, p.b - q.b}) squares += d * d;
        channels += 3;
        alpha += p.a;
        alpha_of_reference += q.a;
    }
    if (!(alpha_of_reference > 0)) return {};
    return {std::sqrt(squares / channels) / 255, alpha / alpha_of_reference - 1};
}

/// From `distance` times as far away as the bounding sphere fills the height at.
std::vector<View> views_around(const Triangles& triangles, double distance, float tolerance_px) {
    Box box = Box::empty();
    for (const auto& t : triangles) box.add(t.bounds());
    double radius = 0;
    for (const auto& t : triangles) {
        for (const glm::vec3& v : t.vertices) radius = std::max(radius, double(glm::length(v - box.center())));
    }
    std::vector<View> out;
    const int count = is_quick ? 2 : 8;
    for (int i = 0; i < count; ++i) {
        const double turn = 2 * std::numbers::pi * (i + 0.37) / count;
        const glm::dvec3 towards(std::cos(turn) * 0.97, 0.25, std::sin(turn) * 0.97), center(box.center());
        out.push_back(paper_view(center + towards * (distance * radius / std::sin(fov / 2)), center, tolerance_px));
    }
    return out;
}

Triangles tree() {
    return scenes::tree({}).groups.back().triangles;
}
Triangles object() {
    const char* folder = std::getenv("FARFIELD_SHARED_DATA");
    const std::filesystem::path file = std::filesystem::path(folder ? folder : "") / "meshes/happy-buddha-100k.obj";
    if (folder != nullptr && std::filesystem::exists(file)) return scenes::load(file).groups.back().triangles;
    Table::remark("no happy buddha: a tree in its place");
    return tree();
}

// --- parts

/// Section 7.2 with what the paper does not say: altitude, pitch.
void chessboard() {
    const auto board = [](std::uint32_t triangles) {
        return scenes::chessboard({.triangles = triangles, .side_m = 1}).groups.back().triangles;
    };
    const std::uint32_t large = is_quick ? 4'000'000 : 8'000'000;
    const auto few = drawn(board(large / 8), Splats{}, 1), many = drawn(board(large), Splats{}, 1);
    const double pitch = -8 * std::numbers::pi / 180;
    for (const float splat : {1.0f, 2.0f, 4.0f, 8.0f}) {
        std::vector<double> ms_few, ms_many;
        const int frames = is_quick ? 20 : 100;
        for (int i = 0; i < frames; ++i) {
            const glm::dvec3 eye(0, 0.05, 0.5 - 0.2 * i / frames);
            const View view = paper_view(eye, eye + glm::dvec3(0, std::sin(pitch), -std::cos(pitch)), splat);
            ms_few.push_back(1e3 * processor_seconds_in_turn(0, [&] { few->viewer.frame(view); }));
            ms_many.push_back(1e3 * processor_seconds_in_turn(0, [&] { many->viewer.frame(view); }));
        }
        std::printf("| chessboard, splat %g | %.2f ms, %.2f ms | %.2f%s |\n", double(splat), median(ms_few),
                    median(ms_many), median(ms_many) / median(ms_few), splat == 4 ? " (<= 1.1 wanted)" : "");
        std::fflush(stdout);
    }
}

template <class A>
void object_row(const char* name, const Triangles& triangles, const A& approximation, float tolerance_px,
                const std::vector<double>& distances, int samples) {
    const auto reference = drawn(triangles, Exact{}, 64);
    const auto exact = drawn(triangles, Exact{}, samples);
    const auto far = drawn(triangles, approximation, samples);
    for (const double distance : distances) {
        ObjectError mean;
        std::vector<double> ratios;
        const std::vector<View> views = views_around(triangles, distance, tolerance_px);
        double items = 0;
        for (const View& view : views) {
            View all = view;
            all.tolerance_px = 0;
            const ObjectError e = object_error(far->picture(view), reference->picture(all));
            mean.rmse += e.rmse / double(views.size());
            mean.bias += e.bias / double(views.size());
            items += double(far->viewer.frame(view).primitives) / double(views.size());
            ratios.push_back(1 / in_turns(
                                     {.least_turns = is_quick ? 3u : 9u, .seconds = 0.1},
                                     [&] { far->viewer.frame(view); }, [&] { exact->viewer.frame(all); })
                                     .speedup);
        }
        std::printf("| %s, %d samples, x %g | RMSE %.4f | coverage %+.2f %% | time / exact %.3f | %.0f triangles |\n",
                    name, samples, distance, mean.rmse, 100 * mean.bias, middle(ratios), items);
        std::fflush(stdout);
    }
}

void object_at_distances() {
    const Triangles o = object();
    const std::vector<double> distances{1, 2, 4, 8, 16, 30};
    for (const int samples : {64, 1}) {
        object_row("tensors, no samples", o, Tensors{.samples_up_to_px = 0}, 1, distances, samples);
        object_row("tensors", o, Tensors{}, 1, distances, samples);
    }
    object_row("splats", o, Splats{}, 1, distances, 64);
    object_row("splats, no samples", o, Splats{.samples_up_to_px = 0}, 1, distances, 64);
}

void leaves() {
    const Triangles t = tree();
    const std::vector<double> distances{1, 4, 16, 32, 64};
    object_row("leaves, tensors, no samples", t, Tensors{.samples_up_to_px = 0}, 1, distances, 64);
    object_row("leaves, tensors", t, Tensors{}, 1, distances, 64);
    object_row("leaves, splats", t, Splats{}, 1, distances, 64);
}

/// Parallel walls a two-thousandth apart, seen from either side: figure 5 of the paper. They lie off the octree's
/// planes.
void sheets() {
    Triangles walls;
    const int n = is_quick ? 100 : 300;
    for (const auto& [x, color] :
         {std::pair(0.3101f, Rgba8{255, 0, 0, 255}), std::pair(0.3091f, Rgba8{0, 0, 255, 255})}) {
        for (int j = 0; j < n; ++j) {
            for (int i = 0; i < n; ++i) {
                const auto at = [&, x = x](int u, int v) {
                    return glm::vec3(x, 2 * float(u) / float(n) - 1, 2 * float(v) / float(n) - 1);
                };
                walls.push_back({{at(i, j), at(i + 1, j), at(i + 1, j + 1)}, {color, color, color}});
                walls.push_back({{at(i, j), at(i + 1, j + 1), at(i, j + 1)}, {color, color, color}});
            }
        }
    }
    walls.push_back({{glm::vec3(-1), glm::vec3(-1, -1, -0.999f), glm::vec3(-1, -0.999f, -1)}, {}});
    const auto row = [&](const char* name, const auto& approximation) {
        const auto far = drawn(walls, approximation, 1);
        std::vector<double> wrong;
        for (const double distance : {10.0, 20.0, 40.0, 80.0}) {
            for (const double side : {1.0, -1.0}) {
                const Image& image = far->picture(paper_view({side * distance, 0, 0}, {}, 1));
                double shown = 0, hidden = 0;
                for (const Rgba8 c : image.pixels()) {
                    shown += c.a > 250;
                    hidden += c.a > 250 && (side > 0 ? c.b > c.r : c.r > c.b);
                }
                wrong.push_back(hidden / std::max(shown, 1.0));
            }
        }
        std::printf("| sheets, %s | hidden color in %.2f %% of pixels, at worst (<= 5 wanted) |\n", name,
                    100 * *std::max_element(wrong.begin(), wrong.end()));
        std::fflush(stdout);
    };
    row("splats", Splats{});
    row("splats of the mean color", Splats{.inner = {.samples = 0}});
    row("tensors", Tensors{});
    row("tensors with a color a side", SampleSet<SidedTensor>{});
}

/// Cells where a frame stops in which some polygon is seen and none of these is drawn: the paper's wrong parts of an
/// image. Seen is what an exact picture shows that the object fills.
void wrong_cells() {
    const Triangles o = object();
    using H = Over<Splats>;
    Box box_of_all = Box::empty();
    for (const auto& t : o) box_of_all.add(t.bounds());
    const glm::dvec3 o_center(box_of_all.center());
    std::vector<Triangle> ids(o.size());
    for (std::size_t i = 0; i < o.size(); ++i) {
        const auto id = std::uint32_t(i + 1);
        ids[i] = {o[i].vertices, Rgba8{std::uint8_t(id), std::uint8_t(id >> 8), std::uint8_t(id >> 16), 255}};
    }
    const H h = build<H>(ids, {.approximation = {.most_areas_for_sample = INFINITY}});
    ZBufferRenderer renderer, antialiasing(ZBufferOptions{.samples = 64});  // the second draws samples
    auto viewer = make_viewer(h, ids, renderer), stopping = make_viewer(h, ids, antialiasing);
    for (const double distance : {8.0, 16.0, 30.0}) {
        std::size_t cells = 0, wrong = 0, well_filled = 0, well_filled_wrong = 0;
        double seen_pixels = 0, wrong_pixels = 0;
        for (const View& view : views_around(o, distance, 1)) {
            // The same eye, and the object as large as the picture, so that polygons are larger than pixels.
            View fine = view;
            fine.camera = Camera::perspective(view.camera.eye, o_center, {0, 1, 0},
                                              2 * std::atan(std::tan(fov / 2) / float(distance)) * 1.1f);
            fine.width = fine.height = 1536;
            fine.tolerance_px = 0;
            viewer.frame(fine);
            std::vector<std::uint32_t> pixels_of(ids.size(), 0);
            for (const Rgba8 c : renderer.image().pixels()) {
                const std::uint32_t id = c.r | std::uint32_t(c.g) << 8 | std::uint32_t(c.b) << 16;
                if (id != 0) ++pixels_of[id - 1];
            }
            const auto selection = stopping.select(view);
            std::vector<char> is_drawn(ids.size(), 0);  // by position
            std::vector<Subtree> stops;
            selection.for_each([&](const auto&, const Selected& s) {
                std::uint32_t first = s.first, end = s.end;
                if (s.kind == Selected::Kind::stand_in) {
                    stops.push_back(s.subtree);
                    first = h.nodes()[s.subtree.node].first_item;
                    end = first + std::min(h.stand_ins()[s.subtree.stand_in].sample_size(), s.subtree.end_item - first);
                }
                std::fill(is_drawn.begin() + first, is_drawn.begin() + end, char(1));
            });
            const LocalView fine_view(fine, h.origin(), h.bounds());
            for (const Subtree& stop : stops) {
                std::uint32_t seen = 0, seen_and_drawn = 0;
                const auto look_at = [&](std::uint32_t at) {
                    const std::uint32_t pixels = pixels_of[h.order()[at]];
                    seen += pixels;
                    seen_and_drawn += is_drawn[at] ? pixels : 0;
                };
                for (std::uint32_t at = h.nodes()[stop.node].first_item; at < stop.end_item; ++at) look_at(at);
                // Samples that moved above the cell are drawn; only those in it count.
                if (seen == 0) continue;
                if (seen_and_drawn == 0) {
                    const Box box = stop.cell.box();
                    for (std::uint32_t at = 0; at < ids.size() && seen_and_drawn == 0; ++at) {
                        if (at >= h.nodes()[stop.node].first_item && at < stop.end_item) continue;
                        if (pixels_of[h.order()[at]] == 0 || !is_drawn[at]) continue;
                        const glm::vec3 center = ids[h.order()[at]].bounds().center();
                        if (box.intersects(Box{center, center})) seen_and_drawn = pixels_of[h.order()[at]];
                    }
                }
                ++cells;
                seen_pixels += seen;
                const float side = fine_view.pixels(stop.cell.largest_side(), fine_view.distance_to(stop.cell));
                const bool fills_half = float(seen) >= 0.5f * side * side;
                well_filled += fills_half;
                if (seen_and_drawn != 0) continue;
                ++wrong;
                well_filled_wrong += fills_half;
                wrong_pixels += seen;
            }
        }
        std::printf(
            "| cells, x %g | %zu wrong of %zu | of %zu that are half filled %zu (0 wanted) | %.3f %% of what is "
            "seen (<= 0.2 wanted) |\n",
            distance, wrong, cells, well_filled, well_filled_wrong, 100 * wrong_pixels / std::max(seen_pixels, 1.0));
        std::fflush(stdout);
    }
}

/// Against as many polygons, drawn at random, as take the same time: "comparable" is not said in the paper.
void uniform_subsets() {
    const auto row = [&](const char* name, const Triangles& triangles, const std::vector<View>& views) {
        const auto reference = drawn(triangles, Exact{}, 64);
        const auto far = drawn(triangles, Tensors{.samples_up_to_px = 0}, 64);
        Triangles shuffled = triangles;
        std::uint64_t state = 1;
        for (std::size_t i = shuffled.size(); i > 1; --i) {
            state = state * 6364136223846793005u + 1442695040888963407u;
            std::swap(shuffled[i - 1], shuffled[(state >> 33) % i]);
        }
        std::vector<double> ratios;
        for (const View& view : views) {
            View all = view;
            all.tolerance_px = 0;
            const Image truth = reference->picture(all);
            const double error = object_error(far->picture(view), truth).rmse;
            const auto least = [&](auto& d, const View& v) {
                double best = 1e9;
                for (int i = 0; i < 5; ++i)
                    best = std::min(best, processor_seconds_in_turn(1, [&] { d.viewer.frame(v); }));
                return best;
            };
            const double time = least(*far, view);
            // Time goes with the number of triangles, but not from 0.
            std::size_t count = shuffled.size();
            double other_error = 0;
            for (int step = 0; step < 4; ++step) {
                const auto some =
                    drawn(Triangles(shuffled.begin(), shuffled.begin() + std::ptrdiff_t(count)), Exact{}, 64);
                const double other = least(*some, all);
                other_error = object_error(some->picture(all), truth).rmse;
                if (std::abs(other / time - 1) < 0.05) break;
                const auto next =
                    std::clamp(std::size_t(double(count) * time / other), std::size_t(10), shuffled.size());
                if (next == count) break;
                count = next;
            }
            if (error > 0) ratios.push_back(other_error / error);
        }
        if (ratios.empty()) ratios.push_back(0);  // all was drawn
        std::printf("| uniform subsets, %s | error at equal time %.1f times that of sample sets, at least %.1f |\n",
                    name, middle(ratios), *std::min_element(ratios.begin(), ratios.end()));
        std::fflush(stdout);
    };
    const Triangles o = object();
    std::vector<View> views;
    for (const double distance : {8.0, 16.0, 30.0}) views.push_back(views_around(o, distance, 1).front());
    row("one object", o, views);
    const Triangles board =
        scenes::chessboard({.triangles = is_quick ? 1'000'000u : 8'000'000u, .side_m = 1}).groups.back().triangles;
    const glm::dvec3 eye(0, 0.05, 0.45), towards(0, std::sin(-0.14), -std::cos(0.14));
    for (const float splat : {2.0f, 4.0f, 8.0f}) {
        const std::string name = "a chessboard, splat " + std::to_string(int(splat));
        row(name.c_str(), board, {paper_view(eye, eye + towards, splat)});
    }
}

/// Section 7.5.
void instances() {
    const auto row = [](const char* name, const Triangles& triangles, int side, double spacing, float altitude,
                        std::initializer_list<float> splats) {
        using H = Over<Tensors>;
        using Placed = Instance<H, VertexColoredTriangle>;
        const H one = build<H>(triangles);
        std::vector<Placed> placed;
        for (int z = 0; z < side; ++z) {
            for (int x = 0; x < side; ++x) {
                const std::uint64_t mixed = detail::mixed(detail::mixed(1, std::uint64_t(x)), std::uint64_t(z));
                const double turn = 2 * std::numbers::pi * double(mixed >> 40) * 0x1p-24;
                const glm::dmat4 m = glm::translate(
                    glm::dmat4(1), glm::dvec3((x - 0.5 * side) * spacing, 0, (z - 0.5 * side) * spacing));
                placed.push_back({&one, triangles, Similarity(glm::rotate(m, turn, glm::dvec3(0, 1, 0)))});
            }
        }
        Drawn<H, Placed> all(placed, {}, 1);
        for (const float splat : splats) {
            std::vector<double> ms, parts, stops;
            const int frames = is_quick ? 10 : 100;
            for (int i = 0; i < frames; ++i) {
                const double at = double(i) / frames;
                const glm::dvec3 eye(spacing * side * 0.3 * (1 - at), double(altitude) * (1 + at),
                                     spacing * side * (0.55 - 0.5 * at));
                const View view = paper_view(eye, {0, 0, -0.2 * spacing * side}, splat);
                FrameStats stats;
                ms.push_back(1e3 * processor_seconds_in_turn(1, [&] { stats = all.viewer.frame(view); }));
                parts.push_back(double(stats.primitives));
                stops.push_back(double(stats.approximations));
            }
            std::printf("| %s, %.3g polygons, splat %g | %.1f ms | %.0f polygons, %.0f stand-ins |\n", name,
                        double(triangles.size()) * side * side, double(splat), median(ms), median(parts),
                        median(stops));
            std::fflush(stdout);
        }
    };
    const int few = is_quick ? 4 : 1;
    row("landscape of trees (<= 60; 20 ms wanted)", tree(), 200 / few, 8, 6, {2, 5});
    const Triangles o = object();
    Box box = Box::empty();
    for (const auto& t : o) box.add(t.bounds());
    row("10,000 of one object (<= 30; 12 ms wanted)", o, 100 / few, double(box.largest_side()) * 1.5,
        box.largest_side() * 2, {2, 4});
}

void building() {
    const auto row = [](const char* name, const Triangles& triangles) {
        double tensors = 1e9, splats = 1e9;
        for (int i = 0; i < 3; ++i) {
            tensors = std::min(tensors, processor_seconds_in_turn(1, [&] { build<Over<Tensors>>(triangles); }));
            splats = std::min(splats, processor_seconds_in_turn(1, [&] { build<Over<Splats>>(triangles); }));
        }
        const double count = double(triangles.size()) * 1e-6;
        std::printf("| building %s, %zu triangles | splats %.2f M/s, tensors %.2f M/s (>= 2.5 wanted) |\n", name,
                    triangles.size(), count / splats, count / tensors);
        std::fflush(stdout);
    };
    row("the object", object());
    row("a chessboard",
        scenes::chessboard({.triangles = is_quick ? 200'000u : 2'000'000u, .side_m = 1}).groups.back().triangles);
}

}  // namespace
}  // namespace farfield::bench

int main(int argc, char** argv) {
    using namespace farfield::bench;
    const std::vector<std::pair<std::string, void (*)()>> parts{
        {"chessboard", chessboard}, {"object", object_at_distances}, {"leaves", leaves},
        {"cells", wrong_cells},     {"uniform", uniform_subsets},    {"sheets", sheets},
        {"instances", instances},   {"building", building}};
    std::vector<std::string> wanted;
    for (int i = 1; i < argc; ++i) {
        if (std::strcmp(argv[i], "--quick") == 0) {
            is_quick = true;
        } else {
            wanted.emplace_back(argv[i]);
        }
    }
    for (const std::string& name : wanted) {
        if (std::none_of(parts.begin(), parts.end(), [&](const auto& part) { return part.first == name; })) {
            std::fprintf(stderr,
                         "bench_samples: no part %s; there are chessboard object leaves cells uniform sheets "
                         "instances building\n",
                         name.c_str());
            return 2;
        }
    }
    for (const auto& [name, part] : parts) {
        if (wanted.empty() || std::find(wanted.begin(), wanted.end(), name) != wanted.end()) part();
    }
    return 0;
}
