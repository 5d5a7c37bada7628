// Gives a light of the outermost hierarchy in the axes of the instances inside it.
#pragma once

#include "farfield/settings.hpp"

#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <optional>
#include <stdexcept>
#include <string>

#include "farfield/fail.hpp"
#include "farfield/geometry/light.hpp"
#include "farfield/view/local_view.hpp"

namespace farfield::detail {

class LightInView {
  public:
    /// Throws std::invalid_argument for a light without a direction, or one that is negative or not finite.
    explicit LightInView(const std::optional<DirectionalLight>& light) : given_(light) {
        if (const char* why = light ? wrong_light(*light) : nullptr)
            detail::fail<std::invalid_argument>(std::string("farfield::") + why);
    }

    /// Takes the outermost hierarchy's view.
    void begin_frame(const LocalView& view) {
        if (!given_) return;
        const glm::vec3 l = given_->towards;
        in_view_ = {glm::dot(l, view.right), glm::dot(l, view.up), glm::dot(l, view.forward)};
    }
    void set_view(const LocalView& view) {
        if (!given_) return;
        light_ = *given_;
        light_.towards = view.right * in_view_.x + view.up * in_view_.y + view.forward * in_view_.z;
    }
    /// The light in the axes of the view set last, or null if there is none.
    const DirectionalLight* light() const { return given_ ? &light_ : nullptr; }

  private:
    std::optional<DirectionalLight> given_;
    DirectionalLight light_;
    glm::vec3 in_view_{0};
};

}  // namespace farfield::detail
