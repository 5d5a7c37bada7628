// Images of cells that viewers keep from frame to frame, over any other approximation.
//
// J. Shade, D. Lischinski, D. H. Salesin, T. DeRose, J. Snyder: Hierarchical Image Caching for Accelerated Walkthroughs
// of Complex Environments, SIGGRAPH 1996. What lives across frames lives in the viewer (frame/kept_images.hpp);
// hierarchies stay as they are, and any number of viewers may cache images of one.
#pragma once

#include "farfield/settings.hpp"

#include "farfield/approximation.hpp"
#include "farfield/image_cache_options.hpp"

namespace farfield {

/// Draws what Inner draws, and cells by images of that where it pays: where a frame is dear. Images pay over any other
/// approximation, for they hold whatever it draws.
template <class Inner>
struct ImageCache : Inner {
    static constexpr ApproximationFacts facts = [] {
        ApproximationFacts f = Inner::facts;
        f.caches_images = true;
        return f;
    }();

    /// Files hold what this one holds, and can be opened as either; what is kept of images is the viewer's, and how is
    /// said anew.
    using stored_approximation = Inner;

    ImageCacheOptions image_options{};

    const ImageCacheOptions& images() const { return image_options; }
    const char* wrong_option() const {
        if (const char* why = image_options.wrong_option()) return why;
        if constexpr (requires(const Inner& inner) { inner.wrong_option(); }) return Inner::wrong_option();
        return nullptr;
    }
};

}  // namespace farfield
