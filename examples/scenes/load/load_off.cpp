// The Object File Format as Geomview's manual has it (chapter 4.2.5, "OFF Files"), read here rather than by
// assimp 5.2, which knows neither face colors nor the prefixes ST, N, 4 and n, and which allocates what the
// header claims.
#include <array>
#include <bit>
#include <cstring>

#include "scenes/load/off_words.hpp"
#include "scenes/load/polygon.hpp"

namespace farfield::scenes::detail {
namespace {

struct Header {
    bool texture = false, colors = false, normals = false, homogeneous = false, binary = false;
    std::size_t dimensions = 3;
};

Header read_header(Words& words) {
    Header header;
    const std::size_t line = words.line();
    const std::string_view whole = words.peek();
    std::string_view word = whole;
    const auto prefix = [&](std::string_view p) {
        if (word.substr(0, p.size()) != p) return false;
        word.remove_prefix(p.size());
        return true;
    };
    header.texture = prefix("ST");
    header.colors = prefix("C");
    header.normals = prefix("N");
    header.homogeneous = prefix("4");
    const bool many = prefix("n");
    if (!prefix("OFF")) {
        // The keyword is optional; the counts then come first.
        if (number<std::uint64_t>(whole)) return {};
        Words::fail(line, in_quotes(whole) + " where a keyword ending in OFF should be");
    }
    words.next("OFF");
    // Some well-known files run the keyword and the first count together: "OFF490 518 0".
    if (!word.empty()) {
        if (!number<std::uint64_t>(word)) Words::fail(line, in_quotes(whole) + " is not a keyword of the format");
        words.back_over(whole, whole.size() - word.size());
    }
    header.binary = words.peek() == "BINARY";
    if (header.binary) {
        if (many) throw std::runtime_error("binary nOFF is not read");
        return header;
    }
    if (many) header.dimensions = words.next_number<std::size_t>("the number of dimensions");
    if (header.dimensions < 3 || header.dimensions > 64) {
        throw std::runtime_error("vertices of " + std::to_string(header.dimensions) + " dimensions");
    }
    return header;
}

/// Colors are kept as written until the whole file is known: "1 0 0" is red in a file of numbers from 0 to 1,
/// and nearly black in one of numbers to 255.
struct RawColor {
    std::array<float, 4> channels{};
    bool indexed = false, present = false;
};

RawColor raw_color(const std::vector<std::string_view>& words, std::size_t line) {
    RawColor color;
    if (words.empty()) return color;
    if (words.size() != 1 && words.size() != 3 && words.size() != 4) {
        Words::fail(line, "a color of " + std::to_string(words.size()) + " numbers");
    }
    color.present = true;
    color.indexed = words.size() == 1;
    for (std::size_t i = 0; i < words.size(); ++i) {
        const std::optional<float> value = number<float>(words[i]);
        if (!value || !(*value >= 0.0f && *value <= 1e6f)) Words::fail(line, in_quotes(words[i]) + " in a color");
        color.channels[i] = *value;
    }
    return color;
}

float scale_of(const std::vector<RawColor>& colors) {
    for (const RawColor& color : colors) {
        for (const float channel : color.channels) {
            if (!color.indexed && channel > 1.0f) return 1.0f / 255.0f;
        }
    }
    return 1.0f;
}

Rgba8 resolved(const RawColor& color, float scale) {
    // Geomview's color map is a file of its own.
    if (color.indexed) return color_of_kind(static_cast<std::int64_t>(color.channels[0]));
    const auto& c = color.channels;
    return to_rgba8({c[0] * scale, c[1] * scale, c[2] * scale, 1.0f});
}

struct Vertices {
    std::vector<glm::dvec3> positions;
    std::vector<Rgba8> colors;  // empty if the format has none
};

Vertices read_vertices(Words& words, const Header& header, std::size_t count) {
    Vertices vertices;
    vertices.positions.reserve(count);
    std::vector<RawColor> colors;
    const std::size_t numbers = header.dimensions * (header.normals ? 2 : 1) + (header.homogeneous ? 1 : 0);
    std::size_t checked_line = 0;
    for (std::size_t v = 0; v < count; ++v) {
        const std::size_t line = words.line();
        const std::string wanted = "vertex " + std::to_string(v) + " of " + std::to_string(count);
        double p[3], w = 1.0;
        for (double& coordinate : p) coordinate = words.next_number<double>(wanted);
        for (std::size_t i = 3; i < header.dimensions; ++i) words.next_number<double>(wanted);
        if (header.homogeneous) w = words.next_number<double>(wanted);
        if (header.normals) {
            // As many as dimensions; not needed.
            for (std::size_t i = 0; i < header.dimensions; ++i) words.next_number<double>(wanted);
        }
        if (!header.colors && !header.texture && !words.done() && words.line() == line && line != checked_line) {
            // Several vertices in a line are legal; anything else means that the keyword lacks a prefix, and
            // taking the numbers as they come would give a scene of nonsense.
            checked_line = line;
            const std::size_t more = Words(words).rest_of(line).size();
            if (more % numbers != 0 && more < numbers * (count - 1 - v)) {
                Words::fail(line, std::to_string(numbers + more) + " numbers where the keyword calls for " +
                                      std::to_string(numbers) + " a vertex");
            }
        }
        vertices.positions.push_back(finite(glm::dvec3(p[0] / w, p[1] / w, p[2] / w), "vertex", v));
        std::vector<std::string_view> rest;
        if (header.colors || header.texture) rest = words.rest_of(line);
        if (header.texture) {
            if (rest.size() < 2) Words::fail(line, wanted + " has no texture coordinates");
            rest.resize(rest.size() - 2);
        }
        if (header.colors) {
            if (rest.size() < 3) Words::fail(line, wanted + " has no color");
            colors.push_back(raw_color(rest, line));
        }
    }
    const float scale = scale_of(colors);
    for (const RawColor& color : colors) vertices.colors.push_back(resolved(color, scale));
    return vertices;
}

/// Faces one after the other, whose colors are known at the end.
class Faces {
  public:
    Faces(Mesh& mesh, const std::vector<Rgba8>& colors_of_vertices, Rgba8 color_of_others)
        : mesh_(mesh), colors_of_vertices_(colors_of_vertices), color_of_others_(color_of_others) {}

