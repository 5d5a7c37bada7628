// Viewers of one hierarchy, one for each number of samples a pixel.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <memory>
#include <utility>
#include <vector>

#include "farfield/primitive_source.hpp"
#include "farfield/viewer.hpp"

namespace farfield::detail {

/// They share what renderers share. Hierarchy and primitives are borrowed.
template <class H, class P, class R>
class ViewersBySamples {
  public:
    struct Drawn {
        int samples;
        std::unique_ptr<R> renderer;
        std::unique_ptr<Viewer<H, P, R>> viewer{};  ///< after its renderer, which it lets go of
    };

    template <class MakeRenderer>
    void add(const H& hierarchy, PrimitiveSpan<P> primitives, int samples, MakeRenderer&& make) {
        // Renderers stay where they are, so they are made there.
        Drawn drawn{samples, std::unique_ptr<R>(new R(make(samples)))};
        drawn.viewer = all_.empty() ? std::make_unique<Viewer<H, P, R>>(hierarchy, primitives, *drawn.renderer)
                                    : std::make_unique<Viewer<H, P, R>>(*all_.front().viewer, *drawn.renderer);
        all_.push_back(std::move(drawn));
    }
    const Drawn& first() const { return all_.front(); }
    /// Of a number that was added.
    const Drawn& at(int samples) const {
        return *std::find_if(all_.begin(), all_.end(), [&](const Drawn& d) { return d.samples == samples; });
    }

  private:
    std::vector<Drawn> all_;
};

}  // namespace farfield::detail
