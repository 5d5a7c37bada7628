// Scenes of glTF 2.0 (Khronos, "glTF 2.0 Specification", 2021; sections are of it): the default scene in the pose of
// its nodes, and of materials what color they have where light falls. Metals, gloss and normal maps are not looked at.
#include <algorithm>
#include <array>
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/quaternion.hpp>
#include <set>

#include "scenes/light.hpp"
#include "scenes/load/gltf_file.hpp"
#include "scenes/load/load_detail.hpp"
#include "scenes/load/mesh.hpp"
#include "scenes/load/texture.hpp"

namespace farfield::scenes::detail {
namespace {

/// A small file can place a large mesh very often; this many are 4.8 GB.
constexpr std::uint64_t most_triangles = 100'000'000;

/// Small files unpack to large images; these are 4 GiB.
constexpr std::uint64_t most_texels = std::uint64_t{1} << 30;

[[noreturn]] void fail(const std::string& where, const std::string& reason) {
    throw std::runtime_error(where + ": " + reason);
}

/// What a picture needs must be among these: what is here read, or what changes no diffuse color.
void check_extensions(const Json& json) {
    static const std::set<std::string_view> known{"EXT_mesh_gpu_instancing",
                                                  "KHR_lights_punctual",
                                                  "KHR_materials_anisotropy",
                                                  "KHR_materials_clearcoat",
                                                  "KHR_materials_emissive_strength",
                                                  "KHR_materials_ior",
                                                  "KHR_materials_iridescence",
                                                  "KHR_materials_pbrSpecularGlossiness",
                                                  "KHR_materials_sheen",
                                                  "KHR_materials_specular",
                                                  "KHR_materials_unlit",
                                                  "KHR_materials_variants",
                                                  "KHR_mesh_quantization",
                                                  "KHR_node_visibility",
                                                  "KHR_texture_transform"};
    for (const Json& name : list(json, "extensionsRequired", "the file")) {
        if (name.is_string() && known.count(name.get_ref<const std::string&>()) == 0) {
            throw std::runtime_error("requires the extension " + in_quotes(name.get_ref<const std::string&>()) +
                                     ", which is not supported");
        }
    }
}

// ---------------------------------------------------------------- materials

/// A texture, and where on it a vertex lies.
struct TextureUse {
    Texture texture;
    std::string set;  ///< "TEXCOORD_1"
    glm::vec2 offset{0.0f}, scale{1.0f};
    float sine = 0.0f, cosine = 1.0f;

    /// glTF has v = 0 at the top row. KHR_texture_transform scales, turns and shifts, in this order; a positive angle
    /// turns counter-clockwise as seen, with v downwards.
    glm::vec2 place(glm::vec2 uv) const {
        uv *= scale;
        const glm::vec2 at = offset + glm::vec2(cosine * uv.x + sine * uv.y, cosine * uv.y - sine * uv.x);
        return {at.x, 1.0f - at.y};
    }
};

enum class Alpha : std::uint8_t { ignored, cut, blended };

/// Factors and vertex colors are linear.
struct Surface {
    glm::vec4 color{1.0f};
    glm::vec3 emission{0.0f};
    std::optional<TextureUse> texture{}, emission_texture{};
    Alpha alpha = Alpha::ignored;
    float cutoff = 0.5f;
    bool lit = true;
};

class Materials {
  public:
    Materials(GltfFile& file, std::set<std::string>& notes) : file_(file), notes_(notes) {}

    /// Of the material that a primitive names.
    const Surface& of(const Json& primitive, const std::string& where) {
        static const Surface plain;
        const auto material = file_.item(primitive, "material", "materials", where);
        if (!material) return plain;
        const auto [entry, is_new] = surfaces_.try_emplace(material->index);
        if (is_new) entry->second = read(*material);
        return entry->second;
    }

