// Measures on this machine what frames of a scene cost, before a walkthrough starts, so that budgets of time hold.
//
// calibrate() prices work by scenes of its own, one kind at a time. What a frame takes depends as much on what is drawn
// over what, and on how nodes lie in memory, so here frames of the scene itself are drawn, coarse ones and fine ones,
// and prices are fitted to their times. That is done once: nothing looks back at frames that are shown.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <span>
#include <vector>

#include "farfield/frame/frame_budget.hpp"
#include "farfield/frame/frame_prices.hpp"
#include "farfield/view.hpp"

namespace farfield {

struct FramePriceOptions {
    double longest = 40e6;  ///< nanoseconds; frames that take longer are not of interest
    int repetitions = 5;    ///< of each frame; the shortest counts
    /// Prices are raised until this part of the frames that were measured takes no more than it is said to, and until
    /// none takes more than `most_over` times that.
    double part_within = 0.98;
    double most_over = 1.1;
    double (*clock)() = [] {
        return std::chrono::duration<double, std::nano>(std::chrono::steady_clock::now().time_since_epoch()).count();
    };  ///< nanoseconds
};

/// The work of a frame and what it took.
struct MeasuredFrame {
    FrameWork work;
    double time = 0;
};

/// Prices that explain times best: the squares of relative errors are least, and no price is negative. They are raised
/// as the options say. The defaults, if there is no frame.
inline FramePrices fitted_frame_prices(std::span<const MeasuredFrame> frames, const FramePriceOptions& options = {}) {
    constexpr std::size_t kinds = FrameWork::kinds;
    FramePrices prices;
    std::vector<std::array<double, kinds>> rows;  // work over time, which their sum is to be
    std::vector<double> times;
    for (const MeasuredFrame& f : frames) {
        if (!(f.time > 0)) continue;
        // Frames so short that they do not matter are not to decide.
        const double weight = 1 / std::max(f.time, options.longest / 32);
        rows.push_back(f.work.with_shown().of);
        for (double& w : rows.back()) w *= weight;
        times.push_back(f.time * weight);
    }
    if (rows.empty()) return prices;
    // Columns of the same length, so that steps are comparable.
    std::array<double, kinds> length{}, p{};
    for (std::size_t k = 0; k < kinds; ++k) {
        for (const auto& row : rows) length[k] += row[k] * row[k];
        length[k] = std::sqrt(length[k]);
        if (!(length[k] > 0)) continue;
        for (auto& row : rows) row[k] /= length[k];
        p[k] = prices.each.of[k] * length[k];
    }
    std::vector<double> off(rows.size());  // by how much the sum differs
    for (std::size_t i = 0; i < rows.size(); ++i) {
        off[i] = -times[i];
        for (std::size_t k = 0; k < kinds; ++k) off[i] += rows[i][k] * p[k];
    }
    // Coordinate by coordinate; a column has length 1. Where frames do not tell two kinds apart, what is left of the
    // start decides.
    for (int round = 0; round < 2000; ++round) {
        for (std::size_t k = 0; k < kinds; ++k) {
            if (!(length[k] > 0)) continue;
            double slope = 0;
            for (std::size_t i = 0; i < rows.size(); ++i) slope += rows[i][k] * off[i];
            const double next = std::max(0.0, p[k] - slope), step = next - p[k];
            for (std::size_t i = 0; i < rows.size(); ++i) off[i] += rows[i][k] * step;
            p[k] = next;
        }
    }
    std::vector<double> taken_over_said(rows.size());
    for (std::size_t i = 0; i < rows.size(); ++i) taken_over_said[i] = times[i] / std::max(times[i] + off[i], 0.1);
    std::sort(taken_over_said.begin(), taken_over_said.end());
    const auto last = std::min(std::size_t(options.part_within * double(rows.size())), rows.size() - 1);
    const double raised = std::max(taken_over_said[last], taken_over_said.back() / options.most_over);
    for (std::size_t k = 0; k < kinds; ++k) {
        if (length[k] > 0) prices.each.of[k] = p[k] / length[k];
        prices.each.of[k] *= raised;
    }
    return prices;
}

/// Draws each view coarser and finer through a viewer, which is left with another picture. Views should be like those
/// that will be drawn; a dozen of them are enough.
template <class Viewer_>
std::vector<MeasuredFrame> measure_frames(Viewer_& viewer, std::span<const View> views,
                                          const FramePriceOptions& options = {}) {
    std::vector<MeasuredFrame> measured;
    Refinement refinement;
    /// False if nothing finer is of interest.
    const auto add = [&](const View& view, const FrameBudget& budget) {
        MeasuredFrame frame;
        for (int i = 0; i <= options.repetitions; ++i) {
            const double start = options.clock();
            viewer.frame(view, budget, refinement);
            const double time = options.clock() - start;
            if (i == 1 || time < frame.time) frame.time = time;  // buffers grow in the first
            if (time > 4 * options.longest) return false;
        }
        frame.work = refinement.work();
        measured.push_back(frame);
        return frame.time <= options.longest && !refinement.is_complete();
    };
    FramePrices by_openings{{}};
    by_openings.each[FrameWork::openings] = 1;
    for (const View& view : views) {
        for (double openings = 0; openings < 1e9 && add(view, {by_openings, openings}); openings = 4 + 2 * openings) {
        }
    }
    // The cuts that such prices make are those that matter.
    const FramePrices first = fitted_frame_prices(measured, options);
    for (const View& view : views) {
        for (double most = options.longest / 16; most <= options.longest && add(view, {first, most}); most *= 2) {
        }
    }
    return measured;
}

template <class Viewer_>
FramePrices measure_frame_prices(Viewer_& viewer, std::span<const View> views, const FramePriceOptions& options = {}) {
    return fitted_frame_prices(measure_frames(viewer, views, options), options);
}

}  // namespace farfield
