#include "farfield/build_pages.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <functional>
#include <glm/common.hpp>
#include <glm/vec3.hpp>
#include <iterator>
#include <limits>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#if __has_include(<sys/wait.h>)
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>
#endif

#include "catch.hpp"
#include "farfield/approximation/area_splat.hpp"
#include "farfield/approximation/color_cube.hpp"
#include "farfield/approximation/opacity_tensor.hpp"
#include "farfield/approximation/sample_set.hpp"
#include "farfield/build_pages/disk_room.hpp"
#include "farfield/build_pages/ordered_results.hpp"
#include "farfield/cost_model/triangle_count.hpp"
#include "farfield/executor.hpp"
#include "farfield/paging/file_notes.hpp"
#include "farfield/paging/open_pages.hpp"
#include "farfield/paging/write_pages.hpp"
#include "farfield/partition/octree.hpp"
#include "farfield/renderer/z_buffer_renderer.hpp"
#include "farfield/viewer.hpp"
#include "support/pictures.hpp"
#include "support/random.hpp"
#include "support/scenes.hpp"
#include "support/temporary_directory.hpp"
#include "support/views.hpp"

using namespace farfield;
using namespace farfield::test;

namespace {

using Tensors = SpatialHierarchy<Octree, OpacityTensor, TriangleCount>;

auto stream_of(const Triangles& scene) {
    return [&scene](auto&& take) {
        for (const Triangle& t : scene) take(t);
    };
}
std::vector<char> bytes_of_file(const std::filesystem::path& path) {
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}
/// As if files had no holes.
std::uint64_t bytes_in(const std::filesystem::path& directory) {
    std::uint64_t sum = 0;
    for (const auto& file : std::filesystem::directory_iterator(directory)) sum += file.file_size();
    return sum;
}
/// So little memory that a small scene has many parts.
template <class H>
PageBuildOptions<H> in_many_parts() {
    PageBuildOptions<H> options;
    options.page_bytes = 8192;
    options.memory_bytes = 1 << 20;
    return options;
}

}  // namespace

TEMPLATE_TEST_CASE("A scene that is built in parts is drawn as if it had been built at once", "",
                   (SpatialHierarchy<Octree, OpacityTensor, TriangleCount>),
                   (SpatialHierarchy<Octree, ColorCube, TriangleCount>),
                   (SpatialHierarchy<Octree, SampleSet<>, TriangleCount>)) {
    const TemporaryDirectory directory;
    const Triangles scene = mixed_triangles(20000, 7);
    const auto path = directory.path() / "scene.farfield";
    build_pages<TestType, Triangle>(stream_of(scene), path, in_many_parts<TestType>());
    CHECK(std::distance(std::filesystem::directory_iterator(directory.path()), {}) == 1);
    auto pages = open_pages<TestType, Triangle>(path);
    pages.wait_for_pages(true);
    const auto h = build<TestType>(scene);
    ZBufferRenderer renderer({.samples = 4}), paged_renderer({.samples = 4});
    auto viewer = make_viewer(h, scene, renderer);
    auto paged_viewer = make_viewer(pages, paged_renderer);
    for (const float distance : {0.2f, 1.0f, 3.0f, 10.0f, 40.0f}) {
        for (const float tolerance : {0.0f, 1.0f, 4.0f}) {
            const View v = looking(glm::dvec3(0.3, 0.4, 1.0) * double(distance), glm::dvec3(0), 160, tolerance);
            viewer.frame(v);
            const FrameStats stats = paged_viewer.frame(v);
            INFO("distance " << distance << " tolerance " << tolerance);
            CHECK(stats.cells_missing == 0);
            if (tolerance == 0) {
                CHECK(different_pixels(renderer.image(), paged_renderer.image()) <= 3);
            } else {
                // Stand-ins that a build in memory does not keep are there.
                CHECK(rms_difference(renderer.image(), paged_renderer.image()) < 0.03);
            }
        }
    }
}

