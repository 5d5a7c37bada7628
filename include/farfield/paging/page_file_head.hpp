// What a file of pages begins with.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <vector>

#include "farfield/composition.hpp"
#include "farfield/hierarchy/hierarchy_data.hpp"
#include "farfield/paging/page_forest.hpp"
#include "farfield/paging/page_format.hpp"
#include "farfield/storage/checksum.hpp"
#include "farfield/storage/file_format.hpp"

namespace farfield::detail {

/// The first bytes of a file of pages, up to its first page.
template <Pageable H, PageablePrimitive P>
std::vector<std::byte> page_file_head(const typename H::partition_type& partition,
                                      const typename H::approximation_type& approximation,
                                      const typename H::cost_model_type& cost, const HierarchyFacts& facts,
                                      const UnitElsewhere& root, std::uint32_t page_bytes, std::uint32_t page_count,
                                      unsigned level_count) {
    std::vector<std::byte> options = bytes_of(partition);
    for (const auto& more :
         {bytes_of<stored_approximation_of<typename H::approximation_type>>(approximation), bytes_of(cost)}) {
        options.insert(options.end(), more.begin(), more.end());
    }
    PageFileHeader header;
    header.records = page_records<H, P>();
    header.option_bytes = std::uint32_t(options.size());
    header.page_bytes = page_bytes;
    header.page_count = page_count;
    header.level_count = level_count;
    header.first_page =
        (sizeof header + options.size() + page_file_alignment - 1) / page_file_alignment * page_file_alignment;
    header.file_bytes = header.first_page + std::uint64_t(page_count) * page_bytes;
    header.node_count = facts.report.nodes;
    header.facts = facts;
    header.root = portal_to({root.page, root.unit, std::uint32_t(std::min<std::uint64_t>(root.items, 0xffffffffu)), {}},
                            root.node);
    header.root.first_item = 0;
    header.checksum_of_options = Xxh64::of(options);
    header.checksum = Xxh64::of(std::as_bytes(std::span(&header, 1)).first(offsetof(PageFileHeader, checksum)));
    std::vector<std::byte> bytes(std::size_t(header.first_page));
    std::memcpy(bytes.data(), &header, sizeof header);
    std::copy(options.begin(), options.end(), bytes.begin() + sizeof header);
    return bytes;
}

}  // namespace farfield::detail
