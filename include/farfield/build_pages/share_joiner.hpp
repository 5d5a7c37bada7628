// Shares of a scene become one file, which is whole when it has its name.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <stdexcept>
#include <string>
#include <system_error>
#include <vector>

#include "farfield/build_pages/build_journal.hpp"
#include "farfield/build_pages/disk_room.hpp"
#include "farfield/build_pages/file_in_place.hpp"
#include "farfield/build_pages/page_build.hpp"
#include "farfield/build_pages/page_share.hpp"
#include "farfield/build_pages/top_pages.hpp"
#include "farfield/build_pages/top_tree.hpp"
#include "farfield/fail.hpp"
#include "farfield/hierarchy/build_report.hpp"
#include "farfield/paging/page_file_head.hpp"
#include "farfield/paging/page_forest.hpp"
#include "farfield/paging/page_format.hpp"
#include "farfield/storage/mapped_file.hpp"

namespace farfield {
namespace detail {

template <class Build>
class ShareJoiner {
    using H = typename Build::hierarchy_type;
    using P = typename Build::primitive_type;
    using Partition_ = typename H::partition_type;
    using A = typename H::approximation_type;
    using Tree = TopTree<Partition_>;
    using Part = BuiltPart<A>;

  public:
    explicit ShareJoiner(Build& build) : build_(build) {}

    /// Makes the file of all shares and removes theirs.
    void operator()(std::uint32_t share_count) {
        std::vector<ShareRecord<A, P>> shares;
        std::vector<ShareFiles> files;
        for (std::uint32_t i = 0; i < share_count; ++i) {
            files.emplace_back(build_.path, PageShare{i, share_count});
            shares.push_back(whole_share(files.back(), i, share_count, shares));
        }
        if (shares.empty()) fail<std::invalid_argument>("farfield::join_page_shares: there are no shares");
        build_.plan = shares[0].plan;
        const Tree tree(shares[0].top_nodes, build_.plan.most_items);
        std::vector<Part> parts;
        std::uint32_t pages = build_.plan.top_pages;
        for (const auto& s : shares) {
            for (Part p : s.parts) {
                p.root.page += pages;
                add_report(build_.plan.facts.report, p.report);
                parts.push_back(p);
            }
            pages += s.pages;
        }
        if (parts.size() != tree.parts().size()) refuse_file("join_page_shares", build_.path, "parts are missing");
        check_disk_room(build_.path, std::uint64_t(pages - shares[0].pages) * build_.plan.page_bytes,
                        build_.options.most_disk_bytes);
        build_.plan.facts.root_has_stand_in = 1;
        UnitElsewhere root = parts[0].root;
        FileInPlace out(files[0].pages(), /*is_new=*/false);
        if (tree.has_top()) root = TopPages<Build>(build_).write(tree, parts, shares[0].own_items, out);
        root.items = build_.plan.facts.report.items;
        append_pages(shares, files, out);
        out.write_at(build_.offset_of(pages), shares[0].notes);
        // Only now does the file begin like one.
        out.sync();
        out.write_at(0, page_file_head<H, P>(build_.options.build.partition, build_.options.build.approximation,
                                             build_.options.build.cost_model, build_.plan.facts, root,
                                             build_.plan.page_bytes, pages, build_.plan.facts.report.levels));
        out.sync();
        std::error_code error;
        std::filesystem::rename(files[0].pages(), build_.path, error);
        if (error) refuse_file("build_pages", build_.path, "cannot be replaced: " + error.message());
        for (const ShareFiles& f : files) f.remove_all();
    }

  private:
    ShareRecord<A, P> whole_share(const ShareFiles& files, std::uint32_t index, std::uint32_t count,
                                  std::span<const ShareRecord<A, P>> before) const {
        const std::string name = "share " + std::to_string(index) + " of " + std::to_string(count);
        std::error_code error;
        if (!std::filesystem::exists(files.journal(), error))
            refuse_file("join_page_shares", build_.path, name + " is missing");
        BuildJournal journal(files.journal());
        ShareRecord<A, P> share;
        if (!share.read(journal.records())) refuse_file("join_page_shares", build_.path, name + " has not begun");
        const Tree tree(share.top_nodes, share.plan.most_items);
        const std::size_t groups =
            tree.group_count() * (index + std::size_t(1)) / count - tree.group_count() * index / count;
        if (share.groups != groups) refuse_file("join_page_shares", build_.path, name + " is not finished");
        if (!before.empty() &&
            (share.plan.identity != before[0].plan.identity || share.plan.page_bytes != before[0].plan.page_bytes)) {
            refuse_file("join_page_shares", build_.path,
                        name + " is of another scene, or was built with other options");
        }
        return share;
    }
    /// The pages of the first share are where they belong.
    void append_pages(std::span<const ShareRecord<A, P>> shares, std::span<const ShareFiles> files, FileInPlace& out) {
        std::vector<std::byte> page(build_.plan.page_bytes);
        std::uint32_t number = build_.plan.top_pages + shares[0].pages;
        for (std::size_t s = 1; s < shares.size(); ++s) {
            FileInPlace in(files[s].pages(), /*is_new=*/false);
            for (std::uint32_t p = 0; p < shares[s].pages; ++p, ++number) {
                in.read_at(build_.offset_of(build_.plan.top_pages + p), page);
                renumber_page(page, number);
                out.write_at(build_.offset_of(number), page);
            }
        }
    }
    static void add_report(BuildReport& all, const BuildReport& part) {
        all.levels = std::max(all.levels, part.levels);
        for (const auto count : {&BuildReport::nodes, &BuildReport::leaves, &BuildReport::empty_cells_pruned,
                                 &BuildReport::splits_that_would_not_pay, &BuildReport::cells_at_depth_limit,
                                 &BuildReport::cells_that_cannot_be_told_apart, &BuildReport::stand_ins,
                                 &BuildReport::stand_ins_that_would_not_pay}) {
            all.*count += part.*count;
        }
    }

    Build& build_;
};

}  // namespace detail

}  // namespace farfield
