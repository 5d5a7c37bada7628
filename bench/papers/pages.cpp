// Scenes larger than memory (Klein et al. 2002, sections 5 to 7), on their chessboards: building within 256 MiB, frames
// of a walk with a cache of 64 MiB, the first image, and caches smaller than what a walk needs.
//
//     bench_pages [--quick] [--directory DIR] [--millions N[,N...]]
//
// Files are kept in DIR (default: bench_pages in the system's folder for temporary files) and used again.
#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include "farfield/approximation/sample_set.hpp"
#include "farfield/build_pages.hpp"
#include "farfield/cost_model/triangle_count.hpp"
#include "farfield/executor.hpp"
#include "farfield/measure/image_error.hpp"
#include "farfield/paging/paged_hierarchy.hpp"
#include "farfield/partition/octree.hpp"
#include "farfield/primitive/triangle.hpp"
#include "farfield/renderer/z_buffer_renderer.hpp"
#include "farfield/viewer.hpp"

namespace farfield::bench {
namespace {

using H = SpatialHierarchy<Octree, SampleSet<AreaSplat>, TriangleCount>;
using Paged = PagedHierarchy<H, Triangle>;
using Clock = std::chrono::steady_clock;

double ms_since(Clock::time_point begin) {
    return std::chrono::duration<double, std::milli>(Clock::now() - begin).count();
}

/// Black and white squares of two triangles each on a side of 1, row by row.
struct Chessboard {
    std::uint64_t triangles;
    template <class Take>
    void operator()(Take&& take) const {
        const auto squares = std::uint32_t(std::lround(std::sqrt(double(triangles) / 2)));
        const auto line = [&](std::uint32_t i) { return float(double(i) / squares - 0.5); };
        for (std::uint32_t row = 0; row < squares; ++row) {
            for (std::uint32_t column = 0; column < squares; ++column) {
                const float x0 = line(column), x1 = line(column + 1), z0 = line(row), z1 = line(row + 1);
                const glm::vec3 a(x0, 0, z0), b(x0, 0, z1), c(x1, 0, z1), d(x1, 0, z0);
                const Rgba8 color = (row + column) % 2 == 0 ? Rgba8{24, 24, 24, 255} : Rgba8{236, 236, 236, 255};
                take(Triangle{{a, b, c}, color});
                take(Triangle{{a, c, d}, color});
            }
        }
    }
};

std::filesystem::path build_if_missing(const std::filesystem::path& directory, std::uint64_t triangles) {
    const auto path = directory / ("chessboard-" + std::to_string(triangles / 1000) + "k.farfield");
    if (std::filesystem::exists(path)) return path;
    PageBuildOptions<H> options;
    options.build.executor = ThreadExecutor();
    const auto begin = Clock::now();
    build_pages<H, Triangle>(Chessboard{triangles}, path, options);
    const double seconds = ms_since(begin) / 1000;
    struct ::rusage usage {};
    ::getrusage(RUSAGE_SELF, &usage);
    const double bytes = double(std::filesystem::file_size(path));
    std::printf("| build, %.1f M polygons | %.1f s, %.2f M polygons/s, peak %.0f MiB; file / data %.3f |\n",
                double(triangles) / 1e6, seconds, double(triangles) / 1e6 / seconds, double(usage.ru_maxrss) / 1024,
                bytes / (double(triangles) * sizeof(Triangle)));
    std::fflush(stdout);
    return path;
}

/// Walking in from an edge, at `altitude` sides, turning slowly.
View walk(int frame, double altitude, double step, float splat_px) {
    const double angle = 0.3 * std::sin(frame * 0.02), pitch = -8 * std::numbers::pi / 180;
    const glm::dvec3 eye(0, altitude, 0.5 - frame * step);
    const glm::dvec3 ahead(std::sin(angle) * std::cos(pitch), std::sin(pitch), -std::cos(angle) * std::cos(pitch));
    return {.camera = Camera::perspective(eye, eye + ahead, {0, 1, 0}, std::numbers::pi_v<float> / 4),
            .width = 640,
            .height = 480,
            .tolerance_px = splat_px};
}

template <class T>
T quantile(std::vector<T> values, double q) {
    std::sort(values.begin(), values.end());
    return values[std::size_t(q * double(values.size() - 1))];
}

void walks(const std::filesystem::path& path, std::uint64_t triangles, int frames) {
    for (const double altitude : {0.05, 0.02}) {
        for (const float splat : {4.0f, 8.0f}) {
            const auto begin = Clock::now();
            const auto pages = open_pages<H, Triangle>(path, {.most_bytes = std::size_t(64) << 20});
            ZBufferRenderer renderer;
            auto viewer = make_viewer(pages, renderer);
            viewer.frame(walk(0, altitude, 0, splat));
            const double first = ms_since(begin);
            double whole = first;
            while (viewer.frame(walk(0, altitude, 0, splat)).cells_missing != 0) whole = ms_since(begin);
            std::vector<double> ms, loads;
            std::uint64_t missing = 0, primitives = 0, splats = 0, cells = 0;
            std::uint64_t before = pages.cache_stats().loads;
            for (int i = 0; i < frames; ++i) {
                const View view = walk(i, altitude, altitude / 40, splat);
                const auto frame_begin = Clock::now();
                const FrameStats stats = viewer.frame(view);
                ms.push_back(ms_since(frame_begin));
                missing += stats.cells_missing;
                primitives += stats.primitives;
                splats += stats.approximations;
                cells += stats.cells_visited;
                const std::uint64_t now = pages.cache_stats().loads;
                loads.push_back(double(now - before));
                before = now;
            }
            const PageCacheStats stats = pages.cache_stats();
            std::printf(
                "| walk, %.1f M, altitude %.2f, splat %g | median %.1f ms, worst %.1f; first image %.0f ms, whole "
                "%.0f; "
                "polygons + splats %.0f k + %.0f k, cells %.0f k; pages a frame: median %.0f, most %.0f; cells missing "
                "a frame "
                "%.1f; resident %llu of %u pages, evicted %llu |\n",
                double(triangles) / 1e6, altitude, double(splat), quantile(ms, 0.5), quantile(ms, 1), first, whole,
                double(primitives) / frames / 1e3, double(splats) / frames / 1e3, double(cells) / frames / 1e3,
                quantile(loads, 0.5), quantile(loads, 1), double(missing) / frames,
                static_cast<unsigned long long>(stats.resident), pages.page_count(),
                static_cast<unsigned long long>(stats.evictions));
            std::fflush(stdout);
        }
    }
}

/// Error against frames that wait for everything, with less memory than the walk touches.
void caps(const std::filesystem::path& path, int frames) {
    const double altitude = 0.02;
    auto all = open_pages<H, Triangle>(path, {.most_bytes = std::size_t(1) << 30});
    all.wait_for_pages(true);
    ZBufferRenderer renderer, limited_renderer;
    auto viewer = make_viewer(all, renderer);
    std::vector<Image> truth;
    for (int i = 0; i < frames; ++i) {
        viewer.frame(walk(i, altitude, altitude / 40, 4));
        truth.push_back(renderer.image());
    }
    const double working_set = double(all.cache_stats().resident) * all.page_bytes();
    for (const double part : {0.05, 0.1, 0.25, 0.5, 1.0}) {
        const auto bytes = std::size_t(part * working_set) + (std::size_t(4) << 20);
        const auto pages = open_pages<H, Triangle>(path, {.most_bytes = bytes});
        auto limited = make_viewer(pages, limited_renderer);
        double squares = 0, worst_ms = 0;
        std::uint64_t missing = 0;
        for (int i = 0; i < frames; ++i) {
            const auto begin = Clock::now();
            missing += limited.frame(walk(i, altitude, altitude / 40, 4)).cells_missing;
            worst_ms = std::max(worst_ms, ms_since(begin));
            const auto& a = limited_renderer.image().pixels();
            const auto& b = truth[std::size_t(i)].pixels();
            for (std::size_t p = 0; p < a.size(); ++p) {
                squares += (double(a[p].g) - b[p].g) * (double(a[p].g) - b[p].g) / (255.0 * 255.0) / double(a.size());
            }
        }
        std::printf(
            "| cache of %.0f %% of %.0f MiB and 4 MiB | RMSE %.4f against waiting, cells missing a frame %.0f, worst "
            "frame %.1f "
            "ms, loaded again within 60 frames %llu |\n",
            100 * part, working_set / 1048576, std::sqrt(squares / frames), double(missing) / frames, worst_ms,
            static_cast<unsigned long long>(pages.cache_stats().reloads));
        std::fflush(stdout);
    }
}

}  // namespace
}  // namespace farfield::bench

