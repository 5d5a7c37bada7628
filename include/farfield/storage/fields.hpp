// The numbers that a policy or a record is made of, one by one, so that files hold no bytes of padding: those differ
// from run to run, and the same hierarchy would not give the same file.
//
// An aggregate tells its number of fields by how many initializers it takes, and a structured binding names them:
// Antony Polukhin's Boost.PFR. Base classes, C arrays and private members do not compile; pointers are told.
#pragma once

#include "farfield/settings.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <glm/vec3.hpp>
#include <limits>
#include <span>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

namespace farfield::detail {

inline constexpr std::size_t most_fields = 18;
inline constexpr std::size_t not_numbers = std::numeric_limits<std::size_t>::max();

struct AnyField {
    template <class T>
    operator T() const;
};

template <class T, std::size_t... number>
constexpr bool takes_fields(std::index_sequence<number...>) {
    return requires {
        T{(void(number), AnyField{})...};
    };
}
template <class T, std::size_t n = most_fields + 1>
constexpr std::size_t field_count() {
    if constexpr (n == 0 || takes_fields<T>(std::make_index_sequence<n>())) {
        return n;
    } else {
        return field_count<T, n - 1>();
    }
}

/// References to the fields of an aggregate.
template <class T>
constexpr auto fields_of(T& v) {
    constexpr std::size_t n = field_count<std::remove_const_t<T>>();
    static_assert(n > 0 && n <= most_fields,
                  "farfield: to be stored in files, an aggregate may have 18 fields at most");
#define FARFIELD_FIELDS(count, ...)   \
    if constexpr (n == count) {       \
        auto& [__VA_ARGS__] = v;      \
        return std::tie(__VA_ARGS__); \
    } else
    FARFIELD_FIELDS(1, a)
    FARFIELD_FIELDS(2, a, b)
    FARFIELD_FIELDS(3, a, b, c)
    FARFIELD_FIELDS(4, a, b, c, d)
    FARFIELD_FIELDS(5, a, b, c, d, e)
    FARFIELD_FIELDS(6, a, b, c, d, e, f)
    FARFIELD_FIELDS(7, a, b, c, d, e, f, g)
    FARFIELD_FIELDS(8, a, b, c, d, e, f, g, h)
    FARFIELD_FIELDS(9, a, b, c, d, e, f, g, h, i)
    FARFIELD_FIELDS(10, a, b, c, d, e, f, g, h, i, j)
    FARFIELD_FIELDS(11, a, b, c, d, e, f, g, h, i, j, k)
    FARFIELD_FIELDS(12, a, b, c, d, e, f, g, h, i, j, k, l)
    FARFIELD_FIELDS(13, a, b, c, d, e, f, g, h, i, j, k, l, m)
    FARFIELD_FIELDS(14, a, b, c, d, e, f, g, h, i, j, k, l, m, o)
    FARFIELD_FIELDS(15, a, b, c, d, e, f, g, h, i, j, k, l, m, o, p)
    FARFIELD_FIELDS(16, a, b, c, d, e, f, g, h, i, j, k, l, m, o, p, q)
    FARFIELD_FIELDS(17, a, b, c, d, e, f, g, h, i, j, k, l, m, o, p, q, r)
    FARFIELD_FIELDS(18, a, b, c, d, e, f, g, h, i, j, k, l, m, o, p, q, r, s)
    return std::tuple<>();
#undef FARFIELD_FIELDS
}

/// long double has padding of its own.
template <class T>
concept Number = (std::is_arithmetic_v<T> || std::is_enum_v<T>)&&!std::is_same_v<T, long double>;
template <class T>
inline constexpr std::size_t vector_length = 0;
template <glm::length_t n, class T, glm::qualifier alignment>
inline constexpr std::size_t vector_length<glm::vec<n, T, alignment>> = std::size_t(n);
template <class T>
concept GlmVector = vector_length<T>
!= 0;
template <class T>
struct IsArray : std::false_type {};
template <class T, std::size_t n>
struct IsArray<std::array<T, n>> : std::true_type {};

template <class T>
constexpr std::size_t bytes_of_numbers();

template <class... F>
constexpr std::size_t bytes_of_tied(std::type_identity<std::tuple<F&...>>) {
    const std::array<std::size_t, sizeof...(F)> bytes{bytes_of_numbers<F>()...};
    std::size_t sum = 0;
    for (const std::size_t b : bytes) {
        if (b == not_numbers) return not_numbers;
        sum += b;
    }
    return sum;
}

/// Size of all numbers in a T, without padding; not_numbers if it holds anything else.
template <class T>
constexpr std::size_t bytes_of_numbers() {
    if constexpr (std::is_empty_v<T>) {
        return 0;
    } else if constexpr (Number<T>) {
        return sizeof(T);
    } else if constexpr (GlmVector<T>) {
        return vector_length<T> * sizeof(typename T::value_type);
    } else if constexpr (IsArray<T>::value) {
        constexpr std::size_t one = bytes_of_numbers<typename T::value_type>();
        return one == not_numbers ? not_numbers : std::tuple_size_v<T> * one;
    } else if constexpr (std::is_class_v<T> && std::is_aggregate_v<T>) {
        return bytes_of_tied(std::type_identity<decltype(fields_of(std::declval<T&>()))>());
    } else {
        return not_numbers;
    }
}

template <class T>
concept MadeOfNumbers = bytes_of_numbers<T>()
!= not_numbers;
/// A record that may lie in a file as it lies in memory.
template <class T>
concept WithoutPadding = std::is_empty_v<T> || bytes_of_numbers<T>()
== sizeof(T);

/// Calls f(number) for each, in the order of declaration.
template <class T, class F>
requires MadeOfNumbers<std::remove_const_t<T>>
void for_each_number(T& v, F&& f) {
    using U = std::remove_const_t<T>;
    if constexpr (std::is_empty_v<U>) {
    } else if constexpr (Number<U>) {
        f(v);
    } else if constexpr (GlmVector<U>) {
        for (std::size_t i = 0; i < vector_length<U>; ++i) f(v[typename U::length_type(i)]);
    } else if constexpr (IsArray<U>::value) {
        for (auto& element : v) for_each_number(element, f);
    } else {
        std::apply([&](auto&... field) { (for_each_number(field, f), ...); }, fields_of(v));
    }
}

template <MadeOfNumbers T>
std::vector<std::byte> bytes_of(const T& v) {
    std::vector<std::byte> bytes(bytes_of_numbers<T>());
    std::size_t at = 0;
    for_each_number(v, [&](const auto& number) {
        std::memcpy(bytes.data() + at, &number, sizeof number);
        at += sizeof number;
    });
    return bytes;
}

/// Reads as many bytes as bytes_of() gives. False if a bool is neither 0 nor 1.
template <MadeOfNumbers T>
bool read_numbers(std::span<const std::byte> bytes, T& v) {
    bool good = true;
    const std::byte* p = bytes.data();
    for_each_number(v, [&](auto& number) {
        if constexpr (std::is_same_v<std::remove_reference_t<decltype(number)>, bool>) {
            good = good && (*p == std::byte(0) || *p == std::byte(1));
            number = *p != std::byte(0);
        } else {
            std::memcpy(&number, p, sizeof number);
        }
        p += sizeof number;
    });
    return good;
}

}  // namespace farfield::detail
