#include "farfield/paging/paged_hierarchy.hpp"

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <limits>
#include <map>
#include <memory>
#include <set>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <thread>
#include <type_traits>
#include <utility>
#include <vector>

#include "catch.hpp"
#include "farfield/approximation/color_cube.hpp"
#include "farfield/approximation/opacity_tensor.hpp"
#include "farfield/build.hpp"
#include "farfield/cost_model/triangle_count.hpp"
#include "farfield/paging/open_pages.hpp"
#include "farfield/paging/write_pages.hpp"
#include "farfield/partition/octree.hpp"
#include "farfield/renderer/z_buffer_renderer.hpp"
#include "farfield/storage/save.hpp"
#include "farfield/viewer.hpp"
#include "paging/faulty_source.hpp"
#include "support/pictures.hpp"
#include "support/random.hpp"
#include "support/scenes.hpp"
#include "support/temporary_directory.hpp"
#include "support/views.hpp"

using namespace farfield;
using namespace farfield::test;
using namespace std::chrono_literals;

namespace {

using Tensors = SpatialHierarchy<Octree, OpacityTensor, TriangleCount>;
using Cubes = SpatialHierarchy<Octree, ColorCube, TriangleCount>;
using Paged = PagedHierarchy<Tensors, Triangle>;
using Bytes = std::vector<std::byte>;

/// A source that keeps its bytes.
struct Memory {
    Bytes bytes;
    std::uint64_t size() const noexcept { return bytes.size(); }
    ReadMerging merging() const noexcept { return {8192, 32768, 2}; }
    ReadResult read(std::uint64_t offset, std::span<std::byte> to) noexcept {
        if (!detail::lies_within(size(), offset, to.size())) {
            return detail::beyond_the_end("memory", size(), offset, to.size());
        }
        if (!to.empty()) std::memcpy(to.data(), bytes.data() + offset, to.size());
        return {};
    }
};
using Faulty = FaultySource<Memory>;

Paged opened(const Bytes& bytes, const PageCacheOptions& options = {.loads_in_background = false}) {
    return open_pages_of<Tensors, Triangle>(std::make_shared<Memory>(Memory{bytes}), "memory", options);
}
/// A file of small pages, and what it was made of.
struct Scene {
    Triangles triangles;
    Tensors hierarchy;
    Bytes bytes;

    explicit Scene(Triangles t, std::uint32_t page_bytes = 4096)
        : triangles(std::move(t)),
          hierarchy(build<Tensors>(triangles)),
          bytes(paged<Tensors, Triangle>(hierarchy, triangles, {.page_bytes = page_bytes})) {}
    detail::PageFileHeader header() const {
        detail::PageFileHeader h;
        std::memcpy(&h, bytes.data(), sizeof h);
        return h;
    }
};
const Scene& mixed_scene() {
    static const Scene scene(mixed_triangles(20000, 7));
    return scene;
}
Bytes with_header(Bytes bytes, const detail::PageFileHeader& changed) {
    detail::PageFileHeader h = changed;
    h.checksum = detail::Xxh64::of(std::as_bytes(std::span(&h, 1)).first(offsetof(detail::PageFileHeader, checksum)));
    std::memcpy(bytes.data(), &h, sizeof h);
    return bytes;
}

View view_at(float distance, float tolerance, int size = 160) {
    return looking(glm::dvec3(0.3, 0.4, 1.0) * double(distance), glm::dvec3(0), size, tolerance);
}
/// Eyes on a way through a scene.
View view_on_walk(int step, float tolerance = 2, int size = 96) {
    const double t = double(step) * 0.05;
    return looking(glm::dvec3(1.5 - t, 0.3, 1.2 - 0.3 * t), glm::dvec3(0.2 - t, 0, 0), size, tolerance);
}
Image waiting_picture(const Paged& pages, const View& view) {
    Paged waiting = pages;
    waiting.wait_for_pages(true);
    ZBufferRenderer renderer;
    auto viewer = make_viewer(waiting, renderer);
    CHECK(viewer.frame(view).cells_missing == 0);
    return renderer.image();
}

}  // namespace

