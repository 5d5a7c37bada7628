// Two ways to draw one picture, in turns in one run, and the table of what came of it: the machine has slow and fast
// phases, and only ratios of neighboring frames mean something. Times are the processor's, all threads of the program
// added up, so that what others do meanwhile slows caches down and nothing else.
#pragma once

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <ctime>
#include <functional>
#include <string>
#include <vector>

#include "support/seconds.hpp"

namespace farfield::bench {

/// How often a pair is drawn: until both the seconds and the least number of turns are over.
struct Patience {
    std::size_t least_turns = 9, most_turns = 61;
    double seconds = 1.5;
};

/// Of an even number the mean of the two in the middle; there must be one.
inline double middle(std::vector<double> v) {
    std::sort(v.begin(), v.end());
    const std::size_t n = v.size();
    return 0.5 * (v[(n - 1) / 2] + v[n / 2]);
}

/// As seconds_in_turn, of the processor.
template <class F>
double processor_seconds_in_turn(double last_seconds, F&& frame) {
    double taken = 0;
    seconds_in_turn(last_seconds, [&] {
        const std::clock_t start = std::clock();
        frame();
        taken = double(std::clock() - start) / CLOCKS_PER_SEC;
    });
    return taken;
}

/// Medians over turns, of one view.
struct PairTimes {
    double ms = 0, other_ms = 0;
    double speedup = 0;  ///< other / ours, turn by turn
    double noise = 0;    ///< half of the range between the quartiles of speedup, as a part of it
};

/// Seconds of each that took turns, turn by turn.
using Turns = std::vector<std::vector<double>>;

inline Turns in_turns(const Patience& patience, const std::vector<std::function<void()>>& frames) {
    for (const auto& frame : frames) frame();  // Buffers grow to what the view needs.
    Turns turns(frames.size());
    const auto start = std::chrono::steady_clock::now();
    for (std::size_t turn = 0;
         turn < patience.least_turns || (turn < patience.most_turns && seconds_since(start) < patience.seconds);
         ++turn) {
        for (std::size_t i = 0; i < frames.size(); ++i) {
            turns[i].push_back(processor_seconds_in_turn(turn == 0 ? 0 : turns[i].back(), frames[i]));
        }
    }
    return turns;
}

inline PairTimes pair_of(const std::vector<double>& ours, const std::vector<double>& other) {
    std::vector<double> speedups;
    for (std::size_t i = 0; i < ours.size(); ++i) speedups.push_back(other[i] / std::max(ours[i], 1e-6));
    std::sort(speedups.begin(), speedups.end());
    const std::size_t n = speedups.size();
    const double speedup = speedups[n / 2];
    return {median(ours) * 1e3, median(other) * 1e3, speedup, (speedups[3 * n / 4] - speedups[n / 4]) / (2 * speedup)};
}

inline PairTimes in_turns(const Patience& patience, const std::function<void()>& ours,
                          const std::function<void()>& other) {
    const Turns turns = in_turns(patience, {other, ours});
    return pair_of(turns[1], turns[0]);
}

/// What has to be reached: a speed-up of at least that, a time of at most that part of the other's, or a figure.
struct Wanted {
    enum class Kind { nothing, at_least, at_most, equal, share };
    Kind kind = Kind::nothing;
    double figure = 0;

    static Wanted at_least(double figure) { return {Kind::at_least, figure}; }
    static Wanted at_most(double figure) { return {Kind::at_most, figure}; }
    /// Nothing is wanted of a part of the other's time.
    static Wanted share() { return {Kind::share, 0}; }
    bool is_wanted() const { return kind != Kind::nothing && kind != Kind::share; }
    bool is_reached(double reached) const {
        if (kind == Kind::equal) return std::abs(reached - figure) < 1e-3 * figure;
        return !is_wanted() || (kind == Kind::at_least ? reached >= figure : reached <= figure);
    }
    std::string text() const {
        if (!is_wanted()) return "";
        std::array<char, 24> text{};
        constexpr const char* signs[] = {"", ">= ", "<= ", "= "};
        std::snprintf(text.data(), text.size(), "%s%.4g", signs[int(kind)], figure);
        return text.data();
    }
};

/// Rows as they come, in Markdown.
class Table {
  public:
    static void header() {
        std::puts("| row | views | ours, ms | other, ms | reached | worst view | noise | wanted | |");
        std::puts("|---|---|---|---|---|---|---|---|---|");
    }

    /// A pair over views: medians. `at_most` and `share` want shares of the other's time, everything else speed-ups.
    static void add(const std::string& name, const std::vector<PairTimes>& views, const Wanted& wanted = {}) {
        const bool is_share = wanted.kind == Wanted::Kind::at_most || wanted.kind == Wanted::Kind::share;
        std::vector<double> ours, other, reached, noise;
        for (const PairTimes& v : views) {
            ours.push_back(v.ms);
            other.push_back(v.other_ms);
            reached.push_back(is_share ? 1 / v.speedup : v.speedup);
            noise.push_back(v.noise);
        }
        const double worst = is_share ? *std::max_element(reached.begin(), reached.end())
                                      : *std::min_element(reached.begin(), reached.end());
        std::printf("| %s | %zu | %.3g | %.3g | %.3g | %.3g | %.0f %% | %s | %s |\n", name.c_str(), views.size(),
                    middle(ours), middle(other), middle(reached), worst, 100 * middle(noise), wanted.text().c_str(),
                    verdict(wanted, middle(reached)));
        std::fflush(stdout);
    }

    /// Figures that are no times, one a view.
    static void add_figure(const std::string& name, const std::vector<double>& figures, const Wanted& wanted = {}) {
        const double worst = wanted.kind == Wanted::Kind::at_least ? *std::min_element(figures.begin(), figures.end())
                                                                   : *std::max_element(figures.begin(), figures.end());
        std::printf("| %s | %zu | | | %.5g | %.5g | | %s | %s |\n", name.c_str(), figures.size(), middle(figures),
                    worst, wanted.text().c_str(), verdict(wanted, middle(figures)));
        std::fflush(stdout);
    }

    static void remark(const std::string& text) { std::fprintf(stderr, "%s\n", text.c_str()); }

  private:
    static const char* verdict(const Wanted& wanted, double reached) {
        if (!wanted.is_wanted()) return "";
        return wanted.is_reached(reached) ? "reached" : "MISSED";
    }
};

}  // namespace farfield::bench
