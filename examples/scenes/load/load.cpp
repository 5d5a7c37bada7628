#include "scenes/load/load.hpp"

#include <algorithm>
#include <new>
#include <utility>

#include "scenes/light.hpp"
#include "scenes/load/load_detail.hpp"
#include "scenes/load/points.hpp"

namespace farfield::scenes {
namespace detail {

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

void bake_light(VertexColoredTriangle& triangle, glm::vec3 up) {
    const auto& v = triangle.vertices;
    glm::vec3 a = v[1] - v[0], b = v[2] - v[0];
    // Triangles of any size have a normal, if their sides are brought to about 1. By a power of two, so that no bit of
    // it depends on the size.
    int exponent = 0;
    std::frexp(std::max({std::abs(a.x), std::abs(a.y), std::abs(a.z), std::abs(b.x), std::abs(b.y), std::abs(b.z)}),
               &exponent);
    const float scale = std::ldexp(1.0f, std::clamp(-exponent, -126, 126));
    a *= scale;
    b *= scale;
    const glm::vec3 cross = glm::cross(a, b);
    const float size = glm::length(cross);
    // No area: as if in half light.
    const float facing = size > 0 ? glm::dot(with_y_up(cross / size, up), Light{}.to_sun) : 0.0f;
    const float brightness = 0.675f + 0.325f * facing;
    for (Rgba8& rgba : triangle.rgba) {
        const glm::vec4 color = to_vec4(rgba);
        rgba = to_rgba8(glm::vec4(glm::vec3(color) * brightness, color.a));
    }
}

bool is_below_one(std::string_view decimal) {
    const std::size_t e = std::min(decimal.find_first_of("eE"), decimal.size());
    const std::string_view mantissa = decimal.substr(0, e);
    const auto point = static_cast<std::int64_t>(std::min(mantissa.find('.'), mantissa.size()));
    const auto first = static_cast<std::int64_t>(std::min(mantissa.find_first_of("123456789"), mantissa.size()));
    std::int64_t exponent = 0;
    if (e < decimal.size()) {
        std::string_view digits = decimal.substr(e + 1);
        if (!digits.empty() && digits.front() == '+') digits.remove_prefix(1);
        const bool negative = !digits.empty() && digits.front() == '-';
        exponent = number<std::int64_t>(digits).value_or(negative ? -(std::int64_t{1} << 62) : std::int64_t{1} << 62);
    }
    return point - first + exponent <= 0;
}

}  // namespace detail

namespace {

using detail::Loaded;

enum class Format { off, ply, obj, gltf, pdb, mmcif, xyz, pts, pcd, lammps_dump, lammps_data, height_field };

std::string lower(std::string text) {
    for (char& c : text) {
        if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
    }
    return text;
}

/// Without the ".gz" of a packed file.
std::filesystem::path unpacked_name(const std::filesystem::path& file) {
    return lower(file.extension().string()) == ".gz" ? file.stem() : file.filename();
}

constexpr std::pair<std::string_view, Format> extensions[] = {
    {".off", Format::off},          {".oogl", Format::off},         {".ply", Format::ply},
    {".obj", Format::obj},          {".gltf", Format::gltf},        {".glb", Format::gltf},
    {".pdb", Format::pdb},          {".ent", Format::pdb},          {".cif", Format::mmcif},
    {".mmcif", Format::mmcif},      {".xyz", Format::xyz},          {".pts", Format::pts},
    {".pcd", Format::pcd},          {".dump", Format::lammps_dump}, {".lammpstrj", Format::lammps_dump},
    {".data", Format::lammps_data}, {".lmp", Format::lammps_data},  {".csv", Format::height_field}};

std::optional<Format> format_named(std::string_view extension) {
    for (const auto& [name, format] : extensions) {
        if (name == extension) return format;
    }
    return std::nullopt;
}

/// By its first lines, for files whose name does not say it.
std::optional<Format> format_of(std::string_view bytes) {
    if (bytes.substr(0, 4) == "glTF") return Format::gltf;
    if (bytes.substr(0, 6) == "# .PCD") return Format::pcd;
    if (bytes.substr(0, 3) == "\xef\xbb\xbf") bytes.remove_prefix(3);
    constexpr std::string_view pdb[] = {"HEADER", "TITLE ", "COMPND", "REMARK", "CRYST1", "MODEL ", "ATOM  ", "HETATM"};
    constexpr std::string_view obj[] = {"v", "vt", "vn", "f", "o", "g", "s", "mtllib", "usemtl"};
    constexpr std::string_view oogl[] = {"LIST", "INST", "appearance", "{", "("};
    detail::Lines lines(bytes.substr(0, 1 << 16));
    std::string_view line;
    bool first = true;
    for (int seen = 0; seen < 32 && lines.next(line);) {
        const auto w = detail::words(line);
        if (w.empty() || w[0].front() == '#') continue;
        ++seen;
        const auto is_one = [&](const auto& known) {
            return std::find(std::begin(known), std::end(known), w[0]) != std::end(known);
        };
        if (first) {
            first = false;
            const std::string_view keyword = w[0].substr(0, w[0].find_first_of("0123456789"));
            if (w[0] == "ply") return Format::ply;
            if (w[0] == "ITEM:") return Format::lammps_dump;
            if (w[0].substr(0, 5) == "data_") return Format::mmcif;
            const std::size_t inner = bytes.find_first_not_of(" \t\r\n", bytes.find('{') + 1);
            const bool json = w[0].front() == '{' && inner != std::string_view::npos && bytes[inner] == '"';
            if (json) return Format::gltf;
            if (keyword.size() >= 3 && keyword.substr(keyword.size() - 3) == "OFF") return Format::off;
            if (w[0].front() == '{' || is_one(oogl)) return Format::off;
            if (w.size() == 1 && detail::number<std::uint64_t>(w[0])) return Format::xyz;
        }
        if (std::find(std::begin(pdb), std::end(pdb), line.substr(0, 6)) != std::end(pdb)) return Format::pdb;
        if (w.size() > 1 && is_one(obj)) return Format::obj;
        if (w.size() == 2 && w[1] == "atoms") return Format::lammps_data;
        if (line.find_first_of(",;") != std::string_view::npos && detail::is_row_of_numbers(line)) {
            return Format::height_field;
        }
    }
    return std::nullopt;
}

Loaded read(const std::filesystem::path& file, const LoadOptions& options) {
    const std::string extension = lower(unpacked_name(file).extension().string());
    std::optional<Format> format = format_named(extension);
    const std::string content = detail::read_file(file);
    if (!format) format = format_of(content);
    if (!format) {
        std::string known;
        for (const auto& [name, format_of_it] : extensions) known.append(" ").append(name);
        throw std::runtime_error("unknown extension " + detail::in_quotes(extension) +
                                 ", and nothing known inside; known are" + known);
    }
    switch (*format) {
        case Format::off:
            return detail::read_off(content, file.parent_path());
        case Format::ply:
            return detail::read_ply(content, options);
        case Format::obj:
            return detail::read_obj(content, file.parent_path());
        case Format::gltf:
            return detail::read_gltf(content, file.parent_path(), options);
        case Format::pdb:
            return detail::read_pdb(content, options);
        case Format::mmcif:
            return detail::read_mmcif(content, options);
        case Format::xyz:
            if (detail::is_point_table(content)) return detail::read_point_table(content, false, options);
            return detail::read_xyz(content, options);
        case Format::pts:
            return detail::read_point_table(content, true, options);
        case Format::pcd:
            return detail::read_pcd(content, options);
        case Format::lammps_dump:
            return detail::read_lammps_dump(content, options);
        case Format::lammps_data:
            return detail::read_lammps_data(content, options);
        case Format::height_field:
            break;
    }
    return detail::read_height_field(content);
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
    Scene scene{unpacked_name(file).stem().string(), std::vector<Group>(1)};
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
        for (VertexColoredTriangle& triangle : loaded.triangles) detail::bake_light(triangle, options.up);
    }
    scene.groups[0].triangles = std::move(loaded.triangles);
    scene.up = options.up;
    scene.origin = loaded.origin;
    scene.notes = std::move(loaded.notes);
    scene.is_closed = loaded.is_closed;
    return scene;
}

}  // namespace farfield::scenes
