// What of a build outside of memory is on the disk already, so that a build that was stopped, by whatever, goes on.
//
// Each record is written after all that it tells of. One that is not whole was being written, and ends the journal.
// What a record tells of may be missing nevertheless, where the machine itself went down: whoever reads it looks.
#pragma once

#include "farfield/settings.hpp"

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <ios>
#include <iterator>
#include <span>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "farfield/storage/checksum.hpp"
#include "farfield/storage/mapped_file.hpp"

namespace farfield::detail {

/// Bytes of records that are copied as they lie.
class RecordBytes {
  public:
    template <class T>
    void put(const T& value) {
        put(std::span<const T>(&value, 1));
    }
    template <class T>
    void put(std::span<const T> values) {
        static_assert(std::is_trivially_copyable_v<T>);
        const auto* bytes = reinterpret_cast<const std::byte*>(values.data());
        bytes_.insert(bytes_.end(), bytes, bytes + values.size_bytes());
    }
    /// In the same order; false if there is nothing more.
    template <class T>
    bool get(T& value) {
        if (bytes_.size() - at_ < sizeof value) return false;
        std::memcpy(&value, bytes_.data() + at_, sizeof value);
        at_ += sizeof value;
        return true;
    }
    std::span<const std::byte> bytes() const { return bytes_; }
    bool is_at_end() const { return at_ == bytes_.size(); }

    RecordBytes() = default;
    explicit RecordBytes(std::vector<std::byte> bytes) : bytes_(std::move(bytes)) {}

  private:
    std::vector<std::byte> bytes_;
    std::size_t at_ = 0;
};

class BuildJournal {
  public:
    /// Goes on with the journal of the build that `identity` names, or begins one.
    BuildJournal(const std::filesystem::path& path, std::uint64_t identity) : path_(path), identity_(identity) {
        std::error_code error;
        const std::uintmax_t whole = read(&identity), size = std::filesystem::file_size(path, error);
        if (!error && whole < size) std::filesystem::resize_file(path, whole);
    }
    /// Looks at one, of whatever build.
    explicit BuildJournal(const std::filesystem::path& path) : path_(path) { read(nullptr); }
    std::vector<RecordBytes>& records() { return records_; }

    void append(const RecordBytes& record) {
        std::FILE* const file = std::fopen(path_.string().c_str(), "ab");
        if (file == nullptr) refuse_file("build_pages", path_, "cannot be written: " + system_message(errno));
        const Head head{identity_, record.bytes().size(), Xxh64::of(record.bytes())};
        bool is_written = std::fwrite(&head, sizeof head, 1, file) == 1 &&
                          std::fwrite(record.bytes().data(), 1, record.bytes().size(), file) == record.bytes().size();
        is_written = std::fclose(file) == 0 && is_written;
        if (!is_written) refuse_file("build_pages", path_, "cannot be written: " + system_message(errno));
    }

    /// Everything that was written is on the disk when it returns.
    static bool sync_file(std::FILE* file) {
        if (std::fflush(file) != 0) return false;
#if FARFIELD_MAPS_FILES
        return ::fsync(::fileno(file)) == 0;
#else
        return true;
#endif
    }

  private:
    struct Head {
        std::uint64_t identity = 0, bytes = 0, checksum = 0;
    };

    /// Returns where the last whole record ends.
    std::uintmax_t read(const std::uint64_t* identity) {
        std::ifstream in(path_, std::ios::binary);
        const std::vector<char> all{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
        in.close();
        const auto bytes = std::as_bytes(std::span(all));
        std::size_t whole = 0;
        while (true) {
            Head head;
            if (bytes.size() - whole < sizeof head) break;
            std::memcpy(&head, bytes.data() + whole, sizeof head);
            if (head.bytes > bytes.size() - whole - sizeof head) break;
            const auto contents = bytes.subspan(whole + sizeof head, std::size_t(head.bytes));
            if ((identity != nullptr && head.identity != *identity) || head.checksum != Xxh64::of(contents)) break;
            records_.emplace_back(std::vector<std::byte>(contents.begin(), contents.end()));
            whole += sizeof head + contents.size();
        }
        return whole;
    }

    std::filesystem::path path_;
    std::uint64_t identity_ = 0;
    std::vector<RecordBytes> records_;
};

}  // namespace farfield::detail
