// Ogre without a window to be seen: draws a frame into a texture, takes its time, and reads the picture back.
#pragma once

#include <OgreSceneManager.h>
#include <OgreTexture.h>

#include <functional>
#include <memory>

#include "engines/compare.hpp"
#include "far_field.hpp"

namespace far_ogre {

/// Starts Ogre, for all of the program, with OpenGL 3 and no log. Throws Ogre::Exception where there is no display.
void start();

class Stage : public farfield::engines::Stage {
  public:
    /// Fills the scene, with a farfield object or without. Ogre has been started.
    using Fill = std::function<std::unique_ptr<FarField>(Ogre::SceneManager&)>;
    Stage(const Fill& fill, int width, int height);
    ~Stage() override;

    double frame(const farfield::engines::Eye& eye) override;
    const farfield::Image& picture() const override { return picture_; }
    farfield::FrameStats stats() const override { return far_field_ ? far_field_->stats() : farfield::FrameStats{}; }

  private:
    farfield::Image picture_;
    Ogre::SceneManager* manager_;
    Ogre::TexturePtr texture_;
    Ogre::RenderTarget* target_;
    Ogre::SceneNode* eye_;
    std::unique_ptr<FarField> far_field_;
};

}  // namespace far_ogre