TEST_CASE("What lies in pages is drawn as what lies in memory, once it is there") {
    const Scene& scene = mixed_scene();
    auto pages = opened(scene.bytes);
    pages.wait_for_pages(true);
    ZBufferRenderer renderer({.samples = 4}), paged_renderer({.samples = 4});
    auto viewer = make_viewer(scene.hierarchy, scene.triangles, renderer);
    auto paged_viewer = make_viewer(pages, paged_renderer);
    const auto compare = [&](const View& v) {
        const FrameStats a = viewer.frame(v);
        const FrameStats b = paged_viewer.frame(v);
        CHECK(b.cells_missing == 0);
        CHECK(b.primitives <= a.primitives);  // those of cells beyond the frustum are in runs with others in memory
        CHECK(a.approximations == b.approximations);
        CHECK(different_pixels(renderer.image(), paged_renderer.image()) <= 3);
    };
    for (const float tolerance : {0.0f, 1.0f, 4.0f}) {
        for (const float distance : {0.2f, 1.0f, 3.0f, 10.0f, 40.0f}) {
            INFO(distance << " " << tolerance << " pages " << pages.page_count());
            compare(view_at(distance, tolerance));
        }
        for (const float height : {0.1f, 1.0f, 5.0f}) {
            INFO("orthographic " << height << " " << tolerance);
            compare(looking_orthographic(glm::dvec3(1, 2, 3), glm::dvec3(0), height, 120, tolerance));
        }
    }
}

TEST_CASE("Pages may have any size, and what they show does not depend on it") {
    const Triangles triangles = mixed_triangles(4000, 3);
    const auto h = build<Tensors>(triangles);
    const Image expected = waiting_picture(opened(paged<Tensors, Triangle>(h, triangles)), view_at(2, 1));
    for (const std::uint32_t page_bytes :
         {0u, 1u, 1000u, 20000u, 1u << 20, 200u << 20, std::numeric_limits<std::uint32_t>::max()}) {
        INFO(page_bytes);
        const Bytes bytes = paged<Tensors, Triangle>(h, triangles, {.page_bytes = page_bytes});
        const auto pages = opened(bytes);
        CHECK(pages.bytes() == bytes.size());
        CHECK(pages.page_bytes() <= 64u << 20);
        CHECK(different_pixels(waiting_picture(pages, view_at(2, 1)), expected) <= 3);
    }
}

TEST_CASE("Scenes of any kind lie in pages") {
    Triangles triangles;
    SECTION("nothing") {}
    SECTION("one triangle") {
        triangles = random_triangles(1, 1);
    }
    SECTION("the same triangle many times, more than a page holds") {
        triangles.assign(5000, random_triangles(1, 1)[0]);
    }
    SECTION("one point") {
        triangles.assign(300, Triangle{});
    }
    SECTION("all in a plane") {
        triangles = sheet({-1, 0, -1}, {2, 0, 0}, {0, 0, 2}, 40, 40, {200, 100, 50, 255});
    }
    SECTION("very small and far from the origin") {
        triangles = moved(mixed_triangles(4000, 3), 1e-3f, glm::vec3(1e3f, -3e3f, 2e3f));
    }
    const Scene scene(triangles);
    auto pages = opened(scene.bytes);
    CHECK(pages.primitive_count() == triangles.size());
    pages.wait_for_pages(true);
    ZBufferRenderer renderer, paged_renderer;
    auto viewer = make_viewer(scene.hierarchy, scene.triangles, renderer);
    auto paged_viewer = make_viewer(pages, paged_renderer);
    const Box& bounds = scene.hierarchy.bounds();
    const glm::dvec3 center = bounds.is_empty() ? glm::dvec3(0) : glm::dvec3(bounds.center());
    const double size = bounds.is_empty() ? 1.0 : std::max(double(bounds.largest_side()), 1e-6);
    for (const float tolerance : {0.0f, 1.0f}) {
        for (const View& v :
             {looking(center + glm::dvec3(0.3, 0.4, 1.0) * (1.5 * size), center, 100, tolerance),
              looking_orthographic(center + glm::dvec3(0.3, 0.4, 1.0) * size, center, float(size), 100, tolerance)}) {
            viewer.frame(v);
            CHECK(paged_viewer.frame(v).cells_missing == 0);
            CHECK(different_pixels(renderer.image(), paged_renderer.image()) <= 3);
        }
    }
}

