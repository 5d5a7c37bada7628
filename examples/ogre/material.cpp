#include "material.hpp"

#include <OgreHighLevelGpuProgram.h>
#include <OgreHighLevelGpuProgramManager.h>
#include <OgreMaterialManager.h>
#include <OgreTechnique.h>

namespace far_ogre {

Ogre::MaterialPtr material_of(const char* name, const char* vertex_shader, const char* fragment_shader) {
    const Ogre::String group = Ogre::ResourceGroupManager::INTERNAL_RESOURCE_GROUP_NAME;
    const auto [resource, is_new] = Ogre::MaterialManager::getSingleton().createOrRetrieve(name, group);
    const auto material = Ogre::static_pointer_cast<Ogre::Material>(resource);
    if (!is_new) return material;
    Ogre::Pass& pass = *material->getTechnique(0)->getPass(0);
    pass.setLightingEnabled(false);
    pass.setCullingMode(Ogre::CULL_NONE);
    const auto program = [&](const char* stage, Ogre::GpuProgramType type, const char* source) {
        const Ogre::HighLevelGpuProgramPtr made = Ogre::HighLevelGpuProgramManager::getSingleton().createProgram(
            Ogre::String(name) + stage, group, "glsl", type);
        made->setSource(source);
        return made->getName();
    };
    pass.setVertexProgram(program(" vertex", Ogre::GPT_VERTEX_PROGRAM, vertex_shader));
    pass.setFragmentProgram(program(" fragment", Ogre::GPT_FRAGMENT_PROGRAM, fragment_shader));
    pass.getVertexProgramParameters()->setNamedAutoConstant("to_clip",
                                                            Ogre::GpuProgramParameters::ACT_WORLDVIEWPROJ_MATRIX);
    material->load();
    return material;
}

}  // namespace far_ogre
