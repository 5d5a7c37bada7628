// Grown in the manner of Weber and Penn, "Creation and rendering of realistic trees", SIGGRAPH 1995: levels
// of stems, each with its own down angle, curvature and number of children, inside a crown envelope. Ours
// differ in that lengths come from the envelope itself (the way to the crown's surface along the branch), and
// in the light: leaf area in a grid of voxels shades what is behind it.
#include "scenes/generate/tree.hpp"

#include <array>
#include <glm/gtc/constants.hpp>
#include <stdexcept>
#include <string>

#include "scenes/generate/random.hpp"

namespace farfield::scenes {
namespace {

using glm::vec3;

constexpr float golden_angle = 2.3999632f;
constexpr int levels = 4;  // trunk, branches, boughs, twigs

struct Stem {
    int level;
    std::vector<vec3> points;
    std::vector<float> radii;

    vec3 at(float t) const {
        const auto [i, f] = locate(t);
        return points[i] * (1.0f - f) + points[i + 1] * f;
    }
    float radius(float t) const {
        const auto [i, f] = locate(t);
        return radii[i] * (1.0f - f) + radii[i + 1] * f;
    }
    float length() const { return glm::length(points.back() - points.front()); }
    vec3 direction(float t) const {
        const std::size_t i = locate(t).first;
        return glm::normalize(points[i + 1] - points[i]);
    }

  private:
    std::pair<std::size_t, float> locate(float t) const {
        const float along = t * static_cast<float>(points.size() - 1);
        const std::size_t i = std::min(static_cast<std::size_t>(along), points.size() - 2);
        return {i, along - static_cast<float>(i)};
    }
};

struct Level {
    std::size_t segments, sides, children;  // of one stem; children of this level's stem
    float wobble, rise;                     // added to the direction at each segment
};

struct Plan {
    std::array<Level, levels> level;
    int last_level;
};

Plan plan_for(std::uint32_t triangles) {
    if (triangles >= 40'000) {
        return {
            {{{14, 12, 36, 0.07f, 0.03f}, {7, 7, 9, 0.16f, 0.05f}, {4, 4, 5, 0.22f, 0.04f}, {2, 3, 0, 0.2f, 0.05f}}},
            3};
    }
    if (triangles >= 7'000) {
        return {{{{9, 8, 28, 0.08f, 0.03f}, {4, 4, 7, 0.2f, 0.07f}, {2, 3, 0, 0.25f, 0.05f}, {1, 3, 0, 0.0f, 0.0f}}},
                2};
    }
    return {{{{5, 5, 14, 0.1f, 0.03f}, {3, 3, 4, 0.2f, 0.08f}, {1, 3, 0, 0.2f, 0.05f}, {1, 3, 0, 0.0f, 0.0f}}}, 2};
}

vec3 perpendicular(const vec3& d) {
    const vec3 axis = std::abs(d.y) < 0.9f ? vec3(0, 1, 0) : vec3(1, 0, 0);
    return glm::normalize(glm::cross(d, axis));
}

/// `direction` turned away from itself by `down`, towards `azimuth` about itself.
vec3 branched(const vec3& direction, float down, float azimuth) {
    const vec3 u = perpendicular(direction);
    const vec3 v = glm::cross(direction, u);
    return glm::normalize(direction * std::cos(down) +
                          (u * std::cos(azimuth) + v * std::sin(azimuth)) * std::sin(down));
}

/// An ellipsoid with lobes, for no crown is smooth.
class Crown {
  public:
    Crown(const TreeOptions& options, Random& random)
        : center_(0.0f, 0.60f * options.height_m, 0.0f),
          radii_(0.36f * options.height_m * options.breadth, 0.40f * options.height_m,
                 0.36f * options.height_m * options.breadth) {
        for (Lobe& lobe : lobes_) lobe = {random.direction(), random.between(-0.16f, 0.14f)};
    }

    float base() const { return center_.y - radii_.y; }
    const vec3& center() const { return center_; }

    /// Above 1 outside.
    float depth(const vec3& p) const {
        const vec3 d = (p - center_) / radii_;
        const float distance = glm::length(d);
        if (distance == 0.0f) return 0.0f;
        float scale = 1.0f;
        for (const Lobe& lobe : lobes_) {
            const float nearness = std::max(0.0f, glm::dot(d, lobe.direction) / distance);
            scale += lobe.height * nearness * nearness * nearness * nearness * nearness;
        }
        return distance / scale;
    }

