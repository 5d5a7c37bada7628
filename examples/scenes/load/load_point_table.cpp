// Points in text, one a line: .xyz of no one in particular, .pts of Leica's Cyclone. Nobody has written down what the
// columns after the coordinates are; where they have no names, their numbers say it.
#include <algorithm>
#include <array>
#include <cmath>

#include "scenes/load/points.hpp"

namespace farfield::scenes::detail {
namespace {

constexpr std::size_t none = ~std::size_t{0};
using Triple = std::array<std::size_t, 3>;

bool is_present(const Triple& columns) {
    return std::find(columns.begin(), columns.end(), none) == columns.end();
}

/// Where in a line what is.
struct Columns {
    Triple position{none, none, none}, color{none, none, none}, normal{none, none, none};
    std::size_t intensity = none, radius = none;
};

/// By the names of the columns. Without x, y and z if these are no such names.
Columns named_columns(const std::vector<std::string_view>& names) {
    Columns columns;
    const auto find = [&](std::initializer_list<std::string_view> known) {
        for (std::size_t i = 0; i < names.size(); ++i) {
            std::string name(names[i]);
            for (char& c : name) {
                if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
            }
            if (std::find(known.begin(), known.end(), name) != known.end()) return i;
        }
        return none;
    };
    columns.position = {find({"x"}), find({"y"}), find({"z"})};
    columns.color = {find({"r", "red"}), find({"g", "green"}), find({"b", "blue"})};
    columns.normal = {find({"nx", "normal_x", "normalx"}), find({"ny", "normal_y", "normaly"}),
                      find({"nz", "normal_z", "normalz"})};
    columns.intensity = find({"i", "intensity", "scalar_intensity", "reflectance"});
    columns.radius = find({"radius"});
    return columns;
}

/// The line without what marks it as a comment, if it is one.
std::optional<std::string_view> comment(std::string_view line) {
    line = trimmed(line);
    if (line.substr(0, 2) == "//") return trimmed(line.substr(2));
    if (line.substr(0, 1) == "#") return trimmed(line.substr(1));
    return std::nullopt;
}

/// All values of a file but the coordinates, as lines have them; of words that are no numbers there are NaNs.
struct Values {
    std::size_t width = 0;
    std::vector<float> all{};

    std::size_t rows() const { return width > 0 ? all.size() / width : 0; }
    float at(std::size_t row, std::size_t column) const { return all[row * width + column]; }
};

class TableReader {
  public:
    explicit TableReader(std::string_view text) : lines_(text) {}

    void read() {
        std::string_view line;
        while (lines_.next(line)) {
            if (const auto remark = comment(line)) {
                if (positions.empty() && !is_present(columns.position)) {
                    columns = named_columns(values_in(*remark));
                    has_names = is_present(columns.position);
                    if (!has_names) columns = {};
                }
                continue;
            }
            const auto& values = values_in(line);
            if (values.empty()) continue;
            if (values.size() == 1 && number<std::uint64_t>(values[0])) {
                begin_block(*number<std::uint64_t>(values[0]));
            } else if (positions.empty() && !has_names && !number<double>(values[0])) {
                columns = named_columns(values);
                has_names = true;
                if (!is_present(columns.position)) {
                    lines_.fail(in_quotes(trimmed(line)) + " where coordinates should be, and no names x, y, z");
                }
            } else {
                add(values);
            }
        }
        end_block();
    }

    Columns columns{};
    bool has_names = false;
    std::vector<glm::dvec3> positions{};
    Values others{};
    /// By column, whether the first row has a number there.
    std::vector<bool> is_number{};

  private:
    const std::vector<std::string_view>& values_in(std::string_view line) {
        values_.clear();
        split_values(line, values_);
        while (!values_.empty() && values_.back().empty()) values_.pop_back();  // of separators that end lines
        return values_;
    }

    void begin_block(std::uint64_t count) {
        end_block();
        check_room(count, 6, lines_.rest().size() + 1, "points");
        counted_ = left_ = count;
        count_line_ = lines_.number();
    }

    void end_block() const {
        if (left_ == 0) return;
        lines_.fail("only " + std::to_string(counted_ - left_) + " of the " + std::to_string(counted_) +
                    " points that line " + std::to_string(count_line_) + " claims");
    }