TEST_CASE("A file of pages that is cut short anywhere, or goes on, is refused by name") {
    const TemporaryDirectory directory;
    const Scene scene(mixed_triangles(3000, 5));
    const std::string text(reinterpret_cast<const char*>(scene.bytes.data()), scene.bytes.size());
    const detail::PageFileHeader h = scene.header();
    std::vector<std::size_t> lengths{0, 1, 7, 8, 11, 12, 15, 16, 17, 100, sizeof h - 1, sizeof h, sizeof h + 1};
    for (std::size_t end = h.first_page; end <= text.size(); end += h.page_bytes) {
        for (const std::size_t length : {end - 1, end, end + 1}) {
            if (length < text.size()) lengths.push_back(length);
        }
    }
    for (const std::size_t length : lengths) {
        INFO(length);
        const auto path = directory.write("cut.pages", std::string_view(text).substr(0, length));
        CHECK_THROWS_AS((open_pages<Tensors, Triangle>(path)), std::runtime_error);
        CHECK_THROWS_WITH((open_pages<Tensors, Triangle>(path)), Catch::Matchers::Contains("cut.pages"));
    }
    const auto longer = directory.write("longer.pages", text + "x");
    CHECK_THROWS_WITH((open_pages<Tensors, Triangle>(longer)), Catch::Matchers::Contains("is too long"));
    CHECK_THROWS_WITH((open_pages<Tensors, Triangle>(directory.path() / "none.pages")),
                      Catch::Matchers::Contains("none.pages"));
    CHECK_THROWS_WITH((open_pages<Tensors, Triangle>(directory.path())),
                      Catch::Matchers::Contains(directory.path().filename().string()));
    CHECK_NOTHROW((open_pages<Tensors, Triangle>(directory.write("whole.pages", text))));
}

TEST_CASE("A flipped bit in any field of the header, of the options or of the first page is found when it is opened") {
    const Scene scene(mixed_triangles(3000, 5));
    const detail::PageFileHeader h = scene.header();
    detail::PageHeader first;
    std::memcpy(&first, scene.bytes.data() + h.first_page, sizeof first);
    std::vector<std::size_t> places;
    for (std::size_t at = 0; at < sizeof h + h.option_bytes; ++at) places.push_back(at);
    for (std::size_t at = 0; at < first.used_bytes; at += at < 400 ? 1 : 37) places.push_back(h.first_page + at);
    Random random(3);
    Bytes bytes = scene.bytes;
    for (const std::size_t at : places) {
        const auto bit = std::byte(1u << random.below(8));
        bytes[at] ^= bit;
        INFO("byte " << at);
        CHECK_THROWS_AS(opened(bytes), std::runtime_error);
        bytes[at] ^= bit;
    }
    CHECK_NOTHROW(opened(bytes));
}

TEST_CASE("A header that lies with a right checksum is refused") {
    const Scene scene(mixed_triangles(3000, 5));
    const auto refuses = [&](auto&& change) {
        detail::PageFileHeader h = scene.header();
        change(h);
        CHECK_THROWS_AS(opened(with_header(scene.bytes, h)), std::runtime_error);
    };
    refuses([](auto& h) { h.page_bytes = 0; });
    refuses([](auto& h) { h.page_bytes *= 2; });
    refuses([](auto& h) { h.page_count = 0; });
    refuses([](auto& h) { h.page_count = 0xffffffffu; });
    refuses([](auto& h) {
        h.first_page = 0;
        h.file_bytes = std::uint64_t(h.page_count) * h.page_bytes;
    });
    refuses([](auto& h) { h.first_page = 1ull << 63; });
    refuses([](auto& h) { h.option_bytes = 0; });
    refuses([](auto& h) { h.option_bytes = 0xffffffffu; });
    refuses([](auto& h) { h.root.first_child = 0; });
    refuses([](auto& h) { h.root.first_child = 2; });
    refuses([](auto& h) { h.root.first_child_data |= 0xffffu; });
    refuses([](auto& h) { h.root.child_mask = 1; });
    refuses([](auto& h) { h.facts.fingerprint ^= 1; });
}

