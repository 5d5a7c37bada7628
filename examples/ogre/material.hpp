// A material of two shaders, which gets "to_clip".
#pragma once

#include <OgreMaterial.h>

namespace far_ogre {

/// Without lights, seen from both sides. Made once; the second time it is the same.
Ogre::MaterialPtr material_of(const char* name, const char* vertex_shader, const char* fragment_shader);

}  // namespace far_ogre
