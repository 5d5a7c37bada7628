// OBJ and glTF through the Open Asset Import Library; tried with 5.2.5.
#include <assimp/material.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include <algorithm>
#include <array>
#include <assimp/Importer.hpp>
#include <map>
#include <memory>

#include "scenes/light.hpp"
#include "scenes/load/load_detail.hpp"
#include "scenes/load/texture.hpp"

namespace farfield::scenes::detail {
namespace {

class Textures {
  public:
    Textures(const aiScene& scene, std::filesystem::path folder) : scene_(scene), folder_(std::move(folder)) {}

    /// Null if there is none, or it cannot be read: the material's color then stands for itself.
    const Image* of(const aiMaterial& material) {
        aiString name;
        if (material.GetTexture(aiTextureType_BASE_COLOR, 0, &name) != aiReturn_SUCCESS &&
            material.GetTexture(aiTextureType_DIFFUSE, 0, &name) != aiReturn_SUCCESS) {
            return nullptr;
        }
        const auto [entry, is_new] = images_.try_emplace(name.C_Str());
        if (is_new) entry->second = read(name.C_Str());
        return entry->second.texels.empty() ? nullptr : &entry->second;
    }

  private:
    Image read(const std::string& name) const {
        if (const aiTexture* embedded = scene_.GetEmbeddedTexture(name.c_str())) {
            // Height 0: still compressed, and width is the number of bytes.
            if (embedded->mHeight == 0) {
                return decoded({reinterpret_cast<const char*>(embedded->pcData), embedded->mWidth});
            }
            return {};
        }
        std::string portable = name;
        std::replace(portable.begin(), portable.end(), '\\', '/');
        try {
            return decoded(read_file(folder_ / portable));
        } catch (const std::runtime_error&) {
            return {};
        }
    }

    const aiScene& scene_;
    std::filesystem::path folder_;
    std::map<std::string, Image> images_;
};

/// glTF's factors and vertex colors are linear; OBJ's are as displayed.
struct Surface {
    glm::vec3 color{1.0f};
    const Image* image = nullptr;
    bool linear = false;
};

Surface surface_of(const aiMaterial& material, Textures& textures, bool linear) {
    Surface surface;
    surface.linear = linear;
    surface.image = textures.of(material);
    aiColor4D color;
    if (material.Get(AI_MATKEY_BASE_COLOR, color) == aiReturn_SUCCESS ||
        material.Get(AI_MATKEY_COLOR_DIFFUSE, color) == aiReturn_SUCCESS) {
        surface.color = {color.r, color.g, color.b};
    }
    return surface;
}

/// A small file can place a large mesh very often; this many are 4.8 GB.
constexpr std::size_t most_triangles = 100'000'000;

class Collector {
  public:
    Collector(const aiScene& scene, const std::filesystem::path& folder, bool linear)
        : scene_(scene), textures_(scene, folder) {
        for (unsigned i = 0; i < scene.mNumMaterials; ++i) {
            surfaces_.push_back(surface_of(*scene.mMaterials[i], textures_, linear));
        }
    }

    Triangles collected() {
        std::vector<std::pair<const aiNode*, aiMatrix4x4>> pending{{scene_.mRootNode, aiMatrix4x4()}};
        while (!pending.empty()) {
            const auto [node, to_parent] = pending.back();
            pending.pop_back();
            const aiMatrix4x4 to_world = to_parent * node->mTransformation;
            for (unsigned i = 0; i < node->mNumMeshes; ++i) add(node->mMeshes[i], to_world);
            // The first child is to be next.
            for (unsigned i = node->mNumChildren; i-- > 0;) pending.push_back({node->mChildren[i], to_world});
        }
        return std::move(triangles_);
    }

  private:
    void add(unsigned mesh_index, const aiMatrix4x4& to_world) {
        const aiMesh& mesh = *scene_.mMeshes[mesh_index];
        const std::string kind = "mesh " + std::to_string(mesh_index) + ": vertex";
        std::vector<glm::vec3> positions;
        positions.reserve(mesh.mNumVertices);
        for (unsigned v = 0; v < mesh.mNumVertices; ++v) {
            const aiVector3D p = to_world * mesh.mVertices[v];
            positions.push_back(
                finite(static_cast<double>(p.x), static_cast<double>(p.y), static_cast<double>(p.z), kind, v));
        }
        const bool mirrored = to_world.Determinant() < 0;  // turns fronts into backs
        for (unsigned f = 0; f < mesh.mNumFaces; ++f) {
            const aiFace& face = mesh.mFaces[f];
            for (unsigned i = 0; i < face.mNumIndices; ++i) {
                if (face.mIndices[i] >= mesh.mNumVertices) {
                    throw std::runtime_error("mesh " + std::to_string(mesh_index) + ": face " + std::to_string(f) +
                                             " names vertex " + std::to_string(face.mIndices[i]) + " of " +
                                             std::to_string(mesh.mNumVertices));
                }
            }
            if (face.mNumIndices != 3) continue;  // points and lines
            if (triangles_.size() == most_triangles) {
                throw std::runtime_error("more than 100,000,000 triangles, with every instance of its meshes");
            }
            const unsigned* index = face.mIndices;
            const std::array<unsigned, 3> corners{index[0], index[mirrored ? 2 : 1], index[mirrored ? 1 : 2]};
            VertexColoredTriangle& triangle = triangles_.emplace_back();
            for (std::size_t k = 0; k < 3; ++k) triangle.vertices[k] = positions[corners[k]];
            color(mesh, corners, triangle.rgba);
        }
    }

    void color(const aiMesh& mesh, const std::array<unsigned, 3>& corners, std::array<Rgba8, 3>& colors) const {
        const Surface surface = mesh.mMaterialIndex < surfaces_.size() ? surfaces_[mesh.mMaterialIndex] : Surface{};
        const aiVector3D* uv = mesh.mTextureCoords[0];
        std::array<Rgba8, 3> texels{};
        if (surface.image && uv) {
            const auto at = [&](std::size_t k) { return glm::vec2(uv[corners[k]].x, uv[corners[k]].y); };
            texels = Texture{surface.image}.corners({at(0), at(1), at(2)});
        }
        for (std::size_t k = 0; k < 3; ++k) {
            glm::vec3 c = surface.color;
            if (const aiColor4D* own = mesh.mColors[0]) {
                c *= glm::vec3(own[corners[k]].r, own[corners[k]].g, own[corners[k]].b);
            }
            if (surface.image && uv) {
                c *= surface.linear ? linear_color(texels[k]) : glm::vec3(to_vec4(texels[k]));
            }
            colors[k] = surface.linear ? display_color(c) : to_rgba8(glm::vec4(c, 1.0f));
        }
    }

    const aiScene& scene_;
    Textures textures_;
    std::vector<Surface> surfaces_;
    Triangles triangles_;
};

}  // namespace

Triangles read_with_assimp(const std::filesystem::path& file) {
    const std::string bytes = read_file(file);
    if (bytes.empty()) throw std::runtime_error("is empty");
    Assimp::Importer importer;
    const aiScene* scene = importer.ReadFile(file.string(), aiProcess_Triangulate);
    if (!scene) throw std::runtime_error(importer.GetErrorString());
    if (!scene->mRootNode || !scene->HasMeshes()) return {};
    return Collector(*scene, file.parent_path(), false).collected();
}

}  // namespace farfield::scenes::detail
