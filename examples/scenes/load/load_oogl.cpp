// What may stand around OFF in Geomview's files: lists, instances, appearances, references; and its meshes and
// quadrilaterals. After its manual, chapter 4, "OOGL File Formats". What it draws besides (spheres, patches, volumes)
// is refused by name; lines and points are left out with a note.
#include <array>
#include <glm/mat4x4.hpp>
#include <map>

#include "scenes/load/off_words.hpp"

namespace farfield::scenes::detail {
namespace {

constexpr int most_nested = 64;
// A small file can place a large object very often, and double it in every line.
constexpr std::size_t most_triangles = 10'000'000, most_transforms = 1'000'000;

using Transforms = std::vector<glm::dmat4>;

class OoglReader {
  public:
    explicit OoglReader(std::filesystem::path folder) : folder_(std::move(folder)) {}

    Mesh file(std::string_view text) {
        Words words(text);
        if (words.done()) throw std::runtime_error("is empty");
        Mesh mesh = object(words, uncolored);
        if (!words.done() && words.peek() == "}") Words::fail(words.line(), "'}' without '{'");
        return mesh;
    }

    std::vector<std::string> notes;

  private:
    /// How deep in braces, references and files the reader is.
    struct Depth {
        explicit Depth(int& depth) : depth_(depth) {
            if (++depth_ > most_nested) throw std::runtime_error("objects are nested deeper than 64, or in themselves");
        }
        ~Depth() { --depth_; }
        Depth(const Depth&) = delete;
        Depth& operator=(const Depth&) = delete;

      private:
        int& depth_;
    };

    Mesh object(Words& words, Rgba8 color) {
        const Depth deeper(depth_);
        while (true) {
            const std::string_view word = words.peek();
            if (word == "appearance") {
                words.next("");
                appearance(words, color);
            } else if (word == "=") {
                words.next("");
            } else if (word == "define" || word == "hdefine") {
                words.next("");
                if (word == "hdefine") words.next("a kind of object");
                const std::string named(words.next("a name"));
                return symbols_.insert_or_assign(named, object(words, color)).first->second;
            } else {
                break;
            }
        }
        if (words.done()) throw std::runtime_error("ends where an object should be");
        const std::size_t line = words.line();
        std::string_view word = words.peek();
        if (word == "{") {
            words.next("");
            Mesh mesh;
            // Nothing, or an appearance alone, is an object, too.
            if (words.peek() != "}") mesh = object(words, color);
            if (words.next("'}'") != "}") Words::fail(line, "the '{' here has no '}' after its object");
            return mesh;
        }
        if (word == "}") return {};
        if (word.front() == '<' || word.front() == ':') return reference(words, color);
        if (word == "LIST") {
            words.next("");
            Mesh mesh;
            while (!words.done() && words.peek() != "}") append(mesh, object(words, color), glm::dmat4(1.0));
            return mesh;
        }
        if (word == "INST") return instances(words, color);
        if (word == "VECT" || word == "SKEL" || word == "COMMENT") {
            note(std::string(word) + " is not drawn, only surfaces are");
            while (!words.done() && words.peek() != "}") skip(words);
            return {};
        }
        const auto ends_in = [&](std::string_view end) {
            return word.size() >= end.size() && word.substr(word.size() - end.size()) == end;
        };
        if (ends_in("QUAD") || ends_in("POLY")) return quadrilaterals(words, color);
        if (ends_in("MESH")) return grid(words, color);
        if (ends_in("OFF") || number<std::uint64_t>(word) || word.substr(0, 3) == "OFF") {
            return read_off_object(words, color);
        }
        Words::fail(line, in_quotes(word) + " where a keyword ending in OFF should be, or LIST, INST, QUAD or MESH");
    }

    /// A word, or all that is in braces.
    static void skip(Words& words) {
        int open = 0;
        do {
            const std::string_view word = words.next("'}'");
            open += word == "{" ? 1 : word == "}" ? -1 : 0;
        } while (open > 0);
    }

