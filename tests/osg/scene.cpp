// What of a scene graph is drawn, and what is refused by name. Needs no display.
#include "scene.hpp"

#include <cmath>
#include <limits>
#include <osg/AutoTransform>
#include <osg/Drawable>
#include <osg/LOD>
#include <osg/MatrixTransform>
#include <osg/Switch>
#include <osg/Texture2D>
#include <stdexcept>
#include <string>
#include <utility>

#include "catch.hpp"
#include "graphs.hpp"

using namespace far_osg;
using far_osg::test::leaf;
using far_osg::test::placed;

namespace {

/// What is said of a scene that is refused; empty: nothing.
std::string refusal(osg::Node& root) {
    try {
        const Scene scene(root);
        return "";
    } catch (const std::invalid_argument& error) {
        return error.what();
    }
}

void check_refused(osg::Node& node, const std::string& why) {
    node.setName("the culprit");
    osg::ref_ptr<osg::Group> root = new osg::Group;
    root->addChild(leaf());
    root->addChild(&node);
    const std::string said = refusal(*root);
    INFO(said);
    CHECK(said.find("'the culprit'") != std::string::npos);
    CHECK(said.find(why) != std::string::npos);
}

}  // namespace

TEST_CASE("what has several parents is there once, and its vertices stay where they are") {
    const osg::ref_ptr<osg::Geometry> shared = leaf();
    osg::ref_ptr<osg::Group> root = new osg::Group;
    for (int i = 0; i < 100; ++i) root->addChild(placed(*shared, osg::Matrixd::translate(i, 0, 0)));
    const unsigned vertices = shared->getVertexArray()->getNumElements();
    const Scene scene(*root);
    CHECK(scene.placements().size() == 100);
    CHECK(scene.triangles() == 2);
    CHECK(shared->getVertexArray()->getNumElements() == vertices);
    CHECK(scene.hierarchy().bounds().size().x == Approx(100));
}

TEST_CASE("nested transforms that stretch, shear and mirror are right") {
    const osg::ref_ptr<osg::Geometry> shared = leaf();
    const osg::Matrixd outer = osg::Matrixd::scale(1, 3, -0.5) * osg::Matrixd::rotate(0.7, osg::Vec3d(1, 2, 3)),
                       inner = osg::Matrixd::rotate(-0.4, osg::Vec3d(0, 1, 1)) * osg::Matrixd::scale(2, 1, 1) *
                               osg::Matrixd::translate(3, 4, 5);
    osg::ref_ptr<osg::Group> root = new osg::Group;
    osg::ref_ptr<osg::MatrixTransform> out = new osg::MatrixTransform(outer);
    out->addChild(placed(*shared, inner));
    root->addChild(out);
    root->addChild(placed(*shared, osg::Matrixd()));  // so that it has two parents
    const Scene scene(*root);
    REQUIRE(scene.placements().size() == 2);
    const auto& vertices = static_cast<const osg::Vec3Array&>(*shared->getVertexArray());
    farfield::BoxD wanted = farfield::BoxD::empty(), got = farfield::BoxD::empty();
    for (const osg::Vec3& v : vertices) {
        for (const osg::Matrixd& m : {inner * outer, osg::Matrixd()}) {
            const osg::Vec3d p = osg::Vec3d(v) * m;
            wanted.add({p.x(), p.y(), p.z()});
        }
    }
    double area = 0;
    for (const Placement& placement : scene.placements()) {
        for (const MeshTriangle& t : placement.primitives) {
            t.polygons([&](const farfield::PolygonD& polygon) {
                std::array<glm::dvec3, 3> at;
                for (std::size_t i = 0; i < 3; ++i) got.add(at[i] = placement.to_world.apply(polygon.vertices[i]));
                area += 0.5 * glm::length(glm::cross(at[1] - at[0], at[2] - at[0]));
            });
        }
    }
    for (int i = 0; i < 3; ++i) {
        CHECK(got.lower[i] == Approx(wanted.lower[i]).margin(1e-5));
        CHECK(got.upper[i] == Approx(wanted.upper[i]).margin(1e-5));
    }
    const osg::Vec3d side = osg::Matrixd::transform3x3(osg::Vec3d(1, 0, 0), inner * outer),
                     up = osg::Matrixd::transform3x3(osg::Vec3d(0, 1, 0), inner * outer);
    CHECK(area == Approx(1 + (side ^ up).length()));
}

