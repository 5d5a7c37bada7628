// The failure gallery: how badly each variant fails what such methods are known to fail. A row is a failure, a scene of
// the gallery, its severity and a variant. Pictures have 16 samples a pixel, for the failures are the far field's and
// not sampling's, and references 64: `exact` is the noise that is left. Cells of 4 pixels from near show what cells of
// one do from four times as far. Time is that of the row with its hierarchy, references not counted, and not the point.
//
//   tearing    torn: part of the pixels inside the silhouette, by a pixel at least, of which less than half is covered;
//              leak: mean part of them that is not. At tolerances of 1 and 4 pixels
//   inflation  signed coverage bias at 1 to 64 times the distance, tolerance 1 pixel; -1: all is gone
//   tone       mean luminance of what is covered, less the reference's, in [-1, 1], over directions: its mean, and the
//              largest less the smallest. covered: part of the reference's coverage, smallest and largest
//   loss       what is covered, less the reference's, as a part of it: median and worst of five directions, at
//              tolerances of 1, 4 and 8 pixels
//   seams      flicker and largest pop (root mean square over the unit ball's rectangle) on a dolly from 2 to 32 radii
//   trembling  likewise where the eye trembles by 1e-3 of its distance; flips: part of the covered pixels, a frame, of
//              which a channel changes by more than a tenth beyond what the reference's does
//   occlusion  behind two occluders with a gap of some samples, by coverage masks: gap_seen: brightness of what the gap
//              shows, as a part of the reference's; drawn: part of the primitives that were not culled; cells of the
//              coverage pyramid visited a pixel
//
// Rows that end in +masks are drawn with coverage masks, 64 samples a pixel, the far field's opacity being a part of
// the samples; with +masks,law it is deposited by the area law.
#include "scenes/generate/gallery.hpp"

#include <benchmark/benchmark.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <glm/geometric.hpp>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

#include "farfield/build.hpp"
#include "farfield/measure/flicker.hpp"
#include "farfield/measure/projected_rect.hpp"
#include "farfield/renderer/coverage_renderer.hpp"
#include "farfield/renderer/z_buffer_renderer.hpp"
#include "farfield/viewer.hpp"
#include "scenes/generate/occluders.hpp"
#include "scenes/generate/random.hpp"
#include "scenes/renderers/any_renderer.hpp"
#include "support/coverage.hpp"
#include "support/variants.hpp"

namespace farfield::bench {
namespace {

constexpr std::uint32_t triangles = 20'000;
constexpr float coarse_px = 4;

/// Draws one scene in one variant, or as a reference.
class Drawn {
  public:
    virtual ~Drawn() = default;
    virtual const Image& picture(View view) = 0;
};

template <class V, class Like = ZBufferRenderer>
class DrawnBy final : public Drawn {
    using H = typename V::hierarchy_type;
    using Renderer = scenes::RendererLike<Like>;
    const V& variant_;
    H hierarchy_;
    Renderer renderer_;
    Viewer<H, Triangle, Renderer> viewer_;
    FrameStats stats_;

