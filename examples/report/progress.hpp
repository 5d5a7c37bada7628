// Something to look at while it takes long.
#pragma once

#include <chrono>
#include <string>

namespace farfield::report {

/// On stderr: a bar that is drawn over itself on a terminal, else a line for each task.
class Progress {
  public:
    Progress();
    ~Progress();
    Progress(const Progress&) = delete;
    Progress& operator=(const Progress&) = delete;

    /// Begins a task of so many steps; 0: nobody knows.
    void begin(std::string task, int steps = 0);
    void step();

  private:
    void draw();
    void erase();

    std::string task_;
    int steps_ = 0, done_ = 0;
    bool on_terminal_;
    std::chrono::steady_clock::time_point drawn_at_{};
};

}  // namespace farfield::report
