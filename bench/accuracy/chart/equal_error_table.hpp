// The table "at equal error", for the page and for the terminal.
#pragma once

#include <string>
#include <vector>

#include "csv.hpp"
#include "summary.hpp"

namespace farfield::bench {

struct TableCell {
    std::string text;
    const Row* row = nullptr;  ///< the measurement that it tells; null: none
};

/// The first row is the head.
struct Table {
    std::vector<std::vector<TableCell>> rows;
};

inline std::string two_digits(double value) {
    char text[64];
    const auto end = std::to_chars(text, text + sizeof text, value, std::chars_format::general, value < 100 ? 2 : 3);
    return std::string(text, end.ptr);
}

/// As in "2 px, 4 samples: 1.3 ms, 3.5x": the median of a frame, and of what exact at one sample took right before,
/// over it.
inline TableCell cell_of(const Row& row) {
    std::string text = row.tolerance_px ? csv_number(*row.tolerance_px) + " px" : std::string();
    if (row.samples != 1) {
        text += (text.empty() ? "" : ", ") + csv_number(row.samples.value_or(1)) + " samples";
    }
    if (!text.empty()) text += ": ";
    if (row.time_ms) text += two_digits(*row.time_ms) + " ms, ";
    return {text + two_digits(row.speedup.value_or(1)) + "x", &row};
}

inline TableCell cell_of(const EqualErrorChoice& choice) {
    if (!choice.is_exact()) return cell_of(*choice.row);
    if (choice.reason == ToleranceReason::nothing_pays) return {"exact: nothing pays", choice.row};
    if (choice.reason == ToleranceReason::nothing_keeps) return {"exact: none keeps it", choice.row};
    return {"-"};
}

/// Two lines for each scene and view: what keeps the error of exact at one sample a pixel, and what keeps `bound`.
/// Exact keeps it with more samples; the variants as at_equal_error says. A dash where nothing keeps it.
inline Table equal_error_table(const std::vector<Row>& rows, Row::Number Row::*error, double bound) {
    const std::vector<ViewGroup> groups = by_view(rows, "accuracy");
    std::vector<const Row*> all;
    for (const ViewGroup& group : groups) all.insert(all.end(), group.rows.begin(), group.rows.end());
    std::vector<std::string> variants = variant_names(all);
    std::erase(variants, "exact");
    Table table;
    table.rows.push_back({{"scene"}, {"view"}, {"error at most"}, {"exact"}});
    for (const std::string& variant : variants) table.rows[0].push_back({variant});
    for (const ViewGroup& group : groups) {
        const Row* const exact_at_one = exact_within(group.rows, error, std::nullopt);
        for (const std::optional<double> wanted : {std::optional<double>(), std::optional(bound)}) {
            std::vector<TableCell>& line = table.rows.emplace_back();
            const std::string own = exact_at_one ? two_digits(*(exact_at_one->*error)) : "-";
            line = {{group.scene}, {group.view}, {wanted ? csv_number(*wanted) : own + " (exact's own)"}};
            const Row* const exact = exact_within(group.rows, error, wanted);
            line.push_back(exact ? cell_of(*exact) : TableCell{"-"});
            for (const std::string& variant : variants) {
                line.push_back(cell_of(at_equal_error(group.rows, variant, error, wanted)));
            }
        }
    }
    return table;
}

}  // namespace farfield::bench
