// packed_format.hpp, unpacked_pages.hpp and pack_pages.hpp, by a codec that is easy to follow.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <ios>
#include <iterator>
#include <memory>
#include <span>
#include <stdexcept>
#include <string>
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
#include "paging/faulty_source.hpp"
#include "support/random.hpp"
#include "support/scenes.hpp"
#include "support/temporary_directory.hpp"
#include "support/trim_zeros.hpp"
#include "support/views.hpp"

using namespace farfield;
using namespace farfield::test;

namespace {

using Tensors = SpatialHierarchy<Octree, OpacityTensor, TriangleCount>;
using Bytes = std::vector<std::byte>;

struct Other : TrimZeros {
    static constexpr std::uint32_t file_tag = 0x4f544852u;
    static constexpr const char* name = "other";
};
static_assert(PageCodec<TrimZeros> && PageCodec<Other>);
struct NoTag {
    static constexpr const char* name = "none";
    std::size_t pack(std::span<const std::byte>, std::span<std::byte>) const { return 0; }
    bool unpack(std::span<const std::byte>, std::span<std::byte>) const noexcept { return false; }
};
static_assert(!PageCodec<NoTag>);

using Unpacked = UnpackedPages<FilePageSource, TrimZeros>;
static_assert(PageSource<Unpacked> && !CancellablePageSource<Unpacked>);

Bytes read_all(const std::filesystem::path& path) {
    std::ifstream in(path, std::ios::binary);
    const std::vector<char> chars{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
    const auto bytes = std::as_bytes(std::span(chars));
    return Bytes(bytes.begin(), bytes.end());
}
void write_all(const std::filesystem::path& path, std::span<const std::byte> bytes) {
    std::ofstream(path, std::ios::binary)
        .write(reinterpret_cast<const char*>(bytes.data()), std::streamsize(bytes.size()));
}
std::string refusal(const std::filesystem::path& path) {
    try {
        Unpacked(std::make_shared<FilePageSource>(path), "packed");
    } catch (const std::runtime_error& e) {
        return e.what();
    }
    return {};
}

struct Files {
    TemporaryDirectory directory;
    std::filesystem::path plain = directory.path() / "plain.farfield", packed = directory.path() / "packed.farfield";
    Triangles triangles = random_triangles(3000, 4);
    Files() {
        save_pages<Tensors, Triangle>(build<Tensors>(triangles), triangles, plain, {.page_bytes = 4096});
        pack_pages(TrimZeros(), plain, packed);
    }
    Unpacked unpacked() const { return Unpacked(std::make_shared<FilePageSource>(packed), "packed"); }
};

}  // namespace

TEST_CASE("Whatever is read of packed pages is what was packed") {
    const Files files;
    const Bytes plain = read_all(files.plain);
    Unpacked source = files.unpacked();
    REQUIRE(source.size() == plain.size());
    CHECK(read_all(files.packed).size() < plain.size());
    Bytes all(plain.size());
    REQUIRE(source.read(0, all).status == ReadStatus::done);
    CHECK(all == plain);
    Random random(5);
    for (int i = 0; i < 300; ++i) {
        const std::size_t begin = random.below(std::uint32_t(plain.size() + 1));
        const std::size_t count = random.below(std::uint32_t(std::min<std::size_t>(plain.size() - begin, 30000) + 1));
        Bytes part(count);
        REQUIRE(source.read(begin, part).status == ReadStatus::done);
        CHECK(std::equal(part.begin(), part.end(), plain.begin() + std::ptrdiff_t(begin)));
    }
    Bytes beyond(2);
    CHECK(source.read(plain.size() - 1, beyond).status == ReadStatus::refused);
    CHECK(source.read(plain.size(), {}).status == ReadStatus::done);
}

TEST_CASE("A file that is packed on several threads, or into itself, has the same bytes") {
    const Files files;
    const Bytes packed = read_all(files.packed);
    pack_pages(TrimZeros(), files.plain, files.directory.path() / "again", ThreadExecutor(3));
    CHECK(read_all(files.directory.path() / "again") == packed);
    pack_pages(TrimZeros(), files.plain, files.plain);
    CHECK(read_all(files.plain) == packed);
    // What is packed already is no file of pages.
    CHECK_THROWS_AS(pack_pages(TrimZeros(), files.plain, files.plain), std::runtime_error);
    CHECK(read_all(files.plain) == packed);
}

TEST_CASE("A page that does not shrink is stored as it is") {
    const Files files;
    Bytes plain = read_all(files.plain);
    detail::PageFileHeader header;
    std::memcpy(&header, plain.data(), sizeof header);
    // Nothing looks at what a page does not use.
    plain[std::size_t(header.first_page) + 3 * header.page_bytes - 1] = std::byte(7);
    write_all(files.plain, plain);
    pack_pages(TrimZeros(), files.plain, files.packed);
    Unpacked source = files.unpacked();
    CHECK(source.stored_bytes(2) == header.page_bytes);
    CHECK(source.stored_bytes(1) < header.page_bytes);
    Bytes all(plain.size());
    REQUIRE(source.read(0, all).status == ReadStatus::done);
    CHECK(all == plain);
}

TEST_CASE("Frames over packed pages are those over plain ones") {
    const Files files;
    const auto image = [](auto pages) {
        pages.wait_for_pages(true);
        ZBufferRenderer renderer;
        make_viewer(pages, renderer).frame(looking({1.5, 0.7, 2}, glm::dvec3(0), 128, 6));
        return renderer.image();
    };
    const PageCacheOptions options{.most_bytes = 8u << 20, .loads_in_background = false};
    const auto plain = image(open_pages<Tensors, Triangle>(files.plain, options));
    const auto packed =
        image(open_pages_of<Tensors, Triangle>(std::make_shared<Unpacked>(files.unpacked()), "packed", options));
    CHECK(plain == packed);
    // What the source takes is taken from the limit.
    const auto limited =
        open_pages_of<Tensors, Triangle>(std::make_shared<Unpacked>(files.unpacked()), "packed", options);
    CHECK(limited.cache_stats().bytes + files.unpacked().memory_bytes() <= options.most_bytes);
}

TEST_CASE("Packed pages that are opened without their codec are refused by its name") {
    const Files files;
    CHECK_THROWS_WITH((open_pages<Tensors, Triangle>(files.packed)), Catch::Matchers::Contains("codec 'trim'"));
    using Wrong = UnpackedPages<FilePageSource, Other>;
    CHECK_THROWS_WITH(Wrong(std::make_shared<FilePageSource>(files.packed), "packed"),
                      Catch::Matchers::Contains("packed by 'trim'") && Catch::Matchers::Contains("'other'"));
    CHECK(refusal(files.plain).find("holds no packed pages") != std::string::npos);
    FilePageSource plain(files.plain), packed(files.packed);
    CHECK_FALSE(holds_pages_packed_by<TrimZeros>(plain));
    CHECK(holds_pages_packed_by<TrimZeros>(packed));
    CHECK_FALSE(holds_pages_packed_by<Other>(packed));
    CHECK_FALSE(holds_pages_of<Tensors, Triangle>(packed));
}

TEST_CASE("Packed files that are cut short or damaged are refused, or their pages found unsound") {
    const Files files;
    const Bytes good = read_all(files.packed);
    const auto path = files.directory.path() / "damaged";
    for (const std::size_t size : {std::size_t(0), std::size_t(7), std::size_t(71), std::size_t(72), std::size_t(4000),
                                   good.size() - 1000, good.size() - 9, good.size() - 1}) {
        write_all(path, std::span(good).first(size));
        CHECK(refusal(path).find("packed: ") != std::string::npos);
    }
    Bytes longer = good;
    longer.resize(longer.size() + 4);
    write_all(path, longer);
    CHECK(!refusal(path).empty());
    // Every bit of the header, and of the sizes of pages.
    const auto pages = std::size_t(
        open_pages_of<Tensors, Triangle>(std::make_shared<Unpacked>(files.unpacked()), "packed").page_count());
    const auto flipped = [&](std::size_t byte, unsigned bit) {
        Bytes bad = good;
        std::byte* const at = bad.data() + byte;
        *at ^= std::byte(1u << bit);
        write_all(path, bad);
    };
    for (std::size_t byte = 0; byte < sizeof(detail::PackedFileHeader); ++byte) {
        flipped(byte, unsigned(byte % 8));
        CHECK(!refusal(path).empty());
    }
    for (std::size_t byte = good.size() - 8 - 4 * pages; byte < good.size(); ++byte) {
        flipped(byte, unsigned(byte % 8));
        CHECK(!refusal(path).empty());
    }
    // Bits of the pages themselves: opened, perhaps, but what is damaged is never drawn.
    Random random(8);
    const std::size_t first = sizeof(detail::PackedFileHeader) + 4096, end = good.size() - 8 - 4 * pages;
    for (int i = 0; i < 40; ++i) {
        flipped(first + random.below(std::uint32_t(end - first)), random.below(8));
        try {
            auto opened = open_pages_of<Tensors, Triangle>(
                std::make_shared<Unpacked>(std::make_shared<FilePageSource>(path), "packed"), "packed",
                {.most_bytes = 8u << 20, .loads_in_background = false});
            opened.wait_for_pages(true);
            ZBufferRenderer renderer;
            make_viewer(opened, renderer).frame(looking({1.5, 0.7, 2}));
            CHECK(opened.cache_stats().failures >= 1);
        } catch (const std::runtime_error& e) {
            CHECK(std::string(e.what()).find("packed: ") != std::string::npos);
        }
    }
}
