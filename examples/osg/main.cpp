// Draws a forest along a path in four ways - plain, osg::LOD over osgUtil::Simplifier, osgSim::Impostor, farfield - and
// prints what each takes and errs by. Needs a display, be it Xvfb's. See --help.
#include <malloc.h>

#include <algorithm>
#include <chrono>
#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <functional>
#include <iostream>
#include <memory>
#include <string>
#include <vector>

#include "farfield/measure/flip.hpp"
#include "forest.hpp"
#include "report/picture.hpp"

namespace {

struct Options {
    far_osg::ForestOptions forest;
    int width = 640, height = 360, frames = 8, compared = 4, warm_up = 2;
    float tolerance_px = 6;
    std::string out;
};

/// All that malloc has given, which is what osg and Mesa's llvmpipe take.
double heap_mb() {
    const auto info = mallinfo2();
    return double(info.uordblks + info.hblkhd) / 1e6;
}

struct Way {
    std::string name;
    std::unique_ptr<far_osg::Stage> stage{};
    double prepared_s = 0, heap = 0, flip = 0;
    std::vector<double> ms{};

    double median() const {
        std::vector<double> sorted = ms;
        std::nth_element(sorted.begin(), sorted.begin() + std::ptrdiff_t(sorted.size() / 2), sorted.end());
        return sorted[sorted.size() / 2];
    }
};

void compare(const Options& options) {
    const far_osg::Forest forest(options.forest);
    std::printf("%d trees, %.2f million triangles, %d x %d\n",
                options.forest.trees_a_side * options.forest.trees_a_side, double(forest.triangles()) / 1e6,
                options.width, options.height);
    std::vector<Way> ways;
    const auto prepare = [&](const char* name, const std::function<osg::ref_ptr<osg::Group>()>& make) {
        Way& way = ways.emplace_back(Way{name});
        const double before = heap_mb();
        const auto begin = std::chrono::steady_clock::now();
        way.stage = std::make_unique<far_osg::Stage>(make(), options.width, options.height);
        for (int i = 0; i < options.warm_up; ++i) way.stage->frame(forest.eye(0));
        way.prepared_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
        way.heap = heap_mb() - before;
    };
    prepare("plain", [&] { return forest.plain(); });
    prepare("LOD of Simplifier", [&] { return forest.with_levels(); });
    prepare("Impostor", [&] { return forest.with_impostors(); });
    osg::ref_ptr<far_osg::FarDrawable> far_field;
    prepare("farfield", [&] { return forest.with_far_field(far_field = forest.far_field(options.tolerance_px)); });

    // The same scene at 64 samples a pixel is what all are compared with.
    constexpr int side = 8;
    far_osg::Stage fine(forest.plain(), options.width * side, options.height * side);
    double triangles = 0, stand_ins = 0;
    for (int i = 0; i < options.frames; ++i) {
        const far_osg::Eye eye = forest.eye(double(i) / std::max(options.frames - 1, 1));
        for (Way& way : ways) {  // in turns, as machines are not the same all the time
            const double before = heap_mb();
            way.ms.push_back(way.stage->frame(eye));
            way.heap += heap_mb() - before;
        }
        triangles += double(far_field->stats().primitives) / options.frames;
        stand_ins += double(far_field->stats().approximations) / options.frames;
        const int step = std::max(options.frames / options.compared, 1);
        if (i % step != step / 2) continue;
        fine.frame(eye);
        const farfield::Image reference = fine.mean_picture(side);
        std::vector<farfield::Image> pictures{reference};
        for (Way& way : ways) {
            pictures.push_back(way.stage->picture());
            way.flip += farfield::flip(pictures.back(), reference) / double((options.frames - 1 - step / 2) / step + 1);
        }
        if (options.out.empty()) continue;
        char name[32];
        std::snprintf(name, sizeof name, "frame%03d", i);
        const std::filesystem::path directory(options.out);
        farfield::report::write_png(reference, directory / (std::string(name) + "_64_samples.png"));
        for (std::size_t w = 0; w < ways.size(); ++w) {
            std::string way = ways[w].name.substr(0, ways[w].name.find(' '));
            farfield::report::write_png(pictures[w + 1], directory / (std::string(name) + "_" + way + ".png"));
        }
        farfield::report::write_png(farfield::report::side_by_side(pictures, 4),
                                    directory / (std::string(name) + "_side_by_side.png"));
    }
    std::printf("%-18s %10s %12s %8s %8s %12s\n", "", "ms a frame", "times plain", "FLIP", "MB", "prepared, s");
    for (const Way& way : ways) {
        std::printf("%-18s %10.1f %12.2f %8.4f %8.1f %12.2f\n", way.name.c_str(), way.median(),
                    ways[0].median() / way.median(), way.flip, way.heap, way.prepared_s);
    }
    const auto best =
        std::min_element(ways.begin(), ways.end() - 1, [](const Way& a, const Way& b) { return a.flip < b.flip; });
    std::printf("farfield draws %.0f triangles and %.0f stand-ins a frame\n", triangles, stand_ins);
    std::printf("farfield errs %.2f times as much as the best of osg's own (%s), and is %.1f times as fast\n",
                ways.back().flip / best->flip, best->name.c_str(), best->median() / ways.back().median());
}

}  // namespace

int main(int argc, char** argv) {
    Options options;
    CLI::App app("Draws a forest with OpenSceneGraph in four ways, and prints what each takes and errs by.");
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
        compare(options);
    } catch (const CLI::CallForHelp& help) {
        return app.exit(help);
    } catch (const std::exception& error) {
        std::cerr << "osg_forest: " << error.what() << "\n";
        return 2;
    }
}
