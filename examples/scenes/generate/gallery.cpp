#include "scenes/generate/gallery.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <stdexcept>

#include "scenes/generate/random.hpp"
#include "scenes/light.hpp"

namespace farfield::scenes {
namespace {

using glm::vec3;
using Triangles = std::vector<Triangle>;

constexpr float pi = 3.14159265f;

void require(bool condition, const char* what) {
    if (!condition) throw std::invalid_argument(std::string("farfield::scenes: ") + what);
}
void require_length(float value, const char* what) {
    require(value > 0 && std::isfinite(value), what);
}

vec3 unit(vec3 v, const char* what) {
    const float length = glm::length(v);
    require_length(length, what);
    return v / length;
}

/// Columns: right, up and `forward`; a rotation that keeps y upright wherever there is an upright.
glm::mat3 facing(vec3 forward) {
    const vec3 upright = std::abs(forward.y) > 0.999f ? vec3(0, 0, -1) : vec3(0, 1, 0);
    const vec3 right = glm::normalize(glm::cross(upright, forward));
    return {right, glm::cross(forward, right), forward};
}

void add_quad(Triangles& out, vec3 a, vec3 b, vec3 c, vec3 d, Rgba8 color) {
    out.push_back({{a, b, c}, color});
    out.push_back({{a, c, d}, color});
}

/// corner + [0, 1] u + [0, 1] v in nu x nv quads, counter-clockwise about u x v. Shared corners have the same bits.
template <class Color>
void add_grid(Triangles& out, vec3 corner, vec3 u, vec3 v, std::uint32_t nu, std::uint32_t nv, Color&& color) {
    const auto at = [&](std::uint32_t i, std::uint32_t j) {
        return corner + u * (float(i) / float(nu)) + v * (float(j) / float(nv));
    };
    for (std::uint32_t j = 0; j < nv; ++j) {
        for (std::uint32_t i = 0; i < nu; ++i) {
            add_quad(out, at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1), color(i, j));
        }
    }
}

vec3 in_unit_ball(Random& random) {
    const vec3 direction = random.direction();
    return direction * std::cbrt(random.unit());
}

/// From z over 45 degrees between x and z to (1,1,1).
vec3 off_axis(float severity) {
    const float azimuth = std::min(1.0f, 2 * severity) * pi / 4;
    const float elevation = std::max(0.0f, 2 * severity - 1) * std::atan(std::sqrt(0.5f));
    return {std::sin(azimuth) * std::cos(elevation), std::sin(elevation), std::cos(azimuth) * std::cos(elevation)};
}

/// Distance from the origin to the surface of an ellipsoid that holds the origin.
float to_ellipsoid(vec3 direction, vec3 center, vec3 radii) {
    const vec3 d = direction / radii, c = center / radii;
    const float a = glm::dot(d, d), b = glm::dot(d, c), outside = glm::dot(c, c) - 1;
    return (b + std::sqrt(b * b - a * outside)) / a;
}

/// A rise of `height` about `center`, one `width` (radians) wide, as a factor on the radius.
float bump(vec3 direction, vec3 center, float width, float height) {
    const float off = glm::dot(direction - center, direction - center) / (width * width);
    return height * std::exp(-off);
}

/// Bodies that all hold the origin, which lies in the neck: their union is star-shaped about it.
float bust_radius(vec3 d) {
    const auto towards = [](float x, float y, float z) { return glm::normalize(vec3(x, y, z)); };
    float head = to_ellipsoid(d, {0, 0.46f, 0.04f}, {0.33f, 0.5f, 0.4f});
    float features = 1;
    features += bump(d, towards(0, 0.42f, 0.5f), 0.13f, 0.24f);  // nose
    features += bump(d, towards(0, 0.05f, 0.42f), 0.2f, 0.12f);  // chin
    features += bump(d, towards(0, 0.7f, 0.45f), 0.25f, 0.05f);  // brow
    for (const float side : {-1.0f, 1.0f}) {
        features -= bump(d, towards(side * 0.15f, 0.56f, 0.42f), 0.12f, 0.1f);  // eye sockets
        features += bump(d, towards(side * 0.34f, 0.42f, 0.0f), 0.12f, 0.18f);  // ears
    }
    const float hair = std::clamp(2 * (d.y - d.z - 0.2f), 0.0f, 1.0f);
    features += 0.02f * hair * std::sin(38 * d.x) * std::sin(31 * (d.y - d.z));
    head *= features;
    const float neck = to_ellipsoid(d, {0, 0, -0.02f}, {0.22f, 0.6f, 0.22f});
    const float shoulders = to_ellipsoid(d, {0, -0.62f, -0.02f}, {0.85f, 0.68f, 0.4f});
    const float base = d.y < 0 ? -0.95f / d.y : 10.0f;
    return std::min(std::max({head, neck, shoulders}), base);
}

}  // namespace

