// Turk's PLY ("The PLY polygon file format", 1994), read here rather than by assimp 5.2, which drops face
// colors and believes the header's counts before it has seen the file's size.
#include <algorithm>
#include <array>
#include <bit>
#include <cstring>

#include "scenes/load/load_detail.hpp"

namespace farfield::scenes::detail {
namespace {

enum class Type { int8, uint8, int16, uint16, int32, uint32, float32, float64 };

constexpr std::size_t size_of(Type type) {
    constexpr std::size_t sizes[] = {1, 1, 2, 2, 4, 4, 4, 8};
    return sizes[static_cast<std::size_t>(type)];
}

std::optional<Type> type_named(std::string_view name) {
    constexpr std::string_view names[][2] = {{"char", "int8"},     {"uchar", "uint8"},   {"short", "int16"},
                                             {"ushort", "uint16"}, {"int", "int32"},     {"uint", "uint32"},
                                             {"float", "float32"}, {"double", "float64"}};
    for (std::size_t i = 0; i < 8; ++i) {
        if (name == names[i][0] || name == names[i][1]) return static_cast<Type>(i);
    }
    return std::nullopt;
}

struct Property {
    std::string_view name;
    Type type;
    std::optional<Type> count_type;  // of lists
};

struct Element {
    std::string_view name;
    std::uint64_t count;
    std::vector<Property> properties;

    int index_of(std::initializer_list<std::string_view> names) const {
        for (const std::string_view wanted : names) {
            for (std::size_t i = 0; i < properties.size(); ++i) {
                if (properties[i].name == wanted) return static_cast<int>(i);
            }
        }
        return -1;
    }
};

struct Header {
    enum class Format { ascii, little, big };
    Format format = Format::ascii;
    std::vector<Element> elements;
};

Property property_in(const Lines& lines, const std::vector<std::string_view>& w) {
    const bool list = w.size() == 5 && w[1] == "list";
    if (!list && w.size() != 3) lines.fail("a property needs a type and a name");
    const std::optional<Type> type = type_named(w[list ? 3 : 1]);
    const std::optional<Type> count_type = list ? type_named(w[2]) : std::nullopt;
    if (!type || (list && !count_type)) lines.fail("a property of unknown type");
    return {w.back(), *type, count_type};
}

Header read_header(Lines& lines) {
    std::string_view line;
    if (!lines.next(line)) throw std::runtime_error("is empty");
    if (trimmed(line) != "ply") lines.fail("does not begin with 'ply'");
    Header header;
    bool has_format = false;
    while (lines.next(line)) {
        const std::vector<std::string_view> w = words(line);
        if (w.empty() || w[0] == "comment" || w[0] == "obj_info") continue;
        if (w[0] == "end_header") {
            if (!has_format) lines.fail("the header names no format");
            return header;
        }
        if (w[0] == "format" && w.size() >= 2) {
            has_format = true;
            if (w[1] == "ascii") {
                header.format = Header::Format::ascii;
            } else if (w[1] == "binary_little_endian") {
                header.format = Header::Format::little;
            } else if (w[1] == "binary_big_endian") {
                header.format = Header::Format::big;
            } else {
                lines.fail("unknown format " + in_quotes(w[1]));
            }
        } else if (w[0] == "element" && w.size() == 3) {
            const std::optional<std::uint64_t> count = number<std::uint64_t>(w[2]);
            if (!count) lines.fail(in_quotes(w[2]) + " where a count should be");
            header.elements.push_back({w[1], *count, {}});
        } else if (w[0] == "property" && !header.elements.empty()) {
            header.elements.back().properties.push_back(property_in(lines, w));
        } else {
            lines.fail(in_quotes(trimmed(line)) + " in the header");
        }
    }
    throw std::runtime_error("ends within its header");
}

/// Values one after the other, whatever the format.
class Body {
  public:
    Body(std::string_view whole, std::string_view body, Header::Format format)
        : whole_(whole), at_(body), format_(format) {}