    /// Of all that it says only the color of faces without one counts here.
    void appearance(Words& words, Rgba8& color) {
        if (words.peek() != "{") {
            words.next("an appearance");  // a reference
            return;
        }
        int open = 0;
        do {
            const std::string_view word = words.next("'}'");
            open += word == "{" ? 1 : word == "}" ? -1 : 0;
            if (word != "diffuse" && word != "*diffuse") continue;
            glm::vec4 c(1.0f);
            for (int i = 0; i < 3; ++i) c[i] = words.next_number<float>("a color");
            color = to_rgba8(c);
        } while (open > 0);
    }

    /// "< file" or ": symbol"; the name may follow without a space, and may be in quotes.
    static std::string name(Words& words) {
        const std::string_view rest = words.rest().substr(1);
        words = Words(rest, words.line());
        if (words.peek().substr(0, 1) != "\"") return std::string(words.next("a name"));
        const std::string_view quoted = words.rest().substr(1);
        const std::size_t end = quoted.find('"');
        if (end == std::string_view::npos) Words::fail(words.line(), "a quotation mark that is not closed");
        words = Words(quoted.substr(end + 1), words.line());
        return std::string(quoted.substr(0, end));
    }

    Mesh reference(Words& words, Rgba8 color) {
        const bool to_file = words.peek().front() == '<';
        const std::string named = name(words);
        if (!to_file) {
            return found(symbols_, named, words);
        }
        const auto [entry, is_new] = files_.try_emplace(named);
        if (is_new) {
            try {
                const std::string text = read_file(folder_ / named);
                Words there(text);
                entry->second = object(there, color);
            } catch (const std::runtime_error& error) {
                throw std::runtime_error("file " + in_quotes(named) + ": " + error.what());
            }
        } else if (!entry->second) {
            throw std::runtime_error("file " + in_quotes(named) + " refers to itself");
        }
        return *entry->second;
    }

    template <class T>
    static const T& found(const std::map<std::string, T>& symbols, const std::string& named, const Words& words) {
        const auto symbol = symbols.find(named);
        if (symbol == symbols.end()) Words::fail(words.line(), "nothing is defined as " + in_quotes(named));
        return symbol->second;
    }

    Mesh instances(Words& words, Rgba8 color) {
        words.next("INST");
        Mesh unit;
        Transforms transforms;
        bool has_unit = false;
        while (!words.done() && words.peek() != "}") {
            const std::size_t line = words.line();
            const std::string_view word = words.next("");
            if (word == "geom" || word == "unit") {
                unit = object(words, color);
                has_unit = true;
            } else if (word == "transform" || word == "transforms" || word == "tlist") {
                const Transforms more = read_transforms(words);
                transforms.insert(transforms.end(), more.begin(), more.end());
            } else if (word == "location" || word == "origin") {
                Words::fail(line, "an INST with its own " + std::string(word) + " is not read");
            } else {
                Words::fail(line, in_quotes(word) + " in an INST");
            }
        }
        if (!has_unit) throw std::runtime_error("an INST has no geom");
        if (transforms.empty()) transforms.push_back(glm::dmat4(1.0));
        if (unit.triangles.size() > most_triangles / transforms.size()) too_many();
        Mesh mesh;
        for (const glm::dmat4& transform : transforms) append(mesh, unit, transform);
        return mesh;
    }

