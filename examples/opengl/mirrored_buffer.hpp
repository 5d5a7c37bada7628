// A buffer whose contents are known here too, so that only what changed is uploaded.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <span>
#include <vector>

#include "opengl/objects.hpp"

namespace farfield::opengl {

class MirroredBuffer {
  public:
    GLuint name() const { return buffer_.name(); }

    /// Makes the buffer begin with `contents`. Returns the bytes that were uploaded: blocks that differ from what lay
    /// there, none if all is as it was.
    std::size_t update(std::span<const std::byte> contents) {
        if (contents.empty()) return 0;
        if (contents.size() > mirror_.size()) {
            buffer_ = make_buffer();
            mirror_.assign(std::max(contents.size(), 2 * mirror_.size()), std::byte{});
            valid_ = 0;
            glNamedBufferData(buffer_.name(), GLsizeiptr(mirror_.size()), nullptr, GL_DYNAMIC_DRAW);
        }
        std::size_t uploaded = 0, first = 0;
        const auto upload = [&](std::size_t end) {
            if (first == end) return;
            glNamedBufferSubData(buffer_.name(), GLintptr(first), GLsizeiptr(end - first), contents.data() + first);
            uploaded += end - first;
        };
        for (std::size_t at = 0; at < contents.size(); at += block) {
            const std::size_t end = std::min(at + block, contents.size());
            if (end > valid_ || std::memcmp(contents.data() + at, mirror_.data() + at, end - at) != 0) {
                std::memcpy(mirror_.data() + at, contents.data() + at, end - at);
            } else {
                upload(at);
                first = end;
            }
        }
        upload(contents.size());
        valid_ = std::max(valid_, contents.size());
        return uploaded;
    }

    template <class T>
    std::size_t update(const std::vector<T>& contents) {
        return update(std::as_bytes(std::span<const T>(contents)));
    }

  private:
    static constexpr std::size_t block = 512;

    Buffer buffer_;
    std::vector<std::byte> mirror_;
    std::size_t valid_ = 0;  ///< bytes of the mirror that the buffer has
};

}  // namespace farfield::opengl