TEST_CASE("A file of pages has the same bytes however it was built") {
    const TemporaryDirectory directory;
    const Triangles scene = mixed_triangles(20000, 11);
    auto options = in_many_parts<Tensors>();
    const auto path = directory.path() / "scene.farfield";
    build_pages<Tensors, Triangle>(stream_of(scene), path, options);
    const std::vector<char> expected = bytes_of_file(path);
    std::filesystem::remove(path);

    SECTION("on several threads") {
        options.build.executor = ThreadExecutor(3);
        build_pages<Tensors, Triangle>(stream_of(scene), path, options);
        CHECK(bytes_of_file(path) == expected);
    }
    SECTION("from the last step to the first") {
        options.build.executor = [](std::size_t count, const std::function<void(std::size_t)>& f) {
            for (std::size_t i = count; i-- > 0;) f(i);
        };
        build_pages<Tensors, Triangle>(stream_of(scene), path, options);
        CHECK(bytes_of_file(path) == expected);
    }
    SECTION("in shares") {
        for (const std::uint32_t count : {2u, 3u, 7u, 25u}) {
            for (std::uint32_t i = count; i-- > 0;) {
                build_page_share<Tensors, Triangle>(stream_of(scene), path, {i, count}, options);
            }
            join_page_shares<Tensors, Triangle>(path, count, options);
            CHECK(bytes_of_file(path) == expected);
            CHECK(std::distance(std::filesystem::directory_iterator(directory.path()), {}) == 1);
        }
    }
}

TEST_CASE("Notes go into the file of all shares, and are those of the build that made it") {
    const TemporaryDirectory directory;
    const Triangles scene = mixed_triangles(5000, 11);
    auto options = in_many_parts<Tensors>();
    const auto path = directory.path() / "scene.farfield";
    build_pages<Tensors, Triangle>(stream_of(scene), path, options);
    const Notes notes{{"origin", "1 2 3"}, {"of", "a scene"}};
    write_notes(notes, path);
    const std::vector<char> expected = bytes_of_file(path);
    options.notes = {{"origin", "of a build that was stopped"}};
    build_page_share<Tensors, Triangle>(stream_of(scene), path, {0, 2}, options);
    options.notes = notes;
    build_page_share<Tensors, Triangle>(stream_of(scene), path, {1, 2}, options);
    CHECK_THROWS_WITH((join_page_shares<Tensors, Triangle>(path, 2, options)),
                      Catch::Matchers::Contains("another scene"));
    build_page_share<Tensors, Triangle>(stream_of(scene), path, {0, 2}, options);
    options.notes = {};  // joined by whoever does not know them
    join_page_shares<Tensors, Triangle>(path, 2, options);
    CHECK(bytes_of_file(path) == expected);
    CHECK((open_pages<Tensors, Triangle>(path).notes() == notes));
    options.notes = {{"long", std::string(17u << 20, ' ')}};
    CHECK_THROWS_AS((build_pages<Tensors, Triangle>(stream_of(scene), path, options)), std::invalid_argument);
}

TEST_CASE("Results of many threads are used in order, by one of them at a time") {
    constexpr std::size_t count = 500;
    detail::OrderedResults<std::unique_ptr<std::size_t>> results(count);
    for (int round = 0; round < 20; ++round) {
        results.restart();
        std::vector<std::size_t> used;  // no lock: ThreadSanitizer looks too
        ThreadExecutor(4)(count, [&](std::size_t i) {
            results.add(count - 1 - i, std::make_unique<std::size_t>(count - 1 - i),
                        [&](const std::unique_ptr<std::size_t>& result) { used.push_back(*result); });
        });
        REQUIRE(used.size() == count);
        for (std::size_t i = 0; i < count; ++i) CHECK(used[i] == i);
    }
    results.restart();
    const auto use = [](const std::unique_ptr<std::size_t>& result) {
        if (*result == 1) throw std::runtime_error("one");
    };
    for (const std::size_t i : {0u, 2u}) results.add(i, std::make_unique<std::size_t>(i), use);
    CHECK_THROWS_WITH(results.add(1, std::make_unique<std::size_t>(1), use), "one");
}

