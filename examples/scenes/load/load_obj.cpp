// Wavefront's OBJ and its material libraries, after "Advanced Visualizer Manual", appendix B1, and "MTL material
// format" (Alias|Wavefront, 1995), with the colors of vertices that many write after their coordinates. Read here
// rather than by a library: assimp 5.2 takes a missing Kd for 0.6, leaves out faces that end in a comment, and rounds
// before anything is subtracted; tinyobjloader 2 rounds, too, reads "1.#IND" as 1, and makes vertices without a color
// white or black by what their neighbors have.
#include <algorithm>
#include <glm/vec2.hpp>
#include <map>
#include <set>

#include "scenes/load/load_detail.hpp"
#include "scenes/load/polygon.hpp"
#include "scenes/load/texture.hpp"

namespace farfield::scenes::detail {
namespace {

/// From '#' at the beginning of a word to the end of the line is a comment; names may have one inside.
std::string_view without_comment(std::string_view line) {
    for (std::size_t hash = line.find('#'); hash != std::string_view::npos; hash = line.find('#', hash + 1)) {
        if (hash == 0 || is_space(line[hash - 1])) return line.substr(0, hash);
    }
    return line;
}

/// Lines without comments, those that end in '\' with the one that continues them.
class Statements {
  public:
    explicit Statements(std::string_view text) : lines(text) {}

    bool next(std::string_view& keyword, std::string_view& rest) {
        std::string_view line;
        if (!lines.next(line)) return false;
        line = trimmed(without_comment(line));
        if (!line.empty() && line.back() == '\\') {
            joined_.clear();
            while (!line.empty() && line.back() == '\\') {
                joined_.append(line.substr(0, line.size() - 1)).push_back(' ');
                if (!lines.next(line)) line = {};
                line = trimmed(without_comment(line));
            }
            line = joined_.append(line);
            line = trimmed(line);
        }
        const std::size_t end =
            static_cast<std::size_t>(std::find_if(line.begin(), line.end(), is_space) - line.begin());
        keyword = line.substr(0, end);
        rest = trimmed(line.substr(end));
        return true;
    }

    Lines lines;

  private:
    std::string joined_;
};

std::string_view next_word(std::string_view& rest) {
    rest = trimmed(rest);
    const auto end = static_cast<std::size_t>(std::find_if(rest.begin(), rest.end(), is_space) - rest.begin());
    const std::string_view word = rest.substr(0, end);
    rest = trimmed(rest.substr(end));
    return word;
}

std::string_view without_quotes(std::string_view name) {
    const bool quoted = name.size() > 1 && name.front() == '"' && name.back() == '"';
    return quoted ? name.substr(1, name.size() - 2) : name;
}

/// Files that lie beside the OBJ, by the names that it gives them.
class Folder {
  public:
    explicit Folder(std::filesystem::path path) : path_(std::move(path)) {}

    /// As named, or else a file of that name here: many name the folder of another machine.
    std::optional<std::string> content_of(std::string_view name) const {
        std::string portable(without_quotes(name));
        std::replace(portable.begin(), portable.end(), '\\', '/');
        if (portable.empty() || portable.find('\0') != std::string::npos) return std::nullopt;
        for (const std::string& candidate : {portable, portable.substr(portable.rfind('/') + 1)}) {
            try {
                return read_file(path_ / candidate);
            } catch (const std::runtime_error&) {
            }
        }
        return std::nullopt;
    }

  private:
    std::filesystem::path path_;
};

// ---------------------------------------------------------------- materials

struct TextureMap {
    std::string file{};
    glm::vec2 scale{1.0f}, offset{0.0f};
    bool clamped = false;
    float base = 0.0f, gain = 1.0f;
};

/// As displayed, not linear. What a library does not say about color leaves it as it is: white.
struct Material {
    glm::vec3 color{1.0f};
    TextureMap map{};
};

using Materials = std::map<std::string, Material, std::less<>>;

class MaterialReader {
  public:
    MaterialReader(std::string_view text, Materials& materials, std::vector<std::string>& notes)
        : statements_(text), materials_(materials), notes_(notes) {}

    void read() {
        Material nowhere, *material = &nowhere;
        std::string_view keyword, rest;
        while (statements_.next(keyword, rest)) {
            if (keyword == "newmtl") {
                // "The first file listed is searched first", so the first of a name counts.
                const auto [entry, is_new] = materials_.try_emplace(std::string(rest));
                material = is_new ? &entry->second : &nowhere;
            } else if (keyword == "Kd") {
                material->color = color(rest);
            } else if (keyword == "map_Kd" || keyword == "map_kd") {
                material->map = map(rest);
            }
        }
    }

