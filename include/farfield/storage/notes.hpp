// What is known of a hierarchy beside itself goes into its file, as notes: texts by name, behind all that a file of its
// kind has. So a file without any is as it was before there were notes, a hierarchy is used where it lies, and whoever
// writes a note (tuning/kept_error_table.hpp does) says what is in it. All kinds of files have the same.
//
//     NotesHeader, 40 bytes
//     for each note, in the order of names: the lengths of its name and of its text in 32 bits each, then both
//
// Nothing follows the last. What a note says of a hierarchy that is not the one in the file is for its reader to find.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <map>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "farfield/fail.hpp"
#include "farfield/geometry/mixed.hpp"
#include "farfield/storage/checksum.hpp"
#include "farfield/storage/fields.hpp"

namespace farfield {

/// Texts by name. Equal notes give equal bytes.
using Notes = std::map<std::string, std::string>;

namespace detail {

inline constexpr std::array<std::uint8_t, 8> notes_magic{0x89, 'F', 'F', 'N', '\r', '\n', 0x1a, '\n'};
inline constexpr std::uint32_t notes_version = 1;
/// A reader takes memory for all of them, whatever a file says.
inline constexpr std::uint64_t most_note_bytes = 16u << 20;
inline constexpr std::uint32_t most_notes = 4096;

struct NotesHeader {
    std::array<std::uint8_t, 8> magic = notes_magic;
    std::uint32_t version = notes_version;
    std::uint32_t count = 0;
    std::uint64_t bytes = 0;  ///< with the header
    std::uint64_t spare = 0;
    std::uint64_t checksum = 0;  ///< of the header before it, and of what follows it

    std::uint64_t checksum_with(std::span<const std::byte> rest) const {
        const auto before = std::as_bytes(std::span(this, 1)).first(offsetof(NotesHeader, checksum));
        return mixed(Xxh64::of(before), Xxh64::of(rest));
    }
};
static_assert(sizeof(NotesHeader) == 40 && WithoutPadding<NotesHeader>);

/// Whether what follows a hierarchy in its file, of which there is one byte or more, may be notes.
inline bool may_be_notes(std::span<const std::byte> bytes) {
    return std::memcmp(bytes.data(), notes_magic.data(), std::min(bytes.size(), notes_magic.size())) == 0;
}

/// What a file holds of notes; nothing where there are none. Throws std::invalid_argument where they are longer than
/// 16 MiB together, or more than 4096.
inline std::vector<std::byte> bytes_of_notes(const Notes& notes) {
    if (notes.empty()) return {};
    NotesHeader header;
    header.count = std::uint32_t(notes.size());
    header.bytes = sizeof header;
    for (const auto& [name, text] : notes) header.bytes += 2 * sizeof(std::uint32_t) + name.size() + text.size();
    if (notes.size() > most_notes) {
        fail<std::invalid_argument>("farfield::Notes: there are " + std::to_string(notes.size()) + ", more than the " +
                                    std::to_string(most_notes) + " that a file has");
    }
    if (header.bytes > most_note_bytes) {
        fail<std::invalid_argument>("farfield::Notes: they take " + std::to_string(header.bytes) +
                                    " bytes, more than the " + std::to_string(most_note_bytes) + " that a file has");
    }
    std::vector<std::byte> bytes(std::size_t(header.bytes));
    std::byte* to = bytes.data() + sizeof header;
    const auto put = [&to](const void* from, std::size_t count) {
        if (count > 0) std::memcpy(to, from, count);
        to += count;
    };
    for (const auto& [name, text] : notes) {
        const std::uint32_t lengths[] = {std::uint32_t(name.size()), std::uint32_t(text.size())};
        put(lengths, sizeof lengths);
        put(name.data(), name.size());
        put(text.data(), text.size());
    }
    header.checksum = header.checksum_with(std::span<const std::byte>(bytes).subspan(sizeof header));
    std::memcpy(bytes.data(), &header, sizeof header);
    return bytes;
}

/// Reads all that follows a hierarchy in its file. Returns the reason to refuse the file; empty if they are notes.
inline std::string wrong_notes(std::span<const std::byte> bytes, Notes& notes) {
    NotesHeader header;
    if (bytes.size() > most_note_bytes) return "is too long: its notes are longer than any";
    if (bytes.size() < sizeof header) return "is truncated: its notes are not whole";
    std::memcpy(&header, bytes.data(), sizeof header);
    if (header.magic != notes_magic) return "is damaged: what follows the hierarchy is none of its notes";
    if (header.version != notes_version) {
        return "has notes of version " + std::to_string(header.version) + ", this program reads version " +
               std::to_string(notes_version);
    }
    if (header.bytes != bytes.size()) {
        return std::string(header.bytes > bytes.size() ? "is truncated" : "is too long") + ": its notes have " +
               std::to_string(bytes.size()) + " bytes and should have " + std::to_string(header.bytes);
    }
    auto rest = bytes.subspan(sizeof header);
    if (header.checksum != header.checksum_with(rest)) return "is damaged: the checksum of its notes is wrong";
    if (header.count == 0 || header.count > most_notes) {
        return "is damaged: it says that it has " + std::to_string(header.count) + " notes";
    }
    notes.clear();
    for (std::uint32_t i = 0; i < header.count; ++i) {
        std::uint32_t lengths[2];
        if (rest.size() < sizeof lengths) return "is damaged: it has fewer notes than it says";
        std::memcpy(lengths, rest.data(), sizeof lengths);
        rest = rest.subspan(sizeof lengths);
        std::string texts[2];
        for (int t = 0; t < 2; ++t) {
            if (lengths[t] > rest.size()) return "is damaged: a note reaches beyond the end";
            texts[t].assign(reinterpret_cast<const char*>(rest.data()), lengths[t]);
            rest = rest.subspan(lengths[t]);
        }
        if (!notes.empty() && !(notes.rbegin()->first < texts[0])) return "is damaged: its notes are out of order";
        notes.emplace_hint(notes.end(), std::move(texts[0]), std::move(texts[1]));
    }
    return rest.empty() ? "" : "is damaged: something follows its last note";
}

}  // namespace detail
}  // namespace farfield
