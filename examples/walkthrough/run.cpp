#include "run.hpp"

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <memory>
#include <stdexcept>
#include <string>

#include "farfield/build.hpp"
#include "farfield/measure/image_error.hpp"
#include "farfield/measure/projected_rect.hpp"
#include "farfield/tuning/sampled_error_table.hpp"
#include "plain_loop.hpp"
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

/// Exact at the samples that are timed, of a frame that is compared.
struct ExactFrame {
    double ms = 0;
    Image over_background;
    double mse = 0;
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
        return {.kind = kind,
                .samples = samples,
                .culls_back_faces = setting_.culls_back_faces,
                .maps_work = maps_work,
                .threads = maps_work ? 1 : unsigned(options_.threads)};
    }

    /// Throws UsageError where what was built turns out not to be in the order that the renderer needs.
    std::unique_ptr<SceneViewer> viewer_of(const BuiltScene& built, const Variant& variant, int samples) const {
        try {
            return built.viewer(renderer(options_.renderer, samples));
        } catch (const std::invalid_argument& error) {
            throw UsageError("the renderer '" + std::string(name_of(options_.renderer)) + "' cannot draw '" +
                             std::string(variant.name) + "' of this scene: " + error.what());
        }
    }

    /// What a variant is drawn by.
    struct Asked {
        float tolerance_px = 0;
        farfield::DistanceMeasure distance{};
        int samples = 1;
        bool asks_wanted = false;
    };
    View view_of(int frame, const Asked& asked) const {
        return {.camera = flight_.cameras[std::size_t(frame)],
                .width = options_.width,
                .height = options_.height,
                .tolerance_px = asked.tolerance_px,
                .distance = asked.distance,
                .wanted =
                    asked.asks_wanted ? farfield::WantedError{.samples = asked.samples} : farfield::WantedError::any()};
    }
    View exact_view_of(int frame) const { return view_of(frame, {}); }

    void make_references() {
        // Its viewer goes before the next comes: each holds a copy of all triangles.
        const auto viewer = exact_->viewer(renderer(RendererKind::z_buffer, 64));
        progress_.begin("drawing references", int(flight_.quality_frames.size()));
        for (const int frame : flight_.quality_frames) {
            const View view = exact_view_of(frame);
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
        if (&variant == &variants().front()) return result_of_exact(variant);
        Result result;
        result.name = variant.name;
        progress_.begin("building " + result.name);
        std::unique_ptr<BuiltScene> built = variant.build(setting_.scene);
        std::unique_ptr<SceneViewer> own = viewer_of(*built, variant, options_.samples);
        result.build = built->facts();
        Asked asked{options_.tolerance_px, variant.distance, options_.samples};
        if (options_.error) {
            choose(*built, *own, variant, result);
            asked.tolerance_px = result.choice->tolerance.trial.tolerance_px;
            asked.samples = result.choice->samples;
            asked.asks_wanted = result.choice->asks_wanted;
        }
        const bool draws_exact = result.choice && result.choice->tolerance.is_exact();
        const bool has_exact_viewer = draws_exact && asked.samples == options_.samples;
        if (draws_exact || asked.samples != options_.samples) own.reset();  // it holds a copy of all triangles
        if (!own && !has_exact_viewer) {
            own = draws_exact ? exact_->viewer(renderer(exact_renderer_, asked.samples))
                              : viewer_of(*built, variant, asked.samples);
        }
        SceneViewer& viewer = has_exact_viewer ? *exact_viewer_ : *own;
        result.renderer = draws_exact ? exact_renderer_ : options_.renderer;
        std::optional<farfield::FrameBudget> budget;
        if (options_.budget_ms) budget = budget_of(viewer, variant, asked);
        progress_.begin("drawing " + result.name, options_.frames);
        auto compared = references_.begin();
        for (int frame = 0; frame < options_.frames; ++frame) {
            const bool is_compared = compared != references_.end() && compared->frame == frame;
            progress_.step();
            if (exact_is_slow_ && draws_exact && !is_compared) continue;
            FrameStats stats;
            if (!exact_is_slow_) result.exact_ms.push_back(timed(*exact_viewer_, exact_view_of(frame), stats));
            result.frame_ms.push_back(timed(viewer, view_of(frame, asked), stats, budget));
            if (!exact_is_slow_ || is_compared) result.paired_ms.push_back(result.frame_ms.back());
            if (exact_is_slow_ && is_compared)
                result.exact_ms.push_back(exact_frames_[std::size_t(compared - references_.begin())].ms);
            add(stats, result.drawn);
            add(viewer.work(), result);
            if (is_compared) compare(viewer.image(), *compared++, result);
        }
        scale(result);
        if (!draws_exact && options_.out_directory && result.drawn.approximations > 0) {
            draw_cut(viewer, variant, asked);
        }
        if (result.drawn.images > 0 && options_.out_directory) draw_from_outside(*built, variant, asked);
        if (result.coverage && options_.out_directory) {
            own.reset();  // it holds a copy of all triangles
            if (draws_exact) {
                draw_work(*exact_, exact_renderer_, variant, asked);
            } else {
                draw_work(*built, options_.renderer, variant, asked);
            }
        }
        return result;
    }

    /// All frames; or where they are slow those that are compared.
    Result result_of_exact(const Variant& exact) {
        Result result;
        result.name = exact.name;
        result.build = exact_->facts();
        result.renderer = exact_renderer_;
        progress_.begin("drawing " + result.name, options_.frames);
        for (int frame = 0; frame < options_.frames; ++frame) {
            const std::size_t compared = exact_frames_.size();
            const bool is_compared = compared < references_.size() && references_[compared].frame == frame;
            const double expected_ms = result.frame_ms.empty() ? 0 : mean(result.frame_ms) * options_.frames;
            progress_.step();
            if (!is_compared && (exact_is_slow_ || expected_ms > slow_ms)) {
                exact_is_slow_ = true;
                continue;
            }
            FrameStats stats;
            result.frame_ms.push_back(timed(*exact_viewer_, exact_view_of(frame), stats));
            add(stats, result.drawn);
            add(exact_viewer_->work(), result);
            if (!is_compared) continue;
            compare(exact_viewer_->image(), references_[compared], result);
            Image picture = report::over_background(exact_viewer_->image(), setting_.background);
            const double error = mse(picture, references_[compared].over_background, references_[compared].rect);
            exact_frames_.push_back({result.frame_ms.back(), std::move(picture), error});
        }
        result.exact_ms = result.paired_ms = result.frame_ms;
        scale(result);
        if (result.coverage && options_.out_directory)
            draw_work(*exact_, exact_renderer_, exact, {.samples = options_.samples});
        result.plain = time_of_plain_loop();
        return result;
    }

    /// Frames that are compared, at any tolerance; exact at 0.
    class Trials {
      public:
        Trials(Run& run, const Variant& variant, bool asks_wanted)
            : run_(run),
              asked_{0, variant.distance, run.options_.samples, asks_wanted},
              exact_ms_(run.references_.size(), 0) {}

        /// With so many samples each.
        void add(int samples, SceneViewer& exact, SceneViewer& far) { viewers_.push_back({samples, exact, far}); }

        double draw(std::size_t i, float tolerance_px, int samples) {
            asked_.tolerance_px = tolerance_px;
            asked_.samples = samples;
            const Viewers& viewers =
                *std::find_if(viewers_.begin(), viewers_.end(), [&](const Viewers& v) { return v.samples == samples; });
            const int frame = run_.references_[i].frame;
            FrameStats stats;
            last_ = is_exact() ? &viewers.exact : &viewers.far;
            if (!is_exact()) return timed(viewers.far, run_.view_of(frame, asked_), stats);
            if (!is_point_sampling()) return timed(viewers.exact, run_.exact_view_of(frame), stats);
            double ms = run_.exact_frames_[i].ms;
            if (!run_.exact_is_slow_) ms = timed(viewers.exact, run_.exact_view_of(frame), stats);
            exact_ms_[i] = exact_ms_[i] > 0 ? std::min(exact_ms_[i], ms) : ms;
            return ms;
        }
        farfield::SquaredError error(std::size_t i) {
            run_.progress_.step();
            if (is_exact() && is_point_sampling()) return {run_.exact_frames_[i].mse, 1};
            const Reference& reference = run_.references_[i];
            const Image picture = report::over_background(last_->image(), run_.setting_.background);
            return {mse(picture, reference.over_background, reference.rect), 1};
        }
        /// Mean of the least of each frame, at the samples that exact is drawn with.
        double exact_ms() const { return mean(exact_ms_); }

      private:
        struct Viewers {
            int samples;
            SceneViewer &exact, &far;
        };

        bool is_exact() const { return asked_.tolerance_px == 0; }
        bool is_point_sampling() const { return asked_.samples == run_.options_.samples; }

        Run& run_;
        Asked asked_;
        std::vector<Viewers> viewers_;
        SceneViewer* last_ = nullptr;
        std::vector<double> exact_ms_;
    };

    void choose(const BuiltScene& built, SceneViewer& viewer, const Variant& variant, Result& result) {
        // Coarser ones are blocks that an eye tells apart, though a mean of squares forgives them.
        const farfield::ErrorTableOptions ladder{.tolerances_px = farfield::tolerance_ladder(0.5f, 4), .seconds = 0.1};
        double exact_ms = mean_of_exact_frames();
        std::vector<int> samples{options_.samples};
        samples.insert(samples.end(), options_.more_samples.begin(), options_.more_samples.end());
        std::vector<std::unique_ptr<SceneViewer>> more;  // exact, variant, exact, ...: once they are needed
        const auto table = [&](bool asks_wanted) {
            for (std::size_t i = more.size() / 2; i < options_.more_samples.size(); ++i) {
                more.push_back(exact_->viewer(renderer(exact_renderer_, options_.more_samples[i])));
                more.push_back(viewer_of(built, variant, options_.more_samples[i]));
            }
            progress_.begin("choosing the tolerance of " + result.name,
                            int(references_.size() * (ladder.tolerances_px.size() + 1) * samples.size()));
            Trials trials(*this, variant, asks_wanted);
            trials.add(options_.samples, *exact_viewer_, viewer);
            for (std::size_t i = 0; i < options_.more_samples.size(); ++i) {
                trials.add(options_.more_samples[i], *more[2 * i], *more[2 * i + 1]);
            }
            farfield::SampledErrorTable measured =
                farfield::measure_sampled_error_table(trials, samples, references_.size(), ladder);
            exact_ms = std::min(exact_ms, trials.exact_ms());
            return measured;
        };
        result.measured = MeasuredErrors{table(false), table(true)};
        result.measured->exact_ms = exact_ms;
        result.choice = result.measured->choice_for(*options_.error);
    }

    double mean_of_exact_frames() const {
        std::vector<double> ms;
        for (const ExactFrame& frame : exact_frames_) ms.push_back(frame.ms);
        return mean(ms);
    }

    /// None where nothing is compared with it, or for so many samples.
    std::optional<PlainTime> time_of_plain_loop() {
        if (!PlainLoop::draws(options_.samples) || !options_.error || options_.variants.size() < 2) return std::nullopt;
        PlainLoop loop(setting_.scene, options_.samples);
        progress_.begin("drawing all triangles in a plain loop", int(references_.size()));
        PlainTime time{.triangles = loop.triangles(), .drawn_triangles = loop.drawn_triangles()};
        for (std::size_t i = 0; i < references_.size(); ++i) {
            const auto least_of = [](auto&& frame) {
                double least = frame();
                for (double spent = least; spent < 100; spent += least) least = std::min(least, frame());
                return least;
            };
            const int frame = references_[i].frame;
            FrameStats stats;
            time.ms += least_of([&] { return loop.ms(exact_view_of(frame)); });
            time.exact_ms += exact_is_slow_
                                 ? exact_frames_[i].ms
                                 : least_of([&] { return timed(*exact_viewer_, exact_view_of(frame), stats); });
            progress_.step();
        }
        time.ms /= double(references_.size());
        time.exact_ms /= double(references_.size());
        return time;
    }

    /// What frames cost is measured on twelve of the flight, before it begins.
    farfield::FrameBudget budget_of(SceneViewer& viewer, const Variant& variant, const Asked& asked) {
        progress_.begin("measuring what frames of " + std::string(variant.name) + " cost");
        std::vector<View> views;
        const int count = std::min(options_.frames, 12);
        for (int i = 0; i < count; ++i) {
            views.push_back(view_of(int((2 * std::int64_t(i) + 1) * options_.frames / (2 * count)), asked));
        }
        const farfield::FramePriceOptions prices{.longest = 2e6 * *options_.budget_ms};
        return {.prices = farfield::fitted_frame_prices(viewer.measured(views, prices), prices),
                .most = 1e6 * *options_.budget_ms,
                .refines_still_views = true};
    }

    static double timed(SceneViewer& viewer, const View& view, FrameStats& stats,
                        const std::optional<farfield::FrameBudget>& budget = std::nullopt) {
        const auto begin = std::chrono::steady_clock::now();
        stats = budget ? viewer.frame_within(*budget, view) : viewer.frame(view);
        return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count();
    }

    /// Sums, until scale() makes means of them.
    static void add(const FrameStats& stats, Drawn& drawn) {
        drawn.primitives += double(stats.primitives);
        drawn.approximations += double(stats.approximations);
        drawn.images += double(stats.images);
        drawn.cells_visited += double(stats.cells_visited);
        drawn.touched_bytes += double(stats.touched_bytes);
        auto& by_level = drawn.approximations_by_level;
        for (std::size_t level = 0; level < FrameStats::max_levels; ++level) {
            if (stats.approximations_by_level[level] == 0) continue;
            by_level.resize(std::max(by_level.size(), level + 1));
            by_level[level] += double(stats.approximations_by_level[level]);
        }
    }

    /// Null where none is counted.
    static void add(const farfield::CoverageWork* work, Result& result) {
        if (work == nullptr) return;
        if (!result.coverage) result.coverage = CoverageCells{result.build.keeps_strict_order};
        result.coverage->tiling += double(work->cells_tiled);
        result.coverage->asking += double(work->cells_asked);
    }

    void scale(Result& result) const {
        const double weight = 1.0 / double(result.frame_ms.size());
        Drawn& drawn = result.drawn;
        for (double* sum :
             {&drawn.primitives, &drawn.approximations, &drawn.images, &drawn.cells_visited, &drawn.touched_bytes})
            *sum *= weight;
        for (double& sum : drawn.approximations_by_level) sum *= weight;
        if (!result.coverage) return;
        const double weight_a_pixel = weight / options_.width / options_.height;
        result.coverage->tiling *= weight_a_pixel;
        result.coverage->asking *= weight_a_pixel;
    }

    /// "Work images" (Greene 1996, figure 3) of the frames that are compared: by tiling polygons, by asking about
    /// cells, and their sum. Not while time is taken.
    void draw_work(const BuiltScene& built, RendererKind by, const Variant& variant, const Asked& asked) {
        const auto viewer = built.viewer(renderer(by, asked.samples, true));
        progress_.begin("drawing the work on " + std::string(variant.name), int(flight_.quality_frames.size()));
        for (const int frame : flight_.quality_frames) {
            viewer->frame(view_of(frame, asked));
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

    /// Which cells are drawn by stand-ins, and which as geometry, in the frames that are compared: alone, and beside
    /// exact and the variant.
    void draw_cut(SceneViewer& viewer, const Variant& variant, const Asked& asked) {
        progress_.begin("drawing the cut of " + std::string(variant.name), int(flight_.quality_frames.size()));
        for (const ExactFrame& exact : exact_frames_) {
            const int frame = references_[std::size_t(&exact - exact_frames_.data())].frame;
            const View view = view_of(frame, asked);
            const Image cut = report::over_background(viewer.how_drawn(view), setting_.background);
            report::write_png(cut, file(std::string(variant.name), frame, "_how_drawn"));
            viewer.frame(view);
            const Image three[] = {exact.over_background, report::over_background(viewer.image(), setting_.background),
                                   cut};
            report::write_png(report::side_by_side(three, 4), file(std::string(variant.name), frame, "_side_by_side"));
            progress_.step();
        }
    }

    /// Frames that are compared as one sees them from outside, with the images that cells are drawn by. They are what
    /// the frames before leave, so some of those are drawn, too.
    void draw_from_outside(const BuiltScene& built, const Variant& variant, const Asked& asked) {
        constexpr int frames_before = 12;
        RendererChoice choice = renderer(options_.renderer, asked.samples);
        choice.looks_on = true;
        const auto viewer = built.viewer(choice);
        progress_.begin("drawing " + std::string(variant.name) + " from outside", int(flight_.quality_frames.size()));
        for (const int frame : flight_.quality_frames) {
            for (int f = std::max(0, frame - frames_before); f <= frame; ++f) {
                viewer->frame(view_of(f, asked));
            }
            if (const Image* image = viewer->from_outside()) {
                report::write_png(report::over_background(*image, {}),
                                  file(std::string(variant.name), frame, "_from_outside"));
            }
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
    static constexpr double slow_ms = 20'000;  ///< all frames of exact together

    std::unique_ptr<BuiltScene> exact_;
    std::unique_ptr<SceneViewer> exact_viewer_;
    RendererKind exact_renderer_ = RendererKind::z_buffer;
    std::vector<Reference> references_;
    std::vector<ExactFrame> exact_frames_;  ///< one a reference
    bool exact_is_slow_ = false;            ///< then it is drawn once, where it is compared
};

}  // namespace

std::vector<Result> run(const Setting& setting, const Options& options, const Flight& flight) {
    return Run(setting, options, flight).all();
}

}  // namespace walkthrough
