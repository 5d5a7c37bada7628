// Lengths, directions and normals of vectors whose squares leave single precision: coordinates may be as small as those
// of molecules in meters and as large as those of galaxies.
//
// A square of 2^63 units is infinite in single precision, and one of 2^-75 units is 0. Vectors are therefore multiplied
// by a power of two first, which rounds nothing: what is in range already gives the same bits with and without.
#pragma once

#include "farfield/settings.hpp"

#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

namespace farfield {

namespace detail {

/// Whether products of two, and sums of such products, neither overflow nor lose bits below the smallest number.
template <class T>
bool squares_are_exact(T square) {
    constexpr T least = sizeof(T) == 4 ? T(0x1p-60f) : T(0x1p-500), most = sizeof(T) == 4 ? T(0x1p120f) : T(0x1p1000);
    return square >= least && square <= most;
}

template <class T>
T largest_component(const glm::vec<3, T>& v) {
    const glm::vec<3, T> a = glm::abs(v);
    return glm::max(a.x, glm::max(a.y, a.z));
}

template <class T>
glm::vec<3, T> times_power_of_two(const glm::vec<3, T>& v, int exponent) {
    return {std::ldexp(v.x, exponent), std::ldexp(v.y, exponent), std::ldexp(v.z, exponent)};
}

}  // namespace detail

/// The exponent e for which |v| 2^-e is from 1/2 up to 1; 0 for 0 and what is not finite.
template <class T>
int exponent_of(T v) {
    int exponent = 0;
    if (std::isfinite(v)) std::frexp(v, &exponent);
    return exponent;
}

/// The vector times the power of two that brings its largest component to between 1/2 and 1.
template <class T>
glm::vec<3, T> scaled_to_one(const glm::vec<3, T>& v) {
    return detail::times_power_of_two(v, -exponent_of(detail::largest_component(v)));
}

namespace detail {

/// Not inlined, so that the common case is.
template <class T>
[[gnu::noinline]] T length_by_scaling(const glm::vec<3, T>& v) {
    const glm::vec<3, T> one = scaled_to_one(v);
    return std::ldexp(std::sqrt(glm::dot(one, one)), exponent_of(largest_component(v)));
}

}  // namespace detail

/// The length of a finite vector, as long as the length itself is a number.
template <class T>
T length_of(const glm::vec<3, T>& v) {
    const T square = glm::dot(v, v);
    return detail::squares_are_exact(square) ? std::sqrt(square) : detail::length_by_scaling(v);
}

/// The unit vector in the direction of a finite vector other than 0.
template <class T>
glm::vec<3, T> direction_of(const glm::vec<3, T>& v) {
    return glm::normalize(detail::squares_are_exact(glm::dot(v, v)) ? v : scaled_to_one(v));
}

/// A vector squarely to both, of any length; 0 if they are parallel.
template <class T>
glm::vec<3, T> normal_to(const glm::vec<3, T>& u, const glm::vec<3, T>& v) {
    const glm::vec<3, T> n = glm::cross(u, v);
    return detail::squares_are_exact(detail::largest_component(n)) ? n : glm::cross(scaled_to_one(u), scaled_to_one(v));
}

}  // namespace farfield
