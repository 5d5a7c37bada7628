// Keeps error tables in the file of the hierarchy that they were measured for: what is measured once chooses tolerances
// and samples in every later run, wherever the file goes.
//
//     const MeasuredWith with{.renderer = "z-buffer", .width = 640, .height = 360};
//     keep_error_table(measure_sampled_error_table(...), with, hierarchy, "scene.farfield");      // once
//     const auto table = kept_error_table(with, open_pages<H, P>("scene.farfield"));              // ever after
//     auto viewer = make_tuned_viewer(hierarchy, primitives, *table, make_renderer);              // tuned_viewer.hpp
//
// A table is a note (storage/notes.hpp), and text, because people look into it: `tail -c 2000 scene.farfield` shows it.
// There is one for each renderer and size of picture; another renderer errs otherwise, and so do larger pictures. Where
// no file is wanted, notes are made and read alike: save() to memory takes them along, read_notes() finds them there.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "farfield/cost_model/price_file.hpp"
#include "farfield/fail.hpp"
#include "farfield/geometry/mixed.hpp"
#include "farfield/hierarchy/hierarchy_data.hpp"
#include "farfield/paging/file_notes.hpp"
#include "farfield/storage/checksum.hpp"
#include "farfield/storage/fields.hpp"
#include "farfield/storage/notes.hpp"
#include "farfield/tuning/error_table.hpp"
#include "farfield/tuning/sampled_error_table.hpp"

namespace farfield {

/// What a table was measured with, and answers for. Whatever makes pictures err or cost otherwise belongs into the name
/// of the renderer, which is the user's.
struct MeasuredWith {
    std::string renderer;
    int width = 0, height = 0;  ///< of pictures, in pixels

    std::string as_text() const { return renderer + " " + std::to_string(width) + "x" + std::to_string(height); }
    friend bool operator==(const MeasuredWith&, const MeasuredWith&) = default;
};

namespace detail {
inline std::uint64_t identity_by(const HierarchyFacts& facts, std::uint32_t approximation_tag,
                                 std::uint64_t checksum_of_options) {
    return mixed(mixed(Xxh64::of(bytes_of(facts)), approximation_tag), checksum_of_options);
}
}  // namespace detail

/// What tells hierarchies apart: their facts, the primitives' fingerprint among them, how they are approximated, and
/// the options of their policies. One that was saved, or cut into pages, has that of the one in memory.
template <class H>
std::uint64_t identity_of(const H& hierarchy) {
    using A = typename H::approximation_type;
    std::vector<std::byte> options;
    for (const auto& bytes : {detail::bytes_of(hierarchy.partition_policy()),
                              detail::bytes_of<detail::stored_approximation_of<A>>(hierarchy.approximation_policy()),
                              detail::bytes_of(hierarchy.cost_policy())}) {
        options.insert(options.end(), bytes.begin(), bytes.end());
    }
    return detail::identity_by(hierarchy.facts(), A::facts.file_tag, detail::Xxh64::of(options));
}

namespace detail {

inline constexpr int error_table_version = 3;
inline constexpr std::string_view error_note = "errors ";  ///< what its name begins with

/// As a message shows it, whatever it is: short, and of characters that can be seen.
inline std::string as_shown(std::string_view text) {
    constexpr std::size_t most = 40;
    std::string shown(text.substr(0, most));
    for (char& c : shown) c = c >= ' ' && c <= '~' ? c : '?';
    return text.size() > most ? shown + "..." : shown;
}

/// As short as it can be and come back to the last bit.
template <class Number>
std::string as_text(Number number) {
    std::array<char, 32> digits;
    return {digits.data(), std::to_chars(digits.data(), digits.data() + digits.size(), number).ptr};
}

/// For each number of samples a pixel "samples 4 1.7", which is what exact frames cost at them, and then one tolerance
/// a line: "2 0.0431 0.52" are pixels, root mean square error and cost in parts of exact's.
inline std::string text_of(const SampledErrorTable& table, std::uint64_t identity) {
    std::string text = "# farfield: what pictures of a hierarchy err by and cost, by samples a pixel and tolerance\n";
    text += "version " + as_text(error_table_version) + "\nhierarchy " + as_text(identity) + "\n";
    for (const ErrorsAtSamples& at : table.tables()) {
        text += "# samples exact_cost\nsamples " + as_text(at.samples) + " " + as_text(at.exact_cost);
        text += "\nleast_saving " + as_text(at.table.least_saving()) + "\n# tolerance_px rmse cost\n";
        for (const ToleranceTrial& t : at.table.trials()) {
            text += as_text(t.tolerance_px) + " " + as_text(t.rmse) + " " + as_text(t.cost) + "\n";
        }
    }
    return text;
}

/// Reads what text_of() wrote, to the last bit. Empty lines and those that start with # do not count. Throws
/// std::runtime_error, "farfield::kept_error_table: WHERE:LINE: reason".
class ErrorTableText {
  public:
    static SampledErrorTable read(std::string_view text, std::uint64_t identity, const std::string& where) {
        ErrorTableText reader(identity, where);
        while (!text.empty()) {
            const std::size_t end = std::min(text.find('\n'), text.size());
            reader.line_ += 1;
            reader.read_line(text.substr(0, end));
            text.remove_prefix(std::min(end + 1, text.size()));
        }
        return reader.table();
    }