Triangles slats(const SlatsOptions& o) {
    require(o.slats > 0 && o.segments > 0, "slats: slats and segments must be above 0");
    require_length(o.breadth, "slats: breadth must be positive and finite");
    require(std::isfinite(o.angle_degrees), "slats: angle_degrees must be finite");
    const float spacing = 2 / float(o.slats), angle = o.angle_degrees * pi / 180;
    const vec3 across = vec3(0, std::sin(angle), -std::cos(angle)) * (o.breadth * spacing);
    Triangles out;
    out.reserve(2 * std::size_t(o.slats) * o.segments);
    for (std::uint32_t i = 0; i < o.slats; ++i) {
        const vec3 middle(0, (float(i) + 0.5f) * spacing - 1, 0);
        const Rgba8 color = i % 2 == 0 ? Rgba8{222, 214, 196, 255} : Rgba8{190, 178, 150, 255};
        add_grid(out, middle - 0.5f * across - vec3(1, 0, 0), {2, 0, 0}, across, o.segments, 1,
                 [&](std::uint32_t, std::uint32_t) { return color; });
    }
    return out;
}

Triangles wall(const WallOptions& o) {
    require(o.side_quads > 0, "wall: side_quads must be above 0");
    const glm::mat3 turned = facing(unit(o.normal, "wall: normal must have a direction"));
    const std::uint32_t n = o.side_quads;
    Triangles out;
    out.reserve(2 * std::size_t(n) * n);
    add_grid(out, -turned[0] - turned[1], 2.0f * turned[0], 2.0f * turned[1], n, n,
             [&](std::uint32_t i, std::uint32_t j) {
                 return (8 * i / n + 8 * j / n) % 2 == 0 ? Rgba8{226, 220, 205, 255} : Rgba8{150, 70, 48, 255};
             });
    return out;
}

Triangles bust(const BustOptions& o) {
    require(o.side_quads > 0, "bust: side_quads must be above 0");
    const glm::mat3 turned = facing(unit(o.looks_to, "bust: looks_to must have a direction"));
    const int n = int(o.side_quads);
    // A lattice on the cube, bent so that its squares are about equally large on the sphere. Neighbors on two faces of
    // the cube find a point by the same three numbers.
    const auto bent = [&](int i) { return std::tan(float(2 * i - n) / float(n) * (pi / 4)); };
    const auto point = [&](std::array<int, 3> at) {
        const vec3 d = glm::normalize(vec3(bent(at[0]), bent(at[1]), bent(at[2])));
        return d * bust_radius(d);
    };
    const Light light{.to_sun = glm::normalize(vec3(0.6f, 0.5f, 0.62f))};
    Triangles out;
    out.reserve(12 * std::size_t(n) * std::size_t(n));
    const auto add = [&](vec3 a, vec3 b, vec3 c) {
        const vec3 across = glm::cross(b - a, c - a);
        const float length = glm::length(across);
        const vec3 normal = length > 0 ? across / length : glm::normalize(a);
        const Rgba8 color = display_color(lit(light, vec3(0.42f, 0.36f, 0.29f), normal, 1, 1));
        out.push_back({{turned * a, turned * b, turned * c}, color});
    };
    for (int side = 0; side < 6; ++side) {
        const auto axis = std::size_t(side / 2);
        const bool upper = side % 2 == 1;
        for (int j = 0; j < n; ++j) {
            for (int i = 0; i < n; ++i) {
                const auto corner = [&](int u, int v) {
                    std::array<int, 3> at{};
                    at[axis] = upper ? n : 0;
                    at[(axis + 1) % 3] = upper ? u : v;
                    at[(axis + 2) % 3] = upper ? v : u;
                    return point(at);
                };
                const vec3 a = corner(i, j), b = corner(i + 1, j), c = corner(i + 1, j + 1), d = corner(i, j + 1);
                add(a, b, c);
                add(a, c, d);
            }
        }
    }
    return out;
}

