// What Ogre is handed to draw in one call.
#pragma once

#include <OgreLight.h>
#include <OgreMaterial.h>
#include <OgreRenderable.h>
#include <OgreRenderOperation.h>
#include <OgreVertexIndexData.h>

#include <glm/gtc/type_ptr.hpp>
#include <glm/matrix.hpp>

namespace far_ogre {

/// Placed relative to the eye, where single precision is at its best.
struct Piece : Ogre::Renderable {
    Ogre::MaterialPtr material;
    Ogre::RenderOperation operation;
    Ogre::IndexData indices;
    Ogre::Matrix4 to_eye = Ogre::Matrix4::IDENTITY;

    Piece() { setUseIdentityView(true); }
    void place(const glm::dmat4& m) { to_eye = Ogre::Matrix4(glm::value_ptr(glm::transpose(m))); }

    const Ogre::MaterialPtr& getMaterial() const override { return material; }
    void getRenderOperation(Ogre::RenderOperation& wanted) override { wanted = operation; }
    void getWorldTransforms(Ogre::Matrix4* m) const override { *m = to_eye; }
    Ogre::Real getSquaredViewDepth(const Ogre::Camera*) const override { return 0; }  // blended after all else
    const Ogre::LightList& getLights() const override {
        static const Ogre::LightList none;
        return none;
    }
};

}  // namespace far_ogre
