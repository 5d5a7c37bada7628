// Stand-ins as points that cover parts of pixels: front to back into a buffer of their own, by the area law, then over
// what is in the window.
#pragma once

#include <algorithm>
#include <cstdint>
#include <osg/FrameBufferObject>
#include <osg/Geometry>
#include <osg/RenderInfo>
#include <osg/Texture2D>
#include <vector>

namespace far_osg {

/// Something of this opacity over an upright rectangle, in osg's eye coordinates.
struct Deposit {
    osg::Vec3 place;
    osg::Vec2 size;
    float opacity;
    osg::Vec4ub rgb;
    enum class Law : std::uint8_t { independent, mixed, coherent } law;
};

/// Whatever is in the window's depth buffer hides them, whoever drew it; they hide nothing. One context's.
class Deposits {
  public:
    Deposits();

    void clear() { deposits_.clear(); }
    /// Nearer ones first.
    void add(const Deposit& deposit) { deposits_.push_back(deposit); }
    void draw(osg::RenderInfo& info);

  private:
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
