#include "forest.hpp"

#include <osg/LOD>
#include <osg/MatrixTransform>
#include <osgSim/Impostor>
#include <osgUtil/Simplifier>

namespace far_osg {
namespace {

void draws_from_buffers(osg::Geometry& geometry) {
    geometry.setUseDisplayList(false);
    geometry.setUseVertexBufferObjects(false);  // so that new arrays get buffers, too
    geometry.setUseVertexBufferObjects(true);
}

osg::ref_ptr<osg::Geometry> geometry_of(const farfield::engines::Mesh& mesh) {
    osg::ref_ptr<osg::Vec3Array> vertices = new osg::Vec3Array;
    for (const glm::vec3& p : mesh.vertices) vertices->push_back({p.x, p.y, p.z});
    osg::ref_ptr<osg::Vec4ubArray> colors = new osg::Vec4ubArray;
    for (const farfield::Rgba8& c : mesh.colors) colors->push_back({c.r, c.g, c.b, c.a});
    colors->setNormalize(true);
    osg::ref_ptr<osg::Geometry> geometry = new osg::Geometry;
    geometry->setVertexArray(vertices);
    geometry->setColorArray(colors, osg::Array::BIND_PER_VERTEX);
    geometry->addPrimitiveSet(new osg::DrawElementsUInt(GL_TRIANGLES, mesh.corners.begin(), mesh.corners.end()));
    draws_from_buffers(*geometry);
    return geometry;
}

}  // namespace

Forest::Forest(const farfield::engines::Forest& forest) : trees_(forest.trees), ground_(geometry_of(forest.ground)) {
    for (const farfield::engines::Mesh& tree : forest.kinds) kinds_.push_back(geometry_of(tree));
}

template <class TreeOf>
osg::ref_ptr<osg::Group> Forest::placed(const TreeOf& tree_of) const {
    osg::ref_ptr<osg::Group> root = new osg::Group;
    root->addChild(ground_);
    for (const farfield::engines::PlacedTree& tree : trees_) {
        osg::ref_ptr<osg::MatrixTransform> place =
            new osg::MatrixTransform(osg::Matrixd::scale(tree.size, tree.size, tree.size) *
                                     osg::Matrixd::rotate(tree.turn, osg::Vec3d(0, 1, 0)) *
                                     osg::Matrixd::translate(tree.at.x, tree.at.y, tree.at.z));
        place->addChild(tree_of(tree.kind));
        root->addChild(place);
    }
    return root;
}

osg::ref_ptr<osg::Group> Forest::plain() const {
    return placed([&](std::size_t kind) { return kinds_[kind]; });
}

osg::ref_ptr<osg::Group> Forest::with_levels() const {
    std::vector<osg::ref_ptr<osg::LOD>> levels;
    for (const auto& tree : kinds_) {
        osg::ref_ptr<osg::LOD> lod = levels.emplace_back(new osg::LOD);
        lod->setRangeMode(osg::LOD::PIXEL_SIZE_ON_SCREEN);
        float ratio = 1, largest_px = 1e9f;
        for (const float least_px : {200.0f, 100.0f, 50.0f, 0.0f}) {
            osg::ref_ptr<osg::Geometry> level = osg::clone(tree.get(), osg::CopyOp::DEEP_COPY_ALL);
            if (ratio < 1) {
                osgUtil::Simplifier simplifier{double(ratio)};
                simplifier.setDoTriStrip(false);
                simplifier.setSmoothing(false);
                simplifier.simplify(*level);
                draws_from_buffers(*level);
            }
            lod->addChild(level, least_px, largest_px);
            largest_px = least_px;
            ratio *= 0.5f;
        }
    }
    return placed([&](std::size_t kind) { return levels[kind]; });
}

osg::ref_ptr<osg::Group> Forest::with_impostors() const {
    return placed([&](std::size_t kind) {
        osg::ref_ptr<osgSim::Impostor> impostor = new osgSim::Impostor;
        impostor->addChild(kinds_[kind], 0, 1e7f);
        impostor->setImpostorThreshold(float(3 * farfield::engines::Forest::height_m));
        return impostor;
    });
}

osg::ref_ptr<osg::Group> Forest::with_far_field(osg::ref_ptr<FarDrawable> trees) const {
    osg::ref_ptr<osg::Group> root = new osg::Group;
    root->addChild(ground_);
    root->addChild(trees);
    return root;
}

osg::ref_ptr<FarDrawable> Forest::far_field(float tolerance_px) const {
    const osg::ref_ptr<osg::Group> trees = plain();
    trees->removeChild(ground_);
    osg::ref_ptr<FarDrawable> drawable = new FarDrawable(std::make_shared<Scene>(*trees));
    drawable->tolerance_px = tolerance_px;
    return drawable;
}

}  // namespace far_osg
