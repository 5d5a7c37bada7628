// A directional light on surfaces that are lit on the side that faces it.
#pragma once

#include "farfield/settings.hpp"

#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <optional>

#include "farfield/geometry/length.hpp"
#include "farfield/geometry/polygon.hpp"
#include "farfield/geometry/rgba8.hpp"

namespace farfield {

/// Lambert's law with an ambient part: brightness = ambient + diffuse * max(0, cosine). A polygon has two sides of
/// different brightness; which one is seen decides. Stand-ins have the light of their build baked in: a light that
/// moves afterwards, or an instance that is turned against it, changes geometry but not stand-ins.
struct DirectionalLight {
    glm::vec3 towards{0.30f, 0.90f, 0.32f};  ///< from the scene to the light; any length but 0
    float ambient = 0.35f;
    float diffuse = 0.65f;
    friend bool operator==(const DirectionalLight&, const DirectionalLight&) = default;

    /// `facing_viewer` is the polygon's normal turned to the side that is seen, any length; brightness in [0, 1] for
    /// ambient + diffuse <= 1. A polygon without a normal gets the ambient part.
    float brightness(glm::vec3 facing_viewer) const {
        float squares = glm::dot(facing_viewer, facing_viewer) * glm::dot(towards, towards);
        glm::vec3 normal = facing_viewer, light = towards;
        if (!detail::squares_are_exact(squares)) {
            normal = scaled_to_one(normal);
            light = scaled_to_one(light);
            squares = glm::dot(normal, normal) * glm::dot(light, light);
        }
        const float cosine = squares > 0 ? glm::dot(normal, light) / std::sqrt(squares) : 0.0f;
        return ambient + diffuse * (cosine > 0 ? cosine : 0.0f);
    }
};

/// What is wrong with a light, or null.
inline const char* wrong_light(const DirectionalLight& light) {
    const float sum = light.towards.x * 0 + light.towards.y * 0 + light.towards.z * 0;
    if (light.towards == glm::vec3(0) || sum != 0) return "DirectionalLight: towards must be finite and not 0";
    if (!(light.ambient >= 0 && std::isfinite(light.ambient)))
        return "DirectionalLight: ambient must be 0 or more and finite";
    if (!(light.diffuse >= 0 && std::isfinite(light.diffuse)))
        return "DirectionalLight: diffuse must be 0 or more and finite";
    return nullptr;
}

/// The factor that a light, if there is one, gives to a polygon's colors on the side with this normal (any length): 1
/// where they hold the light already.
inline float brightness_of(const std::optional<DirectionalLight>& light, const Polygon& polygon,
                           glm::vec3 facing_viewer) {
    return light && !polygon.is_lit ? light->brightness(facing_viewer) : 1.0f;
}

/// A color times a brightness; alpha stays.
inline Rgba8 scaled(Rgba8 c, float brightness) {
    const auto channel = [brightness](std::uint8_t v) {
        const float lit = float(v) * brightness + 0.5f;
        return static_cast<std::uint8_t>(lit < 255.0f ? lit : 255.0f);
    };
    return {channel(c.r), channel(c.g), channel(c.b), c.a};
}

}  // namespace farfield
