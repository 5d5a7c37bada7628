// Turk's PLY ("The PLY polygon file format", 1994), read here rather than by assimp 5.2, which drops face
// colors and believes the header's counts before it has seen the file's size.
#include <algorithm>
#include <array>
#include <bit>
#include <cstring>

#include "scenes/load/load_detail.hpp"
#include "scenes/load/points.hpp"
#include "scenes/load/polygon.hpp"

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

/// A color as written, until it is known whether the numbers of its kind go to 1 or to 255.
using RawColor = std::array<float, 3>;

/// Where the channels are. Whole numbers have the range of their type: 255, or 65535 for 16 bits without a sign; the
/// format has no other rule, and signed or longer types hold bytes where they occur at all. Others go to 1, or to 255
/// if any of the element's does not keep to that.
class ColorColumns {
  public:
    explicit ColorColumns(const Element& element)
        : columns_{element.index_of({"red", "r", "diffuse_red"}), element.index_of({"green", "g", "diffuse_green"}),
                   element.index_of({"blue", "b", "diffuse_blue"})} {
        for (const int column : columns_) {
            if (column < 0 || element.properties[static_cast<std::size_t>(column)].count_type) return;
        }
        present_ = true;
        const Type type = element.properties[static_cast<std::size_t>(columns_[0])].type;
        fractions_ = type == Type::float32 || type == Type::float64;
        scale_ = fractions_ ? 1.0f : type == Type::uint16 ? 1.0f / 65535 : 1.0f / 255;
    }

    bool present() const { return present_; }

    RawColor color(const std::vector<double>& values) {
        RawColor result;
        for (std::size_t i = 0; i < 3; ++i) {
            result[i] = static_cast<float>(values[static_cast<std::size_t>(columns_[i])]);
            // The largest of a rounding above 1 are fractions still.
            if (fractions_ && result[i] > 1.001f) scale_ = 1.0f / 255;
        }
        return result;
    }

    /// After the last color has been read.
    Rgba8 resolved(const RawColor& color) const {
        return to_rgba8({color[0] * scale_, color[1] * scale_, color[2] * scale_, 1.0f});
    }

  private:
    std::array<int, 3> columns_;
    bool present_ = false, fractions_ = false;
    float scale_ = 1.0f;
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

/// Where the coordinates are. Throws if there are none.
class PositionColumns {
  public:
    explicit PositionColumns(const Element& element)
        : x_(element.index_of({"x"})), y_(element.index_of({"y"})), z_(element.index_of({"z"})) {
        if (x_ < 0 || y_ < 0 || z_ < 0) throw std::runtime_error("vertices have no x, y, z");
    }

    glm::dvec3 of(const std::vector<double>& values) const {
        return {values[static_cast<std::size_t>(x_)], values[static_cast<std::size_t>(y_)],
                values[static_cast<std::size_t>(z_)]};
    }

