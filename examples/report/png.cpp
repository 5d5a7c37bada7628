#include <cstdint>
#include <stdexcept>
#include <vector>

#include "report/picture.hpp"

#define STB_IMAGE_WRITE_IMPLEMENTATION
#define STB_IMAGE_WRITE_STATIC
#include <stb_image_write.h>

namespace farfield::report {

void write_png(const Image& image, const std::filesystem::path& file) {
    std::vector<std::uint8_t> bytes;
    bytes.reserve(3 * image.pixels().size());
    for (const Rgba8 c : image.pixels()) bytes.insert(bytes.end(), {c.r, c.g, c.b});
    if (stbi_write_png(file.string().c_str(), image.width(), image.height(), 3, bytes.data(), 3 * image.width()) == 0) {
        throw std::runtime_error("could not write " + file.string());
    }
}

}  // namespace farfield::report