    /// Meters from `p` to the surface along `direction`; 0 outside. By bisection, to a thousandth.
    float way_out(const vec3& p, const vec3& direction) const {
        float inside = 0.0f;
        float outside = 4.0f * std::max(radii_.x, radii_.y);
        if (depth(p) >= 1.0f) return 0.0f;
        for (int step = 0; step < 14; ++step) {
            const float middle = 0.5f * (inside + outside);
            (depth(p + direction * middle) < 1.0f ? inside : outside) = middle;
        }
        return inside;
    }

  private:
    struct Lobe {
        vec3 direction;
        float height;
    };
    vec3 center_;
    vec3 radii_;
    std::array<Lobe, 14> lobes_{};
};

Stem grown(Random& random, const Plan& plan, int level, vec3 start, vec3 direction, float length, float radius) {
    const Level& shape = plan.level[static_cast<std::size_t>(level)];
    Stem stem{level, {start}, {radius}};
    const float step = length / static_cast<float>(shape.segments);
    for (std::size_t s = 1; s <= shape.segments; ++s) {
        direction = glm::normalize(direction + shape.wobble * random.direction() + vec3(0, shape.rise, 0));
        stem.points.push_back(stem.points.back() + direction * step);
        const float t = static_cast<float>(s) / static_cast<float>(shape.segments);
        stem.radii.push_back(radius * (1.0f - 0.85f * t));
    }
    return stem;
}

Stem trunk_of(const TreeOptions& options, const Plan& plan, Random& random) {
    const float h = options.height_m;
    Stem trunk = grown(random, plan, 0, vec3(0), vec3(0, 1, 0), 0.86f * h, 0.021f * h);
    for (std::size_t i = 0; i < trunk.points.size(); ++i) {
        trunk.radii[i] *= 1.0f + 0.75f * std::exp(-trunk.points[i].y / (0.03f * h));  // roots
    }
    return trunk;
}

std::vector<Stem> stems_of(const TreeOptions& options, const Plan& plan, const Crown& crown, Random& random) {
    const float h = options.height_m;
    std::vector<Stem> stems{trunk_of(options, plan, random)};
    // Children are appended while parents are read, so parents are copied out: stems may reallocate.
    std::size_t first_parent = 0;
    for (int level = 1; level <= plan.last_level; ++level) {
        const std::size_t end_of_parents = stems.size();
        const std::size_t all_children =
            plan.level[static_cast<std::size_t>(level - 1)].children * (end_of_parents - first_parent);
        float all_length = 0.0f;
        for (std::size_t p = first_parent; p < end_of_parents; ++p) all_length += stems[p].length();
        float length_so_far = 0.0f;
        std::size_t children_so_far = 0;
        for (std::size_t p = first_parent; p < end_of_parents; ++p) {
            const Stem parent = stems[p];
            // Long stems have more children than short ones: as many a meter everywhere.
            length_so_far += parent.length();
            const float due = static_cast<float>(all_children) * std::min(1.0f, length_so_far / all_length);
            const std::size_t children = static_cast<std::size_t>(due + 0.5f) - children_so_far;
            children_so_far += children;
            float azimuth = random.between(0.0f, glm::two_pi<float>());
            const float first_t = level == 1 ? (crown.base() + 0.07f * h) / (0.86f * h) : 0.25f;
            for (std::size_t c = 0; c < children; ++c) {
                const float along = (static_cast<float>(c) + random.between(0.1f, 0.9f)) / static_cast<float>(children);
                const float t = first_t + (1.0f - first_t) * along;
                azimuth += golden_angle + random.between(-0.4f, 0.4f);
                const vec3 start = parent.at(t);
                float down = random.between(0.65f, 1.1f);
                if (level == 1) down = 1.45f - 1.05f * along + random.between(-0.15f, 0.15f);
                vec3 direction = branched(parent.direction(t), down, azimuth);
                const float way_out = crown.way_out(start, direction);
                float length = way_out * random.between(0.78f, 1.02f);
                if (level == 2) length = std::min(length, h * random.between(0.09f, 0.17f));
                if (level == 3) length = std::min(std::max(length, 0.02f * h), h * random.between(0.03f, 0.06f));
                length = std::max(length, 0.015f * h);
                const float thickness = level == 1 ? 0.021f : level == 2 ? 0.014f : 0.009f;
                const float radius = std::min(0.62f * parent.radius(t), thickness * length + 0.0006f * h);
                stems.push_back(grown(random, plan, level, start, direction, length, radius));
            }
        }
        first_parent = end_of_parents;
    }
    return stems;
}

struct Leaf {
    vec3 base, along, normal;
    float length;
    vec3 albedo;
};

/// How much of the sun, or of the sky, gets through the leaves (Beer and Lambert, over a grid of leaf area).
class Shade {
  public:
    Shade(const std::vector<Leaf>& leaves, float leaf_area, float cell) : cell_(cell) {
        box_ = Box::empty();
        for (const Leaf& leaf : leaves) box_.add(leaf.base);
        if (leaves.empty()) return;
        for (int axis = 0; axis < 3; ++axis) {
            size_[static_cast<std::size_t>(axis)] = static_cast<int>(box_.size()[axis] / cell_) + 1;
        }
        density_.resize(static_cast<std::size_t>(size_[0]) * static_cast<std::size_t>(size_[1]) *
                        static_cast<std::size_t>(size_[2]));
        for (const Leaf& leaf : leaves) density_[index(leaf.base)] += leaf_area / (cell_ * cell_ * cell_);
    }

