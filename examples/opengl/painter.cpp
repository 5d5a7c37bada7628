#include "opengl/painter.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <utility>

namespace farfield::opengl {
namespace {

/// Stand-ins of different laws are drawn in different states, two calls for so many of them; within, those that are
/// strewn come before those that are surfaces. So there are not many more calls than this, however many stand-ins.
constexpr std::size_t most_slabs = 512;
constexpr GLuint vertices_binding = 0, views_binding = 1;

void set_view_attributes(GLuint array) {
    for (GLuint i = 0; i < 6; ++i) {
        glEnableVertexArrayAttrib(array, 2 + i);
        glVertexArrayAttribFormat(array, 2 + i, 4, GL_FLOAT, GL_FALSE, 16 * i);
        glVertexArrayAttribBinding(array, 2 + i, views_binding);
    }
    glVertexArrayBindingDivisor(array, views_binding, 1);
}

/// Programs with CLIPS give distances to planes.
void cut_by_depths(bool is_wanted) {
    for (GLenum i = 0; i < 2; ++i) {
        if (is_wanted) {
            glEnable(GL_CLIP_DISTANCE0 + i);
        } else {
            glDisable(GL_CLIP_DISTANCE0 + i);
        }
    }
}

void set_scissor(const ScreenRectangle& part, int scale) {
    glScissor(part.left * scale, part.top * scale, part.width() * scale, part.height() * scale);
    glEnable(GL_SCISSOR_TEST);
}

const void* at_word(std::size_t word) {
    return reinterpret_cast<const void*>(word * sizeof(std::uint32_t));
}

}  // namespace

Painter::Painter()
    : triangles_(make_vertex_array()),
      far_(make_vertex_array()),
      corners_(make_buffer()),
      records_(GL_TEXTURE_BUFFER),
      record_lists_(GL_TEXTURE_BUFFER),
      whole_triangles_(GL_TEXTURE_BUFFER) {
    glGetIntegerv(GL_MAX_TEXTURE_BUFFER_SIZE, &most_texels_);
    for (const GLuint array : {triangles_.name(), far_.name()}) set_view_attributes(array);
    for (const GLuint attribute : {0u, 1u}) {
        glEnableVertexArrayAttrib(triangles_.name(), attribute);
        glVertexArrayAttribBinding(triangles_.name(), attribute, vertices_binding);
    }
    std::vector<std::uint16_t> corners;
    for (std::uint32_t i = 0; i < Chunk::most; ++i) {
        for (const std::uint32_t c : {0u, 1u, 2u, 0u, 2u, 3u}) corners.push_back(std::uint16_t(4 * i + c));
    }
    for (std::uint32_t i = 0; i < Chunk::most; ++i) {
        for (const std::uint32_t c : {0u, 1u, 2u}) corners.push_back(std::uint16_t(4 * i + c));
    }
    glNamedBufferStorage(corners_.name(), GLsizeiptr(corners.size() * sizeof corners[0]), corners.data(), 0);
    glVertexArrayElementBuffer(far_.name(), corners_.name());
}

void Painter::paint(const Picture& picture, const Sources& sources, const KeptImages& images, Target& target, GLuint to,
                    const PaintOptions& options) {
    now_ = &lists_[options.quad_depth ? 1 : 0];
    geometry_calls_.clear();
    far_calls_.clear();
    words_.clear();
    deposits_triangles_ = false;
    upload(picture, sources);
    add_far_calls(picture, images);
    upload_commands();
    glClipControl(GL_UPPER_LEFT, GL_ZERO_TO_ONE);
    if (options.depth.is_quotient) {
        glDisable(GL_DEPTH_CLAMP);
    } else {
        glEnable(GL_DEPTH_CLAMP);
    }
    cut_by_depths(options.depth.clips);
    glDisable(GL_SCISSOR_TEST);
    glDisable(GL_STENCIL_TEST);
    glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
    glBindBuffer(GL_DRAW_INDIRECT_BUFFER, now_->commands.name());
    find_parts(picture, sources, images, options);
    draw_geometry(picture, sources, images, target, options);
    if (!options.quad_depth && occlusion.asks()) ask_what_is_hidden(picture, options);
    if (!far_part_.is_empty()) draw_far(picture, sources, images, target, options);
    composite(target, to, options);
    glBindBuffer(GL_DRAW_INDIRECT_BUFFER, 0);
    glBindVertexArray(0);
    glUseProgram(0);
    glDisable(GL_DEPTH_CLAMP);
    glClipControl(GL_LOWER_LEFT, GL_NEGATIVE_ONE_TO_ONE);
}

void Painter::add_command(const ArraysCommand& c) {
    words_.insert(words_.end(), {c.count, c.instances, c.first, c.base_instance});
}
void Painter::add_command(const ElementsCommand& c) {
    words_.insert(words_.end(), {c.count, c.instances, c.first_index, std::uint32_t(c.base_vertex), c.base_instance});
}
void Painter::begin_call(Call::Kind kind, std::size_t which) {
    auto& calls = kind == Call::Kind::runs || kind == Call::Kind::streamed ? geometry_calls_ : far_calls_;
    calls.push_back({kind, which, words_.size(), 0});
}

void Painter::upload_commands() {
    now_->commands.begin(words_.size());
    const auto each = [&](auto&& f) {
        for (std::vector<Call>* calls : {&geometry_calls_, &far_calls_}) {
            for (Call& call : *calls) {
                if (call.count != 0) f(call);
            }
        }
    };
    each([&](const Call& call) {
        now_->commands.add(std::span(words_).subspan(call.first, call.count * call.size), call.size);
    });
    draws_.clear();
    draw_ends_.clear();
    stats.uploaded_bytes += now_->commands.update(draws_, draw_ends_);
    std::size_t begin = 0, next = 0;
    each([&](Call& call) {
        call.draws = std::span(draws_).subspan(begin, draw_ends_[next] - begin);
        begin = draw_ends_[next++];
    });
}

void Painter::upload(const Picture& picture, const Sources& sources) {
    stats.uploaded_bytes +=
        picture.makes_rows() ? view_rows_.update(picture.outermost, picture.places) : now_->views.update(picture.rows);
    const auto runs = picture.runs();
    for (std::size_t i = 0; i < runs.size(); ++i) {
        begin_call(Call::Kind::runs, i);
        geometry_calls_.back().count = runs[i].runs.size();
        const TriangleSource& source = *sources[runs[i].source];
        const bool can_deposit = !source.is_indexed && 3 * std::size_t(source.triangles) <= std::size_t(most_texels_);
        geometry_calls_.back().law = can_deposit ? runs[i].law : no_law;
        deposits_triangles_ = deposits_triangles_ || geometry_calls_.back().law != no_law;
        const bool is_indexed = sources[runs[i].source]->is_indexed;
        if (!is_indexed) geometry_calls_.back().size = 4;
        for (const TriangleRun& run : runs[i].runs) {
            if (is_indexed) {
                add_command(ElementsCommand{3 * run.count, 1, 3 * run.first, 0, run.view});
            } else {
                add_command(ArraysCommand{3 * run.count, 1, 3 * run.first, run.view});
            }
        }
    }
    if (picture.streamed.chunks.empty()) return;
    stats.uploaded_bytes += streamed_store_.update(picture.streamed.chunks, picture.streamed.records);
    for (CellLaw law = 0; law <= no_law; ++law) {
        begin_call(Call::Kind::streamed);
        geometry_calls_.back().law = law;
        geometry_calls_.back().size = 4;
        for (const Chunk& c : picture.streamed.chunks) {
            if (c.cell_law != law) continue;
            add_command(ArraysCommand{3 * c.count, 1, 3 * streamed_store_.place_of(c), c.view});
            ++geometry_calls_.back().count;
        }
        if (geometry_calls_.back().count == 0) {
            geometry_calls_.pop_back();
        } else {
            deposits_triangles_ = deposits_triangles_ || law != no_law;
        }
    }
}

void Painter::add_far_calls(const Picture& picture, const KeptImages& images) {
    const std::vector<StandInChunk>& chunks = picture.far.chunks;
    if (!chunks.empty()) {
        const GLuint records = far_store_.records(), lists = far_store_.lists();
        stats.uploaded_bytes += far_store_.update(chunks, picture.far.texels);
        if (far_store_.records() != records) glTextureBuffer(records_.name(), GL_RG32UI, far_store_.records());
        if (far_store_.lists() != lists) glTextureBuffer(record_lists_.name(), GL_R32UI, far_store_.lists());
    }
    std::size_t next = 0;
    for (std::size_t i = 0; i <= picture.images.size(); ++i) {
        const bool is_end = i == picture.images.size();
        if (!is_end && images[picture.images[i].quad.image].is_solid) continue;
        const auto before = [&](const StandInChunk& c, std::size_t texel) { return c.first < texel; };
        const auto end_of = [&](std::size_t texel) {
            return std::size_t(std::lower_bound(chunks.begin(), chunks.end(), texel, before) - chunks.begin());
        };
        const std::size_t end = is_end ? chunks.size() : end_of(picture.images[i].first_texel);
        add_far_chunks(std::span(chunks).subspan(next, end - next));
        next = end;
        if (!is_end) begin_call(Call::Kind::image, i);
    }
}

/// In a slab also what one program draws comes before what another does.
void Painter::add_far_chunks(std::span<const StandInChunk> chunks) {
    std::array<bool, stand_in_groups> has_group{};
    for (const StandInChunk& c : chunks) has_group[std::size_t(group_of(c.kind))] = true;
    // Slabs end where hashes say so, as chunks do, so that one more chunk changes one slab.
    const std::size_t mean = std::bit_ceil((chunks.size() + most_slabs - 1) / most_slabs);
    for (std::size_t first = 0, end = 0; first < chunks.size(); first = end) {
        do {
            ++end;
        } while (end < chunks.size() && (chunks[end - 1].hash & (mean - 1)) != 0 && end - first < 4 * mean);
        const auto slab = chunks.subspan(first, end - first);
        for (const Call::Kind kind : {Call::Kind::independent, Call::Kind::coherent}) {
            for (std::size_t group = 0; group < stand_in_groups; ++group) {
                if (has_group[group]) add_slab(slab, kind, StandInGroup(group));
            }
        }
    }
}

void Painter::add_slab(std::span<const StandInChunk> slab, Call::Kind kind, StandInGroup group) {
    for (const StandInChunk& c : slab) {
        if (group_of(c.kind) != group) continue;
        const std::uint32_t skipped = kind == Call::Kind::coherent ? c.of_law[0] : 0;
        const std::uint32_t count = c.count - (kind == Call::Kind::coherent ? c.of_law[0] : c.of_law[2]);
        if (count == 0) continue;
        const Call* const last = far_calls_.empty() ? nullptr : &far_calls_.back();
        if (last == nullptr || last->kind != kind || last->group != group || last->options != c.options) {
            begin_call(kind);
            far_calls_.back().group = group;
            far_calls_.back().options = c.options;
        }
        ++far_calls_.back().count;
        const auto vertex = std::int32_t(4 * (far_store_.place_of(c) + skipped));
        if (c.kind == StandInKind::face) {
            add_command(ElementsCommand{6 * count, 1, 0, vertex, c.view});
        } else {
            add_command(ElementsCommand{3 * count, 1, 6 * Chunk::most, vertex, c.view});
        }
    }
}

void Painter::find_parts(const Picture& picture, const Sources& sources, const KeptImages& images,
                         const PaintOptions& options) {
    DrawnPart far_part(options.width, options.height), part = far_part;
    for (const StandInChunk& c : picture.far.chunks) far_part.add(c.box, picture.rows[c.view]);
    for (const Chunk& c : picture.streamed.chunks) part.add(c.box, picture.rows[c.view]);
    for (const RunsOfSource& of_source : picture.runs()) {
        std::uint32_t last = ~std::uint32_t(0);
        for (const TriangleRun& run : of_source.runs) {
            if (run.local_view == last) continue;
            last = run.local_view;
            part.add(sources[of_source.source]->box, picture.rows[last]);
        }
    }
    for (const PlacedImage& placed : picture.images) {
        const ImageQuad& q = placed.quad;
        DrawnPart& to = images[q.image].is_solid ? part : far_part;
        for (const glm::vec3 corner : {q.corner, q.corner + q.across, q.corner + q.down, q.corner + q.across + q.down})
            to.add(corner, picture.rows[placed.view]);
    }
    if (deposits_triangles_) far_part.add(part);
    part.add(far_part);
    far_part_ = far_part.rectangle();
    part_ = part.rectangle();
}

GLuint Painter::use(Shader shader, unsigned features, const PaintOptions& options) {
    if (options.depth.clips) features |= CLIPS;
    if (options.slice) features |= SLICED;
    const GLuint program = programs_.get(shader, features);
    glUseProgram(program);
    if (options.slice) glUniform2f(3, options.slice->x, options.slice->y);
    return program;
}

void Painter::draw_geometry(const Picture& picture, const Sources& sources, const KeptImages& images, Target& target,
                            const PaintOptions& options) {
    const int width = options.width * options.side, height = options.height * options.side;
    target.fit_geometry(width, height);
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, target.geometry.name());
    glViewport(0, 0, width, height);
    glEnable(GL_DEPTH_TEST);
    glDepthMask(GL_TRUE);
    glDepthFunc(GL_GREATER);
    glDisable(GL_BLEND);
    const GLfloat nothing = 0;
    set_scissor(part_, options.side);
    glClearBufferfv(GL_COLOR, 0, &options.background.x);
    glClearBufferfv(GL_DEPTH, 0, &nothing);
    if (options.culls_back_faces) {
        glEnable(GL_CULL_FACE);
        glCullFace(GL_BACK);
        glFrontFace(options.is_mirrored ? GL_CW : GL_CCW);
    }
    const GLuint array = triangles_.name();
    glBindVertexArray(array);
    glVertexArrayVertexBuffer(array, views_binding, views_of(picture), 0, sizeof(ViewRow));
    for (const Call& call : geometry_calls_) {
        const bool is_streamed = call.kind == Call::Kind::streamed;
        const TriangleSource* source = is_streamed ? nullptr : sources[picture.runs()[call.which].source].get();
        MeshVertices v;
        v.buffer = streamed_store_.name();
        if (!is_streamed) v = source->vertices;
        const bool translucent = is_streamed ? picture.has_translucent_streamed : source->has_translucent;
        const bool leaves_small = call.law != no_law;
        use(Shader::triangles,
            (options.light ? LIT : 0u) | (translucent ? TRANSLUCENT : 0u) | (leaves_small ? LEAVES_SMALL : 0u),
            options);
        if (options.light) glUniform2f(1, options.light->ambient, options.light->diffuse);
        if (translucent) glUniform2i(2, options.first_sample.x, options.first_sample.y);
        if (leaves_small) {
            glTextureBuffer(whole_triangles_.name(), GL_RGBA32UI, v.buffer);
            glBindTextureUnit(0, whole_triangles_.name());
            glUniform2f(4, float(width), float(height));
            glUniform1i(5, AreaLaw(call.law) == AreaLaw::coherent ? 1 : 0);
        }
        glVertexArrayVertexBuffer(array, vertices_binding, v.buffer, v.first, v.stride);
        glVertexArrayAttribFormat(array, 0, 3, GL_FLOAT, GL_FALSE, v.position_offset);
        glVertexArrayAttribFormat(array, 1, 4, GL_UNSIGNED_BYTE, GL_TRUE, v.color_offset);
        const bool is_indexed = !is_streamed && source->is_indexed;
        if (is_indexed) glVertexArrayElementBuffer(array, source->own.name());
        for (const CommandDraw& draw : call.draws) {
            if (is_indexed) {
                glMultiDrawElementsIndirect(GL_TRIANGLES, GL_UNSIGNED_INT, at_word(draw.first), GLsizei(draw.count), 0);
            } else {
                glMultiDrawArraysIndirect(GL_TRIANGLES, at_word(draw.first), GLsizei(draw.count), 0);
            }
            ++stats.draw_calls;
        }
    }
    glDisable(GL_CULL_FACE);
    for (const PlacedImage& placed : picture.images) {
        draw_image(picture, placed, images, images[placed.quad.image].is_solid ? 0 : 1, 1, options);
    }
}

