// Tells how far a picture of a browser is from one of ours, as JSON on one line:
//
//     farfield_compare PICTURE.pam REFERENCE.pam
#include <algorithm>
#include <cstddef>
#include <exception>
#include <iostream>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>

#include "farfield/measure/flip.hpp"
#include "farfield/measure/pixel_rect.hpp"
#include "pictures.hpp"
#include "report/picture.hpp"

namespace {

/// What the reference shows, with a margin of as many pixels as an eye's filters reach.
farfield::PixelRect shown(const farfield::Image& image) {
    farfield::PixelRect rect{image.width(), image.height(), 0, 0};
    for (int y = 0; y < image.height(); ++y) {
        for (int x = 0; x < image.width(); ++x) {
            if (image.at(x, y).a == 0) continue;
            rect = {std::min(rect.x0, x), std::min(rect.y0, y), std::max(rect.x1, x + 1), std::max(rect.y1, y + 1)};
        }
    }
    constexpr int margin = 4;
    return {std::max(rect.x0 - margin, 0), std::max(rect.y0 - margin, 0), std::min(rect.x1 + margin, image.width()),
            std::min(rect.y1 + margin, image.height())};
}

double covered(const farfield::Image& image) {
    double sum = 0;
    for (const farfield::Rgba8 c : image.pixels()) sum += c.a / 255.0;
    return sum;
}

}  // namespace

int main(int argc, char** argv) {
    try {
        if (argc != 3) throw std::invalid_argument("usage: farfield_compare PICTURE.pam REFERENCE.pam");
        const farfield::Image picture = farfield_export::read_pam(argv[1]), own = farfield_export::read_pam(argv[2]);
        if (picture.width() != own.width() || picture.height() != own.height())
            throw std::invalid_argument("the pictures are of different sizes");
        if (!(covered(own) > 0)) throw std::invalid_argument("the reference shows nothing");
        const farfield::PixelRect rect = shown(own);
        const farfield::Image a = farfield::report::over_background(picture, {}),
                              b = farfield::report::over_background(own, {});
        std::cout << nlohmann::json{{"flip", farfield::flip(a, b, rect)},
                                    {"flip_of_whole_picture", farfield::flip(a, b)},
                                    {"coverage", covered(picture) / covered(own)}}
                  << "\n";
        return 0;
    } catch (const std::exception& error) {
        std::cerr << "farfield_compare: " << error.what() << "\n";
        return 2;
    }
}
