#include "farfield/paging/page_cache.hpp"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <map>
#include <memory>
#include <span>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "catch.hpp"
#include "farfield/paging/page_user.hpp"
#include "paging/faulty_source.hpp"
#include "support/random.hpp"

using namespace farfield;
using namespace farfield::test;
using namespace std::chrono_literals;
using farfield::detail::PageCache;
using farfield::detail::PageSlots;
using farfield::detail::PageUser;

namespace {

constexpr std::uint32_t page_bytes = 1024;
constexpr std::uint64_t first_page = 512;

std::vector<std::byte> numbered_pages(std::uint32_t count) {
    std::vector<std::byte> bytes(first_page + std::size_t(count) * page_bytes);
    for (std::size_t i = 0; i < std::size_t(count) * page_bytes / 4; ++i) {
        const auto number = std::uint32_t(i / (page_bytes / 4));
        std::memcpy(bytes.data() + first_page + 4 * i, &number, 4);
    }
    return bytes;
}
bool is_full_of(std::span<const std::byte> page, std::uint32_t number) {
    for (std::size_t i = 0; i < page.size(); i += 4) {
        std::uint32_t n = 0;
        std::memcpy(&n, page.data() + i, 4);
        if (n != number) return false;
    }
    return true;
}
PageCacheOptions by_hand(std::size_t most_bytes = 1 << 20) {
    return {.most_bytes = most_bytes, .loads_in_background = false, .first_retry = 1ms, .longest_retry = 1ms};
}
PageCacheOptions in_background(std::size_t most_bytes = 1 << 20) {
    return {.most_bytes = most_bytes, .first_retry = 2ms, .longest_retry = 8ms};
}

/// Pages that are full of their number, behind faults.
struct Pages {
    std::vector<std::byte> bytes;
    MemorySource memory;
    FaultySource<MemorySource> source;
    std::shared_ptr<PageCache> cache;

    Pages(std::uint32_t count, const PageCacheOptions& options, ReadMerging merging = {0, page_bytes, 2})
        : bytes(numbered_pages(count)), memory(bytes, merging), source(memory) {
        open(count, options);
    }
    void open(std::uint32_t count, const PageCacheOptions& options) {
        cache = std::make_shared<PageCache>(
            "numbers", detail::PagePlaces{first_page, page_bytes, count}, source.merging(),
            [this](std::uint64_t offset, std::span<std::byte> to) { return source.read(offset, to); },
            [](std::span<std::byte> page, std::uint32_t number, std::uint64_t) {
                return is_full_of(page, number) ? nullptr : "it is not full of its number";
            },
            options, [this] { source.cancel(); });
    }
    std::span<const std::byte> memory_of(std::uint32_t slot) const {
        return {cache->memory() + std::size_t(slot) * page_bytes, page_bytes};
    }
    /// The pages of reads from the `first` on.
    std::vector<std::vector<std::uint32_t>> reads_from(std::size_t first) const {
        std::vector<std::vector<std::uint32_t>> all;
        const auto reads = source.reads();
        for (std::size_t i = first; i < reads.size(); ++i) {
            auto& pages = all.emplace_back();
            for (std::uint64_t at = 0; at < reads[i].count; at += page_bytes) {
                pages.push_back(std::uint32_t((reads[i].offset + at - first_page) / page_bytes));
            }
        }
        return all;
    }
};

struct Wanted {
    std::uint32_t page;
    float weight = 2;
};
/// Returns how many were there, each full of its number.
std::size_t frame(const Pages& pages, PageUser& user, const std::vector<Wanted>& wanted) {
    std::size_t found = 0;
    user.begin_frame();
    for (const Wanted& w : wanted) {
        const std::uint32_t slot = user.find(w.page, w.weight);
        if (slot == PageSlots::none) continue;
        CHECK(is_full_of(pages.memory_of(slot), w.page));
        ++found;
    }
    user.end_frame();
    return found;
}
std::vector<Wanted> range(std::uint32_t begin, std::uint32_t end, float weight = 2) {
    std::vector<Wanted> all;
    for (std::uint32_t p = begin; p < end; ++p) all.push_back({p, weight});
    return all;
}
/// What other threads will do soon, or a busy machine later.
template <class Condition>
bool comes_true(Condition&& condition) {
    for (int i = 0; i < 20000; ++i) {
        if (condition()) return true;
        std::this_thread::sleep_for(500us);
    }
    return false;
}
using Reads = std::vector<std::vector<std::uint32_t>>;

}  // namespace

