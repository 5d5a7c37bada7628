#include "options.hpp"

#include <algorithm>
#include <CLI/CLI.hpp>
#include <cmath>
#include <sstream>

#include "accuracy.hpp"
#include "growth.hpp"
#include "scenes/catalog.hpp"
#include "variants.hpp"

namespace farfield::bench {
namespace {

/// The 64 samples of a reference that is twice as large must fit into a renderer's 16,000.
constexpr int largest_size_px = 1000;

std::vector<std::string> names_of_variants() {
    std::vector<std::string> names;
    for (const AnyVariant& variant : all_variants()) names.push_back(variant.name);
    return names;
}

std::string list() {
    std::ostringstream text;
    const auto tell = [&](const char* what, const std::vector<std::string>& names) {
        text << what << ":";
        for (const std::string& name : names) text << " " << name;
        text << "\n";
    };
    tell("scenes", scenes::names());
    tell("growth", growth_names());
    tell("variants", names_of_variants());
    return text.str();
}

std::vector<std::string> known_names(const char* what, const std::vector<std::string>& asked,
                                     const std::vector<std::string>& known) {
    if (asked == std::vector<std::string>{"all"}) return known;
    if (asked == std::vector<std::string>{"none"}) return {};
    std::vector<std::string> result;
    for (const std::string& name : asked) {
        if (std::find(known.begin(), known.end(), name) == known.end()) {
            throw UsageError("no " + std::string(what) + " '" + name + "'; --list shows them");
        }
        if (std::find(result.begin(), result.end(), name) == result.end()) result.push_back(name);
    }
    return result;
}

void check_numbers(const Options& options) {
    for (const double d : options.distances) {
        if (!(d > 0 && d <= 1e6)) throw UsageError("--distances must be above 0 and at most 1000000 radii");
    }
    for (const double t : options.tolerances_px) {
        if (!(t >= 0 && t <= 1e6)) throw UsageError("--tolerances must be from 0 to 1000000 pixels");
    }
    for (const int s : options.samples) {
        int side = 1;
        while (side * side < s && side < 8) ++side;
        if (side * side != s) throw UsageError("--samples must be 1, 4, 9, 16, 25, 36, 49 or 64");
    }
    if (!std::isfinite(options.angle_degrees)) throw UsageError("--angle must be a finite number of degrees");
    if (options.repetitions < 1 || options.repetitions > 10'000) {
        throw UsageError("--repetitions must be from 1 to 10000");
    }
    if (options.size_px < 8 || options.size_px > largest_size_px) {
        throw UsageError("--size must be from 8 to " + std::to_string(largest_size_px) + " pixels");
    }
}

}  // namespace

std::optional<Options> parse_options(int argc, const char* const* argv, std::string& answer) {
    Options options;
    std::string out, from;
    bool wants_list = false;
    CLI::App app(
        "Measures every variant over scenes, distances and tolerances; writes chart.csv, charts (with gnuplot) and "
        "index.html.",
        "chart");
    app.option_defaults()->multi_option_policy(CLI::MultiOptionPolicy::TakeLast);
    const auto add_list = [&](const std::string& name, auto& to, const char* help, const char* type) {
        return app.add_option(name, to, help)
            ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll)
            ->delimiter(',')
            ->type_name(type)
            ->allow_extra_args(false);
    };
    auto* const scenes = add_list("--scenes", options.scenes, "time against error: all, none or names", "NAME,...");
    auto* const growth =
        add_list("--growth", options.growth, "time against primitives: all, none or names", "NAME,...");
    auto* const variants = add_list("--variants", options.variants, "all or names; exact comes always", "NAME,...");
    auto* const distances =
        add_list("--distances", options.distances, "eye to center, in halves of the scene's largest side", "D,...");
    app.add_option("--angle", options.angle_degrees, "degrees off the front, about the up axis")->type_name("DEG");
    auto* const tolerances = add_list("--tolerances", options.tolerances_px, "errors stand-ins may have", "PX,...");
    auto* const samples =
        add_list("--samples", options.samples, "of variants, a pixel: squares up to 64; with masks always 64", "N,...");
    auto* const repetitions =
        app.add_option("--repetitions", options.repetitions, "frames of each kind to time")->type_name("N");
    auto* const size = app.add_option("--size", options.size_px, "of the pictures, in pixels")->type_name("N");
    app.add_flag("--quick", options.is_quick, "less of everything that is not asked for: two minutes");
    app.add_option("--out", out, "where everything goes (default out/chart, or where --from lies)")->type_name("DIR");
    auto* const from_option = app.add_option("--from", from, "measure nothing, draw this again")->type_name("CSV");
    app.add_flag("--list", wants_list, "show scenes, growth series and variants");
    try {
        app.parse(argc, argv);
    } catch (const CLI::CallForHelp&) {
        answer = app.help();
        return std::nullopt;
    } catch (const CLI::ParseError& error) {
        throw UsageError(error.what());
    }
    if (wants_list) {
        answer = list();
        return std::nullopt;
    }
    const bool quick = options.is_quick;
    using Names = std::vector<std::string>;
    using Numbers = std::vector<double>;
    if (!*scenes) options.scenes = quick ? Names{"tree", "forest"} : default_scenes();
    if (!*growth) options.growth = quick ? Names{"tree"} : Names{"all"};
    if (!*variants) options.variants = {"all"};
    if (!*distances) options.distances = quick ? Numbers{3.5, 14} : Numbers{1.75, 3.5, 7, 14, 28, 56};
    if (!*tolerances) options.tolerances_px = quick ? Numbers{0.5, 1, 2, 4} : Numbers{0.25, 0.5, 1, 2, 4, 8};
    if (!*samples) options.samples = std::vector{1, 4};
    if (!*repetitions) options.repetitions = quick ? 5 : 7;
    if (!*size) options.size_px = quick ? 160 : 256;
    options.scenes = known_names("scene", options.scenes, scenes::names());
    options.growth = known_names("growth series", options.growth, growth_names());
    options.variants = known_names("variant", options.variants, names_of_variants());
    check_numbers(options);
    if (*from_option) options.from_csv = from;
    options.directory = !out.empty()       ? std::filesystem::path(out)
                        : options.from_csv ? options.from_csv->parent_path()
                                           : std::filesystem::path("out/chart");
    if (options.directory.empty()) options.directory = ".";
    return options;
}

}  // namespace farfield::bench
