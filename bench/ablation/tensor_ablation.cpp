// What each part of the opacity tensor buys: error, bytes and time with and without it, on scenes where it matters.
// "Model no more than a scene needs": a default is on because a row here says so.
// include/farfield/approximation/opacity_tensor/README.md explains the parts.
//
// Each variant differs from the first, which has the defaults, in one thing; what is no option is left out here, not in
// the library. The first is measured against another one of its kind: what it differs by from 1 is the machine's noise.
// Cells of 1 pixel, one sample a pixel, references of 64.
//
//   rmse                 on colors in [0, 1] over the object's rectangle, root mean square over the views
//   coverage_bias        coverage less the reference's, of the reference's (of the area of a blind's outline), over the
//   coverage_rms         views: mean, root mean square, and the one of the largest magnitude
//   coverage_largest
//   tone_rms             of mean luminance of what is covered, less the reference's, in [0, 1]
//   torn, leak           of what is opaque: pixels inside the silhouette of which less than half is covered, all views;
//                        mean part of the inside that is not
//   bytes_per_triangle   of nodes and stand-ins
//   time_against_defaults
//                        of frames drawn in turns, medians; geometric mean over the views
//
// Views: tree and molecule from 7 and 14 radii, from 30 (25) degrees off the axis, where the papers looked from, and
// from opposite; the bust 45 degrees off its axis, 512 x 512; a wall along (1,1,1) from 0 to 85 degrees off its normal;
// a blind of slats tilted by 45 degrees from 85 degrees below to 85 above.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <glm/geometric.hpp>
#include <initializer_list>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "farfield/approximation/opacity_tensor.hpp"
#include "farfield/measure/coverage_error.hpp"
#include "farfield/measure/image_error.hpp"
#include "farfield/measure/projected_rect.hpp"
#include "scenes/generate/gallery.hpp"
#include "support/coverage.hpp"
#include "support/fidelity_subject.hpp"
#include "support/subject.hpp"

namespace farfield::bench {
namespace {

// ---- the tensor with a part missing

/// Differs in what is stored, but for its error: the same cells are drawn.
template <void (*change)(const OpacityTensor&, TensorShape&)>
struct Changed : OpacityTensor {
    stand_in_data finish(const Cell& cell, const stand_in_draft& d) const {
        const TensorFit fit(d, cell, closed_surfaces);
        if (fit.is_empty()) return {};
        TensorShape shape = fit.shape(counts_overlap);
        change(*this, shape);
        const float root = std::sqrt(OpacityTensor::finish(cell, d).error()) - 0.5f / 31;  // is rounded up again
        shape.error = root > 0 ? root * root : 0.0f;
        return StoredTensor::packed(shape);
    }
};

/// The mean of Cauchy's formula is kept.
void seen_alike_from_everywhere(const OpacityTensor&, TensorShape& s) {
    const float mean = TensorFit::mean_area(s.root);
    s.root = {mean, 0, 0, mean, 0, mean};
}

/// What is covered seen along the axes is kept: areas are fitted by the other law.
template <AreaLaw law>
void by_one_law(const OpacityTensor& tensor, TensorShape& s) {
    glm::vec3 grown(1);
    for (int axis = 0; axis < 3; ++axis) {
        glm::vec3 w(0);
        w[axis] = 1;
        const float area = area_seen_from(s, w) * (tensor.closed_surfaces ? 0.5f : 1.0f);
        const float outline = s.extent[(axis + 1) % 3] * s.extent[(axis + 2) % 3];
        if (!(area > 0)) continue;
        const float left = std::max(transmitted(1, area / outline, s.law), 1.0f / 64);
        grown[axis] = (law == AreaLaw::coherent ? 1 - left : -std::log(left)) * outline / area;
    }
    constexpr std::array<int, 6> row{0, 1, 2, 1, 2, 2};
    for (std::size_t i = 0; i < 6; ++i) s.root[i] *= grown[row[i]];
    s.facing *= grown;
    s.tone *= grown;
    s.law = law;
}

void without_tone(const OpacityTensor&, TensorShape& s) {
    s.tone = s.facing;  // of closed surfaces; as luminance times area does it change with the area
}

/// Squares of the rectangles' areas.
struct Squares : OpacityTensor {
    template <class Sink>
    void draw_stand_in(const stand_in_data& data, const Cell& cell, const LocalView& view, Sink&& sink) const {
        struct AsSquares {
            std::remove_reference_t<Sink>& to;
            float splat_limit_px;
            void operator()(const Face& face) const { to(face); }
            void operator()(Splat splat) const {
                splat.size = glm::vec2(std::sqrt(splat.size.x * splat.size.y));
                to(splat);
            }
        };
        OpacityTensor::draw_stand_in(data, cell, view, AsSquares{sink, sink.splat_limit_px});
    }
};

/// As with ZBufferOptions{.deposits_small_triangles = false}: where no law is known, only cells are deposited.
struct PointSampledTriangles : OpacityTensor {
    std::optional<AreaLaw> area_law(const stand_in_data&) const { return {}; }
};

template <class Ablated>
Method ablated(const char* name) {
    return method(name, Ablated{}, Ablated{{.closed_surfaces = true}});
}

/// The first has the defaults.
const std::vector<Method>& variants() {
    static const std::vector<Method> all{
        method("defaults", OpacityTensor{}, OpacityTensor{.closed_surfaces = true}),
        ablated<Changed<seen_alike_from_everywhere>>("no_tensor"),
        ablated<Changed<by_one_law<AreaLaw::independent>>>("all_independent"),
        ablated<Changed<by_one_law<AreaLaw::coherent>>>("all_coherent"),
        method("two_sided", OpacityTensor{}),
        method("overlap_counted_twice", OpacityTensor{.counts_overlap = false},
               OpacityTensor{.closed_surfaces = true, .counts_overlap = false}),
        ablated<Changed<without_tone>>("no_tone"),
        ablated<Squares>("squares"),
        method("no_sheet_gain", OpacityTensor{.sheet_gain = 1},
               OpacityTensor{.closed_surfaces = true, .closed_sheet_gain = 1}),
        ablated<PointSampledTriangles>("small_triangles_point_sampled"),
        method("color_cube", ColorCube{}),
        method("color_cube_guessing_laws", ColorCube{.guesses_area_law = true}),
    };
    return all;
}

// ---- scenes

struct Look {
    View view;
    double unit_px;  ///< how many pixels of coverage are an error of 1
};

struct Scene {
    std::unique_ptr<Subject> subject;
    std::vector<Look> looks{};
    bool is_opaque = true;