TEST_CASE("geometry without normals, colors or anything at all is taken") {
    const osg::ref_ptr<osg::Geometry> bare = leaf();
    bare->setColorArray(nullptr);
    REQUIRE(bare->getNormalArray() == nullptr);
    CHECK(refusal(*bare).empty());
    osg::ref_ptr<osg::Group> nothing = new osg::Group;
    nothing->addChild(new osg::Geometry);
    const Scene scene(*nothing);
    CHECK(scene.placements().empty());
}

TEST_CASE("triangles without an area, and transforms that leave none, are taken and bounded as they lie") {
    const osg::ref_ptr<osg::Geometry> point = leaf(), shared = leaf();
    static_cast<osg::Vec3Array&>(*point->getVertexArray()).assign(4, osg::Vec3(3, 4, 5));
    osg::ref_ptr<osg::Group> root = new osg::Group;
    root->addChild(point);
    root->addChild(placed(*shared, osg::Matrixd::scale(0, 1, 1)));
    root->addChild(placed(*shared, osg::Matrixd::scale(0, 0, 0) * osg::Matrixd::translate(-1, 0, 0)));
    const Scene scene(*root);
    CHECK(scene.placements().size() == 3);
    CHECK(scene.bounds() == osg::BoundingBox(-1, 0, 0, 3, 4, 5));
}

TEST_CASE("what lies below itself is refused, and so are parts of parts that come to more than there is room for") {
    osg::ref_ptr<osg::Group> loop = new osg::Group, in_it = new osg::Group;
    loop->addChild(leaf());
    loop->addChild(in_it);
    in_it->addChild(loop);
    check_refused(*loop, "below its own child");
    in_it->removeChild(loop);
    CHECK(refusal(*loop).empty());

    // Two of two of two, and so on: 2^20 of them can be had, 2^40 cannot.
    osg::ref_ptr<osg::Node> part = leaf();
    for (int level = 1; level <= 40; ++level) {
        osg::ref_ptr<osg::Group> two = new osg::Group;
        for (const double side : {0.0, 1.0}) two->addChild(placed(*part, osg::Matrixd::translate(side * level, 0, 0)));
        part = two;
        if (level == 12) CHECK(Scene(*part).placements().size() == 4096);
    }
    check_refused(*part, "placed more than");
    // The same, where each has a state of its own.
    part = leaf();
    for (int level = 1; level <= 40; ++level) {
        osg::ref_ptr<osg::Group> two = new osg::Group;
        for (int side = 0; side < 2; ++side) {
            osg::ref_ptr<osg::Group> own = new osg::Group;
            own->getOrCreateStateSet();
            own->addChild(part);
            two->addChild(own);
        }
        part = two;
    }
    check_refused(*part, "placed more than");
}

TEST_CASE("places that single precision does not reach are refused, and the node named") {
    const osg::ref_ptr<osg::Geometry> shared = leaf();
    shared->setName("the culprit");
    osg::ref_ptr<osg::Group> root = new osg::Group;
    root->addChild(shared);
    const auto said_of = [&](const osg::Matrixd& outer, const osg::Matrixd& inner) {
        osg::ref_ptr<osg::MatrixTransform> out = new osg::MatrixTransform(outer);
        out->addChild(placed(*shared, inner));
        root->addChild(out);
        const std::string said = refusal(*root);
        root->removeChild(out);
        return said;
    };
    const osg::Matrixd wide = osg::Matrixd::scale(1e200, 1e200, 1e200), stretched = osg::Matrixd::scale(1e200, 1, 1);
    for (const auto& [outer, inner] :
         {std::pair{wide, wide}, std::pair{stretched, stretched}, std::pair{stretched, osg::Matrixd()}}) {
        const std::string said = said_of(outer, inner);
        INFO(said);
        CHECK(said.find("'the culprit'") != std::string::npos);
    }
    CHECK(said_of(osg::Matrixd(), osg::Matrixd()).empty());
}

