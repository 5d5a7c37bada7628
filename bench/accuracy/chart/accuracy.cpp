#include "accuracy.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <glm/geometric.hpp>

#include "errors.hpp"
#include "interrupt.hpp"
#include "peer_viewer.hpp"
#include "pictures.hpp"
#include "scenes/catalog.hpp"
#include "timing.hpp"
#include "views.hpp"

namespace farfield::bench {
namespace {

using scenes::BuiltScene;
using scenes::SceneViewer;

/// Of turns in which all variants are timed at one tolerance from one place.
constexpr double limit_seconds = 1;
/// Of the copies of triangles that variants and their viewers hold: where they would be more, not all variants take
/// turns with each other. Each still does with exact.
constexpr double limit_bytes = 3e9;
constexpr double bytes_a_triangle = 110;

std::size_t stored_triangles(const scenes::Scene& scene) {
    return std::size_t(scenes::bytes(scene) / sizeof(VertexColoredTriangle));
}

double guess_build_seconds(std::size_t triangles) {
    return 3e-6 * double(triangles);
}
double guess_reference_seconds(std::size_t triangles) {
    return 0.3 + 2e-6 * double(triangles);
}
/// Of all variants at one tolerance from one place, with their errors.
double guess_round_seconds(std::size_t triangles, std::size_t variants, const Options& options) {
    const double pixels = double(options.size_px) * options.size_px;
    const double turn = 2 * double(variants + 1) * (2e-4 + 3e-9 * double(triangles));
    return std::min(options.repetitions * turn, 3 * limit_seconds) + double(variants) * (1e-3 + 3e-7 * pixels);
}

class SceneRun {
  public:
    SceneRun(const std::string& name, const Options& options, Output& output, Schedule& schedule)
        : name_(name),
          options_(options),
          output_(output),
          schedule_(schedule),
          scene_(scenes::make(name)),
          stored_(stored_triangles(scene_)),
          triangles_(scenes::triangle_count(scene_)) {
        const Box bounds = scenes::bounds(scene_);
        for (const double distance : options.distances) {
            View view = view_from(bounds, scene_.up, distance, options.angle_degrees, options.size_px);
            view.tolerance_px = 0;
            places_.push_back({distance, view, {}});
        }
        bounds_ = bounds;
        // From 1.75 radii the object is as large as the picture; from 3.5 all of it is seen, and some of it is far.
        pictured_ = nearest(options.distances, 3.5);
        pictured_tolerance_ = nearest(options.tolerances_px, 1);
    }

    void measure(const std::vector<const AnyVariant*>& all) {
        measure_exact();
        if (double(triangles_) <= peer_limit) measure_peer();
        const std::vector<const AnyVariant*> variants = variants_over(stored_, all);
        const auto most = std::max<std::size_t>(std::size_t(limit_bytes / (bytes_a_triangle * double(stored_ + 1))), 1);
        for (std::size_t first = 1; first < variants.size() && !was_interrupted(); first += most) {
            const auto last = std::min(first + most, variants.size());
            measure_batch({variants.begin() + std::ptrdiff_t(first), variants.begin() + std::ptrdiff_t(last)});
        }
    }

  private:
    struct Place {
        double distance;
        View view;  ///< at tolerance 0
        Reference reference;
    };
    struct Built {
        const AnyVariant* variant;
        std::unique_ptr<BuiltScene> scene;
        std::unique_ptr<SceneViewer> viewer;  ///< null: it does not take part
        int samples;
    };

    static std::size_t nearest(const std::vector<double>& values, double wanted) {
        const auto off = [&](double v) { return std::abs(std::log(std::max(v, 1e-9) / wanted)); };
        const auto least =
            std::min_element(values.begin(), values.end(), [&](double a, double b) { return off(a) < off(b); });
        return std::size_t(least - values.begin());
    }

    std::unique_ptr<SceneViewer> viewer(const BuiltScene& scene, int samples,
                                        scenes::RendererChoice renderer = {}) const {
        renderer.samples = samples;
        renderer.culls_back_faces = culls_back_faces(name_);
        return scene.viewer(renderer);
    }