  private:
    Surface read(const GltfItem& material) {
        const std::string& where = material.name;
        static const Json none = Json::object();
        Surface surface;
        const Json* const mode = member(material.json, "alphaMode");
        if (mode && *mode == "MASK") surface.alpha = Alpha::cut;
        if (mode && *mode == "BLEND") surface.alpha = Alpha::blended;
        surface.cutoff = static_cast<float>(real(material.json, "alphaCutoff", 0.5, where));
        const Json* const diffuse = extension(material.json, "KHR_materials_pbrSpecularGlossiness");
        const Json* const roughness = member(material.json, "pbrMetallicRoughness");
        const Json& base = diffuse ? *diffuse : roughness ? *roughness : none;
        const auto color = reals<4>(base, diffuse ? "diffuseFactor" : "baseColorFactor", {1, 1, 1, 1}, where);
        for (int i = 0; i < 4; ++i) surface.color[i] = static_cast<float>(color[static_cast<std::size_t>(i)]);
        surface.texture = texture(base, diffuse ? "diffuseTexture" : "baseColorTexture", where);
        if (surface.texture) surface.texture->texture.least_alpha = least_alpha(surface);
        surface.lit = !extension(material.json, "KHR_materials_unlit");
        const auto emission = reals<3>(material.json, "emissiveFactor", {0, 0, 0}, where);
        const Json* const strong = extension(material.json, "KHR_materials_emissive_strength");
        const double strength = strong ? real(*strong, "emissiveStrength", 1.0, where) : 1.0;
        for (int i = 0; i < 3; ++i) {
            surface.emission[i] = static_cast<float>(emission[static_cast<std::size_t>(i)] * strength);
        }
        if (surface.emission != glm::vec3(0.0f) && member(material.json, "emissiveTexture")) {
            surface.emission_texture = texture(material.json, "emissiveTexture", where);
            // Nobody knows what glows if the picture of it is lost: nothing then, rather than all.
            if (!surface.emission_texture) surface.emission = glm::vec3(0.0f);
            if (surface.emission_texture) surface.emission_texture->texture.least_alpha = 0;
        }
        return surface;
    }

    static std::uint8_t least_alpha(const Surface& surface) {
        if (surface.alpha == Alpha::ignored) return 0;
        if (surface.alpha == Alpha::blended) return 1;
        const float least = std::ceil(255.0f * surface.cutoff / surface.color.a);
        return static_cast<std::uint8_t>(least > 0.0f ? std::min(least, 255.0f) : 0.0f);
    }

    std::optional<TextureUse> texture(const Json& parent, const char* name, const std::string& where) {
        const Json* const info = member(parent, name);
        if (!info) return std::nullopt;
        const auto texture = file_.item(*info, "index", "textures", where);
        if (!texture) fail(where, std::string(name) + " has no index");
        const Image* const image = image_of(*texture);
        if (!image) return std::nullopt;
        TextureUse use;
        use.texture.image = image;
        if (const auto sampler = file_.item(texture->json, "sampler", "samplers", texture->name)) {
            use.texture.across = wrap(sampler->json, "wrapS", sampler->name);
            use.texture.up = wrap(sampler->json, "wrapT", sampler->name);
        }
        std::uint64_t set = whole(*info, "texCoord", 0, where);
        if (const Json* const moved = extension(*info, "KHR_texture_transform")) {
            const auto offset = reals<2>(*moved, "offset", {0, 0}, where),
                       scale = reals<2>(*moved, "scale", {1, 1}, where);
            const double angle = real(*moved, "rotation", 0.0, where);
            set = whole(*moved, "texCoord", set, where);
            use.offset = glm::vec2(static_cast<float>(offset[0]), static_cast<float>(offset[1]));
            use.scale = glm::vec2(static_cast<float>(scale[0]), static_cast<float>(scale[1]));
            use.sine = static_cast<float>(std::sin(angle));
            use.cosine = static_cast<float>(std::cos(angle));
        }
        use.set = "TEXCOORD_" + std::to_string(set);
        return use;
    }

    /// Null, with a note, if it cannot be read: the material's color then stands for itself.
    const Image* image_of(const GltfItem& texture) {
        const auto source = file_.item(texture.json, "source", "images", texture.name);
        if (!source) {
            notes_.insert(texture.name +
                          " has no image of a kind that is read (PNG, JPEG, TGA, BMP): drawn without it");
            return nullptr;
        }
        const auto [entry, is_new] = images_.try_emplace(source->index);
        if (is_new) {
            try {
                entry->second = decoded(file_.image(*source));
                texels_ += entry->second.texels.size();
                if (entry->second.texels.empty()) notes_.insert(source->name + " cannot be read: drawn without it");
            } catch (const std::runtime_error& error) {
                notes_.insert(std::string(error.what()) + ": drawn without it");
            }
        }
        if (texels_ > most_texels) throw std::runtime_error("has images of more than 2^30 texels");
        return entry->second.texels.empty() ? nullptr : &entry->second;
    }

