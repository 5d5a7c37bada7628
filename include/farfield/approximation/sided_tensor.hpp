// An opacity tensor with a color for each side of its cell: what is behind something opaque does not show.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <glm/common.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <optional>
#include <span>
#include <type_traits>

#include "farfield/approximation.hpp"
#include "farfield/approximation/cell_faces.hpp"
#include "farfield/approximation/color_cube.hpp"
#include "farfield/approximation/opacity_tensor.hpp"

namespace farfield {

/// 40 bytes a cell: the tensor says how much is seen from a direction, an image sampled from each side in what color. A
/// tensor alone has the mean of all that lies in its cell: of two walls in one cell that face away from each other, it
/// shows the hidden one in nearly half of the pixels (figure 5 of Klein et al. 2002). Building takes longer by the
/// sampling.
struct SidedTensor {
    OpacityTensor tensor{};
    std::uint32_t samples = 4;  ///< along a side of the cell, 1 to 8

    struct stand_in_draft {
        OpacityTensor::stand_in_draft tensor{};
        ColorCube::stand_in_draft faces{};
    };
    struct stand_in_data {
        OpacityTensor::stand_in_data tensor{};
        std::array<Rgba8, 6> colors{};  ///< not premultiplied, alpha 0; sides -x, +x, -y, +y, -z, +z
    };
    static constexpr ApproximationFacts facts{.needs_polygons = true,
                                              .stands_in = true,
                                              .merges_octants = true,
                                              .bounds_error = true,
                                              .provides_area_law = true,
                                              .file_tag = 0x53540001u};

    const char* wrong_option() const {
        if (samples < 1 || samples > 8) return "SidedTensor: samples must be 1 to 8";
        return tensor.wrong_option();
    }
    bool merges_children() const { return true; }

    template <class Contents, OrthographicSampler Sampler>
    stand_in_draft sample(const Cell& cell, Contents&& contents, Sampler& sampler) const {
        return {tensor.sample(cell, contents, sampler), cube().sample(cell, contents, sampler)};
    }
    void merge(const Cell& cell, stand_in_draft& own, std::span<const ChildDraft<stand_in_draft>> children) const {
        std::array<ChildDraft<OpacityTensor::stand_in_draft>, 8> tensors;
        std::array<ChildDraft<ColorCube::stand_in_draft>, 8> faces;
        for (std::size_t i = 0; i < children.size(); ++i) {
            tensors[i] = {children[i].child, children[i].cell, &children[i].draft->tensor};
            faces[i] = {children[i].child, children[i].cell, &children[i].draft->faces};
        }
        tensor.merge(cell, own.tensor, std::span(tensors).first(children.size()));
        cube().merge(cell, own.faces, std::span(faces).first(children.size()));
    }
    stand_in_data finish(const Cell& cell, const stand_in_draft& d) const {
        stand_in_data data{tensor.finish(cell, d.tensor), {}};
        glm::vec4 mean(0);
        for (const glm::vec4& face : d.faces) mean += face;
        for (std::size_t side = 0; side < 6; ++side) {
            // What is only seen edge-on from a side has no color of its own there, and what no sample meets has none.
            const glm::vec4 c = d.faces[side].w > 0 ? d.faces[side] : mean;
            if (c.w > 0) data.colors[side] = to_rgba8(glm::vec4(glm::vec3(c) / c.w, 1));
            data.colors[side].a = c.w > 0 ? 255 : 0;
        }
        return data;
    }

    Work expected_work() const { return tensor.expected_work(); }
    Work work(const stand_in_data& data) const { return tensor.work(data.tensor); }
    std::optional<AreaLaw> area_law(const stand_in_data& data) const { return tensor.area_law(data.tensor); }
    bool is_sound(const stand_in_data& data) const { return tensor.is_sound(data.tensor); }
    float error_px(const stand_in_data& data, const Cell& cell, const LocalView& view) const {
        return tensor.error_px(data.tensor, cell, view);
    }
    float least_error_px(const Cell& cell, unsigned levels, const LocalView& view) const {
        return tensor.least_error_px(cell, levels, view);
    }

    /// As the tensor, in the colors of the sides that look at the viewer.
    template <class Sink>
    void draw_stand_in(const stand_in_data& data, const Cell& cell, const LocalView& view, Sink&& sink) const {
        const VisibleFaces seen(cell, view);
        glm::vec3 sum(0);
        float weight = 0;
        for (int i = 0; i < seen.count; ++i) {
            const Rgba8 c = data.colors[seen.side[std::size_t(i)]];
            if (c.a == 0) continue;
            const float projected = seen.projected[std::size_t(i)];
            sum += glm::vec3(c.r, c.g, c.b) * projected;
            weight += projected;
        }
        const Colored<std::remove_reference_t<Sink>> colored{sink, sink.splat_limit_px, weight > 0,
                                                             sum / std::max(weight, 0x1p-118f)};
        tensor.draw_stand_in(data.tensor, cell, view, colored);
    }
    /// In the tensor's color: from inside a cell no side is seen.
    ContentsBox contents_box(const stand_in_data& data, const Cell& cell, const Box& reach,
                             const LocalView& view) const {
        return tensor.contents_box(data.tensor, cell, reach, view);
    }
    template <class Sink>
    void polygons(const stand_in_data& data, const Cell& cell, Sink&& sink) const {
        tensor.polygons(data.tensor, cell, sink);
    }

  private:
    template <class Sink>
    struct Colored {
        Sink& sink;
        float splat_limit_px;
        bool is_known;  ///< from inside a cell no side is seen
        glm::vec3 rgb;

        void operator()(Splat splat) const {
            if (is_known) splat.rgb = with(255, splat.rgb.a);
            sink(splat);
        }
        void operator()(Face face) const {
            if (is_known) face.rgba = with(face.rgba.a, face.rgba.a);
            sink(face);
        }
        void operator()(OwnRun run) const { sink(run); }

        Rgba8 with(unsigned opacity, std::uint8_t a) const {
            const glm::vec3 c = glm::min(rgb * (float(opacity) / 255) + 0.5f, glm::vec3(255.0f));
            return {std::uint8_t(c.x), std::uint8_t(c.y), std::uint8_t(c.z), a};
        }
    };

    ColorCube cube() const { return {.samples = samples}; }
};

}  // namespace farfield
