// What one of several builds outside of memory leaves for whoever joins them: its pages, and what cells above are made
// of.
#pragma once

#include "farfield/settings.hpp"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "farfield/build_pages/build_journal.hpp"
#include "farfield/build_pages/top_tree.hpp"
#include "farfield/hierarchy/hierarchy_data.hpp"
#include "farfield/paging/page_forest.hpp"

namespace farfield {

/// One of several builds that share the work.
struct PageShare {
    std::uint32_t index = 0, count = 1;
};

namespace detail {

/// A part of the scene that has been built.
template <class A>
struct BuiltPart {
    UnitElsewhere root;  ///< in the share's pages
    typename A::stand_in_data stand_in{};
    typename A::stand_in_draft draft{};
    BuildReport report;
};

/// What all shares of a build agree on.
struct SharedPlan {
    std::uint64_t identity = 0;  ///< of scene and options
    std::uint64_t most_items = 0;
    std::uint32_t page_bytes = 0;
    std::uint32_t top_pages = 0;
    HierarchyFacts facts;
};

/// The names of its files begin with that of the file that is to be.
class ShareFiles {
  public:
    ShareFiles(const std::filesystem::path& target, PageShare share) : target_(target), share_(share) {}
    std::filesystem::path pages() const { return named(".pages"); }
    std::filesystem::path journal() const { return named(".journal"); }
    std::filesystem::path scattered() const { return named(".scattered"); }
    void remove_all() const {
        for (const auto& p : {pages(), journal(), scattered()}) {
            std::error_code ignored;
            std::filesystem::remove(p, ignored);
        }
    }

  private:
    std::filesystem::path named(const char* end) const {
        std::filesystem::path p = target_;
        p += "." + std::to_string(share_.index) + "-of-" + std::to_string(share_.count) + end;
        return p;
    }
    std::filesystem::path target_;
    PageShare share_;
};

/// What the journal of a share tells.
template <class A, class P>
struct ShareRecord {
    SharedPlan plan;
    std::vector<TopNode> top_nodes;
    std::vector<P> own_items;              ///< of cells above parts, depth first
    std::vector<std::uint64_t> scattered;  ///< sum_of_scattered() of each part of the share
    std::vector<std::byte> notes;          ///< as they lie in the file
    std::vector<BuiltPart<A>> parts;
    std::uint32_t groups = 0;  ///< that have been built
    std::uint32_t pages = 0;   ///< that they take

    static RecordBytes plan_record(const SharedPlan& plan, std::span<const TopNode> nodes, std::span<const P> own_items,
                                   std::span<const std::uint64_t> scattered, std::span<const std::byte> notes) {
        RecordBytes r;
        r.put(plan);
        r.put(std::uint64_t(nodes.size()));
        r.put(nodes);
        r.put(std::uint64_t(own_items.size()));
        r.put(own_items);
        r.put(std::uint64_t(scattered.size()));
        r.put(scattered);
        r.put(std::uint64_t(notes.size()));
        r.put(notes);
        return r;
    }
    static RecordBytes group_record(std::uint32_t pages, std::span<const BuiltPart<A>> parts) {
        RecordBytes r;
        r.put(pages);
        r.put(std::uint64_t(parts.size()));
        r.put(parts);
        return r;
    }
    /// Takes in a journal, as far as it goes; false if it has not even begun.
    bool read(std::vector<RecordBytes>& records) {
        if (records.empty() || !records[0].get(plan) || !get_all(records[0], top_nodes) ||
            !get_all(records[0], own_items) || !get_all(records[0], scattered) || !get_all(records[0], notes)) {
            return false;
        }
        for (std::size_t i = 1; i < records.size(); ++i) {
            std::uint32_t count = 0;
            std::vector<BuiltPart<A>> more;
            if (!records[i].get(count) || !get_all(records[i], more)) break;
            parts.insert(parts.end(), more.begin(), more.end());
            pages += count;
            ++groups;
        }
        return true;
    }

  private:
    template <class T>
    static bool get_all(RecordBytes& record, std::vector<T>& values) {
        std::uint64_t count = 0;
        if (!record.get(count)) return false;
        for (std::uint64_t i = 0; i < count; ++i) {
            T value{};
            if (!record.get(value)) return false;
            values.push_back(value);
        }
        return true;
    }
};

}  // namespace detail
}  // namespace farfield
