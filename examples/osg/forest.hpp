// A forest as engines have it: a few trees, placed often, over ground; and the ways to draw it.
#pragma once

#include <memory>
#include <osg/Geometry>
#include <osg/Group>
#include <osg/Matrixd>
#include <vector>

#include "far_drawable.hpp"
#include "stage.hpp"

namespace far_osg {

struct ForestOptions {
    int trees_a_side = 16;
    unsigned triangles_a_tree = 20'000;
    int kinds = 3;
};

class Forest {
  public:
    explicit Forest(const ForestOptions& options);

    double half_extent() const { return half_extent_; }
    /// Down from above the edge to among the first trees; `along` from 0 to 1.
    Eye eye(double along) const;

    // The same scene, to be drawn in one way each.
    osg::ref_ptr<osg::Group> plain() const;
    /// Each tree in four levels, made by osgUtil::Simplifier, the coarser ones with half of the triangles each.
    osg::ref_ptr<osg::Group> with_levels() const;
    /// Each tree an osgSim::Impostor, whose image may be off by so many pixels.
    osg::ref_ptr<osg::Group> with_impostors() const;
    /// All trees in one drawable, and ground, which osg draws as it draws all else.
    osg::ref_ptr<osg::Group> with_far_field(osg::ref_ptr<FarDrawable> trees) const;
    osg::ref_ptr<FarDrawable> far_field(float tolerance_px) const;

    /// The triangles in all trees.
    std::size_t triangles() const;

  private:
    struct Tree {
        int kind;
        osg::Matrixd place;
    };
    /// Ground, and for each tree what tree_of(kind) gives, placed.
    template <class TreeOf>
    osg::ref_ptr<osg::Group> placed(const TreeOf& tree_of) const;

    double half_extent_;
    std::vector<osg::ref_ptr<osg::Geometry>> kinds_;
    std::vector<Tree> trees_;
    osg::ref_ptr<osg::Geometry> ground_;
};

}  // namespace far_osg
