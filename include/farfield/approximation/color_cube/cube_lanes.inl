// Splats of color cubes, of several at once. Included once for each width: see cube_lanes.hpp. There are no include
// guards; FARFIELD_LANES must be 4 or 8. All widths compute the same bits.

#include "farfield/approximation/placed/placed_lanes.inl"

/// What the visible faces add up to: VisibleFaces of cell_faces.hpp, and ColorCube::draw_stand_in.
struct FaceSums {
    Floats footprint{};
    Vector rgb{};
    Floats alpha{};

    /// `area` is a face's, `along` the part of the direction, of this length, to the viewer that is its axis's.
    FARFIELD_INLINE void add(const Floats& area, const Floats& along, const Floats& reach, const Floats& inverse_length,
                             const Words& lower, const Words& upper) {
        const Floats wide = absolute(along);
        const Floats projected = wide > reach ? area * wide * inverse_length : Floats{};
        const Words color = along > 0.0f ? upper : lower;
        footprint += projected;
        rgb = rgb +
              Vector{number_of(color & 255u), number_of(color >> 8 & 255u), number_of(color >> 16 & 255u)} * projected;
        alpha += number_of(color >> 24) * projected;
    }
};

FARFIELD_INLINE Words word_of(AreaLaw law) {
    return Words{} + std::uint32_t(law);
}

/// Fills `out` with the splats of `count` placed cubes, FARFIELD_LANES at most. False: a length needs more care than
/// is taken here, and nothing is filled.
inline bool splats_of(const std::uint32_t* placed, std::size_t count, const LocalView& view, PlacedSplats& out) {
    const Vector center = vector_of(placed, PlacedCube::center), half = vector_of(placed, PlacedCube::half);
    Sight sight;
    if (!sight_of(center, count, view, sight)) return false;
    // What length_unit() of cell_faces.hpp takes from the bits.
    const Words exponent = reinterpret_cast<Words>(2.0f * greater(half.x, greater(half.y, half.z))) >> 23 & 255u;
    if (any(sight.is_there & (exponent - 1u >= 252u))) return false;
    const Floats unit = as_floats((exponent + 1u) << 23);
    const Vector h = half * (1.0f / unit), reach = view.is_perspective ? half : Vector{};
    const Floats inverse_length = 1.0f / sight.distance;
    const std::uint32_t* const colors = placed + PlacedCube::colors * PlacedCube::stride;
    FaceSums sums;
    sums.add(4.0f * h.y * h.z, sight.towards.x, reach.x, inverse_length, word_of(colors, 0), word_of(colors, 1));
    sums.add(4.0f * h.z * h.x, sight.towards.y, reach.y, inverse_length, word_of(colors, 2), word_of(colors, 3));
    sums.add(4.0f * h.x * h.y, sight.towards.z, reach.z, inverse_length, word_of(colors, 4), word_of(colors, 5));
    // What splat_of() of cell_faces.hpp gives.
    const Floats alpha = lesser(sums.alpha / (255.0f * sums.footprint), all_of(1.0f));
    const Words law = alpha >= 0.75f    ? word_of(AreaLaw::coherent)
                      : alpha >= 0.375f ? word_of(AreaLaw::mixed)
                                        : word_of(AreaLaw::independent);
    const Vector rgb = sums.rgb * (255.0f / greater(sums.alpha, all_of(0x1p-118f))) + all_of(glm::vec3(0.5f));
    const Floats most = all_of(255.0f), side = unit * root_of(sums.footprint * sight.stretch);
    fill(out, center, side, side, alpha, {lesser(rgb.x, most), lesser(rgb.y, most), lesser(rgb.z, most)}, law,
         sight.is_seen & (sums.alpha > 0.0f));
    return true;
}
