#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>
#include <string_view>
#include <utility>

#include "csv.hpp"
#include "gnuplot.hpp"

namespace farfield::bench {
namespace {

// Okabe and Ito 2008: told apart by everybody. Black is the reference, gray the peer.
constexpr std::string_view palette[] = {"#000000", "#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9", "#e69f00"};
constexpr std::string_view gray = "#888888";

std::string in_quotes(std::string_view text) {
    std::string result = "'";
    for (const char c : text) result.append(c == '\'' ? 2 : 1, static_cast<unsigned char>(c) < 0x20 ? ' ' : c);
    return result + "'";
}

std::string number(double value) {
    return csv_number(value);
}

/// Color by approximation, line by what it is composed with.
std::string style_of(const std::string& label, double samples, const std::vector<std::string>& labels) {
    const auto parts = [](const std::string& l) {
        const auto end = std::min(l.find('+'), l.find(','));
        return std::pair(l.substr(0, end), end == std::string::npos ? std::string() : l.substr(end));
    };
    std::vector<std::string> bases, rests{""};
    const auto place = [](std::vector<std::string>& in, const std::string& what) {
        const auto at = std::find(in.begin(), in.end(), what);
        if (at != in.end()) return std::size_t(at - in.begin());
        in.push_back(what);
        return in.size() - 1;
    };
    for (const std::string& l : labels) {
        const auto [base, rest] = parts(l);
        if (base != "peer") place(bases, base);
        place(rests, rest);
    }
    const auto [base, rest] = parts(label);
    const std::size_t color = base == "peer" ? 0 : place(bases, base), line = place(rests, rest);
    constexpr int filled[] = {7, 5, 9, 11, 13}, open[] = {6, 4, 8, 10, 12};
    std::ostringstream style;
    style << "lc rgb '" << (base == "peer" ? gray : palette[color % std::size(palette)]) << "' lw 1.5 dt " << line + 1
          << " pt " << (line == 0 ? filled : open)[color % std::size(filled)] << " ps "
          << number(0.5 + 0.15 * std::log2(std::max(samples, 1.0)));
    return style.str();
}

/// 0.002, 50, 20 k, 1 M.
std::string label_of(double value) {
    for (const auto& [unit, name] : {std::pair(1e9, " G"), std::pair(1e6, " M"), std::pair(1e3, " k")}) {
        if (value >= 0.999 * unit) return number(std::round(value / unit)) + name;
    }
    return number(value);
}

/// A logarithmic axis over all that is drawn, bars included, with a little room; gnuplot's own would be whole decades.
void write_axis(std::ostream& out, char axis, const Panel& panel) {
    const std::size_t coordinate = axis == 'x' ? 0 : 1;
    double least = std::numeric_limits<double>::max(), most = 0;
    for (const Series& s : panel.series) {
        for (const auto& p : s.points) {
            least = std::min(least, p[coordinate]);
            most = std::max(most, p[coordinate]);
            if (axis == panel.bars) least = std::min(least, p[2]), most = std::max(most, p[3]);
        }
    }
    for (const ChartPoint& point : panel.front) {
        least = std::min(least, coordinate == 0 ? point.x : point.y);
        most = std::max(most, coordinate == 0 ? point.x : point.y);
    }
    const double room = std::pow(std::max(most / least, 2.0), 0.04);
    out << "set " << axis << "range [" << number(least / room) << ":" << number(most * room) << "]\nset " << axis
        << "tics (";
    const bool is_wide = most / least > 2000;
    const char* separator = "";
    for (int decade = int(std::floor(std::log10(least))) - 1; decade <= int(std::log10(most)) + 1; ++decade) {
        for (const int digit : {1, 2, 5}) {
            const double at = digit * std::pow(10.0, decade);
            if ((is_wide && digit != 1) || at < least / room || at > most * room) continue;
            out << separator << in_quotes(label_of(at)) << " " << number(at);
            separator = ", ";
        }
    }
    out << ")\n";
}

void write_data(std::ostream& out, const Panel& panel, std::size_t p) {
    for (std::size_t s = 0; s < panel.series.size(); ++s) {
        out << "# " << in_quotes(panel.series[s].label) << "\n$panel" << p << "series" << s << " << END\n";
        for (const auto& point : panel.series[s].points) {
            for (std::size_t i = 0; i < 4; ++i) out << number(point[i]) << (i < 3 ? " " : "\n");
        }
        out << "END\n";
    }
    if (panel.front.empty()) return;
    out << "$panel" << p << "front << END\n";
    for (const ChartPoint& point : panel.front) out << number(point.x) << " " << number(point.y) << "\n";
    out << "END\n";
}

void write_plot(std::ostream& out, const Panel& panel, std::size_t p, const std::vector<std::string>& labels) {
    write_axis(out, 'x', panel);
    write_axis(out, 'y', panel);
    out << "set xlabel " << in_quotes(panel.x_label) << "\nset ylabel " << in_quotes(panel.y_label) << "\nplot ";
    if (!panel.front.empty()) {
        const std::string front = "$panel" + std::to_string(p) + "front";
        out << front << " with steps lc rgb '#ffd54f' lw 6 title 'Pareto front', \\\n     " << front
            << " with points lc rgb '#ffd54f' pt 7 ps 1.6 notitle, \\\n     ";
    }
    for (std::size_t s = 0; s < panel.series.size(); ++s) {
        const Series& series = panel.series[s];
        const bool is_new = s == 0 || panel.series[s - 1].label != series.label;
        out << (s == 0 ? "" : ", \\\n     ") << "$panel" << p << "series" << s << " with " << panel.bars
            << "errorlines " << style_of(series.label, series.samples, labels) << " "
            << (is_new ? "title " + in_quotes(series.label) : std::string("notitle"));
    }
    out << "\n";
}

}  // namespace

std::string gnuplot_script(const Chart& chart, const std::vector<std::string>& labels) {
    std::ostringstream out;
    constexpr double panel_px = 430, gap_px = 90, key_px = 290;
    const auto count = double(chart.panels.size());
    const double width = count * (panel_px + gap_px) + key_px;
    out << "# Draw again with: gnuplot " << chart.name << ".gp\n";
    for (std::size_t p = 0; p < chart.panels.size(); ++p) write_data(out, chart.panels[p], p);
    out << "set terminal svg noenhanced size " << number(width) << ",460 font 'sans-serif,13' background rgb 'white'\n"
        << "set output " << in_quotes(chart.name + ".svg")
        << "\nset logscale xy\nset grid xtics ytics lt 1 lw 0.5 lc rgb '#dddddd'\n"
        << "set errorbars small\n"
        << "set tmargin at screen 0.90\nset bmargin at screen 0.14\nset multiplot title " << in_quotes(chart.title)
        << "\n";
    for (std::size_t p = 0; p < chart.panels.size(); ++p) {
        const double left = gap_px + double(p) * (panel_px + gap_px);
        out << "set lmargin at screen " << number(left / width) << "\nset rmargin at screen "
            << number((left + panel_px) / width) << "\n";
        if (p + 1 < chart.panels.size()) {
            out << "unset key\n";
        } else {
            out << "set key at screen " << number((left + panel_px + 15) / width)
                << ", screen 0.90 left top Left reverse samplen 2\n";
        }
        write_plot(out, chart.panels[p], p, labels);
    }
    out << "unset multiplot\n";
    return out.str();
}

}  // namespace farfield::bench
