// Where OpenGL comes from: change this line if your program loads it in another way.
#pragma once

#include <epoxy/gl.h>
