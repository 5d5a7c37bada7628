// Stand-ins have the light of their build in their colors; the renderer lights primitives. A picture of both needs one
// light.
#pragma once

#include "farfield/settings.hpp"

#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>
#include <optional>
#include <stdexcept>
#include <string>

#include "farfield/fail.hpp"
#include "farfield/geometry/length.hpp"
#include "farfield/geometry/light.hpp"
#include "farfield/spatial_hierarchy.hpp"

namespace farfield::detail {

/// Whether two directions, of any length, are one up to rounding.
inline bool is_direction(const glm::dvec3& a, const glm::dvec3& b) {
    return glm::dot(direction_of(a), direction_of(b)) > 1 - 0x1p-20;
}

inline std::string name_of_light(const DirectionalLight& l) {
    return "towards (" + std::to_string(l.towards.x) + ", " + std::to_string(l.towards.y) + ", " +
           std::to_string(l.towards.z) + "), ambient " + std::to_string(l.ambient) + ", diffuse " +
           std::to_string(l.diffuse);
}

/// Throws std::invalid_argument, whose text begins with `who`, if a hierarchy has stand-ins that are known to have
/// another light than `drawn`. `turned` is how the hierarchy lies in the outermost one: instances may be built with
/// the light as it comes from outside, or as it comes in their own axes. (Those turned otherwise keep stand-ins that
/// are lit from elsewhere, which no one light could mend.)
template <class H>
void check_light(const char* who, const H& h, const std::optional<DirectionalLight>& drawn, const glm::mat3& turned) {
    const HierarchyFacts& facts = h.facts();
    if (h.stand_ins().empty() || facts.baked_light == BakedLight::unknown) return;
    const bool is_baked = facts.baked_light == BakedLight::directional;
    if (!is_baked && !drawn) return;
    if (is_baked && drawn && facts.light.ambient == drawn->ambient && facts.light.diffuse == drawn->diffuse) {
        const glm::dvec3 baked(facts.light.towards), given(drawn->towards);
        if (is_direction(baked, given) || is_direction(glm::dmat3(turned) * baked, given)) return;
    }
    detail::fail<std::invalid_argument>(
        std::string(who) + "'s stand-ins were built " +
        (is_baked ? "with a light " + name_of_light(facts.light) : std::string("without a light")) +
        " and the renderer has " + (drawn ? "one " + name_of_light(*drawn) : std::string("none")) +
        ": give the build's options the same, as .sampler = light");
}

}  // namespace farfield::detail
