// What a picture is drawn into before it is made one color a pixel: samples of geometry, and lanes of the far field
// over them.
#pragma once

#include <algorithm>
#include <stdexcept>

#include "opengl/objects.hpp"

namespace farfield::opengl {

inline Texture make_texture(GLenum format, int width, int height) {
    Texture texture(GL_TEXTURE_2D);
    glTextureStorage2D(texture.name(), 1, format, width, height);
    glTextureParameteri(texture.name(), GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    glTextureParameteri(texture.name(), GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    return texture;
}

/// Textures only grow: what is larger than a picture is used in part.
class Target {
  public:
    Texture color, depth;                   ///< of samples
    Texture far_field, far_depth, nearest;  ///< of lanes; the nearest deposits' depths where an image keeps them
    Framebuffer geometry, deposits;

    void fit_geometry(int width, int height) {
        if (width <= width_ && height <= height_) return;
        width_ = std::max(width, width_);
        height_ = std::max(height, height_);
        color = make_texture(GL_RGBA8, width_, height_);
        depth = make_texture(GL_DEPTH_COMPONENT32F, width_, height_);
        attached_depth_ = 0;  // it may get the name of what goes
        geometry = make_framebuffer();
        glNamedFramebufferTexture(geometry.name(), GL_COLOR_ATTACHMENT0, color.name(), 0);
        glNamedFramebufferTexture(geometry.name(), GL_DEPTH_ATTACHMENT, depth.name(), 0);
        check(geometry);
    }
    /// Lanes that are samples are behind the samples' depths; of others they have to be copied.
    void fit_deposits(int width, int height, bool keeps_depths, bool lanes_are_samples) {
        fit_colors(width, height, keeps_depths);
        if (!lanes_are_samples && far_depth.name() == 0)
            far_depth = make_texture(GL_DEPTH_COMPONENT32F, far_width_, far_height_);
        const GLuint wanted = lanes_are_samples ? depth.name() : far_depth.name();
        if (attached_depth_ == wanted) return;
        attached_depth_ = wanted;
        glNamedFramebufferTexture(deposits.name(), GL_DEPTH_ATTACHMENT, wanted, 0);
        check(deposits);
    }

    static void check(const Framebuffer& framebuffer) {
        if (glCheckNamedFramebufferStatus(framebuffer.name(), GL_DRAW_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE)
            throw std::runtime_error("OpenGL has no picture of that size");
    }

  private:
    void fit_colors(int width, int height, bool keeps_depths) {
        if (width <= far_width_ && height <= far_height_ && (!keeps_depths || nearest.name() != 0)) return;
        far_width_ = std::max(width, far_width_);
        far_height_ = std::max(height, far_height_);
        // The area law of surfaces is cut off where a lane is full, which numbers from 0 to 1 do by themselves, and
        // 16 bits hold the small deposits that eight would lose.
        far_field = make_texture(GL_RGBA16, far_width_, far_height_);
        far_depth = {};
        attached_depth_ = 0;
        deposits = make_framebuffer();
        glNamedFramebufferTexture(deposits.name(), GL_COLOR_ATTACHMENT0, far_field.name(), 0);
        if (keeps_depths) {
            nearest = make_texture(GL_R32F, far_width_, far_height_);
            glNamedFramebufferTexture(deposits.name(), GL_COLOR_ATTACHMENT1, nearest.name(), 0);
            constexpr GLenum both[] = {GL_COLOR_ATTACHMENT0, GL_COLOR_ATTACHMENT1};
            glNamedFramebufferDrawBuffers(deposits.name(), 2, both);
        }
    }

    int width_ = 0, height_ = 0, far_width_ = 0, far_height_ = 0;
    GLuint attached_depth_ = 0;
};

}  // namespace farfield::opengl
