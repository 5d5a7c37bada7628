// A scene, and a walk through it with images of cells and without.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <limits>
#include <new>

#include "catch.hpp"
#include "farfield/approximation/exact.hpp"
#include "farfield/approximation/image_cache.hpp"
#include "farfield/build.hpp"
#include "farfield/cost_model/measured_time.hpp"
#include "farfield/partition/octree.hpp"
#include "farfield/renderer/z_buffer_renderer.hpp"
#include "farfield/viewer.hpp"
#include "support/scenes.hpp"

namespace farfield::test {

using CachedImages = SpatialHierarchy<Octree, ImageCache<Exact>, MeasuredTime>;
using Plain = SpatialHierarchy<Octree, Exact, MeasuredTime>;

inline ImageCache<Exact> with(const ImageCacheOptions& options) {
    ImageCache<Exact> a;
    a.image_options = options;
    return a;
}

/// With these, whatever may be an image is one.
inline MeasuredTime free_images() {
    MeasuredTime prices;
    prices.image = prices.texel = prices.made_image = prices.made_texel = 0;
    return prices;
}

/// Two dozen balls of triangles, strewn about the z axis from -30 to -80.
inline const Triangles& balls() {
    static const Triangles all = [] {
        Triangles out;
        for (std::uint64_t i = 0; i < 24; ++i) {
            Triangles ball = random_triangles(600, i + 1, 0.15f);
            const glm::vec3 at(float(int(i * 7 % 11) - 5) * 4, float(int(i * 5 % 7) - 3) * 3, -30.0f - 2.1f * float(i));
            for (Triangle& t : ball) {
                for (glm::vec3& v : t.vertices) v += at;
                out.push_back(t);
            }
        }
        return out;
    }();
    return all;
}

/// A rectangle without holes, at a slant.
inline Triangles wall() {
    return sheet({-12, -9, -30}, {24, 0, 0}, {0, 18, -6}, 96, 96, {200, 180, 40, 255});
}

inline View seen_from(glm::dvec3 eye, glm::dvec3 target = {0, 0, -50}) {
    View view;
    view.width = 160;
    view.height = 120;
    view.camera = Camera::perspective(eye, target, {0, 1, 0}, 0.7f);
    return view;
}

/// Root mean square, of colors in [0, 255].
inline double difference(const Image& a, const Image& b) {
    REQUIRE(a.pixels().size() == b.pixels().size());
    double sum = 0;
    for (std::size_t i = 0; i < a.pixels().size(); ++i) {
        const Rgba8 p = a.pixels()[i], q = b.pixels()[i];
        for (const int d : {p.r - q.r, p.g - q.g, p.b - q.b, p.a - q.a}) sum += double(d * d);
    }
    return std::sqrt(sum / (4 * double(a.pixels().size())));
}

/// Pixels that something covers, and all four around, and how many of these another picture shows nothing in.
struct CoveredPixels {
    int all = 0, lost = 0;
};
inline CoveredPixels covered_pixels(const Image& covered, const Image& shown) {
    CoveredPixels pixels;
    const auto is_covered = [&](int x, int y) { return covered.at(x, y).a != 0; };
    for (int y = 1; y + 1 < covered.height(); ++y) {
        for (int x = 1; x + 1 < covered.width(); ++x) {
            if (!(is_covered(x, y) && is_covered(x - 1, y) && is_covered(x + 1, y) && is_covered(x, y - 1) &&
                  is_covered(x, y + 1)))
                continue;
            ++pixels.all;
            pixels.lost += shown.at(x, y).a == 0;
        }
    }
    return pixels;
}

/// A ZBufferRenderer that is given one slice of an image after the other.
inline constexpr RendererFacts slice_by_slice = [] {
    RendererFacts facts = ZBufferRenderer::facts;
    facts.slices_images = false;
    return facts;
}();

/// Counts images that there are, and may run out of memory for more.
class CountedImages : public ZBufferRenderer {
  public:
    static constexpr RendererFacts facts = slice_by_slice;
    using ZBufferRenderer::ZBufferRenderer;
    void begin_image(const LocalView& view, float depth, int samples) {
        ZBufferRenderer::begin_image(view, depth, samples);
    }
    std::uint32_t end_image() {
        if (left_to_make == 0) throw std::bad_alloc();
        --left_to_make;
        ++alive;
        return ZBufferRenderer::end_image();
    }
    void free_image(std::uint32_t image) {
        --alive;
        ZBufferRenderer::free_image(image);
    }
    int left_to_make = std::numeric_limits<int>::max(), alive = 0;
};

template <class R = ZBufferRenderer>
struct Walk {
    CachedImages hierarchy;
    Plain plain = build<Plain>(balls());
    R renderer{ZBufferOptions{.background = {90, 120, 160, 255}}};
    R plain_renderer{ZBufferOptions{.background = {90, 120, 160, 255}}};
    Viewer<CachedImages, Triangle, R> viewer;
    Viewer<Plain, Triangle, R> plain_viewer;

    explicit Walk(const ImageCacheOptions& options = {.least_items = 64}, const MeasuredTime& prices = {})
        : hierarchy(build<CachedImages>(balls(), {.approximation = with(options), .cost_model = prices})),
          viewer(hierarchy, balls(), renderer),
          plain_viewer(plain, balls(), plain_renderer) {}

    FrameStats frame(const View& view) { return viewer.frame(view); }
    const Image& image() const { return renderer.image(); }
    const Image& exact(const View& view) {
        plain_viewer.frame(view);
        return plain_renderer.image();
    }
};

}  // namespace farfield::test
