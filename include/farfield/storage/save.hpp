// A hierarchy into a file: see storage/file_format.hpp for what is in it, storage/open.hpp for the way back.
#pragma once

#include <array>
#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <system_error>
#include <utility>

#include "farfield/storage/checksum.hpp"
#include "farfield/storage/file_format.hpp"
#include "farfield/storage/mapped_file.hpp"
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
        // Else the name could reach the disk before the contents do.
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

}  // namespace detail

/// Writes beside `path` and renames, so that there is the old file or the whole new one, never a part; who has the old
/// one open keeps it. Equal hierarchies give equal files. Throws std::runtime_error that names the file and the reason;
/// nothing is left behind then.
template <class P, class A, class C>
requires Storable<SpatialHierarchy<P, A, C>>
void save(const SpatialHierarchy<P, A, C>& hierarchy, const std::filesystem::path& path) {
    using H = SpatialHierarchy<P, A, C>;
    using namespace detail;
    FileHeader header;
    header.partition_tag = P::facts.file_tag;
    header.approximation_tag = A::facts.file_tag;
    header.cost_tag = C::file_tag;
    header.facts = {.origin = hierarchy.origin(),
                    .primitive_count = hierarchy.primitive_count(),
                    .fingerprint = hierarchy.fingerprint(),
                    .report = hierarchy.report(),
                    .bounds = hierarchy.bounds(),
                    .root = hierarchy.root_cell(),
                    .work = hierarchy.whole_work(),
                    .root_has_stand_in = hierarchy.root_stand_in() != nullptr ? 1u : 0u};
    const typename H::MappedArrays arrays{hierarchy.nodes(),
                                          hierarchy.all_node_data(),
                                          hierarchy.stand_ins(),
                                          hierarchy.pool(),
                                          hierarchy.order(),
                                          hierarchy.fragments(),
                                          {}};
    if (const char* why =
            unsound<H>(hierarchy.partition_policy(), hierarchy.approximation_policy(), header.facts, arrays)) {
        refuse_file("save", path, std::string("the hierarchy cannot be stored: ") + why);
    }

    const auto partition = bytes_of(hierarchy.partition_policy()),
               approximation = bytes_of(hierarchy.approximation_policy()), cost = bytes_of(hierarchy.cost_policy());
    const auto stored = [](auto records) {
        using T = typename decltype(records)::element_type;
        return std::is_empty_v<T> ? std::span<const std::byte>() : std::as_bytes(records);
    };
    const std::array<std::span<const std::byte>, section_count> contents{partition,
                                                                         approximation,
                                                                         cost,
                                                                         stored(arrays.nodes),
                                                                         stored(arrays.data),
                                                                         stored(arrays.stand_ins),
                                                                         stored(arrays.pool),
                                                                         stored(arrays.order),
                                                                         stored(arrays.fragments.first_vertex),
                                                                         stored(arrays.fragments.vertices),
                                                                         stored(arrays.fragments.colors)};
    header.file_bytes = sizeof header;
    for (std::size_t i = 0; i < section_count; ++i) {
        const std::uint64_t one = record_bytes<H>()[i], offset = next_section(header.file_bytes);
        header.sections[i] = {offset, one == 0 ? 0 : contents[i].size() / one, one, Xxh64::of(contents[i])};
        if (!contents[i].empty()) header.file_bytes = offset + contents[i].size();
    }
    header.checksum = Xxh64::of(std::as_bytes(std::span(&header, 1)).first(offsetof(FileHeader, checksum)));

    ReplacingFile file(path);
    file.write(std::as_bytes(std::span(&header, 1)));
    std::uint64_t at = sizeof header;
    const std::array<std::byte, section_alignment> zeros{};
    for (std::size_t i = 0; i < section_count; ++i) {
        if (contents[i].empty()) continue;
        file.write(std::span(zeros).first(std::size_t(header.sections[i].offset - at)));
        file.write(contents[i]);
        at = header.sections[i].offset + contents[i].size();
    }
    file.replace_target();
}

}  // namespace farfield
