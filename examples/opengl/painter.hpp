// Draws a picture: geometry with a depth buffer, stand-ins front to back by the area law over it, then both as pixels.
#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "farfield/geometry/light.hpp"
#include "opengl/chunk_store.hpp"
#include "opengl/command_store.hpp"
#include "opengl/kept_images.hpp"
#include "opengl/mirrored_buffer.hpp"
#include "opengl/occlusion.hpp"
#include "opengl/picture.hpp"
#include "opengl/screen_rectangle.hpp"
#include "opengl/shaders.hpp"
#include "opengl/stand_in_store.hpp"
#include "opengl/target.hpp"
#include "opengl/triangles.hpp"
#include "opengl/view_rows.hpp"

namespace farfield::opengl {

/// How a picture is drawn.
struct PaintOptions {
    int width = 0, height = 0;  ///< in pixels
    int side = 1;               ///< of a pixel, in samples
    int lanes = 1;              ///< of a sample's side
    DepthRule depth{};
    glm::vec4 background{0};  ///< premultiplied
    std::optional<DirectionalLight> light{};
    bool culls_back_faces = false, is_mirrored = false;
    glm::ivec2 first_sample{0};         ///< of the whole picture's, relative to its middle
    glm::ivec2 beside{0};               ///< samples of the whole picture to the left and above
    std::optional<glm::vec2> slice{};   ///< only what has depths between these, as in the depth buffer
    std::optional<float> quad_depth{};  ///< it is an image: the rectangle's depth, as in the depth buffer
};

/// Counts of one frame, images made in it included.
struct PaintStats {
    std::uint64_t draw_calls = 0;
    std::uint64_t uploaded_bytes = 0;
};

class Painter {
  public:
    using Sources = std::vector<std::shared_ptr<const TriangleSource>>;

    Painter();

    /// Draws into `target` and, as pixels, into a framebuffer of the picture's size, which has a second attachment for
    /// relative depths if it is an image.
    void paint(const Picture& picture, const Sources& sources, const KeptImages& images, Target& target, GLuint to,
               const PaintOptions& options);

    Occlusion occlusion;  ///< asked after the geometry of each frame

    PaintStats stats;

  private:
    struct ArraysCommand {
        std::uint32_t count, instances, first, base_instance;
    };
    struct ElementsCommand {
        std::uint32_t count, instances, first_index;
        std::int32_t base_vertex;
        std::uint32_t base_instance;
    };
    struct Call {
        enum class Kind : unsigned char { runs, streamed, independent, coherent, image };
        Kind kind;
        std::size_t which = 0;             ///< of the runs, or of the images
        std::size_t first = 0, count = 0;  ///< commands, in words and in number
        std::size_t size = 5;              ///< words in a command
        std::span<const CommandDraw> draws{};
        CellLaw law = no_law;      ///< of triangles whose small ones are deposited
        StandInGroup group{};      ///< of stand-ins
        std::uint8_t options = 0;  ///< of tensors: which of the picture's
    };

    void upload(const Picture& picture, const Sources& sources);
    void add_far_calls(const Picture& picture, const KeptImages& images);
    void add_far_chunks(std::span<const StandInChunk> chunks);
    void add_slab(std::span<const StandInChunk> slab, Call::Kind kind, StandInGroup group);
    void use_for_stand_ins(const Call& call, const Picture& picture, glm::vec2 lanes, const PaintOptions& options);
    void add_command(const ArraysCommand& c);
    void add_command(const ElementsCommand& c);
    void begin_call(Call::Kind kind, std::size_t which = 0);
    void upload_commands();

    void draw_geometry(const Picture& picture, const Sources& sources, const KeptImages& images, Target& target,
                       const PaintOptions& options);
    void draw_far(const Picture& picture, const Sources& sources, const KeptImages& images, Target& target,
                  const PaintOptions& options);
    void draw_small_triangles(const Picture& picture, const Sources& sources, glm::vec2 samples,
                              const PaintOptions& options);
    GLuint vertices_of(const Call& call, const Picture& picture, const Sources& sources) const;
    void ask_what_is_hidden(const Picture& picture, const PaintOptions& options);
    void draw_image(const Picture& picture, const PlacedImage& placed, const KeptImages& images, int mode, int lanes,
                    const PaintOptions& options);
    void find_parts(const Picture& picture, const Sources& sources, const KeptImages& images,
                    const PaintOptions& options);
    void composite(Target& target, GLuint to, const PaintOptions& options);
    GLuint use(Shader shader, unsigned features, const PaintOptions& options);

    /// Views and commands, of frames and of images apart: what a frame has is then as it was.
    struct Lists {
        MirroredBuffer views;
        CommandStore commands;
    };
    GLuint views_of(const Picture& picture) const {
        return picture.makes_rows() ? view_rows_.name() : now_->views.name();
    }

    Programs programs_;
    VertexArray triangles_, far_;
    Buffer corners_;         ///< of the records of a chunk, six each
    GLint most_texels_ = 0;  ///< of a buffer
    Texture records_, record_lists_, whole_triangles_;
    Lists lists_[2];
    Lists* now_ = nullptr;
    ViewRows view_rows_;
    StandInStore far_store_;
    ChunkStore<TriangleVertices> streamed_store_;
    std::vector<std::uint32_t> words_;  ///< of commands
    std::vector<CommandDraw> draws_;
    std::vector<std::size_t> draw_ends_;  ///< of each call
    std::vector<Call> geometry_calls_, far_calls_;
    bool deposits_triangles_ = false;
    ScreenRectangle part_, far_part_;  ///< that is drawn into, and that stand-ins are, in pixels
};

}  // namespace farfield::opengl
