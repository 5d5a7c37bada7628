// One picture on many threads: bands of its rows are drawn at once, each by a renderer of its own, over one hierarchy.
//
//     BandedViewer viewer(hierarchy, primitives, 16, [&](std::size_t) { return ZBufferRenderer(options); });
//     viewer.frame(view, ThreadExecutor());
//     show(viewer.image());
//
// Sort-first parallel rendering (S. Molnar, M. Cox, D. Ellsworth, H. Fuchs, "A Sorting Classification of Parallel
// Rendering", IEEE Computer Graphics and Applications 14(4), 1994): a band visits the cells that it shows and no
// others, so nothing is handed from thread to thread, and a frame needs no lock. What is in two bands is visited twice.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <cstddef>
#include <memory>
#include <span>
#include <stdexcept>
#include <utility>
#include <vector>

#include "farfield/executor.hpp"
#include "farfield/fail.hpp"
#include "farfield/image.hpp"
#include "farfield/view.hpp"
#include "farfield/viewer.hpp"

namespace farfield {

/// A renderer whose picture can be had after the frame.
template <class R>
concept HasImage = requires(const R& r) {
    { r.image() } -> std::convertible_to<const Image&>;
};

/// Draws what a Viewer draws, byte for byte: bands are tiles (View::tile) as wide as the picture. It is the same on any
/// number of threads. Borrows hierarchy and primitives, which outlive it; the renderers are its own.
///
/// Bands of 32 rows or more cost little more than the picture at once; four bands a thread or more even out what
/// differs in work. Where renderers share sources (RendererFacts), all bands together keep one copy of the primitives.
template <class H, class P, class R>
class BandedViewer {
    static_assert(
        !caches_images<H>,
        "farfield: each band would keep images of its own, made at other times than those of its neighbors: a "
        "hierarchy that caches images needs a Viewer");

  public:
    /// make(band) returns a renderer; all must be made alike. Throws std::invalid_argument for no bands, and what
    /// Viewer throws.
    template <class MakeRenderer>
    BandedViewer(const H& hierarchy, PrimitiveSpan<P> primitives, std::size_t bands, MakeRenderer&& make) {
        if (bands == 0) detail::fail<std::invalid_argument>("farfield::BandedViewer: there must be a band or more");
        bands_.reserve(bands);
        for (std::size_t i = 0; i < bands; ++i) {
            // Renderers stay where they are, so they are made there.
            Band band{std::unique_ptr<R>(new R(make(i)))};
            band.viewer = i == 0 ? std::make_unique<Viewer<H, P, R>>(hierarchy, primitives, *band.renderer)
                                 : std::make_unique<Viewer<H, P, R>>(*bands_[0].viewer, *band.renderer);
            bands_.push_back(std::move(band));
        }
    }
    /// What is borrowed must outlive the viewer, as what is made in the call does not.
    template <class MakeRenderer>
    BandedViewer(const H&&, PrimitiveSpan<P>, std::size_t, MakeRenderer&&) = delete;

    /// Draws all bands; executor(count, f) calls f(0) ... f(count - 1), on any threads (AnyExecutor, ThreadExecutor).
    /// Counts are those of all bands together: what lies in two is counted twice. If bands throw, the executor decides
    /// what is thrown (ThreadExecutor: what the uppermost threw); the next frame is as if there had been no other.
    template <class Executor = SerialExecutor>
    FrameStats frame(const View& view, const Executor& executor = {}) {
        view.validate();
        if constexpr (HasImage<R>) {
            if (image_.width() != view.width || image_.height() != view.height) image_ = Image(view.width, view.height);
        }
        drawn_bands_ = place_bands(view.height);
        executor(drawn_bands_, [&](std::size_t i) { draw(bands_[i], view); });
        FrameStats sum;
        for (std::size_t i = 0; i < drawn_bands_; ++i) sum += bands_[i].stats;
        return sum;
    }

    /// The picture of the last frame.
    const Image& image() const requires HasImage<R> { return image_; }

    std::size_t bands() const { return bands_.size(); }
    /// How many bands had rows in the last frame: the first ones.
    std::size_t drawn_bands() const { return drawn_bands_; }
    /// A band's renderer, for what else it knows.
    const R& renderer(std::size_t band) const { return *bands_[band].renderer; }

  private:
    struct Band {
        std::unique_ptr<R> renderer;
        std::unique_ptr<Viewer<H, P, R>> viewer{};  ///< after its renderer, which it lets go of
        int first_row = 0, end_row = 0;
        FrameStats stats{};
    };

    /// Renderers keep blocks of 8 x 8 pixels or samples: borders between them cost nothing.
    static constexpr int rows_of_blocks = 8;

    /// Pixels beyond its own that a pixel gets samples from.
    static constexpr int reach_px() {
        if constexpr (requires { R::reach_px; }) return R::reach_px;
        return 0;
    }

    /// Returns how many bands have rows.
    std::size_t place_bands(int height) {
        const auto count = int(std::min(bands_.size(), std::size_t(height)));
        const int even = (height - 1) / count + 1;
        const int rows = (even - 1) / rows_of_blocks * rows_of_blocks + rows_of_blocks;
        std::size_t used = 0;
        for (int row = 0; row < height; row += rows) {
            bands_[used].first_row = row;
            bands_[used++].end_row = std::min(row + rows, height);
        }
        return used;
    }

    void draw(Band& band, const View& view) {
        const int first = std::max(band.first_row - reach_px(), 0);
        const int end = std::min(band.end_row + reach_px(), view.height);
        band.stats = band.viewer->frame(view.tile(0, first, view.width, end - first));
        if constexpr (HasImage<R>) {
            const Image& drawn = band.renderer->image();
            const std::size_t width = std::size_t(view.width);
            const auto from = drawn.pixels().begin() + std::ptrdiff_t(std::size_t(band.first_row - first) * width);
            std::copy(from, from + std::ptrdiff_t(std::size_t(band.end_row - band.first_row) * width),
                      &image_.at(0, band.first_row));
        }
    }

    std::vector<Band> bands_;
    std::size_t drawn_bands_ = 0;
    Image image_;
};

/// Prefer this to naming the type.
template <class H, class P, class MakeRenderer>
auto make_banded_viewer(const H& hierarchy, const std::vector<P>& primitives, std::size_t bands, MakeRenderer&& make) {
    using R = decltype(make(std::size_t(0)));
    return BandedViewer<H, P, R>(hierarchy, std::span<const P>(primitives), bands, make);
}
/// Of what a source of primitives answers for, see primitive_source.hpp.
template <class H, CountsPrimitives S, class MakeRenderer>
auto make_banded_viewer(const H& hierarchy, const S& source, std::size_t bands, MakeRenderer&& make) {
    using R = decltype(make(std::size_t(0)));
    return BandedViewer<H, IndexedPrimitive<S>, R>(hierarchy, IndexedSpan<S>(source), bands, make);
}
/// What is made in the call is gone before the first frame.
template <class H, class P, class MakeRenderer>
void make_banded_viewer(const H&&, const std::vector<P>&, std::size_t, MakeRenderer&&) = delete;
template <class H, class P, class MakeRenderer>
void make_banded_viewer(const H&, const std::vector<P>&&, std::size_t, MakeRenderer&&) = delete;

}  // namespace farfield
