#include "deposits.hpp"

#include <algorithm>
#include <glm/geometric.hpp>
#include <osg/BlendFunc>
#include <osg/Depth>
#include <osg/GLExtensions>
#include <osg/Program>
#include <osg/State>
#include <osg/Viewport>

namespace far_osg {
namespace {

constexpr const char* point_vertex = R"(#version 130
uniform vec4 viewport;
flat out vec2 middle, half_size;
flat out vec4 seen;
flat out float coherent;
void main() {
    gl_Position = gl_ProjectionMatrix * vec4(gl_Vertex.xyz, 1);
    vec2 to_pixels = 0.5 * viewport.zw / gl_Position.w;
    middle = viewport.xy + 0.5 * viewport.zw + gl_Position.xy * to_pixels;
    half_size = 0.5 * gl_MultiTexCoord0.xy * abs(vec2(gl_ProjectionMatrix[0][0], gl_ProjectionMatrix[1][1])) * to_pixels;
    gl_PointSize = 2 * max(half_size.x, half_size.y) + 1;  // all pixels that it meets, if only in part
    seen = vec4(gl_Color.rgb, gl_MultiTexCoord0.z);
    coherent = gl_Vertex.w;
}
)";

constexpr const char* point_fragment = R"(#version 130
flat in vec2 middle, half_size;
flat in vec4 seen;
flat in float coherent;
void main() {
    vec2 lower = max(gl_FragCoord.xy - 0.5, middle - half_size), upper = min(gl_FragCoord.xy + 0.5, middle + half_size);
    vec2 met = max(upper - lower, 0);
    float covered = seen.a * met.x * met.y;
    gl_FragColor = vec4(seen.rgb * (coherent > 0 ? 1 : covered), covered);
}
)";

constexpr const char* quad_vertex = R"(#version 130
void main() { gl_Position = gl_Vertex; }
)";

constexpr const char* quad_fragment = R"(#version 130
uniform sampler2D covered;
void main() { gl_FragColor = texelFetch(covered, ivec2(gl_FragCoord.xy), 0); }
)";

osg::ref_ptr<osg::Program> program(const char* vertex, const char* fragment) {
    osg::ref_ptr<osg::Program> made = new osg::Program;
    made->addShader(new osg::Shader(osg::Shader::VERTEX, vertex));
    made->addShader(new osg::Shader(osg::Shader::FRAGMENT, fragment));
    return made;
}

osg::ref_ptr<osg::Geometry> geometry() {
    osg::ref_ptr<osg::Geometry> made = new osg::Geometry;
    made->setUseDisplayList(false);
    made->setUseVertexBufferObjects(true);
    return made;
}

}  // namespace

Deposits::Deposits()
    : points_(geometry()),
      quad_(geometry()),
      places_(new osg::Vec4Array),
      sizes_(new osg::Vec3Array),
      colors_(new osg::Vec4ubArray),
      point_state_(new osg::StateSet),
      quad_state_(new osg::StateSet),
      viewport_(new osg::Uniform("viewport", osg::Vec4())),
      covered_(new osg::Texture2D) {
    colors_->setNormalize(true);
    points_->setVertexArray(places_);
    points_->setTexCoordArray(0, sizes_);
    points_->setColorArray(colors_, osg::Array::BIND_PER_VERTEX);
    point_state_->setAttributeAndModes(program(point_vertex, point_fragment));
    point_state_->addUniform(viewport_);
    point_state_->setMode(GL_VERTEX_PROGRAM_POINT_SIZE, osg::StateAttribute::ON);
    point_state_->setAttributeAndModes(new osg::Depth(osg::Depth::LESS, 0, 1, false));
    point_state_->setAttributeAndModes(new osg::BlendFunc);

    osg::ref_ptr<osg::Vec3Array> corners = new osg::Vec3Array;
    for (const osg::Vec3& corner : {osg::Vec3(-1, -1, 0), osg::Vec3(1, -1, 0), osg::Vec3(-1, 1, 0), osg::Vec3(1, 1, 0)})
        corners->push_back(corner);
    quad_->setVertexArray(corners);
    quad_->addPrimitiveSet(new osg::DrawArrays(GL_TRIANGLE_STRIP, 0, 4));
    quad_state_->setAttributeAndModes(program(quad_vertex, quad_fragment));
    quad_state_->addUniform(new osg::Uniform("covered", 0));
    quad_state_->setTextureAttribute(0, covered_);
    quad_state_->setMode(GL_DEPTH_TEST, osg::StateAttribute::OFF);
    quad_state_->setMode(GL_CULL_FACE, osg::StateAttribute::OFF);
    quad_state_->setAttributeAndModes(new osg::BlendFunc(GL_ONE, GL_ONE_MINUS_SRC_ALPHA));

    // The area law's limit, a pixel that is full, is where numbers from 0 to 1 end; 16 bits hold small deposits.
    covered_->setInternalFormat(GL_RGBA16);
    covered_->setSourceFormat(GL_RGBA);
    covered_->setSourceType(GL_UNSIGNED_SHORT);
    covered_->setFilter(osg::Texture::MIN_FILTER, osg::Texture::NEAREST);
    covered_->setFilter(osg::Texture::MAG_FILTER, osg::Texture::NEAREST);
    covered_->setResizeNonPowerOfTwoHint(false);
}

