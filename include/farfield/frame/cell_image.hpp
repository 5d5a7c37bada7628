// An image of a cell as a viewer keeps it: where its rectangle lies, and whether it may be drawn in a view (Shade et
// al. 1996, sections 2 and 3).
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <limits>
#include <optional>

#include "farfield/drawables.hpp"
#include "farfield/frame/safety_zone.hpp"
#include "farfield/geometry/length.hpp"
#include "farfield/image_cache_options.hpp"
#include "farfield/view/local_view.hpp"

namespace farfield::detail {

/// A rectangle of the whole picture's pixels, possibly beyond it.
struct ImageRect {
    int left = 0, top = 0, width = 0, height = 0;
};

/// An image of a cell: one rectangle a depth slice, front to back.
struct CellImage {
    ImagePlace place;  ///< with the depths of the slice asked for last
    int slices = 0;
    std::array<std::uint32_t, ImageCacheOptions::most_slices> handles{};
    std::array<ImageSlice, ImageCacheOptions::most_slices> extents{};  ///< as far as the box reaches
    glm::vec3 corner{0}, across{0}, down{0};  ///< from the eye, at depth 1; in a parallel view as they are
    float pixels_a_unit = 1;                  ///< at the box's center
    /// Seen from within this radius of where it was made, nothing in it subtends a larger angle than one of this sine:
    /// the paper's safety zone, which is quick to ask.
    float safe_radius = 0, safe_sine = 0;
    std::uint64_t bytes = 0;
    float whole_price = 0;   ///< of drawing what it shows, all of it
    float making_price = 0;  ///< of making it, that included
    std::uint32_t made_frame = 0;
    std::uint32_t lives = 1;  ///< frames that it was made for
    /// What it shows is partly images of cells below: it is good inside this sphere, where nothing in those subtends a
    /// larger angle than one of this sine, and itself for half the threshold.
    float inherited_radius = std::numeric_limits<float>::infinity(), inherited_sine = 0;
    bool is_of_images = false;