  private:
    float real(std::string_view word, std::string_view of) const {
        const std::optional<float> value = number<float>(word);
        if (!value || !std::isfinite(*value)) statements_.lines.fail(in_quotes(word) + " in " + std::string(of));
        return *value;
    }

    glm::vec3 color(std::string_view rest) const {
        const std::vector<std::string_view> w = words(rest);
        if (w.size() != 1 && w.size() != 3) {
            statements_.lines.fail("a Kd that is not three numbers: " + in_quotes(rest));
        }
        glm::vec3 result(real(w[0], "Kd"));
        if (w.size() == 3) result = {result.x, real(w[1], "Kd"), real(w[2], "Kd")};
        return result;
    }

    /// One to three numbers, as far as they go.
    glm::vec2 pair(std::string_view& rest, float otherwise) const {
        glm::vec2 result(otherwise);
        for (int i = 0; i < 3; ++i) {
            std::string_view ahead = rest;
            const std::optional<float> value = number<float>(next_word(ahead));
            if (!value) break;
            if (i < 2) result[i] = *value;
            rest = ahead;
        }
        return result;
    }

    TextureMap map(std::string_view rest) const {
        TextureMap result;
        while (!rest.empty() && rest.front() == '-') {
            const std::string_view option = next_word(rest);
            if (option == "-s") {
                result.scale = pair(rest, 1.0f);
            } else if (option == "-o") {
                result.offset = pair(rest, 0.0f);
            } else if (option == "-t") {
                pair(rest, 0.0f);
                notes_.push_back("turbulence of a texture (map_Kd -t) is not drawn");
            } else if (option == "-clamp") {
                result.clamped = next_word(rest) == "on";
            } else if (option == "-mm") {
                result.base = real(next_word(rest), "map_Kd -mm");
                result.gain = real(next_word(rest), "map_Kd -mm");
            } else if (option == "-blendu" || option == "-blendv" || option == "-cc" || option == "-bm" ||
                       option == "-boost" || option == "-texres" || option == "-imfchan" || option == "-type") {
                next_word(rest);  // filters, or matters of other maps
            } else {
                statements_.lines.fail("option " + in_quotes(option) + " of map_Kd is not known");
            }
        }
        result.file = std::string(rest);
        return result;
    }

    Statements statements_;
    Materials& materials_;
    std::vector<std::string>& notes_;
};

// ---------------------------------------------------------------- the file

class ObjReader {
  public:
    ObjReader(std::string_view text, std::filesystem::path folder) : statements_(text), folder_(std::move(folder)) {}

    Loaded read() {
        std::string_view keyword, rest;
        while (statements_.next(keyword, rest)) {
            if (keyword == "v") {
                vertex(without_rest_of_comment(rest));
            } else if (keyword == "vt") {
                texture_coordinates(without_rest_of_comment(rest));
            } else if (keyword == "f" || keyword == "fo") {
                face(without_rest_of_comment(rest));
            } else if (keyword == "usemtl") {
                material_ = index_of(rest);
            } else if (keyword == "mtllib") {
                libraries(rest);
            } else if (keyword == "surf" || keyword == "call" || keyword == "csh") {
                statements_.lines.fail(in_quotes(keyword) + " is not read, only polygons are");
            }
        }
        for (const std::string& name : uses_) surfaces_.push_back(surface(name));
        for (const Face& face : faces_) draw(face);
        Loaded loaded = in_single_precision(mesh_);
        loaded.notes = std::move(notes_);
        return loaded;
    }

  private:
    static constexpr std::uint32_t none = ~std::uint32_t{0};

    struct Corner {
        std::uint32_t position, texture;
    };
    struct Face {
        std::size_t first, count;
        std::uint32_t material;
        std::size_t line;
    };
    /// A material as it is drawn.
    struct Surface {
        glm::vec3 color;
        bool is_known = false;
        TextureMap map{};
        const Image* image = nullptr;
    };

    /// In lines of numbers a comment may follow one without a space; "1.#IND" is what some C libraries print for NaN.
    static std::string_view without_rest_of_comment(std::string_view rest) {
        std::size_t hash = rest.find('#');
        while (hash != std::string_view::npos && hash > 0 && rest[hash - 1] == '.') hash = rest.find('#', hash + 1);
        return rest.substr(0, hash);
    }

    [[noreturn]] void fail(const std::string& reason) const { statements_.lines.fail(reason); }

