// Shade et al. 1996, section 5: a walk over an island, by images of cells and without.
#include <algorithm>
#include <array>
#include <chrono>
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
#include "farfield/partition/octree.hpp"
#include "farfield/renderer/z_buffer_renderer.hpp"
#include "farfield/viewer.hpp"
#include "scenes/generate/island.hpp"
#include "scenes/object.hpp"

using namespace farfield;

namespace {

double now_ms() {
    timespec t{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return double(t.tv_sec) * 1e3 + double(t.tv_nsec) * 1e-6;
}

template <class H>
struct Built {
    std::vector<std::vector<VertexColoredTriangle>> trees;
    std::vector<H> kinds;
    std::vector<scenes::Object<H>> objects;
    H hierarchy;

    Built(const scenes::Scene& scene, const typename H::approximation_type& approximation, const MeasuredTime& cost = {}) {
        for (std::size_t g = 0; g + 1 < scene.groups.size(); ++g) trees.push_back(scene.groups[g].triangles);
        for (auto& tree : trees) kinds.push_back(build_in_place<H>(tree, {.approximation = approximation, .cost_model = cost}));
        for (const auto& t : scene.groups.back().triangles) objects.push_back({t});
        for (const auto& p : scene.groups.back().placements)
            objects.push_back({Instance<H, VertexColoredTriangle>{&kinds[p.group], trees[p.group], Similarity(p.to_parent)}});
        hierarchy = build_in_place<H>(objects, {.approximation = approximation, .cost_model = cost});
    }
};

glm::dvec3 spline(std::span<const glm::dvec3> p, double t) {
    const double s = t * double(p.size() - 3);
    const std::size_t i = std::min(std::size_t(s), p.size() - 4);
    const double u = s - double(i);
    const double b0 = (1 - u) * (1 - u) * (1 - u) / 6, b1 = (3 * u * u * u - 6 * u * u + 4) / 6,
                 b2 = (-3 * u * u * u + 3 * u * u + 3 * u + 1) / 6, b3 = u * u * u / 6;
    return b0 * p[i] + b1 * p[i + 1] + b2 * p[i + 2] + b3 * p[i + 3];
}

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
    constexpr std::array<std::array<double, 2>, 11> plan{{{-0.42, 0.42}, {-0.44, 0.25}, {-0.45, 0.05}, {-0.44, -0.15},
        {-0.40, -0.32}, {-0.27, -0.38}, {-0.18, -0.30}, {-0.14, -0.15}, {-0.05, -0.02}, {0.05, 0.10}, {0.14, 0.22}}};
    std::vector<glm::dvec3> points;
    for (const auto& [x, z] : plan) points.emplace_back(x * side, 0, z * side);
    for (auto& p : points) p.y = height(p.x, p.z) + 9;
    std::vector<View> views;
    for (int f = 0; f < frames; ++f) {
        const double t = double(f) / double(frames);
        const glm::dvec3 eye = spline(points, t), ahead = spline(points, std::min(t + 0.08, 1.0) );
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

double error_of(const Image& a, const Image& b) {
    double sum = 0;
    for (std::size_t i = 0; i < a.pixels().size(); ++i) {
        const auto p = a.pixels()[i], q = b.pixels()[i];
        for (const int d : {p.r - q.r, p.g - q.g, p.b - q.b}) sum += d * d;
    }
    return std::sqrt(sum / double(3 * a.pixels().size()));
}

}  // namespace

int main(int argc, char** argv) {
    const int frames = argc > 1 ? std::atoi(argv[1]) : 300;
    const int every = argc > 2 ? std::atoi(argv[2]) : 10;
    ImageCacheOptions o;
    if (argc > 3) o.slices = std::atoi(argv[3]);
    if (argc > 4) o.of_instances_only = std::atoi(argv[4]) != 0;
    if (argc > 5) o.samples = std::atoi(argv[5]);
    if (argc > 6) o.threshold_px = float(std::atof(argv[6]));
    const auto env = [](const char* n, double d) { return std::getenv(n) ? std::atof(std::getenv(n)) : d; };
    o.least_items = std::uint32_t(env("LEAST", 1024));
    o.budget_bytes = std::uint64_t(env("BUDGET", 256e6));
    o.most_overhead = float(env("OVERHEAD", 0.25));
    o.is_conservative = env("CONSERVATIVE", 0) != 0;
    MeasuredTime cost;
    cost.texel = float(env("TEXEL", 2)); cost.image = float(env("IMAGE", 1000)); cost.small_triangle = float(env("SMALL", 3)); cost.near_triangle = float(env("NEAR", 60));
    const bool still = env("STILL", 0) != 0;
    const int first_frame = std::getenv("FIRST") ? std::atoi(std::getenv("FIRST")) : 0, count = std::getenv("COUNT") ? std::atoi(std::getenv("COUNT")) : frames;
    const scenes::Scene scene = scenes::island(scenes::shade_island);
    const float side = 300.0f * std::sqrt(1117.0f / 480.0f);
    const auto views = walk(scene, frames, side);
    const auto run = [&](auto inner) {
        using Inner = decltype(inner);
        using HE = SpatialHierarchy<Octree, Exact, MeasuredTime>;
        using HI = SpatialHierarchy<Octree, Inner, MeasuredTime>;
        using HC = SpatialHierarchy<Octree, ImageCache<Inner>, MeasuredTime>;
        ImageCache<Inner> approximation;
        approximation.image_options = o;
        const Built<HE> exact(scene, {});
        const Built<HI> plain(scene, {});
        const Built<HC> cached(scene, approximation, cost);
        const ZBufferOptions zo{.background = {135, 180, 220, 255}};
        ZBufferRenderer re(zo), ri(zo), rc(zo);
        auto ve = make_viewer(exact.hierarchy, exact.objects, re);
        auto vi = make_viewer(plain.hierarchy, plain.objects, ri);
        auto vc = make_viewer(cached.hierarchy, cached.objects, rc);
        std::vector<double> te, ti, tc, err;
        double images = 0, made = 0;
        std::uint64_t peak = 0;
        ve.frame(views[std::size_t(first_frame)]); vi.frame(views[std::size_t(first_frame)]);
        for (int f = first_frame; f < std::min(frames, first_frame + count); ++f) {
            double t = now_ms();
            if (f % every == 0) { ve.frame(views[std::size_t(still ? first_frame : f)]); te.push_back(now_ms() - t); }
            if (f % every == 0) { t = now_ms(); vi.frame(views[std::size_t(still ? first_frame : f)]); ti.push_back(now_ms() - t); }
            t = now_ms();
            const FrameStats s = vc.frame(views[std::size_t(still ? first_frame : f)]);
            tc.push_back(now_ms() - t);
            images += double(s.images); made += double(s.images_made); peak = std::max(peak, s.image_bytes);
            if (f % every == 0) {
                err.push_back(error_of(re.image(), rc.image()));
                if (std::getenv("VERBOSE")) std::printf("%4d exact %7.2f inner %7.2f cache %7.2f images %4d made %4d prim %d err %.2f\n", f, te.back(), ti.back(), tc.back(), int(s.images), int(s.images_made), int(s.primitives), err.back());
                if (std::getenv("PICTURES")) {
                    const auto ppm = [&](const char* name, const Image& im) { char n[64]; std::snprintf(n, sizeof n, "/tmp/h15-images/%s%04d.ppm", name, f); FILE* file = std::fopen(n, "wb"); std::fprintf(file, "P6\n%d %d\n255\n", im.width(), im.height()); for (auto p : im.pixels()) { std::fputc(p.r, file); std::fputc(p.g, file); std::fputc(p.b, file);} std::fclose(file); };
                    ppm("exact", re.image()); ppm("cache", rc.image()); ppm("inner", ri.image());
                }
            }
        }
        const auto mean = [](std::vector<double> v) { double s = 0; for (double x : v) s += x; return s / double(v.size()); };
        const double first = tc[0];
        auto sorted = tc; sorted.erase(sorted.begin()); std::sort(sorted.begin(), sorted.end());
        const double median = sorted[sorted.size() / 2];
        std::printf("exact %.2f inner %.2f cache %.2f ms: speedup %.2f over inner %.2f | first/exact %.2f p99/median %.2f max/median %.2f | images %.0f made %.2f peak %.1f MB rmse %.2f\n", mean(te), mean(ti), mean(tc), mean(te) / mean(tc), mean(ti) / mean(tc), first / te[0], sorted[sorted.size() * 99 / 100] / median, sorted.back() / median, images / double(tc.size()), made / double(tc.size()), double(peak) / 1e6, mean(err));
    };
#ifdef LOD
    run(OpacityTensor{});
#else
    run(Exact{});
#endif
}
