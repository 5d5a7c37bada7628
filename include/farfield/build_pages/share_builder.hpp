// One share of a build outside of memory: its primitives go into a file, group by group, and groups into pages.
// Whatever is on the disk is written down, and a build that was stopped goes on behind it.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "farfield/build/build_progress.hpp"
#include "farfield/build_pages/build_journal.hpp"
#include "farfield/build_pages/disk_room.hpp"
#include "farfield/build_pages/file_in_place.hpp"
#include "farfield/build_pages/group_builder.hpp"
#include "farfield/build_pages/kept_share.hpp"
#include "farfield/build_pages/ordered_results.hpp"
#include "farfield/build_pages/page_build.hpp"
#include "farfield/build_pages/page_share.hpp"
#include "farfield/build_pages/scattered_file.hpp"
#include "farfield/build_pages/scene_survey.hpp"
#include "farfield/build_pages/stream_batches.hpp"
#include "farfield/build_pages/top_pages.hpp"
#include "farfield/build_pages/top_tree.hpp"
#include "farfield/composition.hpp"
#include "farfield/fail.hpp"
#include "farfield/paging/page_forest.hpp"
#include "farfield/paging/page_format.hpp"

namespace farfield {
namespace detail {

template <class Build>
class ShareBuilder {
    using H = typename Build::hierarchy_type;
    using P = typename Build::primitive_type;
    using Records = typename Build::Records;
    using BuiltGroup = typename GroupBuilder<Build>::BuiltGroup;
    using Partition_ = typename H::partition_type;
    using A = typename H::approximation_type;
    using Tree = TopTree<Partition_>;
    using Part = BuiltPart<A>;

  public:
    explicit ShareBuilder(Build& build) : build_(build) {}

    /// Makes a share of all pages, and leaves files for join().
    template <class Stream>
    void operator()(Stream& stream, PageShare share) {
        refuse_wrong(share);
        const Tree tree = survey_of(stream);
        std::uint64_t needed = 1;
        do {
            // One more try for each cell that is larger than all before it; what goes into a group does not change.
            if (needed > Records::most_bytes) {
                fail<std::invalid_argument>("farfield::build_pages: one cell by itself takes " +
                                            std::to_string(needed) + " bytes, more than the " +
                                            std::to_string(Records::most_bytes) + " that a page may have");
            }
            build_.plan.page_bytes = std::uint32_t(Records::page_bytes(build_.options.page_bytes, needed));
            needed = build_groups(stream, tree, share);
        } while (needed != 0);
    }
    /// Bytes that it takes of the disk meanwhile, at most.
    template <class Stream>
    std::uint64_t disk_bytes(Stream& stream, PageShare share) {
        refuse_wrong(share);
        const Tree tree = survey_of(stream);
        build_.plan.page_bytes = std::uint32_t(Records::page_bytes(build_.options.page_bytes, 1));
        return disk_bytes_of(tree, groups_of(tree, share));
    }

  private:
    /// More keep threads from waiting for one another at the end of each round; a group that comes long before its turn
    /// has to wait in memory.
    static constexpr std::size_t groups_at_once = 16;

    /// Of what a journal tells, and how what it tells of lies in files.
    static constexpr std::uint64_t journal_version = 3;

    static void refuse_wrong(PageShare share) {
        if (share.count == 0 || share.index >= share.count) {
            fail<std::invalid_argument>("farfield::build_pages: share " + std::to_string(share.index) + " of " +
                                        std::to_string(share.count));
        }
    }
    template <class Stream>
    Tree survey_of(Stream& stream) {
        SceneSurvey<Build> survey(build_);
        survey.read_bounds(stream);
        const auto counts = survey.count_cells(stream);
        contents_ = survey.contents();
        return Tree(counts, build_.plan.most_items);
    }
    static std::array<std::size_t, 2> groups_of(const Tree& tree, PageShare share) {
        return {tree.group_count() * share.index / share.count,
                tree.group_count() * (share.index + std::size_t(1)) / share.count};
    }
    /// Of a share's groups. Primitives lie in one file until pages of them are in another; all cells of the scene may
    /// be in it, and all of its long runs.
    std::uint64_t disk_bytes_of(const Tree& tree, std::array<std::size_t, 2> groups) const {
        ContentsOfPages contents = contents_;
        std::uint64_t parts = 0;
        contents.primitives = 0;
        for (std::size_t g = groups[0]; g < groups[1]; ++g) {
            contents.primitives += tree.items_of_group(g);
            parts += tree.group(g).size();
        }
        const std::uint64_t moved = contents.primitives * sizeof(P), above = tree.own_items() * sizeof(P);
        contents.primitives += tree.own_items();
        contents.cells = std::min(contents.cells, 1 + double(contents.primitives) * contents.cells_each);
        contents.in_long_runs = std::min(contents.in_long_runs, contents.primitives);
        // No page is shared by two groups. A journal holds what lies above parts, and drafts of their roots.
        return moved + std::uint64_t(bytes_of_pages<H, P>(contents, build_.plan.page_bytes)) + build_.first_page() +
               (groups[1] - groups[0]) * build_.plan.page_bytes + above + parts * sizeof(Part) +
               tree.nodes().size() * sizeof(TopNode) + 2 * build_.notes.size();
    }

