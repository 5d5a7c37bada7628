// What farfield draws with in Ogre: near triangles as ranges of the meshes' own vertices, in their own materials;
// stand-ins as points. It draws nothing itself, and knows no OpenGL: Ogre gets pieces for its queue.
#pragma once

#include <OgreHardwareBufferManager.h>
#include <OgreRenderQueue.h>

#include <deque>
#include <glm/gtc/matrix_transform.hpp>
#include <vector>

#include "farfield/renderer.hpp"
#include "farfield/view/view_matrix.hpp"
#include "piece.hpp"
#include "points.hpp"
#include "scene.hpp"

namespace far_ogre {

class Renderer {
  public:
    static constexpr farfield::RendererFacts facts{.keeps_sources = true, .draws_faces = true, .draws_splats = true};

    /// What takes the outermost hierarchy's coordinates to the eye, in the next frame.
    void prepare(const glm::dmat4& to_eye) { outermost_to_eye_ = to_eye; }
    /// What the last frame draws.
    void add_to(Ogre::RenderQueue& queue) {
        for (std::size_t i = 0; i < used_; ++i) queue.addRenderable(&pieces_[i]);
        if (Ogre::Renderable* points = points_.piece()) queue.addRenderable(points);
    }

    /// A part's indices in the order of its hierarchy.
    std::uint32_t upload(const farfield::Source<Triangle>& source) {
        std::vector<std::uint32_t> corners;
        for (std::uint32_t at = 0; at < source.item_count; ++at) {
            const auto of_triangle = source.primitives.data()->corners(source.index_of(at));
            corners.insert(corners.end(), of_triangle.begin(), of_triangle.end());
        }
        indices_.push_back(Ogre::HardwareBufferManager::getSingleton().createIndexBuffer(
            Ogre::HardwareIndexBuffer::IT_32BIT, corners.size(), Ogre::HBU_GPU_ONLY));
        indices_.back()->writeData(0, 4 * corners.size(), corners.data(), true);
        return std::uint32_t(indices_.size() - 1);
    }
    std::uint32_t upload(const farfield::Source<Placement>&) { return 0; }  // instances are entered, not drawn
    void release(std::uint32_t) {}                                          // all goes with the renderer

    void begin_frame(const farfield::LocalView& outermost) {
        camera_to_eye_ = outermost_to_eye_ * glm::inverse(farfield::view_matrix(outermost));
        used_ = 0;
        points_.clear();
    }
    void set_view(const farfield::LocalView& view) { to_eye_ = camera_to_eye_ * farfield::view_matrix(view); }
    void draw(const farfield::Source<Placement>&, std::span<const farfield::Range>) {}
    void draw(const farfield::Source<Triangle>& source, std::span<const farfield::Range> ranges) {
        const Part& part = *source.primitives.data();
        const glm::dmat4 to_eye = glm::translate(to_eye_, -source.origin) * part.to_body;
        for (const farfield::Range& range : ranges) {
            if (used_ == pieces_.size()) pieces_.emplace_back();
            Piece& piece = pieces_[used_++];
            piece.material = part.material;
            piece.place(to_eye);
            piece.operation.vertexData = part.vertex_data;
            piece.operation.indexData = &piece.indices;
            piece.indices.indexBuffer = indices_[source.id];
            piece.indices.indexStart = 3 * std::size_t(range.first);
            piece.indices.indexCount = 3 * std::size_t(range.count);
        }
    }
    void draw(std::span<const farfield::Face>) {}  // there are none: opacity tensors are splats where those are drawn
    float largest_splat_px() const { return 64; }
    void draw(std::span<const farfield::Splat> splats) { points_.add(splats, to_eye_); }
    void end_frame() {}

  private:
    glm::dmat4 outermost_to_eye_{1}, camera_to_eye_{1}, to_eye_{1};
    std::vector<Ogre::HardwareIndexBufferSharedPtr> indices_;
    std::deque<Piece> pieces_;
    std::size_t used_ = 0;
    Points points_;
};

}  // namespace far_ogre
