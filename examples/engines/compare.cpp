#include "engines/compare.hpp"

#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <iostream>
#include <stdexcept>
#include <vector>

#include "farfield/measure/flip.hpp"
#include "report/picture.hpp"

namespace farfield::engines {
namespace {

struct Options {
    ForestOptions forest;
    int width = 640, height = 360, frames = 8, compared = 4, warm_up = 2;
    float tolerance_px = 6;
    std::string out;
};

struct Measured {
    std::string name;
    std::unique_ptr<Stage> stage{};
    double prepared_s = 0, peak_mb = 0, flip = 0;
    std::vector<double> ms{};

    double median() const {
        std::vector<double> sorted = ms;
        std::nth_element(sorted.begin(), sorted.begin() + std::ptrdiff_t(sorted.size() / 2), sorted.end());
        return sorted[sorted.size() / 2];
    }
};

/// The most memory of a process that draws the path's ends in one way and does nothing else: engines share much among
/// the ways of one process. To be called before an engine has begun.
double peak_mb(const Options& options, const Forest& forest, const WaysOf& ways_of, std::size_t way) {
    std::fflush(stdout);
    const pid_t child = fork();
    if (child == 0) {
        try {
            const auto stage = ways_of(forest, options.tolerance_px)[way].stage(options.width, options.height);
            for (const double along : {0.0, 1.0}) stage->frame(forest.eye(along));
            _exit(0);
        } catch (const std::exception& error) {
            std::cerr << error.what() << "\n";
            _exit(1);
        }
    }
    int status = 0;
    rusage used{};
    if (child < 0 || wait4(child, &status, 0, &used) != child || status != 0)
        throw std::runtime_error("a way could not be drawn");
    return double(used.ru_maxrss) * 1024 / 1e6;
}

void write_pictures(const Options& options, int frame, const std::vector<Image>& pictures,
                    const std::vector<Measured>& ways) {
    char name[32];
    std::snprintf(name, sizeof name, "frame%03d", frame);
    const auto file = [&](const std::string& what) {
        return std::filesystem::path(options.out) / (std::string(name) + "_" + what + ".png");
    };
    report::write_png(pictures[0], file("64_samples"));
    for (std::size_t w = 0; w < ways.size(); ++w) {
        report::write_png(pictures[w + 1], file(ways[w].name.substr(0, ways[w].name.find(' '))));
    }
    report::write_png(report::side_by_side(pictures, 4), file("side_by_side"));
}

void compare(const Options& options, const std::string& engine, const WaysOf& ways_of) {
    const Forest forest(options.forest);
    std::printf("%zu trees, %.2f million triangles, %d x %d\n", forest.trees.size(), double(forest.triangles()) / 1e6,
                options.width, options.height);
    std::vector<double> peaks;
    for (std::size_t way = 0; way < way_count; ++way) peaks.push_back(peak_mb(options, forest, ways_of, way));
    const auto all = ways_of(forest, options.tolerance_px);
    // The same scene at 64 samples a pixel is what all are compared with; what an engine takes to begin with is its.
    constexpr int side = 8;
    const auto fine = all.front().stage(options.width * side, options.height * side);
    fine->frame(forest.eye(0));
    std::vector<Measured> ways;
    for (const Way& one : all) {
        Measured& way = ways.emplace_back(Measured{one.name});
        way.peak_mb = peaks[ways.size() - 1];
        const auto begin = std::chrono::steady_clock::now();
        way.stage = one.stage(options.width, options.height);
        for (int i = 0; i < options.warm_up; ++i) way.stage->frame(forest.eye(0));
        way.prepared_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    }
    double triangles = 0, stand_ins = 0;
    for (int i = 0; i < options.frames; ++i) {
        const Eye eye = forest.eye(double(i) / std::max(options.frames - 1, 1));
        for (Measured& way : ways) {  // in turns, as machines are not the same all the time
            way.ms.push_back(way.stage->frame(eye));
        }
        const FrameStats stats = ways.back().stage->stats();
        triangles += double(stats.primitives) / options.frames;
        stand_ins += double(stats.approximations) / options.frames;
        const int step = std::max(options.frames / options.compared, 1);
        if (i % step != step / 2) continue;
        fine->frame(eye);
        std::vector<Image> pictures{mean_picture(fine->picture(), side)};
        for (Measured& way : ways) {
            pictures.push_back(way.stage->picture());
            way.flip += flip(pictures.back(), pictures[0]) / double((options.frames - 1 - step / 2) / step + 1);
        }
        if (!options.out.empty()) write_pictures(options, i, pictures, ways);
    }
    std::printf("%-18s %10s %12s %8s %8s %12s\n", "", "ms a frame", "times plain", "FLIP", "MB", "prepared, s");
    for (const Measured& way : ways) {
        std::printf("%-18s %10.1f %12.2f %8.4f %8.0f %12.2f\n", way.name.c_str(), way.median(),
                    ways[0].median() / way.median(), way.flip, way.peak_mb, way.prepared_s);
    }
    const auto best = std::min_element(ways.begin(), ways.end() - 1,
                                       [](const Measured& a, const Measured& b) { return a.flip < b.flip; });
    std::printf("farfield draws %.0f triangles and %.0f stand-ins a frame\n", triangles, stand_ins);
    std::printf("farfield errs %.2f times as much as the best of %s's own (%s), and is %.1f times as fast\n",
                ways.back().flip / best->flip, engine.c_str(), best->name.c_str(),
                best->median() / ways.back().median());
}

}  // namespace

int compare(int argc, char** argv, const std::string& engine, const WaysOf& ways_of) {
    Options options;
    CLI::App app("Draws a forest with " + engine + " in its own ways and by farfield: what each takes and errs by.");
    app.add_option("--trees", options.forest.trees_a_side, "on a side of the forest")->check(CLI::Range(1, 1000));
    app.add_option("--triangles", options.forest.triangles_a_tree)->check(CLI::Range(2000, 10'000'000));
    app.add_option("--kinds", options.forest.kinds, "of trees")->check(CLI::Range(1, 100));
    app.add_option("--width", options.width)->check(CLI::Range(1, 2000));
    app.add_option("--height", options.height)->check(CLI::Range(1, 2000));
    app.add_option("--frames", options.frames)->check(CLI::Range(1, 100'000));
    app.add_option("--compared", options.compared, "frames whose error is measured")->check(CLI::Range(1, 100'000));
    app.add_option("--tolerance", options.tolerance_px, "farfield's, in pixels")->check(CLI::Range(0.0f, 64.0f));
    app.add_option("--out", options.out, "a directory that is there, for pictures")->check(CLI::ExistingDirectory);
    try {
        app.parse(argc, argv);
        compare(options, engine, ways_of);
    } catch (const CLI::CallForHelp& help) {
        return app.exit(help);
    } catch (const std::exception& error) {
        std::cerr << argv[0] << ": " << error.what() << "\n";
        return 2;
    }
    return 0;
}

Image mean_picture(const Image& fine, int side) {
    Image out(fine.width() / side, fine.height() / side);
    const int count = side * side;
    for (int y = 0; y < out.height(); ++y) {
        for (int x = 0; x < out.width(); ++x) {
            int sum[3] = {count / 2, count / 2, count / 2};
            for (int v = 0; v < side; ++v) {
                for (int u = 0; u < side; ++u) {
                    const Rgba8 c = fine.at(x * side + u, y * side + v);
                    sum[0] += c.r, sum[1] += c.g, sum[2] += c.b;
                }
            }
            const auto mean = [&](int i) { return static_cast<std::uint8_t>(sum[i] / count); };
            out.at(x, y) = {mean(0), mean(1), mean(2), 255};
        }
    }
    return out;
}

}  // namespace farfield::engines
