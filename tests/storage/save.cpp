#include "farfield/storage/save.hpp"

#include <csignal>
#include <new>

#include "catch.hpp"
#include "farfield/build.hpp"
#include "farfield/storage/mapped_file.hpp"
#include "farfield/storage/open.hpp"
#include "files.hpp"

#if FARFIELD_MAPS_FILES
#include <sys/resource.h>
#endif

using namespace farfield;

namespace {
#if FARFIELD_MAPS_FILES
/// As on a full disk: this process cannot write more than so many bytes into a file.
class FullDisk {
  public:
    explicit FullDisk(std::size_t bytes) : handler_(std::signal(SIGXFSZ, SIG_IGN)) {
        ::getrlimit(RLIMIT_FSIZE, &before_);
        ::rlimit limit = before_;
        limit.rlim_cur = bytes;
        ::setrlimit(RLIMIT_FSIZE, &limit);
    }
    ~FullDisk() {
        ::setrlimit(RLIMIT_FSIZE, &before_);
        std::signal(SIGXFSZ, handler_);
    }
    FullDisk(const FullDisk&) = delete;
    FullDisk& operator=(const FullDisk&) = delete;

  private:
    ::rlimit before_{};
    void (*handler_)(int);
};
#endif

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

#if FARFIELD_MAPS_FILES
TEST_CASE("a disk that becomes full while saving keeps the old file and leaves nothing else") {
    const TemporaryDirectory directory;
    const std::string target = (directory / "h").string();
    const auto few = built<OctreeOfCubes>(scene(1)), many = built<OctreeOfCubes>(scene(5000));
    save(few, target);
    const Bytes before = read_file(target);
    REQUIRE(before.size() < 4096);      // one that is written when all of it is there,
    REQUIRE(saved_size(many) > 30000);  // and one that is written piece by piece
    for (const auto* h : {&few, &many}) {
        for (const std::size_t room : {0u, 1u, 640u, 700u, 20000u}) {
            if (room >= saved_size(*h)) continue;
            INFO("room for " << room << " of " << saved_size(*h) << " bytes");
            const std::string why = [&] {
                const FullDisk full(room);
                return failure(*h, target);
            }();
            CHECK(why == "farfield::save: " + target + ": cannot write: File too large");
            CHECK(read_file(target) == before);
            CHECK(directory.files() == 1);
        }
    }
}

TEST_CASE("a write that failed is told at once") {
    const TemporaryDirectory directory;
    const std::vector<std::byte> bytes(100000);
    bool told = false;
    {
        farfield::detail::ReplacingFile file(directory / "h");
        const FullDisk full(0);
        try {
            file.write(bytes);
        } catch (const std::runtime_error&) {
            told = true;
        }
    }
    CHECK(told);
    CHECK(directory.files() == 0);
}
#endif

TEST_CASE("memory of the wrong size is refused and left as it is") {
    const auto h = built<OctreeOfCubes>(scene(100));
    const std::size_t size = saved_size(h);
    for (const std::size_t wrong : {std::size_t(0), size - 1, size + 1}) {
        std::vector<std::byte> memory(wrong, std::byte(7));
        CHECK_THROWS_AS(save(h, std::span(memory)), std::invalid_argument);
        CHECK(memory == std::vector<std::byte>(wrong, std::byte(7)));
    }
}

TEMPLATE_TEST_CASE("memory gets the bytes of the file", "", OctreeOfCubes, ExactSharedOctree, HalvesOfPooledCubes,
                   ExactBsp, BspOfPooledCubes) {
    const TemporaryDirectory directory;
    for (const std::size_t count : {0u, 1u, 500u}) {
        const auto h = built<TestType>(scene(count));
        save(h, directory / "h");
        const Bytes file = read_file(directory / "h");
        REQUIRE(saved_size(h) == file.size());
        std::vector<std::byte> memory(file.size(), std::byte(0xff));
        save(h, std::span(memory));
        CHECK(std::memcmp(memory.data(), file.data(), file.size()) == 0);
    }
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
