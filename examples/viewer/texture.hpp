// A picture on the GPU, for the window to show: sent there, or drawn there.
#pragma once

#include <epoxy/gl.h>

#include <utility>

#include "farfield/image.hpp"
#include "shared_picture.hpp"

namespace viewer {

class Texture {
  public:
    Texture() = default;
    ~Texture() { glDeleteTextures(1, &name_); }
    Texture(const Texture&) = delete;
    Texture& operator=(const Texture&) = delete;

    /// Either of them; none: it is empty.
    void show(const farfield::Image& image, SharedPicturePtr shared) {
        // The window may still be drawing the last one.
        before_ = std::exchange(shared_, std::move(shared));
        if (!shared_) upload(image);
    }
    bool is_empty() const { return !shared_ && (width_ == 0 || height_ == 0); }
    GLuint name() const { return shared_ ? shared_->name : name_; }

  private:
    void upload(const farfield::Image& image) {
        if (image.width() != width_ || image.height() != height_) {
            glDeleteTextures(1, &name_);
            name_ = 0;
            width_ = image.width();
            height_ = image.height();
            if (width_ == 0 || height_ == 0) return;
            glCreateTextures(GL_TEXTURE_2D, 1, &name_);
            glTextureStorage2D(name_, 1, GL_RGBA8, width_, height_);
            glTextureParameteri(name_, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
            glTextureParameteri(name_, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
            glTextureParameteri(name_, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
        }
        if (width_ != 0 && height_ != 0) {
            glTextureSubImage2D(name_, 0, 0, 0, width_, height_, GL_RGBA, GL_UNSIGNED_BYTE, image.pixels().data());
        }
    }

    SharedPicturePtr shared_, before_;
    GLuint name_ = 0;
    int width_ = 0, height_ = 0;
};

}  // namespace viewer
