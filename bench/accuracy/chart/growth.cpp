#include "growth.hpp"

#include <algorithm>
#include <memory>

#include "growing_scenes.hpp"
#include "interrupt.hpp"
#include "peer_viewer.hpp"
#include "timing.hpp"

namespace farfield::bench {
namespace {

constexpr double tolerance_px = 1;
constexpr double limit_seconds = 2;  ///< of turns at one size from one place

const GrowingScene& find(const std::string& name) {
    const auto& all = growing_scenes();
    return *std::find_if(all.begin(), all.end(), [&](const GrowingScene& s) { return s.name == name; });
}

double guess_size_seconds(const GrowingScene& series, std::uint32_t size, std::size_t variants) {
    const double count = double(variants);
    return 3e-6 * series.stored(size) * count + 2 * limit_seconds * std::min(1.0, series.triangles(size) / 1e6) +
           1e-8 * series.triangles(size);
}

/// The largest that was timed from each view.
struct PeerTime {
    double triangles = 0, milliseconds = 0;
};

class SeriesRun {
  public:
    SeriesRun(const GrowingScene& series, const Options& options, const std::vector<const AnyVariant*>& variants,
              Output& output, Schedule& schedule)
        : series_(series), options_(options), variants_(variants), output_(output), schedule_(schedule) {}

    void measure() {
        for (const std::uint32_t size : options_.is_quick ? series_.quick_sizes : series_.sizes) {
            if (was_interrupted()) return;
            schedule_.begin(std::string(series_.name) + " of " + csv_number(series_.triangles(size)) + " triangles",
                            guess_size_seconds(series_, size, variants_.size()), int(variants_.size()));
            measure(size);
        }
    }

  private:
    void measure(std::uint32_t size) {
        const scenes::Scene scene = series_.make(size);
        const auto triangles = double(scenes::triangle_count(scene));
        const auto stored = std::size_t(scenes::bytes(scene) / sizeof(VertexColoredTriangle));
        const std::vector<const AnyVariant*> variants = variants_over(stored, variants_);
        std::vector<std::unique_ptr<scenes::BuiltScene>> built;
        std::vector<std::unique_ptr<scenes::SceneViewer>> viewers;
        for (const AnyVariant* variant : variants) {
            if (was_interrupted()) return;
            built.push_back(variant->build(scene));
            scenes::RendererChoice renderer = variant->renderer;
            renderer.samples = variant->samples(1);
            viewers.push_back(built.back()->viewer(renderer));
            schedule_.step();
        }
        const bool times_peer = triangles <= peer_limit;
        if (times_peer) viewers.push_back(std::make_unique<PeerViewer>(scene, 1));
        const std::vector<NamedView> views = series_.views(size, scene, options_.size_px);
        peer_.resize(views.size());
        for (std::size_t v = 0; v < views.size() && !was_interrupted(); ++v) {
            std::vector<Contestant> turns;
            for (std::size_t i = 0; i < viewers.size(); ++i) {
                View view = views[v].view;
                const bool stands_in = i < variants.size() && variants[i]->stands_in;
                view.tolerance_px = stands_in ? float(tolerance_px) : 0;
                if (stands_in) view.distance = variants[i]->distance;
                turns.push_back({viewers[i].get(), view});
                if (i < variants.size() && variants[i]->caches_images) {
                    turns.back().step = double(scenes::bounds(scene).largest_side()) / 800;
                }
            }
            take_turns(std::span(turns), options_.repetitions, limit_seconds, was_interrupted);
            if (turns.front().seconds.empty()) return;
            Row row = row_of(views[v], triangles);
            for (std::size_t i = 0; i < variants.size(); ++i) add(row, *variants[i], turns[i], *built[i]);
            if (times_peer) {
                add_peer(row, turns.back(), peer_[v]);
            } else {
                add_extrapolated(row, turns.front(), peer_[v]);
            }
        }
    }

    Row row_of(const NamedView& view, double triangles) const {
        Row row;
        row.chart = "growth";
        row.scene = series_.name;
        row.triangles = triangles;
        row.view = view.name;
        row.width_px = view.view.width;
        row.height_px = view.view.height;
        row.samples = 1;
        return row;
    }

    void add(Row row, const AnyVariant& variant, const Contestant& turn, const scenes::BuiltScene& built) {
        row.variant = variant.name;
        row.samples = variant.samples(1);
        if (variant.stands_in) row.tolerance_px = tolerance_px;
        set_measured(row, turn, built.facts());
        output_.add(std::move(row));
    }

    void add_peer(Row row, const Contestant& turn, PeerTime& largest) {
        set_measured(row, turn);
        row.variant = "peer";
        largest = {*row.triangles, *row.time_ms};
        output_.add(std::move(row));
    }

    void add_extrapolated(Row row, const Contestant& exact, const PeerTime& largest) {
        if (largest.triangles == 0) return;
        row.variant = "peer";
        row.time_ms = largest.milliseconds * *row.triangles / largest.triangles;
        row.speedup = 1e3 * quartiles(exact.seconds).median / *row.time_ms;
        row.note = "extrapolated from " + csv_number(largest.triangles) + " triangles";
        output_.add(std::move(row));
    }

    const GrowingScene& series_;
    const Options& options_;
    const std::vector<const AnyVariant*>& variants_;
    Output& output_;
    Schedule& schedule_;
    std::vector<PeerTime> peer_;  ///< one a view
};

}  // namespace

std::vector<std::string> growth_names() {
    std::vector<std::string> names;
    for (const GrowingScene& series : growing_scenes()) names.emplace_back(series.name);
    return names;
}

double GrowthRun::guess_seconds(const std::string& name) const {
    const GrowingScene& series = find(name);
    double seconds = 0;
    for (const std::uint32_t size : options_.is_quick ? series.quick_sizes : series.sizes) {
        seconds += guess_size_seconds(series, size, variants_.size());
    }
    return seconds;
}

void GrowthRun::measure(const std::string& name) {
    SeriesRun(find(name), options_, variants_, output_, schedule_).measure();
}

}  // namespace farfield::bench
