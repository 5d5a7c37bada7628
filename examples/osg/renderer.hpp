// What farfield draws with in osg: near triangles from osg's own arrays, stand-ins by deposits.
#pragma once

#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/type_ptr.hpp>
#include <osg/State>

#include "deposits.hpp"
#include "farfield/renderer.hpp"
#include "farfield/renderer/keyed_order.hpp"
#include "farfield/view/view_matrix.hpp"
#include "scene.hpp"

namespace far_osg {

class Renderer {
  public:
    static constexpr farfield::RendererFacts facts{.keeps_sources = true, .draws_faces = true, .draws_splats = true};

    /// What draws the next frame, and what takes the outermost hierarchy's coordinates to osg's eye.
    void prepare(osg::RenderInfo& info, const glm::dmat4& to_eye) {
        info_ = &info;
        outermost_to_eye_ = to_eye;
    }

    std::uint32_t upload(const farfield::Source<MeshTriangle>& source) {
        Indices& indices = sources_.emplace_back(Indices{farfield::KeyedOrder(source)});
        for (const std::uint32_t at : indices.by_mesh.positions()) {
            for (const std::uint32_t corner : source[at].corners) indices.elements->push_back(corner);
        }
        indices.elements->setElementBufferObject(new osg::ElementBufferObject);
        return std::uint32_t(sources_.size() - 1);
    }
    std::uint32_t upload(const farfield::Source<Placement>&) { return 0; }  // instances are entered, not drawn
    void release(std::uint32_t) {}                                          // all goes with the renderer

    void begin_frame(const farfield::LocalView& outermost) {
        camera_to_eye_ = outermost_to_eye_ * glm::inverse(farfield::view_matrix(outermost));
        deposits_.clear();
    }
    void set_view(const farfield::LocalView& view) { to_eye_ = camera_to_eye_ * farfield::view_matrix(view); }
    void draw(const farfield::Source<Placement>&, std::span<const farfield::Range>) {}
    void draw(const farfield::Source<MeshTriangle>& source, std::span<const farfield::Range> ranges) {
        const auto& [by_mesh, elements] = sources_[source.id];
        const glm::dmat4 to_eye = glm::translate(to_eye_, -source.origin);
        osg::State& state = *info_->getState();
        by_mesh.parts_of(ranges, parts_);
        for (auto part = parts_.begin(); part != parts_.end();) {
            const Mesh& mesh = *source[by_mesh.positions()[part->first]].mesh;
            for (const auto& s : mesh.states) state.pushStateSet(s);
            state.apply();
            state.applyModelViewMatrix(mesh.to_body * osg::Matrixd(glm::value_ptr(to_eye)));
            bind(mesh, *elements);
            for (; part != parts_.end() && part->key == mesh.number; ++part) {
                glDrawElements(GL_TRIANGLES, GLsizei(3 * part->count), GL_UNSIGNED_INT,
                               reinterpret_cast<const void*>(12 * std::size_t(part->first)));  // bytes into its buffer
            }
            state.unbindVertexBufferObject();
            state.unbindElementBufferObject();
            for (std::size_t i = 0; i < mesh.states.size(); ++i) state.popStateSet();
        }
    }
    void draw(std::span<const farfield::Face>) {}  // there are none: opacity tensors are splats where those are drawn
    float largest_splat_px() const { return 64; }
    void draw(std::span<const farfield::Splat> splats) { deposits_.add(splats, to_eye_); }
    void end_frame() { deposits_.draw(*info_); }

  private:
    struct Indices {
        farfield::KeyedOrder by_mesh;
        osg::ref_ptr<osg::DrawElementsUInt> elements{new osg::DrawElementsUInt(GL_TRIANGLES)};
    };

    /// Osg binds the geometry's own arrays.
    void bind(const Mesh& mesh, osg::DrawElements& elements) {
        osg::State& state = *info_->getState();
        const bool uses_buffers = state.useVertexBufferObject(mesh.geometry->getUseVertexBufferObjects());
        state.getCurrentVertexArrayState()->setVertexBufferObjectSupported(uses_buffers);
        mesh.geometry->drawVertexArraysImplementation(*info_);
        state.bindElementBufferObject(elements.getOrCreateGLBufferObject(state.getContextID()));
    }

    osg::RenderInfo* info_ = nullptr;
    glm::dmat4 outermost_to_eye_{1}, camera_to_eye_{1}, to_eye_{1};
    std::vector<Indices> sources_;
    std::vector<farfield::KeyedPart> parts_;
    Deposits deposits_;
};

}  // namespace far_osg
