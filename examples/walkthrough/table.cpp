#include <algorithm>
#include <array>
#include <cmath>
#include <iomanip>
#include <ostream>
#include <sstream>

#include "result.hpp"

namespace walkthrough {
namespace {

constexpr std::size_t columns = 12;
using Row = std::array<std::string, columns>;

std::string number(double value, int decimals, const char* unit = "", bool with_plus = false) {
    if (!std::isfinite(value)) return "-";
    std::ostringstream text;
    text << (with_plus ? std::showpos : std::noshowpos) << std::fixed << std::setprecision(decimals) << value << unit;
    return text.str();
}

Row row_of(const Result& r, double stored_primitives) {
    return {r.name,
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
    for (const Result& r : results) rows.push_back(row_of(r, double(stored_primitives(setting.scene))));
    std::array<std::size_t, columns> widths{};
    for (const Row& row : rows) {
        for (std::size_t c = 0; c < columns; ++c) widths[c] = std::max(widths[c], row[c].size());
    }
    out << setting.name << ": " << farfield::scenes::triangle_count(setting.scene) << " triangles, "
        << stored_primitives(setting.scene) << " primitives in " << farfield::scenes::bytes(setting.scene) << " bytes; "
        << options.width << "x" << options.height << " pixels, " << options.samples << " samples each, "
        << options.frames << " frames, " << options.tolerance_px << " px tolerance\n\n";
    for (const Row& row : rows) {
        out << std::left << std::setw(int(widths[0])) << row[0] << std::right;
        for (std::size_t c = 1; c < columns; ++c) out << "  " << std::setw(int(widths[c])) << row[c];
        out << "\n";
    }
    out << "\nTimes are medians on one thread; exact is drawn right before each frame of a variant. Errors are "
           "against\n"
           "exact at 64 samples a pixel, flip as seen at 67 pixels a degree.\n";
}

}  // namespace walkthrough
