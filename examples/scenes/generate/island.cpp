#include "scenes/generate/island.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/gtc/constants.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <limits>
#include <span>
#include <stdexcept>

#include "scenes/generate/point_grid.hpp"
#include "scenes/generate/random.hpp"
#include "scenes/generate/tree.hpp"
#include "scenes/light.hpp"

namespace farfield::scenes {
namespace {

using glm::vec3;

constexpr int sea_columns = 12, sea_rows = 14;  // 336 triangles

float smooth(float t) {
    return t * t * (3.0f - 2.0f * t);
}
float ramp(float from, float to, float v) {
    return smooth(std::clamp((v - from) / (to - from), 0.0f, 1.0f));
}

/// Value noise in [0, 1), smooth between lattice points one unit apart.
float noise(float x, float z, std::uint64_t seed) {
    const float fx = std::floor(x), fz = std::floor(z);
    const auto ix = static_cast<std::int32_t>(fx), iz = static_cast<std::int32_t>(fz);
    const float tx = smooth(x - fx), tz = smooth(z - fz);
    const float a = lattice_value(ix, iz, seed), b = lattice_value(ix + 1, iz, seed);
    const float c = lattice_value(ix, iz + 1, seed), d = lattice_value(ix + 1, iz + 1, seed);
    return (a * (1 - tx) + b * tx) * (1 - tz) + (c * (1 - tx) + d * tx) * tz;
}

float fractal_noise(float x, float z, int octaves, std::uint64_t seed) {
    float sum = 0.0f, amplitude = 0.5f;
    for (int octave = 0; octave < octaves; ++octave) {
        sum += amplitude * noise(x, z, seed + static_cast<std::uint64_t>(octave));
        x = 2.03f * x + 17.1f;  // off the lattice of the octave before
        z = 2.03f * z - 9.7f;
        amplitude *= 0.5f;
    }
    return sum;
}

/// Grows with the number of trees.
float side_of(const IslandOptions& options) {
    return 300.0f * std::sqrt(static_cast<float>(std::max<std::size_t>(options.trees, 40)) / 480.0f);
}

class Ground {
  public:
    explicit Ground(const IslandOptions& options)
        : side_m_(side_of(options)), cells_(options.ground_cells), seed_(options.seed) {
        const int cells = cells_;
        heights_.reserve(static_cast<std::size_t>(cells + 1) * static_cast<std::size_t>(cells + 1));
        for (int z = 0; z <= cells; ++z) {
            for (int x = 0; x <= cells; ++x) heights_.push_back(formed(position(x), position(z)));
        }
    }

    float side_m() const { return side_m_; }
    int cells() const { return cells_; }  ///< along a side

    /// Of the triangulated ground, as drawn.
    float height(float x, float z) const {
        const auto cells = static_cast<float>(cells_);
        const float u = std::clamp((x / side_m_ + 0.5f) * cells, 0.0f, cells - 1e-3f);
        const float v = std::clamp((z / side_m_ + 0.5f) * cells, 0.0f, cells - 1e-3f);
        const int i = static_cast<int>(u), j = static_cast<int>(v);
        const float s = u - static_cast<float>(i), t = v - static_cast<float>(j);
        const float a = at(i, j), b = at(i + 1, j), c = at(i, j + 1), d = at(i + 1, j + 1);
        return s >= t ? a + s * (b - a) + t * (d - b) : a + t * (c - a) + s * (d - c);
    }

    vec3 normal(float x, float z) const {
        const float e = side_m_ / static_cast<float>(cells_);
        return glm::normalize(vec3(height(x - e, z) - height(x + e, z), 2.0f * e, height(x, z - e) - height(x, z + e)));
    }

    vec3 vertex(int x, int z) const { return {position(x), at(x, z), position(z)}; }

  private:
    float position(int i) const { return side_m_ * (static_cast<float>(i) / static_cast<float>(cells_) - 0.5f); }
    float at(int x, int z) const { return heights_[static_cast<std::size_t>(z * (cells_ + 1) + x)]; }