  private:
    struct Rows {
        int samples = 0;
        double exact_cost = 0, least_saving = -1;
        std::vector<ToleranceTrial> trials{};
    };

    ErrorTableText(std::uint64_t identity, const std::string& where) : identity_(identity), where_(where) {}

    [[noreturn]] void refuse(const std::string& why, bool is_of_line = true) const {
        const std::string line = is_of_line ? ":" + std::to_string(line_) : std::string();
        fail<std::runtime_error>("farfield::kept_error_table: " + where_ + line + ": " + why);
    }
    template <class Number>
    void read(std::string_view digits, Number& value) const {
        const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
        if (digits.empty() || end != digits.data() + digits.size() || error != std::errc()) {
            refuse("expected a number, found '" + as_shown(digits) + "'");
        }
    }
    void read_line(std::string_view line) {
        const std::string_view word = next_word(line);
        if (word.empty() || word.front() == '#') return;
        if (version_ == 0) {
            if (word != "version") refuse("expected 'version', found '" + as_shown(word) + "'");
            read(next_word(line), version_);
            if (version_ != error_table_version) {
                refuse("it is of version " + std::to_string(version_) + ", and this library reads version " +
                       std::to_string(error_table_version) + ": measure it again");
            }
        } else if (word == "hierarchy") {
            std::uint64_t identity = 0;
            read(next_word(line), identity);
            if (identity != identity_) refuse("it was measured for another hierarchy: measure it again");
            is_known_ = true;
        } else if (word == "samples") {
            Rows& rows = all_.emplace_back();
            read(next_word(line), rows.samples);
            read(next_word(line), rows.exact_cost);
        } else if (all_.empty()) {
            refuse("'" + as_shown(word) + "' comes before any number of samples");
        } else if (word == "least_saving") {
            read(next_word(line), all_.back().least_saving);
        } else {
            ToleranceTrial& trial = all_.back().trials.emplace_back();
            read(word, trial.tolerance_px);
            read(next_word(line), trial.rmse);
            read(next_word(line), trial.cost);
        }
        if (const std::string_view more = next_word(line); !more.empty()) {
            refuse("'" + as_shown(more) + "' is too much");
        }
    }
    SampledErrorTable table() {
        if (!is_known_) refuse("does not say of which hierarchy it is", false);
        std::vector<ErrorsAtSamples> tables;
        for (Rows& rows : all_) {
            if (const char* why = ErrorTable::obstacle(rows.trials, rows.least_saving)) refuse(why, false);
            tables.push_back({rows.samples, rows.exact_cost, ErrorTable(std::move(rows.trials), rows.least_saving)});
        }
        if (const char* why = SampledErrorTable::obstacle(tables)) refuse(why, false);
        return SampledErrorTable(std::move(tables));
    }

