// What a build outside of memory is told, and what all its steps know.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "farfield/build.hpp"
#include "farfield/build_pages/page_share.hpp"
#include "farfield/build_pages/top_tree.hpp"
#include "farfield/fail.hpp"
#include "farfield/paging/page_file_head.hpp"
#include "farfield/paging/page_forest.hpp"
#include "farfield/paging/page_format.hpp"
#include "farfield/sampler/grid_sampler.hpp"
#include "farfield/storage/notes.hpp"

namespace farfield {

/// A hierarchy whose cells depend on their own primitives and on their children's drafts alone.
template <class H>
concept BuildsInParts =
    Pageable<H> && H::partition_type::facts
        .children_are_octants&& std::is_empty_v<typename H::node_data>&& H::approximation_type::facts
        .merges_octants&& std::is_trivially_copyable_v<typename H::approximation_type::stand_in_draft>;

template <class H, OrthographicSampler Sampler = GridSampler>
struct PageBuildOptions {
    /// As for a build in memory. The executor runs parts at once; memory_budget_bytes is not looked at.
    BuildOptions<H, Sampler> build{};
    /// Bytes of a page, more or less. More where one cell by itself needs more; then what was built is built again.
    std::uint32_t page_bytes = 65536;
    /// What the build takes, beside the stream and the program, roughly. The file depends on it.
    std::uint64_t memory_bytes = std::uint64_t(256) << 20;
    /// What the build, or a share of it, may take of the disk; what is free there is a limit anyway. One that needs
    /// more (disk_bytes_of_build) is refused before anything is moved.
    std::uint64_t most_disk_bytes = std::numeric_limits<std::uint64_t>::max();
    /// They go into the file. All shares have the same; whoever joins them need not.
    Notes notes{};
};

namespace detail {

/// One build: of all shares, of one, or the joining of them. Path and options are borrowed.
template <BuildsInParts H, PageablePrimitive P, class Sampler>
requires std::default_initializable<P>
struct PageBuild {
    using hierarchy_type = H;
    using primitive_type = P;
    using sampler_type = Sampler;
    using Records = PageRecords<H, P>;

    /// Throws std::invalid_argument if an option makes no sense.
    PageBuild(const std::filesystem::path& target, const PageBuildOptions<H, Sampler>& all_options)
        : path(target),
          options(all_options),
          control(all_options.build.executor, all_options.build.progress),
          notes(bytes_of_notes(all_options.notes)) {
        check_build_options(options.build);
        if (!options.build.approximation.merges_children()) {
            fail<std::invalid_argument>(
                "farfield::build_pages: the approximation's options make no stand-ins from those of children");
        }
        plan.most_items = std::clamp<std::uint64_t>(options.memory_bytes / bytes_a_primitive, 512, 1u << 22);
    }

    std::uint64_t first_page() const {
        // It does not depend on what the head says.
        return page_file_head<H, P>(options.build.partition, options.build.approximation, options.build.cost_model, {},
                                    {}, plan.page_bytes, 0, 0)
            .size();
    }
    std::uint64_t offset_of(std::uint64_t page) const { return first_page() + page * plan.page_bytes; }

    const std::filesystem::path& path;
    const PageBuildOptions<H, Sampler>& options;
    BuildControl control;
    std::vector<std::byte> notes;
    SharedPlan plan;

    static constexpr unsigned counted_levels = 7;
    static constexpr std::uint64_t reported_each = 1u << 20;

  private:
    /// Of two parts that are built while others wait to be written.
    static constexpr std::uint64_t bytes_a_primitive = 1024;
};

}  // namespace detail

}  // namespace farfield
