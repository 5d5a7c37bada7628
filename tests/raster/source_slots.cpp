#include "farfield/raster/source_slots.hpp"

#include <cstdint>
#include <span>
#include <vector>

#include "catch.hpp"
#include "farfield/primitive/triangle.hpp"

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
