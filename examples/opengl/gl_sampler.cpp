#include "opengl/gl_sampler.hpp"

#include <algorithm>
#include <cstring>
#include <glm/geometric.hpp>
#include <stdexcept>
#include <string>

#include "opengl/context.hpp"
#include "opengl/program.hpp"
#include "opengl/target.hpp"

namespace farfield::opengl {
namespace {

// An instance is a slab seen from a side: n x n texels, one above the other in the order of a SampleGrid. Within the
// box places run from 0 to 1 along each axis; in a box without extent all that lies in it is at 0.
constexpr const char* vertex_text = R"(#version 450 core
layout(location = 0) in vec3 place;
layout(location = 1) in vec4 front;
layout(location = 2) in vec4 back;
layout(location = 0) uniform vec3 lower;
layout(location = 1) uniform vec3 upper;
layout(location = 2) uniform uint slabs;
noperspective out vec4 front_color;
noperspective out vec4 back_color;
noperspective out float along;
flat out uint slab;
float part(int axis) {
    float extent = upper[axis] - lower[axis], p = place[axis] - lower[axis];
    return extent > 0 ? p / extent : p < 0 ? -1 : place[axis] > upper[axis] ? 2 : 0;
}
void main() {
    uint side = uint(gl_InstanceID) / slabs;
    slab = uint(gl_InstanceID) % slabs;
    int a = int(side / 2), u = (a + 1) % 3, v = (a + 2) % 3;
    bool looks_up = side % 2 == 0;  // from below along the axis
    along = part(a);
    gl_Position = vec4(2 * part(u) - 1, 2 * (float(gl_InstanceID) + part(v)) / float(6 * slabs) - 1,
                       looks_up ? along - 0.5 : 0.5 - along, 1);  // what is farthest is nearer than nothing
    gl_ClipDistance[0] = part(v);
    gl_ClipDistance[1] = 1 - part(v);
    gl_ClipDistance[2] = along;
    gl_ClipDistance[3] = 1 - along;
    front_color = looks_up ? back : front;  // of what is counter-clockwise about the axis
    back_color = looks_up ? front : back;
}
)";
constexpr const char* fragment_text = R"(#version 450 core
layout(location = 2) uniform uint slabs;
noperspective in vec4 front_color;
noperspective in vec4 back_color;
noperspective in float along;
flat in uint slab;
layout(location = 0) out vec4 color;
void main() {
    if (uint(clamp(along * float(slabs), 0, float(slabs) - 1)) != slab) discard;
    color = gl_FrontFacing ? front_color : back_color;
    if (color.a == 0) discard;
}
)";

constexpr GLenum planes[] = {GL_CLIP_DISTANCE0, GL_CLIP_DISTANCE1, GL_CLIP_DISTANCE2, GL_CLIP_DISTANCE3};

}  // namespace

struct GlSampler::Objects {
    Program program = make_program(vertex_text, fragment_text);
    VertexArray layout = make_vertex_array();
    Buffer corners = make_buffer();
    std::size_t room = 0;  ///< bytes in `corners`
    Texture color, depth;
    Framebuffer target;
    int width = 0, height = 0, largest = 0;

    Objects() {
        glGetIntegerv(GL_MAX_TEXTURE_SIZE, &largest);
        const GLuint array = layout.name();
        glVertexArrayVertexBuffer(array, 0, corners.name(), 0, sizeof(Corner));
        for (const GLuint i : {0u, 1u, 2u}) {
            glEnableVertexArrayAttrib(array, i);
            glVertexArrayAttribBinding(array, i, 0);
        }
        glVertexArrayAttribFormat(array, 0, 3, GL_FLOAT, GL_FALSE, offsetof(Corner, place));
        glVertexArrayAttribFormat(array, 1, 4, GL_UNSIGNED_BYTE, GL_TRUE, offsetof(Corner, front));
        glVertexArrayAttribFormat(array, 2, 4, GL_UNSIGNED_BYTE, GL_TRUE, offsetof(Corner, back));
    }

