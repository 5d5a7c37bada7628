#include "scenes/generate/building.hpp"

#include <cmath>
#include <stdexcept>
#include <utility>

#include "scenes/framing.hpp"
#include "scenes/generate/boxes.hpp"
#include "scenes/generate/furniture.hpp"
#include "scenes/generate/quarter_turn.hpp"

namespace farfield::scenes {
namespace {

using glm::vec3;

// Between the middles of walls, except for heights. Sums of powers of two: see the header.
constexpr float width = 4.0f, depth = 5.0f, corridor_width = 2.5f, story = 3.5f;
constexpr float period = 2 * depth + corridor_width;  // from one row of back walls to the next
constexpr float thickness = 0.125f, half = 0.5f * thickness, slab = 0.25f, wall_height = story - slab;
constexpr float ceiling = 2.75f, panel = 0.03125f;
constexpr float door_width = 0.9375f, door_height = 2.125f;
constexpr float door_to_neighbor = 3.625f;  // from the back wall, clear of shelves

constexpr vec3 white{0.72f, 0.7f, 0.65f}, green{0.5f, 0.6f, 0.52f}, concrete{0.5f, 0.48f, 0.45f};
constexpr vec3 carpet{0.2f, 0.22f, 0.28f}, linoleum{0.42f, 0.36f, 0.28f}, tiles{0.78f, 0.78f, 0.76f};
constexpr vec3 door_wood{0.36f, 0.19f, 0.09f}, frame{0.16f, 0.16f, 0.17f}, glow(4.0f);

float middle(float a, float b) {
    return 0.5f * (a + b);
}

/// Upright walls and what belongs to them run along x from 0 to their length, post to post, in the middle of z.
class Wall {
  public:
    void add(vec3 albedo, float x0, float x1, float y0, float y1, float z = half) {
        add_box(group_.triangles, {{x0, y0, -z}, {x1, y1, z}}, albedo, 1.0f);
    }
    void add_skirting(float x0, float x1) {
        add_box(group_.triangles, {{x0, 0, half}, {x1, 0.0625f, half + 0.0125f}}, frame);
        add_box(group_.triangles, {{x0, 0, -half - 0.0125f}, {x1, 0.0625f, -half}}, frame);
    }
    /// Opened by a quarter turn towards -z.
    void add_door_leaf(float hinge) {
        constexpr float z = -half - 0.03125f;
        add_box(group_.triangles, {{hinge, 0.01f, z - 0.875f}, {hinge + 0.03125f, door_height - 0.05f, z}}, door_wood);
        for (const float x : {hinge - 0.05f, hinge + 0.03125f}) {
            add_box(group_.triangles, {{x, 1.0f, z - 0.82f}, {x + 0.05f, 1.03f, z - 0.7f}}, frame);
        }
    }
    Group take() { return std::move(group_); }

  private:
    Group group_;
};

Group solid_wall(float length, vec3 albedo) {
    Wall wall;
    wall.add(albedo, half, length - half, 0, wall_height);
    wall.add_skirting(half, length - half);
    return wall.take();
}

Group wall_with_door(float length, float door_center, vec3 albedo) {
    constexpr float jamb = 0.03125f, rim = half + 0.015625f;
    const float left = door_center - 0.5f * door_width, right = door_center + 0.5f * door_width;
    Wall wall;
    wall.add(albedo, half, left, 0, wall_height);
    wall.add(albedo, right, length - half, 0, wall_height);
    wall.add(albedo, left, right, door_height, wall_height);
    wall.add_skirting(half, left);
    wall.add_skirting(right, length - half);
    wall.add(frame, left, left + jamb, 0, door_height, rim);
    wall.add(frame, right - jamb, right, 0, door_height, rim);
    wall.add(frame, left + jamb, right - jamb, door_height - jamb, door_height, rim);
    wall.add_door_leaf(left + jamb);
    return wall.take();
}

Group facade(float length) {
    constexpr float sill = 0.875f, head = 2.5f, bar = 0.03125f, pier = 0.375f, bars = 0.03125f;
    Wall wall;
    wall.add(concrete, half, length - half, 0, sill);
    wall.add(concrete, half, length - half, head, wall_height);
    wall.add(concrete, half, pier, sill, head);
    wall.add(concrete, length - pier, length - half, sill, head);
    wall.add(frame, pier, length - pier, sill, sill + bar, half + 0.03125f);
    wall.add(frame, pier, length - pier, head - bar, head, bars);
    wall.add(frame, pier, pier + bar, sill + bar, head - bar, bars);
    wall.add(frame, length - pier - bar, length - pier, sill + bar, head - bar, bars);
    wall.add(frame, middle(0, length) - 0.5f * bar, middle(0, length) + 0.5f * bar, sill + bar, head - bar, bars);
    return wall.take();
}

Group post() {
    Group group;
    add_box(group.triangles, {{-half, 0, -half}, {half, wall_height, half}}, concrete, 1.0f);
    return group;
}

/// Floor, ceiling and lamps from (0, 0) to (width, z1) in plan; the ceiling keeps `x_margin` from walls along z.
Group bay(float z1, float x_margin, vec3 floor_albedo) {
    Group group;
    add_box(group.triangles, {{0, -slab, 0}, {width, 0, z1}}, floor_albedo);
    add_box(group.triangles, {{x_margin, ceiling, half}, {width - x_margin, ceiling + panel, z1 - half}}, tiles);
    for (const float z : {0.3125f * z1, 0.6875f * z1}) {
        add_box(group.triangles, {{1.25f, ceiling - panel, z - 0.125f}, {2.75f, ceiling, z + 0.125f}}, glow, 1.0f);
    }
    return group;
}

/// Groups that rooms and floors are made of, by what they are.
struct Parts {
    explicit Parts(Scene& s, std::uint64_t seed) : scene(s) {
        Random random(seed * 0x8a5cd789635d2dffu + 3);
        for (auto& i : desks) i = add(desk(random));
        for (auto& i : shelves) i = add(shelf(random));
        for (auto& i : cabinets) i = add(cabinet(random));
        for (auto& i : plants) i = add(plant(random));
        work_chair = add(chair({0.05f, 0.07f, 0.2f}));
        guest_chair = add(chair({0.25f, 0.05f, 0.04f}));
        waste_bin = add(bin());
        board = add(whiteboard());
        corridor_wall = add(wall_with_door(width, 0.5f * width, white));
        open_partition = add(wall_with_door(depth, door_to_neighbor, green));
        solid_partition = add(solid_wall(depth, green));
        back_wall = add(solid_wall(width, white));
        facade_along_x = add(facade(width));
        facade_along_z = add(facade(depth));
        corridor_end = add(facade(corridor_width));
        column = add(post());
        corridor_bay = add(bay(corridor_width, 0, linoleum));
    }

