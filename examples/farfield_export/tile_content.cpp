#include "tile_content.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <glm/common.hpp>
#include <limits>
#include <nlohmann/json.hpp>
#include <span>
#include <stdexcept>

namespace farfield_export {
namespace {

using farfield::Rgba8;
using nlohmann::json;

// Names of glTF 2.0.
constexpr int array_buffer = 34962, of_float = 5126, of_unsigned_short = 5123;
constexpr int mode_points = 0, mode_triangles = 4;
/// The integral of the harmonic of degree 0, which splats' colors are multiples of.
constexpr float harmonic_0 = 0.28209479177387814f;

/// Colors of vertices are linear in glTF. 16 bits, since 8 are too few for what is dark.
std::array<std::uint16_t, 4> linear_color(Rgba8 c) {
    static const auto table = [] {
        std::array<std::uint16_t, 256> out{};
        for (std::size_t i = 0; i < 256; ++i) {
            const double v = double(i) / 255;
            const double linear = v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4);
            out[i] = std::uint16_t(std::lround(linear * 65535));
        }
        return out;
    }();
    return {table[c.r], table[c.g], table[c.b], std::uint16_t(c.a * 257)};
}

/// What is subtracted from vertices: a number in their range, so that all numbers are multiples of one unit in the last
/// place and none of the differences is rounded.
glm::vec3 translation_of(const farfield::Box& box) {
    glm::vec3 out(0);
    for (int axis = 0; axis < 3; ++axis) {
        const float lower = box.lower[axis], upper = box.upper[axis];
        if (std::max(std::abs(lower), std::abs(upper)) > 16 * (upper - lower)) out[axis] = lower;
    }
    return out;
}

/// The parts of a file, as they come.
class GlbWriter {
  public:
    explicit GlbWriter(const TileContent& content) : translation_(translation_of(content.bounds())) {
        gltf_["asset"] = {{"version", "2.0"}, {"generator", "farfield_export"}};
        gltf_["scene"] = 0;
        gltf_["scenes"] = {{{"nodes", {0}}}};
        gltf_["nodes"] = {{{"mesh", 0}}};
        if (const glm::vec3 t = translation_; t != glm::vec3(0)) gltf_["nodes"][0]["translation"] = {t.x, t.y, t.z};
        add_mesh(content.surfaces, /*double_sided=*/true);
        add_mesh(content.faces, /*double_sided=*/false);
        if (!content.points.empty()) {
            add_primitive(mode_points, colored(content.points, content.point_colors), material(true, false));
        }
        if (!content.splats.empty()) add_splats(content.splats);
        gltf_["meshes"] = {{{"primitives", primitives_}}};
        if (uses_unlit_) extensions_.push_back("KHR_materials_unlit");
        if (!content.splats.empty()) extensions_.push_back("KHR_gaussian_splatting");
        if (!extensions_.empty()) gltf_["extensionsUsed"] = extensions_;
        gltf_["buffers"] = {{{"byteLength", binary_.size()}}};
    }

    std::string bytes() {
        std::string text = gltf_.dump();
        text.resize((text.size() + 3) / 4 * 4, ' ');
        const std::size_t whole = 12 + 8 + text.size() + 8 + binary_.size();
        if (whole > std::numeric_limits<std::uint32_t>::max()) {
            throw std::length_error("farfield_export: a tile takes more than the 4 GiB that a GLB may have");
        }
        std::string out;
        out.reserve(whole);
        const auto word = [&](std::size_t v) {
            for (int i = 0; i < 4; ++i) out.push_back(char(v >> (8 * i) & 255));
        };
        out += "glTF";
        word(2);
        word(whole);
        word(text.size());
        out += "JSON";
        out += text;
        word(binary_.size());
        out += std::string("BIN\0", 4);
        out += binary_;
        return out;
    }

