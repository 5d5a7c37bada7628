#include "scenes/generate/copies.hpp"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <stdexcept>
#include <utility>

#include "scenes/generate/random.hpp"

namespace farfield::scenes {

Scene copies(Scene scene, std::uint32_t count) {
    if (count == 0) throw std::invalid_argument("copies: there must be 1 or more");
    const Box box = bounds(scene);
    if (box.is_empty()) throw std::invalid_argument("copies: there is nothing to copy");
    const glm::dvec3 up = glm::normalize(glm::dvec3(scene.up));
    const glm::dvec3 aside = std::abs(up.x) < 0.5 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0);
    const glm::dvec3 across = glm::normalize(glm::cross(aside, up)), along = glm::cross(up, across);
    const double spacing = 1.25 * std::max(glm::dot(glm::abs(across), glm::dvec3(box.size())),
                                           glm::dot(glm::abs(along), glm::dvec3(box.size())));
    const auto side = std::uint32_t(std::ceil(std::sqrt(double(count))));
    const glm::dvec3 middle(box.center());

    Random random(1);
    const std::size_t one = scene.groups.size() - 1;
    Group rows;
    rows.placements.reserve(count);
    for (std::uint32_t i = 0; i < count; ++i) {
        const double x = (i % side) - 0.5 * (side - 1), z = (i / side) - 0.5 * (side - 1);
        glm::dmat4 to_parent = glm::translate(glm::dmat4(1), middle + spacing * (x * across + z * along));
        to_parent = glm::rotate(to_parent, 6.28318530717958648 * double(random.unit()), up);
        rows.placements.push_back({one, glm::mat4(glm::translate(to_parent, -middle))});
    }
    scene.groups.push_back(std::move(rows));
    return scene;
}

}  // namespace farfield::scenes
