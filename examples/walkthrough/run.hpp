// Draws everything and measures it.
#pragma once

#include <vector>

#include "flight.hpp"
#include "options.hpp"
#include "result.hpp"
#include "setting.hpp"

namespace walkthrough {

/// One result a variant, in the order of the options. Writes pictures where these say so; throws std::runtime_error
/// where that fails.
std::vector<Result> run(const Setting& setting, const Options& options, const Flight& flight);

}  // namespace walkthrough
