#include "html.hpp"

#include <algorithm>
#include <fstream>
#include <stdexcept>
#include <string_view>

#include "equal_error_table.hpp"
#include "gnuplot.hpp"
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

constexpr std::string_view introduction = R"(
<p>Every point is a variant at one tolerance. A line goes through the points of one number of samples a pixel; larger
points have more. <b>exact</b> is there at 1, 4, 16 and 64 samples. What ends in <b>masks</b> is drawn with coverage
masks at 64 samples, <b>by-table</b> with the paper's quantized edges instead of exact ones, all else with a z-buffer. Errors are against exact pictures of 256 samples a
pixel, over the rectangle that the object takes. Times are medians, bars are quartiles; variants and exact were drawn in
turns in one run, and every speed-up is a median of pairs. Both axes are logarithmic, and down to the left is better. The
yellow line is the Pareto front: nothing else measured is both as fast and as accurate.</p>
<p>All numbers: <a href="chart.csv">chart.csv</a>, columns <a href="#columns">below</a>. Charts are drawn again by the
scripts in <code>charts/</code>.</p>
)";

constexpr std::string_view about_equal_error = R"(
<p>For each variant the largest tolerance measured that keeps the bound (nothing is interpolated), at the number of
samples where that is fastest: the speed-up over exact at one sample a pixel, whether that keeps the bound or not, and in
parentheses over exact with as many samples as it needs to keep it. A dash: not kept.</p>
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
)";

class Page {
  public:
    Page(std::ostream& out, const std::vector<Row>& rows, const std::vector<Chart>& charts,
         const std::filesystem::path& directory)
        : out_(out), rows_(rows), charts_(charts), directory_(directory) {}

    void write() const {
        out_
            << "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<title>farfield</title>\n<style>"
            << style << "</style>\n</head>\n<body>\n<h1>Speed against accuracy</h1>" << introduction;
        if (!by_view(rows_, "accuracy").empty()) {
            equal_error("RMSE", &Row::rmse, rmse_bound);
            equal_error("FLIP", &Row::flip, flip_bound);
        }
        std::vector<std::string> scenes;
        for (const Row& row : rows_) {
            if (std::find(scenes.begin(), scenes.end(), row.scene) == scenes.end()) scenes.push_back(row.scene);
        }
        for (const std::string& scene : scenes) write(scene);
        out_ << "<h2 id=\"columns\">Columns of chart.csv</h2>\n<table>\n";
        for (const Column& column : columns) {
            out_ << "<tr><th>" << column.name << "</th><td>" << escaped(column.meaning) << "</td></tr>\n";
        }
        out_ << "</table>\n</body>\n</html>\n";
    }

  private:
    void equal_error(const char* name, Row::Number Row::*error, double bound) const {
        out_ << "<h2>Faster at equal error: " << name << " at most " << csv_number(bound) << "</h2>"
             << about_equal_error << "<div class=\"scroll\"><table>\n";
        const Table table = equal_error_table(rows_, error, bound);
        for (const auto& row : table.rows) {
            const char* cell = &row == table.rows.data() ? "th" : "td";
            out_ << "<tr>";
            for (const std::string& text : row) out_ << "<" << cell << ">" << escaped(text) << "</" << cell << ">";
            out_ << "</tr>\n";
        }
        out_ << "</table></div>\n";
    }

    void write(const std::string& scene) const {
        out_ << "<h2>" << escaped(scene) << "</h2>\n";
        for (const Chart& chart : charts_) {
            const std::string file = svg_file(chart).generic_string();
            if (chart.scene != scene || !exists(file)) continue;
            out_ << "<p><img src=\"" << escaped(file) << "\" alt=\"" << escaped(chart.title) << "\"></p>\n";
        }
        const std::string reference = picture_file(scene, reference_name).generic_string();
        if (!exists(reference)) return;
        out_ << "<h3>Pictures</h3>\n<p>Drawn at the tolerance nearest to 1 pixel, from the distance nearest to 3.5 "
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

void write_html(const std::vector<Row>& rows, const std::vector<Chart>& charts,
                const std::filesystem::path& directory) {
    const std::filesystem::path file = directory / "index.html";
    std::ofstream out(file);
    Page(out, rows, charts, directory).write();
    out.flush();
    if (!out) throw std::runtime_error("could not write " + file.string());
}

}  // namespace farfield::bench
