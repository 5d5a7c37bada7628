// The layout of a file of pages that are packed by a codec, and what a codec is.
//
// It is a file of pages (page_format.hpp) in a wrapping, which unpacked_pages.hpp takes off as it is read: neither the
// cache nor a frame knows. Each page is packed by itself and read by itself; one that does not shrink is stored as it
// is. Pages that follow one another do so in the wrapping too, and are read together as before.
//
//     0       PackedFileHeader
//     72      the file's first bytes, up to its first page, as they are
//             pages, as stored, one after the other
//             the stored size of each in 32 bits, and the XXH64 of these sizes
//             notes, as they are behind the pages of what was packed, if there are any
//
// The checksum of a page is that of its unpacked bytes, which is looked at whenever one is loaded; there is no other of
// what is stored. So a codec is trusted as little as the disk: whatever it makes of damaged bytes is no page.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>

#include "farfield/paging/page_format.hpp"
#include "farfield/storage/checksum.hpp"
#include "farfield/storage/file_format.hpp"
#include "farfield/storage/notes.hpp"

namespace farfield {

/// Packs the bytes of a page. pack() returns how many bytes it has written, 0 if they do not fit; unpack() fills all of
/// `to`, or returns false, whatever it is given. Both are called by several threads at once. The tag says in a file
/// which codec it was, and is not 0; `name` is for messages.
template <class C>
concept PageCodec = requires(const C& codec, std::span<const std::byte> from, std::span<std::byte> to) {
    { C::file_tag } -> std::convertible_to<std::uint32_t>;
    { C::name } -> std::convertible_to<const char*>;
    { codec.pack(from, to) } -> std::same_as<std::size_t>;
    { codec.unpack(from, to) }
    noexcept->std::same_as<bool>;
};

namespace detail {

inline constexpr std::array<std::uint8_t, 8> packed_file_magic{0x89, 'F', 'F', 'Z', '\r', '\n', 0x1a, '\n'};
inline constexpr std::uint32_t packed_file_version = 1;

struct PackedFileHeader {
    std::array<std::uint8_t, 8> magic = packed_file_magic;
    std::uint32_t version = packed_file_version;
    std::uint32_t byte_order = file_byte_order;
    std::uint32_t codec = 0;
    std::uint32_t page_bytes = 0;
    std::uint32_t page_count = 0;
    std::uint32_t note_bytes = 0;
    std::array<char, 16> codec_name{};  ///< for messages of those who have another
    std::uint64_t first_page = 0;       ///< where page 0 begins in what was packed
    std::uint64_t unpacked_bytes = 0;   ///< without notes
    std::uint64_t checksum = 0;         ///< XXH64 of all bytes of the header before it

    std::uint64_t first_stored_page() const { return sizeof(PackedFileHeader) + first_page; }
    std::uint64_t bytes_behind_pages() const {
        return page_count * std::uint64_t(sizeof(std::uint32_t)) + sizeof(std::uint64_t) + note_bytes;
    }
    std::uint64_t checksum_of_header() const {
        return Xxh64::of(std::as_bytes(std::span(this, 1)).first(offsetof(PackedFileHeader, checksum)));
    }
};
static_assert(sizeof(PackedFileHeader) == 72 && WithoutPadding<PackedFileHeader>);

/// Of the first bytes of a packed file; empty if they are too few.
inline std::string codec_of_packed_file(std::span<const std::byte> bytes) {
    PackedFileHeader header;
    if (bytes.size() < sizeof header) return {};
    std::memcpy(&header, bytes.data(), sizeof header);
    const auto& name = header.codec_name;
    std::string text(name.begin(), std::find(name.begin(), name.end(), '\0'));
    for (char& c : text) c = c >= ' ' && c <= '~' ? c : '?';
    return text;
}

/// The reason to refuse the header of a packed file of `file_bytes`, or null. `bytes` has what there is of it.
inline const char* wrong_packed_file(std::span<const std::byte> bytes, std::uint64_t file_bytes,
                                     PackedFileHeader& header) {
    if (bytes.empty()) return "is empty";
    if (std::memcmp(bytes.data(), packed_file_magic.data(), std::min(bytes.size(), packed_file_magic.size())) != 0) {
        return "holds no packed pages";
    }
    if (bytes.size() < sizeof header) return "is truncated: its header is not whole";
    std::memcpy(&header, bytes.data(), sizeof header);
    if (header.byte_order != file_byte_order) return "was saved on a machine of another byte order, or is damaged";
    if (header.version != packed_file_version) return "has another format version: make it again";
    if (header.checksum != header.checksum_of_header()) return "is damaged: the checksum of its header is wrong";
    if (header.page_bytes == 0 || header.page_bytes > most_page_bytes || header.page_count == 0 ||
        header.first_page > most_page_bytes || header.note_bytes > most_note_bytes ||
        header.unpacked_bytes != header.first_page + std::uint64_t(header.page_count) * header.page_bytes ||
        header.first_page < sizeof(PageFileHeader)) {
        return "is damaged: its pages cannot lie where it says";
    }
    return file_bytes < header.first_stored_page() + header.bytes_behind_pages() + header.page_count ? "is truncated"
                                                                                                     : nullptr;
}

}  // namespace detail
}  // namespace farfield