/// Against what was drawn as geometry; what stands in hides nothing here.
void Painter::ask_what_is_hidden(const Picture& picture, const PaintOptions& options) {
    glDepthMask(GL_FALSE);
    glDepthFunc(GL_GEQUAL);
    glColorMask(GL_FALSE, GL_FALSE, GL_FALSE, GL_FALSE);
    glDisable(GL_SCISSOR_TEST);
    cut_by_depths(false);
    glUseProgram(programs_.get(Shader::bounds));
    glBindVertexArray(far_.name());
    glVertexArrayVertexBuffer(far_.name(), views_binding, views_of(picture), 0, sizeof(ViewRow));
    occlusion.ask([this](const Occlusion::Box& box) {
        glUniform3fv(1, 1, &box.center.x);
        glUniform3fv(2, 1, &box.half_size.x);
        glDrawArraysInstancedBaseInstance(GL_TRIANGLE_STRIP, 0, 14, 1, box.view);
        ++stats.draw_calls;
    });
    cut_by_depths(options.depth.clips);
    glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
    glDepthFunc(GL_GREATER);
}

GLuint Painter::vertices_of(const Call& call, const Picture& picture, const Sources& sources) const {
    if (call.kind == Call::Kind::streamed) return streamed_store_.name();
    return sources[picture.runs()[call.which].source]->vertices.buffer;
}

