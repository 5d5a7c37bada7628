// The entry point of libFuzzer: clang++ -fsanitize=fuzzer.
#include <cstddef>
#include <cstdint>

#include "fuzz/fuzz.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    farfield::fuzz::run({data, size});
    return 0;
}
