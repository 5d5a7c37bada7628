// Where the zero of a file of pages lies. Its coordinates are in single precision, as those of a Scene are, and like
// that they leave out how far away the scene is (Scene::origin).
#pragma once

#include <filesystem>
#include <glm/vec3.hpp>

namespace farfield::scenes {

/// In a file beside the pages, PAGES.origin: three numbers, and a file only where they are not 0. Throws
/// std::runtime_error that names the file if it cannot be written.
void keep_origin(const std::filesystem::path& pages, glm::dvec3 origin);

/// What has been kept, or 0. Throws std::runtime_error that names the file if it holds anything else than three finite
/// numbers.
glm::dvec3 kept_origin(const std::filesystem::path& pages);

}  // namespace farfield::scenes