    std::size_t bytes_left() const { return at_.size(); }
    std::size_t least_bytes(Type type) const { return format_ == Header::Format::ascii ? 2 : size_of(type); }

    /// `wanted` is for the message, called only if there is one.
    template <class Wanted>
    double next(Type type, Wanted&& wanted) {
        if (format_ == Header::Format::ascii) return next_word(wanted);
        const std::size_t size = size_of(type);
        if (at_.size() < size) fail("ends within " + wanted());
        std::array<unsigned char, 8> bytes{};
        std::memcpy(bytes.data(), at_.data(), size);
        const bool little = format_ == Header::Format::little;
        if (little != (std::endian::native == std::endian::little)) {
            std::reverse(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size));
        }
        at_.remove_prefix(size);
        switch (type) {
            case Type::int8:
                return as<std::int8_t>(bytes);
            case Type::uint8:
                return as<std::uint8_t>(bytes);
            case Type::int16:
                return as<std::int16_t>(bytes);
            case Type::uint16:
                return as<std::uint16_t>(bytes);
            case Type::int32:
                return as<std::int32_t>(bytes);
            case Type::uint32:
                return as<std::uint32_t>(bytes);
            case Type::float32:
                return static_cast<double>(as<float>(bytes));
            case Type::float64:
                break;
        }
        return as<double>(bytes);
    }

    [[noreturn]] void fail(const std::string& reason) const {
        throw std::runtime_error("byte " + std::to_string(whole_.size() - at_.size()) + ": " + reason);
    }

  private:
    template <class T>
    static T as(const std::array<unsigned char, 8>& bytes) {
        T value;
        std::memcpy(&value, bytes.data(), sizeof value);
        return value;
    }

    template <class Wanted>
    double next_word(Wanted&& wanted) {
        while (!at_.empty() && is_space(at_.front())) at_.remove_prefix(1);
        if (at_.empty()) fail("ends within " + wanted());
        std::size_t end = 0;
        while (end < at_.size() && !is_space(at_[end])) ++end;
        const std::optional<double> value = number<double>(at_.substr(0, end));
        if (!value) fail(in_quotes(at_.substr(0, end)) + " in " + wanted());
        at_.remove_prefix(end);
        return *value;
    }

    std::string_view whole_;
    std::string_view at_;
    Header::Format format_;
};

/// Where the channels are, and what their types make of them.
struct ColorColumns {
    std::array<int, 3> columns;
    std::array<double, 3> scales{};

