// A renderer of your own that keeps images (ImageCache). It draws dots: triangles as one, images as many.
#include <iostream>

#include "farfield/farfield.hpp"
using namespace farfield;

struct Dots {
    static constexpr RendererFacts facts{.keeps_images = true};
    using Pixels = std::vector<std::pair<float, Rgba8>>;  // inverse depth, 0 where nothing is, and color
    std::vector<std::pair<int, Pixels>> pictures{1};      // widths, pixels: the frame's, and images' by handle
    std::size_t target = 0;                               // what is drawn into
    LocalView view{View{}, {}, 1};                        // of what comes next

    void set_view(const LocalView& v) { view = v; }
    void begin_frame(const LocalView& v) { pictures[target] = {v.width, Pixels(std::size_t(v.width * v.height))}; }
    void end_frame() {}
    void begin_image(const LocalView& v, float, int) {
        target = pictures.size(), pictures.emplace_back(), begin_frame(v);
    }
    std::uint32_t end_image() { return std::uint32_t(std::exchange(target, 0)); }
    void free_image(std::uint32_t image) { pictures[image] = {}; }
    std::size_t image_bytes(int width, int height) const { return 8 * std::size_t(width * height); }
    void draw(const auto& source, std::span<const Range> ranges) {
        for (const Range& r : ranges)
            for (auto i = r.first; i < r.first + r.count; ++i)
                source.polygons(i, [&](const Polygon& p) { plot(p.vertices[0], p.colors[0]); });
    }
    void draw(std::span<const ImageQuad> quads) {
        for (const ImageQuad& q : quads)
            for (std::size_t i = 0; i < pictures[q.image].second.size(); ++i) {
                const auto& [width, pixels] = pictures[q.image];
                const glm::vec2 size(width, int(pixels.size()) / width);
                const glm::vec2 at = (glm::vec2(int(i) % width, int(i) / width) + 0.5f) / size;
                if (pixels[i].first > 0) plot(q.corner + q.across * at.x + q.down * at.y, pixels[i].second);
            }
    }
    void plot(glm::vec3 p, Rgba8 color) {
        const glm::vec3 d = p - view.eye, in_view(glm::dot(d, view.right), -glm::dot(d, view.up), view.depth(p));
        const glm::vec2 size(view.width, view.height), off(-view.off_center.x, view.off_center.y);
        const glm::vec2 at = 0.5f * size * (1.0f + off) + glm::vec2(in_view) * (view.focal_px / in_view.z);
        if (in_view.z <= 0 || at.x < 0 || at.y < 0 || at.x >= size.x || at.y >= size.y) return;
        auto& [nearness, shown] = pictures[target].second[std::size_t(int(at.y) * view.width + int(at.x))];
        if (1 / in_view.z > nearness) nearness = 1 / in_view.z, shown = color;
    }
};

int main() {
    const auto at = [](double t) { return glm::vec3(std::sin(37 * t), std::sin(53 * t), std::sin(71 * t)); };
    std::vector<Triangle> cloud;
    for (int i = 0; i < 300'000; ++i) cloud.push_back({{at(i), at(i + 0.001), at(i + 0.002)}, {200, 120, 60}});
    const auto hierarchy = build<SpatialHierarchy<GapBsp, ImageCache<Exact>, MeasuredTime>>(cloud);
    Dots dots;
    auto viewer = make_viewer(hierarchy, cloud, dots);
    for (const double x : {0.0, 0.01, 0.02, 1.0}) {
        const auto stats = viewer.frame({.camera = Camera::perspective({x, 1, 4}, {0, 0, 0}, {0, 1, 0}, 0.8f)});
        std::cout << stats.primitives << " triangles and " << stats.images << " images drawn\n";
    }
}
