#include "farfield/paging/file_notes.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <memory>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "catch.hpp"
#include "farfield/approximation/opacity_tensor.hpp"
#include "farfield/build.hpp"
#include "farfield/cost_model/triangle_count.hpp"
#include "farfield/paging/open_pages.hpp"
#include "farfield/paging/pack_pages.hpp"
#include "farfield/paging/unpacked_pages.hpp"
#include "farfield/paging/write_pages.hpp"
#include "farfield/partition/octree.hpp"
#include "farfield/storage/open.hpp"
#include "farfield/storage/save.hpp"
#include "storage/files.hpp"
#include "support/scenes.hpp"
#include "support/trim_zeros.hpp"

using namespace farfield;
using namespace farfield::test;

namespace {

using Tensors = SpatialHierarchy<Octree, OpacityTensor, TriangleCount>;

using Unpacked = UnpackedPages<FilePageSource, TrimZeros>;

const Notes some{{"errors", "1 2 3\n"}, {"who", "me"}};

/// One file of each kind, over the same hierarchy.
struct Kinds {
    TemporaryDirectory directory;
    Triangles triangles = random_triangles(600, 4);
    Tensors hierarchy = build<Tensors>(triangles);
    std::filesystem::path plain = directory / "plain", pages = directory / "pages", packed = directory / "packed";

    explicit Kinds(const Notes& notes = {}) {
        save(hierarchy, plain, notes);
        save_pages<Tensors, Triangle>(hierarchy, triangles, pages, {.page_bytes = 4096, .notes = notes});
        pack_pages(TrimZeros(), pages, packed);
    }
    std::vector<std::filesystem::path> all() const { return {plain, pages, packed}; }
    /// The notes that come with it where they do; throws what is wrong with the file.
    static Notes opened(const std::filesystem::path& path) {
        if (path.filename() == "plain") {
            open<Tensors>(path);
            return read_notes(path);
        }
        const PageCacheOptions options{.most_bytes = 16u << 20, .loads_in_background = false};
        if (path.filename() == "pages") return open_pages<Tensors, Triangle>(path, options).notes();
        const auto source = std::make_shared<Unpacked>(std::make_shared<FilePageSource>(path), "packed");
        return open_pages_of<Tensors, Triangle>(source, "packed", options).notes();
    }
};

}  // namespace

TEST_CASE("Notes that are put into a file of any kind are those that it could have been made with") {
    const Kinds without, with(some);
    for (std::size_t i = 0; i < without.all().size(); ++i) {
        const auto path = without.all()[i];
        INFO(path.filename());
        const Bytes before = read_file(path);
        CHECK(read_notes(path).empty());
        CHECK(Kinds::opened(path).empty());
        write_notes(some, path);
        CHECK(read_file(path) == read_file(with.all()[i]));
        CHECK(Kinds::opened(path) == some);
        const Bytes after = read_file(path);
        CHECK(read_notes(std::as_bytes(std::span(after))) == some);
        write_notes({{"other", "note"}}, path);
        CHECK(Kinds::opened(path) == Notes{{"other", "note"}});
        write_notes({}, path);
        CHECK(read_file(path) == before);
    }
    // Whoever has the old file open keeps it.
    const auto opened = open_pages<Tensors, Triangle>(with.pages);
    write_notes({}, with.pages);
    CHECK(opened.notes() == some);
    CHECK_NOTHROW(opened.whole());
}

TEST_CASE("Packed pages are read with the notes that follow them") {
    const Kinds kinds(some);
    const Bytes plain = read_file(kinds.pages);
    Unpacked source(std::make_shared<FilePageSource>(kinds.packed), "packed");
    REQUIRE(source.size() == plain.size());
    for (const std::size_t begin : {std::size_t(0), plain.size() - 5000, plain.size() - 9, plain.size()}) {
        std::vector<std::byte> part(plain.size() - begin);
        REQUIRE(source.read(begin, part).status == ReadStatus::done);
        CHECK(std::equal(part.begin(), part.end(), std::as_bytes(std::span(plain)).subspan(begin).begin()));
    }
    std::vector<std::byte> beyond(2);
    CHECK(source.read(plain.size() - 1, beyond).status == ReadStatus::refused);
}

TEST_CASE("A changed byte of the notes of any kind of file is found when it is opened, and so is a missing one") {
    const Kinds kinds(some), without;
    for (std::size_t i = 0; i < kinds.all().size(); ++i) {
        const auto path = kinds.all()[i];
        INFO(path.filename());
        const Bytes good = read_file(path);
        const std::size_t end = read_file(without.all()[i]).size();
        REQUIRE(good.size() > end + 40);
        for (std::size_t at = end; at < good.size(); ++at) {
            CAPTURE(at - end);
            Bytes bad = good;
            bad[at] = char(bad[at] ^ 1 << at % 8);
            write_file(path, bad);
            CHECK_THROWS_AS(Kinds::opened(path), std::runtime_error);
            CHECK_THROWS_AS(read_notes(path), std::runtime_error);
            bad = good;
            bad.resize(at);
            write_file(path, bad);
            if (at == end && i < 2) {
                CHECK(Kinds::opened(path).empty());  // as if there had never been any
            } else {
                CHECK_THROWS_AS(Kinds::opened(path), std::runtime_error);
            }
        }
        Bytes longer = good;
        longer.push_back(0);
        write_file(path, longer);
        CHECK_THROWS_AS(Kinds::opened(path), std::runtime_error);
    }
}

TEST_CASE("Notes are neither read from nor written to what is no file of a hierarchy") {
    const Kinds kinds;
    using Catch::Matchers::Contains;
    CHECK_THROWS_WITH(read_notes(kinds.directory / "none"), Contains("none"));
    for (const char* text : {"", "ply\nformat ascii 1.0\n",
                             "\x89"
                             "FFP\r\n\x1a\n"}) {
        const auto path = kinds.directory.write("text", text);
        CHECK_THROWS_WITH(read_notes(path), Contains("farfield::read_notes: ") && Contains("text: is "));
        CHECK_THROWS_WITH(write_notes(some, path), Contains("farfield::write_notes: ") && Contains("text: is "));
        CHECK(read_file(path) == Bytes(text, text + std::strlen(text)));
    }
    Bytes cut = read_file(kinds.pages);
    cut.pop_back();
    write_file(kinds.pages, cut);
    CHECK_THROWS_WITH(write_notes(some, kinds.pages), Contains("pages: is truncated"));
    CHECK(read_file(kinds.pages) == cut);
    CHECK_THROWS_AS(write_notes({{"much", std::string(std::size_t(1) << 25, ' ')}}, kinds.plain),
                    std::invalid_argument);
    CHECK(kinds.directory.files() == 4);
}
