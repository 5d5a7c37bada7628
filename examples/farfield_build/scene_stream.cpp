#include "scene_stream.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <memory>
#include <stdexcept>
#include <utility>
#include <vector>

#include "scenes/generate/random.hpp"
#include "scenes/generate/tree.hpp"
#include "scenes/load/load.hpp"
#include "scenes/scene.hpp"

namespace farfield::scenes {
namespace {

std::uint64_t parse_count(const std::string& text) {
    char* end = nullptr;
    double n = std::strtod(text.c_str(), &end);
    const std::string unit = end;
    if (unit == "k") n *= 1e3;
    if (unit == "M") n *= 1e6;
    if (unit == "G") n *= 1e9;
    const bool knows_unit = unit.empty() || unit == "k" || unit == "M" || unit == "G";
    if (end == text.c_str() || !knows_unit || !(n >= 2 && n <= 4e9)) {
        throw std::invalid_argument("'" + text + "' is no number of triangles from 2 to 4G, such as 320M");
    }
    return std::uint64_t(n);
}

TriangleStream chessboard_stream(std::uint64_t triangles) {
    const auto squares = std::uint32_t(std::max(1.0, std::round(std::sqrt(double(triangles) / 2))));
    return [squares](const std::function<void(const PagedPrimitive&)>& take) {
        constexpr Rgba8 black{24, 24, 24, 255}, white{236, 236, 236, 255};
        std::vector<float> line;
        for (std::uint32_t i = 0; i <= squares; ++i) line.push_back(float(double(i) / squares - 0.5));
        for (std::uint32_t row = 0; row < squares; ++row) {
            for (std::uint32_t column = 0; column < squares; ++column) {
                const float x0 = line[column], x1 = line[column + 1], z0 = line[row], z1 = line[row + 1];
                const Rgba8 c = (row + column) % 2 == 0 ? black : white;
                take({{glm::vec3(x0, 0, z0), glm::vec3(x0, 0, z1), glm::vec3(x1, 0, z1)}, {c, c, c}});
                take({{glm::vec3(x0, 0, z0), glm::vec3(x1, 0, z1), glm::vec3(x1, 0, z0)}, {c, c, c}});
            }
        }
    };
}

/// In meters.
float height_of_ground(float x, float z) {
    return 12 * std::sin(x * 0.011f) * std::cos(z * 0.013f) + 4 * std::sin(x * 0.05f + 1) * std::sin(z * 0.043f) +
           0.4f * std::sin(x * 0.31f) * std::sin(z * 0.27f);
}

/// A tenth of all triangles is ground.
TriangleStream landscape_stream(std::uint64_t triangles) {
    auto kinds = std::make_shared<std::vector<std::vector<VertexColoredTriangle>>>();
    for (std::uint64_t seed = 1; seed <= 3; ++seed) {
        kinds->push_back(tree({.seed = seed, .triangles = 20'000}).groups.back().triangles);
    }
    return [kinds, triangles](const std::function<void(const PagedPrimitive&)>& take) {
        const auto trees = std::uint64_t(std::max(1.0, 0.9 * double(triangles) / 20'000));
        // Nine meters from tree to tree.
        const float side = 9 * std::sqrt(float(trees));
        const auto squares = std::uint32_t(std::max(1.0, std::sqrt(0.05 * double(triangles))));
        const auto at = [&](std::uint32_t column, std::uint32_t row) {
            const float x = side * (float(column) / float(squares) - 0.5f),
                        z = side * (float(row) / float(squares) - 0.5f);
            return glm::vec3(x, height_of_ground(x, z), z);
        };
        for (std::uint32_t row = 0; row < squares; ++row) {
            for (std::uint32_t column = 0; column < squares; ++column) {
                const glm::vec3 a = at(column, row), b = at(column, row + 1), c = at(column + 1, row + 1),
                                d = at(column + 1, row);
                const auto shade = std::uint8_t(60 + int(20 * std::sin(a.x * 0.7f) * std::sin(a.z * 0.9f)));
                const Rgba8 grass{std::uint8_t(shade / 2), shade, std::uint8_t(shade / 3), 255};
                take({{a, b, c}, {grass, grass, grass}});
                take({{a, c, d}, {grass, grass, grass}});
            }
        }
        Random random(20);
        for (std::uint64_t i = 0; i < trees; ++i) {
            const float x = side * (random.unit() - 0.5f), z = side * (random.unit() - 0.5f);
            const float turn = 6.2831853f * random.unit(), size = 0.6f + 0.6f * random.unit();
            const glm::vec3 foot(x, height_of_ground(x, z), z);
            const float c = size * std::cos(turn), s = size * std::sin(turn);
            for (VertexColoredTriangle t : (*kinds)[i % kinds->size()]) {
                for (glm::vec3& v : t.vertices) v = foot + glm::vec3(c * v.x + s * v.z, size * v.y, c * v.z - s * v.x);
                take(t);
            }
        }
    };
}

}  // namespace

SceneStream scene_stream(const std::string& name) {
    const auto colon = name.find(':');
    const std::string kind = name.substr(0, colon);
    if (colon != std::string::npos && kind == "chessboard")
        return {chessboard_stream(parse_count(name.substr(colon + 1)))};
    if (colon != std::string::npos && kind == "landscape")
        return {landscape_stream(parse_count(name.substr(colon + 1)))};
    auto loaded = load(name);
    // Most are one group already, which may be too large to be had twice.
    const auto scene = std::make_shared<Scene>(loaded.groups.size() > 1 ? expanded(loaded) : std::move(loaded));
    const auto triangles = [scene](const std::function<void(const PagedPrimitive&)>& take) {
        for (const VertexColoredTriangle& t : scene->groups.back().triangles) take(t);
    };
    return {triangles, scene->origin};
}

}  // namespace farfield::scenes
