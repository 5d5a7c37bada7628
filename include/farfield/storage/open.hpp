// A hierarchy from a file or a buffer, used where it lies: nothing is parsed or copied, pages come in as frames touch
// them. Notes of the file (read_notes() in paging/file_notes.hpp) are no part of it: whoever saves it again gives them.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <utility>

#include "farfield/storage/checksum.hpp"
#include "farfield/storage/file_format.hpp"
#include "farfield/storage/mapped_file.hpp"
#include "farfield/storage/notes.hpp"
#include "farfield/storage/soundness.hpp"

namespace farfield {

struct OpenOptions {
    /// Whether to verify the sections' checksums, which reads the whole file once. The header's is always verified, and
    /// so is the structure: a damaged file that slips through may give a wrong picture and no more.
    bool verify_checksums = true;
};

namespace detail {

inline std::string tag_name(std::uint32_t tag) {
    std::string name = "0x";
    for (int shift = 28; shift >= 0; shift -= 4) name += "0123456789abcdef"[tag >> shift & 15];
    const char a = char(tag >> 24), b = char(tag >> 16 & 255);
    const auto is_letter = [](char c) { return c >= 'A' && c <= 'Z'; };
    if (is_letter(a) && is_letter(b)) name += std::string(" (") + a + b + ")";
    return name;
}

inline std::string wrong_tag(const char* policy, std::uint32_t expected, std::uint32_t found) {
    return std::string("was saved with another ") + policy + ": expected " + tag_name(expected) + ", found " +
           tag_name(found);
}

/// The reason to refuse the header; empty if it is one of this version.
inline std::string wrong_header(std::span<const std::byte> bytes, FileHeader& header) {
    if (bytes.empty()) return "is empty";
    const std::size_t compared = std::min(bytes.size(), file_magic.size());
    if (std::memcmp(bytes.data(), file_magic.data(), compared) != 0) return "is not a farfield hierarchy";
    std::memcpy(&header, bytes.data(), std::min(bytes.size(), sizeof header));
    if (bytes.size() >= 16) {
        if (header.byte_order == 0x04030201u) return "was saved on a machine of the other byte order";
        if (header.byte_order != file_byte_order) return "is damaged: its byte order is unknown";
        if (header.version != file_version) {
            return "has format version " + std::to_string(header.version) + ", this program reads version " +
                   std::to_string(file_version) + ": build and save it again";
        }
    }
    if (bytes.size() < sizeof header) {
        return "is truncated: it has " + std::to_string(bytes.size()) + " bytes, its header has " +
               std::to_string(sizeof header);
    }
    if (header.checksum != Xxh64::of(bytes.first(offsetof(FileHeader, checksum)))) {
        return "is damaged: the checksum of its header is wrong";
    }
    return header.header_bytes == sizeof header ? "" : "is damaged: its header has another size";
}

/// The reason to refuse what follows the hierarchy; empty if nothing does, or notes. Others are too long.
inline std::string wrong_rest(std::span<const std::byte> bytes, const FileHeader& header, Notes& notes) {
    if (header.file_bytes >= bytes.size()) return "";
    const auto rest = bytes.subspan(std::size_t(header.file_bytes));
    return may_be_notes(rest) ? wrong_notes(rest, notes) : "";
}

/// The reason to refuse the sections; empty if they lie in the file as save() lays them.
inline std::string wrong_sections(std::span<const std::byte> bytes, const FileHeader& header,
                                  const std::array<std::uint64_t, section_count>& record_bytes, bool checks_sums) {
    if (header.file_bytes != bytes.size()) {
        return std::string(header.file_bytes > bytes.size() ? "is truncated" : "is too long") + ": it has " +
               std::to_string(bytes.size()) + " bytes and should have " + std::to_string(header.file_bytes);
    }
    std::uint64_t end = sizeof header;
    for (std::size_t i = 0; i < section_count; ++i) {
        const SectionEntry& s = header.sections[i];
        const std::string name = std::string("section '") + section_names[i] + "'";
        const auto damaged = [&](const char* why) { return "is damaged: " + name + why; };
        if (s.record_bytes != record_bytes[i]) {
            return "was saved with other records: " + name + " has " + std::to_string(s.record_bytes) +
                   " bytes a record, expected " + std::to_string(record_bytes[i]);
        }
        if (s.offset != next_section(end)) return damaged(" lies in the wrong place");
        if (s.record_bytes == 0 && s.count != 0) return damaged(" should take no space");
        if (i <= std::size_t(Section::cost_options) && s.count != (record_bytes[i] != 0 ? 1 : 0)) {
            return damaged(" is not there exactly once");
        }
        if (s.count == 0) {
            if (s.checksum != Xxh64::of({})) return damaged(" is empty and its checksum is not");
            continue;
        }
        if (s.offset > bytes.size() || s.count > (bytes.size() - s.offset) / s.record_bytes) {
            return damaged(" reaches beyond the end");
        }
        const auto between = bytes.subspan(std::size_t(end), std::size_t(s.offset - end));
        if (std::any_of(between.begin(), between.end(), [](std::byte b) { return b != std::byte(0); })) {
            return damaged(" has something else before it");
        }
        if (checks_sums && s.checksum != Xxh64::of(bytes.subspan(std::size_t(s.offset), std::size_t(s.bytes())))) {
            return damaged(" does not have the checksum it was saved with");
        }
        end = s.offset + s.bytes();
    }
    return end == bytes.size() ? "" : "is damaged: something follows its last section";
}

template <class T>
std::span<const T> records_in(std::span<const std::byte> bytes, const SectionEntry& s) {
    static_assert(alignof(T) <= section_alignment && std::is_trivially_copyable_v<T>);
    if (s.count == 0) return {};
    return {reinterpret_cast<const T*>(bytes.data() + s.offset), std::size_t(s.count)};
}

/// Messages call the file `where`.
template <Storable H>
H open_bytes(const FileBytes& file, const std::filesystem::path& where, const OpenOptions& options) {
    using Partition_ = typename H::partition_type;
    using A = typename H::approximation_type;
    using C = typename H::cost_model_type;
    const auto refuse_if = [&](const std::string& why) {
        if (!why.empty()) refuse_file("open", where, why);
    };
    const auto refuse_tag_if = [&](const char* policy, std::uint32_t expected, std::uint32_t found) {
        if (expected != found) refuse_file("open", where, wrong_tag(policy, expected, found));
    };
    FileHeader header;
    refuse_if(wrong_header(file.bytes, header));
    refuse_tag_if("partition", Partition_::facts.file_tag, header.partition_tag);
    refuse_tag_if("approximation", A::facts.file_tag, header.approximation_tag);
    refuse_tag_if("cost model", C::file_tag, header.cost_tag);
    Notes notes;
    refuse_if(wrong_rest(file.bytes, header, notes));
    const auto hierarchy = notes.empty() ? file.bytes : file.bytes.first(std::size_t(header.file_bytes));
    refuse_if(wrong_sections(hierarchy, header, record_bytes<H>(), options.verify_checksums));

    const auto section = [&](Section s) -> const SectionEntry& { return header.sections[std::size_t(s)]; };
    Partition_ partition{};
    A approximation{};
    C cost{};
    const auto read = [&](Section s, auto& policy) {
        const SectionEntry& entry = section(s);
        return read_numbers(
            file.bytes.subspan(std::size_t(entry.count != 0 ? entry.offset : 0), std::size_t(entry.bytes())), policy);
    };
    if (!read(Section::partition_options, partition) ||
        !read(Section::approximation_options, static_cast<stored_approximation_of<A>&>(approximation)) ||
        !read(Section::cost_options, cost)) {
        refuse_file("open", where, "is damaged: an option is neither true nor false");
    }
    for (const char* why : {wrong_option(partition), wrong_option(approximation), wrong_option(cost)}) {
        if (why != nullptr) refuse_file("open", where, std::string("is damaged: ") + why);
    }
    const typename H::Arrays arrays{records_in<Node>(file.bytes, section(Section::nodes)),
                                    records_in<typename H::node_data>(file.bytes, section(Section::node_data)),
                                    records_in<typename H::stand_in_data>(file.bytes, section(Section::stand_ins)),
                                    records_in<typename H::pool_element>(file.bytes, section(Section::pool)),
                                    records_in<std::uint32_t>(file.bytes, section(Section::order)),
                                    {records_in<std::uint32_t>(file.bytes, section(Section::first_vertices)),
                                     records_in<glm::vec3>(file.bytes, section(Section::vertices)),
                                     records_in<Rgba8>(file.bytes, section(Section::colors))}};
    if (const char* why = unsound<H>(partition, approximation, header.facts, arrays)) {
        refuse_file("open", where, std::string("is damaged: ") + why);
    }
    return H(partition, approximation, cost, header.facts, arrays, file.memory);
}

}  // namespace detail

/// H is the SpatialHierarchy that was saved; its policies' options come from the file. Copies of the result share the
/// mapping, which goes with the last of them; save() may replace the file meanwhile, but do not change it in place or
/// cut it short. Viewers check that they are given the primitives it was built from.
///
/// Throws std::runtime_error, "farfield::open: FILE: reason", if anything is wrong with the file: everything is
/// checked, so that no file makes a frame read outside of its arrays.
template <Storable H>
H open(const std::filesystem::path& path, const OpenOptions& options = {}) {
    return detail::open_bytes<H>(detail::file_bytes(path), path, options);
}

/// Opens the bytes of such a file. They are used where they lie, unless they do not begin at a multiple of 64 bytes:
/// then they are copied. Where they are not, they must stay as they are as long as the hierarchy and its copies live;
/// `memory` may own them.
template <Storable H>
H open(std::span<const std::byte> bytes, const OpenOptions& options = {}, std::shared_ptr<const void> memory = {}) {
    if (reinterpret_cast<std::uintptr_t>(bytes.data()) % detail::section_alignment != 0) {
        return detail::open_bytes<H>(detail::aligned_copy(bytes), "memory", options);
    }
    return detail::open_bytes<H>({std::move(memory), bytes}, "memory", options);
}

}  // namespace farfield
