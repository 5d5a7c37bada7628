#include "pages.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iomanip>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <ostream>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#if FARFIELD_HAS_HTTP
#include "farfield/adapters/http_page_source.hpp"
#endif
#if FARFIELD_HAS_ZSTD
#include "farfield/adapters/zstd_pages.hpp"
#include "farfield/paging/unpacked_pages.hpp"
#endif
#include "farfield/measure/image_error.hpp"
#include "farfield/paging/file_page_source.hpp"
#include "farfield/paging/open_pages.hpp"
#include "farfield/renderer/z_buffer_renderer.hpp"
#include "farfield/tuning/kept_error_table.hpp"
#include "farfield/tuning/measure_error_table.hpp"
#include "farfield/tuning/sampled_error_table.hpp"
#include "farfield/viewer.hpp"
#include "report/picture.hpp"
#include "report/progress.hpp"
#include "result.hpp"
#include "scenes/paged_variants.hpp"

namespace walkthrough {
namespace {

namespace report = farfield::report;
using farfield::FrameStats;
using farfield::Image;
using farfield::View;
using farfield::scenes::PagedPrimitive;
using Clock = std::chrono::steady_clock;

bool is_address(const std::string& scene) {
    return scene.rfind("http://", 0) == 0 || scene.rfind("https://", 0) == 0;
}
double ms_since(Clock::time_point begin) {
    return std::chrono::duration<double, std::milli>(Clock::now() - begin).count();
}

/// Down a spiral, looking ahead and to the middle.
std::vector<farfield::Camera> descent_into(const farfield::Box& bounds, const Options& options) {
    const glm::dvec3 center(bounds.center());
    const double radius = std::max(0.5 * double(bounds.largest_side()), 1e-30);
    std::vector<farfield::Camera> cameras;
    for (int i = 0; i < options.frames; ++i) {
        const double part = options.frames < 2 ? 0 : double(i) / (options.frames - 1);
        const double distance = options.distance ? *options.distance : 2.5 * std::pow(0.12, part);
        const double turn = options.angle_degrees * 3.14159265358979 / 180 + (options.distance ? 0.0 : 1.2 * part);
        const double up = options.distance ? 0.3 : 0.9 * std::pow(0.06, part);
        const glm::dvec3 eye = center + radius * glm::dvec3(distance * std::sin(turn), up, distance * std::cos(turn));
        cameras.push_back(farfield::Camera::perspective(eye, center, {0, 1, 0}, 0.9f));
    }
    return cameras;
}

struct PagedResult {
    std::string variant, where;
    std::uint64_t primitives = 0, file_bytes = 0, pages = 0;
    double open_ms = 0, first_ms = 0;
    std::optional<double>
        whole_ms{};  ///< none: the cache is smaller than what the first frame wants, or reads are slow
    std::vector<double> frame_ms, loads, missing;
    double drawn_primitives = 0, stand_ins = 0;
    std::optional<farfield::SampleChoice> choice{};  ///< none: nothing chose
    bool was_measured = false;                       ///< in this run
    std::vector<double> rmse;
    farfield::PageCacheStats cache;
};

class PagedRun {
  public:
    explicit PagedRun(const Options& options) : options_(options) {}

    template <class Source>
    PagedResult walk(const std::shared_ptr<Source>& source, const std::string& where) {
#if FARFIELD_HAS_ZSTD
        if (farfield::holds_pages_packed_by<farfield::ZstdPages>(*source)) {
            using Unpacked = farfield::UnpackedPages<Source, farfield::ZstdPages>;
            return walk_unpacked(std::make_shared<Unpacked>(source, where), where);
        }
#endif
        return walk_unpacked(source, where);
    }

