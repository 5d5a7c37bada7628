// A file of pages from more primitives than memory holds (Klein et al. 2002, section 5).
//
//     build_pages<H, Triangle>([&](auto&& take) { for (const Triangle& t : anything) take(t); }, "scene.farfield");
//
// The stream is read three times: for the bounds of the scene, for the number of primitives in each cell of its first
// levels, and to put primitives where they belong in a temporary file. Cells of few enough primitives are parts: each
// is built in memory as it would be in the whole, for what a cell becomes depends on what it holds alone, and its pages
// are written. Its root's stand-in is kept, and what that was made from; cells above are made of those, last of all.
// (The paper splits and writes recursively; a count beforehand replaces that, and everything is written twice at most.)
//
// What is on the disk is written down, so that a build that was stopped, by whatever, goes on where it was. Several
// processes may build a share each (build_page_share), on one machine or many, which are joined (join_page_shares): the
// file is the same, byte for byte, however many there were, and however many threads.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <span>
#include <stdexcept>
#include <string>
#include <system_error>
#include <type_traits>
#include <utility>
#include <vector>

#include "farfield/build.hpp"
#include "farfield/build/read_primitives.hpp"
#include "farfield/build_pages/build_journal.hpp"
#include "farfield/build_pages/page_share.hpp"
#include "farfield/build_pages/scattered_file.hpp"
#include "farfield/build_pages/top_tree.hpp"
#include "farfield/fail.hpp"
#include "farfield/paging/page_forest.hpp"
#include "farfield/paging/page_format.hpp"

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
};

namespace detail {

template <BuildsInParts H, PageablePrimitive P, class Sampler>
requires std::default_initializable<P>
class PageBuilder {
    using Partition_ = typename H::partition_type;
    using A = typename H::approximation_type;
    using Data = typename H::Data;
    using Records = PageRecords<H, P>;
    using Tree = TopTree<Partition_>;
    using Part = BuiltPart<A>;

  public:
    PageBuilder(const std::filesystem::path& path, const PageBuildOptions<H, Sampler>& options)
        : path_(path), options_(options), control_(options.build.executor, options.build.progress) {
        check_build_options(options.build);
        if (!options.build.approximation.merges_children()) {
            fail<std::invalid_argument>(
                "farfield::build_pages: the approximation's options make no stand-ins from those of children");
        }
        plan_.most_items = std::clamp<std::uint64_t>(options.memory_bytes / bytes_a_primitive, 512, 1u << 22);
    }

    /// Makes a share of all pages, and leaves files for join().
    template <class Stream>
    void build_share(Stream& stream, PageShare share) {
        if (share.count == 0 || share.index >= share.count) {
            fail<std::invalid_argument>("farfield::build_pages: share " + std::to_string(share.index) + " of " +
                                        std::to_string(share.count));
        }
        read_bounds(stream);
        const Tree tree(count_cells(stream), plan_.most_items);
        std::uint64_t needed = 1;
        do {
            // One more try for each cell that is larger than all before it; what goes into a group does not change.
            if (needed > Records::most_bytes) {
                fail<std::invalid_argument>("farfield::build_pages: one cell by itself takes " +
                                            std::to_string(needed) + " bytes, more than the " +
                                            std::to_string(Records::most_bytes) + " that a page may have");
            }
            plan_.page_bytes = std::uint32_t(Records::page_bytes(options_.page_bytes, needed));
            needed = build_groups(stream, tree, share);
        } while (needed != 0);
    }