TEST_CASE("The first page is there at once and stays, others are read when frames have asked for them") {
    Pages p(20, by_hand());
    PageUser user(p.cache);
    CHECK(frame(p, user, {{0}, {3}, {7}}) == 1);
    CHECK(p.cache->stats().missing == 2);
    CHECK(p.cache->load_wanted() == 2);
    CHECK(p.cache->load_wanted() == 0);
    CHECK(frame(p, user, {{0}, {3}, {7}}) == 3);
    const PageCacheStats stats = p.cache->stats();
    CHECK(stats.loads == 3);
    CHECK(stats.reads == 3);
    CHECK(stats.bytes_read == 3 * page_bytes);
    CHECK(stats.resident == 3);
    CHECK(stats.missing == 0);
}

TEST_CASE("A cache keeps to its limit in bytes at any part of the pages, and says what the least is") {
    constexpr std::uint32_t count = 200;
    for (const std::size_t percent : {5u, 10u, 25u, 50u, 100u}) {
        for (const bool background : {false, true}) {
            const std::size_t most = count * page_bytes * percent / 100;
            Pages p(count, background ? in_background(most) : by_hand(most), {page_bytes, 4 * page_bytes, 2});
            CHECK(p.cache->stats().bytes <= most);
            CHECK(p.cache->memory_bytes() < most);
            PageUser user(p.cache);
            for (std::uint32_t step = 0; step < 60; ++step) {
                frame(p, user, range(step * 2, step * 2 + 80));
                if (!background) p.cache->load_wanted();
                CHECK(p.cache->stats().resident * page_bytes <= p.cache->memory_bytes());
            }
            CHECK(p.cache->stats().bytes <= most);
        }
    }
    for (const bool background : {false, true}) {
        const auto options = [&](std::size_t most) { return background ? in_background(most) : by_hand(most); };
        std::size_t least = 0;
        try {
            Pages(count, options(page_bytes));
        } catch (const std::invalid_argument& e) {
            const std::string message = e.what();
            CHECK_THAT(message, Catch::Matchers::Contains("numbers") && Catch::Matchers::Contains("most_bytes"));
            least = std::stoull(message.substr(message.find("at least ") + 9));
        }
        REQUIRE(least > 2 * page_bytes);
        CHECK_NOTHROW(Pages(count, options(least)));
        CHECK_THROWS_AS(Pages(count, options(least - 1)), std::invalid_argument);
        Pages p(count, options(least));
        CHECK(p.cache->memory_bytes() == 2 * page_bytes);
        CHECK(p.cache->stats().bytes <= least);
    }
}

TEST_CASE("A first page that cannot be used is said when the cache is made, with its reason") {
    Pages p(5, by_hand());
    p.source.fail({.status = ReadStatus::unavailable});
    CHECK_THROWS_WITH(p.open(5, by_hand()),
                      Catch::Matchers::Contains("numbers") && Catch::Matchers::Contains("a fault of the test"));
    p.source.fail({.flipped_bits = 1});
    CHECK_THROWS_WITH(p.open(5, by_hand()), Catch::Matchers::Contains("page 0: it is not full of its number"));
    p.source.recover();
    CHECK_NOTHROW(p.open(5, by_hand()));
}

TEST_CASE("Frames go on while the source gives no answer") {
    Pages p(50, in_background());
    PageUser user(p.cache);
    p.source.hold();
    for (int i = 0; i < 50; ++i) CHECK(frame(p, user, range(0, 50)) == 1);
    CHECK(comes_true([&] { return p.source.in_flight() == 2; }));
    for (int i = 0; i < 50; ++i) CHECK(frame(p, user, range(0, 50)) == 1);
    CHECK(p.source.most_in_flight() == 2);
    p.source.recover();
    CHECK(comes_true([&] { return frame(p, user, range(0, 50)) == 50; }));
}

