#include "farfield/storage/mapped_file.hpp"

#include "catch.hpp"
#include "files.hpp"

using farfield::detail::file_bytes;

TEST_CASE("the bytes of a file, as long as anyone holds them") {
    const TemporaryDirectory directory;
    for (const std::size_t size : {std::size_t(0), std::size_t(1), std::size_t(64), std::size_t(100000)}) {
        Bytes written(size);
        for (std::size_t i = 0; i < size; ++i) written[i] = char(i * 31);
        write_file(directory / "f", written);
        const auto file = file_bytes(directory / "f");
        std::filesystem::remove(directory / "f");
        REQUIRE(file.bytes.size() == size);
        CHECK((size == 0 || std::memcmp(file.bytes.data(), written.data(), size) == 0));
        CHECK(reinterpret_cast<std::uintptr_t>(file.bytes.data()) % 64 == 0);
    }
}

TEST_CASE("what is no file is refused") {
    const TemporaryDirectory directory;
    CHECK(refusal(directory / "none", [](auto& p) { file_bytes(p); }) == "No such file or directory");
    CHECK(refusal(directory / "", [](auto& p) { file_bytes(p); }) == "is a directory");
#if FARFIELD_MAPS_FILES
    REQUIRE(::mkfifo((directory / "pipe").c_str(), 0600) == 0);
    CHECK(refusal(directory / "pipe", [](auto& p) { file_bytes(p); }) == "is not a regular file");
#endif
}
