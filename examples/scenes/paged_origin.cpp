#include "scenes/paged_origin.hpp"

#include <cmath>
#include <limits>
#include <sstream>
#include <stdexcept>

namespace farfield::scenes {
namespace {
constexpr const char* name = "origin";
}

Notes notes_of_origin(glm::dvec3 origin) {
    if (origin == glm::dvec3(0)) return {};
    std::ostringstream out;
    out.precision(std::numeric_limits<double>::max_digits10);
    out << origin.x << ' ' << origin.y << ' ' << origin.z << '\n';
    return {{name, out.str()}};
}

glm::dvec3 origin_in(const Notes& notes, const std::string& file) {
    const auto note = notes.find(name);
    if (note == notes.end()) return glm::dvec3(0);
    std::istringstream in(note->second);
    glm::dvec3 origin(0);
    std::string more;
    in >> origin.x >> origin.y >> origin.z;
    const bool holds_three = !in.fail() && !(in >> more);
    if (!holds_three || !std::isfinite(origin.x) || !std::isfinite(origin.y) || !std::isfinite(origin.z))
        throw std::runtime_error(file + ": its note 'origin' is not one of three finite numbers");
    return origin;
}

}  // namespace farfield::scenes