Triangles twigs(const TwigsOptions& o) {
    require(o.twigs > 0 && o.segments > 0, "twigs: twigs and segments must be above 0");
    require_length(o.length, "twigs: length must be positive and finite");
    require_length(o.thickness, "twigs: thickness must be positive and finite");
    Random random(o.seed);
    Triangles out;
    out.reserve(6 * std::size_t(o.twigs) * o.segments);
    for (std::uint32_t i = 0; i < o.twigs; ++i) {
        const vec3 direction = random.direction();
        // Ends stay in the ball as long as twigs are shorter than it is wide.
        const vec3 middle = in_unit_ball(random) * std::max(0.0f, 1 - 0.5f * o.length);
        const glm::mat3 turned = facing(direction);
        const float tint = random.between(0.7f, 1.1f);
        std::array<vec3, 3> around;
        for (int k = 0; k < 3; ++k) {
            const float azimuth = 2 * pi * float(k) / 3;
            around[std::size_t(k)] =
                (turned[0] * std::cos(azimuth) + turned[1] * std::sin(azimuth)) * (o.thickness / std::sqrt(3.0f));
        }
        const auto at = [&](std::uint32_t j) {
            return middle + direction * (o.length * (float(j) / float(o.segments) - 0.5f));
        };
        for (std::size_t k = 0; k < 3; ++k) {
            const vec3 a = around[k], b = around[(k + 1) % 3];
            const float facing_sky = 0.5f + 0.5f * glm::normalize(a + b).y;
            const Rgba8 color = display_color(vec3(0.16f, 0.11f, 0.07f) * (tint * (0.5f + facing_sky)));
            for (std::uint32_t j = 0; j < o.segments; ++j) {
                add_quad(out, at(j) + a, at(j) + b, at(j + 1) + b, at(j + 1) + a, color);
            }
        }
    }
    return out;
}

Triangles lit_leaves(const LeavesOptions& o) {
    require(o.leaves > 0, "lit_leaves: leaves must be above 0");
    require_length(o.cover, "lit_leaves: cover must be positive and finite");
    require(o.contrast >= 0 && o.contrast <= 1, "lit_leaves: contrast must lie in [0, 1]");
    Random random(o.seed);
    const float area = o.cover * pi / float(o.leaves);
    // Leaves turned every way show half of their area to any direction (Cauchy).
    const float extinction = 0.5f * o.cover * pi / (4 * pi / 3);
    const float radius = std::sqrt(4 * area / (3 * std::sqrt(3.0f)));  // of the triangle's corners about its middle
    Triangles out;
    out.reserve(o.leaves);
    for (std::uint32_t i = 0; i < o.leaves; ++i) {
        const vec3 middle = in_unit_ball(random) * std::max(0.0f, 1 - radius);
        const glm::mat3 turned = facing(random.direction());
        const float begin = random.between(0, 2 * pi);
        // Of the ray from the leaf to the sun, what lies inside the ball.
        const float before = std::sqrt(std::max(0.0f, 1 - middle.y * middle.y - middle.z * middle.z)) - middle.x;
        const float sun = 2 * std::abs(turned[2].x) * std::exp(-extinction * before);
        const float light = (1 - o.contrast) * 0.5f + o.contrast * sun;
        Triangle leaf;
        for (int k = 0; k < 3; ++k) {
            const float azimuth = begin + 2 * pi * float(k) / 3;
            leaf.vertices[std::size_t(k)] =
                middle + (turned[0] * std::cos(azimuth) + turned[1] * std::sin(azimuth)) * radius;
        }
        leaf.rgba = display_color(vec3(0.30f, 0.52f, 0.12f) * light);
        out.push_back(leaf);
    }
    return out;
}

