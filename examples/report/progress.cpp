#include "report/progress.hpp"

#include <unistd.h>

#include <iostream>
#include <utility>

namespace farfield::report {

Progress::Progress() : on_terminal_(isatty(STDERR_FILENO) != 0) {}

Progress::~Progress() {
    erase();
}

void Progress::begin(std::string task, int steps) {
    task_ = std::move(task);
    steps_ = steps;
    done_ = 0;
    if (on_terminal_) {
        draw();
    } else {
        std::cerr << task_ << std::endl;
    }
}

void Progress::step() {
    ++done_;
    // Ten times a second is as often as anybody looks, and keeps the terminal out of the times that are measured.
    if (on_terminal_ && std::chrono::steady_clock::now() - drawn_at_ > std::chrono::milliseconds(100)) draw();
}

void Progress::draw() {
    constexpr int width = 30;
    erase();
    if (steps_ > 0) {
        const int filled = width * done_ / steps_;
        std::cerr << '[' << std::string(std::size_t(filled), '#') << std::string(std::size_t(width - filled), ' ')
                  << "] ";
    }
    std::cerr << task_ << std::flush;
    drawn_at_ = std::chrono::steady_clock::now();
}

void Progress::erase() {
    if (on_terminal_) std::cerr << "\r\x1b[K" << std::flush;
}

}  // namespace farfield::report
