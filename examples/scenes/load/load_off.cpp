// The Object File Format as Geomview's manual has it (chapter 4.2.5, "OFF Files"), read here rather than by
// assimp 5.2, which knows neither face colors nor the prefixes ST, N, 4 and n, and which allocates what the
// header claims.
#include <algorithm>
#include <array>

#include "scenes/load/load_detail.hpp"

namespace farfield::scenes::detail {
namespace {

/// Words with the line they stand in; from '#' to the end of a line is a comment.
class Words {
  public:
    explicit Words(std::string_view text) : text_(text) { skip(); }

    bool done() const { return at_ == text_.size(); }
    std::size_t line() const { return line_; }
    std::size_t bytes_left() const { return text_.size() - at_; }

    std::string_view peek() const {
        std::size_t end = at_;
        while (end < text_.size() && !is_space(text_[end]) && text_[end] != '#') ++end;
        return text_.substr(at_, end - at_);
    }
    std::string_view next(std::string_view wanted) {
        if (done()) throw std::runtime_error("ends where " + std::string(wanted) + " should be");
        const std::string_view word = peek();
        at_ += word.size();
        skip();
        return word;
    }
    template <class T>
    T next_number(std::string_view wanted) {
        const std::size_t line = line_;
        const std::string_view word = next(wanted);
        const std::optional<T> value = number<T>(word);
        if (!value) fail(line, in_quotes(word) + " where " + std::string(wanted) + " should be");
        return *value;
    }
    /// The words left in line `line`.
    std::vector<std::string_view> rest_of(std::size_t line) {
        std::vector<std::string_view> result;
        while (!done() && line_ == line) result.push_back(next(""));
        return result;
    }
    void back_over(std::string_view word, std::size_t keep) {
        at_ = static_cast<std::size_t>(word.data() - text_.data()) + keep;
    }

    [[noreturn]] static void fail(std::size_t line, const std::string& reason) {
        throw std::runtime_error("line " + std::to_string(line) + ": " + reason);
    }

  private:
    void skip() {
        for (; at_ < text_.size(); ++at_) {
            if (text_[at_] == '#') at_ = std::min(text_.find('\n', at_), text_.size());
            if (at_ == text_.size()) return;
            if (!is_space(text_[at_])) return;
            line_ += text_[at_] == '\n';
        }
    }

    std::string_view text_;
    std::size_t at_ = 0;
    std::size_t line_ = 1;
};

struct Header {
    bool texture = false, colors = false, normals = false, homogeneous = false;
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
    if (!words.done() && words.peek() == "BINARY") throw std::runtime_error("binary OFF is not supported");
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
    if (!color.present) return uncolored;
    // Geomview's color map is a file of its own.
    if (color.indexed) return color_of_kind(static_cast<std::int64_t>(color.channels[0]));
    const auto& c = color.channels;
    return to_rgba8({c[0] * scale, c[1] * scale, c[2] * scale, 1.0f});
}

struct Vertices {
    std::vector<glm::vec3> positions;
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
        vertices.positions.push_back(finite(p[0] / w, p[1] / w, p[2] / w, "vertex", v));
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

}  // namespace

Triangles read_off(std::string_view text) {
    Words words(text);
    if (words.done()) throw std::runtime_error("is empty");
    const Header header = read_header(words);
    const std::size_t line_of_counts = words.line();
    const auto vertex_count = words.next_number<std::uint64_t>("the number of vertices");
    const auto face_count = words.next_number<std::uint64_t>("the number of faces");
    // The number of edges is of no use, and missing in some files.
    if (!words.done() && words.line() == line_of_counts) words.next_number<double>("the number of edges");
    check_room(vertex_count, 2 * header.dimensions, words.bytes_left() + 1, "vertices");
    const Vertices vertices = read_vertices(words, header, static_cast<std::size_t>(vertex_count));
    check_room(face_count, 2, words.bytes_left() + 1, "faces");

    Triangles triangles;
    std::vector<RawColor> colors;  // of triangles, resolved at the end
    std::vector<std::size_t> polygon;
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
            polygon.push_back(static_cast<std::size_t>(index));
        }
        if (sides == 0) continue;
        const RawColor color = raw_color(words.rest_of(line), line);
        for (std::size_t i = 2; i < polygon.size(); ++i) {
            const std::array<std::size_t, 3> corners{polygon[0], polygon[i - 1], polygon[i]};
            VertexColoredTriangle& triangle = triangles.emplace_back();
            for (std::size_t k = 0; k < 3; ++k) {
                triangle.vertices[k] = vertices.positions[corners[k]];
                triangle.rgba[k] = vertices.colors.empty() ? uncolored : vertices.colors[corners[k]];
            }
            colors.push_back(color);
        }
    }
    const float scale = scale_of(colors);
    for (std::size_t t = 0; t < triangles.size(); ++t) {
        if (colors[t].present) triangles[t].rgba.fill(resolved(colors[t], scale));
    }
    return triangles;
}

}  // namespace farfield::scenes::detail
