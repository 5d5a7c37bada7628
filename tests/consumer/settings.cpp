// A program of an engine: built with one of its settings after the other, and the same pictures must come out. See
// settings.cmake.
#if defined(WITH_ENGINE_MACROS)
#include <glm/glm.hpp>  // not ours to keep from them

#include "engine_macros.hpp"
#endif
#include "farfield/farfield.hpp"

// A second file that includes everything, linked with this one.
int farfield_in_another_file();

namespace {

using farfield::Camera;
using farfield::Exact;
using farfield::Image;
using farfield::Instance;
using farfield::Nested;
using farfield::Octree;
using farfield::OpacityTensor;
using farfield::PolygonBsp;
using farfield::Rgba8;
using farfield::SpatialHierarchy;
using farfield::Triangle;
using farfield::TriangleCount;

/// FNV-1a of all pictures and of what is stored.
class Sum {
  public:
    void add(const Image& image) {
        for (const Rgba8 c : image.pixels()) {
            for (const unsigned byte : {c.r, c.g, c.b, c.a}) sum_ = (sum_ ^ byte) * 0x100000001b3u;
            seen_ += c.a != 0;
        }
    }
    bool is_empty() const { return seen_ == 0; }
    unsigned long long value() const { return sum_; }

  private:
    std::uint64_t sum_ = 0xcbf29ce484222325u;
    std::size_t seen_ = 0;
};

/// Leaves of a ball.
std::vector<Triangle> leaves(unsigned count) {
    std::vector<Triangle> all;
    std::uint32_t state = 1;
    const auto number = [&] {
        state = state * 1664525u + 1013904223u;
        return float(state >> 8) * 0x1p-23f - 1.0f;
    };
    const auto point = [&] {
        const float x = number(), y = number();
        return glm::vec3(x, y, number());
    };
    while (all.size() < count) {
        const glm::vec3 a = point(), b = a + 0.2f * point(), c = a + 0.2f * point();
        const auto green = std::uint8_t(150.0f + 80.0f * a.y);
        if (glm::dot(a, a) < 1.0f) all.push_back(Triangle{{a, b, c}, Rgba8{60, green, 40, 255}});
    }
    return all;
}

template <class Renderer, class H, class P>
void draw(const H& hierarchy, std::span<const P> primitives, float tolerance_px, Sum& sum) {
    Renderer renderer;
    auto viewer = farfield::make_viewer(hierarchy, primitives, renderer);
    const auto camera = Camera::perspective(glm::dvec3(3, 2, 5), glm::dvec3(0), glm::vec3(0, 1, 0), 0.8f);
    viewer.frame({.camera = camera, .width = 96, .height = 64, .tolerance_px = tolerance_px});
    sum.add(renderer.image());
}

template <class H>
H stored_and_opened(const H& hierarchy) {
    std::vector<std::byte> bytes(farfield::saved_size(hierarchy));
    farfield::save(hierarchy, std::span<std::byte>(bytes));
    return farfield::open<H>(std::span<const std::byte>(bytes));
}

}  // namespace

int main() {
    Sum sum;
    {
        using H = SpatialHierarchy<Octree, OpacityTensor, TriangleCount>;
        using Tree = Instance<H, Triangle>;
        const std::vector<Triangle> tree_leaves = leaves(600);
        const H tree = farfield::build<H>(tree_leaves);
        std::vector<Tree> trees;
        for (int i = 0; i < 9; ++i) {
            glm::dmat4 place(1.0);
            place[3] = glm::dvec4(2 * (i % 3) - 2, 0, 2 * (i / 3) - 2, 1);
            trees.push_back(Tree{&tree, tree_leaves, farfield::Similarity(place)});
        }
        H forest = farfield::build<H>(trees);
        if constexpr (farfield::vectors_are_packed) forest = stored_and_opened(forest);
        const std::span<const Tree> all(trees);
        draw<farfield::ZBufferRenderer>(forest, all, 4.0f, sum);
        draw<farfield::HierarchicalZRenderer>(forest, all, 4.0f, sum);
        draw<farfield::CoverageRenderer>(forest, all, 4.0f, sum);
    }
    {
        using H = SpatialHierarchy<Nested<Octree, PolygonBsp>, Exact, TriangleCount>;
        const std::vector<Triangle> triangles = leaves(100);
        const H hierarchy = farfield::build<H>(triangles);
        const std::span<const Triangle> all(triangles);
        draw<farfield::PainterRenderer>(hierarchy, all, 0.0f, sum);
        draw<farfield::StrictCoverageRenderer>(hierarchy, all, 0.0f, sum);
    }
    std::printf("%016llx\n", sum.value());
    return !sum.is_empty() && farfield_in_another_file() == FARFIELD_VERSION ? 0 : 1;
}
