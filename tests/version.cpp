#include "farfield/version.hpp"

#include "catch.hpp"

TEST_CASE("Versions compare as numbers") {
    static_assert(FARFIELD_VERSION ==
                  FARFIELD_VERSION_MAJOR * 10000 + FARFIELD_VERSION_MINOR * 100 + FARFIELD_VERSION_PATCH);
    static_assert(FARFIELD_VERSION >= 100 && FARFIELD_VERSION_MINOR < 100 && FARFIELD_VERSION_PATCH < 100);
}