    void add(const View& view) { looks.push_back({view, coverage(subject->reference(view))}); }
};

/// Distances in half sides; `degrees` off the axis.
void add_table_views(Scene& scene, std::initializer_list<double> degrees, int size) {
    for (const double distance : {7.0, 14.0}) {
        for (const double angle : degrees) scene.add(table_view(scene.subject->bounds(), distance, angle, size));
    }
}

/// 60 pixels a unit, seen squarely.
View view_from(glm::dvec3 direction, glm::vec3 up) {
    constexpr int size = 256;
    constexpr float field_of_view = 1.04719755f;
    const double distance = size / 60.0 / (2 * std::tan(double(field_of_view) / 2));
    return {.camera = Camera::perspective(direction * distance, {}, up, field_of_view), .width = size, .height = size};
}

Scene made(const std::string& name) {
    constexpr double radians = 3.14159265358979 / 180;
    const auto subject = [](const std::vector<Triangle>& triangles, bool is_closed) {
        return std::make_unique<Subject>(scenes::vertex_colored(triangles), is_closed);
    };
    if (name == "bust") {
        Scene scene{subject(scenes::bust({.side_quads = 163}), true)};
        add_table_views(scene, {45}, 512);
        return scene;
    }
    if (name == "wall") {
        Scene scene{subject(scenes::wall({.normal = glm::vec3(1, 1, 1), .side_quads = 384}), false)};
        const glm::dvec3 n = glm::normalize(glm::dvec3(1)), up(0, 1, 0), along = glm::normalize(glm::cross(up, n));
        for (const int degrees : {0, 15, 30, 45, 60, 75, 85}) {
            scene.add(view_from(n * std::cos(degrees * radians) + along * std::sin(degrees * radians), up));
        }
        return scene;
    }
    if (name == "slats") {
        Scene scene{subject(scenes::slats({.slats = 128, .angle_degrees = 45, .segments = 1024}), false)};
        scene.is_opaque = false;
        const glm::dvec3 size(scene.subject->bounds().size());
        for (int degrees = -85; degrees <= 85; degrees += 10) {
            const double sine = std::sin(degrees * radians), cosine = std::cos(degrees * radians);
            scene.add(view_from({0, sine, cosine}, glm::vec3(0, cosine, -sine)));
            // Of the bounds, as if from so far that their sides are parallel.
            scene.looks.back().unit_px = 60 * 60 * size.x * (size.y * cosine + size.z * std::abs(sine));
        }
        return scene;
    }
    const bool is_molecule = name == "molecule";
    Scene scene{std::make_unique<Subject>(triangles_of(name), is_molecule)};
    scene.is_opaque = is_molecule;
    const double angle = is_molecule ? 25 : 30;
    add_table_views(scene, {angle, angle + 180}, 124);
    return scene;
}

/// One at a time: rows come by scenes.
Scene& scene_of(const std::string& name) {
    static std::string current;
    static Scene scene;
    if (current != name) {
        scene = {};
        scene = made(name);
        current = name;
    }
    return scene;
}

// ---- rows

/// Rec. 709, of colors as stored, over coverage; 0 where nothing is covered.
double mean_luminance(const Image& image) {
    double sum = 0;
    for (const Rgba8 c : image.pixels()) sum += 0.2126 * c.r + 0.7152 * c.g + 0.0722 * c.b;
    const double covered = coverage(image);
    return covered > 0 ? sum / covered / 255 : 0;
}

void set_errors(benchmark::State& state, Scene& scene, Drawing& drawing) {
    double mse_sum = 0, bias = 0, squares = 0, largest = 0, tones = 0, torn = 0, leak = 0;
    for (const Look& look : scene.looks) {
        const Image& reference = scene.subject->reference(look.view);
        drawing.frame(look.view, 1);
        const Image& image = drawing.image();
        mse_sum += mse(image, reference, projected_rect(scene.subject->bounds(), look.view));
        const double off = (coverage(image) - coverage(reference)) / look.unit_px;
        bias += off;
        squares += off * off;
        if (std::abs(off) > std::abs(largest)) largest = off;
        const double tone = mean_luminance(image) - mean_luminance(reference);
        tones += tone * tone;
        const Tearing tearing = tearing_of(image, reference);
        torn += tearing.torn;
        leak += tearing.leak;
    }
    const auto views = double(scene.looks.size());
    state.counters["rmse"] = std::sqrt(mse_sum / views);
    state.counters["coverage_bias"] = bias / views;
    state.counters["coverage_rms"] = std::sqrt(squares / views);
    state.counters["coverage_largest"] = largest;
    state.counters["tone_rms"] = std::sqrt(tones / views);
    if (scene.is_opaque) {
        state.counters["torn"] = torn;
        state.counters["leak"] = leak / views;
    }
}

void ablation(benchmark::State& state, Scene& scene, const Method& variant) {
    Drawing& defaults = scene.subject->by(variants()[0]);
    const std::unique_ptr<Drawing> drawing = variant.draw(scene.subject->triangles(), scene.subject->is_closed());
    std::vector<Turns> turns;
    for (const Look& look : scene.looks) turns.emplace_back(defaults, *drawing, look.view, 1);
    for (auto _ : state) {
        double sum = 0;
        for (Turns& of_a_view : turns) sum += of_a_view.take();
        state.SetIterationTime(sum);
    }
    double log_ratio = 0;
    for (const Turns& of_a_view : turns) log_ratio -= std::log(of_a_view.speedup());
    state.counters["time_against_defaults"] = std::exp(log_ratio / double(turns.size()));
    state.counters["bytes_per_triangle"] = double(drawing->built().bytes) / double(scene.subject->triangles().size());
    set_errors(state, scene, *drawing);
}

[[maybe_unused]] const bool rows_are_registered = [] {
    for (const char* scene : {"tree", "molecule", "bust", "wall", "slats"}) {
        const std::string name = scene;
        const bool is_closed = name == "molecule" || name == "bust";
        for (const Method& variant : variants()) {
            if (variant.name == "two_sided" && !is_closed) continue;  // is the default
            benchmark::RegisterBenchmark(
                ("tensor_ablation/" + name + "/" + variant.name).c_str(),
                [name, &variant](benchmark::State& state) { ablation(state, scene_of(name), variant); })
                ->UseManualTime()
                ->Iterations(7)
                ->Unit(benchmark::kMillisecond);
        }
    }
    return true;
}();

}  // namespace
}  // namespace farfield::bench
