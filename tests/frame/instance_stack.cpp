#include "farfield/frame/instance_stack.hpp"

#include <utility>
#include <vector>

#include "catch.hpp"

using namespace farfield;
using farfield::detail::InstanceStack;

namespace {

/// On the x axis; whether it is an instance, it says.
struct Thing {
    float x = 0;
    bool is_instance = false;
    Box bounds() const { return {glm::vec3(x - 1), glm::vec3(x + 1)}; }
    template <class F>
    bool visit_instance(F&& f) const {
        if (is_instance) f(*this);
        return is_instance;
    }
};

using Ranges = std::vector<std::pair<std::uint32_t, std::uint32_t>>;

struct Gathered {
    InstanceStack stack;
    Ranges ranges;
    void gather(const std::vector<Thing>& things, std::uint32_t first, std::uint32_t end, std::uint32_t left_out = 99) {
        Source<Thing> source;
        source.primitives = things;
        source.item_count = std::uint32_t(things.size());
        stack.gather(
            source, first, end, [](glm::vec3 p) { return p.x; }, [&](std::uint32_t at) { return at != left_out; },
            [&](std::uint32_t from, std::uint32_t to) {
                if (from != to) ranges.emplace_back(from, to);
            });
    }
    std::vector<std::uint32_t> drawn_before(std::size_t& next, float key) {
        std::vector<std::uint32_t> out;
        next = stack.draw_before(next, key, [&](std::uint32_t at) { out.push_back(at); });
        return out;
    }
};

const std::vector<Thing> things{{5, false}, {3, true}, {9, true}, {1, false}, {0, false}, {1, true}, {7, false}};

}  // namespace

TEST_CASE("instances are taken out of runs, and come nearest first") {
    Gathered g;
    g.gather(things, 0, 7);
    CHECK(g.ranges == Ranges{{0, 1}, {3, 5}, {6, 7}});
    REQUIRE(g.stack.size() == 3);
    std::size_t next = 0;
    CHECK(g.drawn_before(next, 1).empty());
    CHECK(g.drawn_before(next, 4) == std::vector<std::uint32_t>{5, 1});
    CHECK(g.drawn_before(next, 4).empty());
    CHECK(g.drawn_before(next, 100) == std::vector<std::uint32_t>{2});
    CHECK(next == 3);
}

TEST_CASE("what was drawn already is not gathered again, and parts of a range are") {
    Gathered g;
    g.gather(things, 1, 6, 2);
    CHECK(g.ranges == Ranges{{3, 5}});
    std::size_t next = 0;
    CHECK(g.drawn_before(next, 100) == std::vector<std::uint32_t>{5, 1});
}

TEST_CASE("a level of the stack is in order by itself, and is taken away with its descent") {
    Gathered g;
    g.gather(things, 2, 3);  // at 9
    const std::size_t outer = g.stack.size();
    g.gather(things, 1, 2);  // at 3
    g.gather(things, 5, 6);  // at 1, of another level
    CHECK(g.stack.size() == 3);
    std::size_t next = 0, inner = outer;
    CHECK(g.drawn_before(inner, 100) == std::vector<std::uint32_t>{1, 5});
    g.stack.resize(outer);
    CHECK(g.drawn_before(next, 100) == std::vector<std::uint32_t>{2});
}