    static Wrap wrap(const Json& sampler, const char* name, const std::string& where) {
        switch (whole(sampler, name, 10497, where)) {
            case 10497:
                return Wrap::repeat;
            case 33648:
                return Wrap::mirror;
            case 33071:
                return Wrap::clamp;
            default:
                fail(where, std::string(name) + " is none of 10497, 33648 and 33071");
        }
    }

    GltfFile& file_;
    std::set<std::string>& notes_;
    std::map<std::size_t, Surface> surfaces_;
    std::map<std::size_t, Image> images_;
    std::uint64_t texels_ = 0;  ///< of all images
};

// ---------------------------------------------------------------- meshes

/// The triangles of a primitive, before any node places them.
struct Primitive {
    std::string mesh;                                   ///< its name in messages
    std::vector<std::uint32_t> vertices;                ///< those that triangles name, of many that several may share
    std::vector<std::array<std::uint32_t, 3>> corners;  ///< into `vertices`
    std::vector<std::array<Rgba8, 3>> colors;
    std::vector<std::array<glm::vec3, 3>> emission;  ///< linear; empty if there is none
    bool lit = true;
    GltfAccessor positions;
    std::vector<std::optional<GltfAccessor>> morphs;      ///< what each target adds to positions
    std::vector<std::array<GltfAccessor, 2>> influences;  ///< four joints and their weights each
};

class Meshes {
  public:
    Meshes(GltfFile& file, std::set<std::string>& notes) : file_(file), materials_(file, notes), notes_(notes) {}

    /// Those of one mesh. `room` is how many more triangles there may be.
    const std::vector<Primitive>& of(const GltfItem& mesh, std::uint64_t room) {
        const auto [entry, is_new] = meshes_.try_emplace(mesh.index);
        if (is_new) {
            for (const Json& primitive : list(mesh.json, "primitives", mesh.name)) {
                entry->second.push_back(read(primitive, mesh.name, room));
                room -= std::min<std::uint64_t>(room, entry->second.back().corners.size());
            }
        }
        return entry->second;
    }

    std::uint64_t points() const { return points_; }
    std::uint64_t lines() const { return lines_; }

  private:
    /// What a primitive's attributes say of a vertex.
    std::optional<GltfAccessor> attribute(const Json& attributes, const std::string& name, std::size_t least,
                                          std::size_t most, const Primitive& primitive) {
        const auto found = file_.accessor(attributes, name.c_str(), primitive.mesh);
        if (!found) return std::nullopt;
        if (found->components() < least || found->components() > most) fail(primitive.mesh, name + " has a wrong type");
        if (found->count() < primitive.positions.count()) {
            fail(primitive.mesh, name + " has " + std::to_string(found->count()) + " elements for " +
                                     std::to_string(primitive.positions.count()) + " vertices");
        }
        return found;
    }

    Primitive read(const Json& json, const std::string& mesh, std::uint64_t room) {
        Primitive result;
        result.mesh = mesh;
        static const Json none = Json::object();
        const Json* const attributes = member(json, "attributes");
        const auto positions = file_.accessor(attributes ? *attributes : none, "POSITION", mesh);
        if (!positions) return result;  // section 3.7.2.1: of no meaning without an extension
        if (positions->components() != 3) fail(mesh, "POSITION has a wrong type");
        const Json* const accessor = &file_.item(*attributes, "POSITION", "accessors", mesh)->json;
        if (extension(json, "KHR_draco_mesh_compression") && !member(*accessor, "bufferView")) {
            fail(mesh, "is compressed (KHR_draco_mesh_compression), which is not supported");
        }
        result.positions = *positions;
        const auto indices = file_.accessor(json, "indices", mesh);
        if (indices && !indices->is_index()) fail(mesh, "indices have a wrong type");
        find_triangles(result, whole(json, "mode", 4, mesh), indices ? &*indices : nullptr, room);
        if (result.corners.empty()) return result;
        read_motion(result, json, *attributes);
        color(result, materials_.of(json, mesh), *attributes);
        return result;
    }

