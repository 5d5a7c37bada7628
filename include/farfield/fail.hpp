// What the library does where it cannot go on: it throws, or tells the hook of a program without exceptions.
#pragma once

#include "farfield/settings.hpp"

#include <exception>
#include <utility>

#if defined(__cpp_exceptions) || defined(__EXCEPTIONS) || defined(_CPPUNWIND)
#define FARFIELD_HAS_EXCEPTIONS 1
#else
#define FARFIELD_HAS_EXCEPTIONS 0
#include <cstdio>
#include <cstdlib>
#endif

namespace farfield {

/// Where exceptions are off (-fno-exceptions), this gets the message that an exception would have carried. It must not
/// return; if it does, or is empty as it is at first, the program ends by std::abort, with the message on stderr if
/// nobody took it. Set it before other threads use the library. Nothing calls it where exceptions are on.
inline void (*on_failure)(const char* message) = nullptr;

namespace detail {

/// Throws Exception(arguments...). Every `throw` of the library is this one.
template <class Exception, class... Arguments>
[[noreturn]] void fail(Arguments&&... arguments) {
#if FARFIELD_HAS_EXCEPTIONS
    throw Exception(std::forward<Arguments>(arguments)...);
#else
    const Exception failure(std::forward<Arguments>(arguments)...);
    if (on_failure != nullptr) {
        on_failure(failure.what());
    } else {
        std::fputs(failure.what(), stderr);
        std::fputc('\n', stderr);
    }
    std::abort();
#endif
}

/// Calls f(), and otherwise() from within the handler if f throws an Exception.
template <class Exception, class F, class G>
void guarded(F&& f, [[maybe_unused]] G&& otherwise) {
#if FARFIELD_HAS_EXCEPTIONS
    try {
        f();
    } catch (const Exception&) {
        otherwise();
    }
#else
    f();
#endif
}

/// Calls f(), and otherwise() from within the handler whatever f throws.
template <class F, class G>
void guarded(F&& f, [[maybe_unused]] G&& otherwise) {
#if FARFIELD_HAS_EXCEPTIONS
    try {
        f();
    } catch (...) {
        otherwise();
    }
#else
    f();
#endif
}

}  // namespace detail
}  // namespace farfield
