#include <algorithm>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "result.hpp"

namespace walkthrough {
namespace {

using Json = nlohmann::ordered_json;

/// Null where there is no number.
Json finite(double value) {
    return std::isfinite(value) ? Json(value) : Json(nullptr);
}

Json json_of(const std::optional<CoverageCells>& c) {
    if (!c) return nullptr;
    return {{"order", c->is_strict ? "strict" : "lazy"},
            {"cells_a_pixel", {{"tiling", c->tiling}, {"asking", c->asking}}}};
}

/// Costs are in parts of exact's at the fewest samples.
Json json_of(const farfield::SampledErrorTable& table) {
    Json trials = Json::array();
    for (const farfield::ErrorsAtSamples& at : table.tables()) {
        const double exact = at.exact_cost / table.tables().front().exact_cost;
        for (const farfield::ToleranceTrial& t : at.table.trials()) {
            trials.push_back({{"samples", at.samples},
                              {"tolerance_px", t.tolerance_px},
                              {"rmse", t.rmse},
                              {"cost", t.cost * exact}});
        }
    }
    return trials;
}

Json json_of(const std::optional<PlainTime>& plain) {
    if (!plain) return nullptr;
    return {{"ms", plain->ms},
            {"exact_ms", plain->exact_ms},
            {"triangles", plain->triangles},
            {"drawn_triangles", plain->drawn_triangles}};
}

Json json_of(const Result& r, const Options& options) {
    const Errors& e = r.errors;
    return {{"name", r.name},
            {"renderer", name_of(r.renderer)},
            {"tolerance_px", r.choice ? r.choice->tolerance.trial.tolerance_px : options.tolerance_px},
            {"samples", r.choice ? r.choice->samples : options.samples},
            {"asks_wanted", r.choice && r.choice->asks_wanted},
            {"budget_ms", options.budget_ms ? Json(*options.budget_ms) : Json(nullptr)},
            {"error_table", r.measured ? json_of(r.measured->by_tolerance) : Json(nullptr)},
            {"wanted_error_table", r.measured ? json_of(r.measured->wanted) : Json(nullptr)},
            {"plain_loop", json_of(r.plain)},
            {"build_seconds", r.build.seconds},
            {"hierarchy_bytes", r.build.bytes},
            {"cells", r.build.cells},
            {"levels", r.build.levels},
            {"frame_ms",
             {{"first", r.frame_ms.front()},
              {"median", median(r.frame_ms)},
              {"mean", mean(r.frame_ms)},
              {"max", *std::max_element(r.frame_ms.begin(), r.frame_ms.end())}}},
            {"exact_ms", {{"median", median(r.exact_ms)}, {"mean", mean(r.exact_ms)}}},
            {"speedup", finite(speedup(r))},
            {"error",
             {{"rmse", finite(e.rmse())},
              {"psnr", finite(e.psnr())},
              {"ssim", finite(e.ssim())},
              {"flip", finite(e.flip())},
              {"coverage_bias", finite(e.coverage_bias())},
              {"coverage_rms", finite(e.coverage_rms())},
              {"flicker", e.flicker_rms() ? finite(*e.flicker_rms()) : Json(nullptr)}}},
            {"drawn",
             {{"primitives", r.drawn.primitives},
              {"approximations", r.drawn.approximations},
              {"images", r.drawn.images},
              {"by_level", r.drawn.approximations_by_level}}},
            {"cells_visited", r.drawn.cells_visited},
            {"working_set_bytes", r.drawn.touched_bytes},
            {"coverage", json_of(r.coverage)}};
}

}  // namespace

void write_json(const std::filesystem::path& file, const Setting& setting, const Options& options,
                const std::vector<Result>& results) {
    std::uint64_t primitives = 0;
    for (const auto& group : setting.scene.groups) primitives += group.triangles.size() + group.placements.size();
    Json json{{"scene",
               {{"name", setting.name},
                {"primitives", primitives},
                {"triangles", farfield::scenes::triangle_count(setting.scene)},
                {"bytes", farfield::scenes::bytes(setting.scene)}}},
              {"image",
               {{"width", options.width},
                {"height", options.height},
                {"frames", options.frames},
                {"threads", options.threads}}},
              {"variants", Json::array()}};
    for (const Result& r : results) json["variants"].push_back(json_of(r, options));
    std::ofstream out(file);
    out << json.dump(2) << "\n";
    out.close();
    if (!out) throw std::runtime_error("could not write " + file.string());
}

}  // namespace walkthrough
