#include "scenes/generate/furniture.hpp"

#include <utility>

#include "scenes/generate/boxes.hpp"

namespace farfield::scenes {
namespace {

using glm::vec3;

constexpr vec3 wood{0.42f, 0.25f, 0.12f}, pale_wood{0.62f, 0.45f, 0.27f}, metal{0.45f, 0.46f, 0.48f};
constexpr vec3 plastic{0.06f, 0.06f, 0.065f}, gray_plastic{0.25f, 0.25f, 0.26f}, paper{0.85f, 0.84f, 0.8f};

class Boxes {
  public:
    /// From (x0, y0, z0) to (x1, y1, z1).
    Boxes& add(vec3 albedo, vec3 lower, vec3 upper) {
        add_box(group_.triangles, {lower, upper}, albedo);
        return *this;
    }
    Group take() { return std::move(group_); }

  private:
    Group group_;
};

vec3 binder_color(Random& random) {
    constexpr vec3 colors[] = {{0.5f, 0.05f, 0.04f}, {0.05f, 0.12f, 0.4f},  {0.03f, 0.25f, 0.12f},
                               {0.7f, 0.5f, 0.08f},  {0.08f, 0.08f, 0.09f}, {0.7f, 0.68f, 0.62f}};
    return colors[random.below(6)] * random.between(0.7f, 1.1f);
}

void add_drawers(Boxes& boxes) {
    boxes.add(pale_wood, {0.36f, 0.05f, -0.36f}, {0.76f, 0.72f, 0.34f});
    for (int i = 0; i < 3; ++i) {
        const float y = 0.07f + 0.215f * static_cast<float>(i);
        boxes.add(wood, {0.37f, y, -0.38f}, {0.75f, y + 0.2f, -0.36f});
        boxes.add(metal, {0.5f, y + 0.13f, -0.4f}, {0.62f, y + 0.15f, -0.38f});
    }
}

void add_monitor(Boxes& boxes, float x) {
    boxes.add(plastic, {x - 0.12f, 0.75f, 0.06f}, {x + 0.12f, 0.76f, 0.24f});
    boxes.add(plastic, {x - 0.03f, 0.76f, 0.15f}, {x + 0.03f, 0.95f, 0.19f});
    boxes.add(gray_plastic, {x - 0.3f, 0.85f, 0.1f}, {x + 0.3f, 1.22f, 0.15f});
    boxes.add({0.25f, 0.55f, 1.1f}, {x - 0.28f, 0.87f, 0.095f}, {x + 0.28f, 1.2f, 0.1f});
}

void add_keyboard(Boxes& boxes, float x) {
    boxes.add(gray_plastic, {x - 0.22f, 0.75f, -0.3f}, {x + 0.22f, 0.765f, -0.14f});
    for (int row = 0; row < 4; ++row) {
        const float z = -0.29f + 0.037f * static_cast<float>(row);
        boxes.add(paper, {x - 0.21f, 0.765f, z}, {x + 0.21f, 0.775f, z + 0.03f});
    }
    boxes.add(gray_plastic, {x + 0.28f, 0.75f, -0.27f}, {x + 0.34f, 0.78f, -0.17f});
}

void add_lamp(Boxes& boxes) {
    boxes.add(metal, {-0.72f, 0.75f, 0.15f}, {-0.54f, 0.77f, 0.33f});
    boxes.add(metal, {-0.64f, 0.77f, 0.23f}, {-0.62f, 1.13f, 0.25f});
    boxes.add({0.1f, 0.3f, 0.2f}, {-0.72f, 1.13f, 0.1f}, {-0.54f, 1.2f, 0.28f});
    boxes.add({3.0f, 2.8f, 2.2f}, {-0.7f, 1.12f, 0.12f}, {-0.56f, 1.13f, 0.22f});
}

void add_telephone(Boxes& boxes) {
    boxes.add(plastic, {0.5f, 0.75f, 0.05f}, {0.7f, 0.79f, 0.25f});
    boxes.add(gray_plastic, {0.52f, 0.79f, 0.07f}, {0.57f, 0.82f, 0.23f});
    boxes.add(paper, {0.6f, 0.79f, 0.08f}, {0.68f, 0.8f, 0.18f});
}

}  // namespace

Group desk(Random& random) {
    Boxes boxes;
    boxes.add(wood, {-0.8f, 0.72f, -0.4f}, {0.8f, 0.75f, 0.4f});
    boxes.add(pale_wood, {-0.8f, 0, -0.38f}, {-0.76f, 0.72f, 0.38f});
    boxes.add(pale_wood, {0.76f, 0, -0.38f}, {0.8f, 0.72f, 0.38f});
    boxes.add(pale_wood, {-0.76f, 0.2f, 0.34f}, {0.76f, 0.72f, 0.37f});
    add_drawers(boxes);
    const float x = random.between(-0.15f, 0.1f);
    add_monitor(boxes, x);
    add_keyboard(boxes, x);
    add_lamp(boxes);
    add_telephone(boxes);
    float height = 0.75f;
    for (std::uint64_t sheets = 2 + random.below(4); sheets > 0; --sheets) {
        const float dx = random.between(-0.03f, 0.03f), dz = random.between(-0.03f, 0.03f);
        boxes.add(paper, {-0.66f + dx, height, -0.3f + dz}, {-0.45f + dx, height + 0.01f, dz}), height += 0.01f;
    }
    boxes.add(binder_color(random), {0.45f, 0.75f, -0.25f}, {0.53f, 0.85f, -0.17f});  // a mug
    return boxes.take();
}

Group chair(vec3 cloth) {
    Boxes boxes;
    boxes.add(cloth, {-0.24f, 0.44f, -0.24f}, {0.24f, 0.5f, 0.24f});
    boxes.add(cloth, {-0.22f, 0.58f, -0.28f}, {0.22f, 1.02f, -0.23f});
    boxes.add(plastic, {-0.04f, 0.47f, -0.3f}, {0.04f, 0.8f, -0.28f});
    boxes.add(metal, {-0.03f, 0.08f, -0.03f}, {0.03f, 0.44f, 0.03f});
    for (const float side : {-1.0f, 1.0f}) {
        const float inner = side < 0 ? -0.28f : 0.03f, outer = side < 0 ? -0.03f : 0.28f;
        boxes.add(metal, {inner, 0.06f, -0.025f}, {outer, 0.1f, 0.025f});
        boxes.add(metal, {-0.025f, 0.06f, inner}, {0.025f, 0.1f, outer});
        const float caster = side * 0.25f;
        boxes.add(plastic, {caster - 0.025f, 0, -0.025f}, {caster + 0.025f, 0.06f, 0.025f});
        boxes.add(plastic, {-0.025f, 0, caster - 0.025f}, {0.025f, 0.06f, caster + 0.025f});
        const float arm = side * 0.27f;
        boxes.add(plastic, {arm - 0.03f, 0.68f, -0.2f}, {arm + 0.03f, 0.71f, 0.12f});
        boxes.add(plastic, {arm - 0.02f, 0.44f, -0.05f}, {arm + 0.02f, 0.68f, 0.0f});
    }
    return boxes.take();
}

Group shelf(Random& random) {
    Boxes boxes;
    constexpr float half = 0.875f, deep = 0.35f;
    const float back = -0.5f * deep, front = 0.5f * deep;
    boxes.add(pale_wood, {back, 0, -half}, {back + 0.02f, 2, half});
    boxes.add(pale_wood, {back + 0.02f, 0, -half}, {front, 2, -half + 0.03f});
    boxes.add(pale_wood, {back + 0.02f, 0, half - 0.03f}, {front, 2, half});
    for (int board = 0; board < 6; ++board) {
        const float y = 0.06f + 0.378f * static_cast<float>(board);
        boxes.add(pale_wood, {back + 0.02f, y, -half + 0.03f}, {front, y + 0.025f, half - 0.03f});
        if (board == 5) break;
        for (float z = -half + 0.04f; z < half - 0.15f;) {
            const float wide = random.between(0.06f, 0.11f);
            if (random.unit() < 0.75f) {
                const float high = random.between(0.26f, 0.33f), out = random.between(0.24f, 0.31f);
                boxes.add(binder_color(random), {back + 0.02f, y + 0.025f, z},
                          {back + out, y + 0.025f + high, z + wide});
            }
            z += wide + 0.005f;
        }
    }
    return boxes.take();
}

Group cabinet(Random& random) {
    Boxes boxes;
    boxes.add(gray_plastic, {-0.2f, 0.05f, -0.6f}, {0.225f, 0.78f, 0.6f});
    boxes.add(plastic, {-0.16f, 0, -0.56f}, {0.2f, 0.05f, 0.56f});
    boxes.add(wood, {-0.225f, 0.78f, -0.6f}, {0.225f, 0.8f, 0.6f});
    for (int door = 0; door < 2; ++door) {
        const float z = -0.59f + 0.595f * static_cast<float>(door);
        boxes.add(metal, {-0.22f, 0.07f, z}, {-0.2f, 0.77f, z + 0.585f});
        const float handle = door == 0 ? 0.52f + z : 0.04f + z;
        boxes.add(plastic, {-0.24f, 0.4f, handle}, {-0.22f, 0.52f, handle + 0.02f});
    }
    for (int i = 0; i < 3; ++i) {  // what was put down there
        const float z = -0.5f + 0.38f * static_cast<float>(i) + random.between(0.0f, 0.1f);
        const float high = random.between(0.05f, 0.2f);
        boxes.add(binder_color(random), {-0.15f, 0.8f, z}, {0.1f, 0.8f + high, z + 0.2f});
    }
    return boxes.take();
}

Group plant(Random& random) {
    Boxes boxes;
    boxes.add({0.45f, 0.16f, 0.08f}, {-0.15f, 0, -0.15f}, {0.15f, 0.3f, 0.15f});
    boxes.add({0.05f, 0.035f, 0.02f}, {-0.13f, 0.3f, -0.13f}, {0.13f, 0.31f, 0.13f});
    boxes.add(wood, {-0.015f, 0.31f, -0.015f}, {0.015f, 1.1f, 0.015f});
    for (int leaf = 0; leaf < 24; ++leaf) {
        const vec3 center = vec3(0, 0.9f, 0) + random.direction() * vec3(0.2f, 0.4f, 0.2f);
        const vec3 half(random.between(0.04f, 0.1f), 0.006f, random.between(0.04f, 0.1f));
        boxes.add(vec3(0.06f, 0.22f, 0.05f) * random.between(0.6f, 1.3f), center - half, center + half);
    }
    return boxes.take();
}

Group bin() {
    Boxes boxes;
    boxes.add(metal, {-0.13f, 0, -0.13f}, {0.13f, 0.01f, 0.13f});
    boxes.add(metal, {-0.13f, 0.01f, -0.13f}, {-0.12f, 0.32f, 0.13f});
    boxes.add(metal, {0.12f, 0.01f, -0.13f}, {0.13f, 0.32f, 0.13f});
    boxes.add(metal, {-0.12f, 0.01f, -0.13f}, {0.12f, 0.32f, -0.12f});
    boxes.add(metal, {-0.12f, 0.01f, 0.12f}, {0.12f, 0.32f, 0.13f});
    boxes.add(paper, {-0.08f, 0.01f, -0.06f}, {0.05f, 0.12f, 0.08f});
    return boxes.take();
}

Group whiteboard() {
    Boxes boxes;
    boxes.add(paper * 1.1f, {-0.015f, 1.02f, -0.73f}, {0, 1.98f, 0.73f});
    boxes.add(metal, {-0.02f, 1.98f, -0.75f}, {0, 2, 0.75f});
    boxes.add(metal, {-0.06f, 1, -0.75f}, {0, 1.02f, 0.75f});
    boxes.add(metal, {-0.02f, 1.02f, -0.75f}, {0, 1.98f, -0.73f});
    boxes.add(metal, {-0.02f, 1.02f, 0.73f}, {0, 1.98f, 0.75f});
    boxes.add({0.5f, 0.03f, 0.03f}, {-0.05f, 1.02f, -0.3f}, {-0.035f, 1.035f, -0.18f});
    boxes.add({0.03f, 0.05f, 0.5f}, {-0.05f, 1.02f, -0.1f}, {-0.035f, 1.035f, 0.02f});
    return boxes.take();
}

}  // namespace farfield::scenes
