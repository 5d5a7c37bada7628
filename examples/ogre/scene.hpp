// What lies below a scene node as hierarchies: a sub-mesh is a body that is placed as often as entities have it.
#pragma once

#include <OgreEntity.h>
#include <OgreSceneNode.h>

#include <deque>
#include <map>
#include <utility>
#include <vector>

#include "farfield/approximation/opacity_tensor.hpp"
#include "farfield/cost_model/triangle_count.hpp"
#include "farfield/partition/octree.hpp"
#include "farfield/primitive/instance.hpp"
#include "farfield/spatial_hierarchy.hpp"
#include "part.hpp"

namespace far_ogre {

using Hierarchy = farfield::SpatialHierarchy<farfield::Octree, farfield::OpacityTensor, farfield::TriangleCount>;
using Triangle = farfield::IndexedPrimitive<Part>;
using Placement = farfield::Instance<Hierarchy, Triangle>;

/// Entities below a node as they are now, in the node's coordinates: meshes are kept, and must not change.
///
/// A sub-mesh in a material is there once. Where it is placed by rotation, uniform scale and translation it is an
/// instance; where it is mirrored or stretched it gets stand-ins of its own, but no vertices.
class Scene {
  public:
    /// Throws std::invalid_argument, which names the node and the object, for what would look otherwise: an object that
    /// is no entity, one that is animated, a texture, lights, blending, several passes; primitives that are no
    /// triangles, vertices of another type than float, colors of another than bytes. So it is for vertices that are not
    /// finite, or that no buffer has.
    explicit Scene(const Ogre::SceneNode& root);
    Scene(const Scene&) = delete;
    Scene& operator=(const Scene&) = delete;

    const Hierarchy& hierarchy() const { return hierarchy_; }
    const std::vector<Placement>& placements() const { return placements_; }
    /// To be called when whoever needs the triangles has read them, and before anything is drawn.
    void close_buffers() { buffers_.close(); }

  private:
    struct Body {
        Part part;
        Hierarchy hierarchy{};
    };
    void read(const Ogre::SceneNode& node, const glm::dmat4& from_world);
    void place(Ogre::SubEntity& entity, const glm::dmat4& to_scene);
    Part part_of(Ogre::SubEntity& entity);
    Body& body_of(const Part& part);

    OpenBuffers buffers_;
    std::deque<Body> bodies_;
    std::map<std::pair<const Ogre::SubMesh*, const Ogre::Material*>, Body*> shared_;
    std::vector<Placement> placements_;
    Hierarchy hierarchy_;
};

}  // namespace far_ogre
