// What farfield draws with in osg: near triangles from osg's own arrays, stand-ins by deposits.
#pragma once

#include <algorithm>
#include <cstdint>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <osg/BufferObject>
#include <osg/Geometry>
#include <osg/Matrixd>
#include <osg/RenderInfo>
#include <osg/State>
#include <span>
#include <tuple>
#include <vector>

#include "deposits.hpp"
#include "farfield/renderer.hpp"
#include "mesh.hpp"
#include "scene.hpp"

namespace far_osg {

/// Keeps what a frame wants drawn, and draws it at its end: triangles mesh by mesh, then stand-ins.
class Renderer {
  public:
    static constexpr farfield::RendererFacts facts{.keeps_sources = true, .draws_faces = true, .draws_splats = true};

    /// What draws the next frame, and how its eye coordinates come from those of farfield's camera: by next to nothing,
    /// or by a scale if the drawable is placed by one.
    void prepare(osg::RenderInfo& info, const osg::Matrixd& camera_to_eye) {
        info_ = &info;
        camera_to_eye_ = camera_to_eye;
    }

    std::uint32_t upload(const farfield::Source<MeshTriangle>& source) {
        Indices& indices = sources_.emplace_back();
        indices.elements = new osg::DrawElementsUInt(GL_TRIANGLES);
        indices.elements->setElementBufferObject(new osg::ElementBufferObject);
        indices.elements->reserve(3 * std::size_t(source.item_count));
        for (std::uint32_t at = 0; at < source.item_count; ++at) {
            for (const std::uint32_t corner : source[at].corners) indices.elements->push_back(corner);
            if (at == 0 || source[at].mesh != source[at - 1].mesh) indices.changes.push_back(at);
        }
        return std::uint32_t(sources_.size() - 1);
    }
    std::uint32_t upload(const farfield::Source<Placement>&) { return 0; }  // instances are entered, not drawn
    void release(std::uint32_t) {}                                          // all goes with the renderer

    void begin_frame(const farfield::LocalView&) {
        views_.clear();
        runs_.clear();
        deposits_.clear();
    }
    void set_view(const farfield::LocalView& v) {
        const glm::dvec3 x(v.right), y(v.up), z(-v.forward), from(v.anchor);
        const osg::Matrixd to_camera(x.x, y.x, z.x, 0, x.y, y.y, z.y, 0, x.z, y.z, z.z, 0,  // as osg has it, transposed
                                     -glm::dot(x, from), -glm::dot(y, from),
                                     -glm::dot(z, from) - double(v.anchor_depth), 1);
        const double scale = double(v.scale);
        views_.push_back(to_camera * osg::Matrixd::scale(scale, scale, scale) * camera_to_eye_);
        view_scale_ = float(osg::Matrixd::transform3x3(osg::Vec3d(x.x, x.y, x.z), views_.back()).length());
    }
    void draw(const farfield::Source<Placement>&, std::span<const farfield::Range>) {}
    void draw(const farfield::Source<MeshTriangle>& source, std::span<const farfield::Range> ranges) {
        const auto view = std::uint32_t(views_.size() - 1);
        const std::vector<std::uint32_t>& changes = sources_[source.id].changes;
        for (const farfield::Range& range : ranges) {
            const std::uint32_t end = range.first + range.count;
            auto next = std::upper_bound(changes.begin(), changes.end(), range.first);
            for (std::uint32_t first = range.first, last; first < end; first = last) {
                last = next == changes.end() ? end : std::min(end, *next++);
                runs_.push_back({source.id, source[first].mesh, view, first, last - first, source.origin});
            }
        }
    }
    void draw(std::span<const farfield::Face>) {}  // there are none: opacity tensors are splats where those are drawn
    float largest_splat_px() const { return 64; }
    void draw(std::span<const farfield::Splat> splats) {
        for (const farfield::Splat& s : splats) {
            deposits_.add({osg::Vec3d(osg::Vec3(s.center.x, s.center.y, s.center.z)) * views_.back(),
                           osg::Vec2(s.size.x, s.size.y) * view_scale_, s.opacity,
                           osg::Vec4ub(s.rgb.r, s.rgb.g, s.rgb.b, 255), Deposit::Law(s.rgb.a)});
        }
    }

    void end_frame() {
        std::sort(runs_.begin(), runs_.end(), [](const Run& a, const Run& b) { return a.order() < b.order(); });
        osg::State& state = *info_->getState();
        const Mesh* mesh = nullptr;
        for (auto run = runs_.begin(); run != runs_.end();) {
            if (mesh != run->mesh) {
                leave(mesh, state);
                enter(*(mesh = run->mesh), sources_[run->source], state);
            }
            state.applyModelViewMatrix(mesh->to_body *
                                       osg::Matrixd::translate(-run->origin.x, -run->origin.y, -run->origin.z) *
                                       views_[run->view]);
            const std::uint32_t view = run->view;
            for (; run != runs_.end() && run->mesh == mesh && run->view == view; ++run) {
                glDrawElements(GL_TRIANGLES, GLsizei(3 * run->count), GL_UNSIGNED_INT,
                               reinterpret_cast<const void*>(12 * std::size_t(run->first)));  // bytes into its buffer
            }
        }
        leave(mesh, state);
        deposits_.draw(*info_);
    }

  private:
    struct Indices {
        osg::ref_ptr<osg::DrawElementsUInt> elements;
        std::vector<std::uint32_t> changes;  ///< positions where another mesh begins
    };
    struct Run {
        std::uint32_t source;
        const Mesh* mesh;
        std::uint32_t view, first, count;
        glm::dvec3 origin;
        std::tuple<std::uint32_t, std::uint32_t, std::uint32_t, std::uint32_t> order() const {
            return {source, mesh->number, view, first};
        }
    };

    /// Osg binds the geometry's own arrays, in the states it lies under.
    void enter(const Mesh& mesh, const Indices& indices, osg::State& state) {
        for (const auto& s : mesh.states) state.pushStateSet(s);
        state.apply();
        const bool uses_buffers = state.useVertexBufferObject(mesh.geometry->getUseVertexBufferObjects());
        state.getCurrentVertexArrayState()->setVertexBufferObjectSupported(uses_buffers);
        mesh.geometry->drawVertexArraysImplementation(*info_);
        state.bindElementBufferObject(indices.elements->getOrCreateGLBufferObject(state.getContextID()));
    }
    static void leave(const Mesh* mesh, osg::State& state) {
        if (mesh == nullptr) return;
        state.unbindVertexBufferObject();
        state.unbindElementBufferObject();
        for (std::size_t i = 0; i < mesh->states.size(); ++i) state.popStateSet();
    }

    osg::RenderInfo* info_ = nullptr;
    osg::Matrixd camera_to_eye_;
    std::vector<Indices> sources_;
    std::vector<osg::Matrixd> views_;
    float view_scale_ = 1;
    std::vector<Run> runs_;
    Deposits deposits_;
};

}  // namespace far_osg
