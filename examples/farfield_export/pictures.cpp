#include "pictures.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <fstream>
#include <glm/geometric.hpp>
#include <ios>
#include <nlohmann/json.hpp>
#include <stdexcept>

namespace farfield_export {
namespace {

constexpr float fov = 0.8f;
constexpr int width = 640, height = 480;

}  // namespace

std::vector<NamedView> views_of(const farfield::BoxD& box) {
    const double radius = std::max(0.5 * glm::length(box.size()), 1e-30), tangent = std::tan(0.5 * double(fov));
    const glm::dvec3 direction = glm::normalize(glm::dvec3(0.55, 0.35, 0.76));
    const auto from = [&](const char* name, double distance) {
        farfield::View view;
        view.camera = farfield::Camera::perspective(box.center() + direction * distance, box.center(), {0, 1, 0}, fov);
        view.width = width;
        view.height = height;
        return NamedView{name, view};
    };
    return {from("far", 16 * radius / tangent), from("whole", 1.05 * radius / std::sin(0.5 * double(fov))),
            from("near", 0.9 * radius)};
}

std::string json_of(const std::vector<NamedView>& views, glm::dvec3 origin) {
    nlohmann::json out = nlohmann::json::array();
    for (const auto& [name, view] : views) {
        const farfield::Camera& c = view.camera;
        const auto numbers = [](auto v) { return nlohmann::json{double(v.x), double(v.y), double(v.z)}; };
        out.push_back({{"name", name},
                       {"eye", numbers(c.eye + origin)},
                       {"target", numbers(c.eye + origin + glm::dvec3(c.forward))},
                       {"up", numbers(c.up)},
                       {"fov", 2 * std::atan(double(c.half_height))},
                       {"width", view.width},
                       {"height", view.height}});
    }
    return out.dump();
}

void write_pam(const farfield::Image& image, const std::filesystem::path& file) {
    std::ofstream out(file, std::ios::binary);
    out << "P7\nWIDTH " << image.width() << "\nHEIGHT " << image.height()
        << "\nDEPTH 4\nMAXVAL 255\nTUPLTYPE RGB_ALPHA\nENDHDR\n";
    out.write(reinterpret_cast<const char*>(image.pixels().data()), std::streamsize(image.pixels().size_bytes()));
    out.close();
    if (!out) throw std::runtime_error(file.string() + ": cannot be written");
}

farfield::Image read_pam(const std::filesystem::path& file) {
    std::ifstream in(file, std::ios::binary);
    std::string word;
    int w = 0, h = 0, depth = 0, most = 0;
    in >> word;
    if (!in || word != "P7") throw std::runtime_error(file.string() + ": is no PAM picture");
    while (in >> word && word != "ENDHDR") {
        if (word == "WIDTH") in >> w;
        if (word == "HEIGHT") in >> h;
        if (word == "DEPTH") in >> depth;
        if (word == "MAXVAL") in >> most;
        if (word == "TUPLTYPE") in >> word;
    }
    if (!in || w < 1 || h < 1 || w > 16384 || h > 16384 || depth != 4 || most != 255) {
        throw std::runtime_error(file.string() + ": is no PAM picture of four channels of eight bits");
    }
    in.get();
    farfield::Image image(w, h);
    in.read(reinterpret_cast<char*>(image.pixels().data()), std::streamsize(image.pixels().size_bytes()));
    if (!in) throw std::runtime_error(file.string() + ": is cut short");
    return image;
}

}  // namespace farfield_export
