// An approximation of your own: the box of the cell in one color, with one opacity. Four bytes a cell.
#pragma once

#include <cstdint>
#include <glm/vec4.hpp>
#include <span>
#include <vector>

#include "farfield/approximation.hpp"
#include "farfield/approximation/cell_faces.hpp"

struct MeanColorBox {
    /// Options are public members with defaults. This one: samples along a side of the box.
    std::uint32_t samples = 4;

    static constexpr farfield::ApproximationFacts facts{
        .needs_polygons = true, .stands_in = true, .file_tag = 0x6d630001u};
    using stand_in_data = farfield::Rgba8;  ///< what is kept for a cell: its color, premultiplied
    using stand_in_draft = glm::vec4;       ///< what it is while it is made

    /// The mean over what is seen through the six sides.
    template <class Contents, farfield::OrthographicSampler Sampler>
    stand_in_draft sample(const farfield::Cell& cell, Contents&& contents, Sampler& sampler) const {
        const farfield::SampleGrid grid{cell.bounds(), samples, 1};
        std::vector<farfield::Rgba8> seen(grid.size());
        sampler.sample(grid, contents, std::span<farfield::Rgba8>(seen));
        glm::vec4 sum(0);
        for (const farfield::Rgba8 c : seen) sum += farfield::to_vec4(c);
        // Contents of a loose cell stick out of it; its box has to cover as much as they do.
        const auto surface = [](glm::vec3 half) { return half.x * half.y + half.y * half.z + half.z * half.x; };
        const float own = surface(cell.half), enlarged = own > 0 ? surface(cell.bounds_half) / own : 0.0f;
        const glm::vec4 mean = sum * (enlarged / float(seen.size()));
        return mean.a > 1 ? mean / mean.a : mean;
    }
    stand_in_data finish(const farfield::Cell&, const stand_in_draft& mean) const { return farfield::to_rgba8(mean); }

    /// What drawing one takes, for the cost model.
    farfield::Work expected_work() const { return {.faces = 3}; }

    /// How wrong it is from here: a box may be taken for its contents as long as it is about a pixel.
    float error_px(const stand_in_data&, const farfield::Cell& cell, const farfield::LocalView& view) const {
        return view.pixels(cell.largest_side(), view.distance_to(cell));
    }
    /// The faces that look at the viewer, at most three.
    template <class Sink>
    void draw_stand_in(const stand_in_data& color, const farfield::Cell& cell, const farfield::LocalView& view,
                       Sink&& sink) const {
        if (color.a == 0) return;
        const farfield::VisibleFaces faces(cell, view);
        for (int i = 0; i < faces.count; ++i) sink(farfield::face_of(cell, faces.side[std::size_t(i)], color));
    }
};
static_assert(farfield::Approximation<MeanColorBox>);
