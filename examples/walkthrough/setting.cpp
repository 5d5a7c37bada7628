#include "setting.hpp"

#include <algorithm>
#include <filesystem>
#include <iostream>
#include <new>
#include <stdexcept>
#include <utility>

#include "options.hpp"
#include "scenes/catalog.hpp"
#include "scenes/generate/copies.hpp"
#include "scenes/generate/island.hpp"
#include "scenes/generate/quadrupled_forest.hpp"
#include "scenes/load/load.hpp"

namespace walkthrough {
namespace {

/// In one line: whoever looks at the pictures is to know what they lack.
void say_what_is_left_out(const std::string& file, const std::vector<std::string>& notes) {
    constexpr std::size_t most = 4;
    if (notes.empty()) return;
    std::cerr << "walkthrough: " << file << ": ";
    for (std::size_t i = 0; i < std::min(notes.size(), most); ++i) std::cerr << (i > 0 ? "; " : "") << notes[i];
    if (notes.size() > most) std::cerr << "; and " << notes.size() - most << " more";
    std::cerr << '\n';
}

farfield::scenes::Scene load(const std::string& file, const std::vector<std::string>& names, glm::vec3 up) {
    std::error_code error;
    if (!std::filesystem::exists(file, error)) {
        std::string known;
        for (const std::string& name : names) known += (known.empty() ? "" : ", ") + name;
        throw UsageError("no scene and no file '" + file + "'; known scenes are " + known);
    }
    try {
        farfield::scenes::Scene scene = farfield::scenes::load(file, {.up = up});
        say_what_is_left_out(file, scene.notes);
        return scene;
    } catch (const std::bad_alloc&) {
        throw;
    } catch (const std::exception& e) {
        throw UsageError(e.what());
    }
}

}  // namespace

Setting make_setting(const std::string& asked, std::optional<glm::vec3> up, std::uint32_t copies) {
    Setting setting;
    const std::vector<std::string> names = farfield::scenes::names();
    const bool generated = std::find(names.begin(), names.end(), asked) != names.end();
    if (generated) {
        if (up) throw UsageError("--up is for files: in '" + asked + "' y is up");
        setting.scene = farfield::scenes::make(asked);
        setting.name = asked;
    } else {
        setting.scene = load(asked, names, up.value_or(glm::vec3(0, 1, 0)));
        setting.name = std::filesystem::path(asked).stem().string();
    }
    setting.bounds = farfield::scenes::bounds(setting.scene);
    if (setting.bounds.is_empty()) throw UsageError("nothing to draw in '" + asked + "'");
    if (!setting.bounds.is_finite())
        throw UsageError("'" + asked + "' has coordinates that are not finite or too large");
    if (copies > 1) {
        setting.scene = farfield::scenes::copies(std::move(setting.scene), copies);
        setting.bounds = farfield::scenes::bounds(setting.scene);
        setting.name += "-x" + std::to_string(copies);
    }
    const bool outdoors = generated && asked != "molecule" && asked != "tree";
    if (outdoors) setting.background = {{126, 173, 224, 255}, {222, 236, 247, 255}};
    if (generated && copies == 1 && asked == "quadrupled-forest") {
        setting.descent = {farfield::scenes::aerial({}), farfield::scenes::eye_level({})};
    }
    if (generated && copies == 1 && asked == "shade-island") {
        setting.path = [](int frames) {
            return farfield::scenes::walk_over_island(farfield::scenes::shade_island, frames);
        };
    }
    setting.culls_back_faces = setting.scene.is_closed || (generated && asked == "molecule");
    return setting;
}

}  // namespace walkthrough
