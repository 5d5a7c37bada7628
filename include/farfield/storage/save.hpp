// Writes a hierarchy into a file or a buffer. storage/file_format.hpp says what is in it; storage/open.hpp reads it.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <span>
#include <stdexcept>
#include <string>
#include <system_error>
#include <type_traits>
#include <utility>
#include <vector>

#include "farfield/fail.hpp"
#include "farfield/storage/checksum.hpp"
#include "farfield/storage/file_format.hpp"
#include "farfield/storage/mapped_file.hpp"
#include "farfield/storage/notes.hpp"
#include "farfield/storage/soundness.hpp"

namespace farfield {
namespace detail {

/// A file that becomes `target` when all of it is on the disk, and is removed if that never happens.
class ReplacingFile {
  public:
    explicit ReplacingFile(const std::filesystem::path& target) : target_(target) {
        // Somebody else may be saving to the same place, or have been stopped while doing so: their file is left alone.
        for (int attempt = 0; attempt < 100 && file_ == nullptr; ++attempt) {
            temporary_ = target;
            temporary_ += ".";
            temporary_ += std::to_string(attempt);
            temporary_ += ".part";
            file_ = std::fopen(temporary_.string().c_str(), "wbx");
            if (file_ == nullptr && errno != EEXIST) fail("cannot create " + temporary_.filename().string());
        }
        if (file_ == nullptr) fail("there are 100 unfinished files beside it");
    }
    ~ReplacingFile() {
        if (file_ != nullptr) std::fclose(file_);
        if (!is_done_) {
            std::error_code ignored;
            std::filesystem::remove(temporary_, ignored);
        }
    }
    ReplacingFile(const ReplacingFile&) = delete;
    ReplacingFile& operator=(const ReplacingFile&) = delete;

    void write(std::span<const std::byte> bytes) {
        if (!bytes.empty() && std::fwrite(bytes.data(), 1, bytes.size(), file_) != bytes.size()) fail("cannot write");
    }

    void replace_target() {
        bool written = std::fflush(file_) == 0;
#if FARFIELD_MAPS_FILES
        // Without this the name could reach the disk before the contents do.
        written = written && ::fsync(::fileno(file_)) == 0;
#endif
        if (!written) fail("cannot write");
        if (std::fclose(std::exchange(file_, nullptr)) != 0) fail("cannot write");
        std::error_code error;
        std::filesystem::rename(temporary_, target_, error);
        if (error) refuse_file("save", target_, "cannot be replaced: " + error.message());
        is_done_ = true;
    }

  private:
    [[noreturn]] void fail(const std::string& what) {
        const int error = errno;
        refuse_file("save", target_, what + ": " + system_message(error));
    }

    std::filesystem::path target_, temporary_;
    std::FILE* file_ = nullptr;
    bool is_done_ = false;
};

/// The bytes that save() writes: a header and sections, which are the hierarchy's own arrays, and notes. Throws
/// std::runtime_error that names `where` if the hierarchy cannot be stored.
template <Storable H>
class FileContents {
  public:
    FileContents(const H& hierarchy, const Notes& notes, const std::filesystem::path& where)
        : partition_(bytes_of(hierarchy.partition_policy())),
          approximation_(
              bytes_of<stored_approximation_of<typename H::approximation_type>>(hierarchy.approximation_policy())),
          cost_(bytes_of(hierarchy.cost_policy())),
          notes_(bytes_of_notes(notes)) {
        const auto& arrays = hierarchy.arrays();
        if (const char* why =
                unsound<H>(hierarchy.partition_policy(), hierarchy.approximation_policy(), hierarchy.facts(), arrays)) {
            refuse_file("save", where, std::string("the hierarchy cannot be stored: ") + why);
        }
        header_.partition_tag = H::partition_type::facts.file_tag;
        header_.approximation_tag = H::approximation_type::facts.file_tag;
        header_.cost_tag = H::cost_model_type::file_tag;
        header_.facts = hierarchy.facts();
        sections_ = {partition_,
                     approximation_,
                     cost_,
                     stored(arrays.nodes),
                     stored(arrays.node_data),
                     stored(arrays.stand_ins),
                     stored(arrays.pool),
                     stored(arrays.order),
                     stored(arrays.fragments.first_vertex),
                     stored(arrays.fragments.vertices),
                     stored(arrays.fragments.colors)};
        header_.file_bytes = sizeof header_;
        for (std::size_t i = 0; i < section_count; ++i) {
            const std::uint64_t one = record_bytes<H>()[i], offset = next_section(header_.file_bytes);
            header_.sections[i] = {offset, one == 0 ? 0 : sections_[i].size() / one, one, Xxh64::of(sections_[i])};
            if (!sections_[i].empty()) header_.file_bytes = offset + sections_[i].size();
        }
        header_.checksum = Xxh64::of(std::as_bytes(std::span(&header_, 1)).first(offsetof(FileHeader, checksum)));
    }

    std::size_t size() const { return std::size_t(header_.file_bytes) + notes_.size(); }

    /// Calls write(bytes) with all parts of the file, in order.
    template <class Write>
    void write(Write&& write) const {
        write(std::as_bytes(std::span(&header_, 1)));
        std::uint64_t at = sizeof header_;
        const std::array<std::byte, section_alignment> zeros{};
        for (std::size_t i = 0; i < section_count; ++i) {
            if (sections_[i].empty()) continue;
            write(std::span<const std::byte>(zeros).first(std::size_t(header_.sections[i].offset - at)));
            write(sections_[i]);
            at = header_.sections[i].offset + sections_[i].size();
        }
        if (!notes_.empty()) write(std::span<const std::byte>(notes_));
    }

  private:
    template <class T>
    static std::span<const std::byte> stored(std::span<const T> records) {
        return std::is_empty_v<T> ? std::span<const std::byte>() : std::as_bytes(records);
    }

    std::vector<std::byte> partition_, approximation_, cost_, notes_;
    FileHeader header_;
    std::array<std::span<const std::byte>, section_count> sections_;
};

}  // namespace detail

/// Writes beside `path` and renames, so that there is the old file or the whole new one, never a part. Programs that
/// have the old one open keep it. Equal hierarchies and notes give equal files. Throws std::runtime_error that names
/// the file and the reason; nothing is left behind then. Throws std::invalid_argument where notes are longer than
/// 16 MiB together, or more than 4096.
template <Storable H>
void save(const H& hierarchy, const std::filesystem::path& path, const Notes& notes = {}) {
    const detail::FileContents<H> contents(hierarchy, notes, path);
    detail::ReplacingFile file(path);
    contents.write([&](std::span<const std::byte> bytes) { file.write(bytes); });
    file.replace_target();
}

/// The number of bytes that save() writes.
template <Storable H>
std::size_t saved_size(const H& hierarchy, const Notes& notes = {}) {
    return detail::FileContents<H>(hierarchy, notes, "memory").size();
}

/// Writes the bytes of the file to memory. Throws std::invalid_argument unless that has saved_size(hierarchy, notes)
/// bytes.
template <Storable H>
void save(const H& hierarchy, std::span<std::byte> memory, const Notes& notes = {}) {
    const detail::FileContents<H> contents(hierarchy, notes, "memory");
    if (memory.size() != contents.size()) {
        detail::fail<std::invalid_argument>("farfield::save: the hierarchy takes " + std::to_string(contents.size()) +
                                            " bytes and is given " + std::to_string(memory.size()));
    }
    std::byte* to = memory.data();
    contents.write([&](std::span<const std::byte> bytes) { to = std::copy(bytes.begin(), bytes.end(), to); });
}

}  // namespace farfield
