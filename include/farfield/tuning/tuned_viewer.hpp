// A viewer that is asked for an error, and takes tolerance and samples from a table that was measured for its hierarchy
// (measure_error_table.hpp) and may have come in its file (kept_error_table.hpp).
//
//     auto viewer = make_tuned_viewer(hierarchy, primitives, table, [](int samples) {
//         return ZBufferRenderer({.samples = samples});
//     });
//     viewer.frame({.camera = camera, .wanted = {.rmse = 0.03}});
//     show(viewer.renderer().image());
#pragma once

#include "farfield/settings.hpp"

#include <optional>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

#include "farfield/primitive.hpp"
#include "farfield/primitive_source.hpp"
#include "farfield/tuning/error_table.hpp"
#include "farfield/tuning/sampled_error_table.hpp"
#include "farfield/tuning/viewers_by_samples.hpp"
#include "farfield/view.hpp"
#include "farfield/viewer.hpp"
#include "farfield/wanted_error.hpp"

namespace farfield {

/// A Viewer for each number of samples in a table, over one hierarchy; they share what renderers share. Hierarchy and
/// primitives outlive it. Not to be used by two threads at once. Frames do not allocate, as a Viewer's.
template <class H, class P, class R>
class TunedViewer {
  public:
    /// make(samples) returns a renderer that draws with so many. Throws what viewers and renderers throw.
    template <class MakeRenderer>
    TunedViewer(const H& hierarchy, PrimitiveSpan<P> primitives, SampledErrorTable table, MakeRenderer&& make)
        : table_(std::move(table)) {
        for (const ErrorsAtSamples& at : table_.tables()) all_.add(hierarchy, primitives, at.samples, make);
    }

    /// Draws a view by what is cheapest of all that keeps the error that it wants, as the table has it; exact where
    /// nothing does that is cheaper, and where it cannot be had, which choice() says. The view's tolerance is not used,
    /// unless any error is wanted: then it counts, at the fewest samples. Throws as Viewer::frame() and
    /// SampledErrorTable::cheapest_for() do.
    FrameStats frame(View view) {
        view.validate();
        choice_.reset();
        if (!view.wanted.is_any()) {
            choice_ = table_.cheapest_for(view.wanted);
            view = choice_->applied_to(view);
            // What is expected of a cell was not asked when the table was measured.
            view.wanted.rmse = WantedError::any().rmse;
        }
        return drawn().viewer->frame(view);
    }

    const SampledErrorTable& table() const { return table_; }
    /// What the last frame was drawn by; none if any error was wanted.
    const std::optional<SampleChoice>& choice() const { return choice_; }
    /// That of the last frame.
    const R& renderer() const { return *drawn().renderer; }

  private:
    /// With what the last frame was drawn; the fewest samples if any error was wanted.
    const auto& drawn() const { return choice_ ? all_.at(choice_->samples) : all_.first(); }

    SampledErrorTable table_;
    detail::ViewersBySamples<H, P, R> all_;  ///< one a table
    std::optional<SampleChoice> choice_;
};

template <class H, class P, class MakeRenderer>
auto make_tuned_viewer(const H& hierarchy, std::span<const P> primitives, SampledErrorTable table,
                       MakeRenderer&& make) {
    return TunedViewer<H, P, std::remove_cvref_t<decltype(make(1))>>(hierarchy, primitives, std::move(table), make);
}
template <class H, class P, class MakeRenderer>
auto make_tuned_viewer(const H& hierarchy, const std::vector<P>& primitives, SampledErrorTable table,
                       MakeRenderer&& make) {
    return make_tuned_viewer(hierarchy, std::span<const P>(primitives), std::move(table), make);
}
/// Of what lies in pages.
template <class H, class MakeRenderer>
requires PagedAtRunTime<H>
auto make_tuned_viewer(const H& hierarchy, SampledErrorTable table, MakeRenderer&& make) {
    return make_tuned_viewer(hierarchy, hierarchy.primitives(), std::move(table), make);
}
/// What is made in the call is gone before the first frame: keep hierarchy and primitives in variables.
template <class H, class P, class MakeRenderer>
void make_tuned_viewer(const H&&, std::span<const P>, SampledErrorTable, MakeRenderer&&) = delete;
template <class H, class P, class MakeRenderer>
void make_tuned_viewer(const H&&, const std::vector<P>&, SampledErrorTable, MakeRenderer&&) = delete;
template <class H, class P, class MakeRenderer>
void make_tuned_viewer(const H&, const std::vector<P>&&, SampledErrorTable, MakeRenderer&&) = delete;

}  // namespace farfield
