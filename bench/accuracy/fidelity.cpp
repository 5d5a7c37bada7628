// What a far field must reach, a line of figures each: error, speed at equal error, tearing, coverage, build. A row is
// a scene, a view and a method.
//
// Errors are on colors in [0, 1] over the object's rectangle, against every triangle at 64 samples a pixel. `exact` is
// the same renderer at one sample a pixel, with frustum culling, drawn in turns with the method; `speedup` is the
// median of exact time / method's time, turn by turn. A field of view of 60 degrees; distances in half sides of the
// scene's bounds; cells of 1 pixel where nothing else is said.
//
//   accuracy  rmse, signed coverage bias and time with 1, 4 and 16 samples a pixel; rmse_exact: of exact
//   speedup   the largest over exact of all tolerances and samples with rmse <= 0.05; reached = 0: none has, and this
//             is the one with the least rmse
//   beside    the same of the forest where all of it is in view, at exact's own error with one sample a pixel, over the
//             whole picture; peer_ms: of a plain loop over all triangles
//   far       the same from six times as far, at 1.3 255ths
//   bust      torn: pixels inside the silhouette, by a pixel at least, of which less than half is covered; leak: mean
//             part of the inside that is not; surfaces drawn from both sides or from the front only
//   wall      coverage / reference - 1 from 0 to 85 degrees off the normal, for cells of 1 and of 4 pixels: root mean
//             square, the one of the largest magnitude, and from where; exact: with as many samples
//   slats     likewise (coverage - reference) / area of the blind's outline, from 85 degrees below to 85 above; along:
//             from straight above and below, where it is a strip of a pixel or a line, how much too thick, in pixels
//   foliage   coverage / reference - 1 of the tree from 1 to 64 times the distance
//   build     bytes of nodes and data, and time on one core
#include <benchmark/benchmark.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <functional>
#include <glm/geometric.hpp>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "farfield/measure/coverage_error.hpp"
#include "farfield/measure/image_error.hpp"
#include "farfield/measure/projected_rect.hpp"
#include "peers/plain_renderer.hpp"
#include "scenes/generate/gallery.hpp"
#include "support/coverage.hpp"
#include "support/fidelity_subject.hpp"
#include "support/subject.hpp"

