#include "farfield/frame/kept_images.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <optional>
#include <vector>

#include "catch.hpp"
#include "farfield/view.hpp"
#include "support/random.hpp"

using namespace farfield;
using namespace farfield::detail;

namespace {

LocalView looking(glm::dvec3 eye, glm::dvec3 target, glm::dvec2 off_center = {0, 0}) {
    View view;
    view.width = 321;
    view.height = 200;
    view.camera = Camera::perspective(eye, target, {0, 1, 0}, 0.8f);
    view.camera.off_center = off_center;
    return LocalView(view, glm::dvec3(0), 50.0f);
}

CellImage image_of(std::uint64_t bytes, std::uint32_t handle) {
    CellImage image;
    image.slices = 1;
    image.handles[0] = handle;
    image.bytes = bytes;
    return image;
}

}  // namespace

TEST_CASE("cells are found again by path and node", "[kept_images]") {
    KeptImages kept;
    CHECK(kept.find({1, 2}) == nullptr);
    std::vector<CellId> ids;
    for (std::uint64_t path = 0; path < 20; ++path) {
        for (std::uint32_t node = 0; node < 100; ++node) ids.push_back({path, node});
    }
    for (std::uint32_t i = 0; i < ids.size(); ++i) CHECK(kept.index_of(ids[i]) == i);
    for (std::uint32_t i = 0; i < ids.size(); ++i) {
        CHECK(kept.index_of(ids[i]) == i);
        REQUIRE(kept.find(ids[i]) != nullptr);
        CHECK(kept.find(ids[i])->id.node == ids[i].node);
    }
    CHECK(kept.find({20, 0}) == nullptr);
}

TEST_CASE("cells that were not seen for long are forgotten where there are many", "[kept_images]") {
    KeptImages kept;
    for (std::uint32_t node = 0; node < 5000; ++node) kept.cell(kept.index_of({0, node})).seen_frame = kept.frame();
    kept.keep(kept.cell(kept.index_of({0, 77})), image_of(10, 1));
    for (int f = 0; f < 100; ++f) kept.begin_frame();
    for (std::uint32_t node = 0; node < 6000; ++node) kept.cell(kept.index_of({1, node})).seen_frame = kept.frame();
    kept.begin_frame();
    CHECK(kept.find({0, 78}) == nullptr);
    REQUIRE(kept.find({0, 77}) != nullptr);  // it has an image
    CHECK(kept.image_of(*kept.find({0, 77}))->handles[0] == 1);
}

TEST_CASE("room is made by what was unseen for longest, and never by what is in use", "[kept_images]") {
    KeptImages kept;
    std::vector<std::uint32_t> freed;
    const auto free_handle = [&](std::uint32_t handle) { freed.push_back(handle); };
    for (std::uint32_t i = 0; i < 4; ++i) {
        kept.begin_frame();
        KeptCell& cell = kept.cell(kept.index_of({0, i}));
        REQUIRE(kept.make_room(10, 40, free_handle));
        kept.keep(cell, image_of(10, i + 1));
        cell.drawn_frame = kept.frame();
    }
    CHECK(kept.bytes() == 40);
    CHECK(freed.empty());
    kept.begin_frame();
    CHECK(kept.make_room(20, 40, free_handle));
    CHECK(freed == std::vector<std::uint32_t>{1, 2});
    CHECK(kept.bytes() == 20);
    CHECK(kept.make_room(30, 40, free_handle));  // the third is two frames old
    CHECK(freed == std::vector<std::uint32_t>{1, 2, 3});
    CHECK_FALSE(kept.make_room(40, 40, free_handle));  // the fourth was drawn in the last frame
    CHECK_FALSE(kept.make_room(41, 40, free_handle));
    CHECK(kept.image_count() == 1);
    kept.forget_all(free_handle);
    CHECK(kept.bytes() == 0);
    CHECK(freed.size() == 4);
}

TEST_CASE("a cell's rectangle holds all of it, wherever the picture's center lies", "[kept_images]") {
    test::Random random(5);
    int some = 0;
    for (int round = 0; round < 200; ++round) {
        const glm::vec3 center = random.in_cube(10) + glm::vec3(0, 0, -25), half = glm::abs(random.in_cube(4));
        const LocalView view = looking({0, 0, 0}, glm::dvec3(random.in_cube(8)) + glm::dvec3(0, 0, -30),
                                       round % 2 == 0 ? glm::dvec2(0) : glm::dvec2(0.3, -0.6));
        const auto rect = image_rect(view, center, half);
        if (!rect) continue;
        ++some;
        const LocalView inner = view.rectangle(rect->left, rect->top, rect->width, rect->height);
        for (int i = 0; i < 50; ++i) {
            const glm::vec3 p = center + half * random.in_cube(1);
            for (std::size_t plane = 0; plane < 4; ++plane) {
                REQUIRE(glm::dot(glm::vec3(inner.planes[plane]), p) + inner.planes[plane].w > 0);
            }
        }
        // The image's rectangle, seen from where it was made, is the pixels' rectangle.
        const CellImage image = planned_image(view, center, half, *rect, 1);
        const ImageQuad quad = image.quad(0);
        for (std::size_t plane = 0; plane < 4; ++plane) {
            const glm::vec3 at = plane == 0 || plane == 3 ? quad.corner : quad.corner + quad.across + quad.down;
            const float distance = glm::dot(glm::vec3(inner.planes[plane]), at) + inner.planes[plane].w;
            REQUIRE(distance == Approx(0).margin(1e-3));
        }
        REQUIRE(is_good(image, view, {}));
    }
    CHECK(some > 50);
}

TEST_CASE("an image of depth slices stays good for longer than one of a single rectangle", "[kept_images]") {
    const LocalView view = looking({0, 0, 0}, {0, 0, -1});
    const glm::vec3 center(1, 2, -30), half(3, 3, 4);
    const std::optional<ImageRect> rect = image_rect(view, center, half);
    REQUIRE(rect);
    for (const bool is_conservative : {false, true}) {
        const ImageCacheOptions options{.is_conservative = is_conservative};
        const auto good_for = [&](int slices) {
            CellImage image = planned_image(view, center, half, *rect, slices);
            const auto steps = [&] {
                LocalView moved = view;
                for (int k = 1; k < 4096; ++k) {
                    moved.eye = view.eye + glm::vec3(0.002f, 0.001f, -0.0005f) * float(k);
                    if (!is_good(image, moved, options)) return k - 1;
                }
                return 4096;
            };
            const int without_zone = steps();
            set_safety_zone(image, view, options);
            CHECK(image.safe_radius > 0);
            CHECK(steps() == without_zone);  // the zone answers sooner, and no more than what is asked without it
            return without_zone;
        };
        const int one = good_for(1), four = good_for(4);
        CHECK(one > 0);
        CHECK(four > 3 * one);
        CHECK(four < 5 * one);
    }
}
