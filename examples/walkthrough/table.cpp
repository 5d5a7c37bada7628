#include <algorithm>
#include <cmath>
#include <iomanip>
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

/// Two columns more where any row has cells of coverage masks.
Row row_of(const Result& r, double stored_primitives, bool has_cells) {
    Row row{r.name,
            number(r.build.seconds, 2),
            number(double(r.build.bytes) / stored_primitives, 1),
            number(median(r.exact_ms), 2),
            number(median(r.frame_ms), 2),
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

}  // namespace

void print_table(std::ostream& out, const Setting& setting, const Options& options,
                 const std::vector<Result>& results) {
    std::vector<Row> rows{{"variant", "build", "bytes per", "exact", "frame", "speed-up", "rmse", "ssim", "flip",
                           "coverage", "stand-ins", "triangles"},
                          {"", "s", "primitive", "ms", "ms", "", "", "", "", "bias", "drawn", "drawn"}};
    const bool has_cells =
        std::any_of(results.begin(), results.end(), [](const Result& r) { return r.coverage.has_value(); });
    if (has_cells) {
        for (const char* kind : {"tiling", "asking"}) {
            rows[0].push_back(kind);
            rows[1].push_back("cells/px");
        }
    }
    for (const Result& r : results) rows.push_back(row_of(r, double(stored_primitives(setting.scene)), has_cells));
    std::vector<std::size_t> widths(rows[0].size());
    for (const Row& row : rows) {
        for (std::size_t c = 0; c < row.size(); ++c) widths[c] = std::max(widths[c], row[c].size());
    }
    out << setting.name << ": " << farfield::scenes::triangle_count(setting.scene) << " triangles, "
        << stored_primitives(setting.scene) << " primitives in " << farfield::scenes::bytes(setting.scene) << " bytes; "
        << options.width << "x" << options.height << " pixels, " << options.samples << " samples each by "
        << name_of(options.renderer) << ", " << options.frames << " frames, " << options.tolerance_px
        << " px tolerance\n\n";
    for (const Row& row : rows) {
        out << std::left << std::setw(int(widths[0])) << row[0] << std::right;
        for (std::size_t c = 1; c < row.size(); ++c) out << "  " << std::setw(int(widths[c])) << row[c];
        out << "\n";
    }
    out << "\nTimes are medians on one thread; exact is drawn right before each frame of a variant. Errors are "
           "against\n"
           "exact at 64 samples a pixel, flip as seen at 67 pixels a degree.\n";
    if (has_cells) {
        out << "Cells are those of the coverage pyramid that tiling polygons, and asking whether cells of the "
               "hierarchy "
               "are\nhidden, visits for a pixel.\n";
    }
    for (const Result& r : results) {
        if (r.build.cells_over_piece_budget == 0) continue;
        out << "Polygons cross one another so much that " << r.name << " leaves " << r.build.cells_over_piece_budget
            << " cells uncut, to stay within its memory: they are\nin no strict order.\n";
    }
    if (!results.empty() && results.front().renderer != options.renderer) {
        out << "Exact is drawn by " << name_of(results.front().renderer) << ", for it is not in the order that "
            << name_of(options.renderer) << " needs.\n";
    }
}

}  // namespace walkthrough
