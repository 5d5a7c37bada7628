// Builds and draws a scene that bytes stand for, with every variant and every renderer of the walkthrough: it must not
// crash, and nothing may be lost. What is seen for certain is found by rays in double precision.
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <exception>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "fuzz/fuzz.hpp"
#include "fuzz/scene.hpp"
#include "scenes/built_scene.hpp"
#include "scenes/scene.hpp"
#include "walkthrough/variants.hpp"

namespace farfield::fuzz {
namespace {

using scenes::RendererChoice;
using scenes::RendererKind;

/// The depth along `forward` at which a line of sight meets the triangle.
std::optional<double> meets(const std::array<glm::dvec3, 3>& v, const glm::dvec3& from, const glm::dvec3& along,
                            const glm::dvec3& forward) {
    const glm::dvec3 normal = glm::cross(v[1] - v[0], v[2] - v[0]);
    const double slope = glm::dot(normal, along);
    if (!(std::abs(slope) > 1e-6 * glm::length(normal) * glm::length(along))) return std::nullopt;  // nearly edge on
    const double t = glm::dot(normal, v[0] - from) / slope;
    const glm::dvec3 p = from + t * along;
    const double whole = glm::dot(normal, normal);
    for (int i = 0; i < 3; ++i) {
        const glm::dvec3 &a = v[std::size_t(i)], &b = v[std::size_t((i + 1) % 3)];
        if (!(glm::dot(glm::cross(b - a, p - a), normal) > 1e-9 * whole)) return std::nullopt;
    }
    return glm::dot(p - from, forward);
}

/// 1 for each pixel that one triangle covers for certain, with room for a quarter of a pixel around it and for what
/// rounding may move.
std::vector<char> certain_pixels(const scenes::Scene& flat, const Scene& scene, const View& view) {
    const Camera& c = view.camera;
    std::vector<char> certain(std::size_t(view.width) * std::size_t(view.height));
    // Points have coordinates along the axes, which are at right angles up to rounding: seen from far that is much.
    const glm::dvec3 axes[3] = {glm::dvec3(c.right), glm::dvec3(c.up), glm::dvec3(c.forward)};
    const glm::dmat3 dual = glm::inverse(glm::transpose(glm::dmat3(axes[0], axes[1], axes[2])));
    const glm::dvec3 right = dual[0], up = dual[1], forward = dual[2];
    double largest = scene.unit;
    for (const scenes::Scene* each : {&flat, &scene.scene}) {
        for (const auto& t : each->groups.front().triangles) {
            for (const glm::vec3& v : t.vertices) {
                for (int i = 0; i < 3; ++i) largest = std::max(largest, std::abs(double(v[i])));
            }
        }
    }
    const double pixel = 2 * double(c.half_height) / view.height;
    std::vector<std::array<glm::dvec3, 3>> triangles;
    for (const auto& t : flat.groups.back().triangles) {
        // In units of the scene, so that nothing leaves double precision.
        triangles.push_back({(glm::dvec3(t.vertices[0]) - c.eye) / scene.unit,
                             (glm::dvec3(t.vertices[1]) - c.eye) / scene.unit,
                             (glm::dvec3(t.vertices[2]) - c.eye) / scene.unit});
    }
    const bool is_perspective = c.projection == Projection::perspective;
    // A vertex may lie a few steps of single precision elsewhere, in the scene and, instances being moved, once more.
    const double blur = 8 * 0x1p-24 * largest / scene.unit;
    const double least_depth = double(c.near_depth) / scene.unit;
    for (int y = 0; y < view.height; ++y) {
        for (int x = 0; x < view.width; ++x) {
            for (const auto& t : triangles) {
                int met = 0;
                for (int corner = 0; corner < 4; ++corner) {
                    const double px = x + (corner & 1 ? 1.25 : -0.25) - 0.5 * view.width;
                    const double py = 0.5 * view.height - (y + (corner & 2 ? 1.25 : -0.25));
                    const double scale = is_perspective ? pixel : pixel / scene.unit;
                    const glm::dvec3 aside = scale * (px * right + py * up);
                    const glm::dvec3 from = is_perspective ? glm::dvec3(0) : aside;
                    const glm::dvec3 along = is_perspective ? forward + aside : forward;
                    const auto depth = meets(t, from, along, forward);
                    if (!depth) break;
                    if (is_perspective || least_depth > 0) {
                        if (!(*depth > 1.001 * least_depth + 4 * blur + 1e-5)) break;
                    }
                    // What blur moves on the screen must stay within the quarter of a pixel.
                    if (!(blur * 8 < scale * (is_perspective ? *depth : 1.0))) break;
                    ++met;
                }
                if (met == 4) {
                    certain[std::size_t(y) * std::size_t(view.width) + std::size_t(x)] = 1;
                    break;
                }
            }
        }
    }
    return certain;
}

[[noreturn]] void lost(const std::string& what) {
    throw std::logic_error(what);
}

std::string described(const Scene& scene, const View& view) {
    const Camera& c = view.camera;
    const auto power = [](double x) { return "2^" + std::to_string(x == 0 ? -9999 : std::ilogb(x)); };
    return std::string(c.projection == Projection::perspective ? "perspective" : "orthographic") + ", unit " +
           power(scene.unit) + ", off the origin by " + power(glm::length(scene.center) / scene.unit) + ", eye " +
           power(glm::length(c.eye - scene.center) / scene.unit) + " from the center, half height " +
           power(double(c.half_height)) + ", near depth " + power(double(c.near_depth) / scene.unit);
}

/// `cuts`: pieces of polygons leave gaps as wide as rounding is, which now and then hold a sample.
void check(const Image& image, const std::vector<char>& certain, const View& view, bool cuts, const std::string& who) {
    if (image.width() != view.width || image.height() != view.height) lost(who + ": a picture of another size");
    if (view.tolerance_px != 0) return;
    std::size_t missing = 0, at = 0;
    for (std::size_t i = 0; i < certain.size(); ++i) {
        if (!certain[i] || image.pixels()[i].a == 255) continue;
        ++missing;
        at = i;
    }
    if (missing == 0 || (cuts && missing <= 1 + certain.size() / 100)) return;
    lost(who + ": " + std::to_string(missing) + " pixels are not covered, the last at " +
         std::to_string(at % std::size_t(view.width)) + ", " + std::to_string(at / std::size_t(view.width)) +
         ", alpha " + std::to_string(image.pixels()[at].a));
}

}  // namespace

void run(std::span<const std::uint8_t> bytes) {
    Input in(bytes);
    const Scene scene = make_scene(in);
    const scenes::Scene flat = scenes::expanded(scene.scene);
    std::vector<View> views;
    for (int i = 0; i < 3; ++i) {
        try {
            views.push_back(make_view(in, scene));
        } catch (const std::invalid_argument&) {
        }
        if (in.is_empty()) break;
    }
    std::vector<std::vector<char>> certain;
    for (const View& view : views) certain.push_back(certain_pixels(flat, scene, view));
    for (const walkthrough::Variant& variant : walkthrough::variants()) {
        std::unique_ptr<scenes::BuiltScene> built;
        try {
            built = variant.build(scene.scene);
        } catch (const std::invalid_argument&) {
            continue;  // refused by name
        } catch (const std::length_error&) {
            continue;
        }
        for (const RendererKind kind : scenes::renderer_kinds) {
            if (!variant.obstacle(kind).empty()) continue;
            for (const int samples : {1, 64}) {
                std::unique_ptr<scenes::SceneViewer> viewer;
                try {
                    viewer = built->viewer({.kind = kind, .samples = samples});
                } catch (const std::invalid_argument&) {
                    continue;  // an order that was not kept, or samples that it does not take
                }
                for (std::size_t i = 0; i < views.size(); ++i) {
                    View view = views[i];
                    const std::string who = std::string(variant.name) + ", " + std::string(scenes::name_of(kind)) +
                                            ", " + std::to_string(samples) + " samples, view " + std::to_string(i) +
                                            " (" + described(scene, view) + ")";
                    view.distance = variant.distance;
                    for (const float tolerance : {view.tolerance_px, 0.0f}) {
                        view.tolerance_px = tolerance;
                        viewer->frame(view);
                        check(viewer->image(), certain[i], view, variant.name.find("bsp") != variant.name.npos, who);
                    }
                }
            }
        }
    }
}

}  // namespace farfield::fuzz
