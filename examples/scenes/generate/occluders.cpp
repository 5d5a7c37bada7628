#include "scenes/generate/occluders.hpp"

#include <glm/vec3.hpp>
#include <stdexcept>

#include "scenes/generate/random.hpp"

namespace farfield::scenes {

std::vector<Triangle> occluders_with_gap(const GapOptions& o) {
    if (!(o.gap > 0 && o.gap < 1)) throw std::invalid_argument("occluders_with_gap: gap must lie between 0 and 1");
    if (o.side_quads == 0) throw std::invalid_argument("occluders_with_gap: side_quads must be above 0");
    if (o.behind == 0) throw std::invalid_argument("occluders_with_gap: behind must be above 0");
    constexpr float width = 4, half_height = 2;
    std::vector<Triangle> out;
    const auto add = [&](glm::vec3 a, glm::vec3 b, glm::vec3 c, glm::vec3 d, Rgba8 color) {
        out.push_back({{a, b, c}, color});
        out.push_back({{a, c, d}, color});
    };
    const auto n = float(o.side_quads);
    for (const float side : {-1.0f, 1.0f}) {
        const auto x = [&](std::uint32_t i) {  // ascending, so that fronts face z
            const std::uint32_t from_gap = side > 0 ? i : o.side_quads - i;
            return side * (0.5f * o.gap + width * float(from_gap) / n);
        };
        const auto y = [&](std::uint32_t j) { return half_height * (2 * float(j) / n - 1); };
        for (std::uint32_t j = 0; j < o.side_quads; ++j) {
            for (std::uint32_t i = 0; i < o.side_quads; ++i) {
                const Rgba8 dark = (i + j) % 2 == 0 ? Rgba8{20, 26, 40, 255} : Rgba8{34, 30, 52, 255};
                add({x(i), y(j), 0}, {x(i + 1), y(j), 0}, {x(i + 1), y(j + 1), 0}, {x(i), y(j + 1), 0}, dark);
            }
        }
    }
    // A sheet that closes, and triangles before it.
    const std::size_t first_behind = out.size();
    for (std::uint32_t j = 0; j < o.side_quads; ++j) {
        for (std::uint32_t i = 0; i < o.side_quads; ++i) {
            const auto at = [&](std::uint32_t k) { return width * (2 * float(k) / n - 1); };
            add({at(i), at(j), -3}, {at(i + 1), at(j), -3}, {at(i + 1), at(j + 1), -3}, {at(i), at(j + 1), -3},
                {250, 230, 140, 255});
        }
    }
    Random random(17);
    while (out.size() < first_behind + o.behind) {
        const float px = random.between(-0.95f * width, 0.95f * width), py = random.between(-1.9f, 1.9f);
        const glm::vec3 p(px, py, random.between(-2.9f, -1.1f));
        const glm::vec3 u = random.direction() * 0.05f, v = random.direction() * 0.05f;
        const auto tint = std::uint8_t(160 + random.below(90));
        out.push_back({{p, p + u, p + v}, {255, tint, std::uint8_t(tint / 2), 255}});
    }
    return out;
}

}  // namespace farfield::scenes
