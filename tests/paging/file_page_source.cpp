#include "farfield/paging/file_page_source.hpp"

#include <atomic>
#include <chrono>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include "catch.hpp"
#include "faulty_source.hpp"
#include "support/temporary_directory.hpp"

using namespace farfield;
using test::random_bytes;
using test::TemporaryDirectory;
namespace fs = std::filesystem;

namespace {

using Bytes = std::vector<std::byte>;

/// Files are never cut to nothing and written again: file systems then wait for the disk, in case power fails.
void write(const fs::path& path, std::span<const std::byte> bytes) {
    std::ofstream(path, std::ios::binary)
        .write(reinterpret_cast<const char*>(bytes.data()), std::streamsize(bytes.size()));
}
/// Within a file that is there.
void overwrite(const fs::path& path, std::uint64_t at, std::span<const std::byte> bytes) {
    std::fstream out(path, std::ios::binary | std::ios::in | std::ios::out);
    out.seekp(std::streamoff(at));
    out.write(reinterpret_cast<const char*>(bytes.data()), std::streamsize(bytes.size()));
}
/// Long ago, so that whatever is written now has another time, however coarse the system's clock is.
void age(const fs::path& path) {
    fs::last_write_time(path, fs::last_write_time(path) - std::chrono::hours(1));
}

template <class Source>
ReadResult read(Source& source, std::uint64_t at, std::uint64_t count) {
    Bytes bytes(count);
    return source.read(at, bytes);
}

template <class Source>
std::string refusal(const fs::path& path) {
    try {
        const Source source(path);
        return {};
    } catch (const std::runtime_error& e) {
        const std::string start = "farfield::FilePageSource: " + path.string() + ": ", what = e.what();
        return what.starts_with(start) ? what.substr(start.size()) : "MISSING: " + what;
    }
}

/// The two ways of reading without the check of the end, which is the same for both.
template <class File>
class Checked {
  public:
    explicit Checked(const fs::path& path) : file_(path) {}
    std::uint64_t size() const { return file_.size(); }
    ReadResult read(std::uint64_t at, std::span<std::byte> bytes) { return file_.read(at, bytes); }

  private:
    File file_;
};

}  // namespace

#if FARFIELD_READS_BY_PREAD
#define FARFIELD_TEST_FILES FilePageSource, Checked<detail::StreamedFile>
#else
#define FARFIELD_TEST_FILES FilePageSource
#endif