Triangles sheets(const SheetsOptions& o) {
    require(o.sheets > 0 && o.side_quads > 0, "sheets: sheets and side_quads must be above 0");
    require_length(o.spacing, "sheets: spacing must be positive and finite");
    const glm::mat3 turned = facing(unit(o.normal, "sheets: normal must have a direction"));
    Triangles out;
    out.reserve(2 * std::size_t(o.sheets) * o.side_quads * o.side_quads);
    for (std::uint32_t i = 0; i < o.sheets; ++i) {
        const vec3 middle = turned[2] * ((0.5f * float(o.sheets - 1) - float(i)) * o.spacing);
        const Rgba8 color = i % 2 == 0 ? Rgba8{40, 44, 80, 255} : Rgba8{240, 226, 120, 255};
        add_grid(out, middle - turned[0] - turned[1], 2.0f * turned[0], 2.0f * turned[1], o.side_quads, o.side_quads,
                 [&](std::uint32_t, std::uint32_t) { return color; });
    }
    return out;
}

Triangles ground_and_leaves(const GroundOptions& o) {
    require_length(o.half_side, "ground_and_leaves: half_side must be positive and finite");
    Triangles out = lit_leaves(o.leaves);
    const float h = o.half_side;
    add_quad(out, {-h, -1, h}, {h, -1, h}, {h, -1, -h}, {-h, -1, -h}, {122, 104, 78, 255});
    return out;
}

Triangles meadow(const MeadowOptions& o) {
    require(o.blades > 0, "meadow: blades must be above 0");
    require_length(o.height, "meadow: height must be positive and finite");
    require_length(o.cover, "meadow: cover must be positive and finite");
    Random random(o.seed);
    // Blades are three quarters as high on average, and half as large as wide and high.
    const float width = 4 * o.cover / (float(o.blades) * 0.5f * 0.75f * o.height);
    Triangles out;
    out.reserve(o.blades);
    for (std::uint32_t i = 0; i < o.blades; ++i) {
        const float x = random.between(-1, 1), z = random.between(-1, 1), azimuth = random.between(0, 2 * pi);
        const float height = o.height * random.between(0.5f, 1);
        const float over_x = height * random.between(-0.3f, 0.3f), over_z = height * random.between(-0.3f, 0.3f);
        const vec3 foot(x, 0, z), half = vec3(std::cos(azimuth), 0, std::sin(azimuth)) * (0.5f * width);
        const float tint = random.between(0.7f, 1.2f);
        out.push_back({{foot - half, foot + half, foot + vec3(over_x, height, over_z)},
                       display_color(vec3(0.22f, 0.42f, 0.1f) * tint)});
    }
    return out;
}

Triangles clouds(const CloudsOptions& o) {
    require(o.clouds > 0 && o.leaves > 0, "clouds: clouds and leaves must be above 0");
    require_length(o.cover, "clouds: cover must be positive and finite");
    require_length(o.radius, "clouds: radius must be positive and finite");
    Triangles out;
    out.reserve(std::size_t(o.clouds) * o.leaves);
    for (std::uint32_t i = 0; i < o.clouds; ++i) {
        const float z = o.clouds == 1 ? 0.0f : 2 * float(i) / float(o.clouds - 1) - 1;
        const Triangles cloud =
            lit_leaves({.seed = o.seed + i, .leaves = o.leaves, .cover = o.cover, .contrast = 0.5f});
        for (Triangle leaf : cloud) {
            for (vec3& v : leaf.vertices) v = vec3(0, 0, z) + o.radius * v;
            out.push_back(leaf);
        }
    }
    return out;
}

