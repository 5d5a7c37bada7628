#include "forest.hpp"

#include <cmath>
#include <cstring>
#include <map>
#include <osg/LOD>
#include <osg/MatrixTransform>
#include <osgSim/Impostor>
#include <osgUtil/Simplifier>
#include <random>
#include <tuple>

#include "scenes/generate/tree.hpp"

namespace far_osg {
namespace {

constexpr double spacing_m = 8, height_m = 10;

void draws_from_buffers(osg::Geometry& geometry) {
    geometry.setUseDisplayList(false);
    geometry.setUseVertexBufferObjects(false);  // so that new arrays get buffers, too
    geometry.setUseVertexBufferObjects(true);
}

/// Vertices that are the same are shared.
osg::ref_ptr<osg::Geometry> geometry_of(const std::vector<farfield::VertexColoredTriangle>& triangles) {
    osg::ref_ptr<osg::Vec3Array> vertices = new osg::Vec3Array;
    osg::ref_ptr<osg::Vec4ubArray> colors = new osg::Vec4ubArray;
    osg::ref_ptr<osg::DrawElementsUInt> corners = new osg::DrawElementsUInt(GL_TRIANGLES);
    std::map<std::tuple<float, float, float, std::uint32_t>, unsigned> known;
    for (const auto& triangle : triangles) {
        for (std::size_t i = 0; i < 3; ++i) {
            const glm::vec3 p = triangle.vertices[i];
            const farfield::Rgba8 c = triangle.rgba[i];
            const auto [found, is_new] =
                known.try_emplace({p.x, p.y, p.z, std::uint32_t(c.r | c.g << 8 | c.b << 16)}, vertices->size());
            if (is_new) {
                vertices->push_back({p.x, p.y, p.z});
                colors->push_back({c.r, c.g, c.b, 255});
            }
            corners->push_back(found->second);
        }
    }
    colors->setNormalize(true);
    osg::ref_ptr<osg::Geometry> geometry = new osg::Geometry;
    geometry->setVertexArray(vertices);
    geometry->setColorArray(colors, osg::Array::BIND_PER_VERTEX);
    geometry->addPrimitiveSet(corners);
    draws_from_buffers(*geometry);
    return geometry;
}

osg::ref_ptr<osg::Geometry> ground_of(double half) {
    std::vector<farfield::VertexColoredTriangle> triangles;
    const auto h = float(half + spacing_m);
    const farfield::Rgba8 grass{74, 92, 41};
    const glm::vec3 a(-h, 0, -h), b(-h, 0, h), c(h, 0, h), d(h, 0, -h);
    triangles.push_back({{a, b, c}, {grass, grass, grass}});
    triangles.push_back({{a, c, d}, {grass, grass, grass}});
    return geometry_of(triangles);
}

}  // namespace

Forest::Forest(const ForestOptions& options) : half_extent_(spacing_m * options.trees_a_side / 2) {
    for (int kind = 0; kind < options.kinds; ++kind) {
        farfield::scenes::TreeOptions tree;
        tree.seed = std::uint64_t(kind + 1);
        tree.triangles = options.triangles_a_tree;
        tree.light.to_sun = glm::vec3(0, 1, 0);  // the same light however a tree is turned
        kinds_.push_back(geometry_of(farfield::scenes::tree(tree).groups.front().triangles));
        kinds_.back()->setName("tree " + std::to_string(kind));
    }
    std::mt19937 random(7);
    const auto number = [&] { return double(random() % 4096) / 4096; };
    for (int row = 0; row < options.trees_a_side; ++row) {
        for (int column = 0; column < options.trees_a_side; ++column) {
            const double size = 0.8 + 0.4 * number(), turn = 6.28 * number();
            const double x = column + 0.2 + 0.6 * number(), z = row + 0.2 + 0.6 * number();
            trees_.push_back(
                {int(random() % unsigned(options.kinds)),
                 osg::Matrixd::scale(size, size, size) * osg::Matrixd::rotate(turn, osg::Vec3d(0, 1, 0)) *
                     osg::Matrixd::translate(x * spacing_m - half_extent_, 0, z * spacing_m - half_extent_)});
        }
    }
    ground_ = ground_of(half_extent_);
}

Eye Forest::eye(double along) const {
    const double height = 6 * height_m * (1 - along) + 1.2 * height_m * along;
    const double back = half_extent_ + (1 - along) * 4 * height_m;
    return {{0.1 * half_extent_, height, back}, {0, 0.3 * height_m, back - half_extent_}};
}

std::size_t Forest::triangles() const {
    std::size_t sum = 0;
    for (const Tree& tree : trees_) sum += kinds_[std::size_t(tree.kind)]->getPrimitiveSet(0)->getNumIndices() / 3;
    return sum;
}

template <class TreeOf>
osg::ref_ptr<osg::Group> Forest::placed(const TreeOf& tree_of) const {
    osg::ref_ptr<osg::Group> root = new osg::Group;
    root->addChild(ground_);
    for (const Tree& tree : trees_) {
        osg::ref_ptr<osg::MatrixTransform> place = new osg::MatrixTransform(tree.place);
        place->addChild(tree_of(std::size_t(tree.kind)));
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
                osgUtil::Simplifier simplifier(ratio);
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
        impostor->setImpostorThreshold(float(3 * height_m));
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
