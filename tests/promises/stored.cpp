// Every variant is saved, opened and drawn as before.
#include <cstdint>
#include <optional>
#include <string>

#include "catch.hpp"
#include "support/pictures.hpp"
#include "support/scenes.hpp"
#include "support/variants.hpp"

using namespace farfield;
using namespace farfield::test;

TEST_CASE("a variant that was saved and opened gives the same pictures, byte for byte") {
    const Triangles triangles = mixed_triangles(2500, 195);
    const DirectionalLight default_light{};
    for (const Variant& variant : all_variants()) {
        INFO(variant.name);
        const auto built = variant.build(triangles, default_light);
        const auto opened = built->stored();
        CHECK(opened->bytes() == built->bytes());
        CHECK(opened->stand_in_count() == built->stand_in_count());
        for (const float tolerance : {0.0f, 2.0f, 16.0f}) {
            for (const View& view : {looking({2, 1, 2}, {}, 64, tolerance), looking({6, -4, 5}, {}, 64, tolerance),
                                     looking_orthographic({1, 2, 3}, {}, 3, 64, tolerance)}) {
                CHECK(opened->picture(view, {.light = default_light}) ==
                      built->picture(view, {.light = default_light}));
            }
        }
    }
}
