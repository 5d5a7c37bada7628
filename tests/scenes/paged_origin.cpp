#include "scenes/paged_origin.hpp"

#include <filesystem>
#include <limits>
#include <string>

#include "catch.hpp"
#include "files.hpp"

using namespace farfield;
using namespace farfield::scenes;
using namespace farfield::scenes::test;

TEST_CASE("an origin is kept beside pages to the last digit, and only where it is not 0", "[scenes]") {
    const TemporaryDirectory directory;
    const auto pages = directory.path() / "city.farfield";
    const auto file = directory.path() / "city.farfield.origin";
    CHECK(kept_origin(pages) == glm::dvec3(0));
    constexpr double largest = std::numeric_limits<double>::max(), least = std::numeric_limits<double>::min();
    for (const glm::dvec3& origin : {glm::dvec3(500'000.1, -1.0 / 3, 5'400'000.3), glm::dvec3(largest, -least, 0)}) {
        keep_origin(pages, origin);
        CHECK(kept_origin(pages) == origin);
    }
    keep_origin(pages, glm::dvec3(0));
    CHECK(!std::filesystem::exists(file));
    for (const char* no : {"", "1 2", "1 2 three", "1 2 3 4", "1 2 inf", "1 2 nan"}) {
        CAPTURE(no);
        directory.write("city.farfield.origin", no);
        CHECK_THROWS_WITH(kept_origin(pages), Catch::Matchers::Contains("city.farfield.origin"));
    }
    CHECK_THROWS_WITH(keep_origin(directory.path() / "no" / "folder.farfield", glm::dvec3(1)),
                      Catch::Matchers::Contains("folder.farfield.origin: cannot be written"));
}
