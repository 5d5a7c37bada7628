// Reads the notes of a file, and puts others there. A file of any kind that this library makes has them in one way
// (storage/notes.hpp): what save() writes, files of pages, and those that are packed.
//
// A file is never changed in place, for whoever has it open reads it: it is written anew beside itself, page by page,
// and takes its name when it is whole. That takes as long as to copy it, and as much room.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "farfield/hierarchy/hierarchy_data.hpp"
#include "farfield/paging/file_page_source.hpp"
#include "farfield/paging/packed_format.hpp"
#include "farfield/paging/page_format.hpp"
#include "farfield/storage/checksum.hpp"
#include "farfield/storage/file_format.hpp"
#include "farfield/storage/mapped_file.hpp"
#include "farfield/storage/notes.hpp"
#include "farfield/storage/save.hpp"

namespace farfield {
namespace detail {

/// Where notes begin in a file, and of which hierarchy it is.
struct PlaceOfNotes {
    std::uint64_t begin = 0;
    bool is_packed = false;
    HierarchyFacts facts;
    std::uint32_t approximation_tag = 0;
    std::uint64_t checksum_of_options = 0;  ///< of policies; 0 where `options` say where they lie
    std::array<SectionEntry, 3> options{};
};

inline constexpr std::size_t most_header_bytes =
    std::max(sizeof(FileHeader), sizeof(PackedFileHeader) + sizeof(PageFileHeader));

inline std::uint32_t approximation_tag_of(const FileHeader& header) {
    return header.approximation_tag;
}
inline std::uint32_t approximation_tag_of(const PageFileHeader& header) {
    return header.records[1];
}

inline void place_options(const FileHeader& header, PlaceOfNotes& place) {
    std::copy_n(header.sections.begin(), place.options.size(), place.options.begin());
}
inline void place_options(const PageFileHeader& header, PlaceOfNotes& place) {
    place.checksum_of_options = header.checksum_of_options;
}

/// Of a file of `size` bytes, of which `head` are the first.
template <class Header>
std::string wrong_end(std::span<const std::byte> head, std::uint64_t size, std::uint32_t version, PlaceOfNotes& place) {
    Header header;
    if (head.size() < sizeof header) return "is truncated: its header is not whole";
    std::memcpy(&header, head.data(), sizeof header);
    if (header.byte_order != file_byte_order) return "was saved on a machine of another byte order, or is damaged";
    if (header.version != version) return "has another format version: make it again";
    if (header.checksum != Xxh64::of(head.first(offsetof(Header, checksum)))) {
        return "is damaged: the checksum of its header is wrong";
    }
    if (header.file_bytes < sizeof header) return "is damaged: it says that it ends within its header";
    place.begin = header.file_bytes;
    place.facts = header.facts;
    place.approximation_tag = approximation_tag_of(header);
    place_options(header, place);
    return size < place.begin ? "is truncated" : "";
}

/// The reason to refuse the file; empty if it is one.
inline std::string wrong_place_of_notes(std::span<const std::byte> head, std::uint64_t size, PlaceOfNotes& place) {
    const auto begins_with = [&](const auto& magic) {
        return head.size() >= magic.size() && std::memcmp(head.data(), magic.data(), magic.size()) == 0;
    };
    if (begins_with(file_magic)) return wrong_end<FileHeader>(head, size, file_version, place);
    if (begins_with(page_file_magic)) return wrong_end<PageFileHeader>(head, size, page_file_version, place);
    if (!begins_with(packed_file_magic)) return "is no file of a hierarchy";
    PackedFileHeader header;
    if (const char* why = wrong_packed_file(head, size, header)) return why;
    const std::string why =
        wrong_end<PageFileHeader>(head.subspan(sizeof header), header.unpacked_bytes, page_file_version, place);
    place.begin = size - header.note_bytes;
    place.is_packed = true;
    return why;
}

/// read(offset, bytes) fills them or throws; refuse(why) throws.
template <class Read, class Refuse>
Notes notes_at(std::uint64_t begin, std::uint64_t size, Read&& read, Refuse&& refuse) {
    Notes notes;
    if (begin >= size) return notes;
    if (size - begin > most_note_bytes) refuse(std::string("is too long: its notes are longer than any"));
    std::vector<std::byte> bytes(std::size_t(size - begin));
    read(begin, std::span(bytes));
    if (const std::string why = wrong_notes(bytes, notes); !why.empty()) refuse(why);
    return notes;
}

/// A file of any kind, with where its notes begin.
struct FileWithNotes {
    std::string function;  ///< of messages
    std::filesystem::path path;
    FilePageSource source;
    std::vector<std::byte> head;
    PlaceOfNotes place;