    std::size_t add(Group group) {
        scene.groups.push_back(std::move(group));
        return scene.groups.size() - 1;
    }

    Scene& scene;
    std::size_t desks[3]{}, shelves[3]{}, cabinets[2]{}, plants[2]{};
    std::size_t work_chair, guest_chair, waste_bin, board;
    std::size_t corridor_wall, open_partition, solid_partition, back_wall;
    std::size_t facade_along_x, facade_along_z, corridor_end, column, corridor_bay;
};

/// From (0, 0) to (width, depth) in plan, the back wall (not its own) at z = 0, the wall to the corridor at z = depth.
Group room(const Parts& parts, Random& random) {
    Group group = bay(depth, half, carpet);
    const auto put = [&](std::size_t what, int turns, float x, float z) {
        group.placements.push_back({what, quarter_turn(turns, {x, 0, z})});
    };
    put(parts.corridor_wall, 0, 0, depth);
    const float clear = half + 0.02f;  // of the skirting
    put(parts.shelves[random.below(3)], 0, clear + 0.175f, 1.25f);
    put(parts.cabinets[random.below(2)], 0, width - clear - 0.225f, 0.95f);
    const float nudge = random.between(-0.1f, 0.1f);
    const int guests = static_cast<int>(1 + random.below(2));
    if (random.below(2) == 0) {
        put(parts.desks[random.below(3)], 0, 2.0f, 1.6f);
        put(parts.work_chair, 0, 2.0f + nudge, 0.8f);
        for (int i = 0; i < guests; ++i) put(parts.guest_chair, 2, 1.5f + static_cast<float>(i), 2.7f + nudge);
        put(parts.waste_bin, 0, 3.05f, 1.3f);
    } else {
        put(parts.desks[random.below(3)], 1, 2.9f, 1.6f);
        put(parts.work_chair, 1, 2.1f, 1.6f + nudge);
        for (int i = 0; i < guests; ++i) put(parts.guest_chair, i, 3.5f - 0.7f * static_cast<float>(i), 2.9f - nudge);
        put(parts.waste_bin, 0, 2.9f, 0.5f);
    }
    if (random.below(3) > 0) put(parts.board, 0, width - half, 1.2f);
    if (random.below(3) > 0) put(parts.plants[random.below(2)], static_cast<int>(random.below(4)), 3.5f, 4.5f);
    return group;
}

Group floor_plan(const BuildingOptions& options, const Parts& parts, std::size_t first_room, Random& random) {
    Group group;
    const auto put = [&](std::size_t what, int turns, float x, float z) {
        group.placements.push_back({what, quarter_turn(turns, {x, 0, z})});
    };
    const auto x_of = [&](std::size_t i) {
        return width * (static_cast<float>(i) - 0.5f * static_cast<float>(options.rooms_per_side));
    };
    const auto back_of = [&](std::size_t row) {
        return period * (static_cast<float>(row) - 0.5f * static_cast<float>(options.corridors));
    };
    const std::size_t rooms = options.rooms_per_side, rows = options.corridors;
    // To both sides of a corridor alike, from the back wall towards it: as it is, and by half a turn.
    const auto side = [&](float back, int turns) {
        const int along = turns == 0 ? 3 : 1;  // a wall along x comes to lie from the back wall to the corridor
        for (std::size_t i = 0; i < rooms; ++i) {
            const std::size_t kind = first_room + static_cast<std::size_t>(random.below(options.room_kinds));
            put(kind, turns, turns == 0 ? x_of(i) : x_of(i + 1), back);
        }
        for (std::size_t i = 0; i <= rooms; ++i) {
            put(parts.column, 0, x_of(i), turns == 0 ? back + depth : back - depth);
            const bool open = random.below(2) == 0;
            if (i > 0 && i < rooms) {
                put(open ? parts.open_partition : parts.solid_partition, along, x_of(i), back);
            } else if (options.exterior_walls) {
                put(parts.facade_along_z, along, x_of(i), back);
            }
        }
    };
    for (std::size_t row = 0; row < rows; ++row) {
        side(back_of(row), 0);
        side(back_of(row + 1), 2);
        const float corridor = back_of(row) + depth;
        for (std::size_t i = 0; i < rooms; ++i) put(parts.corridor_bay, 0, x_of(i), corridor);
        if (!options.exterior_walls) continue;
        put(parts.corridor_end, 3, x_of(0), corridor);
        put(parts.corridor_end, 3, x_of(rooms), corridor);
    }
    for (std::size_t row = 0; row <= rows; ++row) {
        const bool outer = row == 0 || row == rows;
        for (std::size_t i = 0; i <= rooms; ++i) put(parts.column, 0, x_of(i), back_of(row));
        if (outer && !options.exterior_walls) continue;
        for (std::size_t i = 0; i < rooms; ++i) {
            put(outer ? parts.facade_along_x : parts.back_wall, 0, x_of(i), back_of(row));
        }
    }
    return group;
}

}  // namespace

Scene building(const BuildingOptions& options) {
    if (options.floors == 0) throw std::invalid_argument("building: no floors");
    if (options.corridors == 0) throw std::invalid_argument("building: no corridors");
    if (options.rooms_per_side == 0) throw std::invalid_argument("building: no rooms");
    if (options.room_kinds == 0) throw std::invalid_argument("building: no room kinds");
    Scene scene{"building", {}};
    Parts parts(scene, options.seed);
    Random random(options.seed * 0xd6e8feb86659fd93u + 7);
    const std::size_t first_room = scene.groups.size();
    for (std::size_t kind = 0; kind < options.room_kinds; ++kind) parts.add(room(parts, random));
    const std::size_t plan = parts.add(floor_plan(options, parts, first_room, random));
    Group root;
    for (std::size_t i = 0; i < options.floors; ++i) {
        const int turns = i % 2 == 0 ? 0 : 2;
        root.placements.push_back({plan, quarter_turn(turns, {0, story * static_cast<float>(i), 0})});
    }
    const float x = 0.5f * width * static_cast<float>(options.rooms_per_side) + half;
    const float z = 0.5f * period * static_cast<float>(options.corridors) + half;
    const float top = story * static_cast<float>(options.floors);
    add_box(root.triangles, {{-x, top - slab, -z}, {x, top, z}}, concrete);
    parts.add(std::move(root));
    return scene;
}

BuildingOptions building_of_408_floors() {
    BuildingOptions options;
    options.floors = 408;
    options.corridors = 9;
    options.rooms_per_side = 17;
    return options;
}

Camera inside_building(const BuildingOptions& options) {
    const std::size_t room = options.rooms_per_side / 2, row = options.corridors / 2;
    const glm::dvec3 corner(double(width) * (double(room) - 0.5 * double(options.rooms_per_side)),
                            double(story) * double(options.floors / 2),
                            double(period) * (double(row) - 0.5 * double(options.corridors)));
    const glm::dvec3 eye = corner + glm::dvec3(2.6, 1.65, 0.35), door = corner + glm::dvec3(2, 1.45, depth);
    return Camera::perspective(eye, door, {0, 1, 0}, 1.04719755f);
}

Camera outside_building(const BuildingOptions& options) {
    const glm::dvec3 size(double(width) * double(options.rooms_per_side), double(story) * double(options.floors),
                          double(period) * double(options.corridors));
    const BoxD box{{-0.5 * size.x - half, -slab, -0.5 * size.z - half},
                   {0.5 * size.x + half, size.y, 0.5 * size.z + half}};
    const double rise = std::tan(0.261799388);  // 15 degrees
    return framing(box, {0.55, rise, 0.835}, 0.785398163f);
}

}  // namespace farfield::scenes