void Deposits::add(std::span<const farfield::Splat> splats, const glm::dmat4& to_eye) {
    const auto scale = float(glm::length(to_eye[0]));
    for (const farfield::Splat& s : splats) {
        const glm::vec3 place(to_eye * glm::dvec4(s.center, 1));
        deposits_.push_back({{place.x, place.y, place.z},
                             osg::Vec2(s.size.x, s.size.y) * scale,
                             s.opacity,
                             {s.rgb.r, s.rgb.g, s.rgb.b, 255},
                             farfield::AreaLaw(s.rgb.a)});
    }
}

void Deposits::fit(int width, int height) {
    if (width == width_ && height == height_) return;
    width_ = width;
    height_ = height;
    covered_->setTextureSize(width, height);
    covered_->dirtyTextureObject();
    buffer_ = new osg::FrameBufferObject;
    buffer_->setAttachment(osg::Camera::COLOR_BUFFER, osg::FrameBufferAttachment(covered_));
    buffer_->setAttachment(osg::Camera::PACKED_DEPTH_STENCIL_BUFFER,
                           osg::FrameBufferAttachment(new osg::RenderBuffer(width, height, GL_DEPTH24_STENCIL8_EXT)));
}

void Deposits::add_pass(std::size_t first, std::size_t end, bool coherent) {
    const std::size_t begin = places_->size();
    for (std::size_t i = first; i < end; ++i) {
        const Deposit& d = deposits_[i];
        if (d.law == (coherent ? farfield::AreaLaw::independent : farfield::AreaLaw::coherent)) continue;
        places_->push_back(osg::Vec4(d.place, coherent ? 1 : 0));
        sizes_->push_back(osg::Vec3(d.size, d.law == farfield::AreaLaw::mixed ? 0.5f * d.opacity : d.opacity));
        colors_->push_back(d.rgb);
    }
    const auto count = GLsizei(places_->size() - begin);
    if (!passes_.empty() && passes_.back().coherent == coherent) {
        passes_.back().count += count;
    } else if (count != 0) {
        passes_.push_back({coherent, GLint(begin), count});
    }
}

/// Each law is a state of blending, so what comes front to back is cut into slabs, and in each what is strewn comes
/// before what is surface.
void Deposits::sort_by_law() {
    constexpr std::size_t most_slabs = 256;
    passes_.clear();
    places_->clear();
    sizes_->clear();
    colors_->clear();
    const std::size_t step = std::max<std::size_t>(64, (deposits_.size() + most_slabs - 1) / most_slabs);
    for (std::size_t first = 0; first < deposits_.size(); first += step) {
        const std::size_t end = std::min(first + step, deposits_.size());
        add_pass(first, end, false);
        add_pass(first, end, true);
    }
    places_->dirty();
    sizes_->dirty();
    colors_->dirty();
}

void Deposits::draw(osg::RenderInfo& info) {
    if (deposits_.empty()) return;
    sort_by_law();
    osg::State& state = *info.getState();
    const osg::GLExtensions& gl = *state.get<osg::GLExtensions>();
    const osg::Viewport& viewport = *state.getCurrentViewport();
    viewport_->set(
        osg::Vec4(float(viewport.x()), float(viewport.y()), float(viewport.width()), float(viewport.height())));
    fit(int(viewport.x() + viewport.width()), int(viewport.y() + viewport.height()));

    GLint window = 0;
    glGetIntegerv(GL_DRAW_FRAMEBUFFER_BINDING_EXT, &window);
    state.pushStateSet(point_state_);
    state.apply();
    buffer_->apply(state);
    glClearColor(0, 0, 0, 0);
    glClear(GL_COLOR_BUFFER_BIT);
    gl.glBindFramebuffer(GL_READ_FRAMEBUFFER_EXT, GLuint(window));
    gl.glBlitFramebuffer(0, 0, width_, height_, 0, 0, width_, height_, GL_DEPTH_BUFFER_BIT, GL_NEAREST);
    points_->drawVertexArraysImplementation(info);
    for (const Pass& pass : passes_) {
        if (pass.coherent) {
            glBlendFunc(GL_SRC_ALPHA_SATURATE, GL_ONE);
        } else {
            glBlendFunc(GL_ONE_MINUS_DST_ALPHA, GL_ONE);
        }
        glDrawArrays(GL_POINTS, pass.first, pass.count);
    }
    state.haveAppliedAttribute(osg::StateAttribute::BLENDFUNC);
    state.popStateSet();

    gl.glBindFramebuffer(GL_FRAMEBUFFER_EXT, GLuint(window));
    state.pushStateSet(quad_state_);
    state.apply();
    quad_->drawImplementation(info);
    state.popStateSet();
}

}  // namespace far_osg