    float formed(float x, float z) const {
        const float u = x / side_m_, v = z / side_m_;
        const float relief_m = 0.11f * side_m_;
        const float coast = 0.22f * (fractal_noise(4.0f * u, 4.0f * v, 4, seed_) - 0.47f);
        const float inland = 0.44f - std::sqrt(u * u + v * v) + coast;
        if (inland < 0) return std::max(0.2f * side_m_ * inland, -0.05f * side_m_);
        const float hills = fractal_noise(9.0f * u + 5.0f, 9.0f * v, 5, seed_ + 100);
        // A summit off the middle, with ridges.
        const float to_summit = std::sqrt((u - 0.09f) * (u - 0.09f) + (v + 0.07f) * (v + 0.07f));
        const float ridge = 1.0f - std::abs(2.0f * fractal_noise(11.0f * u, 11.0f * v, 4, seed_ + 200) - 1.0f);
        const float summit = ramp(0.24f, 0.0f, to_summit) * (0.55f + 0.65f * ridge);
        return 0.09f * side_m_ * inland + relief_m * (0.30f * ramp(0.02f, 0.22f, inland) * hills + 0.75f * summit);
    }

    float side_m_;
    int cells_;
    std::uint64_t seed_;
    std::vector<float> heights_;
};

struct Standing {
    vec3 foot;
    std::size_t kind;
    float scale, turn;
};

/// Throws darts at the land, denser in some places than in others; the distance kept gives way slowly where
/// there is no more room, so that the number of trees is always met.
std::vector<Standing> planted(const Ground& ground, const IslandOptions& options, Random& random) {
    std::vector<Standing> trees;
    PointGrid grid(6.0f);
    const float half = 0.5f * ground.side_m();
    float distance = 5.2f;
    int misses = 0;
    while (trees.size() < options.trees) {
        if (++misses > 400) {
            misses = 0;
            distance *= 0.9f;
        }
        const float x = random.between(-half, half), z = random.between(-half, half);
        const float y = ground.height(x, z);
        const float steepness = 1.0f - ground.normal(x, z).y;
        const float grove = fractal_noise(x / 38.0f, z / 38.0f, 3, options.seed + 300);
        // Once much room is used up, trees stand wherever there is dry land.
        const bool hard_up = distance < 1.0f;
        if (y < 1.8f || (!hard_up && (steepness > 0.2f || random.unit() > ramp(0.28f, 0.5f, grove)))) continue;
        if (grid.any_within({x, 0.0f, z}, distance)) continue;
        misses = 0;
        grid.add({x, 0.0f, z});
        const float scale = random.between(0.7f, 1.15f);
        // On a slope the lower side of the trunk reaches the ground.
        const float sunk = 0.35f * scale * std::sqrt(1.0f - (1.0f - steepness) * (1.0f - steepness));
        trees.push_back({{x, y - sunk, z},
                         random.below(options.tree_kinds),
                         scale,
                         glm::two_pi<float>() * static_cast<float>(random.below(8)) / 8.0f});
    }
    return trees;
}

/// In [0, 1]: how much of the light reaches the ground between the trees.
float open_sky(const PointGrid& grid, const vec3& p, const Light& light) {
    const vec3 shadow = {p.x + 4.0f * light.to_sun.x, 0.0f, p.z + 4.0f * light.to_sun.z};
    float open = 1.0f;
    grid.for_each_within(shadow, 6.0f, [&](std::size_t, const vec3& trunk) {
        const vec3 d = shadow - trunk;
        open *= 1.0f - 0.62f * std::exp(-glm::dot(d, d) / 7.0f);
    });
    return open;
}

Rgba8 ground_color(const Ground& ground, const vec3& p, float open, const Light& light, std::uint64_t seed) {
    const vec3 normal = ground.normal(p.x, p.z);
    const float patch = fractal_noise(p.x / 9.0f, p.z / 9.0f, 4, seed + 400);
    const float grain = noise(p.x * 1.7f, p.z * 1.7f, seed + 500);
    const vec3 sand = vec3(0.50f, 0.40f, 0.25f) * (0.9f + 0.2f * grain);
    const vec3 grass = vec3(0.085f, 0.17f, 0.035f) * (1.0f - patch) + vec3(0.24f, 0.27f, 0.075f) * patch;
    const vec3 rock = vec3(0.25f, 0.23f, 0.20f) * (0.65f + 0.7f * patch);
    const float grassy = ramp(1.0f, 2.2f, p.y + 1.2f * (patch - 0.5f));
    const float rocky = std::max(ramp(0.14f, 0.30f, 1.0f - normal.y + 0.12f * (patch - 0.5f)),
                                 ramp(0.085f, 0.105f, p.y / ground.side_m() + 0.02f * (patch - 0.5f)));
    vec3 albedo = sand * (1.0f - grassy) + grass * grassy;
    albedo = albedo * (1.0f - rocky * grassy) + rock * (rocky * grassy);
    return display_color(lit(light, albedo, normal, open, 0.5f + 0.5f * open));
}

void append_ground(std::vector<VertexColoredTriangle>& triangles, const Ground& ground,
                   const std::vector<Standing>& trees, const Light& light, std::uint64_t seed) {
    PointGrid grid(6.0f);
    for (const Standing& tree : trees) grid.add({tree.foot.x, 0.0f, tree.foot.z});
    std::vector<Rgba8> colors;
    const int cells = ground.cells();
    colors.reserve(static_cast<std::size_t>(cells + 1) * static_cast<std::size_t>(cells + 1));
    for (int z = 0; z <= cells; ++z) {
        for (int x = 0; x <= cells; ++x) {
            const vec3 p = ground.vertex(x, z);
            colors.push_back(ground_color(ground, p, open_sky(grid, p, light), light, seed));
        }
    }
    const auto add = [&](std::array<std::array<int, 2>, 3> corners) {
        VertexColoredTriangle triangle;
        for (std::size_t i = 0; i < 3; ++i) {
            const auto [x, z] = corners[i];
            triangle.vertices[i] = ground.vertex(x, z);
            triangle.rgba[i] = colors[static_cast<std::size_t>(z * (cells + 1) + x)];
        }
        triangles.push_back(triangle);
    };
    for (int z = 0; z < cells; ++z) {
        for (int x = 0; x < cells; ++x) {
            add({{{x, z}, {x + 1, z + 1}, {x + 1, z}}});
            add({{{x, z}, {x, z + 1}, {x + 1, z + 1}}});
        }
    }
}

/// Few and large, as the paper says of its ground: "triangles of vastly different sizes".
void append_sea(std::vector<VertexColoredTriangle>& triangles, float side_m, Random& random) {
    const auto corner = [&](int x, int z) {
        return vec3(3.0f * side_m * (static_cast<float>(x) / sea_columns - 0.5f), 0.0f,
                    3.0f * side_m * (static_cast<float>(z) / sea_rows - 0.5f));
    };
    std::array<Rgba8, (sea_columns + 1) * (sea_rows + 1)> colors;
    for (Rgba8& color : colors) {
        const float brightness = random.between(0.85f, 1.15f);
        color = display_color(vec3(0.055f, 0.17f, 0.27f) * brightness);
    }
    const auto color = [&](int x, int z) { return colors[static_cast<std::size_t>(z * (sea_columns + 1) + x)]; };
    for (int z = 0; z < sea_rows; ++z) {
        for (int x = 0; x < sea_columns; ++x) {
            triangles.push_back({{corner(x, z), corner(x + 1, z + 1), corner(x + 1, z)},
                                 {color(x, z), color(x + 1, z + 1), color(x + 1, z)}});
            triangles.push_back({{corner(x, z), corner(x, z + 1), corner(x + 1, z + 1)},
                                 {color(x, z), color(x, z + 1), color(x + 1, z + 1)}});
        }
    }
}

/// Of a uniform cubic B-spline, t in [0, 1].
glm::dvec3 on_spline(std::span<const glm::dvec3> p, double t) {
    const double s = t * static_cast<double>(p.size() - 3);
    const std::size_t i = std::min(static_cast<std::size_t>(s), p.size() - 4);
    const double u = s - static_cast<double>(i), v = 1 - u;
    return (p[i] * (v * v * v) + p[i + 1] * (3 * u * u * u - 6 * u * u + 4) +
            p[i + 2] * (-3 * u * u * u + 3 * u * u + 3 * u + 1) + p[i + 3] * (u * u * u)) /
           6.0;
}

/// The highest corner of the ground within some meters, or the sea.
double height_about(const Ground& ground, double x, double z) {
    float height = 0;
    for (int j = 0; j <= ground.cells(); ++j) {
        for (int i = 0; i <= ground.cells(); ++i) {
            const vec3 p = ground.vertex(i, j);
            if (std::abs(p.x - float(x)) < 6 && std::abs(p.z - float(z)) < 6) height = std::max(height, p.y);
        }
    }
    return double(height);
}

}  // namespace

std::vector<Camera> walk_over_island(const IslandOptions& options, int frames) {
    // Fractions of the island's side: along the edge, then in to the middle.
    constexpr std::array<std::array<double, 2>, 11> plan{{{-0.42, 0.42},
                                                          {-0.44, 0.25},
                                                          {-0.45, 0.05},
                                                          {-0.44, -0.15},
                                                          {-0.40, -0.32},
                                                          {-0.27, -0.38},
                                                          {-0.18, -0.30},
                                                          {-0.14, -0.15},
                                                          {-0.05, -0.02},
                                                          {0.05, 0.10},
                                                          {0.14, 0.22}}};
    constexpr double tree_top_m = 9;
    constexpr float field_of_view = 0.785398f;
    const Ground ground(options);
    const double side = static_cast<double>(ground.side_m());
    std::vector<glm::dvec3> points;
    for (const auto& [u, v] : plan) {
        points.emplace_back(u * side, height_about(ground, u * side, v * side) + tree_top_m, v * side);
    }
    std::vector<Camera> cameras;
    for (int f = 0; f < frames; ++f) {
        const double t = static_cast<double>(f) / static_cast<double>(frames);
        const glm::dvec3 eye = on_spline(points, t), ahead = on_spline(points, std::min(t + 0.08, 1.0));
        // From the edge it looks at the middle, the less the nearer that is.
        const double inward = std::max(0.0, 1 - 2 * t);
        glm::dvec3 target = glm::mix(ahead, glm::dvec3(0.0, eye.y - 2, 0.0), 0.35 + 0.5 * inward);
        if (glm::length(target - eye) < 5) target = eye + glm::dvec3(1, 0, 1);
        target.y = eye.y - 0.05 * glm::length(target - eye);
        cameras.push_back(Camera::perspective(eye, target, {0, 1, 0}, field_of_view));
    }
    return cameras;
}

Scene island(const IslandOptions& options) {
    if (options.tree_kinds == 0) throw std::invalid_argument("island: no tree kinds");
    if (options.ground_cells < 1) throw std::invalid_argument("island: no ground");
    Random random(options.seed * 0x2545f4914f6cdd1du + 3);
    const Ground ground(options);
    const std::vector<Standing> trees = planted(ground, options, random);

    Scene scene{"island", {}};
    Light light;
    for (std::size_t kind = 0; kind < options.tree_kinds; ++kind) {
        TreeOptions tree_options;
        tree_options.seed = options.seed + kind;
        tree_options.triangles = options.tree_triangles;
        const std::array<float, 4> heights{10.0f, 8.0f, 11.0f, 7.0f}, breadths{1.0f, 1.2f, 0.8f, 1.1f};
        tree_options.height_m = heights[kind % 4];
        tree_options.breadth = breadths[kind % 4];
        tree_options.light = light;
        tree_options.light.to_sun = vec3(0, 1, 0);  // the same light however a tree is turned
        scene.groups.push_back(std::move(tree(tree_options).groups.front()));
    }
    Group& root = scene.groups.emplace_back();
    append_ground(root.triangles, ground, trees, light, options.seed);
    append_sea(root.triangles, ground.side_m(), random);
    for (const Standing& tree : trees) {
        glm::mat4 to_parent = glm::translate(glm::mat4(1.0f), tree.foot);
        to_parent = glm::rotate(to_parent, tree.turn, vec3(0, 1, 0));
        root.placements.push_back({tree.kind, glm::scale(to_parent, vec3(tree.scale))});
    }
    return scene;
}

Scene island(std::size_t trees, bool instanced) {
    IslandOptions options;
    options.trees = trees;
    Scene scene = island(options);
    return instanced ? scene : expanded(scene, std::numeric_limits<std::uint64_t>::max());
}

}  // namespace farfield::scenes