    explicit ColorColumns(const Element& element)
        : columns{element.index_of({"red", "r", "diffuse_red"}), element.index_of({"green", "g", "diffuse_green"}),
                  element.index_of({"blue", "b", "diffuse_blue"})} {
        for (std::size_t i = 0; i < 3; ++i) {
            if (!present()) return;
            const Type type = element.properties[static_cast<std::size_t>(columns[i])].type;
            scales[i] = type == Type::float32 || type == Type::float64 ? 1.0
                        : type == Type::uint16                         ? 1.0 / 65535
                                                                       : 1.0 / 255;
        }
    }
    bool present() const { return columns[0] >= 0 && columns[1] >= 0 && columns[2] >= 0; }
    Rgba8 color(const std::vector<double>& values) const {
        const auto channel = [&](std::size_t i) {
            return static_cast<float>(values[static_cast<std::size_t>(columns[i])] * scales[i]);
        };
        return to_rgba8({channel(0), channel(1), channel(2), 1.0f});
    }
};

/// One value a property; of the property `kept_list`, the list itself.
void read_row(Body& body, const Element& element, std::uint64_t row, int kept_list, std::vector<double>& values,
              std::vector<double>& list) {
    const auto wanted = [&] {
        return std::string(element.name) + ' ' + std::to_string(row) + " of " + std::to_string(element.count);
    };
    values.clear();
    for (std::size_t p = 0; p < element.properties.size(); ++p) {
        const Property& property = element.properties[p];
        if (!property.count_type) {
            values.push_back(body.next(property.type, wanted));
            continue;
        }
        values.push_back(0.0);
        const double length = body.next(*property.count_type, wanted);
        if (!(length >= 0) || length != std::floor(length) ||
            length > static_cast<double>((body.bytes_left() + 1) / body.least_bytes(property.type))) {
            body.fail("a list longer than the file in " + wanted());
        }
        for (auto left = static_cast<std::uint64_t>(length); left > 0; --left) {
            const double value = body.next(property.type, wanted);
            if (static_cast<int>(p) == kept_list) list.push_back(value);
        }
    }
}

struct Vertices {
    std::vector<glm::vec3> positions;
    std::vector<Rgba8> colors;
};

void read_vertices(Body& body, const Element& element, Vertices& vertices) {
    const int x = element.index_of({"x"}), y = element.index_of({"y"}), z = element.index_of({"z"});
    if (x < 0 || y < 0 || z < 0) throw std::runtime_error("vertices have no x, y, z");
    const ColorColumns colors(element);
    std::vector<double> values, unused;
    vertices.positions.reserve(static_cast<std::size_t>(element.count));
    for (std::uint64_t row = 0; row < element.count; ++row) {
        read_row(body, element, row, -1, values, unused);
        vertices.positions.push_back(finite(values[static_cast<std::size_t>(x)], values[static_cast<std::size_t>(y)],
                                            values[static_cast<std::size_t>(z)], "vertex",
                                            static_cast<std::size_t>(row)));
        if (colors.present()) vertices.colors.push_back(colors.color(values));
    }
}

void read_faces(Body& body, const Element& element, const Vertices& vertices, Triangles& triangles) {
    const int indices = element.index_of({"vertex_indices", "vertex_index"});
    if (indices < 0 || !element.properties[static_cast<std::size_t>(indices)].count_type) {
        throw std::runtime_error("faces have no list vertex_indices");
    }
    const ColorColumns colors(element);
    std::vector<double> values, polygon;
    for (std::uint64_t row = 0; row < element.count; ++row) {
        polygon.clear();
        read_row(body, element, row, indices, values, polygon);
        for (const double index : polygon) {
            if (!(index >= 0) || index >= static_cast<double>(vertices.positions.size())) {
                throw std::runtime_error("face " + std::to_string(row) + " names a vertex out of range (" +
                                         std::to_string(static_cast<long double>(index)) + " of " +
                                         std::to_string(vertices.positions.size()) + ")");
            }
        }
        for (std::size_t i = 2; i < polygon.size(); ++i) {
            VertexColoredTriangle& triangle = triangles.emplace_back();
            const std::array<double, 3> corners{polygon[0], polygon[i - 1], polygon[i]};
            for (std::size_t k = 0; k < 3; ++k) {
                const auto v = static_cast<std::size_t>(corners[k]);
                triangle.vertices[k] = vertices.positions[v];
                triangle.rgba[k] = vertices.colors.empty() ? uncolored : vertices.colors[v];
            }
            if (colors.present()) triangle.rgba.fill(colors.color(values));
        }
    }
}

}  // namespace

Triangles read_ply(std::string_view bytes) {
    Lines lines(bytes);
    const Header header = read_header(lines);
    Body body(bytes, lines.rest(), header.format);
    Vertices vertices;
    Triangles triangles;
    bool seen_vertices = false;
    for (const Element& element : header.elements) {
        std::uint64_t least = 0;
        for (const Property& p : element.properties) least += body.least_bytes(p.count_type.value_or(p.type));
        check_room(element.count, least, body.bytes_left() + 1, element.name);
        if (element.name == "vertex") {
            read_vertices(body, element, vertices);
            seen_vertices = true;
        } else if (element.name == "face") {
            if (!seen_vertices) throw std::runtime_error("faces come before vertices");
            read_faces(body, element, vertices, triangles);
        } else if (least > 0) {
            std::vector<double> values, unused;
            for (std::uint64_t row = 0; row < element.count; ++row) {
                read_row(body, element, row, -1, values, unused);
            }
        }
    }
    return triangles;
}

}  // namespace farfield::scenes::detail
