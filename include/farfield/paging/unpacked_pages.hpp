// A source of pages over a file whose pages are packed, which it unpacks as they are read (packed_format.hpp).
//
//     auto file = std::make_shared<FilePageSource>("packed.farfield");
//     auto source = std::make_shared<UnpackedPages<FilePageSource, ZstdPages>>(file, "packed.farfield");
//     auto pages = open_pages_of<H, P>(source, "packed.farfield");
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <exception>
#include <memory>
#include <mutex>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "farfield/fail.hpp"
#include "farfield/paging/packed_format.hpp"
#include "farfield/paging/page_source.hpp"

namespace farfield {
namespace detail {

[[noreturn]] inline void refuse_packed_file(const std::string& where, const std::string& why) {
    fail<std::runtime_error>("farfield::UnpackedPages: " + where + ": " + why);
}

/// Buffers that go from read to read, so that those who wait for one do not wait for memory too.
class SpareBuffers {
  public:
    std::vector<std::byte> taken() {
        const std::lock_guard lock(mutex_);
        if (spare_.empty()) return {};
        std::vector<std::byte> buffer = std::move(spare_.back());
        spare_.pop_back();
        return buffer;
    }
    void give_back(std::vector<std::byte> buffer) {
        const std::lock_guard lock(mutex_);
        spare_.push_back(std::move(buffer));
    }

  private:
    std::mutex mutex_;
    std::vector<std::vector<std::byte>> spare_;
};

}  // namespace detail

/// Models PageSource, of what was packed, and CancellablePageSource over one that does. It shares the source that it
/// reads from. A page that cannot be unpacked is read as zeros: whoever checks pages finds that it is none, and its
/// neighbors are read all the same. It can be moved, as long as nobody reads.
template <PageSource S, PageCodec C>
class UnpackedPages {
  public:
    /// Reads the file's header and the sizes of its pages, 4 bytes each. Throws std::runtime_error, which begins with
    /// `where`, if it cannot be read, holds no packed pages, is damaged, or was packed by another codec, whose name is
    /// given.
    UnpackedPages(std::shared_ptr<S> packed, const std::string& where, C codec = {})
        : packed_(std::move(packed)), where_(where), codec_(std::move(codec)) {
        const auto read = [&](std::uint64_t offset, std::span<std::byte> to) {
            const ReadResult result = packed_->read(offset, to);
            if (result.status != ReadStatus::done) {
                detail::refuse_packed_file(where_, result.message.empty() ? "cannot be read" : result.message);
            }
        };
        std::array<std::byte, sizeof header_> head{};
        const auto present = std::span(head).first(std::size_t(std::min<std::uint64_t>(head.size(), packed_->size())));
        read(0, present);
        if (const char* why = detail::wrong_packed_file(present, packed_->size(), header_)) {
            detail::refuse_packed_file(where_, why);
        }
        if (header_.codec != C::file_tag) {
            detail::refuse_packed_file(where_, "was packed by '" + detail::codec_of_packed_file(head) +
                                                   "', and is opened with '" + C::name + "'");
        }
        // What is behind the pages lies at the file's end.
        const std::uint64_t end_of_pages = packed_->size() - header_.bytes_behind_pages();
        std::vector<std::uint32_t> sizes(header_.page_count + std::size_t(2));
        read(end_of_pages, std::as_writable_bytes(std::span(sizes)));
        std::uint64_t checksum = 0;
        std::memcpy(&checksum, sizes.data() + header_.page_count, sizeof checksum);
        sizes.resize(header_.page_count);
        if (checksum != detail::Xxh64::of(std::as_bytes(std::span(sizes)))) {
            detail::refuse_packed_file(where_, "is damaged: the checksum of its pages' sizes is wrong");
        }
        places_.reserve(sizes.size() + 1);
        places_.push_back(header_.first_stored_page());
        for (const std::uint32_t size : sizes) {
            if (size == 0 || size > header_.page_bytes) {
                detail::refuse_packed_file(where_, "is damaged: a page has a size that none can have");
            }
            places_.push_back(places_.back() + size);
        }
        if (places_.back() != end_of_pages) {
            detail::refuse_packed_file(where_, "is damaged: its pages' sizes do not add up");
        }
    }

    std::uint64_t size() const noexcept { return header_.unpacked_bytes + header_.note_bytes; }
    ReadMerging merging() const noexcept { return std::as_const(*packed_).merging(); }
    /// That the sizes take, and buffers for as many reads as are made at once.
    std::uint64_t memory_bytes() const noexcept {
        const ReadMerging m = merging();
        return places_.size() * sizeof(std::uint64_t) +
               m.most_reads_at_once * std::max<std::uint64_t>(m.largest_read, header_.page_bytes);
    }
    /// How many bytes a page takes in the file.
    std::uint32_t stored_bytes(std::uint32_t page) const { return std::uint32_t(places_[page + 1] - places_[page]); }