    void add(const std::vector<std::string_view>& values) {
        if (count_line_ > 0 && left_ == 0) {
            lines_.fail("more than the " + std::to_string(counted_) + " points that line " +
                        std::to_string(count_line_) + " claims");
        }
        if (count_line_ > 0) --left_;
        if (positions.empty()) {
            if (!is_present(columns.position)) columns.position = {0, 1, 2};
            others.width = values.size();
            const std::size_t last = *std::max_element(columns.position.begin(), columns.position.end());
            if (others.width <= last) lines_.fail("fewer than three coordinates");
            for (const std::string_view value : values) is_number.push_back(number<double>(value).has_value());
            // Only what a name or a number says something about is kept.
            for (const std::size_t column : columns.position) is_number[column] = true;
        }
        if (values.size() < others.width) {
            lines_.fail("fewer than " + std::to_string(others.width) + " values, which the first point has");
        }
        glm::dvec3 position(0);
        for (std::size_t k = 0; k < 3; ++k) {
            position[static_cast<int>(k)] = number_in(values[columns.position[k]], "a coordinate");
        }
        positions.push_back(position);
        for (std::size_t i = 0; i < others.width; ++i) {
            const bool is_coordinate =
                std::find(columns.position.begin(), columns.position.end(), i) != columns.position.end();
            others.all.push_back(is_coordinate || !is_number[i] ? std::numeric_limits<float>::quiet_NaN()
                                                                : static_cast<float>(number_in(values[i], "a number")));
        }
    }

    double number_in(std::string_view value, std::string_view wanted) const {
        const std::optional<double> result = number<double>(value);
        if (!result) lines_.fail(in_quotes(value) + " where " + std::string(wanted) + " should be");
        return *result;
    }

    Lines lines_;
    std::vector<std::string_view> values_;
    std::uint64_t counted_ = 0, left_ = 0;  ///< points that the last count claims, and those of them not yet seen
    std::size_t count_line_ = 0;            ///< 0: no count
};

/// What a column's numbers may be.
struct Kind {
    bool is_number = false, is_whole = true;
    float least = std::numeric_limits<float>::infinity(), greatest = -std::numeric_limits<float>::infinity();
};

class Guess {
  public:
    explicit Guess(const Values& values, const std::vector<bool>& is_number)
        : values_(values), kinds_(values.width), used_(values.width) {
        for (std::size_t c = 0; c < values.width; ++c) kinds_[c].is_number = is_number[c];
        for (std::size_t row = 0; row < values.rows(); ++row) {
            for (std::size_t c = 0; c < values.width; ++c) {
                const float v = values.at(row, c);
                if (!std::isfinite(v)) continue;
                kinds_[c].is_whole &= v == std::floor(v);
                kinds_[c].least = std::min(kinds_[c].least, v);
                kinds_[c].greatest = std::max(kinds_[c].greatest, v);
            }
        }
    }

    /// Fills in what is not coordinates; these are the first three columns.
    void complete(Columns& columns, bool intensity_first) {
        for (const std::size_t c : columns.position) used_[c] = true;
        columns.normal = first_triple([&](std::size_t c) { return are_normals(c); }, false);
        // Whole bytes and fractions first: numbers in 0 to 255 that are not whole are colors only if nothing else is.
        columns.color =
            first_triple([&](std::size_t c) { return within(c, 255, true) || within(c, 1, false); }, intensity_first);
        if (!is_present(columns.color)) {
            columns.color = first_triple([&](std::size_t c) { return within(c, 255, false) || within(c, 65535, true); },
                                         intensity_first);
        }
        for (std::size_t c = 0; c < kinds_.size() && columns.intensity == none; ++c) {
            if (kinds_[c].is_number && !used_[c]) columns.intensity = c;
        }
    }

    float greatest_of(const Triple& columns) const {
        float greatest = 0;
        for (const std::size_t c : columns) greatest = std::max(greatest, kinds_[c].greatest);
        return greatest;
    }

  private:
    bool is_free(std::size_t first) const {
        for (std::size_t c = first; c < first + 3; ++c) {
            if (c >= kinds_.size() || !kinds_[c].is_number || used_[c]) return false;
        }
        return true;
    }

    /// Marks it as used. If there are several, and one column more than three is free, that may come before or after.
    template <class Fits>
    Triple first_triple(Fits&& fits, bool second_first) {
        std::vector<std::size_t> candidates;
        for (std::size_t c = 0; c + 2 < kinds_.size(); ++c) {
            if (is_free(c) && fits(c)) candidates.push_back(c);
        }
        if (candidates.empty()) return {none, none, none};
        const bool second = second_first && candidates.size() > 1 && candidates[1] == candidates[0] + 1;
        const std::size_t first = candidates[second ? 1 : 0];
        for (std::size_t c = first; c < first + 3; ++c) used_[c] = true;
        return {first, first + 1, first + 2};
    }

