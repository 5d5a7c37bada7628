// An approximation of your own: the box of the cell in one color, with one opacity. Four bytes a cell.
#pragma once

#include <cstdint>
#include <glm/vec4.hpp>
#include <span>
#include <vector>

#include "farfield/approximation/cell_faces.hpp"
#include "farfield/policy.hpp"

struct MeanColorBox {
    // ---- Options.

    /// Orthographic samples along a side of the box.
    std::uint32_t samples = 4;

    // ---- Required by farfield::Approximation.

    static constexpr farfield::ApproximationFacts facts{
        .needs = farfield::needs_polygons, .stands_in = true, .file_tag = 0x6d630001u};

    /// Kept for every cell that has a stand-in. Trivially copyable.
    using cell_data = farfield::Rgba8;  // premultiplied
    /// For data of varying size there is a pool; this has none.
    struct pool_element {};

    // ---- Required by farfield::MakesStandIns, since the facts say `stands_in`.

    /// What a stand-in is while it is made.
    using draft = glm::vec4;  // premultiplied

    /// True: sample() gets the whole subtree. False: it gets the node's own primitives, and merge() adds its children.
    bool wants_all_contents(const farfield::PartitionFacts&) const { return true; }

    /// The mean over what is seen through the six sides.
    template <class Contents, farfield::OrthographicSampler Sampler>
    draft sample(const farfield::Cell& cell, Contents&& contents, Sampler& sampler) const {
        const farfield::SampleGrid grid{cell.bounds(), samples, 1};
        std::vector<farfield::Rgba8> seen(grid.size());
        sampler.sample(grid, contents, std::span<farfield::Rgba8>(seen));
        glm::vec4 sum(0);
        for (const farfield::Rgba8 c : seen) sum += farfield::to_vec4(c);
        // Contents of a loose cell stick out of it; its box has to cover as much as they do.
        const float own = surface(cell.half);
        const float enlarged = own > 0 ? surface(cell.bounds_half) / own : 0.0f;
        const glm::vec4 mean = sum * (enlarged / float(seen.size()));
        return mean.a > 1 ? mean / mean.a : mean;
    }

    void merge(const farfield::Cell&, draft&, std::span<const farfield::ChildDraft<draft>>) const {}

    cell_data finish(const farfield::Cell&, const draft& mean, std::vector<pool_element>&) const {
        return farfield::to_rgba8(mean);
    }

    /// What drawing takes, for the cost model: of any, before there is one, and of this one.
    farfield::Work expected_work() const { return {.faces = 3}; }
    farfield::Work work(const cell_data&) const { return expected_work(); }

    /// A box may be taken for its contents as long as it is about a pixel.
    float error_px(const cell_data&, const farfield::Cell& cell, const farfield::LocalView& view) const {
        return view.pixels(cell.largest_side(), view.distance_to(cell));
    }

    /// Draws it: the faces that look at the viewer, at most three.
    template <class Sink>
    void stand_in(const cell_data& color, std::span<const pool_element>, const farfield::Cell& cell,
                  const farfield::LocalView& view, Sink&& sink) const {
        if (color.a == 0) return;
        const farfield::VisibleFaces faces(cell, view);
        for (int i = 0; i < faces.count; ++i) sink(farfield::face_of(cell, faces.side[std::size_t(i)], color));
    }

    /// All six, for hierarchies that hold an instance of this one.
    template <class Sink>
    void polygons(const cell_data& color, std::span<const pool_element>, const farfield::Cell& cell,
                  Sink&& sink) const {
        for (unsigned side = 0; side < 6; ++side) farfield::emit_polygon(farfield::face_of(cell, side, color), sink);
    }

    // ---- Helpers.

  private:
    static float surface(glm::vec3 half) { return half.x * half.y + half.y * half.z + half.z * half.x; }
};

static_assert(farfield::Approximation<MeanColorBox>);
