// The program of an engine's example (examples/engines): a table of four ways to draw a forest, and their pictures.
#pragma once

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <initializer_list>
#include <iterator>
#include <string>

#include "catch.hpp"
#include "support/display.hpp"
#include "support/temporary_directory.hpp"

namespace farfield::test {

/// Runs it, where there is a display. A picture has the first word of its way's name.
inline void check_forest_program(const std::string& program, std::initializer_list<std::string> ways) {
    const auto display = Display::open();
    if (!display) return;
    const TemporaryDirectory directory;
    const std::string command = "cd '" + directory.path().string() + "' && '" + program +
                                "' --trees 6 --triangles 2000 --kinds 2 --width 96 --height 64 "
                                "--frames 2 --compared 1 --out . >said 2>&1";
    const int status = std::system(command.c_str());
    std::ifstream in(directory / "said");
    const std::string said{std::istreambuf_iterator<char>(in), {}};
    INFO(said);
    REQUIRE(status == 0);
    const auto check_picture = [&](const std::string& name) {
        CHECK(std::filesystem::file_size(directory.path() / ("frame001_" + name + ".png")) > 500);
    };
    for (const std::string& way : ways) {
        CHECK(said.find("\n" + way + " ") != std::string::npos);
        check_picture(way.substr(0, way.find(' ')));
    }
    check_picture("64_samples");
    check_picture("side_by_side");
}

}  // namespace farfield::test
