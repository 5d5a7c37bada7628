// Scenes larger than memory (Klein et al. 2002, sections 5 to 7), on their chessboards: building within 256 MiB, frames
// of a walk with a cache of 64 MiB, the first image, and caches smaller than what a walk needs.
//
//     bench_pages [--quick] [--directory DIR] [--millions N[,N...]] [--url URL [--delay-ms N]]
//
// --url: what a web server gives of the last file, for the first image and caches smaller than a walk needs, and
// nothing else; with --delay-ms every request to it takes so much longer. Files are kept in DIR (default: bench_pages
// in the system's folder for temporary files) and used again.
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
#include <span>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#if FARFIELD_HAS_HTTP
#include "farfield/adapters/http_page_source.hpp"
#endif
#include "farfield/approximation/sample_set.hpp"
#include "farfield/build_pages.hpp"
#include "farfield/cost_model/triangle_count.hpp"
#include "farfield/executor.hpp"
#include "farfield/measure/image_error.hpp"
#include "farfield/paging/open_pages.hpp"
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
        std::vector<float> line;
        for (std::uint32_t i = 0; i <= squares; ++i) line.push_back(float(double(i) / squares - 0.5));
        for (std::uint32_t row = 0; row < squares; ++row) {
            for (std::uint32_t column = 0; column < squares; ++column) {
                const float x0 = line[column], x1 = line[column + 1], z0 = line[row], z1 = line[row + 1];
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

/// Frames of one view until nothing is missing, or no more comes: a cache may be too small for it.
template <class V>
void settle(V& viewer, const Paged& pages, const View& view) {
    std::uint64_t loads = 0;
    auto last = Clock::now();
    while (viewer.frame(view).cells_missing != 0 && ms_since(last) < 1000) {
        if (const std::uint64_t now = pages.cache_stats().loads; now != loads) {
            loads = now;
            last = Clock::now();
        }
    }
}

/// One walk, a frame at a time.
class Walk {
  public:
    Walk(const std::filesystem::path& path, std::uint64_t triangles, double altitude, float splat)
        : triangles_(triangles),
          altitude_(altitude),
          splat_(splat),
          begin_(Clock::now()),
          pages_(open_pages<H, Triangle>(path, {.most_bytes = std::size_t(64) << 20})),
          viewer_(pages_, renderer_) {
        viewer_.frame(walk(0, altitude, 0, splat));
        first_ms_ = ms_since(begin_);
        settle(viewer_, pages_, walk(0, altitude, 0, splat));
        whole_ms_ = ms_since(begin_);
        before_ = pages_.cache_stats().loads;
    }
    void frame(int i) {
        const View view = walk(i, altitude_, altitude_ / 40, splat_);
        const auto begin = Clock::now();
        const FrameStats stats = viewer_.frame(view);
        ms_.push_back(ms_since(begin));
        missing_ += stats.cells_missing;
        primitives_ += stats.primitives;
        splats_ += stats.approximations;
        cells_ += stats.cells_visited;
        const std::uint64_t now = pages_.cache_stats().loads;
        loads_.push_back(double(now - std::exchange(before_, now)));
    }
    double median_ms() const { return quantile(ms_, 0.5); }
    void print() const {
        const PageCacheStats stats = pages_.cache_stats();
        const double frames = double(ms_.size());
        std::printf(
            "| walk, %.1f M, altitude %.2f, splat %g | median %.1f ms, worst %.1f; first image %.0f ms, whole %.0f; "
            "polygons + splats %.0f k + %.0f k, cells %.0f k; pages a frame: median %.0f, most %.0f; cells missing a "
            "frame %.1f; resident %llu of %u pages, evicted %llu |\n",
            double(triangles_) / 1e6, altitude_, double(splat_), quantile(ms_, 0.5), quantile(ms_, 1), first_ms_,
            whole_ms_, double(primitives_) / frames / 1e3, double(splats_) / frames / 1e3,
            double(cells_) / frames / 1e3, quantile(loads_, 0.5), quantile(loads_, 1), double(missing_) / frames,
            static_cast<unsigned long long>(stats.resident), pages_.page_count(),
            static_cast<unsigned long long>(stats.evictions));
        std::fflush(stdout);
    }

  private:
    std::uint64_t triangles_;
    double altitude_;
    float splat_;
    Clock::time_point begin_;
    Paged pages_;
    ZBufferRenderer renderer_;
    Viewer<Paged, Triangle, ZBufferRenderer> viewer_;
    double first_ms_ = 0, whole_ms_ = 0;
    std::vector<double> ms_, loads_;
    std::uint64_t missing_ = 0, primitives_ = 0, splats_ = 0, cells_ = 0, before_ = 0;
};

/// A source whose reads take longer, as those of a server that is far away; those of the first bytes, which are kept,
/// do not.
template <class S>
struct Delayed {
    S source;
    std::chrono::milliseconds delay;
    std::uint64_t kept_bytes = 0;

    std::uint64_t size() const noexcept { return source.size(); }
    ReadMerging merging() const noexcept { return source.merging(); }
    ReadResult read(std::uint64_t offset, std::span<std::byte> bytes) noexcept {
        if (offset + bytes.size() > kept_bytes) std::this_thread::sleep_for(delay);
        return source.read(offset, bytes);
    }
    void cancel() noexcept requires(CancellablePageSource<S>) { source.cancel(); }
};

/// From nothing to a first image, and to one that misses nothing: medians of several. `open()` opens what is read.
template <class Open>
void first_images(const char* from, int repeats, Open&& open) {
    for (const double altitude : {0.05, 0.02}) {
        const View view = walk(0, altitude, 0, 4);
        std::vector<double> opened_ms, first_ms, whole_ms, reads, frames, empty;
        for (int i = 0; i < repeats; ++i) {
            const auto begin = Clock::now();
            const Paged pages = open();
            opened_ms.push_back(ms_since(begin));
            ZBufferRenderer renderer;
            auto viewer = make_viewer(pages, renderer);
            viewer.frame(view);
            first_ms.push_back(ms_since(begin));
            const std::vector<Rgba8> first(renderer.image().pixels().begin(), renderer.image().pixels().end());
            int count = 1;
            while (viewer.frame(view).cells_missing != 0 && ms_since(begin) < 20'000) ++count;
            whole_ms.push_back(ms_since(begin));
            frames.push_back(count);
            reads.push_back(double(pages.cache_stats().reads));
            const auto whole = renderer.image().pixels();
            double holes = 0;
            for (std::size_t p = 0; p < first.size(); ++p) holes += first[p].a == 0 && whole[p].a == 255;
            empty.push_back(holes);
        }
        std::printf(
            "| first image, %s, altitude %.2f, median of %d | opened %.1f ms, first image %.1f ms, worst %.1f, in "
            "which %.0f pixels have nothing; nothing missing after %.0f ms, %.0f frames, %.0f reads |\n",
            from, altitude, repeats, quantile(opened_ms, 0.5), quantile(first_ms, 0.5), quantile(first_ms, 1),
            quantile(empty, 0.5), quantile(whole_ms, 0.5), quantile(frames, 0.5), quantile(reads, 0.5));
        std::fflush(stdout);
    }
}

/// Walks over all boards, frame by frame in turn, so that whatever else the machine does meets all of them.
void walks(const std::vector<std::filesystem::path>& files, const std::vector<double>& millions, int frames) {
    for (const double altitude : {0.05, 0.02}) {
        for (const float splat : {4.0f, 8.0f}) {
            std::vector<std::unique_ptr<Walk>> all;
            for (std::size_t i = 0; i < files.size(); ++i) {
                all.push_back(std::make_unique<Walk>(files[i], std::uint64_t(millions[i] * 1e6), altitude, splat));
            }
            for (int i = 0; i < frames; ++i) {
                for (const auto& w : all) w->frame(i);
            }
            for (const auto& w : all) w->print();
            for (std::size_t i = 1; i < all.size(); ++i) {
                std::printf("| %g M / %g M, altitude %.2f, splat %g: frame times | %.2f |\n", millions[i], millions[0],
                            altitude, double(splat), all[i]->median_ms() / all[0]->median_ms());
            }
            std::fflush(stdout);
        }
    }
}

/// Error against frames that wait for everything, with less memory than the walk touches. `open(most_bytes)` opens what
/// is read by the limited ones.
template <class Open>
void caps(const std::filesystem::path& path, int frames, const char* from, Open&& open) {
    const double altitude = 0.02;
    auto all = open_pages<H, Triangle>(path, {.most_bytes = std::size_t(1) << 30});
    all.wait_for_pages(true);
    ZBufferRenderer renderer, limited_renderer;
    auto viewer = make_viewer(all, renderer);
    const auto view = [&](int i) { return walk(i, altitude, altitude / 40, 4); };
    for (int i = 0; i < frames; ++i) viewer.frame(view(i));
    const double working_set = double(all.cache_stats().loads) * all.page_bytes();
    for (const double part : {0.05, 0.1, 0.25, 0.5, 1.0}) {
        const Paged pages = open(std::size_t(part * working_set) + (std::size_t(4) << 20));
        auto limited = make_viewer(pages, limited_renderer);
        settle(limited, pages, view(0));
        double squares = 0;
        std::vector<double> ms;
        std::uint64_t missing = 0, holes = 0;
        for (int i = 0; i < frames; ++i) {
            viewer.frame(view(i));
            const auto begin = Clock::now();
            missing += limited.frame(view(i)).cells_missing;
            ms.push_back(ms_since(begin));
            const auto& a = limited_renderer.image().pixels();
            const auto& b = renderer.image().pixels();
            for (std::size_t p = 0; p < a.size(); ++p) {
                squares += (double(a[p].g) - b[p].g) * (double(a[p].g) - b[p].g) / (255.0 * 255.0) / double(a.size());
                holes += a[p].a == 0 && b[p].a != 0;
            }
        }
        std::printf(
            "| %s, cache of %.0f %% of %.0f MiB and 4 MiB, %d frames | RMSE %.4f against waiting, pixels without "
            "anything %llu, cells missing a frame %.0f, frame median %.1f ms, worst %.1f, loaded again within 60 "
            "frames "
            "%llu |\n",
            from, 100 * part, working_set / 1048576, frames, std::sqrt(squares / frames),
            static_cast<unsigned long long>(holes), double(missing) / frames, quantile(ms, 0.5), quantile(ms, 1),
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
    std::string url;
    int delay_ms = 0;
    for (int i = 1; i < argc; ++i) {
        const std::string argument = argv[i];
        if (argument == "--quick") {
            millions = {1};
            frames = 50;
        } else if (argument == "--directory" && i + 1 < argc) {
            directory = argv[++i];
        } else if (argument == "--url" && i + 1 < argc) {
            url = argv[++i];
        } else if (argument == "--delay-ms" && i + 1 < argc) {
            delay_ms = std::atoi(argv[++i]);
        } else if (argument == "--millions" && i + 1 < argc) {
            millions.clear();
            for (const char* p = argv[++i]; *p != '\0';) {
                char* end = nullptr;
                millions.push_back(std::strtod(p, &end));
                if (end == p) break;
                p = *end == ',' ? end + 1 : end;
            }
        } else {
            std::fprintf(
                stderr,
                "bench_pages: %s is no option; there are --quick, --directory DIR, --millions N,N, --url URL and "
                "--delay-ms N\n",
                argument.c_str());
            return 2;
        }
    }
    std::filesystem::create_directories(directory);
    std::vector<std::filesystem::path> files;
    for (const double m : millions) files.push_back(build_if_missing(directory, std::uint64_t(m * 1e6)));
    const int capped_frames = frames < 200 ? frames : 600, repeats = frames < 200 ? 5 : 15;
    if (url.empty()) {
        first_images("file", repeats, [&] {
            return farfield::open_pages<H, farfield::Triangle>(files.back(), {.most_bytes = std::size_t(64) << 20});
        });
        walks(files, millions, frames);
        caps(files.back(), capped_frames, "file", [&](std::size_t most_bytes) {
            return farfield::open_pages<H, farfield::Triangle>(files.back(), {.most_bytes = most_bytes});
        });
    } else {
#if FARFIELD_HAS_HTTP
        const std::chrono::milliseconds delay(delay_ms);
        const auto open = [&](std::size_t most_bytes) {
            std::this_thread::sleep_for(delay);
            using Source = Delayed<farfield::HttpPageSource>;
            const farfield::HttpOptions options;
            auto source =
                std::make_shared<Source>(Source{farfield::HttpPageSource(url, options), delay, options.head_bytes});
            return farfield::open_pages_of<H, farfield::Triangle>(std::move(source), url, {.most_bytes = most_bytes});
        };
        first_images("HTTP", repeats, [&] { return open(std::size_t(64) << 20); });
        caps(files.back(), capped_frames, "HTTP", open);
#else
        std::fprintf(stderr, "bench_pages: built without libcurl\n");
        return 2;
#endif
    }
    return 0;
}
