// A display that nobody sees, for tests of engines.
#pragma once

#include <chrono>
#include <cstdlib>
#include <fstream>
#include <memory>
#include <string>
#include <thread>

#include "catch.hpp"
#include "support/temporary_directory.hpp"

namespace farfield::test {

/// (xvfb-run fails at times for what it cannot clean up.)
class Display {
  public:
    Display() {
        // Ten minutes, should a test end before this does.
        run("timeout 600 Xvfb -displayfd 3 -screen 0 640x480x24 -nolisten tcp 3>number 2>said & echo $! >pid");
        for (int i = 0; i < 600 && number().empty(); ++i) std::this_thread::sleep_for(std::chrono::milliseconds(50));
        setenv("DISPLAY", (":" + number()).c_str(), 1);
        setenv("LIBGL_ALWAYS_SOFTWARE", "1", 1);
    }
    ~Display() { run("kill $(cat pid)"); }
    Display(const Display&) = delete;
    Display& operator=(const Display&) = delete;

    /// Null where there is no Xvfb, and the test says so.
    static std::unique_ptr<Display> open() {
        if (std::system("command -v Xvfb >/dev/null 2>&1") == 0) return std::make_unique<Display>();
        WARN("skipped: Xvfb is not there");
        return nullptr;
    }

  private:
    int run(const std::string& command) const {
        return std::system(("cd '" + directory_.path().string() + "' && { " + command + "; }").c_str());
    }
    std::string number() const {
        std::ifstream file(directory_ / "number");
        std::string line;
        std::getline(file, line);
        return file.eof() ? "" : line;
    }

    TemporaryDirectory directory_;
};

}  // namespace farfield::test
