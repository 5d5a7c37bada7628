// Images that a renderer keeps as textures: colors, and depths relative to the rectangle that shows them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "opengl/objects.hpp"
#include "opengl/target.hpp"

namespace farfield::opengl {

struct KeptImage {
    Texture color, depth;
    Framebuffer framebuffer;
    int width = 0, height = 0;              ///< of the image
    int whole_width = 0, whole_height = 0;  ///< of the textures
    bool is_solid = true;                   ///< texels are covered or not, none in part
    bool is_used = false;
};

/// Textures of images that were freed are used again, for images of about their size.
class KeptImages {
  public:
    const KeptImage& operator[](std::uint32_t handle) const { return images_[handle - 1]; }

    std::uint32_t make(int width, int height, bool is_solid) {
        const int whole_width = rounded_up(width), whole_height = rounded_up(height);
        std::size_t slot = images_.size(), empty = slot;
        for (std::size_t i = 0; i < images_.size(); ++i) {
            if (images_[i].is_used) continue;
            if (images_[i].whole_width == whole_width && images_[i].whole_height == whole_height) slot = i;
            if (images_[i].whole_width == 0) empty = i;
        }
        if (slot == images_.size()) {
            slot = empty;
            if (slot == images_.size()) images_.emplace_back();
            images_[slot] = fresh(whole_width, whole_height);
        }
        KeptImage& image = images_[slot];
        image.width = width;
        image.height = height;
        image.is_solid = is_solid;
        image.is_used = true;
        return std::uint32_t(slot + 1);
    }
    /// A few that are free stay.
    void free(std::uint32_t handle) {
        images_[handle - 1].is_used = false;
        std::size_t free_ones = 0;
        for (const KeptImage& image : images_) free_ones += !image.is_used && image.whole_width != 0;
        if (free_ones > most_free) images_[handle - 1] = {};
    }

    static std::size_t bytes(int width, int height) {
        return std::size_t(rounded_up(width)) * std::size_t(rounded_up(height)) * 8;
    }

  private:
    static constexpr std::size_t most_free = 16;
    static int rounded_up(int size) { return (size + 63) / 64 * 64; }

    static KeptImage fresh(int width, int height) {
        KeptImage image;
        image.color = make_texture(GL_RGBA8, width, height);
        image.depth = make_texture(GL_R32F, width, height);
        image.framebuffer = make_framebuffer();
        glNamedFramebufferTexture(image.framebuffer.name(), GL_COLOR_ATTACHMENT0, image.color.name(), 0);
        glNamedFramebufferTexture(image.framebuffer.name(), GL_COLOR_ATTACHMENT1, image.depth.name(), 0);
        constexpr GLenum both[] = {GL_COLOR_ATTACHMENT0, GL_COLOR_ATTACHMENT1};
        glNamedFramebufferDrawBuffers(image.framebuffer.name(), 2, both);
        Target::check(image.framebuffer);
        image.whole_width = width;
        image.whole_height = height;
        return image;
    }

    std::vector<KeptImage> images_;
};

}  // namespace farfield::opengl
