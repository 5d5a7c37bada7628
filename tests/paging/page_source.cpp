#include "farfield/paging/page_source.hpp"

#include <atomic>
#include <bit>
#include <limits>
#include <thread>
#include <vector>

#include "catch.hpp"
#include "faulty_source.hpp"

using namespace farfield;
using test::Fault;
using test::FaultySource;
using test::MemorySource;

namespace {

template <class Size, class Result, bool is_noexcept>
struct Source {
    Size size() const noexcept(is_noexcept);
    ReadMerging merging() const noexcept;
    Result read(std::uint64_t, std::span<std::byte>) noexcept;
};
static_assert(PageSource<Source<std::uint64_t, ReadResult, true>>);
static_assert(!PageSource<Source<std::uint32_t, ReadResult, true>>);
static_assert(!PageSource<Source<std::uint64_t, ReadStatus, true>>);
static_assert(!PageSource<Source<std::uint64_t, ReadResult, false>>);
static_assert(!CancellablePageSource<MemorySource>);

constexpr std::uint64_t most = std::numeric_limits<std::uint64_t>::max();

}  // namespace

TEST_CASE("whether bytes lie within a file, at the edges of 64 bits too") {
    STATIC_REQUIRE(detail::lies_within(10, 0, 10));
    STATIC_REQUIRE(detail::lies_within(10, 10, 0));
    STATIC_REQUIRE(detail::lies_within(0, 0, 0));
    STATIC_REQUIRE(detail::lies_within(most, most, 0));
    STATIC_REQUIRE(!detail::lies_within(10, 11, 0));
    STATIC_REQUIRE(!detail::lies_within(10, 9, 2));
    STATIC_REQUIRE(!detail::lies_within(10, most, most));
    STATIC_REQUIRE(!detail::lies_within(10, 1, most));
}

TEST_CASE("a read that was not done says so in one line") {
    CHECK(not_read(ReadStatus::changed, {"a", ": ", "b"}).message == "a: b");
    CHECK(not_read(ReadStatus::changed, {}).status == ReadStatus::changed);
    const ReadResult beyond = detail::beyond_the_end("f", 10, 9, 2);
    CHECK(beyond.status == ReadStatus::refused);
    CHECK(beyond.message == "f: 2 bytes at 9 are asked for, beyond its end at 10");
}

TEST_CASE("the faults of a source for tests are those that were asked for") {
    const auto all = test::random_bytes(1000);
    MemorySource memory(all);
    FaultySource source(memory, 7);
    std::vector<std::byte> bytes(100);
    const auto status_at = [&](std::uint64_t at) { return source.read(at, bytes).status; };
    const auto differing_bits = [&] {
        int count = 0;
        for (std::size_t i = 0; i < bytes.size(); ++i) count += std::popcount(std::uint8_t(bytes[i] ^ all[i]));
        return count;
    };

    CHECK(status_at(0) == ReadStatus::done);
    CHECK(differing_bits() == 0);
    CHECK(status_at(901) == ReadStatus::refused);

    source.fail({.status = ReadStatus::unavailable});
    source.fail_at(200, 300, {.status = ReadStatus::refused});
    source.fail_next(2, {.status = ReadStatus::changed});
    CHECK(status_at(200) == ReadStatus::changed);
    CHECK(status_at(0) == ReadStatus::changed);
    CHECK(status_at(100) == ReadStatus::unavailable);
    CHECK(status_at(101) == ReadStatus::refused);
    CHECK(status_at(299) == ReadStatus::refused);
    CHECK(status_at(300) == ReadStatus::unavailable);

    source.recover();
    source.fail({.flipped_bits = 1});
    CHECK(status_at(0) == ReadStatus::done);
    CHECK(differing_bits() == 1);

    source.recover();
    source.fail_sometimes(300, {.status = ReadStatus::unavailable});
    source.forget_reads();
    int failed = 0;
    for (int i = 0; i < 1000; ++i) failed += status_at(0) == ReadStatus::unavailable;
    CHECK(failed > 250);
    CHECK(failed < 350);
    CHECK(source.bytes_asked() == 100'000);
    CHECK(source.most_in_flight() == 1);
}

TEST_CASE("reads of a source for tests are held until they are let go or given up") {
    const auto all = test::random_bytes(1000);
    MemorySource memory(all);
    FaultySource source(memory);
    std::atomic<int> done{0}, unavailable{0};
    const auto read_three = [&](auto&& between) {
        std::vector<std::thread> threads;
        for (int i = 0; i < 3; ++i) {
            threads.emplace_back([&] {
                std::byte byte{};
                ++(source.read(0, {&byte, 1}).status == ReadStatus::done ? done : unavailable);
            });
        }
        while (source.in_flight() < 3) std::this_thread::yield();
        between();
        for (std::thread& t : threads) t.join();
    };
    source.hold();
    read_three([&] {
        CHECK(done + unavailable == 0);
        source.recover();
    });
    CHECK(done == 3);
    source.hold();
    read_three([&] { source.cancel(); });
    CHECK(unavailable == 3);
    CHECK(source.most_in_flight() == 3);
}
