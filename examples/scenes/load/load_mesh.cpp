// OBJ and glTF through the Open Asset Import Library; tried with 5.2.5.
#include <assimp/material.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include <algorithm>
#include <array>
#include <assimp/Importer.hpp>
#include <map>
#include <memory>

// Private to this file, so that a program may have an stb_image of its own.
#define STB_IMAGE_STATIC
#define STB_IMAGE_IMPLEMENTATION
#define STBI_NO_STDIO
#define STBI_ONLY_PNG
#define STBI_ONLY_JPEG
#define STBI_ONLY_TGA
#define STBI_ONLY_BMP
#include <stb_image.h>

#include "scenes/light.hpp"
#include "scenes/load/load_detail.hpp"

namespace farfield::scenes::detail {
namespace {

struct Image {
    int width = 0, height = 0;
    std::vector<Rgba8> texels{};

    /// Nearest, repeating; v = 0 is the bottom row.
    Rgba8 at(float u, float v) const {
        const auto wrapped = [](float t, int size) {
            const float fraction = t - std::floor(t);
            return std::clamp(static_cast<int>(fraction * static_cast<float>(size)), 0, size - 1);
        };
        const int x = wrapped(u, width), y = height - 1 - wrapped(v, height);
        return texels[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)];
    }
};

/// No texels if it cannot be decoded or has more than 2^26.
Image decoded(std::string_view bytes) {
    Image image;
    int channels = 0;
    if (bytes.empty() || bytes.size() > 0x7fffffff) return image;
    const auto* data = reinterpret_cast<const stbi_uc*>(bytes.data());
    const int size = static_cast<int>(bytes.size());
    if (!stbi_info_from_memory(data, size, &image.width, &image.height, &channels)) return image;
    if (std::int64_t{image.width} * image.height > (std::int64_t{1} << 26)) return image;
    const std::unique_ptr<stbi_uc, void (*)(void*)> texels(
        stbi_load_from_memory(data, size, &image.width, &image.height, &channels, 4), stbi_image_free);
    if (!texels) return image;
    const std::size_t count = static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height);
    image.texels.reserve(count);
    for (std::size_t i = 0; i < count; ++i) {
        const stbi_uc* t = texels.get() + 4 * i;
        image.texels.push_back({t[0], t[1], t[2], t[3]});
    }
    return image;
}

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
        aiVector3D middle;
        if (uv) middle = (uv[corners[0]] + uv[corners[1]] + uv[corners[2]]) / 3.0f;
        for (std::size_t k = 0; k < 3; ++k) {
            glm::vec3 c = surface.color;
            if (const aiColor4D* own = mesh.mColors[0]) {
                c *= glm::vec3(own[corners[k]].r, own[corners[k]].g, own[corners[k]].b);
            }
            if (surface.image && uv) {
                // A little inside, for in atlases the corner's own texel may be the neighbor's.
                const aiVector3D t = uv[corners[k]] * 0.9f + middle * 0.1f;
                Rgba8 texel = surface.image->at(t.x, t.y);
                // Cut-out leaves are drawn whole, and a transparent texel's color is often black: take one of
                // those that would be seen.
                for (float way = 0.2f; texel.a < 128 && way < 1.0f; way += 0.2f) {
                    const aiVector3D inner = uv[corners[k]] * (1.0f - way) + middle * way;
                    texel = surface.image->at(inner.x, inner.y);
                }
                if (texel.a < 128) texel = {255, 255, 255, 255};
                c *= surface.linear ? linear_color(texel) : glm::vec3(to_vec4(texel));
            }
            colors[k] = surface.linear ? display_color(c) : to_rgba8(glm::vec4(c, 1.0f));
        }
    }

    const aiScene& scene_;
    Textures textures_;
    std::vector<Surface> surfaces_;
    Triangles triangles_;
};

std::uint64_t triangles_in_meshes(const aiScene& scene) {
    std::uint64_t sum = 0;
    for (unsigned m = 0; m < scene.mNumMeshes; ++m) {
        const aiMesh& mesh = *scene.mMeshes[m];
        sum += static_cast<std::uint64_t>(std::count_if(mesh.mFaces, mesh.mFaces + mesh.mNumFaces,
                                                        [](const aiFace& f) { return f.mNumIndices == 3; }));
    }
    return sum;
}

}  // namespace

Triangles read_with_assimp(const std::filesystem::path& file) {
    const std::string bytes = read_file(file);
    if (bytes.empty()) throw std::runtime_error("is empty");
    const std::string extension = file.extension().string();
    const bool gltf = extension.size() > 1 && (extension[1] == 'g' || extension[1] == 'G');
    const std::uint64_t expected = gltf ? check_gltf(file, bytes) : 0;
    Assimp::Importer importer;
    const aiScene* scene = importer.ReadFile(file.string(), aiProcess_Triangulate);
    if (!scene) throw std::runtime_error(importer.GetErrorString());
    if (!scene->mRootNode || !scene->HasMeshes()) return {};
    // Assimp leaves out faces of glTF that name vertices which do not exist, with a line in its log.
    const std::uint64_t triangles = triangles_in_meshes(*scene);
    if (triangles < expected) {
        throw std::runtime_error(std::to_string(expected - triangles) + " of " + std::to_string(expected) +
                                 " triangles name vertices out of range");
    }
    return Collector(*scene, file.parent_path(), gltf).collected();
}

}  // namespace farfield::scenes::detail
