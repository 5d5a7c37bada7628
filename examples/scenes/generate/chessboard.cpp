#include "scenes/generate/chessboard.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <vector>

namespace farfield::scenes {

std::uint32_t squares_per_side(const ChessboardOptions& options) {
    const double wanted = options.triangles / 2.0;
    const double fewer = std::floor(std::sqrt(wanted)), more = fewer + 1;
    const double nearest = wanted - fewer * fewer <= more * more - wanted ? fewer : more;
    return static_cast<std::uint32_t>(std::max(nearest, 1.0));
}

Scene chessboard(const ChessboardOptions& options) {
    if (options.triangles == 0) throw std::invalid_argument("chessboard: no triangles");
    const std::uint32_t squares = squares_per_side(options);
    if (!(options.side_m > 0) || !std::isnormal(options.side_m / static_cast<float>(squares))) {
        throw std::invalid_argument("chessboard: the side must be positive, finite, and large enough for its squares");
    }
    constexpr Rgba8 black{24, 24, 24, 255}, white{236, 236, 236, 255};
    std::vector<float> lines(squares + std::size_t{1});
    for (std::uint32_t i = 0; i <= squares; ++i) {
        lines[i] = static_cast<float>(double(options.side_m) * (double(i) / squares - 0.5));
    }
    Scene scene{"chessboard", std::vector<Group>(1)};
    auto& triangles = scene.groups[0].triangles;
    triangles.reserve(std::size_t{2} * squares * squares);
    for (std::uint32_t row = 0; row < squares; ++row) {
        for (std::uint32_t column = 0; column < squares; ++column) {
            const float x0 = lines[column], x1 = lines[column + 1], z0 = lines[row], z1 = lines[row + 1];
            const glm::vec3 a(x0, 0, z0), b(x0, 0, z1), c(x1, 0, z1), d(x1, 0, z0);
            const Rgba8 color = (row + column) % 2 == 0 ? black : white;
            triangles.push_back({{a, b, c}, {color, color, color}});
            triangles.push_back({{a, c, d}, {color, color, color}});
        }
    }
    return scene;
}

Scene chessboard(std::uint32_t triangles) {
    ChessboardOptions options;
    options.triangles = triangles;
    return chessboard(options);
}

Camera low_over_chessboard(const ChessboardOptions& options) {
    const double side = options.side_m;
    return Camera::perspective({0, side / 50, side / 2}, {0, 0, -side / 2}, {0, 1, 0}, 1.04719755f);
}

}  // namespace farfield::scenes