    /// Makes the file of all shares and removes theirs.
    void join(std::uint32_t share_count) {
        std::vector<ShareRecord<A, P>> shares;
        std::vector<ShareFiles> files;
        for (std::uint32_t i = 0; i < share_count; ++i) {
            files.emplace_back(path_, PageShare{i, share_count});
            shares.push_back(whole_share(files.back(), i, share_count, shares));
        }
        if (shares.empty()) fail<std::invalid_argument>("farfield::join_page_shares: there are no shares");
        plan_ = shares[0].plan;
        const Tree tree(shares[0].top_nodes, plan_.most_items);
        std::vector<Part> parts;
        std::uint32_t pages = plan_.top_pages;
        for (const auto& s : shares) {
            for (Part p : s.parts) {
                p.root.page += pages;
                add_report(plan_.facts.report, p.report);
                parts.push_back(p);
            }
            pages += s.pages;
        }
        if (parts.size() != tree.parts().size()) refuse_file("join_page_shares", path_, "parts are missing");
        plan_.facts.root_has_stand_in = 1;
        UnitElsewhere root = parts[0].root;
        FileInPlace out(files[0].pages(), /*is_new=*/false);
        if (tree.has_top()) root = write_top(tree, parts, shares[0].own_items, out);
        root.items = plan_.facts.report.items;
        append_pages(shares, files, out);
        // Only now does the file begin like one.
        out.sync();
        out.write_at(
            0, page_file_head<H, P>(options_.build.partition, options_.build.approximation, options_.build.cost_model,
                                    plan_.facts, root, plan_.page_bytes, pages, plan_.facts.report.levels));
        out.sync();
        std::error_code error;
        std::filesystem::rename(files[0].pages(), path_, error);
        if (error) refuse_file("build_pages", path_, "cannot be replaced: " + error.message());
        for (const ShareFiles& f : files) f.remove_all();
    }

  private:
    /// Of two parts that are built while four wait to be written.
    static constexpr std::uint64_t bytes_a_primitive = 1024;
    static constexpr std::size_t groups_at_once = 4;
    static constexpr unsigned counted_levels = 7;
    static constexpr std::uint64_t reported_each = 1u << 20;

    HierarchyFacts& facts() { return plan_.facts; }

    // --- what holds for the whole

    template <class Stream>
    void read_bounds(Stream& stream) {
        Fingerprint fingerprint;
        auto whole = decltype(primitive_traits<P>::bounds(std::declval<const P&>()))::empty();
        std::uint64_t count = 0, contents = 0;
        stream([&](const P& p) {
            const auto b = checked_bounds(p, std::size_t(count));
            whole.add(b);
            fingerprint.add(Fingerprint::part(std::size_t(count), b));
            contents = mixed(contents, Xxh64::of(std::as_bytes(std::span(&p, 1))));
            if (++count % reported_each == 0) control_.report(BuildPhase::reading, std::size_t(count), 0);
        });
        check_primitive_count(std::size_t(count));
        facts() = {};
        facts().primitive_count = facts().report.primitives = facts().report.items = count;
        facts().fingerprint = fingerprint.of(std::size_t(count));
        facts().origin = origin_of<P>(whole, options_.build.world);
        // Rounding keeps the order of numbers: these are the bounds of all local bounds.
        if (count != 0) {
            if constexpr (has_double_bounds<P>) {
                add_bounds(facts().bounds,
                           {glm::vec3(whole.lower - facts().origin), glm::vec3(whole.upper - facts().origin)},
                           std::size_t(count - 1));
            } else {
                add_bounds(facts().bounds, whole, std::size_t(count - 1));
            }
        }
        facts().root = options_.build.partition.root(bounds_of_root(facts(), options_.build.world));
        tell_light<A>(options_.build.sampler, facts());
        plan_.identity = mixed(identity(), contents);
    }
    std::uint64_t identity() const {
        std::uint64_t hash = mixed(plan_.facts.fingerprint, plan_.facts.primitive_count);
        for (const std::uint32_t tag : page_records<H, P>()) hash = mixed(hash, tag);
        for (const auto& bytes :
             {bytes_of(options_.build.partition), bytes_of<stored_approximation_of<A>>(options_.build.approximation),
              bytes_of(options_.build.cost_model)}) {
            hash = mixed(hash, Xxh64::of(bytes));
        }
        if constexpr (MadeOfNumbers<Sampler>) hash = mixed(hash, Xxh64::of(bytes_of(options_.build.sampler)));
        return mixed(mixed(hash, plan_.most_items), options_.page_bytes);
    }