/// They are nearer than most of what stands in, and come first; those that are strewn before surfaces.
void Painter::draw_small_triangles(const Picture& picture, const Sources& sources, glm::vec2 samples,
                                   const PaintOptions& options) {
    use(Shader::small_triangles, options.quad_depth ? KEEPS_DEPTHS : 0u, options);
    const glm::vec2 lanes = samples * float(options.lanes);
    glUniform2f(0, lanes.x, lanes.y);
    glUniform2f(4, samples.x, samples.y);
    glUniform1i(7, options.light ? 1 : 0);
    glUniform1i(11, options.lanes);
    glUniform1i(8, !options.culls_back_faces ? 0 : options.is_mirrored ? -1 : 1);
    if (options.light) glUniform2f(6, options.light->ambient, options.light->diffuse);
    glBindVertexArray(triangles_.name());
    for (const bool coherent : {false, true}) {
        glBlendFunci(0, coherent ? GL_SRC_ALPHA_SATURATE : GL_ONE_MINUS_DST_ALPHA, GL_ONE);
        glUniform1i(1, coherent ? 1 : 0);
        for (const Call& call : geometry_calls_) {
            if (call.law == no_law || AreaLaw(call.law) == (coherent ? AreaLaw::independent : AreaLaw::coherent))
                continue;
            glTextureBuffer(whole_triangles_.name(), GL_RGBA32UI, vertices_of(call, picture, sources));
            glBindTextureUnit(0, whole_triangles_.name());
            glUniform1i(5, call.law);
            for (const CommandDraw& draw : call.draws) {
                glMultiDrawArraysIndirect(GL_TRIANGLES, at_word(draw.first), GLsizei(draw.count), 0);
                ++stats.draw_calls;
            }
        }
    }
}

