// Pictures of the drawable against osg's own of the same scene graph.
#include "far_drawable.hpp"

#include <cstdlib>
#include <osg/MatrixTransform>

#include "catch.hpp"
#include "farfield/measure/flip.hpp"
#include "forest.hpp"
#include "graphs.hpp"
#include "stage.hpp"
#include "support/display.hpp"

using namespace far_osg;
using far_osg::test::leaf;
using far_osg::test::placed;
using farfield::test::Display;

namespace {

constexpr int width = 160, height = 120;

struct Drawn {
    farfield::Image picture;
    farfield::FrameStats stats;
};
farfield::Image drawn_by_osg(osg::Node& root, const farfield::engines::Eye& eye) {
    Stage stage(&root, width, height);
    stage.frame(eye);
    return stage.picture();
}
Drawn drawn_far(osg::Node& root, const farfield::engines::Eye& eye, float tolerance_px,
                const osg::Matrixd& place = osg::Matrixd()) {
    osg::ref_ptr<FarDrawable> drawable = new FarDrawable(std::make_shared<Scene>(root));
    drawable->tolerance_px = tolerance_px;
    Stage stage(placed(*drawable, place), width, height);
    stage.frame(eye);
    stage.frame(eye);
    return {stage.picture(), drawable->stats()};
}

/// Squares in nested transforms, of which the inner ones stretch, in two geometries.
osg::ref_ptr<osg::Group> stretched_squares() {
    const osg::ref_ptr<osg::Geometry> shared = leaf(), other = leaf();
    osg::ref_ptr<osg::Vec4ubArray> colors = new osg::Vec4ubArray;
    for (const osg::Vec4ub& c : {osg::Vec4ub(255, 0, 0, 255), osg::Vec4ub(0, 255, 0, 255), osg::Vec4ub(0, 0, 255, 255),
                                 osg::Vec4ub(255, 255, 255, 255)})
        colors->push_back(c);
    colors->setNormalize(true);
    other->setColorArray(colors, osg::Array::BIND_PER_VERTEX);
    other->setUseVertexBufferObjects(false);
    osg::ref_ptr<osg::Group> two = new osg::Group;
    two->addChild(shared);
    two->addChild(placed(*other, osg::Matrixd::translate(1.2, 0, 0.1)));
    osg::ref_ptr<osg::Group> root = new osg::Group;
    for (int i = 0; i < 12; ++i) {
        osg::ref_ptr<osg::MatrixTransform> outer = new osg::MatrixTransform(
            osg::Matrixd::scale(1, 1 + 0.2 * i, 1) * osg::Matrixd::rotate(0.3 * i, osg::Vec3d(0, 1, 0.2)) *
            osg::Matrixd::translate(2.5 * (i % 4), 3 * (i / 4), -i));
        outer->addChild(placed(*two, osg::Matrixd::rotate(0.1 * i, osg::Vec3d(0, 0, 1))));
        root->addChild(outer);
    }
    return root;
}

}  // namespace

TEST_CASE("without a tolerance the picture is osg's, whatever transforms stretch") {
    const auto display = Display::open();
    if (!display) return;
    const farfield::engines::Eye eye{{4, 4, 14}, {4, 4, 0}};
    const farfield::Image wanted = drawn_by_osg(*stretched_squares(), eye);
    const Drawn drawn = drawn_far(*stretched_squares(), eye, 0);
    CHECK(drawn.stats.is_exact());
    CHECK(farfield::flip(drawn.picture, wanted) < 0.002);
    CHECK(farfield::flip(wanted, farfield::Image(width, height, wanted.at(0, 0))) > 0.05);  // there is something
}

TEST_CASE("thousands of tiny geometries, each with arrays and a state of its own, are drawn as osg draws them") {
    const auto display = Display::open();
    if (!display) return;
    osg::ref_ptr<osg::Group> root = new osg::Group;
    constexpr int side = 50;
    for (int i = 0; i < side * side; ++i) {
        const osg::ref_ptr<osg::Geometry> one = leaf();
        (*static_cast<osg::Vec4Array*>(one->getColorArray()))[0] = {float(i % 7) / 6, float(i % 11) / 10, 0.2f, 1};
        one->setCullingActive(false);  // osg would leave out what is small
        root->addChild(placed(*one, osg::Matrixd::translate(1.5 * (i % side), 1.5 * (i / side), 0.01 * (i % 13))));
    }
    const farfield::engines::Eye eye{{40, 30, 60}, {36, 36, 0}};
    const Drawn drawn = drawn_far(*root, eye, 0);
    CHECK(drawn.stats.primitives > side * side);
    CHECK(farfield::flip(drawn.picture, drawn_by_osg(*root, eye)) < 0.002);
}

TEST_CASE("the drawable may itself be placed, and scaled") {
    const auto display = Display::open();
    if (!display) return;
    const farfield::engines::Eye eye{{4, 4, 14}, {4, 4, 0}};
    const osg::Matrixd place = osg::Matrixd::scale(0.5, 0.5, 0.5) * osg::Matrixd::rotate(0.4, osg::Vec3d(0, 1, 0)) *
                               osg::Matrixd::translate(2, 1, 3);
    const farfield::Image wanted = drawn_by_osg(*placed(*stretched_squares(), place), eye);
    CHECK(farfield::flip(drawn_far(*stretched_squares(), eye, 0, place).picture, wanted) < 0.002);
    const Drawn drawn = drawn_far(*stretched_squares(), eye, 8, place);
    CHECK(farfield::flip(drawn.picture, wanted) < 0.1);
}

TEST_CASE("a forest is drawn by stand-ins, which look like it and hide behind what osg draws") {
    const auto display = Display::open();
    if (!display) return;
    const farfield::engines::Forest trees({.trees_a_side = 8, .triangles_a_tree = 4000, .kinds = 2});
    const Forest forest(trees);
    constexpr int side = 4;
    const farfield::engines::Eye eye = trees.eye(0.3);
    Stage fine(forest.plain(), width * side, height * side);
    fine.frame(eye);
    const farfield::Image reference = farfield::engines::mean_picture(fine.picture(), side);
    Stage plain(forest.plain(), width, height), far_field(forest.with_far_field(forest.far_field(2)), width, height);
    plain.frame(eye);
    far_field.frame(eye);
    const double plain_flip = farfield::flip(plain.picture(), reference);
    CHECK(farfield::flip(far_field.picture(), reference) < plain_flip);
}