    template <class Stream>
    CellCounts<Partition_> count_cells(Stream& stream) {
        CellCounts<Partition_> counts(options_.build.partition, facts().root, counted_levels);
        std::uint64_t count = 0;
        Work some;
        stream([&](const P& p) {
            const auto [item, work] = read_item(p, std::size_t(count), options_.build.cost_model, facts().origin);
            counts.add(item);
            some += work;
            if (++count % reported_each != 0) return;
            // Single precision cannot count one by one beyond 2^24.
            facts().work += std::exchange(some, Work{});
            control_.report(BuildPhase::counting, std::size_t(count), std::size_t(facts().primitive_count));
        });
        facts().work += some;
        check_stream(count);
        counts.sum_up();
        return counts;
    }
    void check_stream(std::uint64_t count) const {
        if (count == plan_.facts.primitive_count) return;
        fail<std::invalid_argument>("farfield::build_pages: the stream gave " +
                                    std::to_string(plan_.facts.primitive_count) + " primitives at first, and now " +
                                    std::to_string(count));
    }

    // --- a share

    /// Returns 0, or the bytes that one cell needs where pages are too small for it.
    template <class Stream>
    std::uint64_t build_groups(Stream& stream, const Tree& tree, PageShare share) {
        const ShareFiles files(path_, share);
        const std::size_t begin = tree.group_count() * share.index / share.count,
                          end = tree.group_count() * (share.index + std::size_t(1)) / share.count;
        BuildJournal journal(files.journal(),
                             mixed(mixed(mixed(plan_.identity, plan_.page_bytes), share.index), share.count));
        ShareRecord<A, P> known;
        std::error_code ignored;
        if (!known.read(journal.records()) || !std::filesystem::exists(files.scattered(), ignored) ||
            !has_pages(known, files)) {
            files.remove_all();
            known = {};
            known.own_items = scatter(stream, tree, files, begin, end);
            plan_.top_pages = 0;
            if (tree.has_top()) {
                const PageForest<H, P> top = top_forest(tree, known.own_items);
                if (!top.fits()) return top.needed_bytes();
                plan_.top_pages = top.page_count();
            }
            // Primitives have no checksums: whatever a journal tells of them has to be there.
            FileInPlace(files.scattered(), /*is_new=*/false).sync();
            FileInPlace(files.pages(), /*is_new=*/true);
            journal.append(ShareRecord<A, P>::plan_record(plan_, tree.nodes(), known.own_items));
        } else {
            plan_ = known.plan;
        }
        FileInPlace pages(files.pages(), /*is_new=*/false);
        std::vector<std::uint64_t> first_item{0};
        for (std::size_t g = begin; g < end; ++g) first_item.push_back(first_item.back() + tree.items_of_group(g));
        std::uint32_t page_count = known.pages;
        for (std::size_t g = begin + known.groups; g < end; g += groups_at_once) {
            const std::size_t count = std::min(groups_at_once, end - g);
            std::array<BuiltGroup, groups_at_once> built;
            control_.run_quietly(count, [&](std::size_t i) {
                built[i] = build_group(tree, g + i, files.scattered(), first_item[g + i - begin]);
            });
            for (std::size_t i = 0; i < count; ++i) {
                if (built[i].needed_bytes != 0) return built[i].needed_bytes;
                std::span<std::byte> bytes(built[i].pages);
                const auto more = std::uint32_t(bytes.size() / plan_.page_bytes);
                for (std::uint32_t p = 0; p < more; ++p) {
                    renumber_page(bytes.subspan(std::size_t(p) * plan_.page_bytes, plan_.page_bytes),
                                  plan_.top_pages + page_count + p);
                }
                pages.write_at(offset_of(plan_.top_pages + page_count), bytes);
                for (Part& part : built[i].parts) part.root.page += page_count;
                page_count += more;
                journal.append(ShareRecord<A, P>::group_record(more, built[i].parts));
            }
            control_.report(BuildPhase::building, std::size_t(first_item[g + count - begin]),
                            std::size_t(first_item.back()));
        }
        return 0;
    }