#if __has_include(<sys/wait.h>)
TEST_CASE("A build that is killed over and over goes on, and leaves no file that could be mistaken for a whole one") {
    const TemporaryDirectory directory;
    const Triangles scene = mixed_triangles(20000, 13);
    const auto options = in_many_parts<Tensors>();
    const auto path = directory.path() / "scene.farfield", other = directory.path() / "other.farfield";
    build_pages<Tensors, Triangle>(stream_of(scene), other, options);
    Random random(5);
    int killed = 0;
    for (int attempt = 0; attempt < 20; ++attempt) {
        const ::pid_t child = ::fork();
        if (child == 0) {
            build_pages<Tensors, Triangle>(stream_of(scene), path, options);
            ::_exit(0);
        }
        ::usleep(::useconds_t(random.between(0, 60000)));
        ::kill(child, SIGKILL);
        int status = 0;
        ::waitpid(child, &status, 0);
        killed += WIFSIGNALED(status);
        if (std::filesystem::exists(path)) {
            CHECK(bytes_of_file(path) == bytes_of_file(other));
            std::filesystem::remove(path);
        }
        for (const auto& entry : std::filesystem::directory_iterator(directory.path())) {
            if (entry.path().extension() != ".pages") continue;
            // What opens is whole, and was about to be renamed.
            const std::vector<char> bytes = bytes_of_file(entry.path());
            if (bytes != bytes_of_file(other)) {
                CHECK_THROWS_AS((open_pages<Tensors, Triangle>(entry.path())), std::runtime_error);
            }
        }
    }
    CHECK(killed > 0);
    build_pages<Tensors, Triangle>(stream_of(scene), path, options);
    CHECK(bytes_of_file(path) == bytes_of_file(other));
}

TEST_CASE("A build whose disk is full names the file, and goes on when there is room") {
    const TemporaryDirectory directory;
    const Triangles scene = mixed_triangles(20000, 13);
    const auto options = in_many_parts<Tensors>();
    const auto path = directory.path() / "scene.farfield", other = directory.path() / "other.farfield";
    build_pages<Tensors, Triangle>(stream_of(scene), other, options);
    const std::vector<char> expected = bytes_of_file(other);
    // Files that may not grow beyond a limit say what a full disk says.
    const auto old_action = ::signal(SIGXFSZ, SIG_IGN);
    ::rlimit old_limit{};
    REQUIRE(::getrlimit(RLIMIT_FSIZE, &old_limit) == 0);
    int refused = 0;
    for (const std::size_t eighths : {0u, 1u, 3u, 6u, 7u}) {
        ::rlimit limit = old_limit;
        limit.rlim_cur = expected.size() * eighths / 8;
        ::setrlimit(RLIMIT_FSIZE, &limit);
        std::string message;
        try {
            build_pages<Tensors, Triangle>(stream_of(scene), path, options);
        } catch (const std::runtime_error& e) {
            message = e.what();
        }
        ::setrlimit(RLIMIT_FSIZE, &old_limit);
        INFO(eighths << " eighths: " << message);
        CHECK(message.find("scene.farfield") != message.npos);
        CHECK_FALSE(std::filesystem::exists(path));
        refused += !message.empty();
    }
    ::signal(SIGXFSZ, old_action);
    CHECK(refused == 5);
    build_pages<Tensors, Triangle>(stream_of(scene), path, options);
    CHECK(bytes_of_file(path) == expected);
    CHECK(directory.files() == 2);
}
#endif