    /// The exact picture at 1, 4, 16 and 64 samples a pixel is a curve of its own.
    void measure_exact() {
        const AnyVariant& exact = all_variants().front();
        schedule_.begin(name_ + ": building exact", guess_build_seconds(stored_));
        exact_ = exact.build(scene_);
        exact_viewer_ = viewer(*exact_, 1);
        bool has_row_of_one = false;
        for (const int samples : {64, 16, 4}) {
            schedule_.begin(name_ + ": exact at " + std::to_string(samples) + " samples a pixel",
                            double(places_.size()) * guess_reference_seconds(stored_), int(places_.size()));
            const auto finer = viewer(*exact_, samples);
            for (Place& place : places_) {
                if (was_interrupted()) return;
                if (samples == 64) place.reference = Reference(*finer, place.view, bounds_);
                Contestant turns[] = {{exact_viewer_.get(), place.view}, {finer.get(), place.view}};
                take_turns(std::span(turns), options_.repetitions, limit_seconds, was_interrupted);
                if (!has_row_of_one) add(exact.name, exact_.get(), 1, place, turns[0], {});
                add(exact.name, exact_.get(), samples, place, turns[1], {});
                schedule_.step();
            }
            has_row_of_one = true;
        }
        const Place& place = places_[pictured_];
        report::write_png(place.reference.over_white(), options_.directory / picture_file(name_, reference_name));
        exact_viewer_->frame(place.view);
        write_pictures(exact.name, exact_viewer_->image());
    }

    /// All triangles by the peer at 1 and 64 samples a pixel, each of one color, which its errors show.
    void measure_peer() {
        for (const int a_side : {1, 8}) {
            schedule_.begin(name_ + ": the peer at " + std::to_string(a_side * a_side) + " samples a pixel",
                            double(places_.size()) * guess_reference_seconds(stored_), int(places_.size()));
            PeerViewer peer(scene_, a_side);
            for (const Place& place : places_) {
                if (was_interrupted()) return;
                Contestant turns[] = {{exact_viewer_.get(), place.view}, {&peer, place.view}};
                take_turns(std::span(turns), options_.repetitions, limit_seconds, was_interrupted);
                add("peer", nullptr, a_side * a_side, place, turns[1], {});
                if (a_side == 1 && &place == &places_[pictured_]) write_pictures("peer", peer.image());
                schedule_.step();
            }
        }
    }

    void measure_batch(const std::vector<const AnyVariant*>& batch) {
        std::vector<Built> built;
        for (const AnyVariant* variant : batch) {
            if (was_interrupted()) return;
            schedule_.begin(name_ + ": building " + variant->name, guess_build_seconds(stored_));
            built.push_back({variant, variant->build(scene_), {}, 0});
        }
        for (const int samples : options_.samples) {
            for (Built& b : built) {
                b.viewer.reset();  // it holds a copy of all triangles
                // What has samples of its own is drawn once.
                if (b.variant->has_own_samples() && samples != options_.samples.front()) continue;
                b.samples = b.variant->samples(samples);
                b.viewer = viewer(*b.scene, b.samples, b.variant->renderer);
            }
            measure_places(built, samples);
        }
    }

    /// `samples` were asked for.
    void measure_places(const std::vector<Built>& built, int samples) {
        const auto rounds = options_.tolerances_px.size();
        for (const Place& place : places_) {
            const double seconds = double(rounds) * guess_round_seconds(stored_, built.size(), options_);
            schedule_.begin(name_ + ": from " + csv_number(place.distance) + " radii, " + std::to_string(samples) +
                                (samples == 1 ? " sample" : " samples") + " a pixel",
                            seconds, int(rounds));
            for (std::size_t t = 0; t < rounds; ++t) {
                if (was_interrupted()) return;
                measure_round(built, place, t, samples);
                schedule_.step();
            }
        }
    }

