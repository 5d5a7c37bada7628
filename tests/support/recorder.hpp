// A renderer that draws nothing and writes down what it is given.
#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <optional>
#include <span>
#include <vector>

#include "farfield/renderer.hpp"

namespace farfield::test {

struct Recording {
    struct Draw {
        std::uint32_t source;  ///< as upload numbered them
        std::uint32_t primitive;
        glm::vec3 eye;  ///< of the view it is drawn in
        std::size_t faces_before;
        std::size_t splats_before;
        std::optional<AreaLaw> law{};
        std::uint32_t position = 0;
    };
    std::vector<Draw> draws;
    std::vector<Face> faces;
    std::vector<Splat> splats;
    std::vector<CellId> asked;
    std::vector<Cell> asked_cells;
    std::vector<LocalView> views;
    std::vector<ImageQuad> quads;
    std::size_t ranges = 0, frames = 0, paged_in = 0, paged_out = 0, images = 0, images_freed = 0;
    float largest_splat = 0;
    bool hides_everything = false;
    bool deposits = false;

    /// Forgets what was drawn.
    void clear() {
        draws.clear();
        faces.clear();
        splats.clear();
        asked.clear();
        asked_cells.clear();
        views.clear();
        quads.clear();
        ranges = frames = 0;
    }
};

template <RendererFacts stated>
class BasicRecorder : public Recording {
  public:
    static constexpr RendererFacts facts = stated;

    template <class P>
    std::uint32_t upload(const Source<P>&) {
        return std::uint32_t(paged_in++);
    }
    void release(std::uint32_t) { ++paged_out; }
    void begin_frame(const LocalView&) { ++frames; }
    void set_view(const LocalView& view) { views.push_back(view); }
    void end_frame() {}
    template <class P>
    void draw(const Source<P>& source, std::span<const Range> runs) {
        for (const Range r : runs) {
            ++ranges;
            for (std::uint32_t i = r.first; i < r.first + r.count; ++i) {
                draws.push_back({source.id, std::uint32_t(&source[i] - source.primitives.data()), views.back().eye,
                                 faces.size(), splats.size(), r.law, i});
            }
        }
    }
    void draw(std::span<const Face> f) { faces.insert(faces.end(), f.begin(), f.end()); }
    void draw(std::span<const Splat> s) { splats.insert(splats.end(), s.begin(), s.end()); }
    float largest_splat_px() const { return largest_splat; }
    bool deposits_primitives() const { return deposits; }
    bool hidden(const Cell& cell, CellId id) {
        asked.push_back(id);
        asked_cells.push_back(cell);
        return hides_everything;
    }
    void begin_image(const LocalView&, float, int) {}
    std::uint32_t end_image() { return std::uint32_t(++images); }
    void free_image(std::uint32_t) { ++images_freed; }
    std::size_t image_bytes(int width, int height) const { return std::size_t(width) * std::size_t(height); }
    void draw(std::span<const ImageQuad> q) { quads.insert(quads.end(), q.begin(), q.end()); }
};

using Recorder = BasicRecorder<RendererFacts{.keeps_sources = true,
                                             .draws_faces = true,
                                             .draws_splats = true,
                                             .answers_hidden = true,
                                             .deposits_primitives = true,
                                             .keeps_images = true}>;
/// Stand-ins come as faces, after everything else, back to front.
using BackToFrontRecorder = BasicRecorder<RendererFacts{.order = VisitOrder::back_to_front,
                                                        .far_field_order = VisitOrder::back_to_front,
                                                        .keeps_sources = true,
                                                        .draws_faces = true}>;

}  // namespace farfield::test
