// Height fields in text: a table of heights, or a list of points on a grid.
#include <algorithm>
#include <map>

#include "scenes/load/load_detail.hpp"

namespace farfield::scenes::detail {

void split_values(std::string_view line, std::vector<std::string_view>& result) {
    line = trimmed(line);
    const char separator = line.find(';') != std::string_view::npos   ? ';'
                           : line.find(',') != std::string_view::npos ? ','
                                                                      : ' ';
    if (separator == ' ') return split(line, result);
    while (true) {
        const std::size_t end = std::min(line.find(separator), line.size());
        std::string_view value = trimmed(line.substr(0, end));
        if (value.size() > 1 && value.front() == '"' && value.back() == '"') value = value.substr(1, value.size() - 2);
        result.push_back(value);
        if (end == line.size()) return;
        line.remove_prefix(end + 1);
    }
}

namespace {

std::vector<std::string_view> values_of(std::string_view line) {
    std::vector<std::string_view> result;
    split_values(line, result);
    return result;
}

/// Nothing, "nan", "NA" and "null" are holes.
constexpr double hole = std::numeric_limits<double>::quiet_NaN();

std::optional<double> height(std::string_view value) {
    if (value.empty() || value == "NA" || value == "N/A" || value == "null") return hole;
    return number<double>(value);
}

struct Grid {
    std::vector<double> xs{}, zs{};  ///< of the columns and rows
    std::vector<double> heights{};   ///< row by row; NaN: none
};

/// y up, rows towards +z, facing up. Cells with a hole at a corner are left out.
Loaded drawn(const Grid& grid) {
    Mesh mesh;
    const std::size_t columns = grid.xs.size();
    if (grid.heights.size() > std::uint32_t(-1)) throw std::runtime_error("more than 4,294,967,295 points");
    for (std::size_t row = 0; row < grid.zs.size(); ++row) {
        for (std::size_t column = 0; column < columns; ++column) {
            mesh.positions.push_back({grid.xs[column], grid.heights[row * columns + column], grid.zs[row]});
        }
    }
    for (std::size_t row = 1; row < grid.zs.size(); ++row) {
        for (std::size_t column = 1; column < columns; ++column) {
            const auto d = static_cast<std::uint32_t>(row * columns + column), c = d - 1;
            const auto b = d - static_cast<std::uint32_t>(columns), a = b - 1;
            for (const auto& corners : {std::array{a, c, b}, std::array{b, c, d}}) {
                const bool whole = std::none_of(corners.begin(), corners.end(),
                                                [&](std::uint32_t corner) { return std::isnan(grid.heights[corner]); });
                if (whole) mesh.triangles.push_back({corners, {uncolored, uncolored, uncolored}});
            }
        }
    }
    return in_single_precision(mesh);
}

/// Columns by name, if the first line names them.
struct PointColumns {
    std::size_t x, y, height;
};

std::optional<PointColumns> point_columns(const std::vector<std::string_view>& names) {
    const auto find = [&](std::initializer_list<std::string_view> wanted) {
        for (const std::string_view name : wanted) {
            for (std::size_t i = 0; i < names.size(); ++i) {
                std::string lower(names[i]);
                for (char& c : lower) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
                if (lower == name) return i;
            }
        }
        return names.size();
    };
    const PointColumns columns{find({"x", "easting", "lon", "longitude"}), find({"y", "northing", "lat", "latitude"}),
                               find({"z", "height", "elevation", "altitude"})};
    if (std::max({columns.x, columns.y, columns.height}) == names.size()) return std::nullopt;
    return columns;
}

/// Points in any order; north (+y) is away from the viewer (-z). They must lie on a grid, which may have holes.
Grid grid_of_points(Lines& lines, const PointColumns& columns) {
    std::vector<glm::dvec3> points;
    std::string_view line;
    while (lines.next(line)) {
        if (trimmed(line).empty() || trimmed(line).front() == '#') continue;
        const auto values = values_of(line);
        if (std::max({columns.x, columns.y, columns.height}) >= values.size()) lines.fail("too few values");
        const auto x = number<double>(values[columns.x]), y = number<double>(values[columns.y]);
        const auto h = height(values[columns.height]);
        if (!x || !y || !h) lines.fail(in_quotes(line) + " where a point should be");
        if (!std::isfinite(*x) || !std::isfinite(*y)) lines.fail("a point that is not finite");
        points.push_back({*x, *h, -*y});
    }
    Grid grid;
    for (const glm::dvec3& p : points) {
        grid.xs.push_back(p.x);
        grid.zs.push_back(p.z);
    }
    for (std::vector<double>* axis : {&grid.xs, &grid.zs}) {
        std::sort(axis->begin(), axis->end());
        axis->erase(std::unique(axis->begin(), axis->end()), axis->end());
    }
    // Scattered points have about as many coordinates as there are points.
    if (grid.xs.size() > 4 * points.size() / std::max<std::size_t>(grid.zs.size(), 1)) {
        throw std::runtime_error("its points lie on no grid: " + std::to_string(grid.xs.size()) + " times " +
                                 std::to_string(grid.zs.size()) + " coordinates for " + std::to_string(points.size()) +
                                 " points");
    }
    grid.heights.assign(grid.xs.size() * grid.zs.size(), hole);
    const auto place = [](const std::vector<double>& axis, double at) {
        return static_cast<std::size_t>(std::lower_bound(axis.begin(), axis.end(), at) - axis.begin());
    };
    for (const glm::dvec3& p : points) grid.heights[place(grid.zs, p.z) * grid.xs.size() + place(grid.xs, p.x)] = p.y;
    return grid;
}

/// One row a line, the distance 1 apart.
Grid grid_of_table(Lines& lines, std::string_view line, std::size_t columns) {
    Grid grid;
    do {
        if (trimmed(line).empty() || trimmed(line).front() == '#') continue;
        const auto values = values_of(line);
        const bool ends_in_separator = values.size() == columns + 1 && values.back().empty();
        if (values.size() != columns && !ends_in_separator) {
            lines.fail(std::to_string(values.size()) + " values where the lines before have " +
                       std::to_string(columns));
        }
        for (std::size_t column = 0; column < columns; ++column) {
            const std::optional<double> h = height(values[column]);
            if (!h) lines.fail(in_quotes(values[column]) + " where a height should be");
            grid.heights.push_back(*h);
        }
        grid.zs.push_back(static_cast<double>(grid.zs.size()));
    } while (lines.next(line));
    for (std::size_t column = 0; column < columns; ++column) grid.xs.push_back(static_cast<double>(column));
    return grid;
}

}  // namespace

bool is_row_of_numbers(std::string_view line) {
    const auto values = values_of(line);
    return values.size() > 1 &&
           std::all_of(values.begin(), values.end(), [](std::string_view value) { return height(value).has_value(); });
}

Loaded read_height_field(std::string_view text) {
    if (text.substr(0, 3) == "\xef\xbb\xbf") text.remove_prefix(3);  // a mark of byte order, as Excel writes it
    Lines lines(text);
    std::string_view line;
    do {
        if (!lines.next(line)) throw std::runtime_error("is empty");
    } while (trimmed(line).empty() || trimmed(line).front() == '#');
    const auto values = values_of(line);
    if (const auto columns = point_columns(values)) return drawn(grid_of_points(lines, *columns));
    std::size_t count = values.size();
    if (count > 1 && values.back().empty()) --count;  // a separator at the end of each line
    for (const std::string_view value : values) {
        if (!height(value)) {
            lines.fail(in_quotes(value) + " is neither a height nor the name of a column (x, y and z or height)");
        }
    }
    return drawn(grid_of_table(lines, line, count));
}

}  // namespace farfield::scenes::detail