    /// Returns 0, or the bytes that one cell needs where pages are too small for it.
    template <class Stream>
    std::uint64_t build_groups(Stream& stream, const Tree& tree, PageShare share) {
        const ShareFiles files(build_.path, share);
        const std::size_t begin = groups_of(tree, share)[0], end = groups_of(tree, share)[1];
        BuildJournal journal(
            files.journal(),
            mixed(mixed(mixed(mixed(build_.plan.identity, journal_version), build_.plan.page_bytes), share.index),
                  share.count));
        ShareRecord<A, P> known;
        std::vector<std::uint64_t> first_item{0};
        for (std::size_t g = begin; g < end; ++g) first_item.push_back(first_item.back() + tree.items_of_group(g));
        if (!known.read(journal.records()) || !KeptShare<Build>(build_, known, files).is_whole(tree, begin, end)) {
            files.remove_all();
            known = {};
            scatter(stream, tree, files, begin, end, known);
            build_.plan.top_pages = 0;
            if (tree.has_top()) {
                const PageForest<H, P> top = TopPages<Build>(build_).forest(tree, known.own_items);
                if (!top.fits()) return top.needed_bytes();
                build_.plan.top_pages = top.page_count();
            }
            FileInPlace(files.pages(), /*is_new=*/true);
            journal.append(ShareRecord<A, P>::plan_record(build_.plan, tree.nodes(), known.own_items, known.scattered,
                                                          build_.notes));
        } else {
            build_.plan = known.plan;
        }
        FileInPlace scattered(files.scattered(), /*is_new=*/false), pages(files.pages(), /*is_new=*/false);
        std::uint32_t page_count = known.pages;
        std::size_t written = known.groups;
        GroupBuilder<Build> build_group(build_, scattered);
        // Whoever has built one writes those whose turn it is, while others build.
        OrderedResults<BuiltGroup> results(groups_at_once);
        for (std::size_t next = begin + known.groups; next < end;) {
            const std::size_t count = std::min(groups_at_once, end - next);
            results.restart();
            std::uint64_t needed = 0;
            build_.control.run_quietly(count, [&](std::size_t i) {
                results.add(i, build_group(tree, next + i, first_item[next + i - begin]), [&](BuiltGroup& group) {
                    if (needed == 0) needed = group.needed_bytes;
                    if (needed != 0) return;
                    write_group(group, pages, page_count, journal, [&](std::size_t piece, std::size_t pieces) {
                        if (written == known.groups) return;
                        const std::uint64_t first = first_item[written - 1] * sizeof(P),
                                            bytes = first_item[written] * sizeof(P) - first;
                        const std::uint64_t done = bytes * piece / pieces;
                        scattered.forget(first + done, bytes * (piece + 1) / pieces - done);
                    });
                    build_group.give_back(group);
                    ++written;
                });
            });
            if (needed != 0) return needed;
            next += count;
            build_.control.report(BuildPhase::building, std::size_t(first_item[next - begin]),
                                  std::size_t(first_item.back()));
        }
        return 0;
    }

    /// Writes the pages of a group behind those that are there, and what they are into the journal. Calls forget(i, n)
    /// before the i-th of n pieces is written, for as much of what is of no use any more: the system then writes into
    /// the memory that it has just been given back, instead of memory that has never been touched, which takes several
    /// times as long.
    template <class Forget>
    void write_group(BuiltGroup& group, FileInPlace& pages, std::uint32_t& page_count, BuildJournal& journal,
                     Forget&& forget) const {
        const std::uint32_t page_bytes = build_.plan.page_bytes, top_pages = build_.plan.top_pages;
        const std::span<std::byte> bytes(group.pages);
        const auto more = std::uint32_t(bytes.size() / page_bytes);
        for (std::uint32_t p = 0; p < more; ++p) {
            renumber_page(bytes.subspan(std::size_t(p) * page_bytes, page_bytes), top_pages + page_count + p);
        }
        const std::uint64_t offset = build_.offset_of(std::uint64_t(top_pages) + page_count);
        constexpr std::size_t piece = std::size_t(1) << 20;
        const std::size_t pieces = (bytes.size() + piece - 1) / piece;
        for (std::size_t i = 0; i < pieces; ++i) {
            forget(i, pieces);
            pages.write_at(offset + i * piece, bytes.subspan(i * piece, std::min(piece, bytes.size() - i * piece)));
        }
        pages.begin_to_sync(offset, bytes.size());
        for (Part& part : group.parts) part.root.page += page_count;
        page_count += more;
        journal.append(ShareRecord<A, P>::group_record(more, group.parts));
    }