    ImagePlace slice(int i) const {
        ImagePlace p = place;
        p.depth = extents[std::size_t(i)].depth;
        p.nearest = extents[std::size_t(i)].nearest;
        p.farthest = extents[std::size_t(i)].farthest;
        p.is_slice = slices > 1;
        return p;
    }
    ImageQuad quad(int i) const {
        const float depth = extents[std::size_t(i)].depth;
        if (!place.is_perspective)
            return {handles[std::size_t(i)], place.eye + place.forward * depth + corner, across, down};
        return {handles[std::size_t(i)], place.eye + corner * depth, across * depth, down * depth};
    }
};

/// The pixels that a cell's contents may touch, some more included ("an axis-aligned rectangle that is guaranteed to
/// contain the image of the node's contents"). None if it reaches behind the viewer or past the near plane.
inline std::optional<ImageRect> image_rect(const LocalView& view, glm::vec3 center, glm::vec3 half) {
    glm::vec2 low(std::numeric_limits<float>::infinity()), high = -low;
    const glm::vec2 focal = view.focal_px * view.squeeze;
    for (unsigned i = 0; i < 8; ++i) {
        const glm::vec3 p =
            center + half * glm::vec3((i & 1) ? 1 : -1, (i & 2) ? 1 : -1, (i & 4) ? 1 : -1) - view.anchor;
        const float depth = glm::dot(p, view.forward) + view.anchor_depth;
        if (!(depth > view.near_depth) || !(depth < view.far_depth)) return {};
        const glm::vec2 at =
            focal * glm::vec2(glm::dot(p, view.right), -glm::dot(p, view.up)) / (view.is_perspective ? depth : 1.0f);
        low = glm::min(low, at);
        high = glm::max(high, at);
    }
    constexpr float most = 8192;
    if (!(low.x > -most && low.y > -most && high.x < most && high.y < most)) return {};
    const glm::dvec2 size(view.part.whole_width, view.part.whole_height);
    const glm::dvec2 axis = size * 0.5 * (1.0 + view.whole_off_center * glm::dvec2(-1, 1));
    const double margin = 1 + std::ceil(double(view.reach_px));
    const glm::dvec2 first = glm::floor(glm::dvec2(low) + axis) - margin,
                     end = glm::ceil(glm::dvec2(high) + axis) + margin;
    return ImageRect{int(first.x), int(first.y), int(end.x - first.x), int(end.y - first.y)};
}

/// The image that a view would make of a box, without handles.
inline CellImage planned_image(const LocalView& view, glm::vec3 center, glm::vec3 half, const ImageRect& rect,
                               int slices) {
    CellImage image;
    image.place = {.eye = view.eye,
                   .forward = view.forward,
                   .center = center,
                   .half = half,
                   .is_perspective = view.is_perspective};
    const float middle = view.depth(center), reach = glm::dot(glm::abs(view.forward), half);
    const float nearest = middle - reach, farthest = middle + reach;
    image.slices = slices;
    // Parallax goes with the difference of inverse depths, so slices are even in those, and each rectangle lies in the
    // middle. Slices overlap by an eighth. A single one lies "at constant depth through the center of the node's
    // bounding box".
    const auto between = [&](float part) {
        if (!view.is_perspective) return nearest + (farthest - nearest) * part;
        return 1 / (1 / nearest + (1 / farthest - 1 / nearest) * part);
    };
    for (int i = 0; i < slices; ++i) {
        constexpr float overlap = 0.0625f;
        const auto number = float(i), count = float(slices);
        image.extents[std::size_t(i)] = {slices == 1 ? middle : between((number + 0.5f) / count),
                                         i == 0 ? nearest : between((number - overlap) / count),
                                         i + 1 == slices ? farthest : between((number + 1 + overlap) / count)};
    }
    const glm::dvec2 size(view.part.whole_width, view.part.whole_height);
    const glm::dvec2 axis = size * 0.5 * (1.0 + view.whole_off_center * glm::dvec2(-1, 1));
    const glm::vec2 unit = 1.0f / (view.focal_px * view.squeeze);
    const glm::vec2 upper_left = glm::vec2(glm::dvec2(rect.left, rect.top) - axis) * unit;
    image.corner = view.right * upper_left.x - view.up * upper_left.y;
    if (view.is_perspective) image.corner += view.forward;
    image.across = view.right * (float(rect.width) * unit.x);
    image.down = -view.up * (float(rect.height) * unit.y);
    image.pixels_a_unit = view.pixels(1, length_of(center - view.eye));
    return image;
}

/// "If the dimensions of the rectangle exceed those of the viewport, no image is cached."
inline std::optional<ImageRect> fitting_rect(const LocalView& view, glm::vec3 center, glm::vec3 half) {
    const std::optional<ImageRect> rect = image_rect(view, center, half);
    if (rect && (rect->width > view.part.whole_width || rect->height > view.part.whole_height)) return {};
    return rect;
}
/// The image that a view would make of a box outside of which it is.
inline std::optional<CellImage> image_that_fits(const LocalView& view, glm::vec3 center, glm::vec3 half, int slices) {
    const std::optional<ImageRect> rect = fitting_rect(view, center, half);
    if (!rect || (view.is_perspective && Box{center - half, center + half}.contains(view.eye))) return {};
    return planned_image(view, center, half, *rect, slices);
}

/// The sine of the angle that displaces something by `part` of the threshold.
inline float allowed_sine(const LocalView& view, const ImageCacheOptions& options, float part) {
    const float pixels = options.threshold_px * part;
    return options.is_conservative ? sine_of_pixels_anywhere(pixels, view) : sine_of_pixels(pixels, view);
}
/// The radius of the sphere around where an image was made in which nothing that its slices show is displaced by more
/// than an angle of that sine. In perspective.
inline float safe_radius_of(const CellImage& image, float sine, bool is_conservative) {
    float radius = std::numeric_limits<float>::infinity();
    // Slices between the first and the last are displaced less than one of these: see planned_image().
    for (int i = 0; i < image.slices; i += std::max(1, image.slices - 1)) {
        const ImagePlace place = image.slice(i);
        radius = std::min(radius, is_conservative ? conservative_radius(place, sine) : safety_radius(place, sine));
    }
    return radius;
}
/// Sets the zone in which the image is good.
inline void set_safety_zone(CellImage& image, const LocalView& view, const ImageCacheOptions& options) {
    image.safe_sine = allowed_sine(view, options, image.is_of_images ? 0.5f : 1.0f);
    image.safe_radius = safe_radius_of(image, image.safe_sine, options.is_conservative);
}
/// Makes a box hold more than the cell's, as rectangles that an image of one slice shows reach out of it.
inline void enlarge_box(CellImage& image, const LocalView& view, glm::vec3 low, glm::vec3 high) {
    image.place.center = 0.5f * (low + high);
    image.place.half = 0.5f * (high - low);
    image.pixels_a_unit = view.pixels(1, length_of(image.place.center - view.eye));
    const float middle = view.depth(image.place.center), reach = glm::dot(glm::abs(view.forward), image.place.half);
    image.extents[0].nearest = std::min(image.extents[0].nearest, middle - reach);
    image.extents[0].farthest = std::max(image.extents[0].farthest, middle + reach);
}

/// Whether an image may be drawn in a view in place of what it shows, with its error at most `part` of the threshold.
inline bool is_good(const CellImage& image, const LocalView& view, const ImageCacheOptions& options, float part = 1) {
    const glm::vec3 from_center = glm::abs(view.eye - image.place.center);
    // "Geometry is always drawn if the viewpoint is inside the node."
    if (view.is_perspective && glm::all(glm::lessThanEqual(from_center, image.place.half))) return false;
    const float now = view.pixels(1, length_of(image.place.center - view.eye));
    if (!(now <= image.pixels_a_unit * options.most_magnified && now * options.most_minified >= image.pixels_a_unit))
        return false;
    if (image.is_of_images) {
        if (!(length_of(view.eye - image.place.eye) <= image.inherited_radius)) return false;
        part *= 0.5f;
        // It is the same angle unless resolution or field of view have changed.
        if (!(image.inherited_sine <= allowed_sine(view, options, part))) return false;
    }
    const bool is_safe = view.is_perspective && image.safe_sine > 0 &&
                         length_of(view.eye - image.place.eye) <= image.safe_radius &&
                         image.safe_sine <= allowed_sine(view, options, part);
    for (int i = 0; i < image.slices; i += std::max(1, image.slices - 1)) {
        const ImageQuad quad = image.quad(i);
        for (const glm::vec3& p :
             {quad.corner, quad.corner + quad.across, quad.corner + quad.down, quad.corner + quad.across + quad.down}) {
            if (!(view.depth(p) > view.near_depth)) return false;
        }
        if (is_safe) continue;
        const ImagePlace slice = image.slice(i);
        const float displaced =
            options.is_conservative ? displacement_bound_px(slice, view) : displacement_px(slice, view);
        if (!(displaced <= options.threshold_px * part)) return false;
    }
    return true;
}

}  // namespace farfield::detail