TEST_CASE("strips, fans and quadrangles are triangles") {
    const osg::ref_ptr<osg::Geometry> geometry = leaf();
    geometry->removePrimitiveSet(0);
    for (const int mode : {GL_TRIANGLE_FAN, GL_QUADS, GL_POLYGON})
        geometry->addPrimitiveSet(new osg::DrawArrays(GLenum(mode), 0, 4));
    geometry->addPrimitiveSet(new osg::DrawArrays(GL_TRIANGLE_STRIP, 0, 4));
    const Scene scene(*geometry);
    CHECK(scene.triangles() == 8);
}

TEST_CASE("what is switched off or masked is not there") {
    osg::ref_ptr<osg::Switch> chosen = new osg::Switch;
    chosen->addChild(leaf(), true);
    chosen->addChild(leaf(), false);
    const osg::ref_ptr<osg::Geometry> masked = leaf();
    masked->setNodeMask(0);
    chosen->addChild(masked, true);
    CHECK(Scene(*chosen).triangles() == 2);
}

TEST_CASE("a scene of very many tiny geometries is read, each a mesh of its own") {
    // All have the same arrays, so that the test is about nodes.
    const osg::ref_ptr<osg::Geometry> first = leaf();
    osg::ref_ptr<osg::Group> root = new osg::Group;
    constexpr int side = 250;  // minutes, if each took time in proportion to all
    for (int i = 0; i < side * side; ++i) {
        osg::ref_ptr<osg::Geometry> one = osg::clone(first.get(), osg::CopyOp::SHALLOW_COPY);
        root->addChild(placed(*one, osg::Matrixd::translate(2 * (i % side), 0, 2 * (i / side))));
    }
    const Scene scene(*root);
    CHECK(scene.triangles() == 2 * side * side);
    CHECK(scene.placements().size() == 1);
}

TEST_CASE("what stand-ins cannot show is refused, and the node named") {
    check_refused(*new osg::LOD, "distance");
    check_refused(*new osg::AutoTransform, "turns to the eye");
    check_refused(*new osg::Drawable, "osg::Geometry");
    osg::ref_ptr<osg::MatrixTransform> absolute = new osg::MatrixTransform;
    absolute->setReferenceFrame(osg::Transform::ABSOLUTE_RF);
    check_refused(*absolute, "relative");
    osg::ref_ptr<osg::MatrixTransform> infinite = new osg::MatrixTransform(osg::Matrixd::scale(1, double(INFINITY), 1));
    check_refused(*infinite, "affine");

    const auto with = [](auto&& change) {
        osg::ref_ptr<osg::Geometry> geometry = leaf();
        change(*geometry);
        return geometry;
    };
    check_refused(*with([](auto& g) { g.getOrCreateStateSet()->setTextureAttribute(0, new osg::Texture2D); }),
                  "texture");
    check_refused(*with([](auto& g) { g.getOrCreateStateSet()->setMode(GL_LIGHTING, osg::StateAttribute::ON); }),
                  "lit");
    check_refused(*with([](auto& g) { g.getOrCreateStateSet()->setMode(GL_BLEND, osg::StateAttribute::ON); }),
                  "blended");
    check_refused(*with([](auto& g) { g.setPrimitiveSet(0, new osg::DrawArrays(GL_LINES, 0, 4)); }), "triangles");
    check_refused(*with([](auto& g) { g.setVertexArray(new osg::Vec2Array(4)); }), "Vec3Array");
    check_refused(*with([](auto& g) { g.setColorArray(new osg::Vec4Array(2), osg::Array::BIND_PER_VERTEX); }),
                  "colors");
    check_refused(*with([](auto& g) { g.setPrimitiveSet(0, new osg::DrawArrays(GL_QUADS, 4, 4)); }), "index");
    check_refused(*with([](auto& g) { g.setPrimitiveSet(0, new osg::DrawArrays(GL_TRIANGLES, 0, 2000000000)); }),
                  "draws 2000000000 of 4");
    check_refused(*with([](auto& g) { g.setPrimitiveSet(0, new osg::DrawArrays(GL_TRIANGLES, 0, -3)); }), "draws");
    check_refused(*with([](auto& g) { g.setVertexArray(nullptr); }), "Vec3Array");
    check_refused(*with([](auto& g) {
        static_cast<osg::Vec3Array&>(*g.getVertexArray())[2].y() = std::numeric_limits<float>::quiet_NaN();
    }),
                  "not finite");
}
