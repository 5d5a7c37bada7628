// Scenes as streams of triangles: as often as they are wanted, and larger than memory where they are made as they go.
#pragma once

#include <cstdint>
#include <functional>
#include <glm/vec3.hpp>
#include <string>

#include "scenes/paged_variants.hpp"

namespace farfield::scenes {

using TriangleStream = std::function<void(const std::function<void(const PagedPrimitive&)>&)>;

struct SceneStream {
    TriangleStream triangles;
    glm::dvec3 origin{0};  ///< Scene::origin
};

/// `chessboard:N` (Klein et al. 2002, section 7.2), `landscape:N` (trees on hills, each with triangles of its own),
/// both of about N triangles, which may end in k, M or G; or a file of any format that load() reads, whose triangles
/// lie where large blocks do (large_blocks.hpp). Throws std::invalid_argument for a number that is none, and what
/// loading a file throws.
SceneStream scene_stream(const std::string& name);

}  // namespace farfield::scenes
