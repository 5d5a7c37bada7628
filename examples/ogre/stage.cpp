#include "stage.hpp"

#include <GL/gl.h>
#include <OgreHardwarePixelBuffer.h>
#include <OgreLogManager.h>
#include <OgreRenderTexture.h>
#include <OgreRenderWindow.h>
#include <OgreRoot.h>
#include <OgreTextureManager.h>

#include <chrono>
#include <string>

namespace far_ogre {

void start() {
    if (Ogre::Root::getSingletonPtr() != nullptr) return;
    static Ogre::LogManager log;
    log.createLog("", true, false, true);
    static Ogre::Root root("", "", "");
    root.loadPlugin(FAR_OGRE_PLUGINS "/RenderSystem_GL3Plus");
    root.setRenderSystem(root.getAvailableRenderers().front());
    root.initialise(false);
    const Ogre::NameValuePairList hidden{{"hidden", "true"}};
    root.createRenderWindow("nobody sees it", 16, 16, false, &hidden)->setAutoUpdated(false);
}

Stage::Stage(const Fill& fill, int width, int height)
    : picture_(width, height), manager_(Ogre::Root::getSingleton().createSceneManager()) {
    texture_ = Ogre::TextureManager::getSingleton().createManual(
        manager_->getName(), Ogre::RGN_DEFAULT, Ogre::TEX_TYPE_2D, Ogre::uint(width), Ogre::uint(height), 0,
        Ogre::PF_BYTE_RGBA, Ogre::TU_RENDERTARGET);
    Ogre::Camera* camera = manager_->createCamera("eye");
    camera->setFOVy(Ogre::Degree(45));
    camera->setAspectRatio(Ogre::Real(width) / Ogre::Real(height));
    camera->setNearClipDistance(1);
    camera->setFarClipDistance(10'000);
    eye_ = manager_->getRootSceneNode()->createChildSceneNode();
    eye_->setFixedYawAxis(true);
    eye_->attachObject(camera);
    target_ = texture_->getBuffer()->getRenderTarget();
    target_->setAutoUpdated(false);
    target_->addViewport(camera)->setBackgroundColour(Ogre::ColourValue(0.62f, 0.72f, 0.82f));
    far_field_ = fill(*manager_);
}

Stage::~Stage() {
    far_field_.reset();
    Ogre::TextureManager::getSingleton().remove(texture_);
    Ogre::Root::getSingleton().destroySceneManager(manager_);
}

double Stage::frame(const farfield::engines::Eye& eye) {
    const auto vector = [](const glm::dvec3& p) {
        return Ogre::Vector3(Ogre::Real(p.x), Ogre::Real(p.y), Ogre::Real(p.z));
    };
    eye_->setPosition(vector(eye.at));
    eye_->lookAt(vector(eye.target), Ogre::Node::TS_WORLD);
    const auto begin = std::chrono::steady_clock::now();
    target_->update();
    glFinish();
    const auto end = std::chrono::steady_clock::now();
    const Ogre::Box all(0, 0, Ogre::uint32(picture_.width()), Ogre::uint32(picture_.height()));
    target_->copyContentsToMemory(all, {all, Ogre::PF_BYTE_RGBA, picture_.pixels().data()});
    for (farfield::Rgba8& pixel : picture_.pixels()) pixel.a = 255;
    return std::chrono::duration<double, std::milli>(end - begin).count();
}

}  // namespace far_ogre
