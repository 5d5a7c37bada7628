// Keeps an error table beside the hierarchy it was measured for: what is measured once chooses tolerances in every
// later run. It is a file of its own, and text, because one hierarchy has a table for each renderer and number of
// samples, and because people look into it.
#pragma once

#include "farfield/settings.hpp"

#include <array>
#include <charconv>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "farfield/cost_model/price_file.hpp"
#include "farfield/fail.hpp"
#include "farfield/geometry/mixed.hpp"
#include "farfield/tuning/error_table.hpp"

namespace farfield {
namespace detail {

[[noreturn]] inline void refuse_table(const std::string& where, const std::string& why) {
    fail<std::runtime_error>("farfield::read_error_table: " + where + ": " + why);
}

/// As short as it can be and come back to the last bit.
template <class Number>
std::string as_text(Number number) {
    std::array<char, 32> digits;
    return {digits.data(), std::to_chars(digits.data(), digits.data() + digits.size(), number).ptr};
}

}  // namespace detail

/// What tells hierarchies apart: the primitives, how they are approximated, and how many cells and stand-ins there are.
struct HierarchyIdentity {
    std::uint64_t fingerprint = 0, approximation = 0, cells = 0, stand_ins = 0;

    template <class H>
    static HierarchyIdentity of(const H& hierarchy) {
        HierarchyIdentity identity{hierarchy.fingerprint(), 0, hierarchy.nodes().size(), hierarchy.stand_ins().size()};
        if constexpr (requires { H::approximation_type::facts.file_tag; }) {
            identity.approximation = H::approximation_type::facts.file_tag;
        }
        return identity;
    }
    /// Makes it the identity of several: of a hierarchy and of those that are placed in it, in an order that is kept.
    void add(const HierarchyIdentity& other) {
        fingerprint = detail::mixed(fingerprint, other.fingerprint);
        approximation = detail::mixed(approximation, other.approximation);
        cells += other.cells;
        stand_ins += other.stand_ins;
    }
    std::string as_text() const {
        return detail::as_text(fingerprint) + " " + detail::as_text(approximation) + " " + detail::as_text(cells) +
               " " + detail::as_text(stand_ins);
    }
};

/// Writes text, one tolerance a line: "2 0.0431 0.52" are pixels, root mean square error and cost in parts of exact's.
/// Throws std::runtime_error if it cannot be written.
inline void write_error_table(const ErrorTable& table, const HierarchyIdentity& hierarchy,
                              const std::filesystem::path& path) {
    std::string text = "# farfield: what pictures of a hierarchy err by and cost, by tolerance\n";
    text += "hierarchy " + hierarchy.as_text() + "\n";
    text += "least_saving " + detail::as_text(table.least_saving()) + "\n";
    text += "# tolerance_px rmse cost\n";
    for (const ToleranceTrial& t : table.trials()) {
        text += detail::as_text(t.tolerance_px) + " " + detail::as_text(t.rmse) + " " + detail::as_text(t.cost) + "\n";
    }
    std::ofstream file(path, std::ios::binary);
    if (!file.write(text.data(), std::streamsize(text.size())).flush()) {
        detail::fail<std::runtime_error>("farfield::write_error_table: " + path.string() + ": cannot be written");
    }
}
template <class H>
void write_error_table(const ErrorTable& table, const H& hierarchy, const std::filesystem::path& path) {
    write_error_table(table, HierarchyIdentity::of(hierarchy), path);
}

/// Reads what write_error_table() wrote, to the last bit. Empty lines and those that start with # do not count. Throws
/// std::runtime_error, "farfield::read_error_table: FILE:LINE: reason", for a line that is none of a table, for
/// numbers that make none, and for the table of another hierarchy.
inline ErrorTable read_error_table(const HierarchyIdentity& hierarchy, const std::filesystem::path& path) {
    std::ifstream file(path, std::ios::binary);
    if (!file) detail::refuse_table(path.string(), "cannot be opened");
    bool is_known = false;
    double least_saving = -1;
    std::vector<ToleranceTrial> trials;
    std::string text;
    for (std::size_t number = 1; std::getline(file, text); ++number) {
        std::string_view line = text;
        std::string_view word = detail::next_word(line);
        if (word.empty() || word.front() == '#') continue;
        const auto refuse = [&](const std::string& why) {
            detail::refuse_table(path.string() + ":" + std::to_string(number), why);
        };
        const auto read = [&](std::string_view digits, auto& value) {
            const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
            if (digits.empty() || end != digits.data() + digits.size() || error != std::errc()) {
                refuse("expected a number, found '" + std::string(digits) + "'");
            }
        };
        if (word == "hierarchy") {
            std::string name;
            while (!(word = detail::next_word(line)).empty()) name += (name.empty() ? "" : " ") + std::string(word);
            if (name != hierarchy.as_text()) {
                refuse("it was measured for another hierarchy; measure_error_table() measures this one");
            }
            is_known = true;
            continue;
        }
        if (word == "least_saving") {
            read(detail::next_word(line), least_saving);
        } else {
            ToleranceTrial& trial = trials.emplace_back();
            read(word, trial.tolerance_px);
            read(detail::next_word(line), trial.rmse);
            read(detail::next_word(line), trial.cost);
        }
        if (word = detail::next_word(line); !word.empty()) refuse("'" + std::string(word) + "' is too much");
    }
    if (file.bad()) detail::refuse_table(path.string(), "cannot be read");
    if (!is_known) detail::refuse_table(path.string(), "does not say of which hierarchy it is");
    if (const char* const why = ErrorTable::obstacle(trials, least_saving)) detail::refuse_table(path.string(), why);
    return ErrorTable(std::move(trials), least_saving);
}
template <class H>
ErrorTable read_error_table(const H& hierarchy, const std::filesystem::path& path) {
    return read_error_table(HierarchyIdentity::of(hierarchy), path);
}

}  // namespace farfield