    /// Puts the primitives of groups [begin, end) into a file, part by part, and those that stay above all parts into
    /// the record.
    template <class Stream>
    void scatter(Stream& stream, const Tree& tree, const ShareFiles& files, std::size_t begin, std::size_t end,
                 ShareRecord<A, P>& to) {
        if (tree.own_items() * sizeof(P) > build_.options.memory_bytes / 2) {
            fail<std::invalid_argument>("farfield::build_pages: " + std::to_string(tree.own_items()) +
                                        " primitives are larger than the cells of the first " +
                                        std::to_string(Build::counted_levels) +
                                        " levels, and take more than half of memory_bytes");
        }
        std::vector<std::uint64_t> counts;
        const std::uint32_t first_part = begin < end ? tree.nodes()[tree.group(begin)[0]].part : 0;
        for (std::size_t g = begin; g < end; ++g) {
            for (const std::uint32_t n : tree.group(g)) counts.push_back(tree.nodes()[n].items);
        }
        check_disk_room(build_.path, disk_bytes_of(tree, {begin, end}), build_.options.most_disk_bytes);
        to.own_items.resize(std::size_t(tree.own_items()));
        std::vector<std::uint32_t> next_own;
        for (const TopNode& n : tree.nodes()) next_own.push_back(n.own_begin);
        FileInPlace file(files.scattered(), /*is_new=*/true);
        ScatterWriter<P> writer(file, counts, build_.control);
        const std::uint64_t whole_count = build_.plan.facts.primitive_count;
        // A quarter for what is read and for the same in order; no more than gives parts long pieces.
        const std::uint64_t most = std::max<std::uint64_t>(build_.options.memory_bytes / (8 * sizeof(P)), stream_batch);
        const auto block_size = std::size_t(std::min<std::uint64_t>(most, (counts.size() + 16) * 1024));
        std::vector<std::uint32_t> part_of;
        std::vector<std::vector<std::pair<std::size_t, std::uint32_t>>> own_of_batch;
        const std::uint64_t count =
            in_blocks<P>(stream, block_size, [&](std::span<const P> block, std::uint64_t first) {
                if (first + block.size() > whole_count) SceneSurvey<Build>(build_).check_stream(first + block.size());
                part_of.resize(block.size());
                own_of_batch.resize((block.size() + stream_batch - 1) / stream_batch);
                build_.control.run_quietly(own_of_batch.size(), [&](std::size_t b) {
                    own_of_batch[b].clear();
                    for (std::size_t i = b * stream_batch; i < std::min((b + 1) * stream_batch, block.size()); ++i) {
                        const std::uint32_t n = tree.node_of(
                            build_.options.build.partition,
                            {local_bounds(block[i], build_.plan.facts.origin), std::uint32_t(first + i), 0});
                        const TopNode& node = tree.nodes()[n];
                        if (node.child_mask != 0) own_of_batch[b].emplace_back(i, n);
                        const bool is_ours = node.child_mask == 0 && node.part - first_part < counts.size();
                        part_of[i] = is_ours ? node.part - first_part : ScatterWriter<P>::nowhere;
                    }
                });
                for (const auto& own : own_of_batch) {
                    for (const auto& [i, n] : own) {
                        const TopNode& node = tree.nodes()[n];
                        if (next_own[n] == node.own_begin + node.own_items) refuse_other_stream();
                        to.own_items[next_own[n]++] = block[i];
                    }
                }
                if (!writer.add(block, part_of)) refuse_other_stream();
                const std::uint64_t done = first + block.size();
                if (done / Build::reported_each != first / Build::reported_each) {
                    build_.control.report(BuildPhase::moving, std::size_t(done), std::size_t(whole_count));
                }
            });
        SceneSurvey<Build>(build_).check_stream(count);
        for (std::size_t p = 0; p < counts.size(); ++p) to.scattered.push_back(writer.sum(p));
    }
    [[noreturn]] static void refuse_other_stream() {
        fail<std::invalid_argument>(
            "farfield::build_pages: the stream gives other primitives than at first, or in another order");
    }

    Build& build_;
    ContentsOfPages contents_;
};

}  // namespace detail

}  // namespace farfield
