// Work counts what drawing takes; a cost model says what a unit of each kind of work is worth: the third of the three
// policies.
#pragma once

#include "farfield/settings.hpp"

#include <concepts>
#include <cstdint>
#include <limits>
#include <type_traits>

namespace farfield {

/// Counts of each kind of work; fractions are allowed, since expected work is an average.
struct Work {
    float triangles = 0;  ///< triangles handed to the rasterizer
    float faces = 0;      ///< far-field faces drawn as polygons
    float splats = 0;     ///< far-field cells drawn as one deposit
    float images = 0;     ///< images made or drawn
    float texels = 0;     ///< texels made or drawn
    float cells = 0;      ///< nodes visited: culled, tested and descended
    float runs = 0;       ///< calls that draw a range of primitives

    Work& operator+=(const Work& w) {
        triangles += w.triangles;
        faces += w.faces;
        splats += w.splats;
        images += w.images;
        texels += w.texels;
        cells += w.cells;
        runs += w.runs;
        return *this;
    }
    friend Work operator*(Work w, float times) {
        return {w.triangles * times, w.faces * times, w.splats * times, w.images * times,
                w.texels * times,    w.cells * times, w.runs * times};
    }
};

/// Whether a cost model may ask that much for something: no NaN, nothing below 0.
inline bool is_price(float price) {
    return price >= 0 && price <= std::numeric_limits<float>::max();
}

/// One number, in one declared unit, for all kinds of work together.
template <class C>
concept CostModel = std::is_trivially_copyable_v<C> && requires(const C& c, const Work& work) {
    { c.cost(work) } -> std::convertible_to<float>;
    { C::unit } -> std::convertible_to<const char*>;
    { C::file_tag } -> std::convertible_to<std::uint32_t>;
};

}  // namespace farfield
