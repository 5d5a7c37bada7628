// How far the run is and how long it still takes.
#pragma once

#include <chrono>
#include <string>

#include "report/progress.hpp"

namespace farfield::bench {

/// Steps have guesses of their seconds on some machine; how wrong these are so far scales what is left.
class Schedule {
  public:
    /// Before the first step: what is to come.
    void plan(double seconds) { planned_ += seconds; }
    /// Says on stderr what is being done, which takes about so long.
    void begin(const std::string& task, double seconds, int steps = 0);
    /// A part of the task.
    void step() { progress_.step(); }

  private:
    report::Progress progress_;
    std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
    double planned_ = 0, done_ = 0, current_ = 0;
};

}  // namespace farfield::bench
