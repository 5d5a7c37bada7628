#include "farfield/adapters/zstd_pages.hpp"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <vector>

#include "catch.hpp"
#include "farfield/approximation/opacity_tensor.hpp"
#include "farfield/build.hpp"
#include "farfield/cost_model/triangle_count.hpp"
#include "farfield/executor.hpp"
#include "farfield/paging/file_page_source.hpp"
#include "farfield/paging/open_pages.hpp"
#include "farfield/paging/pack_pages.hpp"
#include "farfield/paging/unpacked_pages.hpp"
#include "farfield/paging/write_pages.hpp"
#include "farfield/partition/octree.hpp"
#include "farfield/renderer/z_buffer_renderer.hpp"
#include "farfield/viewer.hpp"
#include "support/random.hpp"
#include "support/scenes.hpp"
#include "support/temporary_directory.hpp"
#include "support/views.hpp"

using namespace farfield;
using namespace farfield::test;

TEST_CASE("Zstd gives back what it has packed, and refuses what it has not") {
    const ZstdPages codec;
    Random random(3);
    std::vector<std::byte> page(65536), packed(65536), again(65536);
    for (std::size_t i = 0; i < page.size(); ++i) page[i] = std::byte(i % 100 < 40 ? random.below(256) : 0);
    const std::size_t size = codec.pack(page, packed);
    REQUIRE(size > 0);
    CHECK(size < page.size());
    CHECK(codec.unpack(std::span(packed).first(size), again));
    CHECK(again == page);
    // Too short, too long, and nothing at all.
    CHECK_FALSE(codec.unpack(std::span(packed).first(size - 1), again));
    CHECK_FALSE(codec.unpack(std::span(packed).first(size), std::span(again).first(again.size() - 1)));
    CHECK_FALSE(codec.unpack({}, again));
    for (std::byte& b : packed) b = std::byte(random.below(256));
    CHECK_FALSE(codec.unpack(packed, again));
    // What is noise does not fit into less.
    CHECK(codec.pack(packed, std::span(again).first(again.size() - 1)) == 0);
}

TEST_CASE("A file packed by zstd is smaller, and draws the same") {
    using Tensors = SpatialHierarchy<Octree, OpacityTensor, TriangleCount>;
    using Unpacked = UnpackedPages<FilePageSource, ZstdPages>;
    const TemporaryDirectory directory;
    const auto plain = directory.path() / "plain", packed = directory.path() / "packed";
    const Triangles triangles = random_triangles(4000, 4);
    save_pages<Tensors, Triangle>(build<Tensors>(triangles), triangles, plain, {.page_bytes = 8192});
    pack_pages(ZstdPages{.level = 1}, plain, packed, ThreadExecutor(2));
    CHECK(std::filesystem::file_size(packed) < std::filesystem::file_size(plain));
    const auto image = [](auto pages) {
        pages.wait_for_pages(true);
        ZBufferRenderer renderer;
        make_viewer(pages, renderer).frame(looking({1.5, 0.7, 2}, glm::dvec3(0), 128, 6));
        return renderer.image();
    };
    CHECK(image(open_pages<Tensors, Triangle>(plain)) ==
          image(open_pages_of<Tensors, Triangle>(
              std::make_shared<Unpacked>(std::make_shared<FilePageSource>(packed), "packed"), "packed")));
}