TEST_CASE("What is unavailable is tried again, less and less often, until it is there") {
    Pages p(10, {.first_retry = 4ms, .longest_retry = 64ms});
    PageUser user(p.cache);
    p.source.fail({.status = ReadStatus::unavailable});
    const std::size_t before = p.source.reads().size();
    const auto begin = std::chrono::steady_clock::now();
    while (std::chrono::steady_clock::now() - begin < 300ms) {
        frame(p, user, {{4}});
        std::this_thread::sleep_for(1ms);
    }
    const std::size_t tried = p.source.reads().size() - before;
    CHECK(tried >= 2);
    CHECK(tried <= 10);  // at 0, 4, 12, 28, 60, 124, 188, 252 ms, or later
    CHECK(p.cache->stats().failures == tried);
    CHECK(p.cache->stats().last_failure == "a fault of the test");
    p.source.recover();
    CHECK(comes_true([&] { return frame(p, user, {{4}}) == 1; }));
}

TEST_CASE("Waits between two attempts of nothing are not taken at their word") {
    Pages p(10, {.first_retry = 0ms, .longest_retry = 0ms});
    PageUser user(p.cache);
    p.source.fail({.status = ReadStatus::unavailable});
    frame(p, user, {{4}});
    CHECK(comes_true([&] { return p.cache->stats().failures >= 3; }));
    p.source.recover();
    CHECK(comes_true([&] { return frame(p, user, {{4}}) == 1; }));
}

TEST_CASE("A source that has changed is not read any more, and the reason is kept") {
    Pages p(10, in_background());
    PageUser user(p.cache);
    CHECK(comes_true([&] { return frame(p, user, {{1}, {2}}) == 2; }));
    p.source.fail({.status = ReadStatus::changed});
    frame(p, user, {{3}});
    REQUIRE(comes_true([&] { return p.cache->stats().failures > 0; }));
    p.source.recover();
    const std::size_t reads = p.source.reads().size();
    for (int i = 0; i < 20; ++i) {
        CHECK(frame(p, user, range(0, 6)) == 3);
        std::this_thread::sleep_for(1ms);
    }
    CHECK(p.cache->load_wanted() == 0);
    user.begin_frame();
    CHECK(user.find_or_wait(5, 2) == PageSlots::none);
    user.end_frame();
    CHECK(p.source.reads().size() == reads);
    CHECK(p.cache->stats().last_failure == "a fault of the test");
}

TEST_CASE("What is refused is not asked for again, and what lies beside it is there") {
    for (const std::uint32_t largest_read : {1u, 8u}) {
        Pages p(20, by_hand(), {0, largest_read * page_bytes, 1});
        PageUser user(p.cache);
        p.source.fail_at(first_page + 5 * page_bytes, first_page + 6 * page_bytes, {.status = ReadStatus::refused});
        for (int i = 0; i < 30; ++i) {
            frame(p, user, range(1, 12));
            p.cache->load_wanted();
            std::this_thread::sleep_for(1ms);
        }
        CHECK(frame(p, user, range(1, 12)) == 10);
        std::size_t asked = 0;
        for (const auto& pages : p.reads_from(0)) asked += std::count(pages.begin(), pages.end(), 5u) != 0;
        CHECK(asked <= 2);
        p.source.recover();
        p.cache->load_wanted();
        CHECK(frame(p, user, range(1, 12)) == 10);
    }
}

TEST_CASE("A page that cannot be read keeps none away that lie beside it") {
    Pages p(20, in_background(), {0, 8 * page_bytes, 1});
    PageUser user(p.cache);
    p.source.fail_at(first_page + 5 * page_bytes, first_page + 6 * page_bytes, {.status = ReadStatus::unavailable});
    CHECK(comes_true([&] { return frame(p, user, range(1, 12)) == 10; }));
    p.source.recover();
    CHECK(comes_true([&] { return frame(p, user, range(1, 12)) == 11; }));
}

TEST_CASE("Damaged pages are refused one by one, and read again") {
    Pages p(20, in_background(), {0, 8 * page_bytes, 1});
    PageUser user(p.cache);
    p.source.fail({.flipped_bits = 1});
    frame(p, user, range(1, 9));
    REQUIRE(comes_true([&] { return p.cache->stats().failures >= 1; }));
    CHECK_THAT(p.cache->stats().last_failure, Catch::Matchers::Contains("it is not full of its number"));
    p.source.recover();
    CHECK(comes_true([&] { return frame(p, user, range(1, 9)) == 8; }));
}

