// Counts calls of operator new, and lets one of them fail. promises/allocation.cpp replaces the operators of its
// program; only there does this do anything.
#pragma once

#include <cstddef>
#include <limits>
#include <new>

namespace farfield::test {

struct Allocations {
    std::size_t count = 0;
    std::size_t failing = 0;                                        ///< the count that throws; 0: none
    std::size_t largest = std::numeric_limits<std::size_t>::max();  ///< bytes; more throw
};
/// Those of this thread.
Allocations& allocations();

/// Whether f() throws std::bad_alloc, as its n-th allocation, from 1 on, does.
template <class F>
bool fails_for_memory(std::size_t n, F&& f) {
    Allocations& a = allocations();
    a.failing = a.count + n;
    bool failed = false;
    try {
        f();
    } catch (const std::bad_alloc&) {
        failed = true;
    }
    a.failing = 0;
    return failed;
}

}  // namespace farfield::test
