// Whatever a header defines is defined once, in however many files of a program it is included.
#if defined(WITH_ENGINE_MACROS)
#include <glm/glm.hpp>

#include "engine_macros.hpp"
#endif
#include "farfield/farfield.hpp"

int farfield_in_another_file();  // engines ask for a declaration before each definition
int farfield_in_another_file() {
    return FARFIELD_VERSION;
}
