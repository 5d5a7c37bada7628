// The forest in osg, and the ways to draw it.
#pragma once

#include <osg/Geometry>
#include <osg/Group>
#include <vector>

#include "engines/forest.hpp"
#include "far_drawable.hpp"

namespace far_osg {

class Forest {
  public:
    explicit Forest(const farfield::engines::Forest& forest);

    // The same scene, to be drawn in one way each.
    osg::ref_ptr<osg::Group> plain() const;
    /// Each tree in four levels, made by osgUtil::Simplifier, the coarser ones with half of the triangles each.
    osg::ref_ptr<osg::Group> with_levels() const;
    /// Each tree an osgSim::Impostor, whose image may be off by so many pixels.
    osg::ref_ptr<osg::Group> with_impostors() const;
    /// All trees in one drawable, and ground, which osg draws as it draws all else.
    osg::ref_ptr<osg::Group> with_far_field(osg::ref_ptr<FarDrawable> trees) const;
    osg::ref_ptr<FarDrawable> far_field(float tolerance_px) const;

  private:
    /// Ground, and for each tree what tree_of(kind) gives, placed.
    template <class TreeOf>
    osg::ref_ptr<osg::Group> placed(const TreeOf& tree_of) const;

    std::vector<farfield::engines::PlacedTree> trees_;
    std::vector<osg::ref_ptr<osg::Geometry>> kinds_;
    osg::ref_ptr<osg::Geometry> ground_;
};

}  // namespace far_osg
