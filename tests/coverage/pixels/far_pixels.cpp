#include "farfield/coverage/pixels/far_pixels.hpp"

#include <cstdint>
#include <utility>

#include "catch.hpp"

namespace farfield::test {
namespace {

constexpr std::uint64_t left_half = 0x0f0f0f0f0f0f0f0fu, right_half = ~left_half;

}  // namespace

TEST_CASE("two coherent halves close a pixel, wherever they lie") {
    for (const auto& [one, other] : {std::pair{left_half, right_half}, {0x00000000ffffffffu, 0xffffffff00000000u}}) {
        FarPixels far;
        far.begin(1);
        CHECK_FALSE(far.has_any());
        const Loss whole = loss_of_opacity(1, AreaLaw::coherent);
        far.deposit(5, one, one, whole, glm::vec3(1, 0, 0));
        CHECK(far.touched(0) == 1u << 5);
        CHECK_FALSE(far.is_closed(5));
        far.deposit(5, other, other, whole, glm::vec3(0, 1, 0));
        CHECK(far.is_closed(5));
        int pixels = 0;
        far.for_touched([&](std::size_t at, glm::vec3 rgb, float alpha) {
            ++pixels;
            CHECK(at == 5);
            CHECK(alpha == 1.0f);
            CHECK(rgb == glm::vec3(0.5f, 0.5f, 0));
        });
        CHECK(pixels == 1);
        CHECK(far.behind(5, 17, {200, 100, 50, 255}) == Rgba8{0, 0, 0, 0});
    }
}

TEST_CASE("independent deposits let through the product, each lane for itself") {
    FarPixels far;
    far.begin(2);
    const Loss half = loss_of_opacity(0.5f, AreaLaw::independent);
    const auto first = far.deposit(64, all_subcells, all_subcells, half, glm::vec3(1));
    const auto second = far.deposit(64, left_half, left_half, half, glm::vec3(1));
    for (unsigned lane = 0; lane < FarPixels::lane_count; ++lane) {
        CHECK(first[lane] == 0.5f);
        CHECK(second[lane] == (lane % 4 < 2 ? 0.5f : 1.0f));
    }
    CHECK(far.behind(64, 0, {200, 100, 40, 255}) == Rgba8{50, 25, 10, 63});
    CHECK(far.behind(64, 7, {200, 100, 40, 255}) == Rgba8{100, 50, 20, 127});
    far.for_touched([&](std::size_t, glm::vec3, float alpha) { CHECK(alpha == 0.625f); });
}

TEST_CASE("what is behind geometry is not seen, but takes its part all the same") {
    FarPixels far;
    far.begin(1);
    far.deposit(0, all_subcells, left_half, loss_of_opacity(0.5f, AreaLaw::mixed), glm::vec3(1));
    far.for_touched([&](std::size_t, glm::vec3 rgb, float alpha) {
        CHECK(alpha == 0.25f);
        CHECK(rgb == glm::vec3(0.25f));
    });
    CHECK(far.behind(0, 7, {255, 255, 255, 255}).a == 127);
}

TEST_CASE("a frame forgets the one before") {
    FarPixels far;
    far.begin(1);
    far.deposit(3, all_subcells, all_subcells, loss_of_opacity(1, AreaLaw::coherent), glm::vec3(1));
    far.begin(1);
    CHECK(far.touched(0) == 0);
    far.deposit(3, left_half, left_half, loss_of_opacity(1, AreaLaw::coherent), glm::vec3(1));
    CHECK_FALSE(far.is_closed(3));
}

}  // namespace farfield::test
