#include "choices.hpp"

#include <charconv>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace viewer {
namespace {

[[noreturn]] void refuse(const std::string& what, const std::string& value, const std::string& known) {
    throw std::runtime_error("no " + what + " '" + value + "'; there are " + known);
}

double number(const std::string& word, double least, double most) {
    std::size_t end = 0;
    double value = std::numeric_limits<double>::quiet_NaN();
    try {
        value = std::stod(word, &end);
    } catch (const std::exception&) {
    }
    if (end != word.size() || !(value >= least && value <= most)) {
        throw std::runtime_error("'" + word + "' is no number from " + std::to_string(least) + " to " +
                                 std::to_string(most));
    }
    return value;
}

void choose_variant(Look& look, const Stage* stage, const std::string& name) {
    std::string known;
    if (stage == nullptr) throw std::runtime_error("there is no scene yet");
    for (std::size_t i = 0; i < stage->variants.size(); ++i) {
        if (stage->variants[i].name == name) {
            look.variant = i;
            return;
        }
        known += (known.empty() ? "" : ", ") + stage->variants[i].name;
    }
    refuse("variant", name, known);
}

void choose_renderer(Look& look, const std::string& name) {
    std::string known;
    for (const auto kind : farfield::scenes::renderer_kinds) {
        if (name == name_of(kind)) {
            look.renderer = kind;
            return;
        }
        known += (known.empty() ? "" : ", ") + std::string(name_of(kind));
    }
    refuse("renderer", name, known);
}

void choose_error(Look& look, const std::string& word) {
    look.wanted = word == "any" ? Wanted::any : word == "point-sampling" ? Wanted::point_sampling : Wanted::value;
    if (look.wanted == Wanted::value) look.wanted_rmse = float(number(word, 0, 1));
}

}  // namespace

void choose(Look& look, const Stage* stage, std::span<const std::string> words) {
    const std::string& what = words[0];
    const auto value = [&](std::size_t i) -> const std::string& {
        if (i >= words.size()) throw std::runtime_error("'" + what + "' needs a value");
        return words[i];
    };
    if (what == "variant") {
        choose_variant(look, stage, value(1));
    } else if (what == "renderer") {
        choose_renderer(look, value(1));
    } else if (what == "samples") {
        const double side = std::round(std::sqrt(number(value(1), 1, 64)));
        look.samples = int(side * side);
    } else if (what == "threads") {
        look.threads = int(number(value(1), 1, 256));
    } else if (what == "tolerance") {
        look.tolerance_px = float(number(value(1), 0, 1000));
    } else if (what == "error") {
        choose_error(look, value(1));
    } else if (what == "budget") {
        look.has_budget = value(1) != "none";
        if (look.has_budget) look.budget_ms = float(number(value(1), 1, 10'000));
    } else if (what == "difference") {
        if (value(1) != "flip" && value(1) != "absolute") refuse("difference", value(1), "flip, absolute");
        look.difference = value(1) == "flip" ? Difference::flip : Difference::absolute;
    } else if (what == "dividers") {
        const double first = number(value(1), 0, 1), second = number(value(2), first, 1);
        look.exact_until = first;
        look.variant_until = second;
    } else {
        refuse("setting", what, "variant, renderer, samples, threads, tolerance, error, budget, difference, dividers");
    }
}

}  // namespace viewer
