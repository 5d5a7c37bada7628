#include "farfield/storage/save.hpp"

#include <new>

#include "catch.hpp"
#include "farfield/build.hpp"
#include "farfield/storage/open.hpp"
#include "files.hpp"

using namespace farfield;

namespace {
template <class H>
std::string failure(const H& hierarchy, const std::filesystem::path& path) {
    try {
        save(hierarchy, path);
        return {};
    } catch (const std::runtime_error& e) {
        return e.what();
    }
}
}  // namespace

TEMPLATE_TEST_CASE("equal hierarchies give equal files", "", OctreeOfCubes, SharedOctreeOfCubes, ExactOctree, ExactBsp,
                   OctreeOfBspsOfCubes, ExactSharedOctree, HalvesOfPooledCubes) {
    using P = typename TestType::partition_type;
    using A = typename TestType::approximation_type;
    const TemporaryDirectory directory;
    const auto triangles = scene(500);
    Bytes first;
    for (const int fill : {0x00, 0xff}) {
        // Padding between options keeps what was there.
        alignas(P) std::byte partition_memory[sizeof(P)];
        alignas(A) std::byte approximation_memory[sizeof(A)];
        std::memset(partition_memory, fill, sizeof partition_memory);
        std::memset(approximation_memory, fill, sizeof approximation_memory);
        const P& partition = *new (partition_memory) P{};
        const A& approximation = *new (approximation_memory) A{};
        const TestType h = build<TestType>(triangles, {.partition = partition, .approximation = approximation});
        save(h, directory / "h");
        const Bytes bytes = read_file(directory / "h");
        if (first.empty()) first = bytes;
        CHECK(bytes == first);
    }
    save(open<TestType>(directory / "h"), directory / "again");
    CHECK(read_file(directory / "again") == first);
}

TEST_CASE("a hierarchy that is open may be replaced") {
    const TemporaryDirectory directory;
    const auto few = scene(50), many = scene(500);
    save(built<OctreeOfCubes>(many), directory / "h");
    const auto old = open<OctreeOfCubes>(directory / "h");
    save(built<OctreeOfCubes>(few), directory / "h");
    save(old, directory / "copy");
    CHECK(pictures(old, many) == pictures(built<OctreeOfCubes>(many), many));
    save(old, directory / "h");
    CHECK(read_file(directory / "h") == read_file(directory / "copy"));
    CHECK(directory.files() == 2);
}

TEST_CASE("files that are being written are nobody else's") {
    const TemporaryDirectory directory;
    const Bytes other{'m', 'i', 'n', 'e'};
    write_file(directory / "h.0.part", other);
    save(OctreeOfCubes(), directory / "h");
    CHECK(read_file(directory / "h.0.part") == other);
    CHECK(directory.files() == 2);
}

TEST_CASE("what goes wrong while saving names the file and leaves nothing") {
    const TemporaryDirectory directory;
    const OctreeOfCubes h;
    const std::string nowhere = (directory / "no/such/place").string();
    CHECK(failure(h, nowhere) ==
          "farfield::save: " + nowhere + ": cannot create place.0.part: No such file or directory");
    std::filesystem::create_directories(directory / "taken/by");
    const std::string taken = (directory / "taken").string();
    CHECK(failure(h, taken).rfind("farfield::save: " + taken + ": cannot be replaced: ", 0) == 0);
    CHECK(directory.files() == 1);
}

TEST_CASE("what could not be opened is not saved") {
    const TemporaryDirectory directory;
    // Deeper than a file may be.
    HierarchyData<Octree, Exact> parts;
    for (std::uint32_t i = 0; i < most_levels_in_files; ++i) {
        parts.nodes.push_back({.first_child = i + 1, .child_mask = 1});
    }
    const ExactOctree deepest({}, {}, {}, [&] {
        auto p = parts;
        p.nodes.back() = {};
        return p;
    }());
    CHECK(failure(deepest, directory / "h").empty());
    parts.nodes.push_back({});
    const ExactOctree too_deep({}, {}, {}, parts);
    CHECK(failure(too_deep, directory / "h").find("cannot be stored: it has more than 1024 levels") !=
          std::string::npos);
    CHECK(open<ExactOctree>(directory / "h").nodes().size() == most_levels_in_files);
}
