#include "farfield/storage/notes.hpp"

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "catch.hpp"
#include "support/random.hpp"

using namespace farfield;
using namespace farfield::detail;

namespace {

using Stored = std::vector<std::byte>;

const Notes some{{"", "nobody's"}, {"a", ""}, {"a\nb", std::string("\0\xff", 2)}, {"b", std::string(1000, 'x')}};

std::string wrong(const Stored& bytes) {
    Notes notes;
    return wrong_notes(bytes, notes);
}
/// With a checksum that agrees, as somebody who damages files on purpose would write it.
Stored sealed(Stored bytes) {
    NotesHeader header;
    std::memcpy(&header, bytes.data(), sizeof header);
    header.checksum = header.checksum_with(std::span<const std::byte>(bytes).subspan(sizeof header));
    std::memcpy(bytes.data(), &header, sizeof header);
    return bytes;
}
Stored with_header(Stored bytes, std::uint32_t count, std::uint64_t size) {
    NotesHeader header;
    std::memcpy(&header, bytes.data(), sizeof header);
    header.count = count;
    header.bytes = size;
    std::memcpy(bytes.data(), &header, sizeof header);
    return sealed(std::move(bytes));
}

}  // namespace

TEST_CASE("notes come back as they were, and equal ones give equal bytes") {
    CHECK(bytes_of_notes({}).empty());
    const Stored bytes = bytes_of_notes(some);
    Notes back{{"what was there", "is gone"}};
    CHECK(wrong_notes(bytes, back).empty());
    CHECK(back == some);
    Notes in_another_order;
    for (auto note = some.rbegin(); note != some.rend(); ++note) in_another_order.insert(*note);
    CHECK(bytes_of_notes(in_another_order) == bytes);
    CHECK_THROWS_AS(bytes_of_notes({{"much", std::string(most_note_bytes, ' ')}}), std::invalid_argument);
    Notes many;
    while (many.size() < 4096) many[std::to_string(many.size())];
    CHECK(wrong_notes(bytes_of_notes(many), back).empty());
    CHECK(back == many);
    many["one more"];
    CHECK_THROWS_AS(bytes_of_notes(many), std::invalid_argument);
}

TEST_CASE("a changed byte of notes is found, wherever it is, and so is a missing one") {
    const Stored bytes = bytes_of_notes(some);
    for (std::size_t i = 0; i < bytes.size(); ++i) {
        Stored changed = bytes;
        changed[i] ^= std::byte(1u << i % 8);
        CAPTURE(i);
        CHECK_FALSE(wrong(changed).empty());
        CHECK_FALSE(wrong(Stored(bytes.begin(), bytes.begin() + std::ptrdiff_t(i))).empty());
    }
    Stored longer = bytes;
    longer.push_back(std::byte(0));
    CHECK(wrong(longer) == "is too long: its notes have " + std::to_string(longer.size()) + " bytes and should have " +
                               std::to_string(bytes.size()));
}

TEST_CASE("notes that lie with a right checksum are refused, and read nothing that is not there") {
    const Stored bytes = bytes_of_notes(some);
    const std::uint64_t size = bytes.size();
    CHECK(wrong(with_header(bytes, 5, size)) == "is damaged: it has fewer notes than it says");
    for (const std::uint32_t count : {0u, 4097u, 0xffffffffu}) {
        CHECK(wrong(with_header(bytes, count, size)) ==
              "is damaged: it says that it has " + std::to_string(count) + " notes");
    }
    CHECK(wrong(with_header(bytes, 3, size)) == "is damaged: something follows its last note");
    CHECK(wrong(with_header(bytes, 4, ~std::uint64_t(0))).rfind("is truncated: its notes have ", 0) == 0);
    const auto twice = [&](const char* first, const char* second) {
        Stored one = bytes_of_notes({{first, ""}}), two = bytes_of_notes({{second, ""}});
        one.insert(one.end(), two.begin() + sizeof(NotesHeader), two.end());
        return wrong(with_header(one, 2, one.size()));
    };
    CHECK(twice("a", "b").empty());
    CHECK(twice("a", "a") == "is damaged: its notes are out of order");
    CHECK(twice("b", "a") == "is damaged: its notes are out of order");
    // Lengths of anything: refused, or notes that fit into what is there.
    test::Random random(11);
    for (int i = 0; i < 2000; ++i) {
        Stored changed = bytes;
        const std::size_t at =
            sizeof(NotesHeader) + random.below(std::uint32_t(bytes.size() - sizeof(NotesHeader) - 3));
        const std::uint32_t word = random.below(2) == 0 ? 0xffffffffu << random.below(32) : random.below(2000);
        std::memcpy(changed.data() + at, &word, sizeof word);
        Notes notes;
        if (!wrong_notes(sealed(changed), notes).empty()) continue;
        std::size_t used = sizeof(NotesHeader);
        for (const auto& [name, text] : notes) used += 8 + name.size() + text.size();
        CHECK(used == changed.size());
    }
}