    /// Sixteen numbers, or a list of as many each, in braces or not, or what has been defined as such.
    Transforms read_transforms(Words& words) {
        const Depth deeper(depth_);
        const std::size_t line = words.line();
        const std::string_view word = words.peek();
        const auto is_one = [&] {
            const std::string_view next = words.peek();
            return next == "{" || next.substr(0, 1) == "<" || next.substr(0, 1) == ":" || number<double>(next);
        };
        Transforms result;
        const auto add = [&](const Transforms& more) {
            if (result.size() + more.size() > most_transforms)
                throw std::runtime_error("more than 1,000,000 transforms");
            result.insert(result.end(), more.begin(), more.end());
        };
        if (word == "{") {
            words.next("");
            while (words.peek() != "}") add(read_transforms(words));
            words.next("'}'");
        } else if (word == "=" || word == "TRANS") {
            words.next("");
            return read_transforms(words);
        } else if (word == "TLIST" || word == "GROUP" || word == "LIST") {
            words.next("");
            while (is_one()) add(read_transforms(words));
        } else if (word == "define") {
            words.next("");
            const std::string named(words.next("a name"));
            return defined_transforms_.insert_or_assign(named, read_transforms(words)).first->second;
        } else if (word.substr(0, 1) == "<") {
            Words::fail(line, "transforms in a file of their own are not read");
        } else if (word.substr(0, 1) == ":") {
            return found(defined_transforms_, name(words), words);
        } else {
            // Points are rows and stand on the left; GLM's are columns, so that its columns are the rows here.
            glm::dmat4 m;
            for (int row = 0; row < 4; ++row) {
                for (int column = 0; column < 4; ++column) {
                    m[row][column] = words.next_number<double>("a number of a transformation");
                }
            }
            result.push_back(m);
        }
        return result;
    }

    static void append(Mesh& mesh, const Mesh& more, const glm::dmat4& transform) {
        if (more.triangles.empty()) return;
        if (mesh.triangles.size() + more.triangles.size() > most_triangles) too_many();
        if (mesh.positions.size() + more.positions.size() > std::uint32_t(-1)) {
            throw std::runtime_error("more than 4,294,967,295 vertices, with every instance");
        }
        const auto first = static_cast<std::uint32_t>(mesh.positions.size());
        for (std::size_t v = 0; v < more.positions.size(); ++v) {
            const glm::dvec4 p = transform * glm::dvec4(more.positions[v], 1.0);
            mesh.positions.push_back(finite(p.w == 1.0 ? glm::dvec3(p) : glm::dvec3(p) / p.w, "vertex", first + v));
        }
        const bool mirrored = glm::determinant(glm::dmat3(transform)) < 0.0;  // turns fronts into backs
        for (MeshTriangle triangle : more.triangles) {
            for (std::uint32_t& corner : triangle.corners) corner += first;
            if (mirrored) {
                std::swap(triangle.corners[1], triangle.corners[2]);
                std::swap(triangle.colors[1], triangle.colors[2]);
            }
            mesh.triangles.push_back(triangle);
        }
    }

    // ------------------------------------------------------------ objects besides OFF

    struct Prefix {
        bool colors = false, normals = false, heights = false, homogeneous = false, texture = false;
        bool closed_in_u = false, closed_in_v = false;
    };

    static Prefix prefix(std::string_view word, std::size_t line) {
        Prefix result;
        for (const char c : word) {
            bool* const flag = c == 'C'   ? &result.colors
                               : c == 'N' ? &result.normals
                               : c == 'Z' ? &result.heights
                               : c == '4' ? &result.homogeneous
                               : c == 'U' ? &result.texture
                               : c == 'u' ? &result.closed_in_u
                               : c == 'v' ? &result.closed_in_v
                                          : nullptr;
            if (!flag) Words::fail(line, in_quotes(word) + " before QUAD or MESH");
            *flag = true;
        }
        return result;
    }

    struct Vertices {
        Mesh mesh{};
        std::vector<Rgba8> colors{};

        Rgba8 color(std::uint32_t vertex, Rgba8 otherwise) const { return colors.empty() ? otherwise : colors[vertex]; }
        void add(const std::array<std::uint32_t, 3>& corners, Rgba8 otherwise) {
            mesh.triangles.push_back(
                {corners, {color(corners[0], otherwise), color(corners[1], otherwise), color(corners[2], otherwise)}});
        }
    };