    float seen(vec3 p, const vec3& direction) const {
        if (density_.empty()) return 1.0f;
        constexpr float extinction = 0.42f;  // 0.5 for leaves turned every way; less, for light scatters on
        float depth = 0.0f;
        p += direction * (0.75f * cell_);
        while (box_.contains(p)) {
            depth += density_[index(p)] * cell_ * extinction;
            p += direction * cell_;
        }
        return std::exp(-depth);
    }

    float sky_seen(const vec3& p) const {
        float sum = 2.0f * seen(p, vec3(0, 1, 0));
        for (int i = 0; i < 6; ++i) {
            const float azimuth = glm::two_pi<float>() * static_cast<float>(i) / 6.0f;
            sum += seen(p, vec3(0.8f * std::cos(azimuth), 0.6f, 0.8f * std::sin(azimuth)));
        }
        return sum / 8.0f;
    }

  private:
    std::size_t index(const vec3& p) const {
        std::size_t result = 0;
        for (int axis = 2; axis >= 0; --axis) {
            const int n = size_[static_cast<std::size_t>(axis)];
            const int i = std::clamp(static_cast<int>((p[axis] - box_.lower[axis]) / cell_), 0, n - 1);
            result = result * static_cast<std::size_t>(n) + static_cast<std::size_t>(i);
        }
        return result;
    }