    double real(std::string_view word, const char* of) const {
        const std::optional<double> value = number<double>(word);
        if (!value) fail(in_quotes(word) + " in " + of);
        return *value;
    }

    /// x y z, then nothing, a weight (for curves), or red, green, blue and perhaps alpha.
    void vertex(std::string_view rest) {
        words_.clear();
        split(rest, words_);
        const std::size_t n = words_.size(), index = mesh_.positions.size();
        if (n < 3 || n == 5 || n > 7) fail("a vertex of " + std::to_string(n) + " numbers");
        glm::dvec3 p;
        for (int i = 0; i < 3; ++i) p[i] = real(words_[static_cast<std::size_t>(i)], "a vertex");
        if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z)) {
            fail("vertex " + std::to_string(index) + " is not finite");
        }
        if (index == none) fail("more than 4,294,967,295 vertices");
        mesh_.positions.push_back(p);
        if (n < 6) return;
        glm::vec3 color;
        for (int i = 0; i < 3; ++i) {
            color[i] = static_cast<float>(real(words_[static_cast<std::size_t>(i) + 3], "a color"));
            if (!std::isfinite(color[i])) fail("a color that is not finite");
            if (color[i] > 1.0f) color_scale_ = 1.0f / 255.0f;
        }
        colors_.resize(index, uncolored_vertex);
        colors_.push_back(color);
    }

    void texture_coordinates(std::string_view rest) {
        words_.clear();
        split(rest, words_);
        if (words_.empty()) fail("no texture coordinates after vt");
        glm::vec2 uv(0.0f);
        for (std::size_t i = 0; i < std::min<std::size_t>(words_.size(), 2); ++i) {
            uv[static_cast<int>(i)] = static_cast<float>(real(words_[i], "texture coordinates"));
        }
        coordinates_.push_back(uv);
    }

    /// From 1 from the first, from -1 from the last so far.
    std::uint32_t index(std::string_view word, std::size_t so_far, const char* of) const {
        const std::optional<std::int64_t> value = number<std::int64_t>(word);
        if (!value) fail(in_quotes(word) + " where the number of a " + of + " should be");
        const auto count = static_cast<std::int64_t>(so_far);
        if (*value == 0 || *value < -count || *value > std::int64_t{none}) {
            fail("a face names " + std::string(of) + ' ' + std::to_string(*value) + " of " + std::to_string(count));
        }
        return static_cast<std::uint32_t>(*value > 0 ? *value - 1 : count + *value);
    }

    void face(std::string_view rest) {
        words_.clear();
        split(rest, words_);
        faces_.push_back({corners_.size(), words_.size(), material_, statements_.lines.number()});
        for (const std::string_view word : words_) {
            const std::size_t slash = word.find('/');
            Corner corner{index(word.substr(0, slash), mesh_.positions.size(), "vertex"), none};
            if (slash != std::string_view::npos) {
                const std::string_view more = word.substr(slash + 1), texture = more.substr(0, more.find('/'));
                if (!texture.empty()) corner.texture = index(texture, coordinates_.size(), "texture coordinate");
            }
            corners_.push_back(corner);
        }
    }

    std::uint32_t index_of(std::string_view name) {
        const auto [entry, is_new] = use_of_.try_emplace(std::string(name), static_cast<std::uint32_t>(uses_.size()));
        if (is_new) uses_.push_back(std::string(name));
        return entry->second;
    }

    /// Several names in a line, where each may have spaces in it: as many words as make the name of a file.
    void libraries(std::string_view rest) {
        while (!rest.empty()) {
            std::string_view name = rest;
            std::optional<std::string> content = folder_.content_of(name);
            while (!content && name.find_last_of(" \t") != std::string_view::npos) {
                name = trimmed(name.substr(0, name.find_last_of(" \t")));
                content = folder_.content_of(name);
            }
            rest = trimmed(rest.substr(name.size()));
            if (!libraries_.insert(std::string(name)).second) continue;
            if (!content) {
                notes_.push_back("material library " + in_quotes(name) + " cannot be read");
                continue;
            }
            try {
                MaterialReader(*content, materials_, notes_).read();
            } catch (const std::runtime_error& error) {
                throw std::runtime_error(std::string(name) + ": " + error.what());
            }
        }
    }

