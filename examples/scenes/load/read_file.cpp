#include <zlib.h>

#include <algorithm>
#include <fstream>
#include <memory>

#include "scenes/load/load_detail.hpp"

namespace farfield::scenes::detail {
namespace {

/// A thousandth of it may be enough to unpack to it.
constexpr std::uint64_t most_unpacked = std::uint64_t{1} << 32;

std::string unpacked(const std::string& packed) {
    z_stream stream{};
    if (inflateInit2(&stream, 15 + 16) != Z_OK) throw std::bad_alloc();
    const std::unique_ptr<z_stream, int (*)(z_stream*)> ends(&stream, inflateEnd);
    std::string result, piece(std::size_t{1} << 18, '\0');
    const auto* at = reinterpret_cast<const unsigned char*>(packed.data());
    std::size_t left = packed.size();
    int status = Z_OK;
    while (true) {
        if (stream.avail_in == 0) {
            const std::size_t next = std::min<std::size_t>(left, std::size_t{1} << 30);
            stream.next_in = const_cast<unsigned char*>(at);  // zlib does not write there
            stream.avail_in = static_cast<uInt>(next);
            at += next;
            left -= next;
        }
        stream.next_out = reinterpret_cast<unsigned char*>(piece.data());
        stream.avail_out = static_cast<uInt>(piece.size());
        status = inflate(&stream, Z_NO_FLUSH);
        if (status != Z_OK && status != Z_STREAM_END) break;
        result.append(piece, 0, piece.size() - stream.avail_out);
        if (result.size() > most_unpacked) throw std::runtime_error("unpacks to more than 4 GiB");
        if (status != Z_STREAM_END) continue;
        // Several packed files one after the other are one; padding of zeros may follow.
        if (stream.avail_in + left < 2 || stream.next_in[0] != 0x1f) return result;
        inflateReset(&stream);
    }
    throw std::runtime_error(status == Z_BUF_ERROR ? "is packed by gzip and cut short"
                                                   : "is packed by gzip and damaged");
}

}  // namespace

std::string read_file(const std::filesystem::path& file) {
    std::error_code error;
    const std::filesystem::file_status status = std::filesystem::status(file, error);
    if (error || !std::filesystem::exists(status)) throw std::runtime_error("no such file");
    if (!std::filesystem::is_regular_file(status)) throw std::runtime_error("is not a regular file");
    const std::uintmax_t size = std::filesystem::file_size(file, error);
    if (error) throw std::runtime_error(error.message());
    std::ifstream in(file, std::ios::binary);
    std::string content(static_cast<std::size_t>(size), '\0');
    if (!in || !in.read(content.data(), static_cast<std::streamsize>(content.size()))) {
        throw std::runtime_error("cannot be read");
    }
    return content.compare(0, 3, "\x1f\x8b\x08") == 0 ? unpacked(content) : content;
}

}  // namespace farfield::scenes::detail
