#include "farfield/sampler/texture_levels.hpp"

#include <random>
#include <stdexcept>
#include <vector>

#include "catch.hpp"

using namespace farfield;

static_assert(SomeTexture<TextureLevels>);

TEST_CASE("every level of a texture has the mean of all its texels, alpha weighing colors") {
    std::mt19937 random(3);
    for (const glm::ivec2 size : {glm::ivec2(1, 1), glm::ivec2(8, 8), glm::ivec2(7, 5), glm::ivec2(1, 13)}) {
        std::vector<Rgba8> texels;
        glm::dvec4 sum(0);
        for (int i = 0; i < size.x * size.y; ++i) {
            const auto byte = [&] { return std::uint8_t(random() % 256); };
            texels.push_back({byte(), byte(), byte(), byte()});
            const glm::dvec4 c(to_vec4(texels.back()));
            sum += glm::dvec4(glm::dvec3(c) * c.w, c.w);
        }
        const TextureLevels texture(size.x, size.y, texels);
        CHECK(texture.size(0) == size);
        CHECK(texture.size(texture.levels() - 1) == glm::ivec2(1));
        for (int level = 0; level < texture.levels(); ++level) {
            const glm::ivec2 s = texture.size(level);
            glm::dvec4 mean(0);
            for (int y = 0; y < s.y; ++y) {
                for (int x = 0; x < s.x; ++x) {
                    const glm::dvec4 c(to_vec4(texture.texel(level, x, y)));
                    mean += glm::dvec4(glm::dvec3(c) * c.w, c.w) / (double(s.x) * double(s.y));
                }
            }
            const glm::dvec4 wanted = sum / (double(size.x) * double(size.y));
            for (int channel = 0; channel < 4; ++channel) CHECK(std::abs(mean[channel] - wanted[channel]) < 0.004);
        }
    }
}

TEST_CASE("a texture repeats, and what is transparent has no say in colors") {
    const TextureLevels texture(2, 1, std::vector<Rgba8>{{200, 100, 0, 255}, {0, 0, 255, 0}});
    CHECK(texture.texel(0, -2, 5) == Rgba8{200, 100, 0, 255});
    CHECK(texture.texel(0, 3, -7) == Rgba8{0, 0, 255, 0});
    CHECK(texture.texel(1, 9, 9) == Rgba8{200, 100, 0, 128});
    const TextureLevels clear(2, 2, std::vector<Rgba8>(4, Rgba8{9, 9, 9, 0}));
    CHECK(clear.texel(1, 0, 0).a == 0);
}

TEST_CASE("no texels make no texture, and too few are refused") {
    CHECK(TextureLevels().levels() == 0);
    CHECK(TextureLevels(0, 7, {}).levels() == 0);
    CHECK_THROWS_AS(TextureLevels(2, 2, std::vector<Rgba8>(3)), std::invalid_argument);
    CHECK_THROWS_AS(TextureLevels(-1, -1, std::vector<Rgba8>(1)), std::invalid_argument);
}
