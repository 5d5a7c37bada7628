#include "run.hpp"

#include <algorithm>
#include <chrono>
#include <memory>
#include <stdexcept>
#include <string>

#include "farfield/build.hpp"
#include "farfield/measure/projected_rect.hpp"
#include "report/picture.hpp"
#include "report/progress.hpp"
#include "variants.hpp"

namespace walkthrough {
namespace {

namespace report = farfield::report;
using farfield::FrameStats;
using farfield::Image;
using farfield::View;
using farfield::scenes::BuiltScene;
using farfield::scenes::RendererChoice;
using farfield::scenes::RendererKind;
using farfield::scenes::SceneViewer;

/// Exact at 64 samples a pixel, of one frame.
struct Reference {
    int frame;
    Image image;
    Image over_background;
    std::optional<farfield::PixelRect> rect;  ///< what is compared; none: all
};

class Run {
  public:
    Run(const Setting& setting, const Options& options, const Flight& flight)
        : setting_(setting), options_(options), flight_(flight) {}

    std::vector<Result> all() {
        progress_.begin("building exact");
        exact_ = variants().front().build(setting_.scene);
        make_references();
        exact_renderer_ =
            variants().front().obstacle(options_.renderer).empty() ? options_.renderer : RendererKind::z_buffer;
        exact_viewer_ = exact_->viewer(renderer(exact_renderer_, options_.samples));
        std::vector<Result> results;
        for (const std::string& name : options_.variants) results.push_back(result_of(*find_variant(name)));
        return results;
    }

  private:
    RendererChoice renderer(RendererKind kind, int samples, bool maps_work = false) const {
        return {
            .kind = kind, .samples = samples, .culls_back_faces = setting_.culls_back_faces, .maps_work = maps_work};
    }

    /// Throws UsageError where what was built turns out not to be in the order that the renderer needs.
    std::unique_ptr<SceneViewer> viewer_of(const BuiltScene& built, const Variant& variant,
                                           bool maps_work = false) const {
        try {
            return built.viewer(renderer(options_.renderer, options_.samples, maps_work));
        } catch (const std::invalid_argument& error) {
            throw UsageError("the renderer '" + std::string(name_of(options_.renderer)) + "' cannot draw '" +
                             std::string(variant.name) + "' of this scene: " + error.what());
        }
    }

    View view_of(int frame, farfield::DistanceMeasure distance = {}) const {
        return {.camera = flight_.cameras[std::size_t(frame)],
                .width = options_.width,
                .height = options_.height,
                .tolerance_px = options_.tolerance_px,
                .distance = distance};
    }

    void make_references() {
        // Its viewer goes before the next comes: each holds a copy of all triangles.
        const auto viewer = exact_->viewer(renderer(RendererKind::z_buffer, 64));
        progress_.begin("drawing references", int(flight_.quality_frames.size()));
        for (const int frame : flight_.quality_frames) {
            const View view = view_of(frame);
            viewer->frame(view);
            const Image& image = viewer->image();
            Reference reference{frame, image, report::over_background(image, setting_.background), std::nullopt};
            if (options_.distance) reference.rect = projected_rect(setting_.bounds, view);
            if (options_.out_directory) report::write_png(reference.over_background, file("reference", frame));
            references_.push_back(std::move(reference));
            progress_.step();
        }
    }

    Result result_of(const Variant& variant) {
        const bool is_exact = &variant == &variants().front();
        Result result;
        result.name = variant.name;
        std::unique_ptr<BuiltScene> built;
        std::unique_ptr<SceneViewer> viewer;
        if (!is_exact) {
            progress_.begin("building " + result.name);
            built = variant.build(setting_.scene);
            viewer = viewer_of(*built, variant);
        }
        result.build = (is_exact ? exact_ : built)->facts();
        result.renderer = is_exact ? exact_renderer_ : options_.renderer;
        progress_.begin("drawing " + result.name, options_.frames);
        auto reference = references_.begin();
        for (int frame = 0; frame < options_.frames; ++frame) {
            FrameStats stats;
            result.exact_ms.push_back(timed(*exact_viewer_, view_of(frame), stats));
            result.frame_ms.push_back(is_exact ? result.exact_ms.back()
                                               : timed(*viewer, view_of(frame, variant.distance), stats));
            add(stats, result.drawn);
            add((is_exact ? exact_viewer_ : viewer)->work(), result);
            if (reference != references_.end() && reference->frame == frame) {
                compare((is_exact ? exact_viewer_ : viewer)->image(), *reference++, result);
            }
            progress_.step();
        }
        if (!is_exact && options_.out_directory && result.drawn.approximations > 0) draw_cut(*viewer, variant);
        if (result.coverage && options_.out_directory) {
            viewer.reset();  // it holds a copy of all triangles
            draw_work(*(is_exact ? exact_ : built), variant);
        }
        return result;
    }