TEST_CASE("A file of pages says what it holds to whoever opens it as something else") {
    const TemporaryDirectory directory;
    const Scene scene(mixed_triangles(500, 5));
    const auto path = directory.path() / "scene.pages", plain = directory.path() / "plain.farfield";
    save_pages<Tensors, Triangle>(scene.hierarchy, scene.triangles, path, {.page_bytes = 4096});
    using Catch::Matchers::Contains;
    CHECK_THROWS_WITH((open_pages<Cubes, Triangle>(path)), Contains("scene.pages") && Contains("approximation"));
    save(scene.hierarchy, plain);
    CHECK_THROWS_WITH((open_pages<Tensors, Triangle>(plain)), Contains("plain.farfield") && Contains("open()"));
    CHECK_THROWS_AS((open<Tensors>(path)), std::runtime_error);
    CHECK_THROWS_AS((save_pages<Tensors, Triangle>(scene.hierarchy, Triangles(499), path)), std::invalid_argument);
    CHECK_THROWS_WITH((save_pages<Tensors, Triangle>(scene.hierarchy, scene.triangles, directory.path() / "no" / "x")),
                      Contains("x"));
}

TEST_CASE("No flipped bit in a page goes unseen, nor a page of another number or file") {
    const Scene& scene = mixed_scene();
    const detail::PageFileHeader h = scene.header();
    const Paged pages = opened(scene.bytes);
    struct alignas(64) Line {
        std::byte bytes[64];
    };
    std::vector<Line> lines(h.page_bytes / 64 + 1);
    const std::span<std::byte> page(lines[0].bytes, h.page_bytes);
    const auto fault = [&](std::uint32_t number, std::uint64_t fingerprint) {
        const char* const why = detail::unsound_page<Tensors, Triangle>(
            page, {number, h.page_count, fingerprint}, pages.partition_policy(), pages.approximation_policy());
        return std::string_view(why == nullptr ? "" : why);
    };
    Random random(11);
    for (const std::uint32_t number : {0u, 1u, h.page_count / 2, h.page_count - 1}) {
        std::memcpy(page.data(), scene.bytes.data() + h.first_page + std::size_t(number) * h.page_bytes, h.page_bytes);
        CHECK(fault(number, h.facts.fingerprint).empty());
        CHECK(fault(number + 1, h.facts.fingerprint) == "it is another page");
        CHECK(fault(number, h.facts.fingerprint + 1) == "it belongs to another file");
        detail::PageHeader header;
        std::memcpy(&header, page.data(), sizeof header);
        for (std::size_t at = 0; at < header.used_bytes; ++at) {
            const auto bit = std::byte(1u << random.below(8));
            page[at] ^= bit;
            INFO("byte " << at << " of page " << number);
            CHECK_FALSE(fault(number, h.facts.fingerprint).empty());
            page[at] ^= bit;
        }
    }
}

