// The rows of a frame's views, made on the GPU.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "opengl/mirrored_buffer.hpp"
#include "opengl/objects.hpp"
#include "opengl/program.hpp"
#include "opengl/view_places.hpp"
#include "opengl/view_row.hpp"

namespace farfield::opengl {

class ViewRows {
  public:
    /// A vertex buffer of ViewRow, by number; of those alone that the frame uses.
    GLuint name() const { return rows_.name(); }

    /// Returns the bytes that were uploaded: none where neither the outermost row nor what is used has changed.
    std::size_t update(const ViewRow& outermost, const ViewPlaces& places) {
        if (places.places.empty()) return 0;
        if (program_.name() == 0) program_ = make_compute_program(text);
        if (places.places.size() > capacity_) {
            capacity_ = 2 * places.places.size();
            rows_ = make_buffer();
            glNamedBufferStorage(rows_.name(), GLsizeiptr(capacity_ * sizeof(ViewRow)), nullptr, 0);
        }
        const std::size_t bytes = outermost_.update(std::as_bytes(std::span(&outermost, 1))) +
                                  places_.update(places.places) + used_.update(places.used);
        if (bytes == 0) return 0;
        const GLuint buffers[] = {outermost_.name(), places_.name(), used_.name(), rows_.name()};
        for (GLuint i = 0; i < 4; ++i) glBindBufferBase(GL_SHADER_STORAGE_BUFFER, i, buffers[i]);
        glUseProgram(program_.name());
        const auto count = std::uint32_t(places.places.size());
        glUniform1ui(0, count);
        glDispatchCompute((count + group - 1) / group, 1, 1);
        glMemoryBarrier(GL_VERTEX_ATTRIB_ARRAY_BARRIER_BIT);
        for (GLuint i = 0; i < 4; ++i) glBindBufferBase(GL_SHADER_STORAGE_BUFFER, i, 0);
        return bytes;
    }

  private:
    static constexpr std::uint32_t group = 64;
    /// What view_row() gives of LocalView::inside().
    static constexpr const char* text = R"(#version 450 core
layout(local_size_x = 64) in;
layout(std430, binding = 0) readonly buffer Outermost { vec4 outermost[6]; };
layout(std430, binding = 1) readonly buffer Places { vec4 places[]; };
layout(std430, binding = 2) readonly buffer Used { uint used[]; };
layout(std430, binding = 3) writeonly buffer Rows { vec4 rows[]; };
layout(location = 0) uniform uint count;
void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i >= count || (used[i / 32u] >> i % 32u & 1u) == 0u) return;
    vec4 x = places[5 * i], y = places[5 * i + 1], z = places[5 * i + 2];
    vec4 anchor = outermost[0], across = outermost[1], upward = outermost[2], forward = outermost[3],
         depths = outermost[4], light = outermost[5];
    bool is_perspective = forward.w != 0;
    float scale = x.w, sides = is_perspective ? 1.0 : scale, most = uintBitsToFloat(0x7f7fffffu);
    mat3 axes = mat3(x.xyz, y.xyz, z.xyz);
    precise vec3 d = (anchor.xyz - places[5 * i + 3].xyz) - places[5 * i + 4].xyz;
    rows[6 * i] = vec4(d * axes / scale, is_perspective ? anchor.w / scale : anchor.w);
    rows[6 * i + 1] = vec4(across.xyz * axes * sides, across.w);
    rows[6 * i + 2] = vec4(upward.xyz * axes * sides, upward.w);
    rows[6 * i + 3] = vec4(forward.xyz * axes, forward.w);
    rows[6 * i + 4] = vec4(is_perspective ? depths.x / scale : depths.x, depths.y * sides,
                           clamp(depths.zw / scale, -most, most));
    rows[6 * i + 5] = vec4(light.xyz * axes, y.w);
}
)";

    Program program_;
    Buffer rows_;
    std::size_t capacity_ = 0;
    MirroredBuffer outermost_, places_, used_;
};

}  // namespace farfield::opengl