    static double timed(SceneViewer& viewer, const View& view, FrameStats& stats) {
        const auto begin = std::chrono::steady_clock::now();
        stats = viewer.frame(view);
        return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count();
    }

    void add(const FrameStats& stats, Drawn& drawn) const {
        const double weight = 1.0 / options_.frames;
        drawn.primitives += weight * double(stats.primitives);
        drawn.approximations += weight * double(stats.approximations);
        drawn.cells_visited += weight * double(stats.cells_visited);
        drawn.touched_bytes += weight * double(stats.touched_bytes);
        auto& by_level = drawn.approximations_by_level;
        for (std::size_t level = 0; level < FrameStats::max_levels; ++level) {
            if (stats.approximations_by_level[level] == 0) continue;
            by_level.resize(std::max(by_level.size(), level + 1));
            by_level[level] += weight * double(stats.approximations_by_level[level]);
        }
    }

    /// Null where none is counted.
    void add(const farfield::CoverageWork* work, Result& result) const {
        if (work == nullptr) return;
        if (!result.coverage) result.coverage = CoverageCells{result.build.keeps_strict_order};
        const double weight = 1.0 / options_.frames / options_.width / options_.height;
        result.coverage->tiling += weight * double(work->cells_tiled);
        result.coverage->asking += weight * double(work->cells_asked);
    }

    /// "Work images" (Greene 1996, figure 3) of the frames that are compared: by tiling polygons, by asking about
    /// cells, and their sum. Not while time is taken.
    void draw_work(const BuiltScene& built, const Variant& variant) {
        const auto viewer = viewer_of(built, variant, true);
        progress_.begin("drawing the work on " + std::string(variant.name), int(flight_.quality_frames.size()));
        for (const int frame : flight_.quality_frames) {
            viewer->frame(view_of(frame, variant.distance));
            const farfield::CoverageWorkImage& work = *viewer->work_map();
            std::vector<float> sum = work.tiled();
            for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += work.asked()[i];
            const auto write = [&](const std::vector<float>& visits, const char* kind) {
                const report::WorkMap map{visits, work.columns(), work.rows()};
                report::write_png(report::work_image(map, options_.width, options_.height),
                                  file(std::string(variant.name), frame, kind));
            };
            write(work.tiled(), "_work_tiling");
            write(work.asked(), "_work_asking");
            write(sum, "_work");
            progress_.step();
        }
    }

    /// Which cells are drawn by stand-ins, and which as geometry, in the frames that are compared.
    void draw_cut(SceneViewer& viewer, const Variant& variant) {
        progress_.begin("drawing the cut of " + std::string(variant.name), int(flight_.quality_frames.size()));
        for (const int frame : flight_.quality_frames) {
            const Image cut = viewer.how_drawn(view_of(frame, variant.distance));
            report::write_png(report::over_background(cut, setting_.background),
                              file(std::string(variant.name), frame, "_how_drawn"));
            progress_.step();
        }
    }

    void compare(const Image& image, const Reference& reference, Result& result) const {
        const Image picture = report::over_background(image, setting_.background);
        result.errors.add(reference.frame, image, reference.image, picture, reference.over_background, reference.rect);
        if (!options_.out_directory) return;
        report::write_png(picture, file(result.name, reference.frame));
        report::write_png(report::difference(picture, reference.over_background),
                          file(result.name, reference.frame, "_difference"));
    }

    std::filesystem::path file(const std::string& what, int frame, const char* kind = "") const {
        std::string number = std::to_string(frame);
        if (number.size() < 3) number.insert(0, 3 - number.size(), '0');
        return *options_.out_directory / (setting_.name + "_" + what + "_frame" + number + kind + ".png");
    }

    const Setting& setting_;
    const Options& options_;
    const Flight& flight_;
    report::Progress progress_;
    std::unique_ptr<BuiltScene> exact_;
    std::unique_ptr<SceneViewer> exact_viewer_;
    RendererKind exact_renderer_ = RendererKind::z_buffer;
    std::vector<Reference> references_;
};

}  // namespace

std::vector<Result> run(const Setting& setting, const Options& options, const Flight& flight) {
    return Run(setting, options, flight).all();
}

}  // namespace walkthrough
