// The Point Cloud Library's own format ("The PCD (Point Cloud Data) file format", versions 0.5 to 0.7, and the headers
// before them, which have COLUMNS for FIELDS and nothing about types).
#include <algorithm>
#include <bit>

#include "scenes/load/points.hpp"

namespace farfield::scenes::detail {
namespace {

struct Field {
    std::string name;
    std::uint64_t size = 4, count = 1;
    char type = 'F';           ///< F, I or U
    std::uint64_t offset = 0;  ///< in bytes, within a point's record
    std::uint64_t first = 0;   ///< of its values, within a point's line
};

struct Header {
    std::vector<Field> fields;
    std::uint64_t record_bytes = 0, values = 0;
    std::uint64_t points = 0;
    std::string data;
};

/// Reads lines up to the one that says what kind of data follows.
class HeaderReader {
  public:
    explicit HeaderReader(Lines& lines) : lines_(lines) {}

    Header read(std::uint64_t file_bytes) {
        std::string_view line;
        while (lines_.next(line)) {
            const auto w = words(line);
            if (w.empty() || w[0].front() == '#') continue;
            if (w[0] == "DATA" && w.size() > 1) {
                header_.data = std::string(w[1]);
                return completed(file_bytes);
            }
            entry(w);
        }
        throw std::runtime_error(header_.fields.empty() ? "is no PCD file: there is no line FIELDS"
                                                        : "ends within its header: there is no line DATA");
    }

  private:
    void entry(const std::vector<std::string_view>& w) {
        if (w[0] == "FIELDS" || w[0] == "COLUMNS") {
            for (std::size_t i = 1; i < w.size(); ++i) header_.fields.emplace_back().name = std::string(w[i]);
        } else if (w[0] == "SIZE") {
            each(w, [&](Field& field, std::string_view word) { field.size = count_in(word); });
        } else if (w[0] == "COUNT") {
            each(w, [&](Field& field, std::string_view word) { field.count = count_in(word); });
        } else if (w[0] == "TYPE") {
            each(w, [&](Field& field, std::string_view word) { field.type = word.front(); });
        } else if (w.size() == 2 && w[0] == "WIDTH") {
            width_ = count_in(w[1]);
        } else if (w.size() == 2 && w[0] == "HEIGHT") {
            height_ = count_in(w[1]);
        } else if (w.size() == 2 && w[0] == "POINTS") {
            points_ = count_in(w[1]);
        } else if (w[0] != "VERSION" && w[0] != "VIEWPOINT") {
            lines_.fail(in_quotes(w[0]) + " in the header");
        }
    }

    template <class F>
    void each(const std::vector<std::string_view>& w, F&& f) {
        if (w.size() != header_.fields.size() + 1) {
            lines_.fail(std::string(w[0]) + " has " + std::to_string(w.size() - 1) + " values for " +
                        std::to_string(header_.fields.size()) + " fields");
        }
        for (std::size_t i = 1; i < w.size(); ++i) f(header_.fields[i - 1], w[i]);
    }

    std::uint64_t count_in(std::string_view word) const {
        const std::optional<std::uint64_t> count = number<std::uint64_t>(word);
        if (!count) lines_.fail(in_quotes(word) + " where a count should be");
        return *count;
    }

    Header completed(std::uint64_t file_bytes) {
        if (header_.fields.empty()) throw std::runtime_error("is no PCD file: there is no line FIELDS");
        for (Field& field : header_.fields) {
            const bool is_float = field.type == 'F' && (field.size == 4 || field.size == 8);
            const bool is_whole =
                (field.type == 'I' || field.type == 'U') && field.size <= 8 && std::has_single_bit(field.size);
            if (!is_float && !is_whole) {
                throw std::runtime_error("the field " + in_quotes(field.name) + " is of the unknown type " +
                                         std::string(1, field.type) + " with " + std::to_string(field.size) + " bytes");
            }
            field.offset = header_.record_bytes;
            field.first = header_.values;
            check_room(field.count, 1, file_bytes, "values in the field " + in_quotes(field.name));
            header_.values += field.count;
            header_.record_bytes += field.count * field.size;
            check_room(header_.values, 1, file_bytes, "values in a point");
        }
        const std::uint64_t height = height_.value_or(1);
        if (width_ && height > 0 && *width_ > std::uint64_t(-1) / height) {
            throw std::runtime_error("claims more than 2^64 points");
        }
        if (!width_ && !points_) throw std::runtime_error("the header has neither POINTS nor WIDTH");
        header_.points = points_ ? *points_ : *width_ * height;
        if (width_ && *width_ * height != header_.points) {
            throw std::runtime_error("the header claims " + std::to_string(header_.points) + " POINTS, but WIDTH " +
                                     std::to_string(*width_) + " and HEIGHT " + std::to_string(height));
        }
        return std::move(header_);
    }

