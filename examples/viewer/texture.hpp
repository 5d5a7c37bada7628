// A picture on the GPU, for the window to show.
#pragma once

#include <epoxy/gl.h>

#include "farfield/image.hpp"

namespace viewer {

class Texture {
  public:
    Texture() = default;
    ~Texture() { glDeleteTextures(1, &name_); }
    Texture(const Texture&) = delete;
    Texture& operator=(const Texture&) = delete;

    void upload(const farfield::Image& image) {
        if (image.width() != width_ || image.height() != height_) {
            glDeleteTextures(1, &name_);
            name_ = 0;
            width_ = image.width();
            height_ = image.height();
            if (is_empty()) return;
            glCreateTextures(GL_TEXTURE_2D, 1, &name_);
            glTextureStorage2D(name_, 1, GL_RGBA8, width_, height_);
            glTextureParameteri(name_, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
            glTextureParameteri(name_, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
            glTextureParameteri(name_, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
        }
        if (!is_empty()) {
            glTextureSubImage2D(name_, 0, 0, 0, width_, height_, GL_RGBA, GL_UNSIGNED_BYTE, image.pixels().data());
        }
    }
    bool is_empty() const { return width_ == 0 || height_ == 0; }
    GLuint name() const { return name_; }

  private:
    GLuint name_ = 0;
    int width_ = 0, height_ = 0;
};

}  // namespace viewer