void Painter::draw_far(const Picture& picture, const Sources& sources, const KeptImages& images, Target& target,
                       const PaintOptions& options) {
    const bool keeps_depths = options.quad_depth.has_value();
    const int width = options.width * options.side * options.lanes;
    const int height = options.height * options.side * options.lanes;
    target.fit_deposits(width, height, keeps_depths, options.lanes == 1);
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, target.deposits.name());
    glViewport(0, 0, width, height);
    set_scissor(far_part_, options.side * options.lanes);
    const GLfloat nothing[4] = {0, 0, 0, 0}, no_depth[4] = {-1, 0, 0, 0};
    glClearBufferfv(GL_COLOR, 0, nothing);
    if (target.nearest.name() != 0) glClearBufferfv(GL_COLOR, 1, no_depth);
    glDepthMask(GL_TRUE);
    if (options.lanes == 1) {
        // The depths are there.
    } else if (geometry_calls_.empty() && picture.images.empty()) {
        glClearBufferfv(GL_DEPTH, 0, nothing);
    } else {
        glDepthFunc(GL_ALWAYS);
        glColorMask(GL_FALSE, GL_FALSE, GL_FALSE, GL_FALSE);  // a shader that gives no color leaves any
        glUseProgram(programs_.get(Shader::copied_depth));
        glUniform1i(11, options.lanes);
        glBindTextureUnit(2, target.depth.name());
        cut_by_depths(false);
        glBindVertexArray(far_.name());
        glDrawArrays(GL_TRIANGLES, 0, 3);
        ++stats.draw_calls;
        glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
        cut_by_depths(options.depth.clips);
    }
    glDepthFunc(GL_GREATER);
    glDepthMask(GL_FALSE);
    glEnable(GL_BLEND);
    if (keeps_depths) {
        glBlendEquationi(1, GL_MAX);
        glBlendFunci(1, GL_ONE, GL_ONE);
    }
    if (deposits_triangles_)
        draw_small_triangles(picture, sources, glm::vec2(width, height) / float(options.lanes), options);
    glVertexArrayVertexBuffer(far_.name(), views_binding, views_of(picture), 0, sizeof(ViewRow));
    const Call* last = nullptr;
    for (const Call& call : far_calls_) {
        if (last == nullptr || last->kind != call.kind) {
            // The area law, front to back: alpha is what is covered. See README.md.
            if (call.kind == Call::Kind::coherent) {
                glBlendFunci(0, GL_SRC_ALPHA_SATURATE, GL_ONE);
            } else {
                glBlendFunci(0, GL_ONE_MINUS_DST_ALPHA, GL_ONE);
            }
        }
        if (call.kind == Call::Kind::image) {
            draw_image(picture, picture.images[call.which], images, 2, options.lanes, options);
        } else {
            if (last == nullptr || last->kind != call.kind || last->group != call.group ||
                last->options != call.options)
                use_for_stand_ins(call, picture, glm::vec2(width, height), options);
            for (const CommandDraw& draw : call.draws) {
                glMultiDrawElementsIndirect(GL_TRIANGLES, GL_UNSIGNED_SHORT, at_word(draw.first), GLsizei(draw.count),
                                            0);
                ++stats.draw_calls;
            }
        }
        last = &call;
    }
    if (keeps_depths) glBlendEquationi(1, GL_FUNC_ADD);
    glDisable(GL_SCISSOR_TEST);
    glDisable(GL_BLEND);
    glBlendFunc(GL_ONE, GL_ZERO);
}