    Lines& lines_;
    Header header_;
    std::optional<std::uint64_t> width_, height_, points_;
};

/// The field of that name, if points have one value of it.
const Field* find(const Header& header, std::initializer_list<std::string_view> names) {
    for (const std::string_view name : names) {
        for (const Field& field : header.fields) {
            if (field.name == name && field.count == 1) return &field;
        }
    }
    return nullptr;
}

/// The number whose bytes, the lowest first, begin there.
std::uint64_t bits_at(const char* bytes, std::uint64_t size) {
    std::uint64_t bits = 0;
    for (std::uint64_t i = size; i > 0; --i) bits = bits << 8 | static_cast<unsigned char>(bytes[i - 1]);
    return bits;
}

double value_of(std::uint64_t bits, const Field& field) {
    if (field.type == 'F') {
        return field.size == 8 ? std::bit_cast<double>(bits)
                               : static_cast<double>(std::bit_cast<float>(static_cast<std::uint32_t>(bits)));
    }
    if (field.type == 'U') return static_cast<double>(bits);
    const auto unused = static_cast<int>(64 - 8 * field.size);
    return static_cast<double>(static_cast<std::int64_t>(bits << unused) >> unused);
}

// Points with all their values, in bytes or in text. A value comes as a number, and a packed color as its bits.

class BinaryValues {
  public:
    /// Record after record, or all values of each field together.
    BinaryValues(std::string_view bytes, const Header& header, bool by_field)
        : bytes_(bytes), points_(header.points), record_(header.record_bytes), by_field_(by_field) {}

    double number_of(std::uint64_t point, const Field& field) const { return value_of(bits(point, field), field); }
    std::uint32_t bits_of(std::uint64_t point, const Field& field) const {
        return static_cast<std::uint32_t>(bits(point, field));
    }

  private:
    std::uint64_t bits(std::uint64_t point, const Field& field) const {
        const std::uint64_t at =
            by_field_ ? field.offset * points_ + point * field.size : point * record_ + field.offset;
        return bits_at(bytes_.data() + at, field.size);
    }

    std::string_view bytes_;
    std::uint64_t points_, record_;
    bool by_field_;
};

class TextValues {
  public:
    TextValues(Lines& lines, const Header& header) : lines_(lines), header_(header) {}

    double number_of(std::uint64_t point, const Field& field) {
        const std::string_view word = word_of(point, field);
        const std::optional<double> value = number<double>(word);
        if (!value) lines_.fail(in_quotes(word) + " in the field " + in_quotes(field.name));
        return *value;
    }
    /// As a float that has these bits, or as a whole number, whatever TYPE says: some write that.
    std::uint32_t bits_of(std::uint64_t point, const Field& field) {
        const std::string_view word = word_of(point, field);
        if (const auto whole = number<std::int64_t>(word)) return static_cast<std::uint32_t>(*whole);
        const std::optional<float> value = number<float>(word);
        if (!value) lines_.fail(in_quotes(word) + " in the field " + in_quotes(field.name));
        return std::bit_cast<std::uint32_t>(*value);
    }

  private:
    std::string_view word_of(std::uint64_t point, const Field& field) {
        while (read_ <= point) {
            std::string_view line;
            if (!lines_.next(line)) {
                throw std::runtime_error("ends after " + std::to_string(read_) + " of " +
                                         std::to_string(header_.points) + " points");
            }
            words_.clear();
            split(line, words_);
            if (words_.empty() || words_[0].front() == '#') continue;
            if (words_.size() < header_.values) {
                lines_.fail("fewer than " + std::to_string(header_.values) + " values in a point");
            }
            ++read_;
        }
        return words_[static_cast<std::size_t>(field.first)];
    }