    /// All variants at one tolerance from one place.
    void measure_round(const std::vector<Built>& built, const Place& place, std::size_t tolerance, int samples) {
        std::vector<Contestant> turns{{exact_viewer_.get(), place.view}};
        std::vector<const Built*> who{nullptr};
        for (const Built& b : built) {
            if (!b.viewer || (!b.variant->stands_in && tolerance != 0)) continue;  // no tolerance changes anything
            View view = place.view;
            view.distance = b.variant->distance;
            if (b.variant->stands_in) view.tolerance_px = float(options_.tolerances_px[tolerance]);
            turns.push_back({b.viewer.get(), view});
            if (b.variant->caches_images) turns.back().step = step_of(place);
            who.push_back(&b);
        }
        if (turns.size() == 1) return;
        take_turns(std::span(turns), options_.repetitions, limit_seconds, was_interrupted);
        for (std::size_t i = 1; i < turns.size(); ++i) {
            const AnyVariant& variant = *who[i]->variant;
            turns[i].return_to_view();
            const Row::Number tolerance_px =
                variant.stands_in ? Row::Number(options_.tolerances_px[tolerance]) : std::nullopt;
            add(variant.name, who[i]->scene.get(), who[i]->samples, place, turns[i], tolerance_px);
            const bool is_pictured = &place == &places_[pictured_] && samples == options_.samples.front() &&
                                     (!variant.stands_in || tolerance == pictured_tolerance_);
            if (is_pictured) write_pictures(variant.name, turns[i].viewer->image());
        }
    }

    /// Of a stroll: an eight hundredth of the way to the middle, as from the edge of the island of Shade et al. 1996,
    /// section 5, along which 1,200 frames are drawn.
    double step_of(const Place& place) const {
        return glm::length(place.view.camera.eye - glm::dvec3(bounds_.center())) / 800;
    }

    /// `turn` holds the last frame's picture; `built` is null where there is no hierarchy.
    void add(const std::string& variant, const BuiltScene* built, int samples, const Place& place,
             const Contestant& turn, Row::Number tolerance_px) {
        if (turn.seconds.empty()) return;  // interrupted before its first
        Row row;
        row.chart = "accuracy";
        row.scene = name_;
        row.triangles = double(triangles_);
        row.view = csv_number(place.distance) + " radii";
        row.distance_radii = place.distance;
        row.width_px = place.view.width;
        row.height_px = place.view.height;
        row.variant = variant;
        row.samples = samples;
        row.tolerance_px = tolerance_px;
        if (built) {
            set_measured(row, turn, built->facts());
        } else {
            set_measured(row, turn);
        }
        place.reference.compare(turn.viewer->image(), row);
        write_point_picture(place, report::over_background(turn.viewer->image(), {}), point_picture_file(row));
        if (variant == "exact" && samples == 1) {
            write_point_picture(place, place.reference.over_white(), point_reference_file(row));
        }
        output_.add(std::move(row));
    }

    void write_point_picture(const Place& place, const Image& picture, const std::filesystem::path& file) const {
        report::write_png(place.reference.compared_part(picture), options_.directory / file);
    }

    void write_pictures(const std::string& variant, const Image& image) const {
        const Image picture = report::over_background(image, {});
        report::write_png(picture, options_.directory / picture_file(name_, variant));
        report::write_png(report::difference(picture, places_[pictured_].reference.over_white()),
                          options_.directory / picture_file(name_, variant, "_difference"));
    }

    std::string name_;
    const Options& options_;
    Output& output_;
    Schedule& schedule_;
    scenes::Scene scene_;
    std::size_t stored_;
    std::uint64_t triangles_;
    Box bounds_ = Box::empty();
    std::vector<Place> places_;
    std::size_t pictured_ = 0, pictured_tolerance_ = 0;
    std::unique_ptr<BuiltScene> exact_;
    std::unique_ptr<SceneViewer> exact_viewer_;
};

}  // namespace

std::vector<std::string> default_scenes() {
    std::vector<std::string> names;
    for (const char* name : {"tree", "forest", "island", "building"}) {
        for (const std::string& known : scenes::names()) {
            if (known == name) names.push_back(known);
        }
    }
    return names;
}

double AccuracyRun::guess_seconds(const std::string& name) const {
    const std::size_t triangles = stored_triangles(scenes::make(name));
    const auto places = double(options_.distances.size()), count = double(variants_.size());
    return count * guess_build_seconds(triangles) +
           places *
               (5 * guess_reference_seconds(triangles) +
                double(options_.tolerances_px.size()) * guess_round_seconds(triangles, variants_.size(), options_));
}

void AccuracyRun::measure(const std::string& scene) {
    SceneRun(scene, options_, output_, schedule_).measure(variants_);
}

}  // namespace farfield::bench