TEST_CASE("Pages that lie near one another are read together, the most wanted first") {
    Pages p(60, by_hand(), {2 * page_bytes, 6 * page_bytes, 1});
    PageUser user(p.cache);
    SECTION("in a row, as far as a read goes") {
        frame(p, user, {{10, 1}, {11, 1}, {12, 5}, {13, 1}, {14, 1}, {15, 1}, {16, 1}, {17, 1}, {18, 1}, {40, 2}});
        CHECK(p.cache->load_wanted() == 10);
        CHECK(p.reads_from(1) == Reads{{12, 13, 14, 15, 16, 17}, {40}, {10, 11}, {18}});
    }
    SECTION("over gaps") {
        frame(p, user, {{20, 9}, {23, 1}, {24, 1}, {17, 1}, {27, 1}});
        CHECK(p.cache->load_wanted() == 5);
        CHECK(p.reads_from(1) == Reads{{20, 21, 22, 23, 24}, {17}, {27}});
        CHECK(frame(p, user, {{21}, {22}}) == 0);  // what lay between was thrown away
    }
    SECTION("backward") {
        frame(p, user, {{30, 9}, {29, 1}, {27, 1}, {25, 1}, {24, 1}});
        CHECK(p.cache->load_wanted() == 5);
        CHECK(p.reads_from(1) == Reads{{25, 26, 27, 28, 29, 30}, {24}});
    }
    SECTION("but for what is there") {
        frame(p, user, {{11}, {13}});
        p.cache->load_wanted();
        frame(p, user, range(10, 15));
        p.cache->load_wanted();
        CHECK(frame(p, user, range(10, 15)) == 5);
        CHECK(p.cache->stats().loads == 6);
    }
}

TEST_CASE("What counts most is read first, whoever wants it, and what is only expected last") {
    Pages p(60, by_hand());
    PageUser a(p.cache), b(p.cache);
    a.begin_frame();
    a.find(10, 2);
    a.expect(20, 9);
    a.find(30, 7);
    a.find(10, 5);
    a.end_frame();
    frame(p, b, {{40, 6}, {50, 1}});
    CHECK(p.cache->load_wanted() == 5);
    CHECK(p.reads_from(1) == Reads{{30}, {40}, {10}, {50}, {20}});
}

TEST_CASE("Weights may be anything") {
    Pages p(600, by_hand(40 * page_bytes));
    PageUser user(p.cache);
    constexpr float infinity = std::numeric_limits<float>::infinity(), nan = std::numeric_limits<float>::quiet_NaN();
    for (std::uint32_t round = 0; round < 10; ++round) {
        user.begin_frame();
        for (std::uint32_t i = 1; i < 600; ++i) {
            const float weight = i % 5 == 0 ? nan : i % 5 == 1 ? -nan : i % 5 == 2 ? infinity : i % 5 == 3 ? 0 : -1.0f;
            user.find((i * 7 + round) % 600, weight);
            user.expect((i * 11 + round) % 600, weight);
        }
        user.end_frame();
        p.cache->load_wanted();
    }
    CHECK(p.cache->stats().loads > 20);
}

TEST_CASE("A frame that waits has what it asks for, as long as there is room") {
    for (const bool background : {false, true}) {
        const std::size_t most = 12 * page_bytes;
        Pages p(40, background ? in_background(most) : by_hand(most));
        const auto slots = std::uint32_t(p.cache->memory_bytes() / page_bytes);
        PageUser user(p.cache);
        for (std::uint32_t begin = 1; begin < 25; ++begin) {
            user.begin_frame();
            std::vector<std::uint32_t> seen;
            for (std::uint32_t page = begin; page < begin + slots - 1; ++page) {
                const std::uint32_t slot = user.find_or_wait(page, 2);
                REQUIRE(slot != PageSlots::none);
                seen.push_back(slot);
                for (std::size_t i = 0; i < seen.size(); ++i) {
                    CHECK(is_full_of(p.memory_of(seen[i]), begin + std::uint32_t(i)));
                }
            }
            // All that there is holds what this frame uses.
            CHECK(user.find_or_wait(39, 2) == PageSlots::none);
            user.end_frame();
            for (int i = 0; i < 61; ++i) frame(p, user, {});  // so that none is held
        }
    }
}

