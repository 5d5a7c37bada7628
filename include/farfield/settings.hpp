// What the compiler's settings and macros of others must not be, checked before any other header is read.
//
// The same scene gives the same picture, byte for byte, with any optimization and any compiler, if a * b + c is not
// contracted into one rounding: compile with -ffp-contract=off where that matters. g++ contracts wherever the machine
// has the instruction (-march=native), clang since 14 within a statement. Nothing else depends on it.
#pragma once

#if !defined(__GNUC__)
#error "farfield needs g++ 12, clang 14 or newer: it computes with their vectors"
#endif

// Infinities and NaN mean something here: an empty box, a plane that nobody sees, an input to be refused.
#if (defined(__FAST_MATH__) || (defined(__FINITE_MATH_ONLY__) && __FINITE_MATH_ONLY__)) && \
    !defined(FARFIELD_ALLOW_FAST_MATH)
#error \
    "farfield is wrong under -ffast-math: compile what includes it without -ffast-math and -ffinite-math-only, \
or with -fno-finite-math-only; FARFIELD_ALLOW_FAST_MATH takes the risk"
#endif

// <windows.h> defines these two unless NOMINMAX is defined. Headers of libstdc++ drop them in the same way.
#undef min
#undef max
