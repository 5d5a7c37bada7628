#include "scenes/paged_origin.hpp"

#include <cmath>
#include <fstream>
#include <limits>
#include <stdexcept>
#include <string>

namespace farfield::scenes {
namespace {

std::filesystem::path beside(std::filesystem::path pages) {
    pages += ".origin";
    return pages;
}

}  // namespace

void keep_origin(const std::filesystem::path& pages, glm::dvec3 origin) {
    const std::filesystem::path file = beside(pages);
    // What an earlier scene has left behind.
    std::filesystem::remove(file);
    if (origin == glm::dvec3(0)) return;
    std::ofstream out(file);
    out.precision(std::numeric_limits<double>::max_digits10);
    out << origin.x << ' ' << origin.y << ' ' << origin.z << '\n';
    out.close();
    if (!out) throw std::runtime_error(file.string() + ": cannot be written");
}

glm::dvec3 kept_origin(const std::filesystem::path& pages) {
    const std::filesystem::path file = beside(pages);
    if (!std::filesystem::exists(file)) return glm::dvec3(0);
    std::ifstream in(file);
    glm::dvec3 origin(0);
    std::string more;
    in >> origin.x >> origin.y >> origin.z;
    const bool holds_three = !in.fail() && !(in >> more);
    if (!holds_three || !std::isfinite(origin.x) || !std::isfinite(origin.y) || !std::isfinite(origin.z))
        throw std::runtime_error(file.string() + ": is not an origin of three finite numbers");
    return origin;
}

}  // namespace farfield::scenes