  private:
    template <class Source>
    PagedResult walk_unpacked(const std::shared_ptr<Source>& source, const std::string& where) {
        PagedResult result;
        const bool is_known = farfield::scenes::any_paged_variant([&](auto type, std::string_view name) {
            using H = typename decltype(type)::type;
            if (!farfield::holds_pages_of<H, PagedPrimitive>(*source)) return false;
            result.variant = name;
            result.where = where;
            walk_as<H>(source, result);
            return true;
        });
        if (!is_known) throw UsageError(where + " is no file of pages that farfield_build makes");
        return result;
    }
    template <class H, class Source>
    void walk_as(const std::shared_ptr<Source>& source, PagedResult& result) {
        auto begin = Clock::now();
        const auto pages =
            farfield::open_pages_of<H, PagedPrimitive>(source, result.where, {.most_bytes = options_.cache_mib << 20});
        result.open_ms = ms_since(begin);
        result.primitives = pages.primitive_count();
        result.file_bytes = pages.bytes();
        result.pages = pages.page_count();
        const std::vector<farfield::Camera> cameras = descent_into(pages.bounds(), options_);
        const auto before = Clock::now();
        choose(pages, cameras, result);
        begin += Clock::now() - before;  // it is no part of a first image
        const int samples = result.choice ? result.choice->samples : options_.samples;
        farfield::ZBufferRenderer renderer({.samples = samples});
        auto viewer = farfield::make_viewer(pages, renderer);
        const auto view = [&](const farfield::Camera& camera) {
            const View v = view_of(camera);
            return result.choice ? result.choice->applied_to(v) : v;
        };
        viewer.frame(view(cameras[0]));
        result.first_ms = ms_since(begin);
        constexpr double patience_ms = 10'000;
        bool is_whole = false;
        while (!is_whole && ms_since(begin) < patience_ms) is_whole = viewer.frame(view(cameras[0])).cells_missing == 0;
        if (is_whole) result.whole_ms = ms_since(begin);
        // What a frame errs by is seen by another viewer, which waits: with a cache of its own, or it would help.
        auto waiting =
            farfield::open_pages_of<H, PagedPrimitive>(source, result.where, {.most_bytes = options_.cache_mib << 20});
        waiting.wait_for_pages(true);
        farfield::ZBufferRenderer reference_renderer({.samples = samples});
        auto reference = farfield::make_viewer(waiting, reference_renderer);
        progress_.begin("walking through pages", options_.frames);
        std::uint64_t loads = pages.cache_stats().loads;
        for (int i = 0; i < options_.frames; ++i) {
            const View v = view(cameras[std::size_t(i)]);
            const auto frame_begin = Clock::now();
            const FrameStats stats = viewer.frame(v);
            result.frame_ms.push_back(ms_since(frame_begin));
            result.missing.push_back(double(stats.cells_missing));
            result.drawn_primitives += double(stats.primitives) / options_.frames;
            result.stand_ins += double(stats.approximations) / options_.frames;
            const std::uint64_t now = pages.cache_stats().loads;
            result.loads.push_back(double(now - loads));
            loads = now;
            const int step = std::max(options_.frames / 8, 1);
            if (i % step == step - 1) {
                const Image seen = over_background(renderer.image());
                reference.frame(v);
                const Image whole = over_background(reference_renderer.image());
                result.rmse.push_back(std::sqrt(farfield::mse(seen, whole)));
                if (options_.out_directory) report::write_png(seen, picture(result.variant, i));
            }
            progress_.step();
        }
        result.cache = pages.cache_stats();
    }

