// Several tensors at once give the splats that each gives alone, bit by bit.
#include "farfield/approximation/opacity_tensor/appearance_lanes.hpp"

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "catch.hpp"
#include "farfield/approximation/opacity_tensor.hpp"
#include "support/placed.hpp"
#include "support/random.hpp"
#include "support/views.hpp"

using namespace farfield;
using namespace farfield::test;

namespace {

using Tensors = std::vector<Placed<OpacityTensor>>;

/// Whatever bits may be stored; one in eight is what no contents gave.
StoredTensor random_tensor(Random& random) {
    const auto word = [&] {
        return std::uint64_t(random.below(1u << 31)) << 33 ^ std::uint64_t(random.below(1u << 31)) << 8;
    };
    StoredTensor t;
    if (random.below(8) == 0) return t;
    t.first = word() ^ random.below(256);
    t.second = word() ^ random.below(256);
    t.second &= ~(std::uint64_t(3) << 54);
    t.second |= std::uint64_t(random.below(3)) << 54;
    return t;
}

bool widths_agree(const OpacityTensor& policy, const Tensors& all, const LocalView& view,
                  const std::vector<Splat>& expected, bool& was_refused) {
    const std::vector<std::uint32_t> words = words_of(policy, all);
    const TensorOptions options{policy.closed_surfaces, policy.counts_overlap,
                                policy.closed_surfaces ? policy.closed_sheet_gain : policy.sheet_gain};
    return test::widths_agree(detail::tensor_kernels, all.size(), expected, was_refused,
                              [&](auto splats_of, std::size_t first, std::size_t n, PlacedSplats& out) {
                                  return splats_of(words.data() + first, n, view, options, out);
                              });
}

/// The derived policy draws nothing: who draws otherwise must not be bypassed.
struct Silent : OpacityTensor {
    template <class Sink>
    void draw_stand_in(const stand_in_data&, const Cell&, const LocalView&, Sink&&) const {}
};
struct Renamed : OpacityTensor {};
static_assert(detail::DrawsLargePlaced<OpacityTensor> && detail::DrawsLargePlaced<Renamed>);
static_assert(!detail::DrawsPlaced<Silent>);

}  // namespace

TEST_CASE("tensors drawn together are those drawn one by one", "[approximation]") {
    Random random(140);
    std::size_t drawn = 0;
    for (int round = 0; round < 400; ++round) {
        CAPTURE(round);
        OpacityTensor policy;
        policy.closed_surfaces = random.below(2) == 0;
        policy.counts_overlap = random.below(4) != 0;
        const float size = round % 8 == 0 ? std::ldexp(1.0f, int(random.below(160)) - 80) : 1.0f;
        Tensors all(1 + random.below(round % 50 == 0 ? 255 : 20));
        for (auto& p : all) p = {random_tensor(random), random_cell(random, size)};
        const glm::dvec3 eye = glm::dvec3(random.in_cube(3)) * double(size);
        const View view = round % 3 == 0 ? looking_orthographic(eye, {0, 0, 0}) : looking(eye, {0, 0, 0});
        const LocalView local(view, glm::dvec3(0), 4 * size);
        const auto splats = splats_either_way(policy, all, local);
        REQUIRE(splats);
        bool was_refused = false;
        CHECK(widths_agree(policy, all, local, *splats, was_refused));
        // Only squares of lengths that leave single precision are.
        if (was_refused) CHECK((size > 0x1p30f || size < 0x1p-20f));
        drawn += splats->size();
    }
    CHECK(drawn > 2000);
}

TEST_CASE("a tensor in the eye, behind it or beside it", "[approximation]") {
    const OpacityTensor policy;
    TensorShape s;
    s.root = {1, 0, 0, 1, 0, 1};
    s.center = glm::vec3(0.5f);
    s.extent = glm::vec3(1);
    s.rgb = glm::vec3(200, 100, 50);
    const StoredTensor data = StoredTensor::packed(s);
    Cell cell;
    cell.half = cell.bounds_half = glm::vec3(0.5f);
    for (const glm::dvec3 eye : {glm::dvec3(0, 0, 5), glm::dvec3(0, 0, 1e-3), glm::dvec3(0), glm::dvec3(0, 0, -5)}) {
        const LocalView local(looking(eye, eye - glm::dvec3(0, 0, 1)), glm::dvec3(0), 2);
        const Tensors all(7, {data, cell});
        const auto splats = splats_either_way(policy, all, local);
        REQUIRE(splats);
        CHECK(splats->size() == (eye.z > 0 ? 7 : 0));
    }
}
