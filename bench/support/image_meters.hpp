// A z-buffer that looks at what images do: how far what they show is displaced.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "farfield/drawables.hpp"
#include "farfield/renderer.hpp"
#include "farfield/renderer/z_buffer_renderer.hpp"
#include "farfield/view/local_view.hpp"

namespace farfield::bench {

/// A z-buffer that is given one slice of an image after the other.
inline constexpr RendererFacts slice_by_slice = [] {
    RendererFacts facts = ZBufferRenderer::facts;
    facts.slices_images = false;
    return facts;
}();

/// Keeps corners of what each image was made of, and where the image shows them: where the ray to them from the eye
/// that made it meets its rectangle; where an image was made of images, where it shows what those show. In every frame
/// it compares, for each image drawn, where they are seen with where they would be. In perspective.
class DisplacementMeter : public ZBufferRenderer {
  public:
    using ZBufferRenderer::ZBufferRenderer;
    static constexpr RendererFacts facts = slice_by_slice;

    /// Pixels, over all frames.
    float largest_px() const { return largest_px_; }
    std::uint64_t compared() const { return compared_; }

    void begin_frame(const LocalView& view) {
        outermost_ = local_ = view;
        ZBufferRenderer::begin_frame(view);
    }
    void set_view(const LocalView& view) {
        local_ = view;
        ZBufferRenderer::set_view(view);
    }
    template <class P>
    void draw(const Source<P>& source, std::span<const Range> ranges) {
        if (makes_image_) {
            for (const Range& r : ranges) sample(source, r);
        }
        ZBufferRenderer::draw(source, ranges);
    }
    void draw(std::span<const Face> faces) { ZBufferRenderer::draw(faces); }
    void draw(std::span<const Splat> splats) { ZBufferRenderer::draw(splats); }
    void draw(std::span<const ImageQuad> quads) {
        for (const ImageQuad& q : quads) {
            const std::vector<Sample>& shown = images_[q.image];
            const auto here = [&](const Sample& s) { return Sample{outside(local_, s.is), outside(local_, s.shown)}; };
            if (makes_image_) {
                for (std::size_t i = 0; i < shown.size(); i += 1 + shown.size() / 64) keep(here(shown[i]));
            } else {
                for (const Sample& s : shown) compare(here(s));
            }
        }
        ZBufferRenderer::draw(quads);
    }
    void begin_image(const LocalView& view, float quad_depth, int samples) {
        local_ = image_view_ = view;
        quad_depth_ = quad_depth;
        makes_image_ = true;
        made_.clear();
        ZBufferRenderer::begin_image(view, quad_depth, samples);
    }
    std::uint32_t end_image() {
        makes_image_ = false;
        const std::uint32_t image = ZBufferRenderer::end_image();
        if (image == 0) return 0;
        if (images_.size() <= image) images_.resize(image + 1);
        const glm::vec3 eye = outside(image_view_, image_view_.eye);
        for (Sample& s : made_) {
            const float depth = glm::dot(s.shown - eye, outermost_.forward);
            s = {inside(image_view_, s.is),
                 inside(image_view_, eye + (s.shown - eye) * (quad_depth_ * image_view_.scale / depth))};
        }
        images_[image] = made_;
        return image;
    }

  private:
    /// Of an image, in the coordinates of the hierarchy that has it: it may be made from where the viewer will be.
    /// While it is made, in those of the outermost one, as if the viewer were there.
    struct Sample {
        glm::vec3 is, shown;
    };

    glm::vec3 inside(const LocalView& view, glm::vec3 p) const {
        const glm::vec3 d = (p - outermost_.eye) / view.scale;
        return view.eye + view.right * glm::dot(d, outermost_.right) + view.up * glm::dot(d, outermost_.up) +
               view.forward * glm::dot(d, outermost_.forward);
    }
    glm::vec3 outside(const LocalView& view, glm::vec3 p) const {
        const glm::vec3 d = (p - view.eye) * view.scale;
        return outermost_.eye + outermost_.right * glm::dot(d, view.right) + outermost_.up * glm::dot(d, view.up) +
               outermost_.forward * glm::dot(d, view.forward);
    }
    template <class P>
    void sample(const Source<P>& source, const Range& range) {
        const std::uint32_t step = 1 + range.count / 64;
        for (std::uint32_t i = next() % step; i < range.count; i += step) {
            source.polygons(range.first + i, [&](const Polygon& polygon) {
                const glm::vec3 p = polygon.vertices[next() % polygon.vertices.size()];
                const float depth = image_view_.depth(p);
                // Of slices each shows its own.
                if (!(depth > image_view_.near_depth && depth < image_view_.far_depth)) return;
                const glm::vec3 at = outside(local_, p);
                keep({at, at});
            });
        }
    }
    /// At most so many, each as likely as another.
    void keep(const Sample& s) {
        constexpr std::size_t most = 256;
        if (made_.size() < most) {
            made_.push_back(s);
        } else if (const std::size_t at = next() % (4 * most); at < most) {
            made_[at] = s;
        }
    }
    void compare(const Sample& s) {
        const auto seen = [&](glm::vec3 p) {
            const glm::vec3 d = p - outermost_.eye;
            return glm::vec2(glm::dot(d, outermost_.right), glm::dot(d, outermost_.up)) *
                   (outermost_.focal_px / glm::dot(d, outermost_.forward));
        };
        if (!(outermost_.depth(s.is) > 0)) return;
        const glm::vec2 at = seen(s.is);
        const glm::vec2 half = glm::vec2(outermost_.width, outermost_.height) * 0.5f;
        if (!(glm::abs(at.x) <= half.x && glm::abs(at.y) <= half.y)) return;
        largest_px_ = std::max(largest_px_, glm::length(seen(s.shown) - at));
        ++compared_;
    }
    std::uint32_t next() {
        random_ = random_ * 6364136223846793005u + 1442695040888963407u;
        return std::uint32_t(random_ >> 33);
    }

    LocalView outermost_{View{}, {}, 1}, local_ = outermost_, image_view_ = outermost_;
    float quad_depth_ = 0;
    bool makes_image_ = false;
    std::vector<Sample> made_;
    std::vector<std::vector<Sample>> images_;  ///< by handle
    std::uint64_t random_ = 1;
    float largest_px_ = 0;
    std::uint64_t compared_ = 0;
};

}  // namespace farfield::bench
