// Whether files that a build has left hold what its journal tells of: a disk that lost its power may hold anything.
#pragma once

#include "farfield/settings.hpp"

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <span>
#include <system_error>
#include <utility>
#include <vector>

#include "farfield/build_pages/file_in_place.hpp"
#include "farfield/build_pages/page_share.hpp"
#include "farfield/build_pages/scattered_file.hpp"
#include "farfield/build_pages/top_tree.hpp"
#include "farfield/paging/page_format.hpp"

namespace farfield {
namespace detail {

/// Borrows everything.
template <class Build>
class KeptShare {
    using H = typename Build::hierarchy_type;
    using P = typename Build::primitive_type;
    using A = typename H::approximation_type;
    using Tree = TopTree<typename H::partition_type>;

  public:
    /// `share` is what the journal tells. The build's pages are of its size from now on.
    KeptShare(Build& build, const ShareRecord<A, P>& share, const ShareFiles& files)
        : build_(build), share_(share), files_(files) {
        build_.plan.page_bytes = share_.plan.page_bytes;
    }

    /// Whether its pages are there, and all primitives of those of its groups [begin, end) that are not among them.
    bool is_whole(const Tree& tree, std::size_t begin, std::size_t end) const {
        return has_pages() && has_primitives(tree, begin, end);
    }

  private:
    bool has_pages() const {
        std::error_code error;
        if (build_.plan.page_bytes < sizeof(PageHeader) || !std::filesystem::exists(files_.pages(), error)) {
            return false;
        }
        if (share_.pages == 0) return true;
        if (std::filesystem::file_size(files_.pages(), error) <
            build_.offset_of(std::uint64_t(share_.plan.top_pages) + share_.pages)) {
            return false;
        }
        FileInPlace in(files_.pages(), /*is_new=*/false);
        std::vector<std::byte> page(build_.plan.page_bytes);
        for (std::uint32_t p = 0; p < share_.pages; ++p) {
            in.read_at(build_.offset_of(share_.plan.top_pages + std::uint64_t(p)), page);
            PageHeader header;
            std::memcpy(&header, page.data(), sizeof header);
            if (header.number != share_.plan.top_pages + p || header.used_bytes > page.size() ||
                header.used_bytes < sizeof header || header.checksum != checksum_of_page(page, header.used_bytes)) {
                return false;
            }
        }
        return true;
    }
    bool has_primitives(const Tree& tree, std::size_t begin, std::size_t end) const {
        std::error_code error;
        if (!std::filesystem::exists(files_.scattered(), error)) return false;
        FileInPlace in(files_.scattered(), /*is_new=*/false);
        std::vector<P> primitives;
        std::uint64_t first = 0;
        std::size_t part = 0;
        for (std::size_t g = begin; g < end; ++g) {
            for (const std::uint32_t n : tree.group(g)) {
                const auto count = std::size_t(tree.nodes()[n].items);
                const std::uint64_t at = std::exchange(first, first + count);
                const std::size_t number = part++;
                if (g < begin + share_.groups) continue;
                primitives.resize(count);
                if (number >= share_.scattered.size() ||
                    !in.reads_at(at * sizeof(P), std::as_writable_bytes(std::span(primitives))) ||
                    sum_of_scattered(std::span<const P>(primitives), at) != share_.scattered[number]) {
                    return false;
                }
            }
        }
        return true;
    }

    Build& build_;
    const ShareRecord<A, P>& share_;
    const ShareFiles& files_;
};

}  // namespace detail
}  // namespace farfield