    static bool is_measured_at(const farfield::SampledErrorTable& table, int samples) {
        const auto tables = table.tables();
        return std::any_of(tables.begin(), tables.end(), [&](const auto& at) { return at.samples == samples; });
    }
    /// By the table in the file, which is measured first if that is asked for.
    template <class Pages>
    void choose(const Pages& pages, const std::vector<farfield::Camera>& cameras, PagedResult& result) {
        if (!options_.error) return;
        const farfield::MeasuredWith with{"z-buffer", options_.width, options_.height};
        if (options_.measures_errors) measure(pages, with, cameras, result);
        std::optional<farfield::SampledErrorTable> table;
        try {
            table = result.was_measured ? farfield::kept_error_table(with, pages, std::filesystem::path(result.where))
                                        : farfield::kept_error_table(with, pages);
        } catch (const std::runtime_error&) {
            // What nobody asked for keeps no scene from being shown.
            if (options_.error_is_asked || options_.measures_errors || !options_.more_samples.empty()) throw;
        }
        const bool has_samples = table && (!options_.more_samples.empty() || is_measured_at(*table, options_.samples));
        if (!has_samples) {
            if (!options_.error_is_asked && options_.more_samples.empty()) return;
            throw UsageError(result.where + " has no table of errors of " + with.as_text() +
                             " at these samples, which --error could choose by: --measure puts one into it");
        }
        farfield::WantedError wanted = *options_.error;
        wanted.samples = options_.samples;
        if (options_.more_samples.empty()) {
            table = farfield::SampledErrorTable(table->at(options_.samples), options_.samples);
        }
        result.choice = table->cheapest_for(wanted);
    }
    template <class Pages>
    void measure(const Pages& pages, const farfield::MeasuredWith& with, const std::vector<farfield::Camera>& cameras,
                 PagedResult& result) {
        if (is_address(result.where)) throw UsageError("--measure puts a table into a file, not to an address");
        const std::size_t count = std::min<std::size_t>(cameras.size(), 8);
        std::vector<View> views;
        for (std::size_t i = 0; i < count; ++i) {
            views.push_back(view_of(cameras[(2 * i + 1) * cameras.size() / (2 * count)]));
        }
        farfield::HierarchyErrorOptions how;
        how.tolerances_px = farfield::tolerance_ladder(0.5f, 4);  // coarser ones are blocks that an eye tells apart
        how.seconds = 0.1;
        std::vector<int> samples{1, 4, 16};
        if (std::find(samples.begin(), samples.end(), options_.samples) == samples.end()) {
            samples.push_back(options_.samples);
            std::sort(samples.begin(), samples.end());
        }
        progress_.begin("measuring what tolerances and samples err by and cost");
        const auto renderer_of = [](int n) { return farfield::ZBufferRenderer({.samples = n}); };
        const farfield::SampledErrorTable table =
            farfield::measure_sampled_error_table(pages, pages.primitives(), samples, renderer_of, views, how);
        farfield::keep_error_table(table, with, pages, std::filesystem::path(result.where));
        result.was_measured = true;
    }

    View view_of(const farfield::Camera& camera) const {
        return {.camera = camera,
                .width = options_.width,
                .height = options_.height,
                .tolerance_px = options_.error ? 1.0f : options_.tolerance_px};
    }
    static Image over_background(const Image& image) {
        return report::over_background(image, report::Background{});
    }
    std::filesystem::path picture(const std::string& variant, int frame) const {
        std::string number = std::to_string(frame);
        if (number.size() < 3) number.insert(0, 3 - number.size(), '0');
        return *options_.out_directory / ("pages_" + variant + "_frame" + number + ".png");
    }