    /// Whether all pages are there that a share tells of, and whole.
    bool has_pages(const ShareRecord<A, P>& share, const ShareFiles& files) {
        std::error_code error;
        plan_.page_bytes = share.plan.page_bytes;
        if (plan_.page_bytes < sizeof(PageHeader) || !std::filesystem::exists(files.pages(), error)) return false;
        if (share.pages == 0) return true;
        if (std::filesystem::file_size(files.pages(), error) <
            offset_of(std::uint64_t(share.plan.top_pages) + share.pages)) {
            return false;
        }
        FileInPlace in(files.pages(), /*is_new=*/false);
        std::vector<std::byte> page(plan_.page_bytes);
        for (std::uint32_t p = 0; p < share.pages; ++p) {
            in.read_at(offset_of(share.plan.top_pages + std::uint64_t(p)), page);
            PageHeader header;
            std::memcpy(&header, page.data(), sizeof header);
            if (header.number != share.plan.top_pages + p || header.used_bytes > page.size() ||
                header.used_bytes < sizeof header || header.checksum != checksum_of_page(page, header.used_bytes)) {
                return false;
            }
        }
        return true;
    }

    std::uint64_t first_page() const {
        // It does not depend on what the head says.
        return page_file_head<H, P>(options_.build.partition, options_.build.approximation, options_.build.cost_model,
                                    {}, {}, plan_.page_bytes, 0, 0)
            .size();
    }
    std::uint64_t offset_of(std::uint64_t page) const { return first_page() + page * plan_.page_bytes; }

    /// Puts the primitives of groups [begin, end) into a file, and returns those that stay above all parts.
    template <class Stream>
    std::vector<P> scatter(Stream& stream, const Tree& tree, const ShareFiles& files, std::size_t begin,
                           std::size_t end) {
        if (tree.own_items() * sizeof(P) > options_.memory_bytes / 2) {
            fail<std::invalid_argument>("farfield::build_pages: " + std::to_string(tree.own_items()) +
                                        " primitives are larger than the cells of the first " +
                                        std::to_string(counted_levels) +
                                        " levels, and take more than half of memory_bytes");
        }
        std::vector<std::uint64_t> counts;
        std::uint64_t all = 0;
        for (std::size_t g = begin; g < end; ++g) all += counts.emplace_back(tree.items_of_group(g));
        check_disk(all);
        std::vector<P> own(std::size_t(tree.own_items()));
        std::vector<std::uint32_t> next_own;
        for (const TopNode& n : tree.nodes()) next_own.push_back(n.own_begin);
        ScatterWriter<P> writer(files.scattered(), counts, std::size_t(options_.memory_bytes / 4));
        std::uint64_t count = 0;
        stream([&](const P& p) {
            const std::uint32_t n = tree.node_of(options_.build.partition, item_of(p, std::size_t(count)));
            const TopNode& node = tree.nodes()[n];
            if (node.child_mask != 0) {
                if (next_own[n] == node.own_begin + node.own_items) check_stream(count);
                own[next_own[n]++] = p;
            } else if (const std::size_t g = tree.group_of_part(node.part); g >= begin && g < end) {
                writer.add(g - begin, p);
            }
            if (++count % reported_each == 0) {
                control_.report(BuildPhase::moving, std::size_t(count), std::size_t(facts().primitive_count));
            }
        });
        check_stream(count);
        writer.finish();
        return own;
    }
    Item item_of(const P& p, std::size_t index) const {
        return {local_bounds(p, plan_.facts.origin), std::uint32_t(index), 0};
    }
    /// "A disk that is full" is said before hours have gone by: the temporary file, and the pages.
    void check_disk(std::uint64_t items) const {
        std::error_code error;
        std::filesystem::path folder = path_.parent_path();
        if (folder.empty()) folder = ".";
        const std::filesystem::space_info space = std::filesystem::space(folder, error);
        const std::uint64_t needed = items * (sizeof(P) + sizeof(P) + sizeof(P) / 8);
        if (!error && space.available < needed) {
            refuse_file("build_pages", path_,
                        "needs about " + std::to_string(needed >> 20) + " MiB, and the disk has " +
                            std::to_string(space.available >> 20) + " left");
        }
    }

