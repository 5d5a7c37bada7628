// Packs a file of pages page by page (packed_format.hpp). Building and packing are two steps, so that a build needs no
// codec, goes on wherever it was stopped, and gives the same bytes however many built it.
//
//     pack_pages(ZstdPages(), "scene.farfield", "scene.farfield");
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "farfield/executor.hpp"
#include "farfield/paging/file_notes.hpp"
#include "farfield/paging/file_page_source.hpp"
#include "farfield/paging/packed_format.hpp"
#include "farfield/paging/page_format.hpp"
#include "farfield/paging/page_source.hpp"
#include "farfield/storage/checksum.hpp"
#include "farfield/storage/mapped_file.hpp"
#include "farfield/storage/notes.hpp"
#include "farfield/storage/save.hpp"

namespace farfield {

/// Packs a file of pages into another, or into itself, on the executor's threads; whichever file was there is replaced
/// when the new one is whole. Notes are kept. The same file and codec give the same bytes. It takes memory for 32
/// pages, twice. Throws std::runtime_error that names the file which is no file of pages, or cannot be read or written;
/// pages themselves are not looked at.
template <PageCodec C>
void pack_pages(const C& codec, const std::filesystem::path& from, const std::filesystem::path& to,
                const AnyExecutor& executor = {}) {
    static_assert(C::file_tag != 0, "farfield: a codec's tag is not 0");
    const auto refuse = [&](const std::string& why) { detail::refuse_file("pack_pages", from, why); };
    FilePageSource in(from);
    const auto read = [&](std::uint64_t offset, std::span<std::byte> bytes) {
        const ReadResult result = in.read(offset, bytes);
        if (result.status != ReadStatus::done) refuse(result.message);
    };
    detail::PageFileHeader plain;
    if (in.size() < sizeof plain) refuse("is no file of pages");
    read(0, std::as_writable_bytes(std::span(&plain, 1)));
    if (plain.magic != detail::page_file_magic || plain.page_bytes == 0 || plain.page_bytes > detail::most_page_bytes ||
        plain.first_page < sizeof plain || plain.first_page > detail::most_page_bytes || plain.page_count == 0 ||
        plain.file_bytes != plain.first_page + std::uint64_t(plain.page_count) * plain.page_bytes ||
        in.size() < plain.file_bytes) {
        refuse("is no file of pages, or not whole");
    }
    std::vector<std::byte> head(std::size_t(plain.first_page));
    read(0, head);
    const std::vector<std::byte> notes =
        detail::bytes_of_notes(detail::notes_at(plain.file_bytes, in.size(), read, refuse));

    constexpr std::uint32_t pages_at_once = 32;
    const std::size_t page_bytes = plain.page_bytes;
    std::vector<std::byte> pages(pages_at_once * page_bytes), packed(pages_at_once * page_bytes);
    std::vector<std::uint32_t> sizes;
    // Calls take(bytes) with every page as it is stored.
    const auto pack_all = [&](auto&& take) {
        for (std::uint32_t first = 0; first < plain.page_count; first += pages_at_once) {
            const std::uint32_t count = std::min(pages_at_once, plain.page_count - first);
            read(plain.first_page + std::uint64_t(first) * page_bytes, std::span(pages).first(count * page_bytes));
            sizes.resize(first + std::size_t(count));
            const auto pack = [&](std::size_t i) {
                const auto page = std::span<const std::byte>(pages).subspan(i * page_bytes, page_bytes);
                const auto room = std::span(packed).subspan(i * page_bytes, page_bytes);
                const std::size_t size = codec.pack(page, room.first(page_bytes - 1));
                if (size == 0) std::copy(page.begin(), page.end(), room.begin());
                sizes[first + i] = std::uint32_t(size == 0 ? page_bytes : size);
            };
            if (executor) {
                executor(count, pack);
            } else {
                SerialExecutor()(count, pack);
            }
            for (std::uint32_t i = 0; i < count; ++i) {
                take(std::span<const std::byte>(packed).subspan(i * page_bytes, sizes[first + i]));
            }
        }
    };
    detail::PackedFileHeader header;
    header.codec = C::file_tag;
    const std::string name = C::name;
    std::copy_n(name.begin(), std::min(name.size(), header.codec_name.size() - 1), header.codec_name.begin());
    header.page_bytes = plain.page_bytes;
    header.page_count = plain.page_count;
    header.first_page = plain.first_page;
    header.note_bytes = std::uint32_t(notes.size());
    header.unpacked_bytes = plain.file_bytes;
    header.checksum = header.checksum_of_header();
    detail::ReplacingFile out(to);
    out.write(std::as_bytes(std::span(&header, 1)));
    out.write(head);
    pack_all([&](std::span<const std::byte> page) { out.write(page); });
    out.write(std::as_bytes(std::span(sizes)));
    const std::uint64_t checksum = detail::Xxh64::of(std::as_bytes(std::span(sizes)));
    out.write(std::as_bytes(std::span(&checksum, 1)));
    out.write(notes);
    out.replace_target();
}

}  // namespace farfield