  public:
    DrawnBy(const V& variant, std::span<const Triangle> scene, const scenes::RendererChoice& choice)
        : variant_(variant),
          hierarchy_(build<H>(scene, {.partition = partition_for(variant, scene.size()),
                                      .approximation = variant.approximation,
                                      .cost_model = variant.cost_model})),
          renderer_(scenes::make_renderer(choice, false)),
          viewer_(hierarchy_, scene, renderer_) {}
    const Image& picture(View view) override {
        view.distance = distance_measure(variant_);
        stats_ = viewer_.frame(view);
        return renderer_.any().image();
    }
    const FrameStats& stats() const { return stats_; }
    const CoverageWork* work() const { return renderer_.any().work(); }
};

constexpr scenes::RendererChoice z_buffer_at(int samples) {
    return {.samples = samples};
}
constexpr scenes::RendererChoice masks{.kind = scenes::RendererKind::coverage, .samples = 64};
constexpr scenes::RendererChoice far_field_by_area_law{
    .kind = scenes::RendererKind::coverage, .samples = 64, .far_field_by_area_law = true};

View view_from(glm::dvec3 eye, int size, float tolerance) {
    const glm::vec3 up = std::abs(glm::normalize(eye).y) > 0.99 ? glm::vec3(0, 0, 1) : glm::vec3(0, 1, 0);
    return {.camera = Camera::perspective(eye, {}, up, 0.9f), .width = size, .height = size, .tolerance_px = tolerance};
}

/// One scene with its views and references, which its rows share.
struct Subject {
    scenes::GalleryScene scene;
    std::vector<View> views{};
    std::vector<Image> references{};
};
using Measure = void (*)(benchmark::State&, const Subject&, Drawn&);
using Path = std::vector<View> (*)(const scenes::GalleryScene&);

// ---- tearing

std::vector<View> views_of_tearing(const scenes::GalleryScene& scene) {
    return {view_from(glm::dvec3(scene.towards_viewer) * 12.0, 256, 0)};
}

void tearing(benchmark::State& state, const Subject& subject, Drawn& drawn) {
    const Image& reference = subject.references[0];
    for (const auto& [tolerance, name] : {std::pair{1.0f, "1px"}, std::pair{coarse_px, "4px"}}) {
        View view = subject.views[0];
        view.tolerance_px = tolerance;
        const Tearing t = tearing_of(drawn.picture(view), reference);
        state.counters[std::string("torn_") + name] = t.torn / t.inside;
        state.counters[std::string("leak_") + name] = t.leak;
    }
}

// ---- inflation

std::vector<View> views_of_inflation(const scenes::GalleryScene& scene) {
    std::vector<View> views;
    for (int times = 1; times <= 64; times *= 2) {
        views.push_back(view_from(glm::dvec3(scene.towards_viewer) * (4.0 * times), 256, 1));
    }
    return views;
}

/// The same camera with a field of view that the scene fills, so that twigs far away still meet samples.
View narrowed(View view) {
    const float filled = 1.5f / float(glm::length(view.camera.eye));
    view.camera.half_height = std::min(view.camera.half_height, filled);
    return view;
}

void inflation(benchmark::State& state, const Subject& subject, Drawn& drawn) {
    for (std::size_t i = 0; i < subject.views.size(); ++i) {
        const double narrowing =
            double(narrowed(subject.views[i]).camera.half_height) / double(subject.views[i].camera.half_height);
        const double expected = coverage(subject.references[i]) * narrowing * narrowing;
        const double bias = coverage(drawn.picture(subject.views[i])) / expected - 1;
        // Counters are listed by name.
        const std::string times = std::to_string(1 << i);
        state.counters["bias_" + std::string(2 - times.size(), '0') + times + "x"] = bias;
    }
}

// ---- tone

/// About the axis that is level and square to the light, or to the slats' tilt: from all sides.
std::vector<View> views_of_tone(const scenes::GalleryScene& scene) {
    std::vector<View> views;
    const bool is_blind = scene.name == "slats";
    for (int i = 0; i < 16; ++i) {
        // Off the axes, where faces are seen squarely.
        const double angle = (is_blind ? i - 7.5 : 2 * i + 0.5) * 3.14159265358979 / 16;
        const glm::dvec3 direction = is_blind ? glm::dvec3(0, std::sin(angle), std::cos(angle))
                                              : glm::dvec3(std::cos(angle), 0, std::sin(angle));
        views.push_back(view_from(direction * 12.0, 256, coarse_px));
    }
    return views;
}

/// Rec. 709, of colors as stored, over coverage; 0 where nothing is covered.
double mean_luminance(const Image& image) {
    double sum = 0;
    for (const Rgba8 c : image.pixels()) sum += 0.2126 * c.r + 0.7152 * c.g + 0.0722 * c.b;
    const double covered = coverage(image);
    return covered > 0 ? sum / covered / 255 : 0;
}

void tone(benchmark::State& state, const Subject& subject, Drawn& drawn) {
    std::vector<double> off, covered;
    for (std::size_t i = 0; i < subject.views.size(); ++i) {
        const Image& image = drawn.picture(subject.views[i]);
        off.push_back(mean_luminance(image) - mean_luminance(subject.references[i]));
        covered.push_back(coverage(image) / coverage(subject.references[i]));
    }
    const auto [darkest, brightest] = std::minmax_element(off.begin(), off.end());
    const auto [least, most] = std::minmax_element(covered.begin(), covered.end());
    double sum = 0;
    for (const double d : off) sum += d;
    state.counters["tone_mean"] = sum / double(off.size());
    state.counters["tone_spread"] = *brightest - *darkest;
    state.counters["covered_least"] = *least;
    state.counters["covered_most"] = *most;
}

// ---- loss

std::vector<View> views_of_loss(const scenes::GalleryScene& scene) {
    std::vector<View> views;
    for (const glm::dvec3 towards : {glm::dvec3(scene.towards_viewer), glm::dvec3(0, 0.02, 1), glm::dvec3(0.1, 0.15, 1),
                                     glm::dvec3(0.6, 0.5, 0.7), glm::dvec3(0.02, 1, 0)}) {
        views.push_back(view_from(glm::normalize(towards) * 8.0, 256, 0));
    }
    return views;
}

void loss(benchmark::State& state, const Subject& subject, Drawn& drawn) {
    for (const auto& [tolerance, name] :
         {std::pair{1.0f, "1px"}, std::pair{coarse_px, "4px"}, std::pair{8.0f, "8px"}}) {
        std::vector<double> off;
        for (std::size_t i = 0; i < subject.views.size(); ++i) {
            View view = subject.views[i];
            view.tolerance_px = tolerance;
            off.push_back(coverage(drawn.picture(view)) / coverage(subject.references[i]) - 1);
        }
        std::sort(off.begin(), off.end(), [](double a, double b) { return std::abs(a) < std::abs(b); });
        state.counters[std::string("loss_median_") + name] = off[off.size() / 2];
        state.counters[std::string("loss_worst_") + name] = off.back();
    }
}

// ---- seams and trembling

std::vector<View> views_of_dolly(const scenes::GalleryScene& scene) {
    std::vector<View> views;
    for (int i = 0; i <= 80; ++i) {
        views.push_back(view_from(glm::dvec3(scene.towards_viewer) * (2 * std::pow(16.0, i / 80.0)), 128, coarse_px));
    }
    return views;
}

std::vector<View> views_of_trembling(const scenes::GalleryScene& scene) {
    std::vector<View> views;
    scenes::Random random(5);
    const View still = view_from(glm::dvec3(scene.towards_viewer) * 12.0, 256, coarse_px);
    for (int i = 0; i <= 24; ++i) {
        views.push_back(still);
        views.back().camera.eye += glm::dvec3(random.direction()) * (1e-3 * 12.0);
    }
    return views;
}

Flicker flicker_of(const Subject& subject, Drawn& drawn, const std::function<void(std::size_t, const Image&)>& also) {
    Flicker flicker;
    for (std::size_t i = 0; i < subject.views.size(); ++i) {
        const Image& image = drawn.picture(subject.views[i]);
        flicker.add(image, subject.references[i], projected_rect(Box{glm::vec3(-1), glm::vec3(1)}, subject.views[i]));
        also(i, image);
    }
    return flicker;
}

void seams(benchmark::State& state, const Subject& subject, Drawn& drawn) {
    const Flicker flicker = flicker_of(subject, drawn, [](std::size_t, const Image&) {});
    state.counters["flicker"] = flicker.rms();
    state.counters["largest_pop"] = flicker.largest_pop_rms();
}

void trembling(benchmark::State& state, const Subject& subject, Drawn& drawn) {
    Image last;
    double flips = 0, covered = 0;
    const Flicker flicker = flicker_of(subject, drawn, [&](std::size_t i, const Image& image) {
        if (i != 0) {
            const std::span<const Rgba8> now = image.pixels(), before = last.pixels(),
                                         exact_now = subject.references[i].pixels(),
                                         exact_before = subject.references[i - 1].pixels();
            for (std::size_t p = 0; p < now.size(); ++p) {
                const auto beyond = [&](auto channel) {
                    return std::abs((now[p].*channel - before[p].*channel) -
                                    (exact_now[p].*channel - exact_before[p].*channel));
                };
                flips += std::max({beyond(&Rgba8::r), beyond(&Rgba8::g), beyond(&Rgba8::b)}) > 25;
            }
            covered += coverage(subject.references[i]);
        }
        last = image;
    });
    state.counters["flips"] = flips / covered;
    state.counters["flicker"] = flicker.rms();
    state.counters["largest_pop"] = flicker.largest_pop_rms();
}

// ---- rows

View unchanged(View view) {
    return view;
}

struct Failure {
    const char* name;
    Path views;
    Measure measure;
    View (*reference_view)(View);
    std::vector<std::pair<const char*, std::vector<float>>> scenes;
};

const std::vector<Failure>& failures() {
    static const std::vector<Failure> all{
        {"tearing",
         views_of_tearing,
         tearing,
         unchanged,
         {{"wall", {0, 0.5f, 1}}, {"bust", {0, 0.5f, 1}}, {"sheets", {1}}}},
        {"inflation", views_of_inflation, inflation, narrowed, {{"twigs", {0, 0.5f, 1}}, {"bust", {0.5f}}}},
        {"tone", views_of_tone, tone, unchanged, {{"slats", {0, 0.25f, 0.5f, 0.75f, 1}}, {"leaves", {0, 0.5f, 1}}}},
        {"loss",
         views_of_loss,
         loss,
         unchanged,
         {{"meadow", {0, 0.5f, 1}}, {"clouds", {0.25f, 0.75f, 1}}, {"leaves", {0}}}},
        {"seams",
         views_of_dolly,
         seams,
         unchanged,
         {{"bust", {0.5f}}, {"leaves", {1}}, {"sheets", {1}}, {"ground", {0, 1}}}},
        {"trembling",
         views_of_trembling,
         trembling,
         unchanged,
         {{"bust", {0.5f}}, {"leaves", {1}}, {"sheets", {0, 0.5f, 1}}, {"ground", {0.5f}}}},
    };
    return all;
}

template <class Variants>
const Subject& subject_of(const Failure& failure, const std::string& scene, float severity, const Variants& variants) {
    static std::map<std::string, Subject> subjects;
    const std::string key = std::string(failure.name) + "/" + scene + "/" + std::to_string(severity);
    const auto found = subjects.find(key);
    if (found != subjects.end()) return found->second;
    subjects.clear();  // rows come by subjects
    Subject& s = subjects[key] = {scenes::make_gallery(scene, severity, triangles)};
    s.views = failure.views(s.scene);
    using Exactly = std::remove_cvref_t<std::tuple_element_t<0, Variants>>;
    DrawnBy<Exactly> finely(std::get<0>(variants), s.scene.triangles, z_buffer_at(64));
    for (const View& seen : s.views) {
        View view = failure.reference_view(seen);
        view.tolerance_px = 0;
        s.references.push_back(finely.picture(view));
    }
    return s;
}

template <class Like, class V, class Variants>
void register_row(const Failure& failure, const std::string& scene, float severity, const V& variant,
                  const scenes::RendererChoice& choice, const char* suffix, const Variants& all) {
    std::string label = std::to_string(severity);
    label.resize(4);
    const std::string name = std::string(failure.name) + "/" + scene + "/" + label + "/" + variant.name + suffix;
    benchmark::RegisterBenchmark(name.c_str(),
                                 [&failure, scene, severity, &variant, choice, &all](benchmark::State& state) {
                                     const Subject& subject = subject_of(failure, scene, severity, all);
                                     for (auto _ : state) {
                                         const std::span<const Triangle> triangles_of_scene(subject.scene.triangles);
                                         DrawnBy<V, Like> drawn(variant, triangles_of_scene, choice);
                                         failure.measure(state, subject, drawn);
                                     }
                                 })
        ->Iterations(1)
        ->Unit(benchmark::kMillisecond);
}

/// Also drawn with coverage masks.
template <class V>
constexpr bool masks_draw = DrawableWith<typename V::hierarchy_type, Triangle, CoverageRenderer>;

[[maybe_unused]] const bool rows_are_registered = [] {
    static const auto all = variants();
    for (const Failure& failure : failures()) {
        for (const auto& rows : failure.scenes) {
            const std::string scene = rows.first;  // clang 14 captures no structured bindings
            for (const float severity : rows.second) {
                for_each_variant(all, [&]<class V>(const V& variant) {
                    register_row<ZBufferRenderer>(failure, scene, severity, variant, z_buffer_at(16), "", all);
                    if constexpr (masks_draw<V>) {
                        if (!is_drawn_with_masks(variant)) return;
                        register_row<CoverageRenderer>(failure, scene, severity, variant, masks, "+masks", all);
                        if constexpr (V::hierarchy_type::approximation_type::facts.stands_in) {
                            register_row<CoverageRenderer>(failure, scene, severity, variant, far_field_by_area_law,
                                                           "+masks,law", all);
                        }
                    }
                });
            }
        }
    }
    return true;
}();

// ---- occlusion

/// A gap of so many samples, 64 a pixel, between two occluders that hide all else.
template <class V>
void occlusion(benchmark::State& state, const V& variant, double gap_in_samples) {
    constexpr int size = 256;
    constexpr double distance = 4;
    const double sample_width = 2 * distance * std::tan(0.45) / (8 * size);
    const auto scene = scenes::occluders_with_gap({.gap = float(gap_in_samples * sample_width)});
    const auto part_bright = [](const Image& image) {
        double sum = 0;
        for (const Rgba8 c : image.pixels()) sum += std::max(c.r - 34, 0);
        return sum;
    };
    for (auto _ : state) {
        DrawnBy<V> reference(variant, scene, z_buffer_at(64));
        DrawnBy<V, CoverageRenderer> drawn(variant, scene, masks);
        const View view = view_from({0.3 * sample_width, 0, distance}, size, 1);
        View exactly = view;
        exactly.tolerance_px = 0;
        const double expected = part_bright(reference.picture(exactly));
        state.counters["gap_seen"] = part_bright(drawn.picture(view)) / expected;
        state.counters["drawn"] = double(drawn.stats().primitives) / double(scene.size());
        state.counters["tiling"] = double(drawn.work()->cells_tiled) / (size * size);
        state.counters["asking"] = double(drawn.work()->cells_asked) / (size * size);
    }
}

[[maybe_unused]] const bool occlusion_is_registered = [] {
    static const auto all = variants();
    for (const double gap : {1.02, 4.0}) {
        for_each_variant(all, [&]<class V>(const V& variant) {
            if constexpr (masks_draw<V>) {
                if (!is_drawn_with_masks(variant)) return;
                const std::string name = std::string("occlusion/gap/") + (gap < 2 ? "1" : "4") + "/" + variant.name;
                benchmark::RegisterBenchmark(
                    (name + "+masks").c_str(),
                    [gap, &variant](benchmark::State& state) { occlusion(state, variant, gap); })
                    ->Iterations(1)
                    ->Unit(benchmark::kMillisecond);
            }
        });
    }
    return true;
}();

}  // namespace
}  // namespace farfield::bench