    Lines& lines_;
    const Header& header_;
    std::vector<std::string_view> words_;
    std::uint64_t read_ = 0;
};

/// Marc Lehmann's LZF: runs of bytes, and copies of what has been before, at most 8192 bytes back. It grows as it is
/// read, to 88 times what is packed at most.
std::string unpacked_lzf(std::string_view packed, std::uint64_t size) {
    std::string result;
    std::size_t at = 0;
    const auto next = [&] {
        if (at == packed.size()) throw std::runtime_error("its packed data are cut short");
        return static_cast<unsigned char>(packed[at++]);
    };
    while (at < packed.size()) {
        const std::size_t control = next();
        if (control < 32) {
            if (packed.size() - at < control + 1) throw std::runtime_error("its packed data are cut short");
            result.append(packed, at, control + 1);
            at += control + 1;
        } else {
            std::size_t length = (control >> 5) + 2;
            if (length == 9) length += next();
            const std::size_t back = ((control & 31) << 8 | next()) + 1;
            if (back > result.size()) throw std::runtime_error("its packed data are damaged");
            for (; length > 0; --length) result.push_back(result[result.size() - back]);
        }
        if (result.size() > size) break;
    }
    if (result.size() != size) throw std::runtime_error("its packed data are damaged: they have another length");
    return result;
}

/// Colors as PCL packs them: 0xaarrggbb. Opaque, since few write an alpha that means something.
Rgba8 packed_color(std::uint32_t bits) {
    const auto byte = [&](int shift) { return static_cast<std::uint8_t>(bits >> shift & 255); };
    return {byte(16), byte(8), byte(0), 255};
}

template <class Values>
Cloud cloud_of(const Header& header, Values&& values) {
    const Field* const position[] = {find(header, {"x"}), find(header, {"y"}), find(header, {"z"})};
    for (const Field* field : position) {
        if (field == nullptr) throw std::runtime_error("points have no fields x, y, z");
    }
    const Field* packed = find(header, {"rgb", "rgba"});
    if (packed != nullptr && packed->size != 4) packed = nullptr;
    const Field* const color[] = {find(header, {"r", "red"}), find(header, {"g", "green"}),
                                  find(header, {"b", "blue"})};
    const Field* const normal[] = {find(header, {"normal_x", "nx"}), find(header, {"normal_y", "ny"}),
                                   find(header, {"normal_z", "nz"})};
    const bool has_color = color[0] != nullptr && color[1] != nullptr && color[2] != nullptr;
    const bool has_normal = normal[0] != nullptr && normal[1] != nullptr && normal[2] != nullptr;
    const Field* const intensity = find(header, {"intensity", "intensities", "i"});
    const Field* const radius = find(header, {"radius"});
    Cloud cloud;
    std::vector<glm::vec3> colors;
    float greatest = 0;
    for (std::uint64_t i = 0; i < header.points; ++i) {
        const auto vector = [&](const Field* const fields[]) {
            return glm::dvec3(values.number_of(i, *fields[0]), values.number_of(i, *fields[1]),
                              values.number_of(i, *fields[2]));
        };
        cloud.positions.push_back(vector(position));
        if (packed != nullptr) {
            cloud.colors.push_back(packed_color(values.bits_of(i, *packed)));
        } else if (has_color) {
            colors.emplace_back(vector(color));
            greatest = std::max({greatest, colors.back().x, colors.back().y, colors.back().z});
        }
        if (has_normal) cloud.normals.emplace_back(vector(normal));
        if (intensity != nullptr) cloud.intensities.push_back(static_cast<float>(values.number_of(i, *intensity)));
        if (radius != nullptr) cloud.radii.push_back(static_cast<float>(values.number_of(i, *radius)));
    }
    // Fractions, or bytes; only floats are the former.
    const float scale = has_color && color[0]->type == 'F' && greatest <= 1.001f ? 1.0f : 1.0f / 255;
    for (const glm::vec3& c : colors) cloud.colors.push_back(to_rgba8({c * scale, 1.0f}));
    return cloud;
}

}  // namespace

Loaded read_pcd(std::string_view bytes, const LoadOptions& options) {
    Lines lines(bytes);
    const Header header = HeaderReader(lines).read(bytes.size());
    std::string_view body = lines.rest();
    if (header.points == 0) throw std::runtime_error("has no points");
    if (header.data == "ascii") {
        check_room(header.points, 2 * header.values, body.size() + 1, "points");
        return drawn(cloud_of(header, TextValues(lines, header)), options);
    }
    if (header.data == "binary") {
        check_room(header.points, header.record_bytes, body.size(), "points");
        return drawn(cloud_of(header, BinaryValues(body, header, false)), options);
    }
    if (header.data != "binary_compressed") lines.fail("unknown kind of data " + in_quotes(header.data));
    if (body.size() < 8) throw std::runtime_error("ends before its packed data");
    const std::uint64_t packed = bits_at(body.data(), 4), unpacked = bits_at(body.data() + 4, 4);
    body.remove_prefix(8);
    check_room(packed, 1, body.size(), "bytes of packed data");
    check_room(header.points, header.record_bytes, unpacked, "points");
    const std::string data = unpacked_lzf(body.substr(0, packed), unpacked);
    return drawn(cloud_of(header, BinaryValues(data, header, true)), options);
}

}  // namespace farfield::scenes::detail
