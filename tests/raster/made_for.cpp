#include "farfield/raster/made_for.hpp"

#include <new>
#include <vector>

#include "catch.hpp"

using namespace farfield::detail;

TEST_CASE("buffers are made when another size is wanted, and again if that failed", "[raster]") {
    MadeFor<BufferSize> made_for;
    std::vector<BufferSize> made;
    const auto make = [&](BufferSize size, bool fails) {
        return made_for(size, [&] {
            made.push_back(size);
            if (fails) throw std::bad_alloc();
        });
    };
    CHECK(make({0, 0}, false));
    CHECK(make({3, 4}, false));
    CHECK_FALSE(make({3, 4}, false));
    CHECK(make({4, 3}, false));
    CHECK(made.size() == 3);
    CHECK_THROWS_AS(make({9, 9}, true), std::bad_alloc);
    CHECK_THROWS_AS(make({9, 9}, true), std::bad_alloc);
    CHECK(make({4, 3}, false));  // which it was made for before
    CHECK_FALSE(make({4, 3}, false));
    CHECK(made.size() == 6);
}