    FileWithNotes(const char* name, const std::filesystem::path& file) : function(name), path(file), source(file) {
        head.resize(std::size_t(std::min<std::uint64_t>(source.size(), most_header_bytes)));
        read(0, head);
        refuse_if(wrong_place_of_notes(head, source.size(), place));
    }
    void read(std::uint64_t offset, std::span<std::byte> bytes) {
        const ReadResult result = source.read(offset, bytes);
        if (result.status != ReadStatus::done) refuse_if(result.message.empty() ? "cannot be read" : result.message);
    }
    void refuse_if(const std::string& why) const {
        if (!why.empty()) refuse_file(function.c_str(), path, why);
    }
    /// As of a hierarchy in memory (identity_by()).
    std::uint64_t checksum_of_options() {
        constexpr std::uint64_t most_bytes = 65536;  // they are a few numbers
        if (place.checksum_of_options != 0) return place.checksum_of_options;
        std::vector<std::byte> bytes;
        for (const SectionEntry& o : place.options) {
            if (o.record_bytes > most_bytes || o.count > most_bytes || o.bytes() > most_bytes) {
                refuse_if("is damaged: its options are not whole");
            }
            const std::size_t begin = bytes.size();
            bytes.resize(begin + std::size_t(o.bytes()));
            if (o.bytes() != 0) read(o.offset, std::span(bytes).subspan(begin));
        }
        return Xxh64::of(bytes);
    }
    Notes notes() {
        return notes_at(
            place.begin, source.size(),
            [this](std::uint64_t offset, std::span<std::byte> bytes) { read(offset, bytes); },
            [this](const std::string& why) { refuse_if(why); });
    }
};

}  // namespace detail

/// The notes of a file. Throws std::runtime_error that names it if it is none of a hierarchy, cannot be read, or its
/// notes are damaged; the hierarchy is not looked at.
inline Notes read_notes(const std::filesystem::path& path) {
    return detail::FileWithNotes("read_notes", path).notes();
}

/// Those of the bytes of such a file.
inline Notes read_notes(std::span<const std::byte> bytes) {
    const auto refuse = [](const std::string& why) { detail::refuse_file("read_notes", "memory", why); };
    detail::PlaceOfNotes place;
    const auto head = bytes.first(std::min(bytes.size(), detail::most_header_bytes));
    if (const std::string why = detail::wrong_place_of_notes(head, bytes.size(), place); !why.empty()) refuse(why);
    return detail::notes_at(
        place.begin, bytes.size(),
        [&](std::uint64_t offset, std::span<std::byte> to) {
            std::memcpy(to.data(), bytes.data() + std::size_t(offset), to.size());
        },
        refuse);
}

/// Puts notes into a file, in place of those that are there; none takes them out, and what is left is as if there had
/// never been any, byte for byte. There is the old file or the whole new one, never a part, and programs that have the
/// old one open keep it. Throws std::runtime_error as read_notes() and save() do; std::invalid_argument where notes are
/// longer than 16 MiB together, or more than 4096.
inline void write_notes(const Notes& notes, const std::filesystem::path& path) {
    detail::FileWithNotes file("write_notes", path);
    const std::vector<std::byte> behind = detail::bytes_of_notes(notes);
    detail::ReplacingFile out(path);
    std::uint64_t at = 0;
    if (file.place.is_packed) {
        detail::PackedFileHeader header;
        std::memcpy(&header, file.head.data(), sizeof header);
        header.note_bytes = std::uint32_t(behind.size());
        header.checksum = header.checksum_of_header();
        out.write(std::as_bytes(std::span(&header, 1)));
        at = sizeof header;
    }
    std::vector<std::byte> piece(std::size_t(std::min<std::uint64_t>(file.place.begin, 1u << 20)));
    while (at < file.place.begin) {
        const auto bytes =
            std::span(piece).first(std::size_t(std::min<std::uint64_t>(piece.size(), file.place.begin - at)));
        file.read(at, bytes);
        out.write(bytes);
        at += bytes.size();
    }
    out.write(behind);
    out.replace_target();
}

}  // namespace farfield
