// What a scene is drawn with, as programs let their users choose it.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

namespace farfield::scenes {

enum class RendererKind : std::uint8_t { z_buffer, coverage, hierarchical_z, painter, opengl };

inline constexpr std::array renderer_kinds{RendererKind::z_buffer, RendererKind::coverage, RendererKind::hierarchical_z,
                                           RendererKind::painter, RendererKind::opengl};

inline constexpr std::string_view name_of(RendererKind kind) {
    constexpr std::string_view names[] = {"z-buffer", "coverage", "hierarchical-z", "painter", "opengl"};
    return names[std::size_t(kind)];
}

/// Scenes have their light baked in, and coverage is wanted of their pictures: no light, no background.
struct RendererChoice {
    RendererKind kind = RendererKind::z_buffer;
    int samples = 1;  ///< a pixel: a square up to 64; of coverage masks 1 or 64
    bool culls_back_faces = false;
    bool far_field_by_area_law = false;  ///< of coverage masks: instead of FarCoverage::samples
    bool masks_by_table = false;         ///< of coverage masks at 64 samples: edges quantized, as in 1996
    bool maps_work = false;              ///< coverage masks tell where they visit cells, too, which takes time
    bool looks_on = false;               ///< what it drew can be seen from outside, which takes time and memory
    bool draws_hidden = false;           ///< of OpenGL: no z-buffer on the processor says what is hidden
    bool shapes_here = false;            ///< of OpenGL: stand-ins are shaped on the processor and sent, for comparison
    unsigned threads = 1;                ///< above 1: bands of the picture are drawn at once; without maps_work

    friend bool operator==(const RendererChoice&, const RendererChoice&) = default;
};

}  // namespace farfield::scenes
