// What a tolerance does, over every composable triple: more of it draws less, less of it errs less, and a step to the
// side changes little. On triangles all over; the other files have scenes that fail.
#include <cmath>
#include <cstdint>
#include <vector>

#include "catch.hpp"
#include "support/pictures.hpp"
#include "support/random.hpp"
#include "support/scenes.hpp"
#include "support/variants.hpp"

using namespace farfield;
using namespace farfield::test;

TEST_CASE("a larger tolerance never draws more primitives") {
    const Triangles triangles = random_triangles(8000, 6, 0.03f);
    for (const Variant& variant : all_variants()) {
        const auto h = variant.build(triangles);
        for (const glm::dvec3 eye : {glm::dvec3(3, 1, 2), glm::dvec3(0.1, 0.2, 0.1), glm::dvec3(-20, 3, 1)}) {
            std::uint64_t before = ~std::uint64_t(0);
            for (const float tolerance : {0.0f, 0.25f, 0.5f, 1.0f, 2.0f, 4.0f, 8.0f, 64.0f}) {
                INFO(variant.name << ", tolerance " << tolerance << ", eye " << eye.x);
                Recorder recorder;
                const FrameStats stats = h->frame(looking(eye, {0.5, 0, 0}, 256, tolerance), recorder);
                CHECK(stats.primitives <= before);
                before = stats.primitives;
            }
        }
    }
}

// 64 samples a pixel in the reference and in the pictures compared with it, so that what is seen is the error of
// stand-ins and not that of sampling.
TEST_CASE("the error falls, weakly, as the tolerance falls") {
    Triangles triangles = random_triangles(9000, 7, 0.03f);
    append(triangles, sphere({0.2f, 0, 0}, 0.6f, 50, {200, 120, 40, 255}));
    const ZBufferOptions options{.samples = 64};
    const View at = looking({3, 1.5, 2.5}, {}, 96);
    const Image exact = plain_picture<Triangle>(triangles, at, options);
    for (const Variant& variant : all_variants()) {
        if (!variant.stands_in) continue;
        const auto h = variant.build(triangles);
        double before = 1;
        for (const float tolerance : {8.0f, 4.0f, 2.0f, 1.0f, 0.5f, 0.0f}) {
            View view = at;
            view.tolerance_px = tolerance;
            const double error = rms_difference(h->picture(view, options), exact);
            INFO(variant.name << ", tolerance " << tolerance << ": " << error << " after " << before);
            CHECK(error <= before + 1e-4);
            before = error;
        }
        if (!variant.is_clipped) CHECK(before == 0);
        CHECK(variant.is_plain(h->picture(at, options), exact));
    }
}

// What may change when the eye moves by a thousandth of its distance: cells cross the tolerance, and edges move by a
// part of a pixel. On average over the picture that is little; where one pixel flips a lot, something else is wrong.
TEST_CASE("a camera that trembles does not make coverage flicker") {
    const Triangles triangles = random_triangles(20000, 9, 0.02f);
    Random random(10);
    const ZBufferOptions options{.samples = 16};
    const glm::dvec3 eye(6, 2, 3);
    const Image plain_still = plain_picture<Triangle>(triangles, looking(eye, {}, 96), options);
    for (const Variant& variant : all_variants()) {
        const auto h = variant.build(triangles);
        const Image still = h->picture(looking(eye, {}, 96, 1.5f), options);
        for (int i = 0; i < 3; ++i) {
            const glm::dvec3 there = eye + glm::dvec3(random.direction()) * (1e-3 * glm::length(eye));
            const Image trembled = h->picture(looking(there, {}, 96, 1.5f), options);
            const Image plain_trembled = plain_picture<Triangle>(triangles, looking(there, {}, 96), options);
            const double change = rms_difference(trembled, still),
                         without = rms_difference(plain_trembled, plain_still);
            INFO(variant.name << ": " << change << ", without stand-ins " << without << ", coverage "
                              << coverage(trembled) / coverage(still));
            CHECK(change <= 1.5 * without);
            CHECK(std::abs(coverage(trembled) / coverage(still) - 1) < 0.01);
        }
    }
}
