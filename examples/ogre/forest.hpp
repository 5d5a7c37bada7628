// The forest in Ogre, and the ways to draw it.
#pragma once

#include <OgreMesh.h>
#include <OgreSceneManager.h>

#include <memory>
#include <string>
#include <vector>

#include "engines/forest.hpp"
#include "far_field.hpp"

namespace far_ogre {

/// In Ogre's own buffers. Needs a render system.
Ogre::MeshPtr mesh_of(const std::string& name, const farfield::engines::Mesh& mesh);

class Forest {
  public:
    explicit Forest(const farfield::engines::Forest& forest);

    // The same scene, to be drawn in one way each.
    void plain(Ogre::SceneManager& manager) const;
    /// Each tree in four levels, made by Ogre::MeshLodGenerator, the coarser ones with half of the vertices each.
    void with_levels(Ogre::SceneManager& manager) const;
    /// Trees nearby in one batch: Ogre::StaticGeometry.
    void static_geometry(Ogre::SceneManager& manager) const;
    /// All trees in one object, and ground, which Ogre draws as it draws all else.
    std::unique_ptr<FarField> far_field(Ogre::SceneManager& manager, float tolerance_px) const;

  private:
    void add_ground(Ogre::SceneManager& manager) const;
    /// Entities of these meshes, one a kind, below a node.
    void add_trees(Ogre::SceneNode& below, const std::vector<Ogre::MeshPtr>& kinds) const;

    std::vector<farfield::engines::PlacedTree> trees_;
    std::vector<Ogre::MeshPtr> kinds_;
    Ogre::MeshPtr ground_;
};

}  // namespace far_ogre
