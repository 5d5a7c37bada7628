#include "farfield/renderer/keyed_order.hpp"

#include <algorithm>
#include <random>
#include <set>
#include <stdexcept>
#include <vector>

#include "catch.hpp"
#include "farfield/primitive/triangle.hpp"

using namespace farfield;

namespace {

struct Piece : Triangle {
    std::uint32_t material = 0;
    std::uint32_t key() const { return material; }
};

}  // namespace

TEST_CASE("parts hold what the ranges hold, at most one for each key of a range, few keys or one a primitive") {
    std::mt19937 random(3);
    for (const std::uint32_t materials : {1u, 4u, 32u, 33u, 500u, 100'000u}) {
        std::vector<Piece> pieces(1500);
        std::vector<std::uint32_t> order;
        for (std::uint32_t i = 0; i < pieces.size(); ++i) {
            pieces[i].material = std::uint32_t(random() % materials) * 3;
            order.push_back(std::uint32_t(pieces.size()) - 1 - i);
        }
        Source<Piece> source;
        source.primitives = pieces;
        source.order = order;
        source.item_count = std::uint32_t(order.size());
        const KeyedOrder keyed(source);
        std::vector<KeyedPart> parts;
        std::size_t allocated = 0;
        for (int frame = 0; frame < 30; ++frame) {
            std::vector<Range> ranges;
            std::size_t most = 0;
            std::multiset<std::uint32_t> wanted, found;
            for (std::uint32_t at = 0; at < order.size();) {
                const Range range{at, std::min(std::uint32_t(random() % 60), std::uint32_t(order.size()) - at)};
                at += range.count + std::uint32_t(random() % 20) + 1;
                std::set<std::uint32_t> keys;
                for (std::uint32_t i = range.first; i < range.first + range.count; ++i) {
                    wanted.insert(i);
                    keys.insert(source[i].material);
                }
                most += keys.size();
                ranges.push_back(range);
            }
            keyed.parts_of(ranges, parts);
            CHECK(parts.size() <= most);
            for (std::size_t i = 0; i < parts.size(); ++i) {
                const KeyedPart& part = parts[i];
                if (i > 0) CHECK((parts[i - 1].key < part.key || parts[i - 1].first + parts[i - 1].count < part.first));
                for (std::uint32_t k = part.first; k < part.first + part.count; ++k) {
                    found.insert(keyed.positions()[k]);
                    if (source[keyed.positions()[k]].material != part.key) FAIL("a part of two keys");
                }
            }
            CHECK(found == wanted);
            allocated = std::max(allocated, parts.capacity());
        }
        CHECK(allocated <= 2 * pieces.size());
    }
}

TEST_CASE("ranges of nothing have no parts, and a source that changes is refused") {
    Source<Piece> source;
    KeyedOrder none(source);
    std::vector<KeyedPart> parts(3);
    none.parts_of({}, parts);
    CHECK(parts.empty());
    const Range empty{0, 0};
    none.parts_of({&empty, 1}, parts);
    CHECK(parts.empty());
    CHECK((none.key_count() == 0 && none.positions().empty()));
    source.changes = true;
    CHECK_THROWS_AS(KeyedOrder(source), std::invalid_argument);
}
