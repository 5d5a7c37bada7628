// Opens files of pages, from a disk or from any other source.
//
//     const auto scene = open_pages<H, Triangle>("scene.farfield", {.most_bytes = 64 << 20});
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <memory>
#include <span>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "farfield/fail.hpp"
#include "farfield/paging/check_pageable.hpp"
#include "farfield/paging/file_page_source.hpp"
#include "farfield/paging/packed_format.hpp"
#include "farfield/paging/page_cache.hpp"
#include "farfield/paging/page_check.hpp"
#include "farfield/paging/page_format.hpp"
#include "farfield/paging/page_source.hpp"
#include "farfield/paging/paged_hierarchy.hpp"
#include "farfield/storage/notes.hpp"
#include "farfield/storage/open.hpp"

namespace farfield {

namespace detail {

inline std::string wrong_size_of_pages(const char* what, const PageFileHeader& header, std::uint64_t file_bytes) {
    return std::string(what) + ": it has " + std::to_string(file_bytes) + " bytes and should have " +
           std::to_string(header.file_bytes);
}

/// The reason to refuse the header of a file of pages; empty if H and P are what it holds.
template <class H, class P>
std::string wrong_page_file(std::span<const std::byte> bytes, PageFileHeader& header, std::uint64_t file_bytes) {
    if (bytes.empty()) return "is empty";
    if (std::memcmp(bytes.data(), page_file_magic.data(), std::min(bytes.size(), page_file_magic.size())) != 0) {
        if (std::memcmp(bytes.data(), file_magic.data(), std::min(bytes.size(), file_magic.size())) == 0) {
            return "is a hierarchy without pages: open() reads it";
        }
        if (std::memcmp(bytes.data(), packed_file_magic.data(), std::min(bytes.size(), packed_file_magic.size())) ==
            0) {
            return "has packed pages: open it through UnpackedPages (paging/unpacked_pages.hpp) with the codec '" +
                   codec_of_packed_file(bytes) + "'";
        }
        return "is not a farfield file of pages";
    }
    std::memcpy(&header, bytes.data(), std::min(bytes.size(), sizeof header));
    if (bytes.size() >= 16) {
        if (header.byte_order == 0x04030201u) return "was saved on a machine of the other byte order";
        if (header.byte_order != file_byte_order) return "is damaged: its byte order is unknown";
        if (header.version != page_file_version) {
            return "has format version " + std::to_string(header.version) + ", this program reads version " +
                   std::to_string(page_file_version) + ": make it again";
        }
    }
    if (bytes.size() < sizeof header) return "is truncated: its header is not whole";
    if (header.checksum != Xxh64::of(bytes.first(offsetof(PageFileHeader, checksum)))) {
        return "is damaged: the checksum of its header is wrong";
    }
    for (std::size_t i = 0; i < header.records.size(); ++i) {
        const std::uint32_t wanted = page_records<H, P>()[i];
        if (header.records[i] != wanted) return wrong_tag(page_record_names[i], wanted, header.records[i]);
    }
    using Records = PageRecords<H, P>;
    if (const char* why = unsound_facts(header.facts, header.node_count & 0xffffffffu))
        return std::string("is damaged: ") + why;
    if (header.page_bytes == 0 || header.page_bytes > most_page_bytes ||
        header.page_bytes % Records::common_multiple != 0 || header.page_count == 0 ||
        header.first_page % page_file_alignment != 0 || header.first_page < sizeof header ||
        header.first_page > most_page_bytes ||
        header.file_bytes != header.first_page + std::uint64_t(header.page_count) * header.page_bytes ||
        !is_portal(header.root) || portal_of(header.root).page != 0) {
        return "is damaged: its pages cannot lie where it says";
    }
    if (header.file_bytes > file_bytes) return wrong_size_of_pages("is truncated", header, file_bytes);
    return {};
}

/// The reason to refuse what follows the pages; empty if it is notes. There are `file_bytes` in all.
inline std::string wrong_notes_of_pages(std::span<const std::byte> rest, const PageFileHeader& header,
                                        std::uint64_t file_bytes, Notes& notes) {
    if (may_be_notes(rest)) return wrong_notes(rest, notes);
    return wrong_size_of_pages("is too long", header, file_bytes);
}

}  // namespace detail

/// Whether what a source holds says that it is a file of pages of H over P: for programs that know several.
template <Pageable H, PageablePrimitive P, PageSource S>
bool holds_pages_of(S& source) {
    detail::PageFileHeader header;
    if (source.size() < sizeof header) return false;
    const auto bytes = std::as_writable_bytes(std::span(&header, 1));
    return source.read(0, bytes).status == ReadStatus::done && header.magic == detail::page_file_magic &&
           header.records == detail::page_records<H, P>();
}

/// Opens a file of pages from any source, which the result and its copies share; `where` names it in messages. H and P
/// are what it was made of. Reads its header, notes and first page. A source that can be canceled is when the last copy
/// goes. Throws std::runtime_error if anything is wrong with them; std::invalid_argument if the options leave no room
/// for two pages.
template <Pageable H, PageablePrimitive P, PageSource S>
PagedHierarchy<H, P> open_pages_of(std::shared_ptr<S> source, const std::string& where,
                                   const PageCacheOptions& options = {}) {
    using Paged = PagedHierarchy<H, P>;
    const auto refuse_if = [&](const std::string& why) {
        if (!why.empty()) detail::fail<std::runtime_error>("farfield::open_pages: " + where + ": " + why);
    };
    const auto read = [&](std::uint64_t offset, std::size_t size) {
        std::vector<std::byte> bytes(size);
        const ReadResult result = source->read(offset, bytes);
        if (result.status != ReadStatus::done) {
            refuse_if(result.message.empty() ? std::string("cannot be read") : result.message);
        }
        return bytes;
    };
    auto file = std::make_shared<typename Paged::File>();
    const std::uint64_t size = source->size();
    detail::PageFileHeader& header = file->header;
    refuse_if(detail::wrong_page_file<H, P>(read(0, std::size_t(std::min<std::uint64_t>(size, sizeof header))), header,
                                            size));
    if (size > header.file_bytes) {
        const std::uint64_t behind = size - header.file_bytes;
        if (behind > detail::most_note_bytes) refuse_if(detail::wrong_size_of_pages("is too long", header, size));
        refuse_if(
            detail::wrong_notes_of_pages(read(header.file_bytes, std::size_t(behind)), header, size, file->notes));
    }
    const std::vector<std::byte> rest = read(sizeof header, std::size_t(header.first_page - sizeof header));
    std::span<const std::byte> options_left(rest);
    const auto policy = [&](auto& to) {
        const std::size_t bytes = detail::bytes_of_numbers<std::remove_reference_t<decltype(to)>>();
        const bool good = bytes <= options_left.size() && detail::read_numbers(options_left.first(bytes), to);
        options_left = options_left.subspan(std::min(bytes, options_left.size()));
        return good;
    };
    using A = typename H::approximation_type;
    if (header.option_bytes > rest.size() ||
        header.checksum_of_options != detail::Xxh64::of(options_left.first(header.option_bytes)) ||
        !policy(file->partition) || !policy(static_cast<detail::stored_approximation_of<A>&>(file->approximation)) ||
        !policy(file->cost) || rest.size() - options_left.size() != header.option_bytes) {
        refuse_if("is damaged: its options are not whole");
    }
    for (const char* why : {detail::wrong_option(file->partition), detail::wrong_option(file->approximation),
                            detail::wrong_option(file->cost)}) {
        if (why != nullptr) refuse_if(std::string("is damaged: ") + why);
    }
    if constexpr (A::facts.samples_primitives) file->approximation.samples_up_to_px = 0;
    const detail::PageExpected expected{0, header.page_count, header.facts.fingerprint};
    PageCacheOptions possible = options;
    possible.most_bytes =
        std::size_t(std::min<std::uint64_t>(options.most_bytes, detail::PageRecords<H, P>::most_bytes_in_memory));
    if constexpr (requires { source->memory_bytes(); }) {
        // The limit is that of all that is in use, so what is left is the cache's.
        possible.most_bytes -= std::size_t(std::min<std::uint64_t>(source->memory_bytes(), possible.most_bytes));
    }
    file->cache = std::make_shared<detail::PageCache>(
        where, detail::PagePlaces{header.first_page, header.page_bytes, header.page_count}, source->merging(),
        [source](std::uint64_t offset, std::span<std::byte> bytes) { return source->read(offset, bytes); },
        [expected, partition = file->partition, approximation = file->approximation](
            std::span<std::byte> page, std::uint32_t number, std::uint64_t begin) {
            detail::PageExpected e = expected;
            e.number = number;
            const char* const why = detail::unsound_page<H, P>(page, e, partition, approximation);
            if (why == nullptr) detail::place_page<H, P>(page, begin);
            return why;
        },
        possible,
        [source] {
            if constexpr (CancellablePageSource<S>) source->cancel();
        });
    Paged pages(std::shared_ptr<const typename Paged::File>(std::move(file)));
    if (!pages.has_root()) refuse_if("is damaged: its root does not exist");
    return pages;
}

/// Says why something cannot lie in pages.
template <class H, class P>
requires(!(Pageable<H> && PageablePrimitive<P>)) void open_pages(const auto&...) {
    static_assert(detail::check_pageable<H, P>());
}

/// Opens a file.
template <Pageable H, PageablePrimitive P>
PagedHierarchy<H, P> open_pages(const std::filesystem::path& path, const PageCacheOptions& options = {}) {
    return open_pages_of<H, P>(std::make_shared<FilePageSource>(path), path.string(), options);
}

}  // namespace farfield
