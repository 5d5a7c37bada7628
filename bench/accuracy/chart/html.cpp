#include "html.hpp"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <stdexcept>
#include <string_view>
#include <variant>

#include "equal_error_table.hpp"
#include "gnuplot.hpp"
#include "page_script.hpp"
#include "pictures.hpp"
#include "report/picture.hpp"

namespace farfield::bench {
namespace {

std::string escaped(std::string_view text) {
    std::string result;
    for (const char c : text) {
        if (c == '<') {
            result += "&lt;";
        } else if (c == '&') {
            result += "&amp;";
        } else if (c == '"') {
            result += "&quot;";
        } else {
            result += c;
        }
    }
    return result;
}

/// A JSON string, fit for an HTML script element: nothing in it ends that.
std::string json(std::string_view text) {
    constexpr char digits[] = "0123456789abcdef";
    std::string result = "\"";
    for (const char c : text) {
        const auto code = static_cast<unsigned char>(c);
        if (code < 0x20 || c == '<' || c == '"' || c == '\\') {
            (result += "\\u00") += {digits[code / 16], digits[code % 16]};
        } else {
            result += c;
        }
    }
    return result + '"';
}

std::string json(const Row::Number& number) {
    return number && std::isfinite(*number) ? csv_number(*number) : "null";
}

constexpr std::string_view introduction = R"(
<p>All numbers: <a href="chart.csv">chart.csv</a>, columns <a href="#columns">below</a>. Static charts are drawn again by
the scripts in <code>charts/</code>.</p>
)";

constexpr std::string_view about_equal_error = R"(
<p>What each variant takes to err by no more than exact itself at one sample a pixel, and than a round number: the largest
tolerance that keeps this error together with all finer ones and costs less than exact, at the number of samples where
that is fastest; a frame's median time, and how many times as fast as exact at one sample, drawn right before. Where no
tolerance costs less, exact is drawn. Nothing is interpolated. A dash: nothing keeps it.</p>
)";

constexpr std::string_view about_points = R"(
<p>Every point is a variant at one tolerance. A line goes through the points of one number of samples a pixel; larger
points have more. <b>exact</b> is there at 1, 4, 16 and 64 samples; <b>peer</b> is a plain loop over all triangles. What
ends in <b>masks</b> is drawn with coverage masks at 64 samples, <b>by-table</b> with the paper's quantized edges instead
of exact ones, all else with a z-buffer. Errors are against exact pictures of 256 samples a pixel, over the rectangle that
the object takes. Times are medians, bars of static charts are quartiles; variants and exact were drawn in turns in one
run, and every speed-up is a median of pairs. Both axes are logarithmic, and down to the left is better. The yellow line is
the Pareto front: nothing else is both as fast and as accurate.</p>
)";

// Without scripts there is nothing in it, and it is not shown.
constexpr std::string_view interactive = R"(
<div id="interactive" hidden>
<p><label>Plot <select id="plots"></select></label> Point at a mark for its numbers and its picture; click to keep them,
click beside it to let go.</p>
<fieldset id="place-switches"></fieldset>
<fieldset id="variant-switches"></fieldset>
<fieldset id="samples-switches"></fieldset>
<div class="sides"><svg id="plot" viewBox="0 0 900 560"></svg><div id="details"></div></div>
</div>
)";

