#include "farfield/geometry/area_law.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "catch.hpp"
#include "support/random.hpp"

using namespace farfield;
using namespace farfield::test;

namespace {

constexpr AreaLaw laws[] = {AreaLaw::independent, AreaLaw::mixed, AreaLaw::coherent};

/// The law as it is defined, for any c.
double general(double t, double area, double c) {
    return std::max(0.0, (t + c) * std::exp(-area / (1 + c)) - c);
}

}  // namespace

TEST_CASE("what is deposited never lets more through, and never less than nothing", "[geometry]") {
    for (const AreaLaw law : laws) {
        for (float t = 0; t <= 1; t += 1.0f / 64) {
            CHECK(transmitted(t, 0, law) == t);
            float before = 2;
            for (float area = 0; area < 100; area = area * 1.3f + 0.01f) {
                const float left = transmitted(t, area, law);
                CHECK(left >= 0);
                CHECK(left <= t);
                CHECK(left <= before + 1e-6f);
                CHECK(left <= transmitted(t + 1.0f / 64, area, law));
                before = left;
            }
        }
    }
}

TEST_CASE("the three laws are one, for c of 0, 1 and infinity", "[geometry]") {
    for (float t = 0; t <= 1; t += 0.037f) {
        for (float area = 0; area < 30; area = area * 1.1f + 0.003f) {
            INFO("T " << t << ", area " << area);
            const double x = double(area);
            CHECK(std::abs(double(transmitted(t, area, AreaLaw::independent)) - general(double(t), x, 0)) < 1e-5);
            CHECK(std::abs(double(transmitted(t, area, AreaLaw::mixed)) - general(double(t), x, 1)) < 2e-5);
            CHECK(std::abs(double(transmitted(t, area, AreaLaw::coherent)) - std::max(0.0, double(t) - x)) < 1e-6);
            if (area < 2) {
                CHECK(std::abs(double(transmitted(t, area, AreaLaw::coherent)) - general(double(t), x, 1e7)) < 1e-5);
            }
        }
    }
}

TEST_CASE("what a small area takes is right in proportion", "[geometry]") {
    for (float area = 1e-20f; area < 1; area *= 1.5f) {
        const double exact = -std::expm1(-double(area));
        CHECK(std::abs(double(loss_of_area(area, AreaLaw::independent).relative) / exact - 1) < 1e-5);
    }
    constexpr float infinity = std::numeric_limits<float>::infinity();
    for (const AreaLaw law : laws) CHECK(transmitted(1, infinity, law) == 0);
}

TEST_CASE("the area that takes a part is the logarithm of what it leaves", "[geometry]") {
    for (float part = 0; part < 1; part = std::max(part * 1.01f, std::nextafter(part, 1.0f))) {
        const double expected = -std::log(1 - double(part));
        CHECK(std::abs(double(detail::absorbing_area(part)) - expected) <= 1e-7 + 1e-6 * expected);
        CHECK(std::abs(detail::absorbed(detail::absorbing_area(part)) - part) <= 2e-5f);
        if (part < 1e-9f) part = 1e-9f;
    }
    CHECK(detail::absorbing_area(0) == 0);
    CHECK(detail::absorbed(detail::absorbing_area(1)) == 1);
}

TEST_CASE("parts of areas cover together what all of them cover, and each more than its share where it is strewn",
          "[geometry]") {
    for (const AreaLaw law : laws) {
        for (const float opacity : {0.0f, 0.01f, 0.3f, 0.7f, 0.95f}) {
            for (const float part : {0.0f, 0.1f, 0.5f, 0.8f, 1.0f}) {
                const float of_part = opacity_of_part(opacity, part, law);
                CHECK(of_part >= opacity * part - 1e-5f);
                const float first = transmitted(1, loss_of_opacity(of_part, law));
                const float left = transmitted(first, loss_of_opacity(opacity_of_part(opacity, 1 - part, law), law));
                CHECK(left == Approx(1 - opacity).margin(3e-5));
            }
        }
    }
}

TEST_CASE("an area may be split into any parts", "[geometry]") {
    Random random(4);
    for (int i = 0; i < 3000; ++i) {
        const float start = random.unit(), area = random.between(0, 2.5f);
        std::vector<float> cuts = {0, 1};
        for (std::uint32_t k = random.below(30); k > 0; --k) cuts.push_back(random.unit());
        std::sort(cuts.begin(), cuts.end());
        for (const AreaLaw law : laws) {
            float left = start;
            for (std::size_t k = 1; k < cuts.size(); ++k) {
                left = transmitted(left, area * (cuts[k] - cuts[k - 1]), law);
            }
            CHECK(std::abs(left - transmitted(start, area, law)) < 3e-5f);
        }
    }
}

TEST_CASE("order does not matter within a law, and between laws by the product of the areas at most", "[geometry]") {
    Random random(5);
    for (int i = 0; i < 20000; ++i) {
        const float start = random.unit(), a = random.between(0, 1.2f), b = random.between(0, 1.2f);
        const AreaLaw first = laws[random.below(3)], second = laws[random.below(3)];
        const float difference =
            transmitted(transmitted(start, a, first), b, second) - transmitted(transmitted(start, b, second), a, first);
        INFO("laws " << int(first) << " and " << int(second) << ", areas " << a << " and " << b);
        CHECK(std::abs(difference) <= (first == second ? 0 : a * b) + 1e-6f);
    }
}

TEST_CASE("a loss spread over part of a sample commutes likewise", "[geometry]") {
    // What FarSamples does with the lanes of a sample: T' = T - part (relative T + absolute).
    Random random(6);
    for (int i = 0; i < 20000; ++i) {
        const AreaLaw law = laws[random.below(3)];
        const auto some = [&] {
            const Loss loss = loss_of_opacity(random.unit(), law);
            const float part = random.unit();
            return Loss{part * loss.relative, part * loss.absolute};
        };
        const float start = random.unit();
        const Loss a = some(), b = some();
        CHECK(std::abs(transmitted(transmitted(start, a), b) - transmitted(transmitted(start, b), a)) < 1e-6f);
    }
}

TEST_CASE("an opacity leaves one minus that opacity of a fresh sample", "[geometry]") {
    for (int i = 0; i <= 1000; ++i) {
        const float alpha = float(i) / 1000;
        for (const AreaLaw law : laws) {
            CHECK(std::abs(1 - transmitted(1, loss_of_opacity(alpha, law)) - alpha) < 1e-6f);
        }
    }
    CHECK(law_of_opacity(0) == AreaLaw::independent);
    CHECK(law_of_opacity(0.5f) == AreaLaw::mixed);
    CHECK(law_of_opacity(1) == AreaLaw::coherent);
    CHECK(law_of_opacity(0.375f) == AreaLaw::mixed);
    CHECK(law_of_opacity(std::nextafter(0.375f, 0.0f)) == AreaLaw::independent);
    CHECK(law_of_opacity(0.75f) == AreaLaw::coherent);
    CHECK(law_of_opacity(std::nextafter(0.75f, 0.0f)) == AreaLaw::mixed);
}
