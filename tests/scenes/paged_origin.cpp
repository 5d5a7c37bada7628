#include "scenes/paged_origin.hpp"

#include <limits>
#include <string>

#include "catch.hpp"

using namespace farfield;
using namespace farfield::scenes;

TEST_CASE("an origin is noted to the last digit, and only where it is not 0", "[scenes]") {
    CHECK(notes_of_origin(glm::dvec3(0)).empty());
    CHECK(origin_in({}, "city.farfield") == glm::dvec3(0));
    constexpr double largest = std::numeric_limits<double>::max(), least = std::numeric_limits<double>::min();
    for (const glm::dvec3& origin : {glm::dvec3(500'000.1, -1.0 / 3, 5'400'000.3), glm::dvec3(largest, -least, 0)}) {
        CHECK(origin_in(notes_of_origin(origin), "city.farfield") == origin);
    }
    for (const char* no : {"", "1 2", "1 2 three", "1 2 3 4", "1 2 inf", "1 2 nan"}) {
        CAPTURE(no);
        CHECK_THROWS_WITH(origin_in({{"origin", no}}, "city.farfield"), Catch::Matchers::Contains("city.farfield: "));
    }
}
