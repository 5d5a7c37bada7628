// Assimp 5.2 follows glTF nodes that contain themselves until the stack ends, and reads some counts and
// indices unchecked. So what the glTF 2.0 specification promises about them is checked here first.
#include <algorithm>
#include <array>
#include <cstring>

#include "scenes/load/json.hpp"
#include "scenes/load/load_detail.hpp"

namespace farfield::scenes::detail {
namespace {

/// Deeper than any model is; assimp recurses once a level.
constexpr std::size_t deepest = 500;

std::string named(std::string_view kind, std::size_t index) {
    return std::string(kind) + ' ' + std::to_string(index);
}

/// A whole number that is not negative; `otherwise` if there is none of that name.
std::uint64_t whole(const Json& parent, std::string_view name, std::uint64_t otherwise, const std::string& where) {
    const Json* member = parent.find(name);
    if (!member) return otherwise;
    const double* n = member->number();
    if (!n || !(*n >= 0) || *n > 9e15 || *n != std::floor(*n)) {
        throw std::runtime_error(where + ": " + std::string(name) + " is not a count");
    }
    return static_cast<std::uint64_t>(*n);
}

void check_index(const Json& index, std::size_t count, const std::string& where, std::string_view kind) {
    const double* n = index.number();
    if (!n || !(*n >= 0) || *n >= static_cast<double>(count) || *n != std::floor(*n)) {
        throw std::runtime_error(where + " names a " + std::string(kind) + " that does not exist");
    }
}

void check_member(const Json& parent, std::string_view name, std::size_t count, const std::string& where,
                  std::string_view kind) {
    if (const Json* index = parent.find(name)) check_index(*index, count, where, kind);
}

struct Container {
    Json json;
    std::uint64_t binary_bytes = 0;  // of the GLB chunk that is buffer 0
    bool has_binary = false;
};

std::uint32_t little_endian(std::string_view bytes, std::size_t at) {
    std::uint32_t value = 0;
    for (std::size_t i = 4; i-- > 0;) value = value << 8 | static_cast<unsigned char>(bytes[at + i]);
    return value;
}

Container opened(std::string_view bytes) {
    Container result;
    if (bytes.substr(0, 4) != "glTF") {
        if (trimmed(bytes).empty()) throw std::runtime_error("is empty");
        result.json = parse_json(bytes);
        return result;
    }
    if (bytes.size() < 20) throw std::runtime_error("ends within its header");
    if (little_endian(bytes, 4) != 2) throw std::runtime_error("is not glTF version 2");
    const std::uint64_t length = little_endian(bytes, 8);
    const std::uint64_t json_bytes = little_endian(bytes, 12);
    if (length > bytes.size()) {
        throw std::runtime_error("claims " + std::to_string(length) + " bytes, but has " +
                                 std::to_string(bytes.size()));
    }
    if (bytes.substr(16, 4) != "JSON" || json_bytes > length - std::min<std::uint64_t>(length, 20)) {
        throw std::runtime_error("byte 12: no JSON chunk that fits the file");
    }
    result.json = parse_json(bytes.substr(20, static_cast<std::size_t>(json_bytes)));
    const std::uint64_t next = 20 + json_bytes;
    if (length >= next + 8) {
        result.binary_bytes = little_endian(bytes, static_cast<std::size_t>(next));
        result.has_binary = true;
        if (result.binary_bytes > length - next - 8) {
            throw std::runtime_error("byte " + std::to_string(next) + ": a chunk longer than the file");
        }
    }
    return result;
}

std::string unescaped_uri(std::string_view uri) {
    std::string result;
    for (std::size_t i = 0; i < uri.size(); ++i) {
        unsigned code = 0;
        if (uri[i] == '%' && i + 2 < uri.size() &&
            std::from_chars(uri.data() + i + 1, uri.data() + i + 3, code, 16).ptr == uri.data() + i + 3) {
            result.push_back(static_cast<char>(code));
            i += 2;
        } else {
            result.push_back(uri[i]);
        }
    }
    return result;
}

std::uint64_t bytes_there(const Json& buffer, std::size_t index, const Container& container,
                          const std::filesystem::path& folder) {
    const Json* uri = buffer.find("uri");
    if (!uri) {
        if (index == 0 && container.has_binary) return container.binary_bytes;
        throw std::runtime_error(named("buffer", index) + " has no data");
    }
    if (!uri->string()) throw std::runtime_error(named("buffer", index) + ": uri is not a string");
    const std::string& text = *uri->string();
    if (text.substr(0, 5) == "data:") {
        const std::size_t comma = text.find(',');
        if (comma == std::string::npos) throw std::runtime_error(named("buffer", index) + ": broken data uri");
        const std::size_t padding = static_cast<std::size_t>(std::count(
            text.end() - std::min<std::ptrdiff_t>(2, static_cast<std::ptrdiff_t>(text.size())), text.end(), '='));
        return (text.size() - comma - 1) / 4 * 3 - std::min<std::size_t>(padding, (text.size() - comma - 1) / 4 * 3);
    }
    std::error_code error;
    const std::uint64_t size = std::filesystem::file_size(folder / unescaped_uri(text), error);
    if (error) throw std::runtime_error(named("buffer", index) + ": cannot read " + in_quotes(text));
    return size;
}

std::vector<std::uint64_t> check_buffers(const Container& container, const std::filesystem::path& folder) {
    std::vector<std::uint64_t> sizes;
    for (const Json& buffer : container.json.list("buffers")) {
        const std::string where = named("buffer", sizes.size());
        const std::uint64_t claimed = whole(buffer, "byteLength", 0, where);
        const std::uint64_t there = bytes_there(buffer, sizes.size(), container, folder);
        if (claimed > there) {
            throw std::runtime_error(where + " claims " + std::to_string(claimed) + " bytes, but there are " +
                                     std::to_string(there));
        }
        sizes.push_back(claimed);
    }
    return sizes;
}

/// Bytes of one element; 0 if unknown.
std::uint64_t element_bytes(const Json& accessor, const std::string& where) {
    constexpr std::array<std::pair<std::string_view, std::uint64_t>, 7> types{
        {{"SCALAR", 1}, {"VEC2", 2}, {"VEC3", 3}, {"VEC4", 4}, {"MAT2", 4}, {"MAT3", 9}, {"MAT4", 16}}};
    const Json* type = accessor.find("type");
    for (const auto& [name, components] : types) {
        if (!type || !type->string() || *type->string() != name) continue;
        switch (whole(accessor, "componentType", 0, where)) {
            case 5120:
            case 5121:
                return components;
            case 5122:
            case 5123:
                return 2 * components;
            case 5125:
            case 5126:
                return 4 * components;
            default:
                break;
        }
    }
    throw std::runtime_error(where + " has an unknown type");
}

struct View {
    std::uint64_t bytes, stride;
};

void check_range(const std::vector<View>& views, const Json& holder, std::uint64_t count, std::uint64_t size,
                 const std::string& where) {
    check_member(holder, "bufferView", views.size(), where, "bufferView");
    const View& view = views[static_cast<std::size_t>(whole(holder, "bufferView", 0, where))];
    const std::uint64_t offset = whole(holder, "byteOffset", 0, where);
    const std::uint64_t stride = std::max(view.stride, view.stride == 0 ? size : std::uint64_t{1});
    const std::uint64_t room = view.bytes - std::min(view.bytes, offset);
    if (count > 0 && (room < size || count - 1 > (room - size) / stride)) {
        throw std::runtime_error(where + " claims " + std::to_string(count) + " elements, more than its buffer has");
    }
}

void check_accessors(const Json& json, const std::vector<std::uint64_t>& buffers) {
    std::vector<View> views;
    std::uint64_t all_bytes = 0;
    for (const std::uint64_t bytes : buffers) all_bytes += bytes;
    for (const Json& view : json.list("bufferViews")) {
        const std::string where = named("bufferView", views.size());
        if (!view.find("buffer")) throw std::runtime_error(where + " has no buffer");
        check_member(view, "buffer", buffers.size(), where, "buffer");
        const std::uint64_t size = buffers[static_cast<std::size_t>(whole(view, "buffer", 0, where))];
        const std::uint64_t offset = whole(view, "byteOffset", 0, where);
        const std::uint64_t length = whole(view, "byteLength", 0, where);
        if (offset > size || length > size - offset) throw std::runtime_error(where + " reaches beyond its buffer");
        views.push_back({length, whole(view, "byteStride", 0, where)});
    }
    std::size_t a = 0;
    for (const Json& accessor : json.list("accessors")) {
        const std::string where = named("accessor", a++);
        const std::uint64_t size = element_bytes(accessor, where);
        const std::uint64_t count = whole(accessor, "count", 0, where);
        if (accessor.find("bufferView")) {
            check_range(views, accessor, count, size, where);
        } else if (count > all_bytes) {
            // Legal as all zeros; but not for more elements than the file has bytes.
            throw std::runtime_error(where + " claims " + std::to_string(count) + " elements without data");
        }
        if (const Json* sparse = accessor.find("sparse")) {
            const std::uint64_t sparse_count = whole(*sparse, "count", 0, where);
            const Json* indices = sparse->find("indices");
            const Json* values = sparse->find("values");
            if (!indices || !values || sparse_count > count) throw std::runtime_error(where + ": broken sparse data");
            check_range(views, *indices, sparse_count, 1, where);
            check_range(views, *values, sparse_count, size, where);
        }
    }
    std::size_t i = 0;
    for (const Json& image : json.list("images")) {
        check_member(image, "bufferView", views.size(), named("image", i++), "bufferView");
    }
}

void check_meshes(const Json& json) {
    const std::size_t accessors = json.list("accessors").size();
    std::size_t m = 0;
    for (const Json& mesh : json.list("meshes")) {
        const std::string where = named("mesh", m++);
        for (const Json& primitive : mesh.list("primitives")) {
            check_member(primitive, "indices", accessors, where, "accessor");
            check_member(primitive, "material", json.list("materials").size(), where, "material");
            std::vector<const Json*> attribute_sets;
            if (const Json* attributes = primitive.find("attributes")) attribute_sets.push_back(attributes);
            for (const Json& target : primitive.list("targets")) attribute_sets.push_back(&target);
            for (const Json* set : attribute_sets) {
                if (!set->object()) throw std::runtime_error(where + ": attributes are not an object");
                for (const auto& [name, index] : *set->object()) check_index(index, accessors, where, "accessor");
            }
        }
    }
}

/// Triangles that the meshes, each once, must give.
std::uint64_t triangles_in_meshes(const Json& json) {
    const Json::Array& accessors = json.list("accessors");
    std::uint64_t sum = 0;
    for (const Json& mesh : json.list("meshes")) {
        for (const Json& primitive : mesh.list("primitives")) {
            const Json* attributes = primitive.find("attributes");
            const Json* positions = attributes ? attributes->find("POSITION") : nullptr;
            if (!positions) continue;
            const Json* indices = primitive.find("indices");
            const double index = *(indices ? indices : positions)->number();
            const std::uint64_t count = whole(accessors[static_cast<std::size_t>(index)], "count", 0, "accessor");
            switch (whole(primitive, "mode", 4, "primitive")) {
                case 4:
                    sum += count / 3;
                    break;
                case 5:
                case 6:
                    sum += count < 3 ? 0 : count - 2;
                    break;
                default:
                    break;  // points and lines
            }
        }
    }
    return sum;
}

/// Every node has at most one parent and none is its own ancestor (section 3.5.2), which with one parent each
/// is the same as: every node is reached from one that has no parent.
void check_nodes(const Json& json) {
    const Json::Array& nodes = json.list("nodes");
    std::vector<char> has_parent(nodes.size(), 0);
    for (std::size_t n = 0; n < nodes.size(); ++n) {
        const std::string where = named("node", n);
        check_member(nodes[n], "mesh", json.list("meshes").size(), where, "mesh");
        check_member(nodes[n], "skin", json.list("skins").size(), where, "skin");
        check_member(nodes[n], "camera", json.list("cameras").size(), where, "camera");
        for (const Json& child : nodes[n].list("children")) {
            check_index(child, nodes.size(), where, "node");
            char& parent = has_parent[static_cast<std::size_t>(*child.number())];
            if (parent)
                throw std::runtime_error(named("node", static_cast<std::size_t>(*child.number())) +
                                         " has more than one parent");
            parent = 1;
        }
    }
    std::vector<std::pair<std::size_t, std::size_t>> pending;  // node, depth
    std::size_t reached = 0;
    for (std::size_t n = 0; n < nodes.size(); ++n) {
        if (!has_parent[n]) pending.push_back({n, 1});
    }
    while (!pending.empty()) {
        const auto [node, depth] = pending.back();
        pending.pop_back();
        ++reached;
        if (depth > deepest) throw std::runtime_error("nodes are nested more than 500 deep");
        for (const Json& child : nodes[node].list("children")) {
            pending.push_back({static_cast<std::size_t>(*child.number()), depth + 1});
        }
    }
    if (reached < nodes.size()) throw std::runtime_error("nodes contain themselves");
    std::size_t s = 0;
    for (const Json& scene : json.list("scenes")) {
        const std::string where = named("scene", s++);
        for (const Json& node : scene.list("nodes")) check_index(node, nodes.size(), where, "node");
    }
    check_member(json, "scene", json.list("scenes").size(), "the file", "scene");
}

void check_materials(const Json& json) {
    const std::size_t textures = json.list("textures").size();
    std::size_t t = 0;
    for (const Json& texture : json.list("textures")) {
        const std::string where = named("texture", t++);
        check_member(texture, "source", json.list("images").size(), where, "image");
        check_member(texture, "sampler", json.list("samplers").size(), where, "sampler");
    }
    std::size_t m = 0;
    for (const Json& material : json.list("materials")) {
        const std::string where = named("material", m++);
        for (const std::string_view name : {"normalTexture", "occlusionTexture", "emissiveTexture"}) {
            if (const Json* texture = material.find(name)) check_member(*texture, "index", textures, where, "texture");
        }
        const Json* surface = material.find("pbrMetallicRoughness");
        for (const std::string_view name : {"baseColorTexture", "metallicRoughnessTexture"}) {
            const Json* texture = surface ? surface->find(name) : nullptr;
            if (texture) check_member(*texture, "index", textures, where, "texture");
        }
    }
}

void check_extensions(const Json& json) {
    // Those that change neither geometry nor base color, or whose geometry assimp reads.
    const auto harmless = [](std::string_view name) {
        return name.substr(0, 14) == "KHR_materials_" || name == "KHR_texture_transform" ||
               name == "KHR_lights_punctual";
    };
    for (const Json& extension : json.list("extensionsRequired")) {
        if (extension.string() && !harmless(*extension.string())) {
            throw std::runtime_error("requires the extension " + in_quotes(*extension.string()) +
                                     ", which is not supported");
        }
    }
}

}  // namespace

std::uint64_t check_gltf(const std::filesystem::path& file, std::string_view bytes) {
    const Container container = opened(bytes);
    const Json& json = container.json;
    const Json* asset = json.find("asset");
    if (!asset || !asset->find("version")) throw std::runtime_error("is not glTF: no asset version");
    check_extensions(json);
    check_accessors(json, check_buffers(container, file.parent_path()));
    check_meshes(json);
    check_materials(json);
    check_nodes(json);
    if (json.list("meshes").empty()) throw std::runtime_error("has no meshes");
    return triangles_in_meshes(json);
}

}  // namespace farfield::scenes::detail