TEMPLATE_TEST_CASE("a file is read at any place, by any number of threads", "", FARFIELD_TEST_FILES) {
    const TemporaryDirectory directory;
    const Bytes all = random_bytes(300'001);
    write(directory / "f", all);
    TestType source(directory / "f");
    REQUIRE(source.size() == all.size());
    std::atomic<int> wrong{0};
    std::vector<std::thread> threads;
    for (std::uint64_t seed = 1; seed <= 4; ++seed) {
        threads.emplace_back([&, seed] {
            test::Random random(seed);
            for (int i = 0; i < 300; ++i) {
                const std::size_t at = random.below(std::uint32_t(all.size()));
                const std::size_t count = 1 + random.below(std::uint32_t(all.size() - at));
                Bytes bytes(count);
                const ReadResult result = source.read(at, bytes);
                wrong += result.status != ReadStatus::done || !result.message.empty() ||
                         std::memcmp(bytes.data(), all.data() + at, count) != 0;
            }
        });
    }
    for (std::thread& t : threads) t.join();
    CHECK(wrong == 0);
}

TEST_CASE("a read beyond the end of a file is refused, and one of nothing is done") {
    const TemporaryDirectory directory;
    write(directory / "f", random_bytes(100));
    FilePageSource source(directory / "f");
    CHECK(read(source, 0, 100).status == ReadStatus::done);
    CHECK(read(source, 100, 0).status == ReadStatus::done);
    CHECK(read(source, 0, 0).status == ReadStatus::done);
    CHECK(read(source, 101, 0).status == ReadStatus::refused);
    CHECK(read(source, 100, 1).status == ReadStatus::refused);
    CHECK(read(source, std::uint64_t(-1), 100).status == ReadStatus::refused);
    const std::string name = (directory / "f").string();
    CHECK(read(source, 99, 2).message == name + ": 2 bytes at 99 are asked for, beyond its end at 100");

    write(directory / "empty", {});
    FilePageSource empty(directory / "empty");
    CHECK(empty.size() == 0);
    CHECK(read(empty, 0, 0).status == ReadStatus::done);
    CHECK(read(empty, 0, 1).status == ReadStatus::refused);
}

TEMPLATE_TEST_CASE("what is no page file is refused when it is opened", "", FARFIELD_TEST_FILES) {
    const TemporaryDirectory directory;
    CHECK(refusal<TestType>(directory / "none") == "No such file or directory");
    CHECK(refusal<TestType>(directory / "") == "is a directory");
#if FARFIELD_READS_BY_PREAD
    REQUIRE(::mkfifo((directory / "pipe").c_str(), 0600) == 0);
    CHECK(refusal<TestType>(directory / "pipe") == "is not a regular file");
    CHECK(refusal<TestType>("/dev/null") == "is not a regular file");
    if (::geteuid() != 0) {  // root may read all
        write(directory / "secret", random_bytes(1));
        fs::permissions(directory / "secret", fs::perms::none);
        CHECK(!refusal<TestType>(directory / "secret").empty());
    }
#endif
}

TEMPLATE_TEST_CASE("a file that is not as it was opened is found changed", "", FARFIELD_TEST_FILES) {
    const TemporaryDirectory directory;
    const fs::path path = directory / "f";
    write(path, random_bytes(100'000));
    age(path);
    TestType source(path);
    REQUIRE(read(source, 0, 1000).status == ReadStatus::done);
    std::string how;
    SECTION("cut short, before what is read and behind it") {
        fs::resize_file(path, 50'000);
        CHECK(read(source, 0, 1000).status == ReadStatus::changed);
        CHECK(read(source, 49'999, 2).status == ReadStatus::changed);
        how = "has been cut short";
    }
    SECTION("cut to nothing") {
        fs::resize_file(path, 0);
        how = "has been cut short";
    }
    SECTION("longer") {
        fs::resize_file(path, 100'001);
        how = "has been written to";
    }
    SECTION("written to elsewhere, at the same size") {
        overwrite(path, 70'000, random_bytes(10, 2));
        how = "has been written to";
    }
    SECTION("cut short and grown again") {
        fs::resize_file(path, 10);
        fs::resize_file(path, 100'000);
        how = "has been written to";
    }
    for (const std::uint64_t at : {0u, 70'000u, 99'000u}) {
        const ReadResult result = read(source, at, 1000);
        CHECK(result.status == ReadStatus::changed);
        CHECK(result.message == path.string() + ": " + how + " since it was opened: open it again");
    }
}

#if FARFIELD_READS_BY_PREAD
TEST_CASE("a file that another one of its name has replaced, or that was removed, goes on as the old one") {
    const TemporaryDirectory directory;
    const Bytes all = random_bytes(100'000);
    write(directory / "f", all);
    FilePageSource source(directory / "f");
    const auto is_old = [&] {
        Bytes bytes(all.size());
        return source.read(0, bytes).status == ReadStatus::done && bytes == all;
    };
    write(directory / "g", random_bytes(500, 2));
    fs::rename(directory / "g", directory / "f");
    CHECK(is_old());
    CHECK(FilePageSource(directory / "f").size() == 500);
    fs::remove(directory / "f");
    CHECK(is_old());
}
#endif

TEST_CASE("a source of a file is moved with its file") {
    const TemporaryDirectory directory;
    const Bytes all = random_bytes(1000);
    write(directory / "f", all);
    write(directory / "g", random_bytes(10, 2));
    FilePageSource source(directory / "f"), other(directory / "g");
    other = std::move(source);
    FilePageSource third(std::move(other));
    Bytes bytes(1000);
    CHECK(third.read(0, bytes).status == ReadStatus::done);
    CHECK(bytes == all);
    CHECK(third.merging().largest_read >= 1u << 20);
}
