// Every variant is saved, opened and drawn as before, and keeps its table of errors.
#include <cstdint>
#include <optional>
#include <string>

#include "catch.hpp"
#include "farfield/tuning/error_table.hpp"
#include "farfield/tuning/sampled_error_table.hpp"
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
        const auto kept = built->stored(SampledErrorTable(ErrorTable({{0, 0.1, 1}, {2, 0.05, 1.0 / 3}}), 4));
        CHECK((kept && kept->at(4).trials()[1].cost == 1.0 / 3));
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