  private:
    int x_, y_, z_;
};

struct Vertices {
    std::vector<glm::dvec3> positions;
    std::vector<Rgba8> colors;  // empty if there are none
};

void read_vertices(Body& body, const Element& element, Vertices& vertices) {
    const PositionColumns position(element);
    ColorColumns columns(element);
    std::vector<double> values, unused;
    std::vector<RawColor> colors;
    vertices.positions.reserve(static_cast<std::size_t>(element.count));
    for (std::uint64_t row = 0; row < element.count; ++row) {
        read_row(body, element, row, -1, values, unused);
        vertices.positions.push_back(finite(position.of(values), "vertex", static_cast<std::size_t>(row)));
        if (columns.present()) colors.push_back(columns.color(values));
    }
    for (const RawColor& color : colors) vertices.colors.push_back(columns.resolved(color));
}

/// Vertices that no element makes anything of.
void read_points(Body& body, const Element& element, Cloud& cloud) {
    const PositionColumns position(element);
    ColorColumns columns(element);
    const int nx = element.index_of({"nx", "normal_x"}), ny = element.index_of({"ny", "normal_y"}),
              nz = element.index_of({"nz", "normal_z"});
    const int radius = element.index_of({"radius"}),
              intensity = element.index_of({"intensity", "scalar_intensity", "scalar_Intensity", "reflectance"});
    const auto at = [](const std::vector<double>& values, int column) {
        return static_cast<float>(values[static_cast<std::size_t>(column)]);
    };
    std::vector<double> values, unused;
    std::vector<RawColor> colors;
    for (std::uint64_t row = 0; row < element.count; ++row) {
        read_row(body, element, row, -1, values, unused);
        cloud.positions.push_back(position.of(values));
        if (columns.present()) colors.push_back(columns.color(values));
        if (nx >= 0 && ny >= 0 && nz >= 0) cloud.normals.push_back({at(values, nx), at(values, ny), at(values, nz)});
        if (radius >= 0) cloud.radii.push_back(at(values, radius));
        if (intensity >= 0) cloud.intensities.push_back(at(values, intensity));
    }
    for (const RawColor& color : colors) cloud.colors.push_back(columns.resolved(color));
    if (element.index_of({"f_dc_0"}) >= 0) cloud.notes.push_back("Gaussian splats are drawn as plain points");
}

/// What a list of vertices stands for.
enum class Shape { polygon, strip, fan };

/// The list that names the vertices: as most call it, or the only list of whole numbers.
int vertex_list(const Element& element) {
    const int named = element.index_of({"vertex_indices", "vertex_index", "vertex_indexes", "vertices", "indices"});
    if (named >= 0 && element.properties[static_cast<std::size_t>(named)].count_type) return named;
    int only = -1;
    for (std::size_t p = 0; p < element.properties.size(); ++p) {
        const Property& property = element.properties[p];
        if (!property.count_type || property.type == Type::float32 || property.type == Type::float64) continue;
        if (only >= 0) return -1;
        only = static_cast<int>(p);
    }
    return only;
}

std::optional<Shape> shape_of(const Element& element) {
    const std::string_view name = element.name;
    if (name == "face" || name == "faces" || name == "polygon" || name == "triangle") return Shape::polygon;
    if (name == "tristrips" || name == "tristrip" || name == "strip" || name == "strips") return Shape::strip;
    if (name == "trifans" || name == "trifan" || name == "fan" || name == "fans") return Shape::fan;
    return std::nullopt;
}

class FaceReader {
  public:
    FaceReader(const Vertices& vertices, std::vector<MeshTriangle>& triangles)
        : vertices_(vertices), triangles_(triangles) {}

    void read(Body& body, const Element& element, Shape shape) {
        const int list = vertex_list(element);
        if (list < 0) throw std::runtime_error(std::string(element.name) + "s have no list vertex_indices");
        ColorColumns columns(element);
        std::vector<double> values;
        std::vector<RawColor> colors;
        const std::size_t first = triangles_.size();
        for (std::uint64_t row = 0; row < element.count; ++row) {
            list_.clear();
            read_row(body, element, row, list, values, list_);
            switch (shape) {
                case Shape::polygon:
                    polygon(element, row);
                    break;
                case Shape::strip:
                    strips(element, row);
                    break;
                case Shape::fan:
                    fans(element, row);
                    break;
            }
            if (!columns.present()) continue;
            colors.resize(triangles_.size() - first, columns.color(values));
        }
        for (std::size_t i = 0; i < colors.size(); ++i) triangles_[first + i].colors.fill(columns.resolved(colors[i]));
    }

  private:
    std::uint32_t vertex(const Element& element, std::uint64_t row, double index) const {
        if (!(index >= 0) || index >= static_cast<double>(vertices_.positions.size())) {
            throw std::runtime_error(std::string(element.name) + ' ' + std::to_string(row) +
                                     " names a vertex out of range (" + in_digits(index) + " of " +
                                     std::to_string(vertices_.positions.size()) + ")");
        }
        return static_cast<std::uint32_t>(index);
    }

    static std::string in_digits(double index) {
        std::string text = std::to_string(static_cast<long double>(index));
        return text.substr(0, text.find('.'));
    }

    void add(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
        MeshTriangle& triangle = triangles_.emplace_back(MeshTriangle{{a, b, c}, {uncolored, uncolored, uncolored}});
        if (vertices_.colors.empty()) return;
        for (std::size_t k = 0; k < 3; ++k) triangle.colors[k] = vertices_.colors[triangle.corners[k]];
    }