    struct BuiltGroup {
        std::vector<std::byte> pages;
        std::vector<Part> parts;
        std::uint64_t needed_bytes = 0;  ///< 0, or there are no pages, which were too small
    };
    BuiltGroup build_group(const Tree& tree, std::size_t group, const std::filesystem::path& scattered,
                           std::uint64_t first_item) const {
        const std::span<const std::uint32_t> nodes = tree.group(group);
        std::vector<std::size_t> ends;
        const std::vector<P> primitives =
            sorted_by_part(tree, nodes, read_scattered<P>(scattered, first_item, tree.items_of_group(group)), ends);
        const AnyExecutor alone;
        const ProgressCallback quiet;
        const BuildControl control(alone, quiet);
        BuiltGroup out;
        out.parts.resize(nodes.size());
        std::vector<H> hierarchies;
        std::vector<PageTree<H, P>> trees;
        hierarchies.reserve(nodes.size());
        for (std::size_t i = 0; i < nodes.size(); ++i) {
            const std::size_t first = i == 0 ? 0 : ends[i - 1];
            const auto of_part = std::span<const P>(primitives).subspan(first, ends[i] - first);
            BuildBudget budget;
            budget.part = &tree.nodes()[nodes[i]].cell;
            // So that primitives in double precision have the origin that they have in the whole.
            budget.world = whole_world();
            const auto& b = options_.build;
            hierarchies.emplace_back(b.partition, b.approximation, b.cost_model,
                                     HierarchyBuilder<H, P, Sampler>(of_part, b.partition, b.approximation,
                                                                     b.cost_model, b.sampler, budget, control)
                                         .build_part(&out.parts[i].draft));
            trees.push_back({&hierarchies.back(), of_part});
        }
        PageForest<H, P> forest(trees, plan_.page_bytes, plan_.page_bytes);
        if (!forest.fits()) return {{}, {}, forest.needed_bytes()};
        out.pages.reserve(std::size_t(forest.page_count()) * plan_.page_bytes);
        forest.write(0, plan_.facts.fingerprint, [&](std::span<const std::byte> page) {
            out.pages.insert(out.pages.end(), page.begin(), page.end());
        });
        for (std::size_t i = 0; i < nodes.size(); ++i) {
            out.parts[i].root = forest.root_of(i);
            out.parts[i].stand_in = *hierarchies[i].root_stand_in();
            out.parts[i].report = hierarchies[i].report();
            out.parts[i].report.levels += hierarchies[i].root_cell().depth;
        }
        return out;
    }
    BoxD whole_world() const {
        BoxD world = BoxD::empty();
        if constexpr (has_double_bounds<P>) {
            const glm::dvec3 o = plan_.facts.origin;
            world = BoxD{o, o};
        }
        return world;
    }
    std::vector<P> sorted_by_part(const Tree& tree, std::span<const std::uint32_t> nodes,
                                  const std::vector<P>& mixed_up, std::vector<std::size_t>& ends) const {
        if (nodes.size() == 1) {
            ends = {mixed_up.size()};
            return mixed_up;
        }
        const std::uint32_t first_part = tree.nodes()[nodes[0]].part;
        std::vector<std::uint32_t> part_of;
        part_of.reserve(mixed_up.size());
        std::vector<std::size_t> next(nodes.size() + 1);
        for (const P& p : mixed_up) {
            part_of.push_back(tree.nodes()[tree.node_of(options_.build.partition, item_of(p, 0))].part - first_part);
            ++next[part_of.back() + std::size_t(1)];
        }
        for (std::size_t i = 1; i < next.size(); ++i) next[i] += next[i - 1];
        ends.assign(next.begin() + 1, next.end());
        std::vector<P> sorted(mixed_up.size());
        for (std::size_t i = 0; i < mixed_up.size(); ++i) sorted[next[part_of[i]]++] = mixed_up[i];
        return sorted;
    }

