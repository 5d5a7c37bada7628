// A scene graph as hierarchies: what has several parents is a body that is placed several times.
#pragma once

#include <cstdint>
#include <deque>
#include <glm/vec3.hpp>
#include <map>
#include <osg/BoundingBox>
#include <osg/Node>
#include <string>
#include <utility>
#include <vector>

#include "farfield/approximation/opacity_tensor.hpp"
#include "farfield/cost_model/triangle_count.hpp"
#include "farfield/partition/octree.hpp"
#include "farfield/primitive/instance.hpp"
#include "farfield/spatial_hierarchy.hpp"
#include "mesh.hpp"

namespace far_osg {

using Hierarchy = farfield::SpatialHierarchy<farfield::Octree, farfield::OpacityTensor, farfield::TriangleCount>;
using Placement = farfield::Instance<Hierarchy, MeshTriangle>;

/// What lies below a node, as it is now: the graph is kept, and must not change. Colors are drawn as they are, without
/// lights, so that nobody asks for normals.
///
/// A part with several parents is there once. Where it is placed by rotation, uniform scale and translation it is an
/// instance; where it is mirrored, sheared or stretched it gets handles and stand-ins of its own, but no vertices.
class Scene {
  public:
    static constexpr std::uint64_t most_placements = std::uint64_t(1) << 26;

    /// Throws std::invalid_argument, which names the node by its path, for what would look otherwise: a node that the
    /// eye chooses for or turns, a texture, a shader, blending, lights that are switched on; a drawable that is no
    /// osg::Geometry; primitives that are no triangles; vertices or colors of another type, or that are missing. And
    /// for what has no end: a node below itself, parts of parts that come to more than `most_placements`, places that
    /// are not finite in single precision.
    explicit Scene(osg::Node& root);
    Scene(const Scene&) = delete;
    Scene& operator=(const Scene&) = delete;

    const Hierarchy& hierarchy() const { return hierarchy_; }
    const std::vector<Placement>& placements() const { return placements_; }
    osg::BoundingBox bounds() const;
    std::size_t triangles() const;  ///< handles, not counted again for each placement

  private:
    struct Body {
        std::string path{};  ///< of the node, as it was found first
        std::deque<Mesh> meshes{};
        std::vector<MeshTriangle> triangles{};
        Hierarchy hierarchy{};
        std::vector<std::pair<Body*, osg::Matrixd>> parts{};  ///< with parents of their own
    };
    class Reader;
    struct Key {
        const osg::Node* node;
        States states;
        friend bool operator<(const Key& a, const Key& b) {
            return a.node != b.node ? a.node < b.node : a.states < b.states;
        }
    };

    void place(Body& body, const osg::Matrixd& to_world);

    osg::ref_ptr<osg::Node> root_;
    std::deque<Body> bodies_;
    std::map<Key, Body*> body_of_;
    std::vector<Placement> placements_;
    Hierarchy hierarchy_;
};

}  // namespace far_osg