int main(int argc, char** argv) {
    using namespace farfield::bench;
    std::filesystem::path directory = std::filesystem::temp_directory_path() / "bench_pages";
    std::vector<double> millions{8, 80};
    int frames = 200;
    for (int i = 1; i < argc; ++i) {
        const std::string argument = argv[i];
        if (argument == "--quick") {
            millions = {1};
            frames = 50;
        } else if (argument == "--directory" && i + 1 < argc) {
            directory = argv[++i];
        } else if (argument == "--millions" && i + 1 < argc) {
            millions.clear();
            for (const char* p = argv[++i]; *p != '\0';) {
                char* end = nullptr;
                millions.push_back(std::strtod(p, &end));
                if (end == p) break;
                p = *end == ',' ? end + 1 : end;
            }
        } else {
            std::fprintf(stderr,
                         "bench_pages: %s is no option; there are --quick, --directory DIR and --millions N,N\n",
                         argument.c_str());
            return 2;
        }
    }
    std::filesystem::create_directories(directory);
    std::vector<std::filesystem::path> files;
    for (const double m : millions) files.push_back(build_if_missing(directory, std::uint64_t(m * 1e6)));
    for (std::size_t i = 0; i < files.size(); ++i) walks(files[i], std::uint64_t(millions[i] * 1e6), frames);
    caps(files.back(), std::min(frames, 100));
    return 0;
}