    /// Sections 3.7.2.1 and, for strips and fans, figure 11 there.
    void find_triangles(Primitive& primitive, std::uint64_t mode, const GltfAccessor* indices, std::uint64_t room) {
        const std::uint64_t n = indices ? indices->count() : primitive.positions.count();
        if (mode > 6) fail(primitive.mesh, "mode is none of 0 to 6");
        if (mode == 0) points_ += n;
        if (mode == 1) lines_ += n / 2;
        if (mode == 2) lines_ += n;
        if (mode == 3) lines_ += n > 0 ? n - 1 : 0;
        if (mode < 4) return;
        const std::uint64_t count = mode == 4 ? n / 3 : n - std::min<std::uint64_t>(n, 2);
        if (mode == 4 && n % 3 != 0) notes_.insert("a list of triangles ends within one, which is left out");
        if (count > room)
            throw std::runtime_error("more than 100,000,000 triangles, with every instance of its meshes");
        constexpr std::uint32_t unused = ~std::uint32_t{0};
        if (slots_.size() < primitive.positions.count()) slots_.resize(primitive.positions.count(), unused);
        primitive.corners.reserve(count);
        std::uint64_t out_of_range = 0;
        for (std::uint64_t t = 0; t < count; ++t) {
            std::array<std::uint64_t, 3> corners{3 * t, 3 * t + 1, 3 * t + 2};
            if (mode == 5) corners = {t, t + 1 + t % 2, t + 2 - t % 2};
            if (mode == 6) corners = {t + 1, t + 2, 0};
            if (indices) {
                for (std::uint64_t& corner : corners) corner = indices->index(corner);
            }
            const std::uint64_t vertices = primitive.positions.count();
            if (corners[0] >= vertices || corners[1] >= vertices || corners[2] >= vertices) {
                ++out_of_range;
                continue;
            }
            auto& triangle = primitive.corners.emplace_back();
            for (std::size_t k = 0; k < 3; ++k) {
                std::uint32_t& slot = slots_[corners[k]];
                if (slot == unused) {
                    slot = static_cast<std::uint32_t>(primitive.vertices.size());
                    primitive.vertices.push_back(static_cast<std::uint32_t>(corners[k]));
                }
                triangle[k] = slot;
            }
        }
        for (const std::uint32_t vertex : primitive.vertices) slots_[vertex] = unused;
        if (out_of_range > 0) {
            fail(primitive.mesh, std::to_string(out_of_range) + " of " + std::to_string(count) +
                                     " triangles name vertices out of range");
        }
    }

    /// Morph targets (section 3.7.2.2) and skins (3.7.3.3).
    void read_motion(Primitive& primitive, const Json& json, const Json& attributes) {
        for (const Json& target : list(json, "targets", primitive.mesh)) {
            primitive.morphs.push_back(attribute(target, "POSITION", 3, 3, primitive));
            for (const auto& [name, unused] : target.items()) {
                if (name.substr(0, 6) == "COLOR_" || name.substr(0, 9) == "TEXCOORD_") {
                    notes_.insert("a morph target changes " + name + ", which is not done");
                }
            }
        }
        for (std::size_t set = 0;; ++set) {
            const std::string number = std::to_string(set);
            const auto joints = attribute(attributes, "JOINTS_" + number, 4, 4, primitive);
            const auto weights = attribute(attributes, "WEIGHTS_" + number, 4, 4, primitive);
            if (!joints || !weights) break;
            primitive.influences.push_back({*joints, *weights});
        }
    }