    // --- what lies above the parts

    /// As a hierarchy, with stand-ins that are not made yet and parts as leaves.
    Data top_data(const Tree& tree) const {
        Data data;
        data.facts = plan_.facts;
        data.facts.report.items = tree.own_items();
        data.facts.primitive_count = tree.own_items();
        data.facts.root_has_stand_in = 1;
        for (const TopNode& n : tree.nodes()) {
            Node node;
            node.first_child = n.child_mask != 0 ? n.first_child : 0;
            node.first_item = n.own_begin;
            node.first_child_data = node.first_child;  // every node has a stand-in
            node.child_mask = node.stand_in_mask = n.child_mask;
            data.nodes.push_back(node);
        }
        data.stand_ins.resize(data.nodes.size());
        return data;
    }
    H hierarchy_of(Data data) const {
        return H(options_.build.partition, options_.build.approximation, options_.build.cost_model, std::move(data));
    }
    /// To see how many pages it takes.
    PageForest<H, P> top_forest(const Tree& tree, std::span<const P> own_items) const {
        const H h = hierarchy_of(top_data(tree));
        const std::vector<UnitElsewhere> elsewhere(tree.nodes().size());
        return PageForest<H, P>({{&h, own_items, elsewhere}}, plan_.page_bytes, plan_.page_bytes);
    }

    /// Writes the first pages and returns where the root is.
    UnitElsewhere write_top(const Tree& tree, std::span<const Part> parts, std::span<const P> own_items,
                            FileInPlace& out) {
        Data data = top_data(tree);
        std::vector<UnitElsewhere> elsewhere(tree.nodes().size());
        std::vector<typename A::stand_in_draft> drafts(tree.nodes().size());
        Sampler sampler = options_.build.sampler;
        const A& approximation = options_.build.approximation;
        for (std::size_t n = tree.nodes().size(); n-- > 0;) {
            const TopNode& node = tree.nodes()[n];
            if (node.child_mask == 0) {
                const Part& part = parts[node.part];
                drafts[n] = part.draft;
                data.stand_ins[n] = part.stand_in;
                elsewhere[n] = part.root;
                data.nodes[n].stand_in_levels_below = part.root.node.stand_in_levels_below;
                data.nodes[n].levels_replaced = part.root.node.levels_replaced;
                continue;
            }
            if (node.own_items != 0) {
                const auto own = own_items.subspan(node.own_begin, std::size_t(node.own_items));
                const auto contents = [&](auto&& sink) {
                    for (const P& p : own) local_polygons(p, plan_.facts.origin, sink);
                };
                drafts[n] = approximation.sample(node.cell, contents, sampler);
            }
            std::array<ChildDraft<typename A::stand_in_draft>, 8> children;
            unsigned count = 0;
            for (unsigned mask = node.child_mask; mask != 0; mask &= mask - 1, ++count) {
                const std::uint32_t at = node.first_child + count;
                children[count] = {unsigned(std::countr_zero(mask)), &tree.nodes()[at].cell, &drafts[at]};
            }
            approximation.merge(node.cell, drafts[n], {children.data(), count});
            std::vector<typename H::pool_element> no_pool;
            data.stand_ins[n] = finished_stand_in(approximation, node.cell, drafts[n], no_pool);
            mark_levels_below(data.nodes[n], std::span<const Node>(data.nodes).subspan(node.first_child), true);
        }
        count_top(tree);
        const H h = hierarchy_of(std::move(data));
        PageForest<H, P> forest({{&h, own_items, elsewhere}}, plan_.page_bytes, plan_.page_bytes);
        std::uint32_t number = 0;
        forest.write(0, plan_.facts.fingerprint,
                     [&](std::span<const std::byte> page) { out.write_at(offset_of(number++), page); });
        return forest.root_of(0);
    }
    void count_top(const Tree& tree) {
        const auto above = std::uint32_t(tree.nodes().size() - tree.parts().size());
        plan_.facts.report.nodes += above;
        plan_.facts.report.stand_ins += above;
    }

    // --- joining

