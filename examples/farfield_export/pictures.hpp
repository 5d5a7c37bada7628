// Views that a browser is to show as we do, and pictures as files that keep opacities.
#pragma once

#include <filesystem>
#include <glm/vec3.hpp>
#include <string>
#include <vector>

#include "farfield/geometry/box.hpp"
#include "farfield/image.hpp"
#include "farfield/view.hpp"

namespace farfield_export {

struct NamedView {
    std::string name;
    farfield::View view;
};

/// Of a scene in this box, in the user's coordinates, y up: `far`, where it takes a sixteenth of the picture's height,
/// `whole`, and `near`, from beside it. They are drawn within a tolerance of one pixel.
std::vector<NamedView> views_of(const farfield::BoxD& box);

/// What the page makes cameras from: the same from eyes that lie farther from zero by `origin`.
std::string json_of(const std::vector<NamedView>& views, glm::dvec3 origin);

/// PAM (netpbm's P7) with opacities, colors premultiplied. Both throw std::runtime_error that names the file.
void write_pam(const farfield::Image& image, const std::filesystem::path& file);
farfield::Image read_pam(const std::filesystem::path& file);

}  // namespace farfield_export
