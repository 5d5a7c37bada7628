// Where the zero of a file of pages lies. Its coordinates are in single precision, as those of a Scene are, and like
// that they leave out how far away the scene is (Scene::origin); a note of the file tells.
#pragma once

#include <glm/vec3.hpp>
#include <string>

#include "farfield/storage/notes.hpp"

namespace farfield::scenes {

/// Three numbers in a note; none where they are 0, so that such a file is as any other.
Notes notes_of_origin(glm::dvec3 origin);

/// What a file's notes tell, or 0. Throws std::runtime_error that names `file` if they tell anything else than three
/// finite numbers.
glm::dvec3 origin_in(const Notes& notes, const std::string& file);

}  // namespace farfield::scenes