    void add(const std::vector<std::uint32_t>& polygon, const RawColor& color) {
        corners_.clear();
        for (const std::uint32_t vertex : polygon) corners_.push_back(mesh_.positions[vertex]);
        for (const auto& [a, b, c] : triangulator_(corners_)) {
            MeshTriangle& triangle = mesh_.triangles.emplace_back();
            triangle.corners = {polygon[a], polygon[b], polygon[c]};
            for (std::size_t k = 0; k < 3; ++k) {
                triangle.colors[k] =
                    colors_of_vertices_.empty() ? color_of_others_ : colors_of_vertices_[triangle.corners[k]];
            }
            colors_.push_back(color);
        }
    }

    void finish() {
        const float scale = scale_of(colors_);
        for (std::size_t t = 0; t < colors_.size(); ++t) {
            if (colors_[t].present) mesh_.triangles[t].colors.fill(resolved(colors_[t], scale));
        }
    }

  private:
    Mesh& mesh_;
    const std::vector<Rgba8>& colors_of_vertices_;
    Rgba8 color_of_others_;
    std::vector<RawColor> colors_;
    std::vector<glm::dvec3> corners_;
    Triangulator triangulator_;
};

// ---------------------------------------------------------------- binary

/// The manual wants the highest byte first, four numbers a color, and after each face the number of numbers in its
/// color. pmp-library and OpenMesh write bytes as they lie in memory and no such count; OpenMesh leaves out alpha, if
/// it has none, and writes colors as whole numbers.
struct Layout {
    std::endian order = std::endian::big;
    std::size_t vertex_channels = 4;
    std::optional<std::size_t> face_channels{};  ///< none: each face says
};

class BinaryOff {
  public:
    BinaryOff(std::string_view bytes, const Header& header, const Layout& layout)
        : at_(bytes), header_(header), layout_(layout) {}

    /// Nothing, if the bytes do not fit the layout to the last.
    std::optional<Mesh> read(Rgba8 color_of_others) {
        const std::uint32_t vertex_count = next<std::uint32_t>(), face_count = next<std::uint32_t>();
        next<std::uint32_t>();  // edges
        const std::size_t floats = 3 + (header_.homogeneous ? 1 : 0) + (header_.normals ? 3 : 0) +
                                   (header_.colors ? layout_.vertex_channels : 0) + (header_.texture ? 2 : 0);
        if (ended_ || vertex_count > at_.size() / (4 * floats)) return std::nullopt;
        Mesh mesh;
        std::vector<RawColor> raw;
        for (std::uint32_t v = 0; v < vertex_count; ++v) {
            glm::dvec3 p;
            for (int i = 0; i < 3; ++i) p[i] = static_cast<double>(next<float>());
            if (header_.homogeneous) p /= static_cast<double>(next<float>());
            mesh.positions.push_back(p);
            if (header_.normals) skip(3);
            if (header_.colors) raw.push_back(color(layout_.vertex_channels));
            if (header_.texture) skip(2);
        }
        std::vector<Rgba8> colors;
        const float scale = scale_of(raw);
        for (const RawColor& c : raw) colors.push_back(resolved(c, scale));
        if (face_count > at_.size() / 4) return std::nullopt;
        Faces faces(mesh, colors, color_of_others);
        std::vector<std::uint32_t> polygon;
        for (std::uint32_t f = 0; f < face_count; ++f) {
            const std::uint32_t sides = next<std::uint32_t>();
            if (sides > at_.size() / 4) return std::nullopt;
            polygon.clear();
            for (std::uint32_t i = 0; i < sides; ++i) {
                polygon.push_back(next<std::uint32_t>());
                if (polygon.back() >= vertex_count) return std::nullopt;
            }
            const std::size_t channels = layout_.face_channels ? *layout_.face_channels : next<std::uint32_t>();
            if (channels > 4 || channels == 2) return std::nullopt;
            faces.add(polygon, color(channels));
            if (ended_) return std::nullopt;
        }
        while (!at_.empty() && is_space(at_.front())) at_.remove_prefix(1);
        if (ended_ || !at_.empty()) return std::nullopt;
        faces.finish();
        for (std::size_t v = 0; v < mesh.positions.size(); ++v) finite(mesh.positions[v], "vertex", v);
        return mesh;
    }

