#include "scenes/generate/tumbling_hall.hpp"

#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <initializer_list>
#include <numbers>
#include <stdexcept>
#include <string_view>

#include "scenes/generate/boxes.hpp"
#include "scenes/generate/building.hpp"
#include "scenes/generate/random.hpp"
#include "scenes/generate/sphere.hpp"

namespace farfield::scenes {
namespace {

using glm::vec3;
using Triangles = std::vector<VertexColoredTriangle>;

constexpr float turn = 2 * std::numbers::pi_v<float>;
/// Of the building: a room is 4 x 5, the corridor lies in the middle.
constexpr float room_width = 4;

constexpr std::array<std::string_view, 6> shapes{"box", "ball", "gem", "star", "ring", "angle"};

void add(Triangles& out, vec3 a, vec3 b, vec3 c, vec3 albedo) {
    constexpr Light lamps{
        .to_sun = {0, 1, 0}, .sun = vec3(0.3f), .sky = {1.05f, 1.03f, 0.98f}, .ground = {0.4f, 0.38f, 0.36f}};
    const Rgba8 color = display_color(lit(lamps, albedo, glm::normalize(glm::cross(b - a, c - a)), 1, 1));
    out.push_back({{a, b, c}, {color, color, color}});
}

/// Counter-clockwise seen from outside.
void add_convex(Triangles& out, std::initializer_list<vec3> corners, vec3 albedo) {
    const auto* v = corners.begin();
    for (std::size_t i = 2; i < corners.size(); ++i) add(out, v[0], v[i - 1], v[i], albedo);
}

Triangles box(vec3 half, vec3 albedo) {
    Triangles out;
    add_box(out, {-half, half}, albedo, 1);
    return out;
}

Triangles ball(float radius, vec3 albedo) {
    Triangles out;
    for (const auto& [a, b, c] : icosphere(2)) add(out, a * radius, b * radius, c * radius, albedo);
    return out;
}

/// Two pyramids over a ring of seven.
Triangles gem(float radius, vec3 albedo) {
    Triangles out;
    constexpr int sides = 7;
    const auto at = [&](int i) {
        const float angle = turn * float(i % sides) / sides;
        return radius * vec3(std::sin(angle), 0, std::cos(angle));
    };
    for (int i = 0; i < sides; ++i) {
        add(out, at(i), at(i + 1), {0, 1.4f * radius, 0}, albedo);
        add(out, at(i + 1), at(i), {0, -0.8f * radius, 0}, albedo);
    }
    return out;
}

/// A ball with a spike on every triangle.
Triangles star(float radius, vec3 albedo) {
    Triangles out;
    for (const auto& [a, b, c] : icosphere(1)) {
        const vec3 tip = glm::normalize(a + b + c) * radius;
        const vec3 p = a * (0.5f * radius), q = b * (0.5f * radius), r = c * (0.5f * radius);
        add(out, p, q, tip, albedo);
        add(out, q, r, tip, albedo);
        add(out, r, p, tip, albedo);
    }
    return out;
}

Triangles ring(float radius, vec3 albedo) {
    Triangles out;
    constexpr int around = 20, across = 8;
    const auto at = [&](int i, int j) {
        const float u = turn * float(i % around) / around, v = turn * float(j % across) / across;
        const float off = radius * (1 + 0.35f * std::cos(v));
        return vec3(off * std::sin(u), 0.35f * radius * std::sin(v), off * std::cos(u));
    };
    for (int i = 0; i < around; ++i) {
        for (int j = 0; j < across; ++j) {
            // Its quadrilaterals are not planar: two triangles each.
            add(out, at(i, j), at(i + 1, j), at(i + 1, j + 1), albedo);
            add(out, at(i, j), at(i + 1, j + 1), at(i, j + 1), albedo);
        }
    }
    return out;
}

/// A prism over an L.
Triangles angle_iron(float s, vec3 albedo) {
    Triangles out;
    const float t = 0.3f * s;  // thickness
    const auto at = [&](float x, float y, float z) { return vec3(x - 0.5f * s, y - 0.5f * s, z * 0.6f * s); };
    for (const float z : {-1.0f, 1.0f}) {
        const auto face = [&](vec3 a, vec3 b, vec3 c, vec3 d) {
            if (z > 0) {
                add_convex(out, {a, b, c, d}, albedo);
            } else {
                add_convex(out, {d, c, b, a}, albedo);
            }
        };
        // Split where a corner of the other half lies, so that no edge has a corner in its middle.
        face(at(0, 0, z), at(t, 0, z), at(t, t, z), at(0, t, z));
        face(at(t, 0, z), at(s, 0, z), at(s, t, z), at(t, t, z));
        face(at(0, t, z), at(t, t, z), at(t, s, z), at(0, s, z));
    }
    const std::array<glm::vec2, 8> outline{{{0, 0}, {t, 0}, {s, 0}, {s, t}, {t, t}, {t, s}, {0, s}, {0, t}}};
    for (std::size_t i = 0; i < outline.size(); ++i) {
        const glm::vec2 a = outline[i], b = outline[(i + 1) % outline.size()];
        add_convex(out, {at(a.x, a.y, 1), at(a.x, a.y, -1), at(b.x, b.y, -1), at(b.x, b.y, 1)}, albedo);
    }
    return out;
}

Body body(std::size_t i, Random& random) {
    Body result;
    result.shape = shapes[i % shapes.size()];
    const float r = random.between(0.2f, 0.4f);
    const float red = random.between(0.15f, 0.8f), green = random.between(0.15f, 0.8f);
    const vec3 albedo(red, green, 0.95f - 0.5f * (red + green));
    switch (i % shapes.size()) {
        case 0:
            result.triangles = box({r, 0.6f * r, 0.8f * r}, albedo);
            break;
        case 1:
            result.triangles = ball(r, albedo);
            break;
        case 2:
            result.triangles = gem(r, albedo);
            break;
        case 3:
            result.triangles = star(1.2f * r, albedo);
            break;
        case 4:
            result.triangles = ring(0.8f * r, albedo);
            break;
        default:
            result.triangles = angle_iron(1.6f * r, albedo);
            break;
    }
    result.is_convex = i % shapes.size() < 3;
    return result;
}

VertexColoredTriangle of_one_color(VertexColoredTriangle t) {
    const auto mean = [&](std::uint8_t Rgba8::*channel) {
        return std::uint8_t((t.rgba[0].*channel + t.rgba[1].*channel + t.rgba[2].*channel + 1) / 3);
    };
    t.rgba.fill({mean(&Rgba8::r), mean(&Rgba8::g), mean(&Rgba8::b), 255});
    return t;
}

}  // namespace

TumblingHall tumbling_hall(const TumblingHallOptions& options) {
    if (options.bodies == 0) throw std::invalid_argument("tumbling_hall: no bodies");
    if (options.rooms_per_side == 0) throw std::invalid_argument("tumbling_hall: no rooms");
    TumblingHall hall{options, {}, {}};
    BuildingOptions one_floor;
    one_floor.seed = options.seed;
    one_floor.floors = 1;
    one_floor.corridors = 1;
    one_floor.rooms_per_side = options.rooms_per_side;
    hall.building = expanded(building(one_floor)).groups.back().triangles;
    for (VertexColoredTriangle& t : hall.building) t = of_one_color(t);
    Random random(options.seed * 0x9fb21c651e98df25u + 11);
    for (std::size_t i = 0; i < options.bodies; ++i) hall.bodies.push_back(body(i, random));
    return hall;
}

std::vector<glm::mat4> placements_at(const TumblingHall& hall, double t) {
    Random random(hall.options.seed * 0xc2b2ae3d27d4eb4fu + 5);
    const float phase_of_all = turn * float(t - std::floor(t));
    const float half_length = 0.5f * room_width * float(hall.options.rooms_per_side);
    std::vector<glm::mat4> placements;
    for (std::size_t i = 0; i < hall.bodies.size(); ++i) {
        const float phase = phase_of_all + random.between(0, turn);
        const vec3 axis = random.direction();
        const auto turns = float(1 + random.below(3));
        const float height = random.between(0.7f, 1.7f), off = random.between(-0.6f, 0.6f);
        const std::uint64_t room = random.below(hall.options.rooms_per_side);
        vec3 at(0.9f * half_length * std::sin(phase), height, off);
        if (i % 3 == 2) {
            // The doors are in the middle of the rooms' walls, opposite to each other, and 2.1 high.
            at = {room_width * (float(room) + 0.5f) - half_length, 0.8f * height, 4 * std::sin(phase)};
        }
        placements.push_back(glm::rotate(glm::translate(glm::mat4(1), at), turns * phase, axis));
    }
    return placements;
}

Scene scene_at(const TumblingHall& hall, double t) {
    Scene scene{"tumbling-hall", {}};
    scene.groups.push_back({hall.building, {}});
    for (const Body& b : hall.bodies) scene.groups.push_back({b.triangles, {}});
    Group root;
    root.placements.push_back({0, glm::mat4(1)});
    const std::vector<glm::mat4> placements = placements_at(hall, t);
    for (std::size_t i = 0; i < placements.size(); ++i) root.placements.push_back({i + 1, placements[i]});
    scene.groups.push_back(std::move(root));
    return scene;
}

Camera inside_tumbling_hall(const TumblingHall& hall) {
    const double end = 0.5 * double(room_width) * double(hall.options.rooms_per_side);
    return Camera::perspective({-end + 0.4, 1.6, 0.3}, {end, 1.2, -0.2}, {0, 1, 0}, 1.2f);
}

}  // namespace farfield::scenes
