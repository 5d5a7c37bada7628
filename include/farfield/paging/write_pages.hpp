// Cuts a hierarchy in memory into pages: a file that paging/open_pages.hpp opens.
#pragma once

#include "farfield/settings.hpp"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "farfield/fail.hpp"
#include "farfield/paging/check_pageable.hpp"
#include "farfield/paging/page_file_head.hpp"
#include "farfield/paging/page_forest.hpp"
#include "farfield/paging/page_format.hpp"
#include "farfield/storage/notes.hpp"
#include "farfield/storage/save.hpp"

namespace farfield {

struct PageOptions {
    /// Bytes of a page, more or less: less by up to the common multiple of the sizes of its records, more if what one
    /// node holds by itself needs it.
    std::uint32_t page_bytes = 65536;
    Notes notes{};  ///< that go into the file
};

namespace detail {

/// Calls write(bytes) with all parts of the file, in order.
template <Pageable H, PageablePrimitive P, class Write>
void write_pages(const H& hierarchy, std::span<const P> primitives, const PageOptions& options, Write&& write) {
    if (primitives.size() != hierarchy.primitive_count()) {
        fail<std::invalid_argument>("farfield::save_pages: the hierarchy was built from " +
                                    std::to_string(hierarchy.primitive_count()) + " primitives and is given " +
                                    std::to_string(primitives.size()));
    }
    const std::vector<std::byte> notes = bytes_of_notes(options.notes);
    PageForest<H, P> pages({{&hierarchy, primitives}}, options.page_bytes);
    if (!pages.fits()) {
        fail<std::invalid_argument>("farfield::save_pages: one cell by itself takes " +
                                    std::to_string(pages.needed_bytes()) + " bytes, more than the " +
                                    std::to_string(most_page_bytes) + " that a page may have");
    }
    write(std::span<const std::byte>(page_file_head<H, P>(
        hierarchy.partition_policy(), hierarchy.approximation_policy(), hierarchy.cost_policy(), hierarchy.facts(),
        pages.root_of(0), pages.page_bytes(), pages.page_count(), pages.level_count())));
    pages.write(hierarchy.fingerprint(), write);
    if (!notes.empty()) write(std::span<const std::byte>(notes));
}

}  // namespace detail

/// Writes beside `path` and renames, as save() does. Equal hierarchies and notes give equal files. Throws
/// std::invalid_argument for other primitives than the hierarchy was built from, or if one node alone holds more than
/// 64 MiB; std::runtime_error that names the file if it cannot be written.
template <Pageable H, PageablePrimitive P>
void save_pages(const H& hierarchy, std::span<const P> primitives, const std::filesystem::path& path,
                const PageOptions& options = {}) {
    detail::ReplacingFile file(path);
    detail::write_pages(hierarchy, primitives, options, [&](std::span<const std::byte> bytes) { file.write(bytes); });
    file.replace_target();
}
template <Pageable H, PageablePrimitive P>
void save_pages(const H& hierarchy, const std::vector<P>& primitives, const std::filesystem::path& path,
                const PageOptions& options = {}) {
    save_pages(hierarchy, std::span<const P>(primitives), path, options);
}

/// Says why something cannot lie in pages.
template <class H, class P>
requires(!(Pageable<H> && PageablePrimitive<P>)) void save_pages(const H&, const auto&, const auto&...) {
    static_assert(detail::check_pageable<H, P>());
}

/// The bytes of the same file, in memory.
template <Pageable H, PageablePrimitive P>
std::vector<std::byte> paged(const H& hierarchy, std::span<const P> primitives, const PageOptions& options = {}) {
    std::vector<std::byte> bytes;
    detail::write_pages(hierarchy, primitives, options,
                        [&](std::span<const std::byte> part) { bytes.insert(bytes.end(), part.begin(), part.end()); });
    return bytes;
}

}  // namespace farfield
