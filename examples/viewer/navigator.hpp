// Moves a camera as people expect of a program that shows models: around a point, along the picture, towards what the
// cursor is on, and on foot. It knows of no window: distances on the screen are in heights of the picture.
#pragma once

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <numbers>
#include <optional>

#include "farfield/camera.hpp"
#include "farfield/geometry/box.hpp"

namespace viewer {

class Navigator {
  public:
    static constexpr float field_of_view = std::numbers::pi_v<float> / 3;

    Navigator() = default;
    /// `up` is a unit vector along an axis.
    Navigator(const farfield::BoxD& bounds, glm::dvec3 up) : bounds_(bounds), up_(up) {
        // A point is looked at from one unit away, or from as far as its coordinates tell apart.
        const glm::dvec3 center = bounds.center();
        const double place = std::max({std::abs(center.x), std::abs(center.y), std::abs(center.z)});
        radius_ = std::max(0.5 * glm::length(bounds.size()), 0x1p-20 * place);
        if (!(radius_ > 0)) radius_ = 1;
        const glm::dvec3 other = std::abs(up.x) < 0.9 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0);
        front_ = glm::cross(other, up_);
        side_ = glm::cross(up_, front_);
        reset();
    }

    farfield::Camera camera() const {
        return farfield::Camera::perspective(eye(), target_, glm::vec3(upright()), field_of_view);
    }
    glm::dvec3 eye() const { return target_ - forward() * distance_; }
    glm::dvec3 target() const { return target_; }
    double distance() const { return distance_; }
    /// Of the sphere around the scene.
    double radius() const { return radius_; }

    /// Turns about the target. A drag across the picture's height is half a turn.
    void orbit(glm::dvec2 by) { turn(by * std::numbers::pi); }
    /// Turns about the eye: what is looked at follows the mouse.
    void look(glm::dvec2 by) {
        const glm::dvec3 stays = eye();
        turn(-by * double(field_of_view));
        target_ = stays + forward() * distance_;
    }
    /// What lies at the target's depth follows the mouse.
    void pan(glm::dvec2 by) {
        const double height = 2 * std::tan(0.5 * double(field_of_view)) * distance_;
        target_ += (upright() * by.y - right() * by.x) * height;
    }
    /// Towards what lies `at` in the picture, in heights from its middle, y up, or away where steps are negative. The
    /// point there stays where it is on the screen. `depth` is how deep it lies; 0: as deep as the target.
    void zoom(double steps, glm::dvec2 at, double depth = 0) {
        if (!(depth > 0)) depth = distance_;
        const double factor = std::pow(0.85, steps), height = 2 * std::tan(0.5 * double(field_of_view)) * depth;
        const glm::dvec3 from = eye(), point = from + forward() * depth + (right() * at.x + upright() * at.y) * height;
        const double left = std::clamp(depth * factor, least_distance(), most_distance());
        const glm::dvec3 to = point + (from - point) * (left / depth);
        distance_ = left;
        target_ = to + forward() * distance_;
    }
    /// Goes so many steps to the right, up and ahead. A step is a part of how far the target is away, but not of less
    /// than a thousandth of the scene.
    void walk(glm::dvec3 steps) {
        const double step = std::max(distance_, 1e-3 * radius_);
        target_ += (right() * steps.x + up_ * steps.y + forward() * steps.z) * step;
    }

    /// All of the scene, seen from where one looks now.
    void frame() {
        target_ = bounds_.center();
        distance_ = radius_ / std::sin(0.5 * double(field_of_view));
    }
    /// As at first: from the front, a little from above, unless start_at() said otherwise.
    void reset() {
        if (starts_at_) {
            distance_ = std::max(glm::length(bounds_.center() - starts_at_->eye), least_distance());
            follow(*starts_at_);
            return;
        }
        angle_ = 0.4;
        elevation_ = 0.35;
        frame();
    }
    void start_at(const farfield::Camera& camera) {
        starts_at_ = camera;
        reset();
    }
    /// Goes on from another camera, which looks at something as far away as the target was.
    void follow(const farfield::Camera& camera) {
        const glm::dvec3 f(camera.forward);
        elevation_ = std::clamp(std::asin(std::clamp(-glm::dot(f, up_), -1.0, 1.0)), -steepest, steepest);
        angle_ = std::atan2(-glm::dot(f, side_), -glm::dot(f, front_));
        target_ = camera.eye + forward() * distance_;
    }

    glm::dvec3 forward() const {
        return -(front_ * std::cos(angle_) + side_ * std::sin(angle_)) * std::cos(elevation_) -
               up_ * std::sin(elevation_);
    }

  private:
    /// Straight up and down there is no horizon to keep level.
    static constexpr double steepest = 0.499 * std::numbers::pi;

    double least_distance() const { return 1e-5 * radius_; }
    double most_distance() const { return 1e4 * radius_; }
    glm::dvec3 right() const { return side_ * std::cos(angle_) - front_ * std::sin(angle_); }
    glm::dvec3 upright() const { return glm::cross(right(), forward()); }
    void turn(glm::dvec2 by) {
        angle_ = std::remainder(angle_ - by.x, 2 * std::numbers::pi);
        elevation_ = std::clamp(elevation_ - by.y, -steepest, steepest);
    }

    farfield::BoxD bounds_{glm::dvec3(-1), glm::dvec3(1)};
    glm::dvec3 up_{0, 1, 0}, front_{0, 0, 1}, side_{1, 0, 0};
    double radius_ = 1;
    std::optional<farfield::Camera> starts_at_{};
    glm::dvec3 target_{0.0};
    double distance_ = 3, angle_ = 0, elevation_ = 0;  ///< of the eye, off the front and above the ground
};

}  // namespace viewer