void Painter::use_for_stand_ins(const Call& call, const Picture& picture, glm::vec2 lanes,
                                const PaintOptions& options) {
    constexpr unsigned features[stand_in_groups] = {0, TENSORS, CUBES};
    use(Shader::far_field, features[std::size_t(call.group)] | (options.quad_depth ? KEEPS_DEPTHS : 0u), options);
    glUniform2f(0, lanes.x, lanes.y);
    glUniform1i(1, call.kind == Call::Kind::coherent ? 1 : 0);
    glUniform1i(11, options.lanes);
    if (call.group == StandInGroup::tensors) {
        const TensorOptions& o = picture.tensor_options[call.options];
        glUniform3f(12, o.closed_surfaces ? 1.0f : 0.0f, o.counts_overlap ? 1.0f : 0.0f, o.sheet_gain);
    }
    glBindVertexArray(far_.name());
    glBindTextureUnit(0, records_.name());
    glBindTextureUnit(1, record_lists_.name());
}

void Painter::draw_image(const Picture& picture, const PlacedImage& placed, const KeptImages& images, int mode,
                         int lanes, const PaintOptions& options) {
    const KeptImage& image = images[placed.quad.image];
    const ImageQuad& q = placed.quad;
    use(Shader::image_quad, mode == 2 && options.quad_depth ? KEEPS_DEPTHS : 0u, options);
    glUniform3fv(4, 1, &q.corner.x);
    glUniform3fv(5, 1, &q.across.x);
    glUniform3fv(6, 1, &q.down.x);
    glUniform2f(7, float(image.width), float(image.height));
    glUniform2i(8, image.width, image.height);
    glUniform1i(9, mode);
    glUniform4i(10, int(std::lround(q.first_part * 64)), int(std::lround(q.end_part * 64)), options.beside.x,
                options.beside.y);
    glUniform1i(11, lanes);
    glUniform2f(12, options.depth.bias, options.depth.is_perspective ? 1.0f : 0.0f);
    glBindTextureUnit(0, image.color.name());
    glBindTextureUnit(1, image.depth.name());
    glBindVertexArray(far_.name());
    glVertexArrayVertexBuffer(far_.name(), views_binding, views_of(picture), 0, sizeof(ViewRow));
    glDrawArraysInstancedBaseInstance(GL_TRIANGLE_STRIP, 0, 4, 1, placed.view);
    ++stats.draw_calls;
}

