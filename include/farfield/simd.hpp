// Compiles the same kernel for several instruction sets and chooses one at run time.
//
// A kernel is one source file that is included once for each width, in a namespace of its own, where FARFIELD_LANES
// says how wide its vectors are. Any compiler makes vectors of one and four lanes for any machine; wider ones stand
// between FARFIELD_BEGIN_..._LANES and FARFIELD_END_LANES, which exist on x86-64 only.
#pragma once

#include "farfield/settings.hpp"

#include <cstdint>

// What kernels call beyond the compilers' own vectors. A processor of 32 bits may have four lanes of it.
#if defined(__x86_64__)
#include <immintrin.h>
#elif defined(__SSE2__)
#include <emmintrin.h>
#endif

namespace farfield {

/// How many lanes of 32 bits a kernel uses; all compute the same bits. If the kernel or the processor has fewer, the
/// most available are used, as with `automatic`.
enum class Simd : std::uint8_t { automatic, scalar, four_lanes, eight_lanes, sixteen_lanes };

namespace detail {

/// The most lanes that are wanted and that the processor has: 1, 4, 8 or 16, but only 1 or 4 outside x86-64. A kernel
/// written for fewer takes the most that it has.
inline int lanes_for(Simd wanted) {
    if (wanted == Simd::scalar) return 1;
#if defined(__x86_64__)
    // Processors with AVX2 and BMI2 have BMI, LZCNT and POPCNT too, which not every compiler can test for.
    const bool has_eight = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("bmi2");
    if (wanted == Simd::four_lanes || !has_eight) return 4;
    const bool has_sixteen = __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
                             __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl");
    return wanted == Simd::eight_lanes || !has_sixteen ? 8 : 16;
#else
    return 4;
#endif
}

}  // namespace detail

}  // namespace farfield

// Marks small functions that kernels call. Inlined, they are compiled for the kernel's instruction set; a call would
// mix the old and the new encoding of vector instructions, where the first old one waits for all registers.
#if defined(__GNUC__)
#define FARFIELD_INLINE [[gnu::always_inline]] inline
#else
#define FARFIELD_INLINE inline
#endif

#if defined(__x86_64__)

#define FARFIELD_PRAGMA(...) _Pragma(#__VA_ARGS__)
#if defined(__clang__)
#define FARFIELD_BEGIN_TARGET(features) \
    FARFIELD_PRAGMA(clang attribute push(__attribute__((target(features))), apply_to = function))
#define FARFIELD_END_LANES FARFIELD_PRAGMA(clang attribute pop)
#else
#define FARFIELD_BEGIN_TARGET(features) FARFIELD_PRAGMA(GCC push_options) FARFIELD_PRAGMA(GCC target features)
#define FARFIELD_END_LANES FARFIELD_PRAGMA(GCC pop_options)
#endif

// Functions from here to FARFIELD_END_LANES run only where lanes_for() gives that many lanes. Fused multiply-add is
// left out on purpose: all widths compute the same bits.
#define FARFIELD_BEGIN_EIGHT_LANES FARFIELD_BEGIN_TARGET("avx2,bmi,bmi2,lzcnt,popcnt")
#define FARFIELD_BEGIN_SIXTEEN_LANES \
    FARFIELD_BEGIN_TARGET("avx512f,avx512bw,avx512dq,avx512vl,avx2,bmi,bmi2,lzcnt,popcnt")

#endif