TEST_CASE("Room on the disk is looked for before anything is moved") {
    const TemporaryDirectory directory;
    const Triangles scene = mixed_triangles(20000, 13);
    auto options = in_many_parts<Tensors>();
    options.page_bytes = 4096;
    const auto path = directory.path() / "scene.farfield";
    int reads = 0;
    const auto stream = [&](auto&& take) {
        ++reads;
        for (const Triangle& t : scene) take(t);
    };
    const std::uint64_t needed = disk_bytes_of_build<Tensors, Triangle>(stream, options);
    CHECK(std::exchange(reads, 0) == 2);
    CHECK(directory.files() == 0);
    SECTION("less may be taken than it needs") {
        options.most_disk_bytes = needed / 2;
        CHECK_THROWS_WITH((build_pages<Tensors, Triangle>(stream, path, options)),
                          Catch::Matchers::Contains("scene.farfield") &&
                              Catch::Matchers::Contains("needs about " + std::to_string((needed >> 20) + 1) + " MiB") &&
                              Catch::Matchers::Contains("most_disk_bytes"));
        CHECK(reads == 2);  // for the bounds, and to count
        CHECK(directory.files() == 0);
    }
    SECTION("what it needs may be taken") {
        options.most_disk_bytes = needed;
        build_pages<Tensors, Triangle>(stream, path, options);
        CHECK(reads == 3);
        CHECK(std::filesystem::exists(path));
        CHECK(std::filesystem::file_size(path) < needed);
    }
    SECTION("the disk has less than it needs") {
        constexpr std::uint64_t too_much = std::uint64_t(1) << 62, any = std::numeric_limits<std::uint64_t>::max();
        CHECK_THROWS_WITH(detail::check_disk_room(path, too_much, any),
                          Catch::Matchers::Contains("scene.farfield") &&
                              Catch::Matchers::Contains("needs about 4398046511105 MiB") &&
                              Catch::Matchers::Contains(" left"));
        CHECK_THROWS_WITH(detail::check_disk_room("scene.farfield", too_much, any),
                          Catch::Matchers::Contains("scene.farfield"));
        CHECK_NOTHROW(detail::check_disk_room(path, 1, any));
    }
}

TEMPLATE_TEST_CASE("No build takes more of the disk than it said", "", AreaSplat, OpacityTensor, ColorCube,
                   SampleSet<AreaSplat>) {
    using H = SpatialHierarchy<Octree, TestType, TriangleCount>;
    // A chain of cells leads to each cluster, and triangles as large as their cell stay in it.
    Triangles clusters;
    Random random(4);
    for (int cluster = 0; cluster < 1000; ++cluster) {
        const glm::vec3 center = random.in_cube(1);
        for (int i = 0; i < 12; ++i) {
            Triangle& t = clusters.emplace_back();
            for (glm::vec3& v : t.vertices) v = center + random.in_cube(1e-6f);
        }
    }
    const Triangles flat = sheet({-1, 0, 1}, {2, 0, 0}, {0, 0, -2}, 80, 80, {90, 160, 60, 255}),
                    large = random_triangles(12000, 3, 0.3f), mixed = mixed_triangles(12000, 5);
    for (const Triangles& scene : {std::cref(clusters), std::cref(flat), std::cref(large), std::cref(mixed)}) {
        for (const std::uint32_t page_bytes : {4096u, 65536u}) {
            for (const std::uint32_t shares : {1u, 2u}) {
                PageBuildOptions<H> options;
                options.page_bytes = page_bytes;
                if (shares != 1) options.memory_bytes = 1 << 21;
                const TemporaryDirectory directory;
                const auto path = directory.path() / "scene.farfield";
                for (std::uint32_t index = 0; index < shares; ++index) {
                    const PageShare share{index, shares};
                    const std::uint64_t said = disk_bytes_of_build<H, Triangle>(stream_of(scene), options, share),
                                        before = bytes_in(directory.path());
                    std::uint64_t most = 0;
                    auto watched = options;
                    watched.build.progress = [&](const BuildProgress&) {
                        most = std::max(most, bytes_in(directory.path()) - before);
                        return true;
                    };
                    build_page_share<H, Triangle>(stream_of(scene), path, share, watched);
                    INFO("scene of " << scene.size() << ", pages of " << page_bytes << ", share " << index << " of "
                                     << shares);
                    CHECK(most > 0);
                    CHECK(most <= said);
                }
            }
        }
    }
}