    void polygon(const Element& element, std::uint64_t row) {
        polygon_.clear();
        run_.clear();
        for (const double index : list_) {
            run_.push_back(vertex(element, row, index));
            polygon_.push_back(vertices_.positions[run_.back()]);
        }
        for (const auto& [a, b, c] : triangulator_(polygon_)) add(run_[a], run_[b], run_[c]);
    }

    /// A negative index begins anew. Of a strip every other triangle is turned round, so that all face the same way;
    /// one that names a vertex twice only leads to the next.
    template <class F>
    void runs(const Element& element, std::uint64_t row, F&& triangle) {
        run_.clear();
        for (const double index : list_) {
            if (index < 0) {
                run_.clear();
                continue;
            }
            run_.push_back(vertex(element, row, index));
            if (run_.size() < 3) continue;
            const auto [a, b, c] = triangle(run_);
            if (a != b && b != c && c != a) add(a, b, c);
        }
    }

    void strips(const Element& element, std::uint64_t row) {
        runs(element, row, [](const std::vector<std::uint32_t>& run) {
            const std::size_t n = run.size();
            const bool turned = n % 2 == 0;
            return std::array{run[turned ? n - 2 : n - 3], run[turned ? n - 3 : n - 2], run[n - 1]};
        });
    }

    void fans(const Element& element, std::uint64_t row) {
        runs(element, row, [](const std::vector<std::uint32_t>& run) {
            return std::array{run[0], run[run.size() - 2], run[run.size() - 1]};
        });
    }

    const Vertices& vertices_;
    std::vector<MeshTriangle>& triangles_;
    std::vector<double> list_;
    std::vector<std::uint32_t> run_;
    std::vector<glm::dvec3> polygon_;
    Triangulator triangulator_;
};

bool has_faces(const Header& header) {
    return std::any_of(header.elements.begin(), header.elements.end(), [](const Element& element) {
        const bool names_vertices =
            element.name != "range_grid" && element.index_of({"vertex_indices", "vertex_index"}) >= 0;
        return element.count > 0 && (shape_of(element) || names_vertices);
    });
}

void skip_rows(Body& body, const Element& element) {
    std::vector<double> values, unused;
    for (std::uint64_t row = 0; row < element.count; ++row) read_row(body, element, row, -1, values, unused);
}

}  // namespace

Loaded read_ply(std::string_view bytes, const LoadOptions& options) {
    Lines lines(bytes);
    const Header header = read_header(lines);
    std::string_view rest = lines.rest();
    // In a file whose lines end in CR alone the byte after the header's last may be LF and belong to the first number.
    const std::size_t first_end = bytes.find_first_of("\r\n"), begin = bytes.size() - rest.size();
    if (bytes[first_end] == '\r' && bytes.substr(first_end, 2) != "\r\n" && bytes.substr(begin - 2, 2) == "\r\n") {
        rest = bytes.substr(begin - 1);
    }
    Body body(bytes, rest, header.format);
    Vertices vertices;
    Mesh mesh;
    Cloud cloud;
    const bool is_cloud = !has_faces(header);
    bool seen_vertices = false;
    for (const Element& element : header.elements) {
        std::uint64_t least = 0;
        for (const Property& p : element.properties) least += body.least_bytes(p.count_type.value_or(p.type));
        check_room(element.count, least, body.bytes_left() + 1, element.name);
        if (least == 0) continue;
        const std::optional<Shape> shape = shape_of(element);
        if (element.name == "vertex" || element.name == "vertices") {
            if (element.count > std::uint32_t(-1)) throw std::runtime_error("more than 4,294,967,295 vertices");
            if (is_cloud) {
                read_points(body, element, cloud);
            } else {
                read_vertices(body, element, vertices);
            }
            seen_vertices = true;
        } else if (shape && element.count > 0) {
            if (!seen_vertices) throw std::runtime_error("faces come before vertices");
            FaceReader(vertices, mesh.triangles).read(body, element, *shape);
        } else if (element.count > 0 && element.name != "range_grid" &&
                   element.index_of({"vertex_indices", "vertex_index"}) >= 0) {
            throw std::runtime_error("what an element " + in_quotes(element.name) +
                                     " makes of its vertices is not known");
        } else {
            skip_rows(body, element);
        }
    }
    if (!cloud.positions.empty()) return drawn(std::move(cloud), options);
    mesh.positions = std::move(vertices.positions);
    return in_single_precision(mesh);
}

}  // namespace farfield::scenes::detail
