// Files of pages as farfield_build makes them, which are larger than memory: here or on a web server.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>

#include "farfield/geometry/box.hpp"
#include "scenes/built_scene.hpp"

namespace viewer {

/// A name that ends in .farfield, or an address that begins with http:// or https://.
bool is_paged_scene(const std::string& where);

struct PagedScene {
    std::shared_ptr<const farfield::scenes::BuiltScene> built;
    std::string variant;
    farfield::BoxD bounds;
    std::uint64_t primitives = 0, file_bytes = 0, pages = 0;
};

/// The z-buffer does, and OpenGL where this program was built with it.
bool draws_pages(farfield::scenes::RendererKind kind);

/// Throws std::runtime_error, one line that names the place.
PagedScene open_paged_scene(const std::string& where, std::size_t cache_bytes);

}  // namespace viewer