#if __has_include(<sys/wait.h>)
TEST_CASE("A disk that fills up while pages are written is told of, and the build goes on when there is room") {
    if (!std::filesystem::exists("/dev/full")) {
        WARN("skipped: this system has no /dev/full");
        return;
    }
    const TemporaryDirectory directory;
    const Triangles scene = mixed_triangles(20000, 13);
    const auto options = in_many_parts<Tensors>();
    const auto path = directory.path() / "scene.farfield", pages = directory / "scene.farfield.0-of-1.pages";
    int reads = 0;
    const auto stream = [&](auto&& take) {
        for (const Triangle& t : scene) take(t);
        // By the end of the third time all has been moved and no page been written.
        if (++reads == 3) std::filesystem::create_symlink("/dev/full", pages);
    };
    for (int i = 0; i < 2; ++i) {
        CHECK_THROWS_WITH((build_pages<Tensors, Triangle>(stream, path, options)),
                          Catch::Matchers::Contains("scene.farfield.0-of-1.pages: cannot be written: No space left"));
        CHECK_FALSE(std::filesystem::exists(path));
    }
    std::filesystem::remove(pages);
    build_pages<Tensors, Triangle>(stream, path, options);
    CHECK(directory.files() == 1);
    const auto other = directory / "other.farfield";
    build_pages<Tensors, Triangle>(stream, other, options);
    CHECK(bytes_of_file(path) == bytes_of_file(other));
}
#endif

TEST_CASE("What another build has left does not get into this one, nor what is left of it in pieces") {
    const TemporaryDirectory directory;
    const Triangles scene = mixed_triangles(24000, 19), other_scene = mixed_triangles(24000, 23);
    const auto options = in_many_parts<Tensors>();
    const auto path = directory.path() / "scene.farfield";
    build_pages<Tensors, Triangle>(stream_of(scene), path, options);
    const std::vector<char> expected = bytes_of_file(path);
    std::filesystem::remove(path);
    const auto leave = [&](const Triangles& of, std::uint32_t page_bytes) {
        auto stopped = options;
        stopped.page_bytes = page_bytes;
        int groups = 0;
        stopped.build.progress = [&](const BuildProgress& p) {
            return p.phase != BuildPhase::building || ++groups < 2;
        };
        CHECK_THROWS_AS((build_pages<Tensors, Triangle>(stream_of(of), path, stopped)), BuildCanceled);
        REQUIRE(std::filesystem::exists(directory / "scene.farfield.0-of-1.journal"));
    };
    const auto goes_on = [&] {
        build_pages<Tensors, Triangle>(stream_of(scene), path, options);
        CHECK(bytes_of_file(path) == expected);
        CHECK(directory.files() == 1);
        std::filesystem::remove(path);
    };
    leave(other_scene, 8192);
    goes_on();
    leave(scene, 16384);
    goes_on();
    Random random(7);
    for (int damage = 0; damage < 10; ++damage) {
        leave(scene, 8192);
        const auto journal = directory / "scene.farfield.0-of-1.journal";
        std::vector<char> bytes = bytes_of_file(journal);
        REQUIRE(bytes.size() > 100);
        switch (damage % 5) {
            case 0:
                bytes.resize(random.below(std::uint32_t(bytes.size())));
                break;
            case 1:
                bytes[random.below(std::uint32_t(bytes.size()))] ^= char(1 << random.below(8));
                break;
            case 2:
                std::filesystem::remove(directory / "scene.farfield.0-of-1.pages");
                break;
            case 3:
                std::filesystem::remove(directory / "scene.farfield.0-of-1.scattered");
                break;
            default:
                // A disk that lost its power may hold anything.
                std::vector<char> primitives = bytes_of_file(directory / "scene.farfield.0-of-1.scattered");
                primitives[primitives.size() - 1 - random.below(4000)] ^= 1;
                directory.write("scene.farfield.0-of-1.scattered", std::string(primitives.begin(), primitives.end()));
                break;
        }
        directory.write(journal.filename().string(), std::string(bytes.begin(), bytes.end()));
        INFO("damage " << damage);
        goes_on();
    }
    directory.write("scene.farfield.0-of-1.journal", std::string(5000, 'x'));
    directory.write("scene.farfield.0-of-1.pages", "x");
    goes_on();
}

