#include "report/picture.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>

namespace farfield::report {

Image over_background(const Image& premultiplied, const Background& background) {
    Image result(premultiplied.width(), premultiplied.height());
    const auto [top, bottom] = background;
    const int last = std::max(result.height() - 1, 1);
    for (int y = 0; y < result.height(); ++y) {
        const auto between = [&](int a, int b) { return (a * (last - y) + b * y + last / 2) / last; };
        const int r = between(top.r, bottom.r), g = between(top.g, bottom.g), b = between(top.b, bottom.b);
        for (int x = 0; x < result.width(); ++x) {
            const Rgba8 c = premultiplied.at(x, y);
            const auto over = [&](int front, int back) {
                return std::uint8_t(std::min(255, front + (back * (255 - c.a) + 127) / 255));
            };
            result.at(x, y) = {over(c.r, r), over(c.g, g), over(c.b, b), 255};
        }
    }
    return result;
}

Image difference(const Image& a, const Image& b) {
    Image result(a.width(), a.height());
    const auto amplified = [](int x, int y) { return std::uint8_t(std::min(255, std::abs(x - y) * difference_gain)); };
    for (std::size_t i = 0; i < result.pixels().size(); ++i) {
        const Rgba8 p = a.pixels()[i], q = b.pixels()[i];
        result.pixels()[i] = {amplified(p.r, q.r), amplified(p.g, q.g), amplified(p.b, q.b), 255};
    }
    return result;
}

Image side_by_side(std::span<const Image> images, int gap) {
    int width = -gap;
    for (const Image& image : images) width += image.width() + gap;
    Image result(width, images.front().height(), {255, 255, 255, 255});
    int left = 0;
    for (const Image& image : images) {
        for (int y = 0; y < image.height(); ++y) {
            for (int x = 0; x < image.width(); ++x) result.at(left + x, y) = image.at(x, y);
        }
        left += image.width() + gap;
    }
    return result;
}

Image work_image(const WorkMap& map, int width, int height) {
    Image result(width, height);
    int side = 1;  // of a square: a power of 2
    while (map.columns * side < width || map.rows * side < height) side *= 2;
    for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
            const std::size_t at = std::size_t(y / side) * std::size_t(map.columns) + std::size_t(x / side);
            const float visits = map.visits[at] / float(side * side);
            const float scaled = visits > 0 ? (std::log2(visits) + 6) / 12 : 0.0f;
            const auto gray = std::uint8_t(std::clamp(scaled, 0.0f, 1.0f) * 255 + 0.5f);
            result.at(x, y) = {gray, gray, gray, 255};
        }
    }
    return result;
}

}  // namespace farfield::report