    /// Colors of corners; what a cut material cuts away is gone after this.
    void color(Primitive& primitive, const Surface& surface, const Json& attributes) {
        const auto colors = attribute(attributes, "COLOR_0", 3, 4, primitive);
        const auto coordinates = [&](const std::optional<TextureUse>& use) {
            auto found = use ? attribute(attributes, use->set, 2, 2, primitive) : std::nullopt;
            if (use && !found)
                notes_.insert("a mesh without " + use->set + " is drawn without the texture that asks for it");
            return found;
        };
        const auto texels = [&](const TextureUse& use, const GltfAccessor& uv,
                                const std::array<std::uint32_t, 3>& corners) {
            std::array<glm::vec2, 3> places;
            for (std::size_t k = 0; k < 3; ++k) {
                const std::uint32_t vertex = primitive.vertices[corners[k]];
                places[k] =
                    use.place({static_cast<float>(uv.number(vertex, 0)), static_cast<float>(uv.number(vertex, 1))});
            }
            return use.texture.corners(places);
        };
        const auto uv = coordinates(surface.texture), emission_uv = coordinates(surface.emission_texture);
        const bool emits = surface.emission != glm::vec3(0.0f) && (emission_uv || !surface.emission_texture);
        primitive.lit = surface.lit;
        primitive.colors.reserve(primitive.corners.size());
        std::size_t kept = 0;
        for (const std::array<std::uint32_t, 3> corners : primitive.corners) {
            std::array<Rgba8, 3> texel{}, result{};
            if (uv) texel = texels(*surface.texture, *uv, corners);
            bool seen = surface.alpha != Alpha::cut;
            for (std::size_t k = 0; k < 3; ++k) {
                glm::vec4 c = surface.color;
                for (std::size_t i = 0; colors && i < colors->components(); ++i) {
                    c[static_cast<int>(i)] *= static_cast<float>(colors->number(primitive.vertices[corners[k]], i));
                }
                if (uv) c *= glm::vec4(linear_color(texel[k]), static_cast<float>(texel[k].a) / 255.0f);
                seen |= c.a >= surface.cutoff;
                result[k] = display_color(glm::vec3(c));
                if (surface.alpha == Alpha::blended) result[k].a = to_rgba8({0.0f, 0.0f, 0.0f, c.a}).a;
            }
            if (!seen) continue;
            primitive.corners[kept++] = corners;
            primitive.colors.push_back(result);
            if (!emits) continue;
            auto& emission = primitive.emission.emplace_back();
            emission.fill(surface.emission);
            if (!emission_uv) continue;
            texel = texels(*surface.emission_texture, *emission_uv, corners);
            for (std::size_t k = 0; k < 3; ++k) emission[k] *= linear_color(texel[k]);
        }
        primitive.corners.resize(kept);
    }

    GltfFile& file_;
    Materials materials_;
    std::set<std::string>& notes_;
    std::map<std::size_t, std::vector<Primitive>> meshes_;
    std::vector<std::uint32_t>
        slots_;  ///< by vertex; kept, since many primitives may share one large array of vertices
    std::uint64_t points_ = 0, lines_ = 0;
};

// ---------------------------------------------------------------- nodes

glm::dmat4 turned_and_scaled(const std::array<double, 3>& t, const std::array<double, 4>& r,
                             const std::array<double, 3>& s) {
    return glm::translate(glm::dmat4(1.0), {t[0], t[1], t[2]}) * glm::mat4_cast(glm::dquat(r[3], r[0], r[1], r[2])) *
           glm::scale(glm::dmat4(1.0), {s[0], s[1], s[2]});
}

glm::dmat4 to_parent(const Json& node, const std::string& where) {
    if (member(node, "matrix")) {
        const auto m = reals<16>(node, "matrix", {}, where);
        glm::dmat4 result;
        for (int i = 0; i < 16; ++i) result[i / 4][i % 4] = m[static_cast<std::size_t>(i)];
        return result;
    }
    return turned_and_scaled(reals<3>(node, "translation", {0, 0, 0}, where),
                             reals<4>(node, "rotation", {0, 0, 0, 1}, where),
                             reals<3>(node, "scale", {1, 1, 1}, where));
}

/// Every node has at most one parent and none is its own ancestor (section 3.5.2), which with one parent each is the
/// same as: every node is reached from one that has no parent.
class Nodes {
  public:
    explicit Nodes(const GltfFile& file) : to_world(file.count("nodes")), children_(to_world.size()) {
        const Json& nodes = list(file.json(), "nodes", "the file");
        std::vector<char> has_parent(to_world.size(), 0);
        for (std::size_t n = 0; n < nodes.size(); ++n) {
            const std::string where = "node " + std::to_string(n);
            for (const Json& child : list(nodes[n], "children", where)) {
                const GltfItem found = file.item(child, "nodes", where);
                if (has_parent[found.index]) throw std::runtime_error(found.name + " has more than one parent");
                has_parent[found.index] = 1;
                children_[n].push_back(found.index);
            }
            to_world[n] = to_parent(nodes[n], where);
        }
        std::vector<std::size_t> pending;
        for (std::size_t n = nodes.size(); n-- > 0;) {
            if (!has_parent[n]) pending.push_back(n);
        }
        roots.assign(pending.rbegin(), pending.rend());
        std::size_t reached = 0;
        while (!pending.empty()) {
            const std::size_t node = pending.back();
            pending.pop_back();
            ++reached;
            for (const std::size_t child : children_[node]) {
                to_world[child] = to_world[node] * to_world[child];
                pending.push_back(child);
            }
        }
        if (reached < nodes.size()) throw std::runtime_error("nodes contain themselves");
    }