constexpr std::string_view style = R"(
body { font: 15px/1.45 sans-serif; margin: 2em; max-width: 110em; color: #222 }
table { border-collapse: collapse; margin: 1em 0; font-size: 13px }
td, th { border: 1px solid #ccc; padding: 2px 7px; text-align: left; white-space: nowrap }
th { background: #f3f3f3 }
img { max-width: 100%; vertical-align: top }
.scroll { overflow-x: auto }
.pictures img { width: 256px; height: 256px; image-rendering: pixelated; border: 1px solid #ccc }
figure { display: inline-block; margin: 0 14px 14px 0 }
figcaption { font-size: 13px; color: #555 }
td button { all: unset; cursor: pointer; border-bottom: 1px dotted #888 }
td button:focus-visible { outline: 2px solid #0072b2 }
fieldset { border: 1px solid #ccc; margin: 6px 0; font-size: 13px }
fieldset label { display: inline-block; margin: 0 12px 0 0; white-space: nowrap }
fieldset button { margin-right: 8px }
.swatch { display: inline-block; width: 13px; height: 10px; margin-right: 4px }
.sides { display: flex; flex-wrap: wrap; gap: 20px; align-items: flex-start }
#plot { flex: 1 1 560px; max-width: 1100px; font-size: 12px; background: #fff }
#details { flex: 0 0 420px; min-height: 560px }
#details figure { margin: 0 8px 8px 0 }
#details img { width: 200px; image-rendering: pixelated; border: 1px solid #ccc }
.grid { stroke: #ddd; fill: none }
.front { stroke: #ffd54f; stroke-width: 7; fill: none }
.line { fill: none; stroke-width: 1.5 }
.point { stroke: transparent; stroke-width: 6; pointer-events: all; cursor: pointer }
.point:focus { outline: none }
.chosen { stroke: #d00; stroke-width: 2.5 }
)";

class Page {
  public:
    Page(std::ostream& out, const std::vector<Row>& rows, const std::vector<Chart>& charts,
         const std::filesystem::path& directory)
        : out_(out), rows_(rows), charts_(charts), directory_(directory) {}

    void write() const {
        out_
            << "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<title>farfield</title>\n<style>"
            << style << "</style>\n</head>\n<body>\n<h1>Speed against accuracy</h1>\n";
        const bool has_errors = !by_view(rows_, "accuracy").empty();
        if (has_errors) equal_error("RMSE", &Row::rmse, rmse_bound, about_equal_error);
        out_ << introduction << "<h2>Every point</h2>" << about_points << interactive;
        if (has_errors) equal_error("FLIP", &Row::flip, flip_bound, "<p>As above, by another measure.</p>\n");
        out_ << "<h2>At a glance</h2>\n<p>At most " << most_lines
             << " lines a chart: exact, the peer, those that are fastest at exact's own error (RMSE) and the Pareto "
                "front "
                "of all that was measured. The plot above has the rest.</p>\n";
        std::vector<std::string> scenes;
        for (const Row& row : rows_) {
            if (std::find(scenes.begin(), scenes.end(), row.scene) == scenes.end()) scenes.push_back(row.scene);
        }
        for (const std::string& scene : scenes) write(scene);
        out_ << "<h2 id=\"columns\">Columns of chart.csv</h2>\n<table>\n";
        for (const Column& column : columns) {
            out_ << "<tr><th>" << column.name << "</th><td>" << escaped(column.meaning) << "</td></tr>\n";
        }
        out_ << "</table>\n";
        write_data();
        out_ << "<script>" << page_script << "</script>\n</body>\n</html>\n";
    }

  private:
    void equal_error(const char* name, Row::Number Row::*error, double bound, std::string_view about) const {
        out_ << "<h2>At equal error: " << name << "</h2>" << about << "<div class=\"scroll\"><table>\n";
        const Table table = equal_error_table(rows_, error, bound);
        for (const auto& row : table.rows) {
            const char* cell = &row == table.rows.data() ? "th" : "td";
            out_ << "<tr>";
            for (const TableCell& c : row) {
                out_ << "<" << cell << ">";
                if (c.row) out_ << "<button type=\"button\" data-row=\"" << c.row - rows_.data() << "\">";
                out_ << escaped(c.text) << (c.row ? "</button></" : "</") << cell << ">";
            }
            out_ << "</tr>\n";
        }
        out_ << "</table></div>\n";
    }

    /// All rows with the pictures that lie beside the page, for the script.
    void write_data() const {
        out_ << "<script type=\"application/json\" id=\"data\">{\"columns\":[";
        for (const Column& column : columns) out_ << json(column.name) << ",";
        out_ << "\"picture\",\"reference\"],\n\"shown\":[";
        std::vector<std::string> shown;
        if (!charts_.empty()) {
            for (const Series& s : charts_.front().panels.front().series) shown.push_back(json(s.label));
        }
        for (const std::string& label : shown) out_ << (&label == shown.data() ? "" : ",") << label;
        out_ << "],\n\"rows\":[";
        for (const Row& row : rows_) {
            out_ << (&row == rows_.data() ? "\n[" : ",\n[");
            for (const Column& column : columns) {
                std::visit([&](const auto field) { out_ << json(row.*field) << ","; }, column.field);
            }
            out_ << picture_or_null(point_picture_file(row)) << "," << picture_or_null(point_reference_file(row))
                 << "]";
        }
        out_ << "]}</script>\n";
    }

    std::string picture_or_null(const std::filesystem::path& file) const {
        return exists(file.generic_string()) ? json(file.generic_string()) : "null";
    }

    void write(const std::string& scene) const {
        out_ << "<h3>" << escaped(scene) << "</h3>\n";
        for (const Chart& chart : charts_) {
            const std::string file = svg_file(chart).generic_string();
            if (chart.scene != scene || !exists(file)) continue;
            out_ << "<p><img src=\"" << escaped(file) << "\" alt=\"" << escaped(chart.title) << "\"></p>\n";
        }
        const std::string reference = picture_file(scene, reference_name).generic_string();
        if (!exists(reference)) return;
        out_ << "<h4>Pictures</h4>\n<p>Drawn at the tolerance nearest to 1 pixel, from the distance nearest to 3.5 "
                "radii; differences to the reference are amplified "
             << report::difference_gain << " times.</p>\n<div class=\"pictures\">\n";
        for (const std::string& variant : variant_names(rows_of(scene))) {
            const std::string picture = picture_file(scene, variant).generic_string();
            const std::string difference = picture_file(scene, variant, "_difference").generic_string();
            if (!exists(picture) || !exists(difference)) continue;
            out_ << "<figure>";
            for (const std::string& file : {reference, picture, difference}) {
                out_ << "<img src=\"" << escaped(file) << "\" alt=\"" << escaped(file) << "\"> ";
            }
            out_ << "<figcaption>reference, " << escaped(variant) << ", difference</figcaption></figure>\n";
        }
        out_ << "</div>\n";
    }

    std::vector<const Row*> rows_of(const std::string& scene) const {
        std::vector<const Row*> result;
        for (const Row& row : rows_) {
            if (row.scene == scene && row.chart == "accuracy") result.push_back(&row);
        }
        return result;
    }

    bool exists(const std::string& file) const { return std::filesystem::exists(directory_ / file); }

    std::ostream& out_;
    const std::vector<Row>& rows_;
    const std::vector<Chart>& charts_;
    const std::filesystem::path& directory_;
};

}  // namespace

void write_html(std::ostream& out, const std::vector<Row>& rows, const std::vector<Chart>& charts,
                const std::filesystem::path& directory) {
    Page(out, rows, charts, directory).write();
}

void write_html(const std::vector<Row>& rows, const std::vector<Chart>& charts,
                const std::filesystem::path& directory) {
    const std::filesystem::path file = directory / "index.html";
    std::ofstream out(file, std::ios::binary);
    write_html(out, rows, charts, directory);
    out.flush();
    if (!out) throw std::runtime_error("could not write " + file.string());
}

}  // namespace farfield::bench