  private:
    template <class T>
    int add_accessor(std::span<const T> values, const char* type, int component, bool is_normalized = false) {
        const std::size_t begin = binary_.size(), size = values.size_bytes();
        binary_.resize(begin + (size + 3) / 4 * 4);
        std::memcpy(binary_.data() + begin, values.data(), size);
        gltf_["bufferViews"].push_back(
            {{"buffer", 0}, {"byteOffset", begin}, {"byteLength", size}, {"target", array_buffer}});
        json accessor{{"bufferView", gltf_["bufferViews"].size() - 1},
                      {"componentType", component},
                      {"count", values.size()},
                      {"type", type}};
        if (is_normalized) accessor["normalized"] = true;
        gltf_["accessors"].push_back(std::move(accessor));
        return int(gltf_["accessors"].size()) - 1;
    }
    /// With the bounds that glTF wants of positions.
    int add_positions(std::span<const glm::vec3> in_tile) {
        std::vector<glm::vec3> positions(in_tile.begin(), in_tile.end());
        for (glm::vec3& p : positions) p -= translation_;
        const int at = add_accessor(std::span<const glm::vec3>(positions), "VEC3", of_float);
        glm::vec3 lower = positions.front(), upper = lower;
        for (const glm::vec3& p : positions) {
            lower = glm::min(lower, p);
            upper = glm::max(upper, p);
        }
        gltf_["accessors"].back()["min"] = {lower.x, lower.y, lower.z};
        gltf_["accessors"].back()["max"] = {upper.x, upper.y, upper.z};
        return at;
    }
    json colored(std::span<const glm::vec3> positions, std::span<const Rgba8> colors) {
        std::vector<std::array<std::uint16_t, 4>> linear(colors.size());
        std::transform(colors.begin(), colors.end(), linear.begin(), linear_color);
        json attributes;
        attributes["POSITION"] = add_positions(positions);
        attributes["COLOR_0"] = add_accessor(std::span<const std::array<std::uint16_t, 4>>(linear), "VEC4",
                                             of_unsigned_short, /*is_normalized=*/true);
        return attributes;
    }
    int material(bool double_sided, bool blends) {
        json m{{"extensions", {{"KHR_materials_unlit", json::object()}}}, {"doubleSided", double_sided}};
        m["pbrMetallicRoughness"] = {{"metallicFactor", 0}, {"roughnessFactor", 1}};
        if (blends) m["alphaMode"] = "BLEND";
        uses_unlit_ = true;
        gltf_["materials"].push_back(std::move(m));
        return int(gltf_["materials"].size()) - 1;
    }
    void add_primitive(int mode, json attributes, int material) {
        primitives_.push_back({{"mode", mode}, {"attributes", std::move(attributes)}, {"material", material}});
    }
    void add_mesh(const TileMesh& mesh, bool double_sided) {
        if (mesh.positions.empty()) return;
        const bool blends = std::any_of(mesh.colors.begin(), mesh.colors.end(), [](Rgba8 c) { return c.a != 255; });
        add_primitive(mode_triangles, colored(mesh.positions, mesh.colors), material(double_sided, blends));
    }
    void add_splats(std::span<const GaussianSplat> splats) {
        const auto each = [&]<class T>(auto&& of, const char* type, std::vector<T> values) {
            values.reserve(splats.size());
            for (const GaussianSplat& s : splats) values.push_back(of(s));
            return add_accessor(std::span<const T>(values), type, of_float);
        };
        std::vector<glm::vec3> centers;
        for (const GaussianSplat& s : splats) centers.push_back(s.center);
        json attributes;
        attributes["POSITION"] = add_positions(centers);
        const std::string name = "KHR_gaussian_splatting:";
        attributes[name + "ROTATION"] =
            each([](const auto& s) { return s.rotation; }, "VEC4", std::vector<glm::vec4>());
        attributes[name + "SCALE"] = each([](const auto& s) { return s.scale; }, "VEC3", std::vector<glm::vec3>());
        attributes[name + "OPACITY"] = each([](const auto& s) { return s.opacity; }, "SCALAR", std::vector<float>());
        attributes[name + "SH_DEGREE_0_COEF_0"] =
            each([](const auto& s) { return (s.rgb - 0.5f) / harmonic_0; }, "VEC3", std::vector<glm::vec3>());
        // What a program without splats draws as points.
        std::vector<std::array<std::uint16_t, 4>> colors;
        for (const GaussianSplat& s : splats) colors.push_back(linear_color(farfield::to_rgba8({s.rgb, s.opacity})));
        attributes["COLOR_0"] =
            add_accessor(std::span<const std::array<std::uint16_t, 4>>(colors), "VEC4", of_unsigned_short, true);
        add_primitive(mode_points, std::move(attributes), material(/*double_sided=*/true, /*blends=*/true));
        primitives_.back()["extensions"] = {
            {"KHR_gaussian_splatting", {{"kernel", "ellipse"}, {"colorSpace", "srgb_rec709_display"}}}};
    }

    glm::vec3 translation_;
    json gltf_, primitives_ = json::array(), extensions_ = json::array();
    std::string binary_;
    bool uses_unlit_ = false;
};

}  // namespace

void TileMesh::add(const farfield::Polygon& polygon) {
    if (polygon.vertices.size() < 3 || polygon.colors.empty()) return;
    const bool one_color = polygon.colors.size() < polygon.vertices.size();
    farfield::for_each_triangle(polygon.vertices.size(), [&](std::size_t a, std::size_t b, std::size_t c) {
        for (const std::size_t corner : {a, b, c}) {
            positions.push_back(polygon.vertices[corner]);
            colors.push_back(polygon.colors[one_color ? 0 : corner]);
        }
    });
}

farfield::Box TileContent::bounds() const {
    farfield::Box box = farfield::Box::empty();
    for (const auto* all : {&surfaces.positions, &faces.positions, &points}) {
        for (const glm::vec3& p : *all) box.add(p);
    }
    for (const GaussianSplat& s : splats) {
        const glm::vec3 reach = s.reach();
        box.add(s.center - reach);
        box.add(s.center + reach);
    }
    return box;
}

std::string glb_of(const TileContent& content) {
    static_assert(sizeof(glm::vec3) == 12 && sizeof(glm::vec4) == 16 && sizeof(Rgba8) == 4);
    if (content.is_empty()) throw std::invalid_argument("farfield_export: a tile without contents has no GLB");
    return GlbWriter(content).bytes();
}

}  // namespace farfield_export
