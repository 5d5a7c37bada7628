#include "stage.hpp"

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <utility>

#include "paged_scene.hpp"
#include "scenes/scene.hpp"
#include "walkthrough/flight.hpp"
#include "walkthrough/options.hpp"
#include "walkthrough/setting.hpp"
#include "walkthrough/variants.hpp"

namespace viewer {
namespace {

using farfield::scenes::BuiltScene;
using farfield::scenes::RendererKind;
using farfield::scenes::SceneProgress;

std::string with_commas(std::uint64_t number) {
    std::string digits = std::to_string(number);
    for (std::size_t i = digits.size(); i > 3; i -= 3) digits.insert(i - 3, ",");
    return digits;
}

std::shared_ptr<const Stage> open_pages(const std::string& where, std::size_t cache_mib) {
    const PagedScene pages = open_paged_scene(where, cache_mib << 20);
    auto stage = std::make_shared<Stage>();
    stage->name = where.substr(where.find_last_of('/') + 1);
    stage->where = where;
    stage->what = with_commas(pages.primitives) + " triangles, " + std::to_string(pages.file_bytes >> 20) + " MiB in " +
                  std::to_string(pages.pages) + " pages";
    stage->bounds = pages.bounds;
    stage->is_paged = true;
    const auto only_some = [](RendererKind kind) {
        return std::string(draws_pages(kind) ? "" : "does not draw from pages here");
    };
    const auto same = [built = pages.built](const SceneProgress&) { return built; };
    stage->variants = {{"exact", "as fine as pages in memory allow", {}, same, only_some},
                       {pages.variant, "what the file was built with", {}, same, only_some}};
    return stage;
}

}  // namespace

std::shared_ptr<const Stage> open_stage(const std::string& where, std::size_t cache_mib) {
    if (is_paged_scene(where)) return open_pages(where, cache_mib);
    // Variants build from the scene when they are first chosen, so each keeps it.
    const auto setting = std::make_shared<const walkthrough::Setting>(walkthrough::make_setting(where));
    auto stage = std::make_shared<Stage>();
    stage->name = setting->name;
    stage->where = where;
    stage->what = with_commas(farfield::scenes::triangle_count(setting->scene)) + " triangles";
    stage->notes = setting->scene.notes;
    stage->bounds = {glm::dvec3(setting->bounds.lower), glm::dvec3(setting->bounds.upper)};
    stage->up = glm::dvec3(setting->scene.up);
    stage->background = setting->background;
    stage->culls_back_faces = setting->culls_back_faces;
    stage->flight = [setting] {
        walkthrough::Options options;
        options.frames = 96;
        farfield::scenes::CameraPath path;
        for (const farfield::Camera& camera : walkthrough::plan_flight(*setting, options).cameras) {
            path.stops.push_back({0.25 * double(path.stops.size()), camera});
        }
        return path;
    };
    // All of a landscape is a line on the horizon: it is looked at from where a flight has come near.
    const glm::dvec3 size = stage->bounds.size(), up = glm::abs(stage->up);
    if (glm::dot(size, glm::dvec3(1) - up) > 4 * glm::dot(size, up)) stage->start = stage->flight().at(0.5);
    for (const walkthrough::Variant& v : walkthrough::variants()) {
        stage->variants.push_back(
            {std::string(v.name), std::string(v.description), v.distance,
             [setting, &v](const SceneProgress& progress) -> BuiltPtr { return v.build(setting->scene, progress); },
             [&v](RendererKind kind) { return std::string(v.obstacle(kind)); }});
    }
    return stage;
}

}  // namespace viewer
