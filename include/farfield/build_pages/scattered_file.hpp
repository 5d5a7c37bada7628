// Primitives on their way into parts: a file with a place for each group of them, in which they come to lie in the
// order that they were read in.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <ios>
#include <span>
#include <string>
#include <vector>

#include "farfield/storage/mapped_file.hpp"

namespace farfield::detail {

/// Writes; the file stays until somebody removes it.
template <class P>
class ScatterWriter {
  public:
    /// `counts`: the number of primitives of each group. `buffer_bytes` for all of them together.
    ScatterWriter(const std::filesystem::path& path, std::span<const std::uint64_t> counts, std::size_t buffer_bytes)
        : path_(path), file_(path, std::ios::binary | std::ios::trunc), groups_(counts.size()) {
        if (!file_) refuse_file("build_pages", path_, "cannot be written");
        const std::size_t each =
            std::max<std::size_t>(buffer_bytes / std::max<std::size_t>(counts.size(), 1) / sizeof(P), 16);
        std::uint64_t at = 0;
        for (std::size_t g = 0; g < counts.size(); ++g) {
            groups_[g].next = at * sizeof(P);
            groups_[g].waiting.reserve(std::size_t(std::min<std::uint64_t>(each, counts[g])));
            at += counts[g];
        }
    }
    void add(std::size_t group, const P& primitive) {
        Group& g = groups_[group];
        g.waiting.push_back(primitive);
        if (g.waiting.size() == g.waiting.capacity()) flush(g);
    }
    /// Everything is in the file when it returns.
    void finish() {
        for (Group& g : groups_) flush(g);
        file_.close();
        if (!file_) refuse_file("build_pages", path_, "cannot be written: is the disk full?");
    }

  private:
    struct Group {
        std::uint64_t next = 0;  ///< byte in the file
        std::vector<P> waiting{};
    };
    void flush(Group& g) {
        if (g.waiting.empty()) return;
        const std::size_t bytes = g.waiting.size() * sizeof(P);
        file_.seekp(std::streamoff(g.next));
        file_.write(reinterpret_cast<const char*>(g.waiting.data()), std::streamsize(bytes));
        if (!file_) refuse_file("build_pages", path_, "cannot be written: is the disk full?");
        g.next += bytes;
        g.waiting.clear();
    }

    std::filesystem::path path_;
    std::ofstream file_;
    std::vector<Group> groups_;
};

/// Reads `count` primitives from the `first` on.
template <class P>
std::vector<P> read_scattered(const std::filesystem::path& path, std::uint64_t first, std::uint64_t count) {
    std::ifstream file(path, std::ios::binary);
    std::vector<P> primitives(std::size_t(count), P{});
    file.seekg(std::streamoff(first * sizeof(P)));
    file.read(reinterpret_cast<char*>(primitives.data()), std::streamsize(primitives.size() * sizeof(P)));
    if (!file) refuse_file("build_pages", path, "cannot be read");
    return primitives;
}

}  // namespace farfield::detail