TEST_CASE(
    "Forged pages with right checksums are refused, or drawn as something else; nothing beyond memory is touched") {
    const Scene scene(mixed_triangles(3000, 5));
    const detail::PageFileHeader h = scene.header();
    Random random(17);
    int refused = 0, drawn = 0;
    for (int forgery = 0; forgery < 500; ++forgery) {
        Bytes bytes = scene.bytes;
        for (int changes = 0; changes < 1 + forgery % 3; ++changes) {
            const std::uint32_t number = random.below(h.page_count);
            const std::span<std::byte> page(bytes.data() + h.first_page + std::size_t(number) * h.page_bytes,
                                            h.page_bytes);
            detail::PageHeader header;
            std::memcpy(&header, page.data(), sizeof header);
            // A number of the header that counts something, or one of a node.
            const std::size_t place =
                forgery % 4 == 0 ? 8 + 4 * random.below(6) : 64 + 4 * std::size_t(random.below(4 * header.node_count));
            std::uint32_t value = 0;
            std::memcpy(&value, page.data() + place, 4);
            switch (random.below(5)) {
                case 0:
                    value += 1;
                    break;
                case 1:
                    value -= 1;
                    break;
                case 2:
                    value ^= 1u << random.below(32);
                    break;
                case 3:
                    value = std::uint32_t(random.bits());
                    break;
                default:
                    value = random.below(64);
                    break;
            }
            std::memcpy(page.data() + place, &value, 4);
            std::memcpy(&header, page.data(), sizeof header);
            if (header.used_bytes >= sizeof header && header.used_bytes <= h.page_bytes) {
                detail::sign_page(page, header.used_bytes);
            }
        }
        try {
            auto pages = opened(bytes);
            pages.wait_for_pages(true);
            ZBufferRenderer renderer;
            auto viewer = make_viewer(pages, renderer);
            viewer.frame(view_at(2, 0, 32));
            viewer.frame(view_at(0.5f, 1, 32));
            ++(pages.cache_stats().failures != 0 ? refused : drawn);
        } catch (const std::runtime_error&) {
            ++refused;
        }
    }
    CHECK(refused > 100);
    CHECK(drawn > 10);
}

TEST_CASE("A copy of a viewer draws what lies in pages with a renderer of its own") {
    auto pages = opened(mixed_scene().bytes);
    pages.wait_for_pages(true);
    ZBufferRenderer a, b;
    auto viewer = make_viewer(pages, a);
    Viewer<Paged, Triangle, ZBufferRenderer> other(viewer, b);
    viewer.frame(view_at(1, 1));
    other.frame(view_at(1, 1));
    CHECK(a.image() == b.image());
}

TEST_CASE("Thresholds of cells stay with them, wherever their pages come to lie") {
    const Scene& scene = mixed_scene();
    View v = view_at(1, 2, 96);
    v.tolerance_jitter = 1;
    for (const float fade : {0.0f, 0.7f}) {
        v.fade = fade;
        const Image expected = waiting_picture(opened(scene.bytes), v);
        auto pages = opened(scene.bytes);
        waiting_picture(pages, view_on_walk(0));  // other pages are there first
        waiting_picture(pages, view_on_walk(30));
        CHECK(waiting_picture(pages, v) == expected);
    }
}

TEST_CASE("While pages are missing there is something coarser in their place, and never a hole") {
    // A closed surface that fills the view.
    const Scene scene(sphere(glm::vec3(0), 1, 90, {90, 160, 220, 255}));
    const auto full = [](const Image& image) {
        return std::all_of(image.pixels().begin(), image.pixels().end(), [](Rgba8 p) { return p.a != 0; });
    };
    const View v = looking(glm::dvec3(0.2, 0.3, 1.08), glm::dvec3(0), 96, 1);
    ZBufferRenderer whole_renderer;
    auto whole = make_viewer(scene.hierarchy, scene.triangles, whole_renderer);
    whole.frame(v);
    REQUIRE(full(whole_renderer.image()));
    const double expected = coverage(whole_renderer.image());
    for (const std::size_t slots : {2u, 3u, 5u, 10u, 100u}) {
        const Paged pages =
            opened(scene.bytes, {.most_bytes = slots * scene.header().page_bytes + 8192, .loads_in_background = false});
        ZBufferRenderer renderer;
        auto viewer = make_viewer(pages, renderer);
        auto own = pages;
        for (int i = 0; i < 20; ++i) {
            const FrameStats stats = viewer.frame(v);
            INFO(slots << " slots, frame " << i);
            if (i == 0) CHECK(stats.cells_missing != 0);
            CHECK(full(renderer.image()));
            CHECK(coverage(renderer.image()) > 0.8 * expected);
            own.load_wanted();
        }
    }
}