    const Options& options_;
    report::Progress progress_;
};

double most(const std::vector<double>& values) {
    return values.empty() ? 0 : *std::max_element(values.begin(), values.end());
}

void print(std::ostream& out, const PagedResult& r) {
    const auto line = [&](const char* what, double middle, double worst, const char* unit) {
        out << "  " << std::left << std::setw(34) << what << std::right << std::setw(10) << middle << std::setw(10)
            << worst << "  " << unit << "\n";
    };
    out << r.where << ": " << r.variant << ", " << r.primitives << " triangles, " << r.file_bytes / 1048576
        << " MiB in " << r.pages << " pages\n"
        << std::fixed << std::setprecision(1) << "first image after " << r.first_ms << " ms (opened in " << r.open_ms
        << "), "
        << (r.whole_ms ? "nothing missing after " + std::to_string(long(*r.whole_ms)) + " ms\n"
                       : std::string("and not whole within 10 s: give it more --cache, or time\n"));
    if (r.choice) {
        out << "by the table in the file, measured " << (r.was_measured ? "now: " : "before: ")
            << words(Choice{*r.choice, false}, true) << std::setprecision(4) << ", RMSE "
            << r.choice->tolerance.trial.rmse << " over objects, " << std::setprecision(2) << r.choice->cost
            << " times what exact costs at the fewest samples\n"
            << std::setprecision(1);
    }
    out << std::left << std::setw(36) << "" << std::right << std::setw(10) << "median" << std::setw(10) << "most"
        << "\n";
    line("frame", median(r.frame_ms), most(r.frame_ms), "ms");
    line("pages loaded a frame", median(r.loads), most(r.loads), "");
    line("cells drawn coarser for a page", median(r.missing), most(r.missing), "");
    out << std::setprecision(4);
    line("RMSE, against frames that wait", median(r.rmse), most(r.rmse), "");
    out << std::setprecision(1) << "drawn a frame: " << r.drawn_primitives << " triangles, " << r.stand_ins
        << " stand-ins; cache: " << double(r.cache.bytes) / 1048576 << " MiB, " << r.cache.resident << " pages in it, "
        << r.cache.evictions << " gone again\n";
    if (r.cache.failures != 0) out << r.cache.failures << " reads failed, the last: " << r.cache.last_failure << "\n";
}

void write_json(const std::filesystem::path& file, const PagedResult& r) {
    using Json = nlohmann::json;
    const Json json{
        {"scene",
         {{"name", r.where}, {"primitives", r.primitives}, {"triangles", r.primitives}, {"bytes", r.file_bytes}}},
        {"variants",
         {{{"name", r.variant},
           {"tolerance_px", r.choice ? Json(r.choice->tolerance.trial.tolerance_px) : Json(nullptr)},
           {"samples", r.choice ? Json(r.choice->samples) : Json(nullptr)},
           {"expected_rmse", r.choice ? Json(r.choice->tolerance.trial.rmse) : Json(nullptr)},
           {"frame_ms",
            {{"first", r.first_ms},
             {"median", median(r.frame_ms)},
             {"mean", mean(r.frame_ms)},
             {"max", most(r.frame_ms)}}},
           {"pages_loaded", {{"median", median(r.loads)}, {"max", most(r.loads)}}},
           {"cells_missing", {{"median", median(r.missing)}, {"max", most(r.missing)}}},
           {"error", {{"rmse_against_waiting", mean(r.rmse)}}},
           {"drawn", {{"primitives", r.drawn_primitives}, {"approximations", r.stand_ins}}},
           {"cache_bytes", r.cache.bytes}}}}};
    std::ofstream out(file);
    out << json.dump(2) << "\n";
    if (!out.flush()) throw std::runtime_error("cannot write " + file.string());
}

}  // namespace

bool is_paged(const std::string& scene) {
    constexpr std::string_view end = ".farfield";
    return is_address(scene) ||
           (scene.size() > end.size() && scene.compare(scene.size() - end.size(), end.size(), end) == 0);
}

void walk_pages(std::ostream& out, const Options& options) {
    PagedResult result;
    try {
        PagedRun run(options);
        if (is_address(options.scene)) {
#if FARFIELD_HAS_HTTP
            result = run.walk(std::make_shared<farfield::HttpPageSource>(options.scene), options.scene);
#else
            throw UsageError(
                "this walkthrough was built without libcurl: give it a file, or install libcurl4-openssl-dev "
                "and build again");
#endif
        } else {
            result = run.walk(std::make_shared<farfield::FilePageSource>(options.scene), options.scene);
        }
    } catch (const UsageError&) {
        throw;
    } catch (const std::bad_alloc&) {
        throw;
    } catch (const std::exception& error) {
        throw UsageError("cannot draw '" + options.scene + "': " + error.what());
    }
    print(out, result);
    if (options.json_file) write_json(*options.json_file, result);
}

}  // namespace walkthrough