    std::uint64_t identity_;
    const std::string& where_;
    std::size_t line_ = 0;
    int version_ = 0;
    bool is_known_ = false;
    std::vector<Rows> all_;
};

inline std::string name_of_error_note(const MeasuredWith& with) {
    return std::string(error_note) + with.as_text();
}

template <class H>
std::optional<SampledErrorTable> error_table_in(const Notes& notes, const MeasuredWith& with, const H& hierarchy,
                                                const std::string& where) {
    const auto note = notes.find(name_of_error_note(with));
    if (note == notes.end()) return std::nullopt;
    return ErrorTableText::read(note->second, identity_of(hierarchy), where + note->first);
}

}  // namespace detail

/// What the tables among notes were measured with, by renderers' names.
inline std::vector<MeasuredWith> error_tables_in(const Notes& notes) {
    std::vector<MeasuredWith> all;
    for (const auto& [name, text] : notes) {
        const std::size_t space = name.rfind(' '), by = name.rfind('x');
        if (name.rfind(detail::error_note, 0) != 0 || space < detail::error_note.size() || by == std::string::npos ||
            by < space) {
            continue;
        }
        MeasuredWith with{name.substr(detail::error_note.size(), space - detail::error_note.size())};
        std::from_chars(name.data() + space + 1, name.data() + by, with.width);
        std::from_chars(name.data() + by + 1, name.data() + name.size(), with.height);
        if (detail::name_of_error_note(with) == name) all.push_back(std::move(with));
    }
    return all;
}

/// Puts a table among notes, in place of one that was measured with the same.
template <class H>
void keep_error_table(const SampledErrorTable& table, const MeasuredWith& with, const H& hierarchy, Notes& notes) {
    notes.insert_or_assign(detail::name_of_error_note(with), detail::text_of(table, identity_of(hierarchy)));
}

/// Puts a table into the hierarchy's file, which is written anew (write_notes()). Throws as that does, and
/// std::runtime_error for the file of another hierarchy.
template <class H>
void keep_error_table(const SampledErrorTable& table, const MeasuredWith& with, const H& hierarchy,
                      const std::filesystem::path& file) {
    detail::FileWithNotes in("keep_error_table", file);
    if (detail::identity_by(in.place.facts, in.place.approximation_tag, in.checksum_of_options()) !=
        identity_of(hierarchy)) {
        in.refuse_if("is of another hierarchy than the one that was measured");
    }
    Notes notes = in.notes();
    keep_error_table(table, with, hierarchy, notes);
    write_notes(notes, file);
}

/// The table that was measured with this, as it was; none if there is none. Throws std::runtime_error that names the
/// note, its line and what is wrong with it: what is no table, of another hierarchy, or of another version.
template <class H>
std::optional<SampledErrorTable> kept_error_table(const MeasuredWith& with, const H& hierarchy, const Notes& notes) {
    return detail::error_table_in(notes, with, hierarchy, "");
}
/// That in the hierarchy's file. Throws as read_notes(), too.
template <class H>
std::optional<SampledErrorTable> kept_error_table(const MeasuredWith& with, const H& hierarchy,
                                                  const std::filesystem::path& file) {
    return detail::error_table_in(read_notes(file), with, hierarchy, file.string() + ": ");
}
/// That which came with a hierarchy in pages.
template <class H>
requires requires(const H& h) {
    h.notes();
}
std::optional<SampledErrorTable> kept_error_table(const MeasuredWith& with, const H& hierarchy) {
    return kept_error_table(with, hierarchy, hierarchy.notes());
}

}  // namespace farfield