void Painter::composite(Target& target, GLuint to, const PaintOptions& options) {
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, to);
    glViewport(0, 0, options.width, options.height);
    glDisable(GL_DEPTH_TEST);
    glDisable(GL_SCISSOR_TEST);
    cut_by_depths(false);
    const GLfloat no_depth[4] = {-1e30f, 0, 0, 0};
    glClearBufferfv(GL_COLOR, 0, &options.background.x);
    if (options.quad_depth) glClearBufferfv(GL_COLOR, 1, no_depth);
    // Where samples are pixels, what the far field leaves alone is copied.
    const bool copies = options.side == 1 && !options.quad_depth;
    if (part_.is_empty()) return;
    if (copies) {
        glBlitNamedFramebuffer(target.geometry.name(), to, part_.left, part_.top, part_.right, part_.bottom, part_.left,
                               part_.top, part_.right, part_.bottom, GL_COLOR_BUFFER_BIT, GL_NEAREST);
        if (far_part_.is_empty()) return;
    }
    set_scissor(copies ? far_part_ : part_, 1);
    glUseProgram(programs_.get(Shader::composite, options.quad_depth ? KEEPS_DEPTHS : 0u));
    glUniform1i(1, options.side);
    glUniform1i(11, options.lanes);
    glUniform4i(2, far_part_.left, far_part_.top, far_part_.right, far_part_.bottom);
    glBindTextureUnit(0, target.color.name());
    glBindTextureUnit(1, target.far_field.name());
    if (options.quad_depth) {
        glUniform3f(3, *options.quad_depth, options.depth.bias, options.depth.is_perspective ? 1.0f : 0.0f);
        glBindTextureUnit(2, target.depth.name());
        glBindTextureUnit(3, target.nearest.name());
    }
    glBindVertexArray(far_.name());
    glDrawArrays(GL_TRIANGLES, 0, 3);
    ++stats.draw_calls;
    glDisable(GL_SCISSOR_TEST);
    for (const GLuint unit : {0u, 1u, 2u, 3u}) glBindTextureUnit(unit, 0);
}

}  // namespace farfield::opengl
