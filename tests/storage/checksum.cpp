#include "farfield/storage/checksum.hpp"

#include <cstdint>
#include <set>
#include <string_view>
#include <vector>

#include "catch.hpp"

using farfield::detail::Xxh64;

namespace {
std::uint64_t hash_of(std::string_view text) {
    return Xxh64::of(std::as_bytes(std::span(text.data(), text.size())));
}
}  // namespace

TEST_CASE("the hash is XXH64 with seed 0") {
    CHECK(hash_of("") == 0xef46db3751d8e999u);
    CHECK(hash_of("a") == 0xd24ec4f1a98c6e5bu);
    CHECK(hash_of("abc") == 0x44bc2cf5ad770999u);
    CHECK(hash_of("Nobody inspects the spammish repetition") == 0xfbcea83c8a378bf1u);
}

TEST_CASE("every bit of every length counts") {
    std::vector<std::byte> bytes(75);
    for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = std::byte(i * 37);
    for (std::size_t size = 0; size <= bytes.size(); ++size) {
        std::vector<std::byte> some(bytes.begin(), bytes.begin() + std::ptrdiff_t(size));
        std::set<std::uint64_t> hashes{Xxh64::of(some)};
        for (std::size_t bit = 0; bit < 8 * size; ++bit) {
            some[bit / 8] ^= std::byte(1u << bit % 8);
            hashes.insert(Xxh64::of(some));
            some[bit / 8] ^= std::byte(1u << bit % 8);
        }
        CHECK(hashes.size() == 8 * size + 1);
    }
}