namespace {

struct WideTriangle {
    std::array<glm::dvec3, 3> vertices;
    Rgba8 rgba;
    std::uint32_t spare = 0;

    BoxD bounds() const {
        return {glm::min(vertices[0], glm::min(vertices[1], vertices[2])),
                glm::max(vertices[0], glm::max(vertices[1], vertices[2]))};
    }
    template <class Sink>
    void polygons(Sink&& sink) const {
        sink(PolygonD{vertices, {&rgba, 1}});
    }
};

}  // namespace

TEST_CASE("Primitives in double precision lie where they lie in a build in memory") {
    const TemporaryDirectory directory;
    std::vector<WideTriangle> scene;
    const glm::dvec3 offset(1e7, -3e6, 5e8);
    for (const Triangle& t : mixed_triangles(8000, 29)) {
        const auto wide = [&](int i) { return glm::dvec3(t.vertices[std::size_t(i)]) + offset; };
        scene.push_back({{wide(0), wide(1), wide(2)}, t.rgba});
    }
    const auto stream = [&scene](auto&& take) {
        for (const WideTriangle& t : scene) take(t);
    };
    const auto path = directory / "scene.farfield";
    build_pages<Tensors, WideTriangle>(stream, path, in_many_parts<Tensors>());
    const auto h = build<Tensors>(scene);
    auto pages = open_pages<Tensors, WideTriangle>(path);
    pages.wait_for_pages(true);
    CHECK(pages.origin() == h.origin());
    CHECK(pages.bounds() == h.bounds());
    CHECK(pages.root_cell().center == h.root_cell().center);
    ZBufferRenderer renderer, paged_renderer;
    auto viewer = make_viewer(h, scene, renderer);
    auto paged_viewer = make_viewer(pages, paged_renderer);
    for (const float distance : {0.5f, 3.0f}) {
        const View v = looking(offset + glm::dvec3(0.3, 0.4, 1.0) * double(distance), offset, 100, 0);
        viewer.frame(v);
        CHECK(paged_viewer.frame(v).cells_missing == 0);
        CHECK(coverage(renderer.image()) > 100);
        CHECK(different_pixels(renderer.image(), paged_renderer.image()) <= 3);
        const View coarse = looking(offset + glm::dvec3(0.3, 0.4, 1.0) * 12.0, offset, 100, 4);
        viewer.frame(coarse);
        CHECK(paged_viewer.frame(coarse).approximations > 0);
        CHECK(rms_difference(renderer.image(), paged_renderer.image()) < 0.03);
    }
}

TEST_CASE("Pages of a build may be asked to be smaller than any can be") {
    const TemporaryDirectory directory;
    const Triangles scene = mixed_triangles(3000, 31);
    auto options = in_many_parts<Tensors>();
    options.page_bytes = 1;
    const auto path = directory / "scene.farfield";
    build_pages<Tensors, Triangle>(stream_of(scene), path, options);
    auto pages = open_pages<Tensors, Triangle>(path);
    pages.wait_for_pages(true);
    ZBufferRenderer renderer;
    auto viewer = make_viewer(pages, renderer);
    CHECK(viewer.frame(looking(glm::dvec3(1, 1, 2), glm::dvec3(0), 64, 1)).cells_missing == 0);
}