  private:
    template <class T>
    T next() {
        static_assert(sizeof(T) == 4);
        T value{};
        if (at_.size() < sizeof value) {
            ended_ = true;
            at_ = {};
            return value;
        }
        std::array<char, 4> bytes{at_[0], at_[1], at_[2], at_[3]};
        if (layout_.order != std::endian::native) std::reverse(bytes.begin(), bytes.end());
        std::memcpy(&value, bytes.data(), sizeof value);
        at_.remove_prefix(sizeof value);
        return value;
    }
    void skip(std::size_t count) {
        while (count-- > 0) next<std::uint32_t>();
    }

    RawColor color(std::size_t channels) {
        RawColor result;
        result.present = channels > 0;
        result.indexed = channels == 1;
        for (std::size_t i = 0; i < channels; ++i) {
            const auto bits = next<std::uint32_t>();
            // No fraction worth mentioning has the bits of a whole number to 255.
            const float channel = bits <= 255 ? static_cast<float>(bits) : std::bit_cast<float>(bits);
            result.channels[i] = channel >= 0.0f && channel <= 1e6f ? channel : 0.0f;
        }
        return result;
    }

    std::string_view at_;
    const Header& header_;
    Layout layout_;
    bool ended_ = false;
};

Mesh read_binary(std::string_view bytes, const Header& header, Rgba8 color_of_others) {
    for (const std::endian order : {std::endian::big, std::endian::little}) {
        for (const std::size_t vertex_channels : {4u, 3u}) {
            if (!header.colors && vertex_channels == 3) continue;
            using Channels = std::optional<std::size_t>;
            for (const Channels face_channels : {Channels{}, Channels{0}, Channels{3}, Channels{4}}) {
                std::optional<Mesh> mesh =
                    BinaryOff(bytes, header, {order, vertex_channels, face_channels}).read(color_of_others);
                if (mesh) return *std::move(mesh);
            }
        }
    }
    throw std::runtime_error("is binary, and its counts fit neither the bytes there are nor any order of them");
}

}  // namespace

Mesh read_off_object(Words& words, Rgba8 color_of_others) {
    const Header header = read_header(words);
    if (header.binary) {
        // The bytes begin after the end of the line.
        std::string_view rest = words.rest();
        words.next("BINARY");
        rest.remove_prefix(std::min(rest.size(), rest.find_first_of("\r\n")));
        rest.remove_prefix(rest.substr(0, 2) == "\r\n" ? 2 : std::min<std::size_t>(rest.size(), 1));
        Mesh mesh = read_binary(rest, header, color_of_others);
        words = Words({});
        return mesh;
    }
    const std::size_t line_of_counts = words.line();
    const auto vertex_count = words.next_number<std::uint64_t>("the number of vertices");
    const auto face_count = words.next_number<std::uint64_t>("the number of faces");
    // The number of edges is of no use, and missing in some files.
    if (!words.done() && words.line() == line_of_counts) words.next_number<double>("the number of edges");
    check_room(vertex_count, 2 * header.dimensions, words.bytes_left() + 1, "vertices");
    if (vertex_count > std::uint32_t(-1)) throw std::runtime_error("more than 4,294,967,295 vertices");
    Vertices vertices = read_vertices(words, header, static_cast<std::size_t>(vertex_count));
    check_room(face_count, 2, words.bytes_left() + 1, "faces");

    Mesh mesh;
    mesh.positions = std::move(vertices.positions);
    Faces faces(mesh, vertices.colors, color_of_others);
    std::vector<std::uint32_t> polygon;
    for (std::uint64_t f = 0; f < face_count; ++f) {
        const std::string wanted = "face " + std::to_string(f) + " of " + std::to_string(face_count);
        const auto sides = words.next_number<std::uint64_t>(wanted);
        check_room(sides, 2, words.bytes_left() + 1, "vertices in " + wanted);
        polygon.clear();
        std::size_t line = words.line();
        for (std::uint64_t i = 0; i < sides; ++i) {
            line = words.line();
            const auto index = words.next_number<std::uint64_t>("a vertex of " + wanted);
            if (index >= vertex_count) {
                Words::fail(line, "face " + std::to_string(f) + " names vertex " + std::to_string(index) + " of " +
                                      std::to_string(vertex_count));
            }
            polygon.push_back(static_cast<std::uint32_t>(index));
        }
        if (sides > 0) faces.add(polygon, raw_color(words.rest_of(line), line));
    }
    faces.finish();
    return mesh;
}

}  // namespace farfield::scenes::detail
