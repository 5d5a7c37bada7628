// Shade et al. 1996, section 5: a walk over an island of 40.6 million triangles, by images of cells and without, over
// exact geometry and over a far field; exact frames among them, in one run. Times are the processor's.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <span>
#include <string>
#include <vector>

#include "farfield/approximation/exact.hpp"
#include "farfield/approximation/image_cache.hpp"
#include "farfield/approximation/opacity_tensor.hpp"
#include "farfield/build.hpp"
#include "farfield/cost_model/measured_time.hpp"
#include "farfield/partition/gap_bsp.hpp"
#include "farfield/renderer/z_buffer_renderer.hpp"
#include "farfield/viewer.hpp"
#include "scenes/generate/island.hpp"
#include "scenes/object.hpp"

using namespace farfield;

namespace {

/// Of this thread, on the processor.
double now_ms() {
    timespec t{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return double(t.tv_sec) * 1e3 + double(t.tv_nsec) * 1e-6;
}

/// A scene whose last group places the others.
template <class H>
struct Built {
    std::vector<std::vector<VertexColoredTriangle>> trees;
    std::vector<H> kinds;
    std::vector<scenes::Object<H>> objects;
    H hierarchy;

    Built(const scenes::Scene& scene, const typename H::approximation_type& approximation) {
        for (std::size_t g = 0; g + 1 < scene.groups.size(); ++g) trees.push_back(scene.groups[g].triangles);
        for (auto& tree : trees) kinds.push_back(build_in_place<H>(tree, {.approximation = approximation}));
        for (const auto& t : scene.groups.back().triangles) objects.push_back({t});
        for (const auto& p : scene.groups.back().placements)
            objects.push_back(
                {Instance<H, VertexColoredTriangle>{&kinds[p.group], trees[p.group], Similarity(p.to_parent)}});
        hierarchy = build_in_place<H>(objects, {.approximation = approximation});
    }
};

/// A uniform cubic B-spline, t in [0, 1].
glm::dvec3 spline(std::span<const glm::dvec3> p, double t) {
    const double s = t * double(p.size() - 3);
    const std::size_t i = std::min(std::size_t(s), p.size() - 4);
    const double u = s - double(i);
    const double b0 = (1 - u) * (1 - u) * (1 - u) / 6, b1 = (3 * u * u * u - 6 * u * u + 4) / 6,
                 b2 = (-3 * u * u * u + 3 * u * u + 3 * u + 1) / 6, b3 = u * u * u / 6;
    return b0 * p[i] + b1 * p[i + 1] + b2 * p[i + 2] + b3 * p[i + 3];
}

/// "The camera first tracks along the edge of the model, then flies in toward the center of the island at tree-top
/// level."
std::vector<View> walk(const scenes::Scene& scene, int frames, float side) {
    const auto& ground = scene.groups.back().triangles;
    const auto height = [&](double x, double z) {
        float h = 0;
        for (const auto& t : ground) {
            const glm::vec3 v = t.vertices[0];
            if (std::abs(v.x - float(x)) < 6 && std::abs(v.z - float(z)) < 6) h = std::max(h, v.y);
        }
        return double(h);
    };
    // Fractions of the island's side: along the edge, then in to the middle.
    constexpr std::array<std::array<double, 2>, 11> plan{{{-0.42, 0.42},
                                                          {-0.44, 0.25},
                                                          {-0.45, 0.05},
                                                          {-0.44, -0.15},
                                                          {-0.40, -0.32},
                                                          {-0.27, -0.38},
                                                          {-0.18, -0.30},
                                                          {-0.14, -0.15},
                                                          {-0.05, -0.02},
                                                          {0.05, 0.10},
                                                          {0.14, 0.22}}};
    std::vector<glm::dvec3> points;
    for (const auto& [x, z] : plan) points.emplace_back(x * side, 0, z * side);
    for (auto& p : points) p.y = height(p.x, p.z) + 9;
    std::vector<View> views;
    for (int f = 0; f < frames; ++f) {
        const double t = double(f) / double(frames);
        const glm::dvec3 eye = spline(points, t), ahead = spline(points, std::min(t + 0.08, 1.0));
        const double inward = std::max(0.0, 1 - 2 * t);
        glm::dvec3 target = glm::mix(ahead, glm::dvec3(0.0, eye.y - 2, 0.0), 0.35 + 0.5 * inward);
        if (glm::length(target - eye) < 5) target = eye + glm::dvec3(1, 0, 1);
        target.y = eye.y - 0.05 * glm::length(target - eye);
        View view;
        view.width = 640;
        view.height = 480;
        view.camera = Camera::perspective(eye, target, {0, 1, 0}, 0.785398f);
        views.push_back(view);
    }
    return views;
}

/// Root mean square over channels, in 255ths.
double error_of(const Image& a, const Image& b) {
    double sum = 0;
    for (std::size_t i = 0; i < a.pixels().size(); ++i) {
        const auto p = a.pixels()[i], q = b.pixels()[i];
        for (const int d : {p.r - q.r, p.g - q.g, p.b - q.b}) sum += d * d;
    }
    return std::sqrt(sum / double(3 * a.pixels().size()));
}

struct Wanted {
    int frames = 1200;     ///< along the path
    int first = 0;         ///< drawn from this one on,
    int count = 1200;      ///< so many
    int exact_every = 24;  ///< exact frames among them
    ImageCacheOptions images{.budget_bytes = std::uint64_t(256) << 20};
};

double mean(std::span<const double> v) {
    double sum = 0;
    for (const double x : v) sum += x;
    return sum / double(v.size());
}

/// One walk: exact frames, those of `Inner` and of images over it in turns.
template <class Inner>
void walk_with(const char* name, const scenes::Scene& scene, std::span<const View> views, const Wanted& wanted) {
    using WithoutImages = SpatialHierarchy<GapBsp, Inner, MeasuredTime>;
    using WithImages = SpatialHierarchy<GapBsp, ImageCache<Inner>, MeasuredTime>;
    ImageCache<Inner> approximation;
    approximation.image_options = wanted.images;
    const Built<SpatialHierarchy<GapBsp, Exact, MeasuredTime>> exact(scene, {});
    const Built<WithoutImages> plain(scene, {});
    const Built<WithImages> cached(scene, approximation);
    const ZBufferOptions sky{.background = {135, 180, 220, 255}};
    ZBufferRenderer exact_renderer(sky), plain_renderer(sky), cached_renderer(sky);
    auto exact_viewer = make_viewer(exact.hierarchy, exact.objects, exact_renderer);
    auto plain_viewer = make_viewer(plain.hierarchy, plain.objects, plain_renderer);
    auto cached_viewer = make_viewer(cached.hierarchy, cached.objects, cached_renderer);
    exact_viewer.frame(views[std::size_t(wanted.first)]);  // buffers grow
    plain_viewer.frame(views[std::size_t(wanted.first)]);
    std::vector<double> exact_ms, plain_ms, cached_ms, errors;
    double drawn = 0, made = 0;
    std::uint64_t most_bytes = 0;
    const int end = std::min(wanted.frames, wanted.first + wanted.count);
    for (int f = wanted.first; f < end; ++f) {
        const View& view = views[std::size_t(f)];
        const auto timed = [&](std::vector<double>& into, auto& viewer) {
            const double start = now_ms();
            const FrameStats stats = viewer.frame(view);
            into.push_back(now_ms() - start);
            return stats;
        };
        const bool compared = (f - wanted.first) % wanted.exact_every == 0;
        if (compared) {
            timed(exact_ms, exact_viewer);
            timed(plain_ms, plain_viewer);
        }
        const FrameStats stats = timed(cached_ms, cached_viewer);
        drawn += double(stats.images);
        made += double(stats.images_made);
        most_bytes = std::max(most_bytes, stats.image_bytes);
        if (compared) errors.push_back(error_of(exact_renderer.image(), cached_renderer.image()));
    }
    std::vector<double> later(cached_ms.begin() + (cached_ms.size() > 1 ? 1 : 0), cached_ms.end());
    std::sort(later.begin(), later.end());
    const double median = later[later.size() / 2], frames = double(cached_ms.size());
    std::printf(
        "%-16s exact %7.2f ms, without images %7.2f, with %7.2f: %5.2f times exact, %5.2f without | first / exact "
        "%.2f, "
        "p99 / median %.2f, slowest / median %.2f | %.0f images drawn, %.2f made a frame, %.1f MB | RMSE %.1f / 255\n",
        name, mean(exact_ms), mean(plain_ms), mean(cached_ms), mean(exact_ms) / mean(cached_ms),
        mean(plain_ms) / mean(cached_ms), cached_ms[0] / exact_ms[0], later[later.size() * 99 / 100] / median,
        later.back() / median, drawn / frames, made / frames, double(most_bytes) / 1e6, mean(errors));
}

}  // namespace

/// --quick: 40 frames of the path. --frames N: along the path; --first N, --count N: those drawn.
int main(int argc, char** argv) {
    Wanted wanted;
    for (int i = 1; i < argc; ++i) {
        const std::string option = argv[i];
        const auto number = [&] { return i + 1 < argc ? std::atof(argv[++i]) : 0.0; };
        if (option == "--quick") {
            wanted.first = 300;
            wanted.count = 40;
            wanted.exact_every = 10;
        } else if (option == "--frames") {
            wanted.frames = std::max(1, int(number()));
        } else if (option == "--first") {
            wanted.first = std::max(0, int(number()));
        } else if (option == "--count") {
            wanted.count = std::max(1, int(number()));
        } else if (option == "--threshold") {
            wanted.images.threshold_px = float(number());
        } else if (option == "--slices") {
            wanted.images.slices = int(number());
        } else if (option == "--samples") {
            wanted.images.samples = int(number());
        } else if (option == "--instances-only") {
            wanted.images.of_instances_only = true;
        } else if (option == "--conservative") {
            wanted.images.is_conservative = true;
        } else {
            std::fprintf(stderr, "bench_images: unknown option %s\n", argv[i]);
            return 2;
        }
    }
    wanted.first = std::min(wanted.first, wanted.frames - 1);
    const scenes::Scene scene = scenes::island(scenes::shade_island);
    const float side = 300.0f * std::sqrt(float(scenes::shade_island.trees) / 480.0f);
    const std::vector<View> views = walk(scene, wanted.frames, side);
    walk_with<Exact>("over exact", scene, views, wanted);
    walk_with<OpacityTensor>("over tensors", scene, views, wanted);
    return 0;
}