    /// The picture has just this size, so that its rows follow one another when they are read.
    void fit(int w, int h) {
        if (w == width && h == height) return;
        if (w > largest || h > largest) {
            throw std::runtime_error(
                "GlSampler: " + std::to_string(h) +
                " samples in a column are more than a texture has here: " + std::to_string(largest));
        }
        width = w;
        height = h;
        color = make_texture(GL_RGBA8, w, h);
        depth = make_texture(GL_DEPTH_COMPONENT32F, w, h);
        target = make_framebuffer();
        glNamedFramebufferTexture(target.name(), GL_COLOR_ATTACHMENT0, color.name(), 0);
        glNamedFramebufferTexture(target.name(), GL_DEPTH_ATTACHMENT, depth.name(), 0);
        Target::check(target);
    }
    void send(std::span<const Corner> all) {
        if (all.size_bytes() > room) {
            room = std::max(all.size_bytes(), 2 * room);
            glNamedBufferData(corners.name(), GLsizeiptr(room), nullptr, GL_STREAM_DRAW);
        }
        glNamedBufferSubData(corners.name(), 0, GLsizeiptr(all.size_bytes()), all.data());
    }
};

GlSampler::GlSampler(std::optional<DirectionalLight> l) : light(l) {
    require_opengl();
    objects_ = std::make_shared<Objects>();
}

void GlSampler::add(const Polygon& polygon) {
    const bool one_color = polygon.colors.size() < polygon.vertices.size();
    for (std::size_t i = 2; i < polygon.vertices.size(); ++i) {
        const std::size_t corners[3] = {0, i - 1, i};
        const glm::vec3 a = polygon.vertices[0];
        const glm::vec3 normal = normal_to(polygon.vertices[i - 1] - a, polygon.vertices[i] - a);
        const float front = brightness(polygon, normal), back = brightness(polygon, -normal);
        for (const std::size_t c : corners) {
            const Rgba8 color = polygon.colors[one_color ? 0 : c];
            corners_.push_back(
                {polygon.vertices[c], premultiplied(scaled(color, front)), premultiplied(scaled(color, back))});
        }
    }
}

void GlSampler::draw(const SampleGrid& grid, std::span<Rgba8> out) {
    if (corners_.empty()) {
        std::fill(out.begin(), out.end(), Rgba8{0, 0, 0, 0});
        return;
    }
    Objects& o = *objects_;
    const auto instances = GLsizei(6 * grid.slabs);
    o.fit(int(grid.n), int(grid.n) * instances);
    o.send(corners_);
    const GLuint target = o.target.name();
    glBindFramebuffer(GL_FRAMEBUFFER, target);
    glViewport(0, 0, o.width, o.height);
    constexpr float nothing[4] = {0, 0, 0, 0}, farthest = 1;
    glDisable(GL_SCISSOR_TEST);
    glClearNamedFramebufferfv(target, GL_COLOR, 0, nothing);
    glClearNamedFramebufferfv(target, GL_DEPTH, 0, &farthest);
    glEnable(GL_DEPTH_TEST);
    glDepthFunc(GL_LESS);  // of two at one depth the first
    glDisable(GL_BLEND);
    glDisable(GL_CULL_FACE);
    for (const GLenum plane : planes) glEnable(plane);
    glUseProgram(o.program.name());
    glUniform3fv(0, 1, &grid.box.lower.x);
    glUniform3fv(1, 1, &grid.box.upper.x);
    glUniform1ui(2, grid.slabs);
    glBindVertexArray(o.layout.name());
    glDrawArraysInstanced(GL_TRIANGLES, 0, GLsizei(corners_.size()), instances);
    glPixelStorei(GL_PACK_ALIGNMENT, 4);
    glReadPixels(0, 0, o.width, o.height, GL_RGBA, GL_UNSIGNED_BYTE, out.data());
    glBindVertexArray(0);
    glUseProgram(0);
    for (const GLenum plane : planes) glDisable(plane);
    glDisable(GL_DEPTH_TEST);
    glBindFramebuffer(GL_FRAMEBUFFER, 0);
}

}  // namespace farfield::opengl