    ShareRecord<A, P> whole_share(const ShareFiles& files, std::uint32_t index, std::uint32_t count,
                                  std::span<const ShareRecord<A, P>> before) const {
        const std::string name = "share " + std::to_string(index) + " of " + std::to_string(count);
        std::error_code error;
        if (!std::filesystem::exists(files.journal(), error))
            refuse_file("join_page_shares", path_, name + " is missing");
        BuildJournal journal(files.journal());
        ShareRecord<A, P> share;
        if (!share.read(journal.records())) refuse_file("join_page_shares", path_, name + " has not begun");
        const Tree tree(share.top_nodes, share.plan.most_items);
        const std::size_t groups =
            tree.group_count() * (index + std::size_t(1)) / count - tree.group_count() * index / count;
        if (share.groups != groups) refuse_file("join_page_shares", path_, name + " is not finished");
        if (!before.empty() &&
            (share.plan.identity != before[0].plan.identity || share.plan.page_bytes != before[0].plan.page_bytes)) {
            refuse_file("join_page_shares", path_, name + " is of another scene, or was built with other options");
        }
        return share;
    }
    /// The pages of the first share are where they belong.
    void append_pages(std::span<const ShareRecord<A, P>> shares, std::span<const ShareFiles> files, FileInPlace& out) {
        std::vector<std::byte> page(plan_.page_bytes);
        std::uint32_t number = plan_.top_pages + shares[0].pages;
        for (std::size_t s = 1; s < shares.size(); ++s) {
            FileInPlace in(files[s].pages(), /*is_new=*/false);
            for (std::uint32_t p = 0; p < shares[s].pages; ++p, ++number) {
                in.read_at(offset_of(plan_.top_pages + p), page);
                renumber_page(page, number);
                out.write_at(offset_of(number), page);
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

    std::filesystem::path path_;
    const PageBuildOptions<H, Sampler>& options_;
    BuildControl control_;
    SharedPlan plan_;
};

}  // namespace detail

/// Builds a share of a file of pages, and leaves it beside where that will be (`path.0-of-2.pages`, and so on). A share
/// that was stopped goes on where it was when it is built again, and one that is there already is left as it is. See
/// build_pages() for what it throws.
template <BuildsInParts H, PageablePrimitive P, OrthographicSampler Sampler = GridSampler, class Stream>
void build_page_share(Stream&& stream, const std::filesystem::path& path, PageShare share,
                      const PageBuildOptions<H, Sampler>& options = {}) {
    detail::PageBuilder<H, P, Sampler>(path, options).build_share(stream, share);
}

/// Joins all shares of a file and removes what they left. The options are those of the shares. Throws
/// std::runtime_error that names the share which is missing, not finished, or of another build.
template <BuildsInParts H, PageablePrimitive P, OrthographicSampler Sampler = GridSampler>
void join_page_shares(const std::filesystem::path& path, std::uint32_t share_count,
                      const PageBuildOptions<H, Sampler>& options = {}) {
    detail::PageBuilder<H, P, Sampler>(path, options).join(share_count);
}

/// Builds a file of pages. stream(take) calls take(const P&) with every primitive; it is called three times or more,
/// and must give the same each time, in the same order. The same stream and options give the same bytes, on any number
/// of threads, in any number of shares, and after any number of builds of it that were stopped: whatever is left beside
/// `path` by one goes into the next. `path` itself is only there when all of it is.
///
/// Throws std::invalid_argument that names a primitive which cannot be built from, as build() does, or where the stream
/// does not keep to that, or if one cell by itself holds more than 64 MiB; std::runtime_error that names the file if
/// the disk is too small or fails; BuildCanceled.
template <BuildsInParts H, PageablePrimitive P, OrthographicSampler Sampler = GridSampler, class Stream>
void build_pages(Stream&& stream, const std::filesystem::path& path, const PageBuildOptions<H, Sampler>& options = {}) {
    detail::PageBuilder<H, P, Sampler> builder(path, options);
    builder.build_share(stream, {});
    builder.join(1);
}

}  // namespace farfield
