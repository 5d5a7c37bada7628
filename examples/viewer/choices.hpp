// Names and numbers that stand for choices: of scripts and of the command line.
#pragma once

#include <span>
#include <string>

#include "look.hpp"
#include "stage.hpp"

namespace viewer {

/// Sets what words[0] names to what the others say; script.hpp lists them. Variants are the stage's, if there is one.
/// Throws std::runtime_error, one line.
void choose(Look& look, const Stage* stage, std::span<const std::string> words);

}  // namespace viewer
