#include "scenes/camera_path.hpp"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>
#include <glm/mat3x3.hpp>
#include <nlohmann/json.hpp>
#include <stdexcept>

namespace farfield::scenes {
namespace {

using Json = nlohmann::json;

glm::dquat rotation_of(const Camera& c) {
    return glm::quat_cast(glm::dmat3(glm::dvec3(c.right), glm::dvec3(c.up), -glm::dvec3(c.forward)));
}

/// The same camera with axes that are square and of length 1 in single precision.
Camera with_axes(Camera camera, glm::dvec3 forward, glm::dvec3 up) {
    const glm::dvec3 right = glm::cross(forward, up);
    const double lengths = glm::length(forward) * glm::length(up);
    if (!(glm::length(right) > 1e-6 * lengths) || !std::isfinite(lengths)) {
        throw std::invalid_argument("forward and up span no plane");
    }
    const glm::dvec3 f = glm::normalize(forward), r = glm::normalize(right);
    camera.forward = glm::vec3(f);
    camera.right = glm::vec3(r);
    camera.up = glm::vec3(glm::cross(r, f));
    camera.validate();
    return camera;
}

Json json_of(glm::dvec3 v) {
    return {v.x, v.y, v.z};
}

glm::dvec3 vector_of(const Json& json) {
    const auto numbers = json.get<std::vector<double>>();
    if (numbers.size() != 3) throw std::invalid_argument("a vector has three numbers");
    return {numbers[0], numbers[1], numbers[2]};
}

CameraPath::Stop stop_of(const Json& json) {
    CameraPath::Stop stop;
    stop.seconds = json.at("seconds").get<double>();
    stop.camera.eye = vector_of(json.at("eye"));
    if (json.contains("half_height")) stop.camera.half_height = json.at("half_height").get<float>();
    stop.camera = with_axes(stop.camera, vector_of(json.at("forward")), vector_of(json.at("up")));
    return stop;
}

}  // namespace

Camera CameraPath::at(double seconds) const {
    const auto after = std::upper_bound(stops.begin(), stops.end(), seconds,
                                        [](double s, const Stop& stop) { return s < stop.seconds; });
    if (after == stops.begin()) return stops.front().camera;
    if (after == stops.end()) return stops.back().camera;
    const Stop &a = after[-1], &b = *after;
    const double t = (seconds - a.seconds) / (b.seconds - a.seconds);
    const glm::dmat3 axes = glm::mat3_cast(glm::slerp(rotation_of(a.camera), rotation_of(b.camera), t));
    Camera camera = a.camera;
    camera.eye = glm::mix(a.camera.eye, b.camera.eye, t);
    camera.half_height = glm::mix(a.camera.half_height, b.camera.half_height, float(t));
    return with_axes(camera, -axes[2], axes[1]);
}

std::vector<Camera> CameraPath::cameras(int frames) const {
    std::vector<Camera> result;
    for (int i = 0; i < frames; ++i) {
        const double part = frames > 1 ? double(i) / (frames - 1) : 0;
        result.push_back(at(stops.front().seconds + part * (seconds() - stops.front().seconds)));
    }
    return result;
}

void write_camera_path(const CameraPath& path, const std::filesystem::path& file) {
    Json views = Json::array();
    for (const CameraPath::Stop& stop : path.stops) {
        views.push_back({{"seconds", stop.seconds},
                         {"eye", json_of(stop.camera.eye)},
                         {"forward", json_of(glm::dvec3(stop.camera.forward))},
                         {"up", json_of(glm::dvec3(stop.camera.up))},
                         {"half_height", stop.camera.half_height}});
    }
    std::ofstream out(file);
    out << Json{{"camera_path", 1}, {"views", views}}.dump(1) << "\n";
    if (!out.flush()) throw std::runtime_error("cannot write " + file.string());
}

CameraPath read_camera_path(const std::filesystem::path& file) {
    std::ifstream in(file);
    if (!in) throw std::runtime_error("cannot read " + file.string());
    CameraPath path;
    std::size_t view = 0;
    try {
        const Json json = Json::parse(in);
        if (json.at("camera_path") != 1) throw std::invalid_argument("camera_path is not 1");
        for (const Json& each : json.at("views")) {
            path.stops.push_back(stop_of(each));
            if (view > 0 && !(path.stops[view].seconds >= path.stops[view - 1].seconds)) {
                throw std::invalid_argument("it is earlier than the one before");
            }
            ++view;
        }
        if (path.is_empty()) throw std::invalid_argument("there are no views");
    } catch (const std::exception& error) {
        throw std::runtime_error(file.string() + " is no path of a camera: view " + std::to_string(view) + ": " +
                                 error.what());
    }
    return path;
}

}  // namespace farfield::scenes
