// Scene graphs for tests.
#pragma once

#include <osg/Geometry>
#include <osg/MatrixTransform>

namespace far_osg::test {

/// A square of side 1 in two triangles, orange, without normals.
inline osg::ref_ptr<osg::Geometry> leaf() {
    osg::ref_ptr<osg::Geometry> geometry = new osg::Geometry;
    osg::ref_ptr<osg::Vec3Array> vertices = new osg::Vec3Array;
    for (const osg::Vec3& v : {osg::Vec3(0, 0, 0), osg::Vec3(1, 0, 0), osg::Vec3(1, 1, 0), osg::Vec3(0, 1, 0)})
        vertices->push_back(v);
    osg::ref_ptr<osg::Vec4Array> color = new osg::Vec4Array;
    color->push_back({1, 0.5f, 0, 1});
    osg::ref_ptr<osg::DrawElementsUInt> corners = new osg::DrawElementsUInt(GL_TRIANGLES);
    for (const unsigned i : {0u, 1u, 2u, 0u, 2u, 3u}) corners->push_back(i);
    geometry->setVertexArray(vertices);
    geometry->setColorArray(color, osg::Array::BIND_OVERALL);
    geometry->addPrimitiveSet(corners);
    geometry->setUseDisplayList(false);
    geometry->setUseVertexBufferObjects(true);
    return geometry;
}

inline osg::ref_ptr<osg::MatrixTransform> placed(osg::Node& node, const osg::Matrixd& place) {
    osg::ref_ptr<osg::MatrixTransform> transform = new osg::MatrixTransform(place);
    transform->addChild(&node);
    return transform;
}

}  // namespace far_osg::test
