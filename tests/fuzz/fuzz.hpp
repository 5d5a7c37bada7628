// What each fuzzer defines and its drivers call: libFuzzer's (with_libfuzzer.cpp), and one for any compiler
// (replay.cpp). (replay.cpp).
#pragma once

#include <cstdint>
#include <span>

namespace farfield::fuzz {

/// Tries one input. Any exception is a finding.
void run(std::span<const std::uint8_t> bytes);

}  // namespace farfield::fuzz
