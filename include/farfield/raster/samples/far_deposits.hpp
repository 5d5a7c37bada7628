// Deposits faces and splats of the far field into samples.
#pragma once

#include "farfield/settings.hpp"

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "farfield/drawables.hpp"
#include "farfield/geometry/area_law.hpp"
#include "farfield/geometry/rgba8.hpp"
#include "farfield/raster/far_field/face_triangles.hpp"
#include "farfield/raster/sample_projection.hpp"
#include "farfield/raster/samples/sample_buffers.hpp"
#include "farfield/raster/scan_conversion.hpp"

namespace farfield::detail {

/// Buffers::begin_far() must come before the first deposit: SampleBuffers, or SlicedBuffers.
template <class Buffers>
class FarDeposits {
  public:
    FarDeposits(const SampleProjection& projection, Buffers& buffers) : projection_(projection), buffers_(buffers) {}

    /// Deposits into each sample that the face covers.
    void add(const Face& face) {
        const Rgba8 premultiplied = face.rgba;
        if (premultiplied.a == 0) return;
        const float opacity = float(premultiplied.a) * (1 / 255.0f);
        const Loss loss = loss_of_opacity(opacity, law_of_opacity(opacity));
        const glm::vec3 rgb = glm::vec3(float(premultiplied.r), float(premultiplied.g), float(premultiplied.b)) *
                              (1.0f / float(premultiplied.a));
        const FarSamples::Deposit deposit(loss, rgb);
        for_triangles_of(face, projection_, [&](const SnappedTriangle& t, const DepthPlane& plane) {
            scan_convert(t, projection_, [&](int y, int begin, int end) {
                const float row = plane.row(y);
                buffers_.deposit_row(
                    y, begin, end, [&](int x) { return plane.at(row, x); }, deposit);
            });
        });
    }

    /// Deposits a rectangle: each sample gets its share by overlap.
    void add(const Splat& splat) {
        const auto at = projection_.footprint(splat);
        if (!at) return;
        const glm::vec2 upper_left = at->center - at->half, lower_right = at->center + at->half;
        const Loss loss = loss_of_opacity(splat.opacity, AreaLaw(splat.rgb.a));
        const glm::vec3 rgb = glm::vec3(float(splat.rgb.r), float(splat.rgb.g), float(splat.rgb.b)) * (1 / 255.0f);
        buffers_.deposit_square(upper_left.x, upper_left.y, lower_right.x, lower_right.y, at->q, loss, rgb);
    }

  private:
    const SampleProjection& projection_;
    Buffers& buffers_;
};

}  // namespace farfield::detail