std::span<const GalleryEntry> gallery() {
    static constexpr GalleryEntry entries[] = {
        {"slats", "tone", "angle of the slats, 0 to 90 degrees; worst in between"},
        {"wall", "tearing", "normal from z over 45 degrees between x and z to (1,1,1)"},
        {"bust", "tearing", "looks from z over 45 degrees between x and z to (1,1,1)"},
        {"twigs", "inflation", "thickness from 0.01 to 0.01 / 32"},
        {"leaves", "tone", "contrast of the light"},
        {"sheets", "noise", "spacing from 0.25 to 0.25 / 1024"},
        {"ground", "seams", "half side of the plane from 2 to 2048"},
        {"meadow", "loss", "height of the blades from 0.08 to 0.08 / 16"},
        {"clouds", "loss", "clouds in a row along the view, 2 to 32"},
    };
    return entries;
}

GalleryScene make_gallery(std::string_view name, float severity, std::uint32_t triangles) {
    require(severity >= 0 && severity <= 1, "make_gallery: severity must lie in [0, 1]");
    require(triangles >= 1000, "make_gallery: at least 1000 triangles");
    const auto quads_a_side = [&](std::uint32_t grids) {
        return std::uint32_t(std::sqrt(double(triangles) / (2.0 * grids)));
    };
    GalleryScene scene{.name = std::string(name), .triangles = {}};
    const vec3 from_above = glm::normalize(vec3(0.35f, 0.3f, 1));
    if (name == "slats") {
        scene.triangles = slats({.angle_degrees = 90 * severity, .segments = triangles / 64});
        scene.towards_viewer = glm::normalize(vec3(0, 1, 1));
    } else if (name == "wall") {
        scene.towards_viewer = off_axis(severity);
        scene.triangles = wall({.normal = scene.towards_viewer, .side_quads = quads_a_side(1)});
        scene.is_opaque = true;
    } else if (name == "bust") {
        scene.towards_viewer = off_axis(severity);
        scene.triangles = bust({.looks_to = scene.towards_viewer, .side_quads = quads_a_side(6)});
        scene.is_closed = scene.is_opaque = true;
    } else if (name == "twigs") {
        scene.triangles = twigs({.twigs = triangles / 48, .thickness = 0.01f * std::exp2(-5 * severity)});
        scene.towards_viewer = from_above;
    } else if (name == "leaves") {
        scene.triangles = lit_leaves({.leaves = triangles, .contrast = severity});
        scene.towards_viewer = glm::normalize(vec3(1, 0.3f, 0.4f));
    } else if (name == "sheets") {
        const SheetsOptions defaults;
        scene.triangles =
            sheets({.spacing = 0.25f * std::exp2(-10 * severity), .side_quads = quads_a_side(defaults.sheets)});
        scene.towards_viewer = glm::normalize(defaults.normal);
        scene.is_opaque = true;
    } else if (name == "ground") {
        scene.triangles =
            ground_and_leaves({.leaves = {.leaves = triangles - 2}, .half_side = std::exp2(1 + 10 * severity)});
        scene.towards_viewer = from_above;
    } else if (name == "meadow") {
        scene.triangles = meadow({.blades = triangles, .height = 0.08f * std::exp2(-4 * severity)});
        scene.towards_viewer = glm::normalize(vec3(0.2f, 0.35f, 1));
    } else if (name == "clouds") {
        const auto count = std::uint32_t(std::exp2(1 + 4 * severity));
        scene.triangles = clouds({.clouds = count, .leaves = triangles / count});
        scene.towards_viewer = {0, 0, 1};
    } else {
        std::string known;
        for (const GalleryEntry& entry : gallery()) known += (known.empty() ? "" : ", ") + std::string(entry.name);
        throw std::invalid_argument("farfield::scenes: make_gallery: no scene '" + std::string(name) + "'; there are " +
                                    known);
    }
    return scene;
}

std::vector<VertexColoredTriangle> vertex_colored(std::span<const Triangle> triangles) {
    std::vector<VertexColoredTriangle> out;
    out.reserve(triangles.size());
    for (const Triangle& t : triangles) out.push_back({t.vertices, {t.rgba, t.rgba, t.rgba}});
    return out;
}

}  // namespace farfield::scenes
