#include "farfield/storage/fields.hpp"

#include <array>
#include <cstdint>
#include <cstring>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <new>
#include <vector>

#include "catch.hpp"

using namespace farfield::detail;

namespace {

enum class Kind : std::uint8_t { one, two };
struct Nothing {};
struct Inner {
    Kind kind = Kind::one;
    float weight = 0;
};
struct Mixed {
    std::uint8_t small = 0;
    double large = 0;
    bool flag = false;
    Inner inner;
    glm::vec3 point{0};
    std::array<std::uint16_t, 3> list{};
    Nothing nothing;
};
struct Tight {
    glm::vec4 plane{0};
    std::array<std::uint16_t, 2> list{};
    std::uint32_t last = 0;
};
struct HasPointer {
    int* p = nullptr;
};
struct HasConstructor {
    explicit HasConstructor(int v) : value(v) {}
    int value;
};
struct Twelve {
    int a = 0, b = 1, c = 2, d = 3, e = 4, f = 5, g = 6, h = 7, i = 8, j = 9, k = 10, l = 11;
};

}  // namespace

TEST_CASE("what is made of numbers, and what is not") {
    STATIC_REQUIRE(MadeOfNumbers<Nothing>);
    STATIC_REQUIRE(MadeOfNumbers<int>);
    STATIC_REQUIRE(MadeOfNumbers<Mixed>);
    STATIC_REQUIRE(MadeOfNumbers<Twelve>);
    STATIC_REQUIRE_FALSE(MadeOfNumbers<int*>);
    STATIC_REQUIRE_FALSE(MadeOfNumbers<long double>);
    STATIC_REQUIRE_FALSE(MadeOfNumbers<HasPointer>);
    STATIC_REQUIRE_FALSE(MadeOfNumbers<HasConstructor>);
    STATIC_REQUIRE(bytes_of_numbers<Mixed>() == 1 + 8 + 1 + 1 + 4 + 12 + 6);
}

TEST_CASE("padding is told from numbers") {
    STATIC_REQUIRE(WithoutPadding<Tight>);
    STATIC_REQUIRE(WithoutPadding<Nothing>);
    STATIC_REQUIRE(WithoutPadding<glm::vec3>);
    STATIC_REQUIRE_FALSE(WithoutPadding<Inner>);
    STATIC_REQUIRE_FALSE(WithoutPadding<Mixed>);
}

TEST_CASE("numbers come back in the order of declaration") {
    const Mixed m{7, 0.1, true, {Kind::two, 0.3f}, {1, 2, 3}, {4, 5, 6}, {}};
    const std::vector<std::byte> bytes = bytes_of(m);
    REQUIRE(bytes.size() == bytes_of_numbers<Mixed>());
    Mixed back;
    REQUIRE(read_numbers(bytes, back));
    CHECK(back.small == 7);
    CHECK(back.large == 0.1);
    CHECK(back.flag);
    CHECK(back.inner.kind == Kind::two);
    CHECK(back.inner.weight == 0.3f);
    CHECK(back.point == glm::vec3(1, 2, 3));
    CHECK(back.list == std::array<std::uint16_t, 3>{4, 5, 6});

    int sum = 0;
    const Twelve twelve;
    for_each_number(twelve, [&](int n) { sum = 2 * sum + n; });
    CHECK(sum == 4083);  // 2^12 - 13: the n-th weighs 2^(11 - n)
}

TEST_CASE("what was in memory before does not show") {
    std::vector<std::byte> first;
    for (const int fill : {0x00, 0xff, 0x5a}) {
        alignas(Mixed) std::byte memory[sizeof(Mixed)];
        std::memset(memory, fill, sizeof memory);
        const Mixed* const m = new (memory) Mixed{7, 0.1, true, {Kind::two, 0.3f}, {1, 2, 3}, {4, 5, 6}, {}};
        const std::vector<std::byte> bytes = bytes_of(*m);
        if (first.empty()) first = bytes;
        CHECK(bytes == first);
    }
}

TEST_CASE("a byte that is neither true nor false is refused") {
    std::vector<std::byte> bytes = bytes_of(Mixed{});
    Mixed m;
    bytes[9] = std::byte(1);
    CHECK(read_numbers(bytes, m));
    bytes[9] = std::byte(2);
    CHECK_FALSE(read_numbers(bytes, m));
}