    ReadResult read(std::uint64_t offset, std::span<std::byte> bytes) noexcept {
        if (!detail::lies_within(size(), offset, bytes.size())) {
            return detail::beyond_the_end(where_, size(), offset, bytes.size());
        }
        if (offset < header_.first_page && !bytes.empty()) {
            const auto in_head =
                bytes.first(std::size_t(std::min<std::uint64_t>(bytes.size(), header_.first_page - offset)));
            const ReadResult result = packed_->read(sizeof header_ + offset, in_head);
            if (result.status != ReadStatus::done) return result;
            offset += in_head.size();
            bytes = bytes.subspan(in_head.size());
        }
        if (offset + bytes.size() > header_.unpacked_bytes) {
            const auto in_notes = bytes.last(
                std::size_t(std::min<std::uint64_t>(bytes.size(), offset + bytes.size() - header_.unpacked_bytes)));
            const std::uint64_t from_end = size() - (offset + bytes.size() - in_notes.size());
            const ReadResult result = packed_->read(packed_->size() - from_end, in_notes);
            if (result.status != ReadStatus::done) return result;
            bytes = bytes.first(bytes.size() - in_notes.size());
        }
        if (bytes.empty()) return {};
        ReadResult result;
        detail::guarded<std::exception>(
            [&] { result = read_pages(offset - header_.first_page, bytes); },
            [&] {
                result = not_read(ReadStatus::unavailable, {where_, ": there is no memory to unpack its pages"});
            });
        return result;
    }
    void cancel() noexcept requires CancellablePageSource<S> { packed_->cancel(); }

  private:
    /// `offset` from the first page's begin.
    ReadResult read_pages(std::uint64_t offset, std::span<std::byte> to) {
        const std::uint64_t page_bytes = header_.page_bytes, end = offset + to.size();
        const std::uint64_t first = offset / page_bytes, last = (end - 1) / page_bytes;
        std::vector<std::byte> stored = buffers_->taken();
        stored.resize(std::size_t(places_[last + 1] - places_[first]));
        const ReadResult result = packed_->read(places_[first], stored);
        for (std::uint64_t p = first; p <= last && result.status == ReadStatus::done; ++p) {
            const auto from = std::span<const std::byte>(stored).subspan(std::size_t(places_[p] - places_[first]),
                                                                         stored_bytes(std::uint32_t(p)));
            const std::uint64_t begin = p * page_bytes, wanted_begin = std::max(begin, offset),
                                wanted_end = std::min(begin + page_bytes, end);
            const auto wanted = to.subspan(std::size_t(wanted_begin - offset), std::size_t(wanted_end - wanted_begin));
            if (wanted.size() == page_bytes) {
                unpack(from, wanted);
                continue;
            }
            std::vector<std::byte> whole = buffers_->taken();
            whole.resize(std::size_t(page_bytes));
            unpack(from, whole);
            std::copy_n(whole.begin() + std::ptrdiff_t(wanted_begin - begin), wanted.size(), wanted.begin());
            buffers_->give_back(std::move(whole));
        }
        buffers_->give_back(std::move(stored));
        return result;
    }
    void unpack(std::span<const std::byte> from, std::span<std::byte> to) const {
        if (from.size() == to.size()) {
            std::memcpy(to.data(), from.data(), to.size());
        } else if (!codec_.unpack(from, to)) {
            std::fill(to.begin(), to.end(), std::byte(0));
        }
    }

    std::shared_ptr<S> packed_;
    std::string where_;
    C codec_;
    detail::PackedFileHeader header_;
    std::vector<std::uint64_t> places_;  ///< of pages in the file, and where the last one ends
    std::unique_ptr<detail::SpareBuffers> buffers_ = std::make_unique<detail::SpareBuffers>();
};

/// Whether what a source holds was packed by this codec: for programs that know several. A plain file of pages was not.
template <PageCodec C, PageSource S>
bool holds_pages_packed_by(S& source) {
    detail::PackedFileHeader header;
    if (source.size() < sizeof header) return false;
    return source.read(0, std::as_writable_bytes(std::span(&header, 1))).status == ReadStatus::done &&
           header.magic == detail::packed_file_magic && header.codec == C::file_tag;
}

}  // namespace farfield
