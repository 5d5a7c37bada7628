// Stand-ins that are drawn together (DrawsPlaced), and the splats that they give.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <optional>
#include <vector>

#include "farfield/approximation.hpp"
#include "farfield/approximation/placed/placed_splats.hpp"
#include "farfield/drawables.hpp"
#include "farfield/geometry/cell.hpp"
#include "farfield/view/local_view.hpp"
#include "support/random.hpp"

namespace farfield::test {

template <class A>
struct Placed {
    typename A::stand_in_data data;
    Cell cell;
};

inline Cell random_cell(Random& random, float size) {
    Cell cell;
    cell.center = random.in_cube(1) * size;
    cell.half = glm::vec3(random.between(0.01f, 0.2f), random.between(0.01f, 0.2f), random.between(0.01f, 0.2f)) * size;
    cell.bounds_center = cell.center + random.in_cube(0.01f) * size;
    cell.bounds_half = cell.half * random.between(0.5f, 1.5f);
    return cell;
}

/// Keeps what one stand-in after the other is drawn as.
struct SplatSink {
    std::vector<Splat>& splats;
    float splat_limit_px = std::numeric_limits<float>::max();
    void operator()(const Face&) const { is_splat = false; }
    void operator()(const Splat& s) const { splats.push_back(s); }
    mutable bool is_splat = true;  ///< all were
};

inline bool are_same(const std::vector<Splat>& a, const std::vector<Splat>& b) {
    return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(Splat)) == 0);
}

template <class A>
std::vector<std::uint32_t> words_of(const A& policy, const std::vector<Placed<A>>& all) {
    std::vector<std::uint32_t> words(A::words_placed * detail::placed_stride, 0x7fffffffu);  // NaN behind the last
    for (std::size_t i = 0; i < all.size(); ++i) policy.place(all[i].data, all[i].cell, words.data() + i);
    return words;
}

/// The splats of all, one by one, if placed together they are the same.
template <class A>
std::optional<std::vector<Splat>> splats_either_way(const A& policy, const std::vector<Placed<A>>& all,
                                                    const LocalView& view) {
    std::vector<Splat> one_by_one, together;
    const SplatSink sink{one_by_one};
    for (const auto& p : all) policy.draw_stand_in(p.data, p.cell, view, sink);
    const std::vector<std::uint32_t> words = words_of(policy, all);
    policy.draw_placed(words.data(), all.size(), view, SplatSink{together});
    if (!sink.is_splat || !are_same(together, one_by_one)) return std::nullopt;
    return one_by_one;
}

/// What a kernel gives with that many lanes; nothing where it wants more care. fill(first, n, out) runs it.
template <class Fill>
std::optional<std::vector<Splat>> splats_by_lanes(std::size_t lanes, std::size_t count, Fill&& fill) {
    std::vector<Splat> found;
    for (std::size_t first = 0; first < count; first += lanes) {
        PlacedSplats out;
        const std::size_t n = std::min(lanes, count - first);
        if (!fill(first, n, out)) return std::nullopt;
        for (std::size_t i = 0; i < n; ++i) {
            if (out.is_drawn[i] != 0) found.push_back(out[i]);
        }
    }
    return found;
}

/// Whether four lanes, and eight where the processor has them, give the same as one by one. fill(kernel, first, n, out)
/// runs one of `kernels`. `was_refused`: one wanted more care.
template <class Kernels, class Fill>
bool widths_agree(const Kernels& kernels, std::size_t count, const std::vector<Splat>& expected, bool& was_refused,
                  Fill&& fill) {
    for (const std::size_t lanes : {std::size_t(4), std::size_t(8)}) {
        if (lanes == 8 && detail::lanes_for(Simd::automatic) < 8) continue;
        const auto found = splats_by_lanes(lanes, count, [&](std::size_t first, std::size_t n, PlacedSplats& out) {
            return fill(lanes == 4 ? kernels.four : kernels.eight, first, n, out);
        });
        if (!found) {
            was_refused = true;
        } else if (!are_same(*found, expected)) {
            return false;
        }
    }
    return true;
}

}  // namespace farfield::test
