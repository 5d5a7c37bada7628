// A tileset in memory, read as a viewer reads it: independent of what wrote it.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <functional>
#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <map>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "farfield/geometry/box.hpp"

namespace farfield_export::testing {

using Files = std::map<std::string, std::string>;

/// What a GLB holds; throws where it is none.
class Glb {
  public:
    explicit Glb(std::string_view bytes) {
        demand(bytes.size() >= 20 && bytes.substr(0, 4) == "glTF" && word(bytes, 4) == 2, "header");
        demand(word(bytes, 8) == bytes.size() && bytes.size() % 4 == 0, "length");
        const std::size_t text = word(bytes, 12);
        demand(bytes.substr(16, 4) == "JSON" && text % 4 == 0, "JSON chunk");
        json = nlohmann::json::parse(bytes.substr(20, text));
        const std::size_t at = 20 + text;
        demand(bytes.substr(at + 4, 4) == std::string_view("BIN\0", 4), "binary chunk");
        binary_ = bytes.substr(at + 8, word(bytes, at));
        demand(binary_.size() == json["buffers"][0]["byteLength"].get<std::size_t>(), "buffer");
    }
    /// Of all primitives of that mode, with splats or without; positions where the node puts them.
    template <class V>
    std::vector<V> attribute(int mode, const std::string& name, bool of_splats = false) const {
        std::vector<V> out;
        for (const auto& p : json["meshes"][0]["primitives"]) {
            if (p["mode"] != mode || p.contains("extensions") != of_splats || !p["attributes"].contains(name)) continue;
            const auto& accessor = json["accessors"][p["attributes"][name].get<std::size_t>()];
            const auto& view = json["bufferViews"][accessor["bufferView"].get<std::size_t>()];
            const std::size_t count = accessor["count"], offset = view["byteOffset"], bytes = view["byteLength"];
            demand(bytes == count * sizeof(V) && offset % 4 == 0 && offset + bytes <= binary_.size(), "buffer view");
            out.resize(out.size() + count);
            std::memcpy(out.data() + out.size() - count, binary_.data() + offset, bytes);
        }
        if constexpr (std::is_same_v<V, glm::vec3>) {
            if (const glm::vec3 t = translation(); name == "POSITION" && t != glm::vec3(0)) {
                for (V& v : out) v += t;
            }
        }
        return out;
    }
    glm::vec3 translation() const {
        const auto& node = json["nodes"][0];
        if (!node.contains("translation")) return glm::vec3(0);
        const auto t = node["translation"].get<std::array<double, 3>>();
        return {float(t[0]), float(t[1]), float(t[2])};
    }
    std::vector<glm::vec3> triangles() const { return attribute<glm::vec3>(4, "POSITION"); }

    nlohmann::json json;

  private:
    static void demand(bool holds, const char* what) {
        if (!holds) throw std::runtime_error(std::string("not a GLB: ") + what);
    }
    static std::size_t word(std::string_view bytes, std::size_t at) {
        std::uint32_t w = 0;
        std::memcpy(&w, bytes.data() + at, 4);
        return w;
    }
    std::string_view binary_;
};

struct ReadTile {
    farfield::BoxD box{};  ///< in glTF's axes
    double error = 0;
    std::string content{};  ///< the name of a GLB, or empty
    std::vector<ReadTile> children{};
};

/// The tree in a file, and in those that it names.
inline ReadTile read_tile(const Files& files, const nlohmann::json& json) {
    if (json.contains("content")) {
        const std::string uri = json["content"]["uri"];
        if (uri.ends_with(".json")) {
            const auto tileset = nlohmann::json::parse(files.at(uri));
            if (json.contains("children")) throw std::runtime_error("a tile has children and a tileset");
            return read_tile(files, tileset.at("root"));
        }
    }
    ReadTile tile;
    const auto box = json.at("boundingVolume").at("box").get<std::array<double, 12>>();
    for (const int i : {4, 5, 6, 8, 9, 10}) {
        if (i != 7 && box[std::size_t(i)] != 0) throw std::runtime_error("a box is turned");
    }
    // z is up in tiles: (x, y, z) of glTF is (x, -z, y).
    const glm::dvec3 center(box[0], box[2], -box[1]), half(box[3], box[11], box[7]);
    tile.box = {center - half, center + half};
    tile.error = json.at("geometricError");
    if (json.contains("content")) tile.content = json["content"]["uri"];
    if (json.contains("children")) {
        for (const auto& child : json["children"]) tile.children.push_back(read_tile(files, child));
    }
    return tile;
}
inline ReadTile read_tileset(const Files& files) {
    const auto tileset = nlohmann::json::parse(files.at("tileset.json"));
    if (tileset.at("asset").at("version") != "1.1") throw std::runtime_error("the version is another");
    if (tileset.at("geometricError").get<double>() < tileset.at("root").at("geometricError").get<double>())
        throw std::runtime_error("the tileset's error is less than its root's");
    return read_tile(files, tileset.at("root"));
}

inline void for_each_tile(const ReadTile& tile, const std::function<void(const ReadTile&)>& f) {
    f(tile);
    for (const ReadTile& child : tile.children) for_each_tile(child, f);
}

}  // namespace farfield_export::testing
