// The table "faster at equal error", for the page and for the terminal.
#pragma once

#include <string>
#include <vector>

#include "csv.hpp"
#include "summary.hpp"

namespace farfield::bench {

/// Cells as text; the first row is the head.
struct Table {
    std::vector<std::vector<std::string>> rows;
};

inline std::string two_digits(double value) {
    char text[64];
    const auto end = std::to_chars(text, text + sizeof text, value, std::chars_format::general, value < 100 ? 2 : 3);
    return std::string(text, end.ptr);
}

/// A line for each scene and view: the error of exact at one sample; how many samples exact needs to keep the bound;
/// then for each variant the largest tolerance that keeps it (at other than one sample a pixel these are told), the
/// speed-up over exact at one sample and, in parentheses, over exact at equal error, that is at as many samples as it
/// needs. A dash where nothing keeps it.
inline Table equal_error_table(const std::vector<Row>& rows, Row::Number Row::*error, double bound) {
    const std::vector<ViewGroup> groups = by_view(rows, "accuracy");
    std::vector<const Row*> all;
    for (const ViewGroup& group : groups) all.insert(all.end(), group.rows.begin(), group.rows.end());
    std::vector<std::string> variants = variant_names(all);
    std::erase(variants, "exact");
    Table table;
    table.rows.push_back({"scene", "view", "exact at 1: error", "exact: samples"});
    table.rows[0].insert(table.rows[0].end(), variants.begin(), variants.end());
    for (const ViewGroup& group : groups) {
        std::vector<std::string>& line = table.rows.emplace_back();
        line = {group.scene, group.view, "-", "-"};
        for (const Row* row : group.rows) {
            if (row->variant == "exact" && row->samples == 1 && row->*error) line[2] = two_digits(*(row->*error));
        }
        const Row* exact = nullptr;  // with the fewest samples; noise may make more of them look faster
        for (const Row* row : group.rows) {
            const bool keeps_bound = row->variant == "exact" && row->*error && *(row->*error) <= bound;
            if (keeps_bound && (!exact || row->samples < exact->samples)) exact = row;
        }
        if (exact && exact->samples) line[3] = csv_number(*exact->samples);
        for (const std::string& variant : variants) {
            const Row* best = fastest_within(group.rows, variant, error, bound);
            std::string cell = "-";
            if (best && best->speedup) {
                cell = best->tolerance_px ? csv_number(*best->tolerance_px) + " px" : std::string();
                if (best->samples != 1) {
                    cell += (cell.empty() ? "" : ", ") + csv_number(best->samples.value_or(1)) + " samples";
                }
                cell += (cell.empty() ? "" : ": ") + two_digits(*best->speedup) + "x";
                if (const auto fair = speedup_at_equal_error(best, exact)) cell += " (" + two_digits(*fair) + "x)";
            }
            line.push_back(cell);
        }
    }
    return table;
}

}  // namespace farfield::bench
