#include "scenes/load/texture.hpp"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <memory>
#include <optional>

// Private to this file, so that a program may have an stb_image of its own.
#define STB_IMAGE_STATIC
#define STB_IMAGE_IMPLEMENTATION
#define STBI_NO_STDIO
#define STBI_ONLY_PNG
#define STBI_ONLY_JPEG
#define STBI_ONLY_TGA
#define STBI_ONLY_BMP
#include <stb_image.h>

namespace farfield::scenes::detail {
namespace {

int texel_index(float t, int size, Wrap wrap) {
    float within = t - std::floor(t);
    if (wrap == Wrap::clamp) within = std::min(std::max(t, 0.0f), 1.0f);
    if (wrap == Wrap::mirror && std::fmod(std::floor(t), 2.0f) != 0.0f) within = 1.0f - within;
    // Comparisons let no NaN through.
    return within > 0.0f ? std::min(static_cast<int>(within * static_cast<float>(size)), size - 1) : 0;
}

/// Twice the signed area of a triangle; positive if counter-clockwise.
double turn(glm::dvec2 a, glm::dvec2 b, glm::dvec2 c) {
    return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

/// The means of channels as displayed, as the renderers' pixels are means of samples. Looks at no more than 64 by 64
/// texels, evenly spread, so that neither large images nor many repetitions cost more.
class Mean {
  public:
    explicit Mean(const Texture& texture) : texture_(texture) {}

    /// Of the texels that are seen with their centers in the triangle. None if there are none, or if it covers more of
    /// either axis than the image does.
    std::optional<Rgba8> of_triangle(const std::array<glm::vec2, 3>& uv) const {
        const glm::dvec2 size(texture_.image->width, texture_.image->height);
        std::array<glm::dvec2, 3> corners;
        for (std::size_t k = 0; k < 3; ++k) corners[k] = glm::dvec2(uv[k]) * size;
        const double area = turn(corners[0], corners[1], corners[2]);
        const glm::dvec2 lower = floor_of(glm::min(corners[0], glm::min(corners[1], corners[2])));
        const glm::dvec2 upper = floor_of(glm::max(corners[0], glm::max(corners[1], corners[2]))) + 1.0;
        if (!(upper.x - lower.x <= size.x + 1.0 && upper.y - lower.y <= size.y + 1.0) || area == 0) return {};
        const double sign = area < 0 ? -1.0 : 1.0;
        return of(lower, upper, [&](glm::dvec2 p) {
            return sign * turn(corners[0], corners[1], p) >= 0 && sign * turn(corners[1], corners[2], p) >= 0 &&
                   sign * turn(corners[2], corners[0], p) >= 0;
        });
    }

    std::optional<Rgba8> of_image() const {
        return of(glm::dvec2(0), {texture_.image->width, texture_.image->height}, [](glm::dvec2) { return true; });
    }

  private:
    static glm::dvec2 floor_of(glm::dvec2 p) { return {std::floor(p.x), std::floor(p.y)}; }

    /// `lower` and `upper` in texels, whole.
    template <class Inside>
    std::optional<Rgba8> of(glm::dvec2 lower, glm::dvec2 upper, const Inside& inside) const {
        constexpr double most = 64;
        const glm::dvec2 size(texture_.image->width, texture_.image->height), extent = upper - lower;
        const int across = static_cast<int>(std::min(extent.x, most)), up = static_cast<int>(std::min(extent.y, most));
        std::array<std::uint32_t, 4> sum{};
        std::uint32_t seen = 0;
        for (int j = 0; j < up; ++j) {
            for (int i = 0; i < across; ++i) {
                const glm::dvec2 p = floor_of(lower + extent * glm::dvec2((i + 0.5) / across, (j + 0.5) / up)) + 0.5;
                if (!inside(p)) continue;
                const Rgba8 texel = texture_.at(glm::vec2(p / size));
                if (texel.a < texture_.least_alpha) continue;
                sum[0] += texel.r;
                sum[1] += texel.g;
                sum[2] += texel.b;
                sum[3] += texel.a;
                ++seen;
            }
        }
        if (seen == 0) return {};
        const auto mean = [&](std::size_t k) { return static_cast<std::uint8_t>((sum[k] + seen / 2) / seen); };
        return Rgba8{mean(0), mean(1), mean(2), mean(3)};
    }

    const Texture& texture_;
};

}  // namespace

Image decoded(std::string_view bytes) {
    Image image;
    int width = 0, height = 0, channels = 0;
    if (bytes.empty() || bytes.size() > 0x7fffffff) return image;
    const auto* data = reinterpret_cast<const stbi_uc*>(bytes.data());
    const int size = static_cast<int>(bytes.size());
    if (!stbi_info_from_memory(data, size, &width, &height, &channels)) return image;
    if (std::int64_t{width} * height > (std::int64_t{1} << 26)) return image;
    const std::unique_ptr<stbi_uc, void (*)(void*)> texels(
        stbi_load_from_memory(data, size, &width, &height, &channels, 4), stbi_image_free);
    if (!texels || width <= 0 || height <= 0) return image;
    image = {width, height, {}};
    const std::size_t count = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
    image.texels.reserve(count);
    for (std::size_t i = 0; i < count; ++i) {
        const stbi_uc* t = texels.get() + 4 * i;
        image.texels.push_back({t[0], t[1], t[2], t[3]});
    }
    return image;
}

Rgba8 Texture::at(glm::vec2 uv) const {
    const int x = texel_index(uv.x, image->width, across);
    const int y = image->height - 1 - texel_index(uv.y, image->height, up);
    return image
        ->texels[static_cast<std::size_t>(y) * static_cast<std::size_t>(image->width) + static_cast<std::size_t>(x)];
}

std::array<Rgba8, 3> Texture::corners(const std::array<glm::vec2, 3>& uv) const {
    const glm::vec2 middle = (uv[0] + uv[1] + uv[2]) * (1.0f / 3.0f);
    std::array<Rgba8, 3> result{};
    std::optional<Rgba8> mean;
    for (std::size_t k = 0; k < 3; ++k) {
        Rgba8 texel = at(uv[k] * 0.9f + middle * 0.1f);
        for (float way = 0.2f; texel.a < least_alpha && way < 1.0f; way += 0.2f) {
            texel = at(uv[k] * (1.0f - way) + middle * way);
        }
        if (texel.a < least_alpha) {
            if (!mean) mean = Mean(*this).of_triangle(uv);
            if (!mean) mean = Mean(*this).of_image();
            if (!mean) mean = Rgba8{255, 255, 255};
            texel = *mean;
        }
        result[k] = texel;
    }
    return result;
}

}  // namespace farfield::scenes::detail
