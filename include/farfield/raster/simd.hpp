// The same kernel for several instruction sets, chosen at run time: what may be asked for, what the processor has, and
// how a kernel is compiled for it.
//
// A kernel is one source file that is included once for each width, in a namespace of its own, with FARFIELD_LANES
// saying how wide its vectors are. Every compiler makes vectors of one and four lanes of what it has; wider ones stand
// between FARFIELD_BEGIN_..._LANES and FARFIELD_END_LANES, which exist on x86-64 only.
#pragma once

#include <cstdint>

namespace farfield {

/// How many lanes of 32 bits a kernel uses; all compute the same bits. More than the kernel or the processor has mean
/// the most that there are, and so does `automatic`.
enum class Simd : std::uint8_t { automatic, scalar, four_lanes, eight_lanes, sixteen_lanes };

/// The most lanes that are wanted and the processor has: 1, 4, 8 or 16, and 1 or 4 anywhere but on x86-64. A kernel
/// that is not written for as many takes the most that it is written for.
inline int lanes_for(Simd wanted) {
    if (wanted == Simd::scalar) return 1;
#if defined(__x86_64__)
    // What has AVX2 and BMI2 has BMI, LZCNT and POPCNT, not all of which every compiler can ask for.
    const bool has_eight = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("bmi2");
    if (wanted == Simd::four_lanes || !has_eight) return 4;
    const bool has_sixteen = __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
                             __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl");
    return wanted == Simd::eight_lanes || !has_sixteen ? 8 : 16;
#else
    return 4;
#endif
}

}  // namespace farfield

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

// Functions from here to FARFIELD_END_LANES are for processors of which lanes_for() gives as many lanes. Fused
// multiply-add is left out on purpose: all widths compute the same bits.
#define FARFIELD_BEGIN_EIGHT_LANES FARFIELD_BEGIN_TARGET("avx2,bmi,bmi2,lzcnt,popcnt")
#define FARFIELD_BEGIN_SIXTEEN_LANES \
    FARFIELD_BEGIN_TARGET("avx512f,avx512bw,avx512dq,avx512vl,avx2,bmi,bmi2,lzcnt,popcnt")

#endif