    bool within(std::size_t first, float most, bool whole) const {
        return std::all_of(kinds_.begin() + static_cast<std::ptrdiff_t>(first),
                           kinds_.begin() + static_cast<std::ptrdiff_t>(first) + 3, [&](const Kind& kind) {
                               return kind.least >= 0 && kind.greatest <= most && (kind.is_whole || !whole);
                           });
    }

    /// Of unit length, but for rounding and those that are not known.
    bool are_normals(std::size_t first) const {
        bool any = false;
        for (std::size_t row = 0; row < values_.rows(); ++row) {
            const float x = values_.at(row, first), y = values_.at(row, first + 1), z = values_.at(row, first + 2);
            const float square = x * x + y * y + z * z;
            if (!std::isfinite(square) || square == 0) continue;
            if (std::abs(square - 1) > 0.03f) return false;
            any = true;
        }
        return any;
    }

    const Values& values_;
    std::vector<Kind> kinds_;
    std::vector<bool> used_;
};

std::string_view without_mark(std::string_view text) {
    return text.substr(0, 3) == "\xef\xbb\xbf" ? text.substr(3) : text;
}

/// How many numbers a line has, if it has nothing else.
std::size_t numbers_in(std::string_view line, std::vector<std::string_view>& values) {
    values.clear();
    split_values(line, values);
    while (!values.empty() && values.back().empty()) values.pop_back();
    for (const std::string_view value : values) {
        if (!number<double>(value)) return 0;
    }
    return values.size();
}

}  // namespace

bool is_point_table(std::string_view text) {
    Lines lines(without_mark(text));
    std::string_view line;
    std::vector<std::string_view> values;
    while (lines.next(line) && trimmed(line).empty()) {
    }
    if (comment(line)) return true;
    const std::optional<std::uint64_t> count = number<std::uint64_t>(trimmed(line));
    if (!count) {
        // Three coordinates and more, of which the first is a number; or the names of columns.
        if (numbers_in(line, values) >= 3) return true;
        values.clear();
        split_values(line, values);
        if (values.size() >= 3 && number<double>(values[0]) && number<double>(values[1]) && number<double>(values[2])) {
            return true;
        }
        return is_present(named_columns(values).position);
    }
    // A count stands before molecules, too, but with a line of anything between it and the atoms. That may be numbers,
    // and an atom's symbol a number: then there are as many lines as the count says, and one more.
    if (!lines.next(line)) return false;
    const std::size_t width = numbers_in(line, values);
    if (width < 3) return false;
    std::uint64_t rows = 1;
    while (rows <= *count && lines.next(line)) {
        const std::size_t numbers = numbers_in(line, values);
        if (numbers == 1 || trimmed(line).empty()) break;
        if (numbers != width) return false;
        ++rows;
    }
    return rows <= *count;
}

Loaded read_point_table(std::string_view text, bool intensity_first, const LoadOptions& options) {
    TableReader table(without_mark(text));
    table.read();
    Columns& columns = table.columns;
    const Values& values = table.others;
    Guess guess(values, table.is_number);
    Cloud cloud;
    if (!table.has_names && values.width > 3) {
        guess.complete(columns, intensity_first);
        if (values.width > 5 && !is_present(columns.color) && !is_present(columns.normal)) {
            cloud.notes.push_back("the columns after z are neither colors nor normals");
        }
    }
    const auto column = [&](std::size_t c, std::vector<float>& result) {
        if (c == none) return;
        for (std::size_t row = 0; row < values.rows(); ++row) result.push_back(values.at(row, c));
    };
    column(columns.intensity, cloud.intensities);
    column(columns.radius, cloud.radii);
    const auto vector = [&](std::size_t row, const Triple& t) {
        return glm::vec3(values.at(row, t[0]), values.at(row, t[1]), values.at(row, t[2]));
    };
    if (is_present(columns.color)) {
        const float greatest = guess.greatest_of(columns.color);
        const float scale = greatest <= 1.001f ? 1.0f : greatest <= 255 ? 1.0f / 255 : 1.0f / 65535;
        for (std::size_t row = 0; row < values.rows(); ++row) {
            cloud.colors.push_back(to_rgba8({vector(row, columns.color) * scale, 1.0f}));
        }
    }
    if (is_present(columns.normal)) {
        for (std::size_t row = 0; row < values.rows(); ++row) {
            cloud.normals.push_back(vector(row, columns.normal));
        }
    }
    cloud.positions = std::move(table.positions);
    return drawn(std::move(cloud), options);
}

}  // namespace farfield::scenes::detail
