// What one of several builds outside of memory leaves for whoever joins them: its pages, and what cells above are made
// of.
#pragma once

#include "farfield/settings.hpp"

#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <memory>
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

/// A file that is written in place, and stays when something goes wrong: a build goes on with it.
class FileInPlace {
  public:
    FileInPlace(const std::filesystem::path& path, bool is_new) : path_(path) {
        file_ = std::fopen(path.string().c_str(), is_new ? "w+b" : "r+b");
        if (file_ == nullptr) refuse_file("build_pages", path_, "cannot be opened: " + system_message(errno));
    }
    ~FileInPlace() {
        if (file_ != nullptr) std::fclose(file_);
    }
    FileInPlace(const FileInPlace&) = delete;
    FileInPlace& operator=(const FileInPlace&) = delete;

    /// Nothing of it is left in this process: a kill right afterwards loses none of it.
    void write_at(std::uint64_t offset, std::span<const std::byte> bytes) {
        seek(offset);
        const bool is_written = std::fwrite(bytes.data(), 1, bytes.size(), file_) == bytes.size();
        if (!is_written || std::fflush(file_) != 0) refuse_to_write();
    }
    void read_at(std::uint64_t offset, std::span<std::byte> bytes) {
        seek(offset);
        if (std::fread(bytes.data(), 1, bytes.size(), file_) != bytes.size()) {
            refuse_file("build_pages", path_, "cannot be read, or is shorter than it was");
        }
    }
    /// On the disk.
    void sync() {
        if (!BuildJournal::sync_file(file_)) refuse_to_write();
    }

  private:
    void seek(std::uint64_t offset) {
#if FARFIELD_MAPS_FILES
        const bool good = ::fseeko(file_, ::off_t(offset), SEEK_SET) == 0;
#else
        const bool good = std::fseek(file_, long(offset), SEEK_SET) == 0;
#endif
        if (!good) refuse_to_write();
    }
    [[noreturn]] void refuse_to_write() {
        refuse_file("build_pages", path_, "cannot be written: " + system_message(errno));
    }
    std::filesystem::path path_;
    std::FILE* file_ = nullptr;
};

/// What the journal of a share tells.
template <class A, class P>
struct ShareRecord {
    SharedPlan plan;
    std::vector<TopNode> top_nodes;
    std::vector<P> own_items;  ///< of cells above parts, depth first
    std::vector<BuiltPart<A>> parts;
    std::uint32_t groups = 0;  ///< that have been built
    std::uint32_t pages = 0;   ///< that they take

    static RecordBytes plan_record(const SharedPlan& plan, std::span<const TopNode> nodes,
                                   std::span<const P> own_items) {
        RecordBytes r;
        r.put(plan);
        r.put(std::uint64_t(nodes.size()));
        r.put(nodes);
        r.put(std::uint64_t(own_items.size()));
        r.put(own_items);
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
            !get_all(records[0], own_items)) {
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