    const std::vector<std::size_t>& children(std::size_t node) const { return children_[node]; }

    std::vector<glm::dmat4> to_world;
    std::vector<std::size_t> roots;  ///< in the order of the file

  private:
    std::vector<std::vector<std::size_t>> children_;
};

// ---------------------------------------------------------------- the scene

class Collector {
  public:
    Collector(const std::string& bytes, const std::filesystem::path& folder)
        : file_(bytes, folder), meshes_(file_, notes_) {}

    Loaded collected(const LoadOptions& options) {
        check_extensions(file_.json());
        const Nodes nodes(file_);
        if (file_.count("meshes") == 0) throw std::runtime_error("has no meshes");
        std::vector<std::size_t> pending = roots_of_default_scene(nodes);
        std::reverse(pending.begin(), pending.end());
        while (!pending.empty()) {
            const std::size_t node = pending.back();
            pending.pop_back();
            const GltfItem item = file_.item(node, "nodes", "the scene");
            const Json* const visibility = extension(item.json, "KHR_node_visibility");
            const Json* const visible = visibility ? member(*visibility, "visible") : nullptr;
            if (visible && *visible == false) continue;
            add_node(item, nodes);
            // The first child is to be next.
            pending.insert(pending.end(), nodes.children(node).rbegin(), nodes.children(node).rend());
        }
        if (mesh_.triangles.empty()) {
            const bool others = meshes_.points() + meshes_.lines() > 0;
            throw std::runtime_error(others ? "has points and lines only, which are not drawn" : "has no triangles");
        }
        Loaded loaded = in_single_precision(mesh_);
        put_light(loaded.triangles, options);
        loaded.lit = true;
        if (meshes_.points() > 0) notes_.insert("points left out: " + std::to_string(meshes_.points()));
        if (meshes_.lines() > 0) notes_.insert("lines left out: " + std::to_string(meshes_.lines()));
        loaded.notes.assign(notes_.begin(), notes_.end());
        return loaded;
    }

  private:
    std::vector<std::size_t> roots_of_default_scene(const Nodes& nodes) {
        const std::size_t scenes = file_.count("scenes");
        if (scenes == 0) return nodes.roots;  // section 3.5.1: a library of parts
        const auto named = file_.item(file_.json(), "scene", "scenes", "the file");
        const GltfItem scene = named ? *named : file_.item(0, "scenes", "the file");
        if (scenes > 1) {
            notes_.insert("the default one of " + std::to_string(scenes) + " scenes is drawn");
        }
        std::vector<std::size_t> result;
        std::set<std::size_t> seen;
        for (const Json& node : list(scene.json, "nodes", scene.name)) {
            const GltfItem root = file_.item(node, "nodes", scene.name);
            if (!std::binary_search(nodes.roots.begin(), nodes.roots.end(), root.index)) {
                fail(scene.name, "names " + root.name + ", which is the child of another");
            }
            if (!seen.insert(root.index).second) fail(scene.name, "names " + root.name + " twice");
            result.push_back(root.index);
        }
        return result;
    }