namespace farfield::bench {
namespace {

constexpr double radians = 3.14159265358979 / 180;
constexpr float field_of_view = float(60 * radians);

Subject made(const std::string& name) {
    const auto colored = [](const std::vector<Triangle>& triangles) { return scenes::vertex_colored(triangles); };
    if (name == "bust-two_sided") return {colored(scenes::bust({.side_quads = 163})), false};
    if (name == "bust-one_sided") return {colored(scenes::bust({.side_quads = 163})), true};
    for (const auto& [axes, normal] :
         {std::pair{"z", glm::vec3(0, 0, 1)}, {"xz", glm::vec3(1, 0, 1)}, {"xyz", glm::vec3(1, 1, 1)}}) {
        if (name == std::string("wall-") + axes)
            return {colored(scenes::wall({.normal = normal, .side_quads = 384})), false};
    }
    for (const int tilt : {0, 45, 90}) {
        if (name != "slats-" + std::to_string(tilt)) continue;
        return {colored(scenes::slats({.slats = 128, .angle_degrees = float(tilt), .segments = 1024})), false};
    }
    return {triangles_of(name), name == "molecule"};
}

/// One at a time: rows come by scenes, and all methods of one take gigabytes.
Subject& subject_of(const std::string& name) {
    static std::string current;
    static std::unique_ptr<Subject> subject;
    if (current != name) {
        subject.reset();
        subject = std::make_unique<Subject>(made(name));
        current = name;
    }
    return *subject;
}

/// Chamberlain 1996, Table 2: the tree from 30 degrees off its axis, the molecule from 25.
View view_of(Subject& subject, double distance) {
    return table_view(subject.bounds(), distance, subject.is_closed() ? 25 : 30, 124);
}

double root_mean_square(const std::vector<double>& errors) {
    double squares = 0;
    for (const double e : errors) squares += e * e;
    return std::sqrt(squares / double(errors.size()));
}

std::size_t index_of_largest(const std::vector<double>& errors) {
    const auto smaller = [](double a, double b) { return std::abs(a) < std::abs(b); };
    return std::size_t(std::max_element(errors.begin(), errors.end(), smaller) - errors.begin());
}

// ---- accuracy, and speed at equal error

void accuracy(benchmark::State& state, Subject& subject, const Method& method, double distance, int samples) {
    const View view = view_of(subject, distance);
    const Image& reference = subject.reference(view);
    const auto rect = projected_rect(subject.bounds(), view);
    Drawing& drawing = subject.by(method);
    Turns turns(subject.exact(), drawing, view, samples);
    for (auto _ : state) state.SetIterationTime(turns.take());
    state.counters["ms"] = turns.other_seconds() * 1e3;
    state.counters["exact_ms"] = turns.exact_seconds() * 1e3;
    state.counters["speedup"] = turns.speedup();
    state.counters["rmse"] = rmse(drawing.image(), reference, rect);
    state.counters["rmse_exact"] = rmse(subject.exact().image(), reference, rect);
    state.counters["coverage_bias"] = coverage_error(drawing.image(), reference, rect).bias;
    state.counters["cells"] = double(turns.stats().approximations);
    state.counters["triangles"] = double(turns.stats().primitives);
}

/// A tolerance and a number of samples, and what they give.
struct Setting {
    View view;
    int samples = 1;
    double rmse = std::numeric_limits<double>::infinity();
    double speedup = 0;  ///< over exact at one sample
    double seconds = 0;
};

/// The fastest setting that errs no more than `most`, or else the one that errs least, and says which; `rect` empty:
/// over the whole picture.
void find_fastest(benchmark::State& state, Subject& subject, const Method& method, View view, double most,
                  const std::optional<PixelRect>& rect) {
    const Image& reference = subject.reference(view);
    Drawing& drawing = subject.by(method);
    const auto time = [&](int turns, Setting& setting) {
        Turns taken(subject.exact(), drawing, setting.view, setting.samples);
        for (int i = 0; i < turns; ++i) taken.take();
        setting.seconds = taken.other_seconds();
        setting.speedup = taken.speedup();
    };
    Setting fastest, closest;
    for (auto _ : state) {
        for (const int samples : {1, 4, 16}) {
            for (const float tolerance_px :
                 {0.25f, 0.5f, 0.7f, 1.0f, 1.4f, 2.0f, 2.8f, 4.0f, 5.6f, 8.0f, 11.0f, 16.0f, 22.0f}) {
                view.tolerance_px = tolerance_px;
                drawing.frame(view, samples);
                Setting setting{view, samples, rmse(drawing.image(), reference, rect)};
                if (setting.rmse < closest.rmse) closest = setting;
                if (setting.rmse > most) continue;
                time(3, setting);
                if (setting.speedup > fastest.speedup) fastest = setting;
            }
        }
        // The largest of several noisy figures is one of luck: measured again.
        const bool reached = fastest.speedup > 0;
        if (!reached) fastest = closest;
        time(15, fastest);
        state.SetIterationTime(fastest.seconds);
        state.counters["reached"] = reached;
    }
    state.counters["speedup"] = fastest.speedup;
    state.counters["tolerance"] = double(fastest.view.tolerance_px);
    state.counters["samples"] = fastest.samples;
    state.counters["rmse"] = fastest.rmse;
    state.counters["exact_ms"] = fastest.seconds * fastest.speedup * 1e3;
}

void speedup(benchmark::State& state, Subject& subject, const Method& method, double distance) {
    const View view = view_of(subject, distance);
    find_fastest(state, subject, method, view, 0.05, projected_rect(subject.bounds(), view));
}

/// The whole of a scene in view from `times` as far as that takes, at exact's own error with one sample a pixel, or at
/// `most` over the whole picture. `peer_ms` is a plain loop over all triangles, compiled for this processor.
void all_in_view(benchmark::State& state, Subject& subject, const Method& method, double times, int degrees,
                 std::optional<double> most) {
    const double angle = degrees * radians;
    const glm::dvec3 center(subject.bounds().center()), towards(std::sin(angle), 0.2, std::cos(angle));
    const double distance = 0.75 * times * double(length_of(subject.bounds().size()));
    const View view{
        .camera = Camera::perspective(center + glm::normalize(towards) * distance, center, {0, 1, 0}, field_of_view),
        .width = 512,
        .height = 512};
    if (!most) {
        const Image& reference = subject.reference(view);
        subject.exact().frame(view, 1);
        most = rmse(subject.exact().image(), reference);
    }
    find_fastest(state, subject, method, view, *most, {});
    std::vector<PlainTriangle> all;
    for (const VertexColoredTriangle& t : subject.triangles()) {
        t.polygons([&](const Polygon& polygon) { add_plain_triangles(polygon, all); });
    }
    const auto peer = native_plain_z_buffer(1);
    const LocalView local(view, glm::dvec3(0), length_of(subject.bounds().size()));
    std::vector<double> peer_seconds;
    for (int i = 0; i < 7; ++i) {
        peer_seconds.push_back(seconds([&] {
            peer->begin_frame(local);
            peer->set_view(local);
            peer->draw(all);
            peer->end_frame();
        }));
    }
    state.counters["peer_ms"] = median(peer_seconds) * 1e3;
    state.counters["rmse_in_255ths"] = state.counters["rmse"].value * 255;
}

// ---- tearing

void tearing(benchmark::State& state, Subject& subject, const Method& method, double distance, float tolerance_px) {
    View view = table_view(subject.bounds(), distance, 45, 512);
    view.tolerance_px = tolerance_px;
    const Image& reference = subject.reference(view);
    Drawing& drawing = subject.by(method);
    for (auto _ : state) drawing.frame(view, 1);
    const Image& image = drawing.image();
    const Tearing found = tearing_of(image, reference);
    const auto rect = projected_rect(subject.bounds(), view);
    state.counters["torn"] = found.torn;
    state.counters["leak"] = found.leak;
    state.counters["bias"] = coverage_error(image, reference, rect).bias;
    state.counters["rmse"] = rmse(image, reference, rect);
}

// ---- coverage

constexpr double px_a_unit = 60;  // of length, seen squarely: walls and blinds have 2

View view_from(glm::dvec3 direction, glm::vec3 up) {
    constexpr int size = 256;
    const double distance = size / px_a_unit / (2 * std::tan(double(field_of_view) / 2));
    return {.camera = Camera::perspective(direction * distance, {}, up, field_of_view), .width = size, .height = size};
}

/// Where a scene is looked at from, and how many pixels of coverage count as an error of 1.
struct Look {
    int degrees;
    View view;
    double unit_px;
};

std::vector<double> coverage_errors(Subject& subject, Drawing& drawing, const std::vector<Look>& looks,
                                    float tolerance_px, int samples) {
    std::vector<double> errors;
    for (const Look& look : looks) {
        View view = look.view;
        view.tolerance_px = tolerance_px;
        drawing.frame(view, samples);
        errors.push_back((coverage(drawing.image()) - coverage(subject.reference(view))) / look.unit_px);
    }
    return errors;
}

void set_coverage_errors(benchmark::State& state, Subject& subject, const Method& method,
                         const std::vector<Look>& looks, int samples) {
    const auto set = [&](const std::string& suffix, Drawing& drawing, float tolerance_px) {
        const std::vector<double> errors = coverage_errors(subject, drawing, looks, tolerance_px, samples);
        const std::size_t largest = index_of_largest(errors);
        state.counters["rms_" + suffix] = root_mean_square(errors);
        state.counters["largest_" + suffix] = errors[largest];
        state.counters["largest_" + suffix + "_from"] = looks[largest].degrees;
    };
    for (auto _ : state) {
        set("1px", subject.by(method), 1);
        set("4px", subject.by(method), 4);
        set("exact", subject.exact(), 0);
    }
}

void wall(benchmark::State& state, Subject& subject, const Method& method, glm::vec3 normal, int samples) {
    const glm::dvec3 n = glm::normalize(glm::dvec3(normal)), up(0, 1, 0), along = glm::normalize(glm::cross(up, n));
    std::vector<Look> looks;
    for (const int degrees : {0, 15, 30, 45, 60, 75, 85}) {
        const View view = view_from(n * std::cos(degrees * radians) + along * std::sin(degrees * radians), up);
        looks.push_back({degrees, view, coverage(subject.reference(view))});
    }
    set_coverage_errors(state, subject, method, looks, samples);
}

void slats(benchmark::State& state, Subject& subject, const Method& method, int samples) {
    const glm::dvec3 size(subject.bounds().size());
    const auto look_from = [&](int degrees) -> Look {
        const double sine = std::sin(degrees * radians), cosine = std::cos(degrees * radians);
        // The outline of the bounds, from so far that their sides are parallel.
        const double outline = size.x * (size.y * cosine + size.z * std::abs(sine));
        return {degrees, view_from({0, sine, cosine}, glm::vec3(0, cosine, -sine)), outline * px_a_unit * px_a_unit};
    };
    std::vector<Look> looks, along{look_from(-90), look_from(90)};
    for (int degrees = -85; degrees <= 85; degrees += 5) looks.push_back(look_from(degrees));
    set_coverage_errors(state, subject, method, looks, samples);
    for (Look& look : along) look.unit_px = size.x * px_a_unit;
    for (const int tolerance_px : {1, 4}) {
        const auto errors = coverage_errors(subject, subject.by(method), along, float(tolerance_px), samples);
        state.counters["along_" + std::to_string(tolerance_px) + "px"] = (errors[0] + errors[1]) / 2;
    }
}

/// The same camera with a field of view that the scene fills, so that twigs far away still meet samples.
View narrowed(View view, const Box& bounds) {
    const double radius = 0.5 * double(glm::length(bounds.size()));
    const double distance = glm::length(view.camera.eye - glm::dvec3(bounds.center()));
    if (distance > 2 * radius) {
        view.camera.half_height = std::min(view.camera.half_height, float(radius / (distance - radius)));
    }
    return view;
}

void foliage(benchmark::State& state, Subject& subject, const Method& method, int samples) {
    Drawing& drawing = subject.by(method);
    std::vector<double> biases;
    for (auto _ : state) {
        for (int times = 1; times <= 64; times *= 2) {
            const View view = view_of(subject, 1.75 * times), near_by = narrowed(view, subject.bounds());
            const double narrowing = double(near_by.camera.half_height) / double(view.camera.half_height);
            drawing.frame(view, samples);
            const double expected = coverage(subject.reference(near_by)) * narrowing * narrowing;
            biases.push_back(coverage(drawing.image()) / expected - 1);
            // Counters are listed by name.
            const std::string label = std::to_string(times);
            state.counters["bias_" + std::string(2 - label.size(), '0') + label + "x"] = biases.back();
        }
    }
    state.counters["rms"] = root_mean_square(biases);
    state.counters["largest"] = biases[index_of_largest(biases)];
}

// ---- build

void build(benchmark::State& state, Subject& subject, const Method& method) {
    const double triangles = double(subject.triangles().size());
    std::vector<double> seconds;
    Drawing::BuildFacts built;
    for (auto _ : state) {
        built = method.draw(subject.triangles(), subject.is_closed())->built();
        seconds.push_back(built.seconds);
        state.SetIterationTime(built.seconds);
    }
    state.counters["triangles_per_s"] = triangles / median(seconds);
    state.counters["bytes_per_triangle"] = double(built.bytes) / triangles;
    state.counters["bytes_of_nodes"] = double(built.nodes * sizeof(Node)) / triangles;
    state.counters["nodes"] = double(built.nodes);
    state.counters["stand_ins"] = double(built.stand_ins);
}

// ---- rows

using Row = std::function<void(benchmark::State&, Subject&, const Method&)>;

/// measure(state, subject, method, arguments...)
template <class... Arguments>
Row row(void (*measure)(benchmark::State&, Subject&, const Method&, Arguments...),
        std::type_identity_t<Arguments>... arguments) {
    return [=](benchmark::State& state, Subject& subject, const Method& method) {
        measure(state, subject, method, arguments...);
    };
}

/// A row a method. `turns`: of iterations that time themselves; 0: one that does not.
void add(const std::string& scene, const std::string& name, int turns, const Row& measure) {
    for (const Method& method : methods()) {
        auto* added = benchmark::RegisterBenchmark(
            (name + "/" + method.name).c_str(),
            [=, &method](benchmark::State& state) { measure(state, subject_of(scene), method); });
        added->Iterations(std::max(turns, 1))->Unit(benchmark::kMillisecond);
        if (turns > 0) added->UseManualTime();
    }
}

std::string at(double distance) {
    std::array<char, 16> text{};
    std::snprintf(text.data(), text.size(), "/d=%g", distance);
    return text.data();
}
std::string with(int samples) {
    return "/" + std::to_string(samples) + (samples == 1 ? "_sample" : "_samples");
}

void add_papers_scene(const std::string& scene, const std::vector<double>& distances, int builds) {
    for (const double distance : distances) {
        for (const int samples : {1, 4, 16}) {
            add(scene, "accuracy/" + scene + at(distance) + with(samples), 21, row(accuracy, distance, samples));
        }
    }
    for (const double distance : {1.75, 3.5, 7.0, 14.0}) {
        add(scene, "speedup/" + scene + at(distance), 1, row(speedup, distance));
    }
    add(scene, "build/" + scene, builds, build);
}

[[maybe_unused]] const bool rows_are_registered = [] {
    add_papers_scene("tree", {1.75, 3.5, 7, 14, 28, 56}, 11);
    for (const int samples : {1, 16}) {
        add("tree", "foliage/tree" + with(samples), 0, row(foliage, samples));
    }
    for (const char* sides : {"two_sided", "one_sided"}) {
        for (const double distance : {7.0, 14.0}) {
            for (const int tolerance_px : {1, 2}) {
                add(std::string("bust-") + sides,
                    std::string("bust/") + sides + at(distance) + "/" + std::to_string(tolerance_px) + "px", 0,
                    row(tearing, distance, float(tolerance_px)));
            }
        }
    }
    for (const auto& axes : {"z", "xz", "xyz"}) {
        const std::string name = axes;
        const glm::vec3 normal(name.find('x') != name.npos, name.find('y') != name.npos, 1);
        for (const int samples : {1, 16}) {
            add("wall-" + name, "wall/" + name + with(samples), 0, row(wall, normal, samples));
        }
    }
    for (const int tilt : {0, 45, 90}) {
        const std::string degrees = std::to_string(tilt);
        for (const int samples : {1, 16}) {
            add("slats-" + degrees, "slats/" + degrees + with(samples), 0, row(slats, samples));
        }
    }
    add_papers_scene("molecule", {1.75, 3.5, 7, 14}, 3);
    for (const int degrees : {0, 90, 180, 270}) {
        const std::string from = "/" + std::to_string(degrees) + "_degrees";
        add("forest", "beside/forest" + from, 1, row(all_in_view, 1.0, degrees, std::optional<double>{}));
        add("forest", "far/forest" + from, 1, row(all_in_view, 6.0, degrees, std::optional(1.3 / 255)));
    }
    return true;
}();

}  // namespace
}  // namespace farfield::bench