    static void read_vertex(Words& words, const Prefix& prefix, double u, double v, Vertices& vertices) {
        constexpr const char* wanted = "a number of a vertex";
        glm::dvec3 p(u, v, 0.0);
        if (!prefix.heights) p.x = words.next_number<double>(wanted);
        if (!prefix.heights) p.y = words.next_number<double>(wanted);
        p.z = words.next_number<double>(wanted);
        if (prefix.homogeneous) p /= words.next_number<double>(wanted);
        for (int i = 0; prefix.normals && i < 3; ++i) words.next_number<double>(wanted);
        if (prefix.colors) {
            glm::vec4 color;
            for (int i = 0; i < 4; ++i) color[i] = words.next_number<float>(wanted);
            color.a = 1.0f;
            vertices.colors.push_back(to_rgba8(color));
        }
        for (int i = 0; prefix.texture && i < 2; ++i) words.next_number<double>(wanted);
        vertices.mesh.positions.push_back(finite(p, "vertex", vertices.mesh.positions.size()));
    }

    static Mesh quadrilaterals(Words& words, Rgba8 color) {
        const std::size_t line = words.line();
        std::string_view word = words.next("");
        const Prefix of = prefix(word.substr(0, word.size() - 4), line);
        Vertices vertices;
        while (!words.done() && words.peek() != "}") {
            const auto first = static_cast<std::uint32_t>(vertices.mesh.positions.size());
            for (int i = 0; i < 4; ++i) read_vertex(words, of, 0, 0, vertices);
            vertices.add({first, first + 1, first + 2}, color);
            vertices.add({first, first + 2, first + 3}, color);
        }
        return std::move(vertices.mesh);
    }

    static Mesh grid(Words& words, Rgba8 color) {
        const std::size_t line = words.line();
        std::string_view word = words.next("");
        const Prefix of = prefix(word.substr(0, word.size() - 4), line);
        const auto across = words.next_number<std::uint32_t>("the number of columns"),
                   up = words.next_number<std::uint32_t>("the number of rows");
        check_room(std::uint64_t{across} * up, 2, words.bytes_left() + 1, "vertices");
        Vertices vertices;
        for (std::uint32_t v = 0; v < up; ++v) {
            for (std::uint32_t u = 0; u < across; ++u) read_vertex(words, of, u, v, vertices);
        }
        const auto at = [&](std::uint32_t u, std::uint32_t v) { return (v % up) * across + u % across; };
        for (std::uint32_t v = 0; v + (of.closed_in_v ? 0 : 1) < up; ++v) {
            for (std::uint32_t u = 0; u + (of.closed_in_u ? 0 : 1) < across; ++u) {
                vertices.add({at(u, v), at(u + 1, v), at(u + 1, v + 1)}, color);
                vertices.add({at(u, v), at(u + 1, v + 1), at(u, v + 1)}, color);
            }
        }
        return std::move(vertices.mesh);
    }

    void note(const std::string& text) {
        if (std::find(notes.begin(), notes.end(), text) == notes.end()) notes.push_back(text);
    }

    [[noreturn]] static void too_many() {
        throw std::runtime_error("more than 10,000,000 triangles, with every instance");
    }

    std::filesystem::path folder_;
    std::map<std::string, Mesh> symbols_;
    std::map<std::string, std::optional<Mesh>> files_;  ///< nothing while it is read
    std::map<std::string, Transforms> defined_transforms_;
    int depth_ = 0;
};

}  // namespace

Loaded read_off(std::string_view bytes, const std::filesystem::path& folder) {
    OoglReader reader(folder);
    const Mesh mesh = reader.file(bytes);
    Loaded loaded = in_single_precision(mesh);
    loaded.notes = std::move(reader.notes);
    return loaded;
}

}  // namespace farfield::scenes::detail
