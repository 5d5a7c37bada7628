// Keeps an error table beside the hierarchy it was measured for: what is measured once chooses tolerances in every
// later run. It is a file of its own, and text, because one hierarchy has a table for each renderer, and because people
// look into it.
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
#include "farfield/tuning/sampled_error_table.hpp"

namespace farfield {
namespace detail {

inline constexpr int error_table_version = 2;

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

/// Writes text: for each number of samples a pixel "samples 4 1.7", which is what exact frames cost at them, and then
/// one tolerance a line: "2 0.0431 0.52" are pixels, root mean square error and cost in parts of exact's. Throws
/// std::runtime_error if it cannot be written.
inline void write_error_table(const SampledErrorTable& table, const HierarchyIdentity& hierarchy,
                              const std::filesystem::path& path) {
    std::string text = "# farfield: what pictures of a hierarchy err by and cost, by samples a pixel and tolerance\n";
    text += "version " + detail::as_text(detail::error_table_version) + "\n";
    text += "hierarchy " + hierarchy.as_text() + "\n";
    for (const ErrorsAtSamples& at : table.tables()) {
        text += "# samples exact_cost\nsamples " + detail::as_text(at.samples) + " " + detail::as_text(at.exact_cost);
        text += "\nleast_saving " + detail::as_text(at.table.least_saving()) + "\n# tolerance_px rmse cost\n";
        for (const ToleranceTrial& t : at.table.trials()) {
            text += detail::as_text(t.tolerance_px) + " " + detail::as_text(t.rmse) + " " + detail::as_text(t.cost);
            text += "\n";
        }
    }
    std::ofstream file(path, std::ios::binary);
    if (!file.write(text.data(), std::streamsize(text.size())).flush()) {
        detail::fail<std::runtime_error>("farfield::write_error_table: " + path.string() + ": cannot be written");
    }
}
template <class H>
void write_error_table(const SampledErrorTable& table, const H& hierarchy, const std::filesystem::path& path) {
    write_error_table(table, HierarchyIdentity::of(hierarchy), path);
}

/// Reads what write_error_table() wrote, to the last bit. Empty lines and those that start with # do not count. Throws
/// std::runtime_error, "farfield::read_error_table: FILE:LINE: reason", for a line that is none of a table, for
/// numbers that make none, for the table of another hierarchy, and for files of another version.
inline SampledErrorTable read_error_table(const HierarchyIdentity& hierarchy, const std::filesystem::path& path) {
    struct Rows {
        int samples = 0;
        double exact_cost = 0, least_saving = -1;
        std::vector<ToleranceTrial> trials{};
    };
    std::ifstream file(path, std::ios::binary);
    if (!file) detail::refuse_table(path.string(), "cannot be opened");
    bool is_known = false;
    int version = 0;
    std::vector<Rows> all;
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
        if (version == 0) {
            if (word == "hierarchy") {
                refuse("it is of version 1, which knew no numbers of samples; measure it again");
            }
            if (word != "version") refuse("expected 'version', found '" + std::string(word) + "'");
            read(detail::next_word(line), version);
            if (version != detail::error_table_version) {
                refuse("it is of version " + std::to_string(version) + ", and this library reads version " +
                       std::to_string(detail::error_table_version));
            }
        } else if (word == "hierarchy") {
            std::string name;
            while (!(word = detail::next_word(line)).empty()) name += (name.empty() ? "" : " ") + std::string(word);
            if (name != hierarchy.as_text()) {
                refuse("it was measured for another hierarchy; measure_error_table() measures this one");
            }
            is_known = true;
        } else if (word == "samples") {
            Rows& rows = all.emplace_back();
            read(detail::next_word(line), rows.samples);
            read(detail::next_word(line), rows.exact_cost);
        } else if (all.empty()) {
            refuse("'" + std::string(word) + "' comes before any number of samples");
        } else if (word == "least_saving") {
            read(detail::next_word(line), all.back().least_saving);
        } else {
            ToleranceTrial& trial = all.back().trials.emplace_back();
            read(word, trial.tolerance_px);
            read(detail::next_word(line), trial.rmse);
            read(detail::next_word(line), trial.cost);
        }
        if (word = detail::next_word(line); !word.empty()) refuse("'" + std::string(word) + "' is too much");
    }
    if (file.bad()) detail::refuse_table(path.string(), "cannot be read");
    if (!is_known) detail::refuse_table(path.string(), "does not say of which hierarchy it is");
    std::vector<ErrorsAtSamples> tables;
    for (Rows& rows : all) {
        const char* const why = ErrorTable::obstacle(rows.trials, rows.least_saving);
        if (why != nullptr) detail::refuse_table(path.string(), why);
        tables.push_back({rows.samples, rows.exact_cost, ErrorTable(std::move(rows.trials), rows.least_saving)});
    }
    const char* const why = SampledErrorTable::obstacle(tables);
    if (why != nullptr) detail::refuse_table(path.string(), why);
    return SampledErrorTable(std::move(tables));
}
template <class H>
SampledErrorTable read_error_table(const H& hierarchy, const std::filesystem::path& path) {
    return read_error_table(HierarchyIdentity::of(hierarchy), path);
}

}  // namespace farfield