TEST_CASE("Whoever stands still comes to the picture of whoever waits, and loads nothing after that") {
    const Scene& scene = mixed_scene();
    for (const bool background : {false, true}) {
        auto pages = opened(scene.bytes, {.loads_in_background = background, .first_retry = 1ms});
        const View v = view_at(1, 1);
        ZBufferRenderer renderer;
        auto viewer = make_viewer(pages, renderer);
        FrameStats stats;
        int frames = 0;
        do {
            stats = viewer.frame(v);
            if (background) {
                std::this_thread::sleep_for(1ms);
            } else {
                pages.load_wanted();
            }
        } while (stats.cells_missing != 0 && ++frames < 10000);
        CHECK(stats.cells_missing == 0);
        CHECK(renderer.image() == waiting_picture(opened(scene.bytes), v));
        viewer.frame(v);
        pages.load_wanted();
        const std::uint64_t loads = pages.cache_stats().loads;
        for (int i = 0; i < 100; ++i) CHECK(viewer.frame(v).cells_missing == 0);
        pages.load_wanted();
        CHECK(pages.cache_stats().loads == loads);
    }
}

TEST_CASE("Two viewers on threads, apart on one cache, draw what each would draw alone") {
    const Scene& scene = mixed_scene();
    auto pages = opened(scene.bytes, {.first_retry = 1ms});
    pages.wait_for_pages(true);
    std::vector<std::vector<Image>> pictures(2);
    std::vector<std::thread> threads;
    const auto view_of = [](std::size_t who, int step) {
        return who == 0 ? view_on_walk(step) : looking(glm::dvec3(-2.0, 0.1 * step, -1.0), glm::dvec3(-1, 0, 0), 96, 1);
    };
    for (std::size_t who = 0; who < 2; ++who) {
        threads.emplace_back([&, who] {
            ZBufferRenderer renderer;
            auto viewer = make_viewer(pages, renderer);
            for (int step = 0; step < 15; ++step) {
                viewer.frame(view_of(who, step));
                pictures[who].push_back(renderer.image());
            }
        });
    }
    for (std::thread& t : threads) t.join();
    const auto alone = opened(scene.bytes);
    for (std::size_t who = 0; who < 2; ++who) {
        for (int step = 0; step < 15; ++step) {
            CHECK(pictures[who][std::size_t(step)] == waiting_picture(alone, view_of(who, step)));
        }
    }
}

TEST_CASE("The more memory, the smaller the error on a walk, down to none") {
    const Scene& scene = mixed_scene();
    const auto alone = opened(scene.bytes);
    std::vector<Image> expected;
    for (int step = 0; step < 15; ++step) expected.push_back(waiting_picture(alone, view_on_walk(2 * step)));
    const std::uint64_t working_set = alone.cache_stats().resident;
    std::vector<double> errors;
    for (const std::uint64_t percent : {5u, 10u, 25u, 50u, 100u, 110u}) {
        const std::size_t slots = std::max<std::size_t>(2, std::size_t(working_set * percent / 100));
        auto pages = opened(scene.bytes, {.most_bytes = slots * alone.page_bytes() + alone.page_count() * 16 + 65536,
                                          .loads_in_background = false});
        ZBufferRenderer renderer;
        auto viewer = make_viewer(pages, renderer);
        double sum = 0;
        for (int step = 0; step < 15; ++step) {
            const View v = view_on_walk(2 * step);
            for (int i = 0; i < 6; ++i) {  // a page leads to the next
                viewer.frame(v);
                pages.load_wanted();
            }
            viewer.frame(v);
            sum += rms_difference(renderer.image(), expected[std::size_t(step)]);
        }
        errors.push_back(sum);
    }
    for (std::size_t i = 1; i < errors.size(); ++i) {
        INFO(errors[i - 1] << " then " << errors[i]);
        CHECK(errors[i] <= errors[i - 1] * 1.05);
    }
    CHECK(errors.front() > 0);
    CHECK(errors.back() == 0);
}

