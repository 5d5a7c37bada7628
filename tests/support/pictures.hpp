// Pictures without a hierarchy, and how far two pictures are apart.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <span>
#include <string>

#include "farfield/image.hpp"
#include "farfield/primitive.hpp"
#include "farfield/renderer/z_buffer_renderer.hpp"
#include "farfield/view.hpp"
#include "farfield/view/local_view.hpp"
#include "support/views.hpp"

namespace farfield::test {

/// The view as an outermost hierarchy over these primitives sees it.
template <class P>
LocalView local_view(std::span<const P> primitives, const View& view, glm::dvec3& origin) {
    auto whole = decltype(primitive_traits<P>::bounds(primitives[0]))::empty();
    for (const P& p : primitives) whole.add(primitive_traits<P>::bounds(p));
    origin = glm::dvec3(0);
    if constexpr (has_double_bounds<P>) {
        if (!whole.is_empty()) origin = whole.center();
    }
    Box local = Box::empty();
    for (const P& p : primitives) local.add(local_bounds(p, origin));
    return LocalView(view, origin, local);
}
template <class P>
LocalView local_view(std::span<const P> primitives, const View& view) {
    glm::dvec3 origin;
    return local_view(primitives, view, origin);
}

/// Every primitive in the user's order, in one run: the oracle.
template <class P>
Image plain_picture(std::span<const P> primitives, const View& view, const ZBufferOptions& options = {}) {
    glm::dvec3 origin;
    const LocalView local = local_view(primitives, view, origin);
    ZBufferRenderer renderer(options);
    Source<P> source{primitives, {}, std::uint32_t(primitives.size()), origin, 0};
    source.id = renderer.upload(source);
    renderer.begin_frame(local);
    renderer.set_view(local);
    const Range all{0, source.item_count};
    renderer.draw(source, std::span<const Range>(&all, 1));
    renderer.end_frame();
    return renderer.image();
}

inline int different_pixels(const Image& a, const Image& b) {
    if (a.width() != b.width() || a.height() != b.height()) return -1;
    int count = 0;
    for (std::size_t i = 0; i < a.pixels().size(); ++i) count += a.pixels()[i] != b.pixels()[i];
    return count;
}

/// Largest difference of a channel, alpha included, 0 to 255.
inline int largest_difference(const Image& a, const Image& b) {
    int largest = a.width() == b.width() && a.height() == b.height() ? 0 : 999;
    for (std::size_t i = 0; i < a.pixels().size() && largest < 999; ++i) {
        const Rgba8 p = a.pixels()[i], q = b.pixels()[i];
        for (const int d : {p.r - q.r, p.g - q.g, p.b - q.b, p.a - q.a}) largest = std::max(largest, std::abs(d));
    }
    return largest;
}

/// Root mean square over four channels in [0, 1].
inline double rms_difference(const Image& a, const Image& b) {
    double sum = 0;
    for (std::size_t i = 0; i < a.pixels().size(); ++i) {
        const Rgba8 p = a.pixels()[i], q = b.pixels()[i];
        for (const int d : {p.r - q.r, p.g - q.g, p.b - q.b, p.a - q.a}) sum += double(d) * d;
    }
    return std::sqrt(sum / (4.0 * double(a.pixels().size()))) / 255;
}

/// Sum of alpha in pixels.
inline double coverage(const Image& a) {
    double sum = 0;
    for (const Rgba8 p : a.pixels()) sum += p.a;
    return sum / 255;
}

}  // namespace farfield::test
