// Loads files of any bytes: each gives triangles that are finite or one line that says what is wrong.
#include "scenes/load/load.hpp"

#include <array>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string>
#include <string_view>

#include "fuzz/fuzz.hpp"
#include "support/temporary_directory.hpp"

namespace farfield::fuzz {
namespace {

/// The first byte of an input is the letter of its format; any other stands for a name without an extension.
constexpr std::array<std::pair<char, std::string_view>, 13> formats{{{'o', ".off"},
                                                                     {'p', ".ply"},
                                                                     {'w', ".obj"},
                                                                     {'g', ".gltf"},
                                                                     {'a', ".pdb"},
                                                                     {'m', ".cif"},
                                                                     {'x', ".xyz"},
                                                                     {'t', ".pts"},
                                                                     {'n', ".pcd"},
                                                                     {'d', ".dump"},
                                                                     {'l', ".lmp"},
                                                                     {'c', ".csv"},
                                                                     {'z', ".gz"}}};

/// Between the file and another that lies beside it under the name "beside", for formats that have such.
constexpr std::string_view divider = "\n%%%%\n";

void check(const scenes::Scene& scene) {
    if (scene.groups.empty() || scenes::triangle_count(scene) == 0) throw std::logic_error("a scene of nothing");
    for (const scenes::Group& group : scene.groups) {
        for (const VertexColoredTriangle& t : group.triangles) {
            if (!t.bounds().is_finite()) throw std::logic_error("a triangle that is not finite");
        }
    }
}

}  // namespace

void run(std::span<const std::uint8_t> bytes) {
    static const test::TemporaryDirectory folder;
    if (bytes.empty()) return;
    std::string_view extension;
    for (const auto& [letter, name] : formats) {
        if (bytes[0] == static_cast<std::uint8_t>(letter)) extension = name;
    }
    const std::string_view all(reinterpret_cast<const char*>(bytes.data()) + 1, bytes.size() - 1);
    const std::size_t end = all.find(divider);
    folder.write("beside", end == std::string_view::npos ? std::string_view{} : all.substr(end + divider.size()));
    const auto file = folder.write("input" + std::string(extension), all.substr(0, end));
    scenes::LoadOptions options;
    options.sphere_triangle_budget = 1000;
    try {
        check(scenes::load(file, options));
    } catch (const std::runtime_error& error) {
        const std::string message = error.what();
        const std::string begin = file.string() + ": ";
        if (message.compare(0, begin.size(), begin) != 0 || message.size() < begin.size() + 5 ||
            message.find('\n') != std::string::npos) {
            throw std::logic_error("a message that is not one line about the file: " + message);
        }
    }
}

}  // namespace farfield::fuzz