TEST_CASE("A cache smaller than what is looked at reads no page more than twice within sixty frames") {
    const Scene& scene = mixed_scene();
    Memory memory{scene.bytes};
    const auto source = std::make_shared<Faulty>(memory);
    auto pages = open_pages_of<Tensors, Triangle>(
        source, "memory", {.most_bytes = 16 * scene.header().page_bytes + 16384, .loads_in_background = false});
    ZBufferRenderer renderer;
    auto viewer = make_viewer(pages, renderer);
    std::map<std::uint64_t, std::vector<int>> frames_of_page;
    std::size_t known = source->reads().size();
    for (int i = 0; i < 400; ++i) {
        viewer.frame(view_on_walk(i / 10 % 2 == 0 ? i % 10 : 40 - i % 10, 2, 32));
        pages.load_wanted();
        const auto reads = source->reads();
        for (; known < reads.size(); ++known) {
            for (std::uint64_t at = 0; at < reads[known].count; at += pages.page_bytes()) {
                frames_of_page[reads[known].offset + at].push_back(i);
            }
        }
    }
    CHECK(pages.cache_stats().evictions > 10);
    for (const auto& [page, frames] : frames_of_page) {
        for (std::size_t i = 2; i < frames.size(); ++i) CHECK(frames[i] - frames[i - 2] >= 60);
    }
}

TEST_CASE("Nothing leads nowhere: what is in memory can be come to, however walks have counted it") {
    const Scene scene(mixed_triangles(20000, 7), 2048);
    Memory memory{scene.bytes};
    for (std::uint64_t seed = 1; seed <= 4; ++seed) {
        const auto source = std::make_shared<Faulty>(memory);
        auto pages = open_pages_of<Tensors, Triangle>(
            source, "memory", {.most_bytes = 20 * scene.header().page_bytes + 16384, .loads_in_background = false});
        Random random(seed);
        // Every second cell, each counting for what comes up; or all, and which pages they lie in.
        const auto walk = [&](const Paged& user, bool all) {
            std::set<std::uint32_t> reached{0};
            const auto visit = [&](auto&& self, Subtree subtree) -> void {
                if (const Node node = user.nodes()[subtree.node]; user.is_portal(node)) {
                    if (!all && random.below(2) == 0) return;
                    if (!user.follow(subtree, all ? 0 : random.between(1, 100))) return;
                    reached.insert(detail::portal_of(node).page);
                }
                for_each_child<VisitOrder::any>(user, subtree, glm::vec4(0, 0, 0, 1),
                                                [&](const Subtree& child) { self(self, child); });
            };
            user.begin_frame();
            visit(visit, user.whole());
            user.end_frame();
            return reached.size();
        };
        const Paged a = pages, b = pages, whoever_looks = pages;
        std::vector<std::size_t> reads_until{source->reads().size()};
        std::size_t in_use = 0;
        for (int i = 0; i < 200; ++i) {
            walk(random.below(2) == 0 ? a : b, false);
            while (pages.load_wanted() != 0) {
            }
            const auto reached = walk(whoever_looks, true);
            whoever_looks.begin_frame();  // to want nothing
            whoever_looks.end_frame();
            whoever_looks.forget();
            // What came back stays, whatever leads to it.
            const auto reads = source->reads();
            reads_until.push_back(reads.size());
            std::map<std::uint64_t, std::size_t> times;
            std::size_t held = 0;
            for (std::size_t r = 0; r < reads.size(); ++r) {
                for (std::uint64_t at = 0; at < reads[r].count; at += pages.page_bytes()) {
                    const bool is_again = ++times[reads[r].offset + at] > 1;
                    held += is_again && r >= reads_until[std::size_t(std::max(0, i - 60))];
                }
            }
            const std::size_t resident = pages.cache_stats().resident;
            REQUIRE(reached <= resident);
            REQUIRE(reached + held >= resident);
            in_use += reached;
        }
        CHECK(in_use > 200 * 5);
        CHECK(pages.cache_stats().evictions > 50);
    }
}