    void add_node(const GltfItem& node, const Nodes& nodes) {
        const auto mesh = file_.item(node.json, "mesh", "meshes", node.name);
        if (!mesh) return;
        const std::vector<glm::dmat4>* joints = nullptr;
        if (const auto skin = file_.item(node.json, "skin", "skins", node.name)) joints = &joints_of(*skin, nodes);
        std::vector<double> weights;
        const bool own = member(node.json, "weights") != nullptr;
        for (const Json& weight : list(own ? node.json : mesh->json, "weights", own ? node.name : mesh->name)) {
            if (!weight.is_number()) fail(own ? node.name : mesh->name, "weights has something that is not a number");
            weights.push_back(weight.get<double>());
        }
        const glm::dmat4& to_world = nodes.to_world[node.index];
        for (const Primitive& primitive : meshes_.of(*mesh, most_triangles - mesh_.triangles.size())) {
            if (primitive.corners.empty()) continue;
            if (const Json* const instancing = extension(node.json, "EXT_mesh_gpu_instancing")) {
                add_instances(*instancing, node.name, primitive, to_world, joints, weights);
            } else {
                add(primitive, to_world, joints, weights);
            }
        }
    }

    void add_instances(const Json& instancing, const std::string& where, const Primitive& primitive,
                       const glm::dmat4& to_world, const std::vector<glm::dmat4>* joints,
                       const std::vector<double>& weights) {
        static const Json none = Json::object();
        const Json* const found = member(instancing, "attributes");
        const Json& attributes = found ? *found : none;
        const auto t = file_.accessor(attributes, "TRANSLATION", where),
                   r = file_.accessor(attributes, "ROTATION", where), s = file_.accessor(attributes, "SCALE", where);
        std::uint64_t count = 0;
        for (const auto& [accessor, components] : {std::pair(&t, 3u), std::pair(&r, 4u), std::pair(&s, 3u)}) {
            if (!*accessor) continue;
            if ((*accessor)->components() != components || (count > 0 && (*accessor)->count() != count)) {
                fail(where, "EXT_mesh_gpu_instancing has attributes that do not fit each other");
            }
            count = (*accessor)->count();
        }
        const auto value = [&](const std::optional<GltfAccessor>& from, std::uint64_t i, std::size_t k,
                               double otherwise) { return from ? from->number(i, k) : otherwise; };
        for (std::uint64_t i = 0; i < count; ++i) {
            add(primitive,
                to_world *
                    turned_and_scaled({value(t, i, 0, 0), value(t, i, 1, 0), value(t, i, 2, 0)},
                                      {value(r, i, 0, 0), value(r, i, 1, 0), value(r, i, 2, 0), value(r, i, 3, 1)},
                                      {value(s, i, 0, 1), value(s, i, 1, 1), value(s, i, 2, 1)}),
                joints, weights);
        }
    }

    /// Section 3.7.3.3: the transforms of the joints, from where the vertices are in the bind pose. What places the
    /// node that has the skin has no say.
    const std::vector<glm::dmat4>& joints_of(const GltfItem& skin, const Nodes& nodes) {
        const auto [entry, is_new] = joints_.try_emplace(skin.index);
        if (!is_new) return entry->second;
        const auto inverse = file_.accessor(skin.json, "inverseBindMatrices", skin.name);
        const Json& joints = list(skin.json, "joints", skin.name);
        if (joints.empty()) fail(skin.name, "has no joints");
        if (inverse && (inverse->components() != 16 || inverse->count() < joints.size())) {
            fail(skin.name, "has not a matrix for every joint");
        }
        for (std::size_t j = 0; j < joints.size(); ++j) {
            glm::dmat4 bound = nodes.to_world[file_.item(joints[j], "nodes", skin.name).index];
            if (inverse) {
                glm::dmat4 m;
                for (int i = 0; i < 16; ++i) m[i / 4][i % 4] = inverse->number(j, static_cast<std::size_t>(i));
                bound *= m;
            }
            entry->second.push_back(bound);
        }
        return entry->second;
    }

    /// The joints' mean, weighted; weights that were rounded need not have the sum of 1.
    static glm::dmat4 blended(const Primitive& primitive, std::uint32_t vertex, const std::vector<glm::dmat4>& joints) {
        glm::dmat4 sum(0.0);
        double all = 0;
        for (const auto& [which, weights] : primitive.influences) {
            for (std::size_t k = 0; k < 4; ++k) {
                const double weight = weights.number(vertex, k), joint = which.number(vertex, k);
                if (weight == 0) continue;
                if (!(joint >= 0 && joint < static_cast<double>(joints.size()))) {
                    fail(primitive.mesh, "vertex " + std::to_string(vertex) + " names a joint that does not exist");
                }
                sum += joints[static_cast<std::size_t>(joint)] * weight;
                all += weight;
            }
        }
        if (!(all > 0)) fail(primitive.mesh, "vertex " + std::to_string(vertex) + " has no weights");
        return sum * (1.0 / all);
    }

