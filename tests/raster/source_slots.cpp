#include "farfield/raster/source_slots.hpp"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "catch.hpp"
#include "farfield/primitive/triangle.hpp"
#include "support/scenes.hpp"

using namespace farfield;
using namespace farfield::detail;

namespace {

struct Count {
    std::size_t primitives;
    explicit Count(const Source<Triangle>& source) : primitives(source.primitives.size()) {}
};

}  // namespace

TEST_CASE("sources keep their number until they are released, and the first free one is taken again", "[raster]") {
    const std::vector<Triangle> triangles(9);
    const auto source = [&](std::size_t count) {
        Source<Triangle> s;
        s.primitives = std::span<const Triangle>(triangles).first(count);
        s.item_count = std::uint32_t(count);
        return s;
    };
    SourceSlots<Count> slots;
    CHECK(slots.upload(source(3)) == 0);
    CHECK(slots.upload(source(5)) == 1);
    CHECK(slots.upload(source(7)) == 2);
    const Count* const kept = &slots[2];
    slots.release(1);
    slots.release(0);
    CHECK(&slots[2] == kept);
    CHECK(slots.upload(source(1)) == 0);
    CHECK(slots.upload(source(2)) == 1);
    CHECK(slots.upload(source(9)) == 3);
    for (const auto& [id, primitives] : {std::pair(0u, 1u), std::pair(1u, 2u), std::pair(2u, 7u), std::pair(3u, 9u)}) {
        CHECK(slots[id].primitives == primitives);
    }
}

TEST_CASE("equal sources share a slot until all are released, wherever they lie", "[raster]") {
    struct Bytes {
        explicit Bytes(const Source<Triangle>& source) : size(source.item_count) {}
        std::size_t size;
        std::size_t bytes() const { return size; }
    };
    const std::vector<Triangle> triangles = test::random_triangles(20, 820), copy = triangles;
    const std::vector<std::uint32_t> backwards{4, 3, 2, 1, 0};
    Source<Triangle> a{triangles, {}, 20}, b{copy, {}, 20};
    SourceSlots<Bytes> slots;
    const std::uint32_t id = slots.upload(a);
    CHECK(slots.upload(b) == id);
    CHECK(slots.upload(a) == id);
    CHECK(slots.bytes() == 20);
    Source<Triangle> fewer = a, turned = a;
    fewer.item_count = 5;
    turned.item_count = 5;
    turned.order = backwards;
    Source<Triangle> elsewhere = a;
    elsewhere.origin = {1, 0, 0};
    const std::uint32_t others[] = {slots.upload(fewer), slots.upload(turned), slots.upload(elsewhere)};
    CHECK((others[0] != id && others[1] != id && others[2] != id));
    CHECK((others[0] != others[1] && others[1] != others[2]));
    // The same place with another color.
    std::vector<Triangle> changed = triangles;
    changed[19].rgba.g ^= 1;
    const std::uint32_t green = slots.upload(Source<Triangle>{changed, {}, 20});
    CHECK(green != id);
    slots.release(green);
    for (const std::uint32_t other : others) slots.release(other);
    slots.release(id);
    slots.release(id);
    CHECK(slots.bytes() == 20);
    CHECK(slots[id].size == 20);
    slots.release(id);
    CHECK(slots.bytes() == 0);
    CHECK(slots.upload(a) == 0);
}

TEST_CASE("many sources take no longer each than few, and numbers stay small", "[raster]") {
    const std::vector<Triangle> triangles = test::random_triangles(3000, 821);
    SourceSlots<Count> slots;
    for (int round = 0; round < 2; ++round) {
        for (std::uint32_t i = 0; i < 3000; ++i) {
            REQUIRE(slots.upload(Source<Triangle>{std::span(triangles).subspan(i, 1), {}, 1}) == i);
        }
        for (std::uint32_t i = 0; i < 3000; ++i) slots.release((i * 7) % 3000);
    }
}

TEST_CASE("one knows when slots are gone", "[raster]") {
    std::weak_ptr<const void> lifetime;
    {
        SourceSlots<Count> slots;
        lifetime = slots.lifetime();
        CHECK_FALSE(lifetime.expired());
    }
    CHECK(lifetime.expired());
}