TEST_CASE("A build in parts refuses what a build in memory refuses, and says what else is wrong") {
    const TemporaryDirectory directory;
    const auto path = directory.path() / "scene.farfield";
    const auto options = in_many_parts<Tensors>();
    Triangles scene = mixed_triangles(3000, 17);
    SECTION("a primitive that is not finite") {
        scene[1234].vertices[1].y = std::numeric_limits<float>::quiet_NaN();
        CHECK_THROWS_WITH((build_pages<Tensors, Triangle>(stream_of(scene), path, options)),
                          Catch::Matchers::Contains("primitive 1234"));
    }
    SECTION("a stream that changes") {
        int reads = 0;
        const auto stream = [&](auto&& take) {
            const std::size_t count = scene.size() - std::size_t(reads++ == 2);
            for (std::size_t i = 0; i < count; ++i) take(scene[i]);
        };
        CHECK_THROWS_WITH((build_pages<Tensors, Triangle>(stream, path, options)),
                          Catch::Matchers::Contains("3000") && Catch::Matchers::Contains("2999"));
    }
    SECTION("a share that is missing") {
        build_page_share<Tensors, Triangle>(stream_of(scene), path, {0, 2}, options);
        CHECK_THROWS_WITH((join_page_shares<Tensors, Triangle>(path, 2, options)),
                          Catch::Matchers::Contains("share 1 of 2"));
    }
    SECTION("a share of something else") {
        build_page_share<Tensors, Triangle>(stream_of(scene), path, {0, 2}, options);
        scene[0].vertices[0].x += 0.001f;
        build_page_share<Tensors, Triangle>(stream_of(scene), path, {1, 2}, options);
        CHECK_THROWS_WITH((join_page_shares<Tensors, Triangle>(path, 2, options)),
                          Catch::Matchers::Contains("share 1 of 2"));
    }
    SECTION("a callback that cancels, after which a build goes on") {
        auto canceling = options;
        canceling.build.progress = [](const BuildProgress& p) { return p.phase != BuildPhase::building; };
        CHECK_THROWS_AS((build_pages<Tensors, Triangle>(stream_of(scene), path, canceling)), BuildCanceled);
        CHECK_FALSE(std::filesystem::exists(path));
        build_pages<Tensors, Triangle>(stream_of(scene), path, options);
        CHECK(std::filesystem::exists(path));
    }
    SECTION("a folder that does not exist") {
        CHECK_THROWS_WITH(
            (build_pages<Tensors, Triangle>(stream_of(scene), directory.path() / "no" / "scene", options)),
            Catch::Matchers::Contains("scene"));
    }
}

TEST_CASE("Scenes of any kind are built in parts") {
    const TemporaryDirectory directory;
    const auto path = directory.path() / "scene.farfield";
    const auto options = in_many_parts<Tensors>();
    Triangles scene;
    SECTION("nothing") {}
    SECTION("one triangle") {
        scene = random_triangles(1, 1);
    }
    SECTION("the same triangle many times, more than a page holds") {
        scene.assign(5000, random_triangles(1, 1)[0]);
    }
    SECTION("one point") {
        scene.assign(3000, Triangle{});
    }
    SECTION("all in a plane") {
        scene = sheet({-1, 0, -1}, {2, 0, 0}, {0, 0, 2}, 60, 60, {200, 100, 50, 255});
    }
    SECTION("a large one among small ones") {
        scene = random_triangles(4000, 3, 0.01f);
        scene.push_back({{glm::vec3(-50, -50, 0), glm::vec3(50, -50, 0), glm::vec3(0, 50, 0)}, {9, 9, 9, 255}});
    }
    SECTION("far from the origin") {
        scene = moved(mixed_triangles(4000, 3), 1, glm::vec3(1e5f, -3e5f, 2e5f));
    }
    SECTION("very small") {
        scene = moved(mixed_triangles(4000, 3), 1e-18f);
    }
    build_pages<Tensors, Triangle>(stream_of(scene), path, options);
    auto pages = open_pages<Tensors, Triangle>(path);
    pages.wait_for_pages(true);
    CHECK(pages.primitive_count() == scene.size());
    const auto h = build<Tensors>(scene);
    ZBufferRenderer renderer, paged_renderer;
    auto viewer = make_viewer(h, scene, renderer);
    auto paged_viewer = make_viewer(pages, paged_renderer);
    const glm::dvec3 center = h.bounds().is_empty() ? glm::dvec3(0) : glm::dvec3(h.bounds().center());
    const double size = h.bounds().is_empty() ? 1.0 : std::max(double(h.bounds().largest_side()), 1e-20);
    const View v = looking(center + glm::dvec3(0.3, 0.4, 1.0) * (1.5 * size), center, 100, 0);
    viewer.frame(v);
    paged_viewer.frame(v);
    CHECK(different_pixels(renderer.image(), paged_renderer.image()) <= 3);
}
