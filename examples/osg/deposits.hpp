// Stand-ins as points that cover parts of pixels: front to back into a buffer of their own, by the area law, then over
// what is in the window.
#pragma once

#include <glm/mat4x4.hpp>
#include <osg/FrameBufferObject>
#include <osg/Geometry>
#include <osg/RenderInfo>
#include <osg/Texture2D>
#include <span>
#include <vector>

#include "farfield/drawables.hpp"

namespace far_osg {

/// Whatever is in the window's depth buffer hides them, whoever drew it; they hide nothing. One context's.
class Deposits {
  public:
    Deposits();

    void clear() { deposits_.clear(); }
    /// Nearer ones first. The matrix takes them to osg's eye.
    void add(std::span<const farfield::Splat> splats, const glm::dmat4& to_eye);
    void draw(osg::RenderInfo& info);

  private:
    struct Deposit {
        osg::Vec3 place;
        osg::Vec2 size;  ///< of an upright rectangle
        float opacity;
        osg::Vec4ub rgb;
        farfield::AreaLaw law;
    };
    struct Pass {
        bool coherent;
        GLint first;
        GLsizei count;
    };
    void sort_by_law();
    void add_pass(std::size_t first, std::size_t end, bool coherent);
    void fit(int width, int height);
    void blend(osg::State& state, bool coherent) const;

    std::vector<Deposit> deposits_;
    std::vector<Pass> passes_;
    osg::ref_ptr<osg::Geometry> points_, quad_;
    osg::ref_ptr<osg::Vec4Array> places_;  ///< w: 1 for coherent ones
    osg::ref_ptr<osg::Vec3Array> sizes_;   ///< z: opacity
    osg::ref_ptr<osg::Vec4ubArray> colors_;
    osg::ref_ptr<osg::StateSet> point_state_, quad_state_;
    osg::ref_ptr<osg::Uniform> viewport_;
    osg::ref_ptr<osg::Texture2D> covered_;
    osg::ref_ptr<osg::FrameBufferObject> buffer_;
    int width_ = 0, height_ = 0;
};

}  // namespace far_osg
