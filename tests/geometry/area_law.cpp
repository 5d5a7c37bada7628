#include "farfield/geometry/area_law.hpp"

#include <cmath>

#include "catch.hpp"
#include "support/random.hpp"

using namespace farfield;
using namespace farfield::test;

namespace {
constexpr AreaLaw laws[] = {AreaLaw::independent, AreaLaw::mixed, AreaLaw::coherent};
}

TEST_CASE("what is deposited never lets more through, and never less than nothing", "[geometry]") {
    for (const AreaLaw law : laws) {
        for (float t = 0; t <= 1; t += 1.0f / 64) {
            CHECK(transmitted(t, 0, law) == Approx(t).margin(1e-6));
            float before = 2;
            for (float area = 0; area < 20; area = area * 1.3f + 0.01f) {
                const float left = transmitted(t, area, law);
                CHECK(left >= 0);
                CHECK(left <= t * 1.000001f);
                CHECK(left <= before);
                CHECK(left <= transmitted(t + 1.0f / 64, area, law));
                before = left;
            }
        }
    }
}

TEST_CASE("coherent and mixed areas may be split into any parts", "[geometry]") {
    Random random(4);
    for (int i = 0; i < 5000; ++i) {
        const AreaLaw law = i % 2 ? AreaLaw::mixed : AreaLaw::coherent;
        const float start = random.unit(), a = random.between(0, 1.2f), b = random.between(0, 1.2f);
        CHECK(std::abs(transmitted(transmitted(start, a, law), b, law) - transmitted(start, a + b, law)) < 2e-6f);
    }
}

TEST_CASE("independent areas let through what an exponential does, to 0.002 below one half", "[geometry]") {
    for (float area = 0; area < 0.5f; area += 0.001f) {
        const double exact = std::exp(-double(area)), left = double(transmitted(1, area, AreaLaw::independent));
        CHECK(left - exact >= -1e-7);
        CHECK(left - exact <= 0.002);
        // So splitting in parts errs by as much at most.
        const float half = area / 2;
        CHECK(std::abs(transmitted(transmitted(1, half, AreaLaw::independent), half, AreaLaw::independent) -
                       float(left)) <= 0.002f);
    }
    for (float area = 0.5f; area < 30; area *= 1.1f) {
        CHECK(double(transmitted(1, area, AreaLaw::independent)) >= std::exp(-double(area)));
    }
}

TEST_CASE("the general law is the same for its three exponents", "[geometry]") {
    for (float t = 0.01f; t <= 1; t += 0.037f) {
        for (float area = 0; area < 1.5f; area += 0.05f) {
            const auto general = [&](double k) {
                return std::pow(std::max(0.0, std::pow(double(t), k) - k * double(area)), 1 / k);
            };
            CHECK(std::abs(double(transmitted(t, area, AreaLaw::coherent)) - general(1)) < 1e-6);
            CHECK(std::abs(double(transmitted(t, area, AreaLaw::mixed)) - general(0.5)) < 1e-6);
            if (area < 0.5f)
                CHECK(std::abs(double(transmitted(t, area, AreaLaw::independent)) - general(1e-6)) < 0.002);
        }
    }
}

TEST_CASE("the area of an opacity leaves one minus that opacity", "[geometry]") {
    for (int i = 0; i <= 1000; ++i) {
        const float alpha = float(i) / 1000;
        for (const AreaLaw law : laws) {
            if (law == AreaLaw::independent && alpha > 0.5f) continue;
            const double error = std::abs(1 - double(transmitted(1, area_of_opacity(alpha, law), law)) - double(alpha));
            INFO("law " << int(law) << ", alpha " << alpha);
            CHECK(error <= (law == AreaLaw::independent ? 0.01 : 1e-6));
        }
        const AreaLaw law = law_of_opacity(alpha);
        CHECK(std::abs(1 - transmitted(1, area_of_opacity(alpha, law), law) - alpha) < 0.004f);
    }
    CHECK(law_of_opacity(0) == AreaLaw::independent);
    CHECK(law_of_opacity(0.5f) == AreaLaw::mixed);
    CHECK(law_of_opacity(1) == AreaLaw::coherent);
}