TEST_CASE("A source that fails gives coarser pictures, and whole ones when it recovers") {
    const Scene& scene = mixed_scene();
    Memory memory{scene.bytes};
    const auto source = std::make_shared<Faulty>(memory);
    const auto pages = open_pages_of<Tensors, Triangle>(source, "memory", {.first_retry = 1ms, .longest_retry = 4ms});
    const View v = view_at(1, 1);
    const Image expected = waiting_picture(opened(scene.bytes), v);
    ZBufferRenderer renderer;
    auto viewer = make_viewer(pages, renderer);
    for (const Fault& fault : {Fault{.status = ReadStatus::unavailable}, Fault{.flipped_bits = 3}}) {
        source->fail(fault);
        for (int i = 0; i < 10; ++i) {
            CHECK(viewer.frame(v).cells_missing != 0);
            CHECK(coverage(renderer.image()) > 0);
            std::this_thread::sleep_for(1ms);
        }
    }
    source->recover();
    int frames = 0;
    while (viewer.frame(v).cells_missing != 0 && ++frames < 10000) std::this_thread::sleep_for(1ms);
    CHECK(renderer.image() == expected);
}

TEST_CASE("Whoever moves on finds pages there that he would otherwise miss") {
    const Scene& scene = mixed_scene();
    // All that a frame has asked for is there before the next one.
    const auto missing_on_walk = [&](bool knows_motion) {
        auto pages = opened(scene.bytes);
        ZBufferRenderer renderer;
        auto viewer = make_viewer(pages, renderer);
        std::uint64_t missing = 0;
        for (int step = 0; step < 40; ++step) {
            const View view = view_on_walk(step);
            if (knows_motion) {
                missing += viewer.frame(view).cells_missing * (step > 6);
            } else {
                auto stranger = make_viewer(pages, renderer);
                missing += stranger.frame(view).cells_missing * (step > 6);
            }
            while (pages.load_wanted() != 0) viewer.frame(view);
        }
        return missing;
    };
    const std::uint64_t with = missing_on_walk(true), without = missing_on_walk(false);
    INFO(with << " " << without);
    CHECK(with < without / 2);
}

TEST_CASE("A forged file that leads to the same contents by many ways takes no longer than one that does not") {
    const Scene scene(random_triangles(30000, 6), 8192);
    const detail::PageFileHeader h = scene.header();
    Bytes bytes = scene.bytes;
    // Every node elsewhere is the first one of its page that is: as many ways as there were nodes, for each of the few
    // that are left.
    for (std::uint32_t number = 0; number < h.page_count; ++number) {
        const auto page =
            std::span(bytes).subspan(std::size_t(h.first_page) + std::size_t(number) * h.page_bytes, h.page_bytes);
        detail::PageHeader header;
        std::memcpy(&header, page.data(), sizeof header);
        Node first;
        for (std::uint32_t n = 0; n < header.node_count; ++n) {
            std::byte* const at = page.data() + sizeof header + n * sizeof(Node);
            Node node;
            std::memcpy(&node, at, sizeof node);
            if (!detail::is_portal(node)) continue;
            // What lies in the same page comes behind; that is for pages of several levels.
            if (node.first_child == 1) continue;
            if (first.first_child == 0) first = node;
            node.first_child = first.first_child;
            node.first_child_data = first.first_child_data;
            std::memcpy(at, &node, sizeof node);
        }
        detail::sign_page(page, header.used_bytes);
    }
    auto pages = opened(bytes);
    pages.wait_for_pages(true);
    ZBufferRenderer renderer;
    auto viewer = make_viewer(pages, renderer);
    const FrameStats stats = viewer.frame(view_at(2, 0));
    CHECK(stats.cells_missing > 0);
    std::uint64_t nodes = 0;
    for (std::uint32_t number = 0; number < h.page_count; ++number) {
        detail::PageHeader header;
        std::memcpy(&header, bytes.data() + h.first_page + std::size_t(number) * h.page_bytes, sizeof header);
        nodes += header.node_count;
    }
    CHECK(stats.cells_visited <= 2 * nodes);
}
