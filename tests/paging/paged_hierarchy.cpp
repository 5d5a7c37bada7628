#include "farfield/paging/paged_hierarchy.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "catch.hpp"
#include "farfield/approximation/color_cube.hpp"
#include "farfield/approximation/opacity_tensor.hpp"
#include "farfield/approximation/sample_set.hpp"
#include "farfield/build.hpp"
#include "farfield/cost_model/triangle_count.hpp"
#include "farfield/paging/write_pages.hpp"
#include "farfield/partition/octree.hpp"
#include "farfield/renderer/z_buffer_renderer.hpp"
#include "farfield/viewer.hpp"
#include "support/pictures.hpp"
#include "support/scenes.hpp"
#include "support/views.hpp"

using namespace farfield;
using namespace farfield::test;

namespace {

struct Memory {
    std::vector<std::byte> bytes;
    std::uint64_t size() const noexcept { return bytes.size(); }
    ReadMerging merging() const noexcept { return {}; }
    ReadResult read(std::uint64_t offset, std::span<std::byte> to) noexcept {
        if (offset > bytes.size() || to.size() > bytes.size() - offset)
            return {ReadStatus::refused, "memory: beyond its end"};
        std::memcpy(to.data(), bytes.data() + offset, to.size());
        return {};
    }
};

using Tensors = SpatialHierarchy<Octree, OpacityTensor, TriangleCount>;

View view_at(float distance, float tolerance) {
    return looking(glm::dvec3(0.3, 0.4, 1.0) * double(distance), glm::dvec3(0), 160, tolerance);
}

}  // namespace

TEST_CASE("What lies in pages is drawn as what lies in memory, once it is there") {
    const Triangles scene = mixed_triangles(20000, 7);
    const auto h = build<Tensors>(scene);
    const auto source = std::make_shared<Memory>(Memory{paged<Tensors, Triangle>(h, scene, {.page_bytes = 4096})});
    auto pages = open_pages_of<Tensors, Triangle>(source, "memory", {.loads_in_background = false});
    pages.wait_for_pages(true);
    ZBufferRenderer renderer({.samples = 4}), paged_renderer({.samples = 4});
    auto viewer = make_viewer(h, scene, renderer);
    auto paged_viewer = make_viewer(pages, paged_renderer);
    for (const float distance : {0.2f, 1.0f, 3.0f, 10.0f, 40.0f}) {
        for (const float tolerance : {0.0f, 1.0f, 4.0f}) {
            const View v = view_at(distance, tolerance);
            const FrameStats a = viewer.frame(v);
            const FrameStats b = paged_viewer.frame(v);
            INFO(distance << " " << tolerance << " pages " << pages.page_count());
            CHECK(b.cells_missing == 0);
            CHECK(b.primitives <= a.primitives);  // those of cells beyond the frustum are in runs with others in memory
            CHECK(a.approximations == b.approximations);
            CHECK(different_pixels(renderer.image(), paged_renderer.image()) <= 3);
        }
    }
}