    float cell_;
    Box box_;
    std::array<int, 3> size_{};
    std::vector<float> density_;
};

std::uint64_t wood_triangles(const std::vector<Stem>& stems, const Plan& plan) {
    std::uint64_t count = 0;
    for (const Stem& stem : stems) {
        const Level& shape = plan.level[static_cast<std::size_t>(stem.level)];
        count += shape.sides * (2 * shape.segments - 1);
    }
    return count;
}

/// `count` leaves, spread over the stems of the last level and the tips of the one before, as many a meter
/// everywhere.
std::vector<Leaf> leaves_on(const std::vector<Stem>& stems, const Plan& plan, const Crown& crown, std::size_t count,
                            float length, Random& random) {
    std::vector<const Stem*> twigs;
    for (const Stem& stem : stems) {
        if (stem.level >= plan.last_level - 1 && stem.level > 0) twigs.push_back(&stem);
    }
    float all_weight = 0.0f;
    const auto weight = [&](const Stem& stem) { return stem.length() * (stem.level == plan.last_level ? 1.0f : 0.3f); };
    for (const Stem* twig : twigs) all_weight += weight(*twig);
    float weight_so_far = 0.0f;
    const float tint = random.unit();
    std::vector<Leaf> leaves;
    leaves.reserve(count);
    for (std::size_t w = 0; w < twigs.size(); ++w) {
        const Stem& twig = *twigs[w];
        weight_so_far += weight(twig);
        const float due = static_cast<float>(count) * std::min(1.0f, weight_so_far / all_weight);
        const std::size_t upto = w + 1 == twigs.size() ? count : static_cast<std::size_t>(due);
        const std::size_t here = std::max(upto, leaves.size()) - leaves.size();
        const bool last = twig.level == plan.last_level;
        const float twig_tint = random.between(-0.25f, 0.25f);
        float azimuth = random.between(0.0f, glm::two_pi<float>());
        for (std::size_t i = 0; i < here; ++i) {
            const float spread = (static_cast<float>(i) + random.unit()) / static_cast<float>(here);
            const float t = last ? 0.15f + 0.85f * spread : 0.6f + 0.4f * spread;
            azimuth += golden_angle + random.between(-0.3f, 0.3f);
            const vec3 place = twig.at(t);
            const float down = random.between(0.5f, 1.25f) * (1.15f - 0.5f * t);
            vec3 along = branched(twig.direction(t), down, azimuth);
            along = glm::normalize(along + vec3(0, random.between(-0.45f, 0.1f), 0));
            const vec3 outward = glm::normalize(place - crown.center() + 1e-3f * random.direction());
            vec3 normal = vec3(0, 0.8f, 0) + 0.5f * outward + 0.7f * random.direction();
            normal -= along * glm::dot(normal, along);
            // Nearly along the leaf, rarely: any perpendicular is as good.
            normal = glm::length(normal) > 0.05f ? glm::normalize(normal) : perpendicular(along);
            const float yellow = std::clamp(0.45f * tint + twig_tint + random.between(-0.1f, 0.35f), 0.0f, 1.0f);
            vec3 albedo = vec3(0.045f, 0.150f, 0.020f) * (1.0f - yellow) + vec3(0.200f, 0.300f, 0.035f) * yellow;
            albedo *= random.between(0.75f, 1.25f);
            leaves.push_back(
                {place + along * (0.15f * length), along, normal, length * random.between(0.72f, 1.28f), albedo});
        }
    }
    return leaves;
}

constexpr float leaf_breadth = 0.55f;  // of its length

void append(std::vector<VertexColoredTriangle>& triangles, const Leaf& leaf, const Shade& shade, const Light& light,
            bool half) {
    const vec3 middle = leaf.base + leaf.along * (0.5f * leaf.length);
    const vec3 side = glm::cross(leaf.normal, leaf.along) * (0.5f * leaf_breadth * leaf.length);
    const vec3 fold = leaf.normal * (0.12f * leaf.length);
    const vec3 tip = leaf.base + leaf.along * leaf.length - leaf.normal * (0.06f * leaf.length);
    const float sun = shade.seen(middle, light.to_sun);
    const float sky = shade.sky_seen(middle);
    const vec3 widest = leaf.base + leaf.along * (0.42f * leaf.length) + fold;
    const auto add = [&](const vec3& a, const vec3& b, const vec3& c) {
        const vec3 normal = glm::normalize(glm::cross(b - a, c - a));
        // Both sides get this color: reflected light on one, transmitted (half as much, and yellower) on the
        // other, and so the mean of the two over all ways a leaf may be turned to viewer and sun.
        const float facing = std::abs(glm::dot(normal, light.to_sun));
        const vec3 up_side = normal.y < 0 ? -normal : normal;
        const vec3 reflected =
            lit(light, leaf.albedo, up_side, 0.0f, sky) + leaf.albedo * light.sun * (0.15f + 0.75f * facing) * sun;
        const vec3 transmitted = vec3(0.055f, 0.06f, 0.0f) * light.sun * (facing * sun);
        const Rgba8 color = display_color(reflected + transmitted);
        triangles.push_back({{a, b, c}, {color, color, color}});
    };
    add(leaf.base, widest - side, tip);
    if (!half) add(leaf.base, tip, widest + side);
}

void append(std::vector<VertexColoredTriangle>& triangles, const Stem& stem, std::size_t sides, const Shade& shade,
            const Light& light, Random& random) {
    const std::size_t rings = stem.points.size();
    std::vector<vec3> vertices;
    std::vector<Rgba8> colors;
    vec3 u = perpendicular(stem.direction(0.0f));
    const vec3 bark = stem.level == 3 ? vec3(0.13f, 0.10f, 0.05f) : vec3(0.16f, 0.115f, 0.08f);
    for (std::size_t r = 0; r < rings; ++r) {
        vec3 d = stem.points[std::min(r + 1, rings - 1)] - stem.points[r == 0 ? 0 : r - 1];
        d = glm::normalize(stem.level == 0 && r == 0 ? vec3(0, 1, 0) : d);  // the foot is level
        u = glm::normalize(u - d * glm::dot(u, d));
        const vec3 v = glm::cross(d, u);
        const float sky = shade.sky_seen(stem.points[r]);
        const float sun = shade.seen(stem.points[r], light.to_sun);
        for (std::size_t s = 0; s < sides; ++s) {
            const float angle = glm::two_pi<float>() * static_cast<float>(s) / static_cast<float>(sides);
            const vec3 normal = u * std::cos(angle) + v * std::sin(angle);
            const float ridge = stem.level == 0 ? random.between(0.86f, 1.14f) : 1.0f;
            vertices.push_back(stem.points[r] + normal * (stem.radii[r] * ridge));
            const vec3 albedo = bark * random.between(0.65f, 1.35f);
            colors.push_back(display_color(lit(light, albedo, normal, sun, sky)));
        }
    }
    const auto add = [&](std::size_t a, std::size_t b, std::size_t c) {
        triangles.push_back({{vertices[a], vertices[b], vertices[c]}, {colors[a], colors[b], colors[c]}});
    };
    // The last ring is drawn together to a point.
    const std::size_t apex = (rings - 1) * sides;
    vertices[apex] = stem.points.back();
    for (std::size_t r = 0; r + 1 < rings; ++r) {
        for (std::size_t s = 0; s < sides; ++s) {
            const std::size_t a = r * sides + s;
            const std::size_t b = r * sides + (s + 1) % sides;
            if (r + 2 == rings) {
                add(a, b, apex);
            } else {
                add(a, b, b + sides);
                add(a, b + sides, a + sides);
            }
        }
    }
}

}  // namespace

Scene tree(const TreeOptions& options) {
    if (options.triangles < 2'000) throw std::invalid_argument("tree: fewer than 2,000 triangles");
    if (!(options.height_m > 0) || !std::isfinite(options.height_m) || !(options.breadth > 0) ||
        !std::isfinite(options.breadth)) {
        throw std::invalid_argument("tree: height and breadth must be positive and finite");
    }
    Random random(options.seed * 0x9e3779b97f4a7c15u + 17);
    const Plan plan = plan_for(options.triangles);
    const Crown crown(options, random);
    const std::vector<Stem> stems = stems_of(options, plan, crown, random);
    const std::uint64_t left = options.triangles - wood_triangles(stems, plan);
    const std::size_t leaf_count = static_cast<std::size_t>((left + 1) / 2);

    // Leaf area is about four times the ground under the crown, as in a closed broadleaf stand.
    const float crown_radius = 0.36f * options.height_m * options.breadth;
    const float leaf_area = 3.2f * glm::pi<float>() * crown_radius * crown_radius / static_cast<float>(leaf_count);
    const float leaf_length = std::sqrt(leaf_area / (0.5f * leaf_breadth));
    const std::vector<Leaf> leaves = leaves_on(stems, plan, crown, leaf_count, leaf_length, random);
    const Shade shade(leaves, leaf_area, 0.035f * options.height_m);

    Scene scene{"tree", std::vector<Group>(1)};
    std::vector<VertexColoredTriangle>& triangles = scene.groups[0].triangles;
    triangles.reserve(options.triangles);
    for (const Stem& stem : stems) {
        append(triangles, stem, plan.level[static_cast<std::size_t>(stem.level)].sides, shade, options.light, random);
    }
    for (std::size_t i = 0; i < leaves.size(); ++i) {
        append(triangles, leaves[i], shade, options.light, left % 2 == 1 && i + 1 == leaves.size());
    }
    return scene;
}

Scene tree(std::uint64_t seed) {
    TreeOptions options;
    options.seed = seed;
    return tree(options);
}

}  // namespace farfield::scenes
