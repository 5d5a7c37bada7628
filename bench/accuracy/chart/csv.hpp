// Rows as comma-separated values (RFC 4180): a header, then one line each.
#pragma once

#include <algorithm>
#include <charconv>
#include <cmath>
#include <istream>
#include <ostream>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "row.hpp"

namespace farfield::bench {

/// In quotes where it has to be.
inline std::string csv_field(std::string_view text) {
    if (text.find_first_of(",\"\r\n") == std::string_view::npos) return std::string(text);
    std::string quoted = "\"";
    for (const char c : text) quoted.append(c == '"' ? 2 : 1, c);
    return quoted + '"';
}

/// Whole numbers as they are, others to six digits; never in another language's way.
inline std::string csv_number(double value) {
    char text[64];
    const bool is_whole = std::abs(value) < 0x1p53 && value == std::floor(value);
    const auto end = is_whole ? std::to_chars(text, text + sizeof text, value, std::chars_format::fixed, 0)
                              : std::to_chars(text, text + sizeof text, value, std::chars_format::general, 6);
    return std::string(text, end.ptr);
}

inline std::string csv_header() {
    std::string line;
    for (const Column& column : columns) line.append(line.empty() ? "" : ",").append(csv_field(column.name));
    return line + '\n';
}

inline std::string csv_line(const Row& row) {
    std::string line;
    for (const Column& column : columns) {
        if (&column != columns.data()) line += ',';
        if (const auto* text = std::get_if<std::string Row::*>(&column.field)) {
            line += csv_field(row.*(*text));
        } else if (const Row::Number& number = row.*std::get<Row::Number Row::*>(column.field)) {
            line += csv_number(*number);
        }
    }
    return line + '\n';
}

/// The fields of the next record into `fields`; false if there is none, or only a part: what a program that was killed
/// has left of its last line.
inline bool read_csv_record(std::istream& in, std::vector<std::string>& fields) {
    fields.assign(1, {});
    bool in_quotes = false;
    for (char c; in.get(c);) {
        if (in_quotes) {
            if (c != '"') {
                fields.back() += c;
            } else if (in.peek() == '"') {
                fields.back() += char(in.get());
            } else {
                in_quotes = false;
            }
        } else if (c == '"') {
            in_quotes = true;
        } else if (c == ',') {
            fields.emplace_back();
        } else if (c == '\n') {
            return true;
        } else if (c != '\r') {
            fields.back() += c;
        }
    }
    return false;
}

/// What csv_header and csv_line wrote, in any order of columns. Throws std::invalid_argument saying in one line what is
/// wrong: a column that is missing, a record of another length, what should be a number and is none.
inline std::vector<Row> read_csv(std::istream& in) {
    std::vector<std::string> names, fields;
    read_csv_record(in, names);
    std::vector<std::size_t> places;
    for (const Column& column : columns) {
        const auto place = std::find(names.begin(), names.end(), column.name);
        if (place == names.end()) throw std::invalid_argument("there is no column " + std::string(column.name));
        places.push_back(std::size_t(place - names.begin()));
    }
    std::vector<Row> rows;
    while (read_csv_record(in, fields)) {
        const auto refuse = [&](const std::string& why) {
            throw std::invalid_argument("record " + std::to_string(rows.size() + 1) + " " + why);
        };
        if (fields.size() != names.size()) refuse("has another number of fields than the header");
        Row& row = rows.emplace_back();
        for (std::size_t i = 0; i < columns.size(); ++i) {
            const std::string& field = fields[places[i]];
            if (const auto* text = std::get_if<std::string Row::*>(&columns[i].field)) {
                row.*(*text) = field;
            } else if (!field.empty()) {
                double value = 0;
                const auto end = std::from_chars(field.data(), field.data() + field.size(), value);
                if (end.ec != std::errc() || end.ptr != field.data() + field.size()) {
                    refuse("has '" + field + "' for " + std::string(columns[i].name));
                }
                row.*std::get<Row::Number Row::*>(columns[i].field) = value;
            }
        }
    }
    return rows;
}

}  // namespace farfield::bench
