#include "options.hpp"

#include <algorithm>
#include <charconv>
#include <CLI/CLI.hpp>
#include <cmath>
#include <sstream>
#include <string_view>

#include "scenes/catalog.hpp"
#include "scenes/generate/island.hpp"
#include "variants.hpp"

namespace walkthrough {
namespace {

using farfield::scenes::name_of;
using farfield::scenes::renderer_kinds;
using farfield::scenes::RendererKind;

/// One a RendererKind, in their order.
constexpr std::string_view renderer_descriptions[] = {
    "scan conversion with a depth a sample",
    "hierarchical tiling with coverage masks, 1 or 64 samples a pixel (Greene 1996)",
    "the z-buffer under a pyramid that tells what is hidden (Greene, Kass and Miller 1993)",
    "back to front, overwriting: bsp and octree-of-bsps only (as Greene 1996, section 9 compares with)",
    "OpenGL 4.5 core without a window, samples as of the z-buffer; --threads 1",
};
static_assert(std::size(renderer_descriptions) == renderer_kinds.size());
constexpr int frames_of_a_flight = 48;
constexpr int frames_of_a_fixed_view = 21;
/// The reference has eight samples on a pixel's side, and the z-buffer takes 16,000 on an image's.
constexpr int largest_side_px = 2000;

std::string in_quotes(std::string_view s) {
    return "'" + std::string(s) + "'";
}

std::string list() {
    std::ostringstream text;
    text << "scenes:\n";
    for (const std::string& name : farfield::scenes::names()) text << "  " << name << "\n";
    text << "  FILE                    .off .oogl .ply .obj .gltf .glb .pdb .ent .cif .mmcif .xyz\n"
            "                          .pts .pcd .dump .lammpstrj .data .lmp .csv, each also packed (.gz)\n";
    text << "variants:\n";
    for (const Variant& v : variants()) {
        text << "  " << v.name << std::string(24 - v.name.size(), ' ') << v.description << "\n";
    }
    text << "renderers:\n";
    for (const RendererKind kind : renderer_kinds) {
        const std::string_view name = name_of(kind);
        text << "  " << name << std::string(24 - name.size(), ' ') << renderer_descriptions[std::size_t(kind)] << "\n";
    }
    return text.str();
}

std::string names_drawn_by(RendererKind renderer) {
    std::string names;
    for (const Variant& v : variants()) {
        if (v.obstacle(renderer).empty()) names.append(names.empty() ? "" : ", ").append(v.name);
    }
    return names;
}

/// "all" that the renderer draws, or names with commas between them. Exact comes first, asked for or not.
std::vector<std::string> parse_variants(const std::string& names, RendererKind renderer) {
    std::vector<std::string> result{"exact"};
    const auto add = [&](std::string_view name) {
        if (std::find(result.begin(), result.end(), name) == result.end()) result.emplace_back(name);
    };
    if (names == "all") {
        for (const Variant& v : variants()) {
            if (v.obstacle(renderer).empty()) add(v.name);
        }
        return result;
    }
    std::istringstream rest(names + ",");
    for (std::string name; std::getline(rest, name, ',');) {
        const Variant* const variant = find_variant(name);
        if (variant == nullptr) throw UsageError("no variant " + in_quotes(name) + "; --list shows them");
        if (const std::string_view obstacle = variant->obstacle(renderer); !obstacle.empty()) {
            throw UsageError("the renderer " + in_quotes(name_of(renderer)) + " " + std::string(obstacle) +
                             ", so not " + in_quotes(name) + "; it draws " + names_drawn_by(renderer));
        }
        add(name);
    }
    return result;
}

glm::vec3 parse_up(const std::string& text) {
    const bool is_negative = text.size() == 2 && text[0] == '-';
    const std::size_t axis = std::string_view("xyz").find(is_negative ? text[1] : text.empty() ? '?' : text[0]);
    if (axis == std::string_view::npos || (text.size() != 1 && !is_negative)) {
        throw UsageError("--up must be x, y, z, -x, -y or -z, not " + in_quotes(text));
    }
    glm::vec3 up(0);
    up[int(axis)] = is_negative ? -1.0f : 1.0f;
    return up;
}

void parse_size(std::string_view text, Options& options) {
    const char* const end = text.data() + text.size();
    const auto width = std::from_chars(text.data(), end, options.width);
    bool good = width.ec == std::errc() && width.ptr != end && *width.ptr == 'x';
    if (good) {
        const auto height = std::from_chars(width.ptr + 1, end, options.height);
        good = height.ec == std::errc() && height.ptr == end;
    }
    const auto fits = [](int side) { return side >= 1 && side <= largest_side_px; };
    if (!good || !fits(options.width) || !fits(options.height)) {
        throw UsageError("--size must be WIDTHxHEIGHT, each from 1 to " + std::to_string(largest_side_px) + ", not " +
                         in_quotes(text));
    }
}

RendererKind parse_renderer(std::string_view name) {
    for (const RendererKind kind : renderer_kinds) {
        if (name_of(kind) == name) return kind;
    }
    throw UsageError("no renderer " + in_quotes(name) + "; --list shows those that there are");
}

void parse_samples(std::string_view text, Options& options) {
    if (text == "auto") {
        options.more_samples = options.renderer == RendererKind::coverage ? std::vector{64} : std::vector{4, 16};
        return;
    }
    const char* const end = text.data() + text.size();
    const auto number = std::from_chars(text.data(), end, options.samples);
    if (number.ec != std::errc() || number.ptr != end) {
        throw UsageError("--samples must be a number or auto, not " + in_quotes(text));
    }
}

std::optional<farfield::WantedError> parse_error(const std::string& text) {
    if (text == "none") return std::nullopt;
    if (text == "point-sampling") return farfield::WantedError{};
    double rmse = 0;
    const char* const end = text.data() + text.size();
    const auto number = std::from_chars(text.data(), end, rmse);
    if (number.ec != std::errc() || number.ptr != end || !(rmse > 0 && rmse <= 1)) {
        throw UsageError("--error must be point-sampling, none, or an RMSE above 0 and at most 1, not " +
                         in_quotes(text));
    }
    return farfield::WantedError{rmse};
}

void check_numbers(const Options& options) {
    int side = 1;
    while (side * side < options.samples && side < 8) ++side;
    if (side * side != options.samples) {
        throw UsageError("--samples must be 1, 4, 9, 16, 25, 36, 49 or 64, not " + std::to_string(options.samples));
    }
    if (options.renderer == RendererKind::coverage && options.samples != 1 && options.samples != 64) {
        throw UsageError("--samples must be 1 or 64 with --renderer coverage, not " + std::to_string(options.samples));
    }
    if (options.renderer == RendererKind::opengl && options.threads != 1) {
        throw UsageError("--renderer opengl draws on one thread: leave --threads out");
    }
    if (options.threads < 1 || options.threads > 256) {
        throw UsageError("--threads must be from 1 to 256, not " + std::to_string(options.threads));
    }
    if (options.copies < 1 || options.copies > 1'000'000) throw UsageError("--copies must be from 1 to 1000000");
    if (options.frames < 1 || options.frames > 1'000'000) throw UsageError("--frames must be from 1 to 1000000");
    if (options.distance && !(*options.distance > 0 && *options.distance <= 1e6)) {
        throw UsageError("--distance must be above 0 and at most 1000000 radii");
    }
    if (options.cache_mib < 1 || options.cache_mib > (1u << 20))
        throw UsageError("--cache must be from 1 to 1048576 MiB");
    if (!std::isfinite(options.angle_degrees)) throw UsageError("--angle must be a finite number of degrees");
    if (options.budget_ms) {
        if (!(*options.budget_ms > 0 && *options.budget_ms <= 1e6)) {
            throw UsageError("--budget-ms must be above 0 and at most 1000000");
        }
        if (options.threads != 1) throw UsageError("--budget-ms is kept by one thread: leave --threads out");
    }
    if (!(options.tolerance_px >= 0) || !std::isfinite(options.tolerance_px)) {
        throw UsageError("--tolerance must be 0 or more pixels");
    }
}

}  // namespace

std::optional<Options> parse_options(int argc, const char* const* argv, std::string& answer) {
    Options options;
    std::string variant_names = "color-cube", renderer = "z-buffer", wanted_error = "point-sampling", up, size, out,
                json, path, samples = "1";
    double budget_ms = 0, distance = 0;
    bool wants_list = false;

    CLI::App app("Draws a scene exactly and with far fields, and says what that costs and gains.", "walkthrough");
    app.option_defaults()->multi_option_policy(CLI::MultiOptionPolicy::TakeLast);
    app.add_option("--scene", options.scene, "name of a generated scene, a file, or the address of a file of pages")
        ->type_name("NAME|FILE|URL");
    app.add_option("--copies", options.copies, "of the scene, each turned, in the rows of a square (default 1)")
        ->type_name("N");
    const auto* const up_option =
        app.add_option("--up", up, "what is up in the file: x, y (if nothing is said), z, or one of them with -")
            ->type_name("AXIS");
    app.add_option("--variant", variant_names, "names with commas between them, or all; exact always comes first")
        ->type_name("NAME[,NAME...]");
    app.add_option("--renderer", renderer, "what draws: z-buffer, coverage, hierarchical-z, painter or opengl")
        ->type_name("NAME");
    app.add_option("--samples", samples,
                   "samples a pixel of what is timed: a square up to 64, of coverage 1 or 64; auto: exact 1, and of "
                   "variants what is cheapest at --error")
        ->type_name("N");
    app.add_option("--threads", options.threads, "that draw a frame, in bands of its rows (default 1)")->type_name("N");
    app.add_option("--size", size, "of the images in pixels (default 640x360)")->type_name("WxH");
    app.add_option("--frames", options.frames,
                   "how many (default 48 on a flight, 1200 over shade-island, 21 from one place)")
        ->type_name("N");
    const auto* const distance_option =
        app.add_option("--distance", distance, "look at the scene's center from D times its radius; else fly through")
            ->type_name("D");
    app.add_option("--angle", options.angle_degrees, "degrees off the front, about the up axis")->type_name("DEG");
    const auto* const error_option =
        app.add_option(
               "--error", wanted_error,
               "what tolerances are chosen by: point-sampling (no more error than exact has at these samples), an "
               "RMSE of colors from 0 to 1, or none (1 px); exact is drawn where nothing pays")
            ->type_name("WHAT");
    const auto* const tolerance_option =
        app.add_option("--tolerance", options.tolerance_px, "error in pixels that stand-ins may have; chooses nothing")
            ->type_name("PX");
    const auto* const budget_option =
        app.add_option("--budget-ms", budget_ms,
                       "time that a frame may take; it is drawn as well as that allows, to --tolerance at best")
            ->type_name("MS");
    app.add_option("--cache", options.cache_mib,
                   "MiB for pages, where the scene is a file of pages (FILE.farfield, or its http:// address)")
        ->type_name("MIB");
    app.add_option("--path", path, "fly this instead: a path that the viewer has recorded")->type_name("FILE");
    app.add_option("--out", out, "write pictures of up to 8 frames here")->type_name("DIR");
    app.add_option("--json", json, "write the table here")->type_name("FILE");
    app.add_flag("--measure", options.measures_errors,
                 "of a file of pages: measure what --error chooses from at this --size, and put it into the file, for "
                 "all later runs");
    app.add_flag("--list", wants_list, "show scenes, variants and renderers");
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
    options.renderer = parse_renderer(renderer);
    options.variants = parse_variants(variant_names, options.renderer);
    options.error = parse_error(wanted_error);
    parse_samples(samples, options);
    if (tolerance_option->count() != 0) {
        if (error_option->count() != 0 && options.error) {
            throw UsageError("--tolerance says what --error would choose: give one of them");
        }
        options.error.reset();
    }
    if (budget_option->count() != 0) {
        if (error_option->count() != 0 && options.error) {
            throw UsageError("--budget-ms and --error both choose what is drawn: give one of them");
        }
        options.error.reset();
        options.budget_ms = budget_ms;
    }
    if (up_option->count() != 0) options.up = parse_up(up);
    if (!size.empty()) parse_size(size, options);
    if (distance_option->count() != 0) options.distance = distance;
    if (app.get_option("--frames")->count() == 0) {
        options.frames = options.distance ? frames_of_a_fixed_view
                         : options.scene == "shade-island" && options.copies == 1
                             ? farfield::scenes::frames_of_island_walk
                             : frames_of_a_flight;
    }
    if (!path.empty()) {
        if (options.distance) throw UsageError("--path and --distance both say where the camera is: give one of them");
        options.path = path;
    }
    if (!out.empty()) options.out_directory = out;
    if (!json.empty()) options.json_file = json;
    options.error_is_asked = error_option->count() != 0 && options.error;
    if (options.measures_errors && !options.error) {
        throw UsageError("--measure is for what --error chooses from: there is nothing to choose");
    }
    if (!options.more_samples.empty() && !options.error) {
        throw UsageError("--samples auto is chosen by --error: there is nothing to choose by");
    }
    check_numbers(options);
    return options;
}

}  // namespace walkthrough