TEST_CASE("A frame that waits gets the room that another one's frame holds, when that ends") {
    Pages p(60, {.most_bytes = 4 * page_bytes + 2000, .loads_in_background = false, .first_retry = 1ms});
    PageUser a(p.cache), b(p.cache);
    frame(p, a, range(1, 20));
    p.cache->load_wanted();
    a.begin_frame();
    for (std::uint32_t i = 0; i < 60; ++i) a.find(i, 1);
    std::atomic<bool> is_done{false};
    std::thread other([&] {
        b.begin_frame();
        const std::uint32_t slot = b.find_or_wait(50, 9);
        is_done = slot != PageSlots::none && is_full_of(p.memory_of(slot), 50);
        b.end_frame();
    });
    std::this_thread::sleep_for(30ms);
    CHECK_FALSE(is_done);
    a.end_frame();
    other.join();
    CHECK(is_done);
}

TEST_CASE("Two frames that wait at once do not wait for each other") {
    Pages p(60, {.most_bytes = 4 * page_bytes + 2000, .loads_in_background = false, .first_retry = 1ms});
    std::vector<std::thread> threads;
    for (std::uint32_t t = 0; t < 3; ++t) {
        threads.emplace_back([&, t] {
            PageUser user(p.cache);
            for (std::uint32_t round = 0; round < 50; ++round) {
                user.begin_frame();
                for (std::uint32_t i = 0; i < 8; ++i) {
                    const std::uint32_t page = (13 * t + 7 * round + i) % 60;
                    const std::uint32_t slot = user.find_or_wait(page, float(1 + i));
                    if (slot != PageSlots::none && !is_full_of(p.memory_of(slot), page)) std::abort();
                }
                user.end_frame();
            }
        });
    }
    for (std::thread& t : threads) t.join();
    CHECK(p.cache->stats().loads > 20);
}

TEST_CASE("Of what is only expected some pages are read each frame") {
    Pages p(600, by_hand());
    PageUser user(p.cache);
    user.begin_frame();
    for (std::uint32_t i = 1; i < 200; ++i) user.expect(i, float(i));
    for (std::uint32_t i = 300; i < 320; ++i) user.find(i, 2);
    user.end_frame();
    CHECK(p.cache->load_wanted() == 28);
}

TEST_CASE("A frame enters what is in a page twice as often as it is there, and no more") {
    Pages p(10, by_hand());
    PageUser user(p.cache);
    for (int i = 0; i < 3; ++i) {
        user.begin_frame();
        for (int n = 0; n < 10; ++n) CHECK(user.may_enter(3, 5));
        CHECK_FALSE(user.may_enter(3, 5));
        CHECK(user.may_enter(4, 1));
        user.end_frame();
    }
}

TEST_CASE("Two that wait for a page read it once") {
    Pages p(10, by_hand());
    p.source.hold();
    std::vector<std::thread> threads;
    std::atomic<int> found{0};
    for (int i = 0; i < 3; ++i) {
        threads.emplace_back([&] {
            PageUser user(p.cache);
            user.begin_frame();
            found += user.find_or_wait(7, 2) != PageSlots::none;
            user.end_frame();
        });
    }
    CHECK(comes_true([&] { return p.source.in_flight() == 1; }));
    std::this_thread::sleep_for(5ms);
    p.source.recover();
    for (std::thread& t : threads) t.join();
    CHECK(found == 3);
    CHECK(p.source.reads().size() == 2);
}

TEST_CASE("Loading what is wanted waits for what is being loaded already") {
    Pages p(10, in_background());
    PageUser user(p.cache);
    p.source.hold();
    frame(p, user, {{7}});
    REQUIRE(comes_true([&] { return p.source.in_flight() == 1; }));
    std::thread opens([&] {
        std::this_thread::sleep_for(5ms);
        p.source.recover();
    });
    CHECK(p.cache->load_wanted() == 0);
    CHECK(frame(p, user, {{7}}) == 1);
    opens.join();
}

