// The picture of the page on opacity tensors: a closed surface far away and off its axis, where six faces tear and
// swell. From left to right every triangle at 64 samples a pixel, color cubes, opacity tensors; both of cells of 1
// pixel, one sample a pixel. Pixels are shown as squares, over a color that the bust does not have: where it shines
// through, it is torn.
//
//   bench_bust_picture bench/figures/opacity_tensor.png
#include <algorithm>
#include <exception>
#include <iostream>
#include <span>
#include <vector>

#include "farfield/approximation/color_cube.hpp"
#include "farfield/approximation/exact.hpp"
#include "farfield/approximation/opacity_tensor.hpp"
#include "farfield/build.hpp"
#include "farfield/measure/projected_rect.hpp"
#include "report/picture.hpp"
#include "scenes/generate/gallery.hpp"
#include "support/subject.hpp"

namespace farfield::bench {
namespace {

constexpr int zoom = 4, margin_px = 3;
constexpr Rgba8 background{255, 0, 255, 255}, paper{255, 255, 255, 255};

template <class Approximation>
Image drawn(std::vector<Triangle> triangles, const View& view, const Approximation& approximation, int samples) {
    using Hierarchy = SpatialHierarchy<Octree, Approximation, TriangleCount>;
    const auto hierarchy = build_in_place<Hierarchy>(triangles, {.approximation = approximation});
    ZBufferRenderer renderer({.samples = samples, .culls_back_faces = true});
    auto viewer = make_viewer(hierarchy, triangles, renderer);
    viewer.frame(view);
    return report::over_background(renderer.image(), {background, background});
}

/// Side by side, enlarged, with a line of paper between.
Image panels(std::span<const Image> images, const PixelRect& part) {
    constexpr int gap = 2 * zoom;
    const int width = zoom * part.width();
    Image result(int(images.size()) * (width + gap) - gap, zoom * part.height());
    std::fill(result.pixels().begin(), result.pixels().end(), paper);
    for (std::size_t i = 0; i < images.size(); ++i) {
        for (int y = 0; y < result.height(); ++y) {
            for (int x = 0; x < width; ++x) {
                result.at(int(i) * (width + gap) + x, y) = images[i].at(part.x0 + x / zoom, part.y0 + y / zoom);
            }
        }
    }
    return result;
}

void write(const char* file) {
    const std::vector<Triangle> bust = scenes::bust({.side_quads = 163});
    Box bounds = Box::empty();
    for (const Triangle& t : bust) bounds.add(t.bounds());
    const View view = table_view(bounds, 14, 45, 512);
    const Image images[] = {drawn(bust, view, Exact{}, 64), drawn(bust, view, ColorCube{}, 1),
                            drawn(bust, view, OpacityTensor{.closed_surfaces = true}, 1)};
    PixelRect part = projected_rect(bounds, view).value();
    part = {part.x0 - margin_px, part.y0 - margin_px, part.x1 + margin_px, part.y1 + margin_px};
    report::write_png(panels(images, part), file);
}

}  // namespace
}  // namespace farfield::bench

int main(int argc, char** argv) {
    if (argc != 2) {
        std::cerr << "usage: " << argv[0] << " FILE.png\n";
        return 2;
    }
    try {
        farfield::bench::write(argv[1]);
    } catch (const std::exception& e) {
        std::cerr << e.what() << '\n';
        return 1;
    }
}
