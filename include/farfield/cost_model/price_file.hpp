// Prices of work in a file: a machine is measured once (tuning/calibrate.hpp), and builds that read the file are the
// same from then on.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>

#include "farfield/cost_model/measured_time.hpp"
#include "farfield/fail.hpp"

namespace farfield {
namespace detail {

struct NamedPrice {
    const char* name;
    float MeasuredTime::*price;
    bool is_later = false;  ///< files from before there were such prices lack it
};
inline constexpr std::array<NamedPrice, 11> named_prices{{{"small_triangle", &MeasuredTime::small_triangle},
                                                          {"hit_triangle", &MeasuredTime::hit_triangle, true},
                                                          {"near_triangle", &MeasuredTime::near_triangle},
                                                          {"face", &MeasuredTime::face},
                                                          {"splat", &MeasuredTime::splat},
                                                          {"cell", &MeasuredTime::cell},
                                                          {"run", &MeasuredTime::run},
                                                          {"image", &MeasuredTime::image},
                                                          {"texel", &MeasuredTime::texel},
                                                          {"made_image", &MeasuredTime::made_image, true},
                                                          {"made_texel", &MeasuredTime::made_texel, true}}};

[[noreturn]] inline void refuse_prices(const char* function, const std::string& where, const std::string& why) {
    detail::fail<std::runtime_error>(std::string("farfield::") + function + ": " + where + ": " + why);
}

/// Takes the next word off a line.
inline std::string_view next_word(std::string_view& line) {
    constexpr const char* spaces = " \t\r";
    line.remove_prefix(std::min(line.find_first_not_of(spaces), line.size()));
    const std::string_view word = line.substr(0, line.find_first_of(spaces));
    line.remove_prefix(word.size());
    return word;
}

}  // namespace detail

/// Writes text for people, one price a line: "small_triangle 3.1 nanoseconds". Throws std::runtime_error if it cannot
/// be written.
inline void write_prices(const MeasuredTime& prices, const std::filesystem::path& path) {
    std::string text = "# farfield: what each kind of work takes on the machine that calibrate() ran on\n";
    for (const auto& [name, price, is_later] : detail::named_prices) {
        std::array<char, 32> digits;
        const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), prices.*price);
        text += name + (" " + std::string(digits.data(), end.ptr)) + " " + MeasuredTime::unit + "\n";
    }
    std::ofstream file(path, std::ios::binary);
    if (!file.write(text.data(), std::streamsize(text.size())).flush()) {
        detail::refuse_prices("write_prices", path.string(), "cannot be written");
    }
}

/// Reads what write_prices() wrote, to the last bit. Empty lines and those that start with # do not count. Throws
/// std::runtime_error, "farfield::read_prices: FILE:LINE: reason", for a line that is not a positive price, and if a
/// price is missing. Files from before images had prices of their own are read: hit_triangle, made_image and made_texel
/// are then MeasuredTime's defaults.
inline MeasuredTime read_prices(const std::filesystem::path& path) {
    std::ifstream file(path, std::ios::binary);
    if (!file) detail::refuse_prices("read_prices", path.string(), "cannot be opened");
    MeasuredTime prices;
    std::array<bool, detail::named_prices.size()> known{};
    std::string text;
    for (std::size_t number = 1; std::getline(file, text); ++number) {
        std::string_view line = text;
        const std::string_view name = detail::next_word(line);
        if (name.empty() || name.front() == '#') continue;
        const std::string_view digits = detail::next_word(line), unit = detail::next_word(line);
        const auto refuse = [&](const std::string& why) {
            detail::refuse_prices("read_prices", path.string() + ":" + std::to_string(number), why);
        };
        const auto named = std::find_if(detail::named_prices.begin(), detail::named_prices.end(),
                                        [&](const auto& p) { return p.name == name; });
        if (named == detail::named_prices.end()) refuse("'" + std::string(name) + "' is no kind of work");
        float value = 0;
        const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
        if (digits.empty() || end != digits.data() + digits.size() || error == std::errc::invalid_argument) {
            refuse("expected a number after '" + std::string(name) + "', found '" + std::string(digits) + "'");
        }
        if (error != std::errc() || !(value > 0) || !std::isfinite(value)) {
            refuse("a price must be above 0 and finite, not " + std::string(digits));
        }
        if (unit != MeasuredTime::unit || !detail::next_word(line).empty()) {
            refuse("expected 'nanoseconds' after the price and nothing else");
        }
        if (std::exchange(known[std::size_t(named - detail::named_prices.begin())], true)) {
            refuse("the price of '" + std::string(name) + "' was given before");
        }
        prices.*(named->price) = value;
    }
    if (file.bad()) detail::refuse_prices("read_prices", path.string(), "cannot be read");
    for (std::size_t i = 0; i < known.size(); ++i) {
        if (known[i] || detail::named_prices[i].is_later) continue;
        detail::refuse_prices("read_prices", path.string(),
                              std::string("the price of '") + detail::named_prices[i].name + "' is missing");
    }
    return prices;
}

}  // namespace farfield