TEST_CASE("Caches go while reads run, without waiting for their answers") {
    for (int i = 0; i < 20; ++i) {
        Pages p(50, in_background());
        {
            PageUser user(p.cache);
            if (i % 2 == 0) p.source.hold();
            frame(p, user, range(1, 50));
            if (i % 2 == 0) CHECK(comes_true([&] { return p.source.in_flight() != 0; }));
        }
        p.cache.reset();
        CHECK(p.source.in_flight() == 0);
    }
}

TEST_CASE("Whoever stands still loads nothing more, whatever the limit") {
    for (const std::size_t slots : {4u, 12u, 40u}) {
        Pages p(60, by_hand(slots * page_bytes + 4096));
        PageUser user(p.cache);
        std::vector<Wanted> wanted;
        Random random(slots);
        for (std::uint32_t page = 0; page < 30; ++page) wanted.push_back({page, random.between(1, 20)});
        for (int i = 0; i < 100; ++i) {
            frame(p, user, wanted);
            p.cache->load_wanted();
        }
        const std::uint64_t loads = p.cache->stats().loads;
        for (int i = 0; i < 200; ++i) {
            frame(p, user, wanted);
            p.cache->load_wanted();
        }
        CHECK(p.cache->stats().loads == loads);
    }
}

TEST_CASE("Whoever looks to and fro has no page read more than twice in sixty frames") {
    for (const std::size_t slots : {4u, 12u, 25u}) {
        Pages p(100, by_hand(slots * page_bytes + 4096));
        PageUser user(p.cache);
        std::map<std::uint32_t, std::vector<std::size_t>> frames_of_page;
        std::size_t known = p.source.reads().size();
        for (std::size_t i = 0; i < 600; ++i) {
            const auto at = std::uint32_t(i / 7 % 2 == 0 ? 0 : 50);
            frame(p, user, range(at + 1, at + 30, 2 + float(i % 5)));
            p.cache->load_wanted();
            for (const auto& pages : p.reads_from(known)) {
                for (const std::uint32_t page : pages) frames_of_page[page].push_back(i);
                ++known;
            }
        }
        for (const auto& [page, frames] : frames_of_page) {
            for (std::size_t i = 2; i < frames.size(); ++i) CHECK(frames[i] - frames[i - 2] >= 60);
        }
    }
}

TEST_CASE("Several on one cache, behind faults of all kinds, see pages that are what they should be") {
    Pages p(80, in_background(24 * page_bytes), {page_bytes, 4 * page_bytes, 2});
    p.source.fail_sometimes(200, {.flipped_bits = 2});
    std::atomic<int> wrong{0};
    std::atomic<std::size_t> found{0};
    std::vector<std::thread> threads;
    for (std::uint64_t seed = 1; seed <= 3; ++seed) {
        threads.emplace_back([&, seed] {
            Random random(seed);
            for (int life = 0; life < 4; ++life) {
                PageUser user(p.cache);
                for (int i = 0; i < 300; ++i) {
                    user.begin_frame();
                    std::vector<std::pair<std::uint32_t, std::uint32_t>> seen;
                    for (int k = 0; k < 20; ++k) {
                        const std::uint32_t page = random.below(80);
                        const float weight = random.between(0.5f, 30);
                        const std::uint32_t slot =
                            seed == 1 && k % 8 == 0 ? user.find_or_wait(page, weight) : user.find(page, weight);
                        if (slot != PageSlots::none) seen.emplace_back(page, slot);
                    }
                    for (const auto& [page, slot] : seen) wrong += !is_full_of(p.memory_of(slot), page);
                    found += seen.size();
                    user.end_frame();
                    if (seed == 2 && i % 16 == 0) p.cache->load_wanted();
                    if (seed == 3 && i == 30) p.source.fail_next(3, {.status = ReadStatus::unavailable});
                }
            }
        });
    }
    for (std::thread& t : threads) t.join();
    CHECK(wrong == 0);
    CHECK(found > 100);
    CHECK(p.cache->stats().failures > 0);
    CHECK(p.cache->stats().resident * page_bytes <= p.cache->memory_bytes());
}
