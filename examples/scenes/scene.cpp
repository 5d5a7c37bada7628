#include "scenes/scene.hpp"

#include <limits>
#include <stdexcept>

namespace farfield::scenes {
namespace {

void check(const Scene& scene) {
    if (scene.groups.empty()) throw std::invalid_argument("scene '" + scene.name + "' has no group");
    for (std::size_t g = 0; g < scene.groups.size(); ++g) {
        for (const Placement& placement : scene.groups[g].placements) {
            if (placement.group >= g) {
                throw std::invalid_argument("scene '" + scene.name + "': group " + std::to_string(g) +
                                            " places group " + std::to_string(placement.group) +
                                            ", which is not an earlier one");
            }
        }
    }
}

glm::vec3 transformed(const glm::mat4& m, const glm::vec3& p) {
    return glm::vec3(m * glm::vec4(p, 1.0f));
}

Box transformed(const glm::mat4& m, const Box& box) {
    Box result = Box::empty();
    for (int corner = 0; corner < 8; ++corner) {
        result.add(
            transformed(m, glm::vec3((corner & 1) ? box.upper.x : box.lower.x, (corner & 2) ? box.upper.y : box.lower.y,
                                     (corner & 4) ? box.upper.z : box.lower.z)));
    }
    return result;
}

void append(const Scene& scene, std::size_t group, const glm::mat4& to_world,
            std::vector<VertexColoredTriangle>& triangles) {
    for (VertexColoredTriangle triangle : scene.groups[group].triangles) {
        for (glm::vec3& vertex : triangle.vertices) vertex = transformed(to_world, vertex);
        triangles.push_back(triangle);
    }
    for (const Placement& placement : scene.groups[group].placements) {
        append(scene, placement.group, to_world * placement.to_parent, triangles);
    }
}

}  // namespace

std::uint64_t triangle_count(const Scene& scene) {
    check(scene);
    constexpr std::uint64_t most = std::numeric_limits<std::uint64_t>::max();
    std::vector<std::uint64_t> counts;
    counts.reserve(scene.groups.size());
    for (const Group& group : scene.groups) {
        std::uint64_t count = group.triangles.size();
        for (const Placement& placement : group.placements) {
            const std::uint64_t inner = counts[placement.group];
            count = inner > most - count ? most : count + inner;
        }
        counts.push_back(count);
    }
    return counts.back();
}

Box bounds(const Scene& scene) {
    check(scene);
    std::vector<Box> boxes;
    boxes.reserve(scene.groups.size());
    for (const Group& group : scene.groups) {
        Box box = Box::empty();
        for (const VertexColoredTriangle& triangle : group.triangles) box.add(triangle.bounds());
        for (const Placement& placement : group.placements) {
            const Box& inner = boxes[placement.group];
            if (!inner.is_empty()) box.add(transformed(placement.to_parent, inner));
        }
        boxes.push_back(box);
    }
    return boxes.back();
}

std::uint64_t bytes(const Scene& scene) {
    check(scene);
    std::uint64_t sum = 0;
    for (const Group& group : scene.groups) {
        sum += group.triangles.size() * sizeof(VertexColoredTriangle);
        sum += group.placements.size() * sizeof(Placement);
    }
    return sum;
}

Scene expanded(const Scene& scene, std::uint64_t triangle_limit) {
    const std::uint64_t count = triangle_count(scene);
    if (count > triangle_limit) {
        throw std::length_error("scene '" + scene.name + "' has " + std::to_string(count) +
                                " triangles when expanded, more than the limit of " + std::to_string(triangle_limit));
    }
    Scene result{scene.name, std::vector<Group>(1), scene.up, scene.origin};
    result.is_closed = scene.is_closed;
    result.groups[0].triangles.reserve(static_cast<std::size_t>(count));
    append(scene, scene.groups.size() - 1, glm::mat4(1.0f), result.groups[0].triangles);
    return result;
}

}  // namespace farfield::scenes
