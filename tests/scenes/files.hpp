// Files that a test writes, and loads that must end well: with a scene that makes sense or with a message.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <string>
#include <string_view>

#include "catch.hpp"
#include "scenes/load/load.hpp"
#include "support/temporary_directory.hpp"

namespace farfield::scenes::test {

using farfield::test::TemporaryDirectory;

inline std::string content_of(const std::filesystem::path& file) {
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

/// Empty, with a message, where there are no such files.
inline std::filesystem::path shared_data() {
    const char* const named = std::getenv("FARFIELD_SHARED_DATA");  // set by ctest
    const std::filesystem::path folder = named != nullptr ? named : "../shared/data";
    if (std::filesystem::is_directory(folder)) return folder;
    WARN("skipped: there is no " << folder.string());
    return {};
}

/// Colors as in the file.
inline LoadOptions unlit() {
    LoadOptions options;
    options.bake_light = false;
    return options;
}

/// Empty if the file loads, into finite triangles; else the message, which must name the file in one line.
inline std::string outcome(const std::filesystem::path& file) {
    try {
        const Scene scene = load(file);
        REQUIRE(scene.groups.size() == 1);
        CHECK(triangle_count(scene) > 0);
        for (const VertexColoredTriangle& t : scene.groups[0].triangles) {
            if (!t.bounds().is_finite()) FAIL(file.string() << ": a triangle that is not finite");
        }
        return {};
    } catch (const std::runtime_error& error) {
        const std::string message = error.what();
        CHECK(message.find(file.string() + ": ") == 0);
        CHECK(message.find('\n') == std::string::npos);
        CHECK(message.size() > file.string().size() + 5);
        return message;
    }
}

}  // namespace farfield::scenes::test