    Surface surface(const std::string& name) {
        const auto found = materials_.find(name);
        if (found == materials_.end()) {
            if (!name.empty()) notes_.push_back("material " + in_quotes(name) + " is in no material library");
            return {};
        }
        const Material& material = found->second;
        Surface result{material.color, true, material.map};
        if (material.map.file.empty()) return result;
        const auto [entry, is_new] = images_.try_emplace(material.map.file);
        if (is_new) {
            const std::optional<std::string> content = folder_.content_of(material.map.file);
            if (content) entry->second = decoded(*content);
            if (entry->second.texels.empty()) {
                notes_.push_back("texture " + in_quotes(material.map.file) + " cannot be read");
            }
        }
        if (!entry->second.texels.empty()) result.image = &entry->second;
        return result;
    }

    void draw(const Face& face) {
        const auto corner_of = [&](std::uint32_t i) -> const Corner& { return corners_[face.first + i]; };
        polygon_.clear();
        for (std::uint32_t i = 0; i < face.count; ++i) {
            check(face, corner_of(i).position, mesh_.positions.size(), "vertex");
            if (corner_of(i).texture != none)
                check(face, corner_of(i).texture, coordinates_.size(), "texture coordinate");
            polygon_.push_back(mesh_.positions[corner_of(i).position]);
        }
        const Surface surface = face.material == none ? Surface{} : surfaces_[face.material];
        for (const auto& [a, b, c] : triangulator_(polygon_)) {
            MeshTriangle& triangle = mesh_.triangles.emplace_back();
            const std::array<Corner, 3> corners{corner_of(a), corner_of(b), corner_of(c)};
            std::array<glm::vec3, 3> texels{glm::vec3(1.0f), glm::vec3(1.0f), glm::vec3(1.0f)};
            color_from_texture(surface, corners, texels);
            for (std::size_t k = 0; k < 3; ++k) {
                triangle.corners[k] = corners[k].position;
                triangle.colors[k] = color(surface, corners[k].position, texels[k]);
            }
        }
    }

    void check(const Face& face, std::uint32_t index, std::size_t count, const char* of) const {
        if (index < count) return;
        throw std::runtime_error("line " + std::to_string(face.line) + ": a face names " + of + ' ' +
                                 std::to_string(std::uint64_t{index} + 1) + " of " + std::to_string(count));
    }

    void color_from_texture(const Surface& surface, const std::array<Corner, 3>& corners,
                            std::array<glm::vec3, 3>& texels) const {
        if (!surface.image) return;
        std::array<glm::vec2, 3> uv;
        for (std::size_t k = 0; k < 3; ++k) {
            if (corners[k].texture == none) return;
            uv[k] = coordinates_[corners[k].texture] * surface.map.scale + surface.map.offset;
        }
        const Wrap wrap = surface.map.clamped ? Wrap::clamp : Wrap::repeat;
        const std::array<Rgba8, 3> found = Texture{surface.image, wrap, wrap}.corners(uv);
        for (std::size_t k = 0; k < 3; ++k) {
            texels[k] = glm::vec3(to_vec4(found[k])) * surface.map.gain + surface.map.base;
        }
    }

    /// Material, texture and vertex color multiplied, those that there are. Of files that say nothing all have one
    /// color.
    Rgba8 color(const Surface& surface, std::uint32_t position, const glm::vec3& texel) const {
        const bool has_own = position < colors_.size() && colors_[position].x > uncolored_vertex.x;
        if (!surface.is_known && !has_own) return uncolored;
        glm::vec3 c = surface.is_known ? surface.color * texel : glm::vec3(1.0f);
        if (has_own) c *= colors_[position] * color_scale_;
        return to_rgba8(glm::vec4(c, 1.0f));
    }

    static constexpr glm::vec3 uncolored_vertex{-std::numeric_limits<float>::infinity()};

    Statements statements_;
    Folder folder_;
    std::vector<std::string_view> words_;
    Mesh mesh_;
    std::vector<glm::vec3> colors_;  ///< of the vertices up to the last that has one
    float color_scale_ = 1.0f;       ///< bytes, as soon as there is more than 1
    std::vector<glm::vec2> coordinates_;
    std::vector<Corner> corners_;
    std::vector<Face> faces_;
    std::uint32_t material_ = none;
    std::vector<std::string> uses_;
    std::map<std::string, std::uint32_t> use_of_;
    std::set<std::string> libraries_;
    Materials materials_;
    std::map<std::string, Image> images_;
    std::vector<Surface> surfaces_;
    std::vector<glm::dvec3> polygon_;
    Triangulator triangulator_;
    std::vector<std::string> notes_;
};

}  // namespace

Loaded read_obj(std::string_view text, const std::filesystem::path& folder) {
    if (text.empty()) throw std::runtime_error("is empty");
    return ObjReader(text, folder).read();
}

}  // namespace farfield::scenes::detail
