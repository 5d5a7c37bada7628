#include <algorithm>
#include <cmath>
#include <iomanip>
#include <limits>
#include <ostream>
#include <sstream>
#include <vector>

#include "result.hpp"

namespace walkthrough {
namespace {

using Row = std::vector<std::string>;

std::string number(double value, int decimals, const char* unit = "", bool with_plus = false) {
    if (!std::isfinite(value)) return "-";
    std::ostringstream text;
    text << (with_plus ? std::showpos : std::noshowpos) << std::fixed << std::setprecision(decimals) << value << unit;
    return text.str();
}

std::string tolerance(float px) {
    std::string text = number(double(px), 2);
    text.erase(text.find_last_not_of('0') + 1);
    if (text.back() == '.') text.pop_back();
    return text + " px";
}

/// Two columns more where any row has cells of coverage masks.
Row row_of(const Result& r, double stored_primitives, bool has_cells, bool tells_samples) {
    Row row{r.name,
            number(r.build.seconds, 2),
            number(double(r.build.bytes) / stored_primitives, 1),
            r.choice ? words(*r.choice, tells_samples) : "-",
            number(median(r.exact_ms), 2),
            number(median(r.paired_ms), 2),
            number(speedup(r), 2, "x"),
            number(r.errors.rmse(), 4),
            number(r.errors.ssim(), 4),
            number(r.errors.flip(), 4),
            number(100 * r.errors.coverage_bias(), 2, " %", true),
            number(r.drawn.approximations, 0),
            number(r.drawn.primitives, 0)};
    if (has_cells) {
        row.push_back(r.coverage ? number(r.coverage->tiling, 3) : "-");
        row.push_back(r.coverage ? number(r.coverage->asking, 3) : "-");
    }
    return row;
}

std::uint64_t stored_primitives(const farfield::scenes::Scene& scene) {
    std::uint64_t count = 0;
    for (const auto& group : scene.groups) count += group.triangles.size() + group.placements.size();
    return count;
}

void print(std::ostream& out, const std::vector<Row>& rows) {
    std::vector<std::size_t> widths(rows[0].size());
    for (const Row& row : rows) {
        for (std::size_t c = 0; c < row.size(); ++c) widths[c] = std::max(widths[c], row[c].size());
    }
    for (const Row& row : rows) {
        out << std::left << std::setw(int(widths[0])) << row[0] << std::right;
        for (std::size_t c = 1; c < row.size(); ++c) out << "  " << std::setw(int(widths[c])) << row[c];
        out << "\n";
    }
}

/// What each variant takes to err by no more than point sampling, and than a round number, beside exact and a plain
/// loop over all triangles.
void print_at_equal_error(std::ostream& out, const std::vector<Result>& results, bool tells_samples) {
    constexpr double round_rmse = 0.05;
    std::vector<Row> rows{{"at equal error", "point sampling:", "rmse", "ms", "exact/", "plain/", "rmse 0.05:", "rmse",
                           "ms", "exact/", "plain/"}};
    const auto& plain = results.front().plain;
    // Of one frame's worth of exact, so that each ratio is of times that were taken in turns.
    const double plain_to_exact = plain ? plain->ms / plain->exact_ms : std::numeric_limits<double>::quiet_NaN();
    const auto add = [&](Row& row, const std::string& what, double rmse, double ms, double speedup) {
        row.insert(row.end(), {what, number(rmse, 4), number(ms, 2), number(speedup, 2, "x"),
                               number(speedup * plain_to_exact, speedup * plain_to_exact < 99.5 ? 2 : 0, "x")});
    };
    bool has_choices = false;
    for (const Result& r : results) has_choices = has_choices || r.measured;
    if (!has_choices) return;
    if (plain) {
        const double rmse = results.front().errors.rmse();
        for (const bool is_exact : {false, true}) {
            Row row{is_exact ? "exact" : "plain loop"};
            const double ms = is_exact ? plain->exact_ms : plain->ms;
            add(row, "every triangle", rmse, ms, plain->exact_ms / ms);
            if (rmse <= round_rmse) {
                add(row, "every triangle", rmse, ms, plain->exact_ms / ms);
            } else {
                row.insert(row.end(), {"errs more", "-", "-", "-", "-"});
            }
            rows.push_back(std::move(row));
        }
    }
    for (const Result& r : results) {
        if (!r.measured) continue;
        Row row{r.name};
        for (const farfield::WantedError wanted : {farfield::WantedError{}, farfield::WantedError{round_rmse}}) {
            const Choice choice = r.measured->choice_for(wanted);
            const farfield::ToleranceTrial& trial = choice.tolerance.trial;
            add(row, words(choice, tells_samples), trial.rmse, choice.cost * r.measured->exact_ms, 1 / choice.cost);
        }
        rows.push_back(std::move(row));
    }
    out << "\n";
    print(out, rows);
    out << "\nOver the frames that are compared: the largest tolerance that errs by no more than exact itself at "
           "these\n"
           "samples, and than 0.05, and costs less than exact, which else is drawn; \"as wanted\": of cells those "
           "alone\n"
           "that are expected to err no more than point sampling (View::wanted). Times are the least of several.\n"
           "exact/, plain/: how many times as long exact takes, which is culled, and a plain z-buffer's loop over all\n"
           "triangles without a hierarchy";
    if (plain && plain->drawn_triangles < plain->triangles) {
        out << ",\ncounted: " << plain->drawn_triangles << " of " << plain->triangles
            << " triangles are drawn, and their time is multiplied";
    }
    out << ".\n";
}

}  // namespace

std::string words(const Choice& choice, bool tells_samples) {
    if (tells_samples) {
        return words(choice, false) + " at " + std::to_string(choice.samples) +
               (choice.samples == 1 ? " sample" : " samples");
    }
    const std::string px = tolerance(choice.tolerance.trial.tolerance_px) + (choice.asks_wanted ? ", as wanted" : "");
    switch (choice.tolerance.reason) {
        case farfield::ToleranceReason::pays:
            return px;
        case farfield::ToleranceReason::only_way:
            return px + " (exact errs more)";
        case farfield::ToleranceReason::nothing_pays:
            return "exact (nothing pays)";
        case farfield::ToleranceReason::nothing_keeps:
            return "exact (no other keeps it)";
        case farfield::ToleranceReason::cannot_be_had:
            return "exact (cannot be had)";
        case farfield::ToleranceReason::nothing_tried:
            break;
    }
    return "exact (nothing seen)";
}

void print_table(std::ostream& out, const Setting& setting, const Options& options,
                 const std::vector<Result>& results) {
    std::vector<Row> rows{{"variant", "build", "bytes per", "tolerance", "exact", "frame", "speed-up", "rmse", "ssim",
                           "flip", "coverage", "stand-ins", "triangles"},
                          {"", "s", "primitive", "", "ms", "ms", "", "", "", "", "bias", "drawn", "drawn"}};
    const bool has_cells =
        std::any_of(results.begin(), results.end(), [](const Result& r) { return r.coverage.has_value(); });
    if (has_cells) {
        for (const char* kind : {"tiling", "asking"}) {
            rows[0].push_back(kind);
            rows[1].push_back("cells/px");
        }
    }
    const bool tells_samples = !options.more_samples.empty();
    for (const Result& r : results) {
        rows.push_back(row_of(r, double(stored_primitives(setting.scene)), has_cells, tells_samples));
    }
    out << setting.name << ": " << farfield::scenes::triangle_count(setting.scene) << " triangles, "
        << stored_primitives(setting.scene) << " primitives in " << farfield::scenes::bytes(setting.scene) << " bytes; "
        << options.width << "x" << options.height << " pixels, " << options.samples << " samples each"
        << (tells_samples ? ", or as many as are cheapest at the error that is wanted," : "") << " by "
        << name_of(options.renderer) << ", " << options.frames << " frames";
    if (!options.error) out << ", " << options.tolerance_px << " px tolerance";
    if (options.budget_ms) out << ", at most " << *options.budget_ms << " ms a frame";
    out << "\n\n";
    print(out, rows);
    out << "\nTimes are medians on "
        << (options.threads == 1 ? "one thread" : std::to_string(options.threads) + " threads")
        << "; exact is drawn right before each frame of a variant"
        << (results.front().frame_ms.size() < std::size_t(options.frames)
                ? ", but as it is\nslow, only the frames that are compared, once"
                : "")
        << ". Errors are "
           "against\n"
           "exact at 64 samples a pixel, flip as seen at 67 pixels a degree.\n";
    if (has_cells) {
        out << "Cells are those of the coverage pyramid that tiling polygons, and asking whether cells of the "
               "hierarchy "
               "are\nhidden, visits for a pixel.\n";
    }
    for (const Result& r : results) {
        if (!options.budget_ms || &r == &results.front()) continue;
        const auto above = [&](double limit) {
            return std::count_if(r.frame_ms.begin(), r.frame_ms.end(), [&](double ms) { return ms > limit; });
        };
        out << "Of " << r.frame_ms.size() << " frames of " << r.name << ", " << above(*options.budget_ms)
            << " took longer than the budget, " << above(1.2 * *options.budget_ms) << " longer than 1.2 times it"
            << (options.distance ? ": the view stands still, and each frame of it is finer than the last" : "")
            << ".\n";
    }
    for (const Result& r : results) {
        if (r.build.cells_over_piece_budget == 0) continue;
        out << "Polygons cross one another so much that " << r.name << " leaves " << r.build.cells_over_piece_budget
            << " cells uncut, to stay within its memory: they are\nin no strict order.\n";
    }
    print_at_equal_error(out, results, tells_samples);
    if (!results.empty() && results.front().renderer != options.renderer) {
        out << "Exact is drawn by " << name_of(results.front().renderer) << ", for it is not in the order that "
            << name_of(options.renderer) << " needs.\n";
    }
}

}  // namespace walkthrough
