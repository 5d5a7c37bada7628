#include "scenes/load/load.hpp"

#include <algorithm>
#include <fstream>
#include <new>

#include "scenes/light.hpp"
#include "scenes/load/load_detail.hpp"

namespace farfield::scenes {
namespace detail {

std::string read_file(const std::filesystem::path& file) {
    std::error_code error;
    const std::filesystem::file_status status = std::filesystem::status(file, error);
    if (error || !std::filesystem::exists(status)) throw std::runtime_error("no such file");
    if (!std::filesystem::is_regular_file(status)) throw std::runtime_error("is not a regular file");
    const std::uintmax_t size = std::filesystem::file_size(file, error);
    if (error) throw std::runtime_error(error.message());
    std::ifstream in(file, std::ios::binary);
    std::string content(static_cast<std::size_t>(size), '\0');
    if (!in || !in.read(content.data(), static_cast<std::streamsize>(content.size()))) {
        throw std::runtime_error("cannot be read");
    }
    return content;
}

Rgba8 color_of_kind(std::int64_t kind) {
    // Hues a golden section of the circle apart are far from all earlier ones.
    const double turn = static_cast<double>(kind % 1'000'003) * 0.6180339887498949;
    const double hue = turn - std::floor(turn);
    const auto channel = [&](double offset) {
        const double h = std::abs((hue + offset) - std::floor(hue + offset) - 0.5) * 6.0 - 1.0;
        return static_cast<float>(0.25 + 0.70 * std::clamp(h, 0.0, 1.0));
    };
    return to_rgba8({channel(0.0), channel(1.0 / 3.0), channel(2.0 / 3.0), 1.0f});
}

void bake_light(VertexColoredTriangle& triangle) {
    const auto& v = triangle.vertices;
    const glm::vec3 cross = glm::cross(v[1] - v[0], v[2] - v[0]);
    const float size = glm::length(cross);
    // No area, or too large or small for a normal in floats: as if in half light.
    const float facing = size > 0 && std::isfinite(size) ? glm::dot(cross / size, Light{}.to_sun) : 0.0f;
    const float brightness = 0.675f + 0.325f * facing;
    for (Rgba8& rgba : triangle.rgba) {
        const glm::vec4 color = to_vec4(rgba);
        rgba = to_rgba8(glm::vec4(glm::vec3(color) * brightness, color.a));
    }
}

}  // namespace detail

namespace {

using detail::Loaded;

std::string lower_extension(const std::filesystem::path& file) {
    std::string extension = file.extension().string();
    for (char& c : extension) {
        if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
    }
    return extension;
}

Loaded read(const std::filesystem::path& file, const LoadOptions& options) {
    const auto loaded = [](detail::Triangles triangles) {
        Loaded l;
        l.triangles = std::move(triangles);
        return l;
    };
    const std::string extension = lower_extension(file);
    const auto is = [&](auto... names) { return ((extension == names) || ...); };
    if (is(".off", ".oogl")) return loaded(detail::read_off(detail::read_file(file)));
    if (is(".ply")) return loaded(detail::read_ply(detail::read_file(file)));
    if (is(".obj")) return loaded(detail::read_with_assimp(file));
    if (is(".gltf", ".glb")) return detail::read_gltf(file, options);
    if (is(".pdb", ".ent")) return detail::read_pdb(detail::read_file(file), options);
    if (is(".cif", ".mmcif")) return detail::read_mmcif(detail::read_file(file), options);
    if (is(".xyz")) return detail::read_xyz(detail::read_file(file), options);
    if (is(".dump", ".lammpstrj")) return detail::read_lammps_dump(detail::read_file(file), options);
    if (is(".data", ".lmp")) return detail::read_lammps_data(detail::read_file(file), options);
    throw std::runtime_error("unknown extension " + detail::in_quotes(extension) +
                             "; known are .off .oogl .ply .obj .gltf .glb .pdb .ent .cif .mmcif .xyz .dump .lammpstrj "
                             ".data .lmp");
}

/// Messages from other libraries may have line ends in them.
std::string one_line(std::string text) {
    std::replace_if(
        text.begin(), text.end(), [](char c) { return static_cast<unsigned char>(c) < ' '; }, ' ');
    while (!text.empty() && text.back() == ' ') text.pop_back();
    return text;
}

}  // namespace

Scene load(const std::filesystem::path& file, const LoadOptions& options) {
    Scene scene{file.stem().string(), std::vector<Group>(1)};
    const auto fail = [&](const std::string& reason) -> std::runtime_error {
        return std::runtime_error(one_line(file.string() + ": " + reason));
    };
    Loaded loaded;
    try {
        loaded = read(file, options);
    } catch (const std::bad_alloc&) {
        throw fail("too large for the memory there is");
    } catch (const std::exception& error) {
        throw fail(error.what());
    }
    if (loaded.triangles.empty()) throw fail("has no triangles");
    if (options.bake_light && !loaded.lit) {
        for (VertexColoredTriangle& triangle : loaded.triangles) detail::bake_light(triangle);
    }
    scene.groups[0].triangles = std::move(loaded.triangles);
    scene.origin = loaded.origin;
    scene.notes = std::move(loaded.notes);
    return scene;
}

}  // namespace farfield::scenes