    void add(const Primitive& primitive, const glm::dmat4& to_world, const std::vector<glm::dmat4>* joints,
             const std::vector<double>& weights) {
        if (primitive.corners.size() > most_triangles - mesh_.triangles.size()) {
            throw std::runtime_error("more than 100,000,000 triangles, with every instance of its meshes");
        }
        const std::size_t first = mesh_.triangles.size();
        const auto base = static_cast<std::uint32_t>(mesh_.positions.size());
        const bool skinned = joints && !primitive.influences.empty();
        mirrored_.clear();
        for (const std::uint32_t vertex : primitive.vertices) {
            glm::dvec3 p(primitive.positions.number(vertex, 0), primitive.positions.number(vertex, 1),
                         primitive.positions.number(vertex, 2));
            for (std::size_t m = 0; m < std::min(weights.size(), primitive.morphs.size()); ++m) {
                if (weights[m] == 0 || !primitive.morphs[m]) continue;
                for (int i = 0; i < 3; ++i) {
                    p[i] += weights[m] * primitive.morphs[m]->number(vertex, static_cast<std::size_t>(i));
                }
            }
            const glm::dmat4 matrix = skinned ? blended(primitive, vertex, *joints) : to_world;
            p = glm::dvec3(matrix * glm::dvec4(p, 1.0));
            if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z)) {
                fail(primitive.mesh, "vertex " + std::to_string(vertex) + " is not finite");
            }
            mesh_.positions.push_back(p);
            mirrored_.push_back(glm::determinant(glm::dmat3(matrix)) < 0);
        }
        for (std::size_t t = 0; t < primitive.corners.size(); ++t) {
            const auto& corners = primitive.corners[t];
            // Section 3.7.4: turns fronts into backs, and back again here.
            const std::array<std::size_t, 3> order =
                mirrored_[corners[0]] ? std::array<std::size_t, 3>{0, 2, 1} : std::array<std::size_t, 3>{0, 1, 2};
            MeshTriangle& triangle = mesh_.triangles.emplace_back();
            for (std::size_t k = 0; k < 3; ++k) {
                triangle.corners[k] = base + corners[order[k]];
                triangle.colors[k] = primitive.colors[t][order[k]];
            }
            if (primitive.emission.empty()) continue;
            const auto& emission = primitive.emission[t];
            glows_.push_back({first + t, {emission[order[0]], emission[order[1]], emission[order[2]]}});
        }
        if (!primitive.lit) unlit_.push_back({first, mesh_.triangles.size()});
    }

    void put_light(Triangles& triangles, const LoadOptions& options) const {
        std::size_t done = 0;
        const auto put = [&](std::size_t end) {
            for (; done < end && options.bake_light; ++done) bake_light(triangles[done], options.up);
        };
        for (const auto& [begin, end] : unlit_) {
            put(begin);
            done = end;
        }
        put(triangles.size());
        for (const Glow& glow : glows_) {
            for (std::size_t k = 0; k < 3; ++k) {
                Rgba8& rgba = triangles[glow.triangle].rgba[k];
                const std::uint8_t alpha = rgba.a;
                rgba = display_color(linear_color(rgba) + glow.emission[k]);
                rgba.a = alpha;
            }
        }
    }

    struct Glow {
        std::size_t triangle;
        std::array<glm::vec3, 3> emission;
    };

    std::set<std::string> notes_;
    GltfFile file_;
    Meshes meshes_;
    std::map<std::size_t, std::vector<glm::dmat4>> joints_;
    Mesh mesh_;
    std::vector<Glow> glows_;
    std::vector<std::pair<std::size_t, std::size_t>> unlit_;  ///< ranges of triangles that are as bright as they are
    std::vector<char> mirrored_;                              ///< of the primitive that is added, by vertex
};

}  // namespace

Loaded read_gltf(const std::string& bytes, const std::filesystem::path& folder, const LoadOptions& options) {
    return Collector(bytes, folder).collected(options);
}

}  // namespace farfield::scenes::detail
