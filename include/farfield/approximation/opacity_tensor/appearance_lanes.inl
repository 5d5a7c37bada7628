// The look of opacity tensors from a direction, of one or of several at once. Included once for each width: see
// appearance_lanes.hpp. There are no include guards; FARFIELD_LANES must be 1, 4 or 8. All widths compute the same
// bits.

#include "farfield/approximation/placed/placed_lanes.inl"

#if FARFIELD_LANES == 1
using Tensors = TensorShape;
inline bool is_coherent(const TensorShape& t) {
    return t.law == AreaLaw::coherent;
}
inline bool is_mixed(const TensorShape& t) {
    return t.law == AreaLaw::mixed;
}
#else
/// The lanes of several TensorShapes.
struct Tensors {
    Floats root[6];
    Vector facing, tone, center, extent, rgb;
    Words law;
};

FARFIELD_INLINE Mask is_coherent(const Tensors& t) {
    return t.law == std::uint32_t(AreaLaw::coherent);
}
FARFIELD_INLINE Mask is_mixed(const Tensors& t) {
    return t.law == std::uint32_t(AreaLaw::mixed);
}
#endif

/// See appearance_lanes.hpp.
FARFIELD_INLINE Floats area_seen_from(const Tensors& t, const Vector& w) {
    const Vector u{t.root[0] * w.x + t.root[1] * w.y + t.root[2] * w.z, t.root[3] * w.y + t.root[4] * w.z,
                   t.root[5] * w.z};
    return root_of(dot(u, u));
}

/// See appearance_lanes.hpp.
FARFIELD_INLINE Floats outline_from(const Tensors& t, const Vector& w) {
    const Vector& e = t.extent;
    const Vector sides = times(absolute(w), Vector{e.y * e.z, e.z * e.x, e.x * e.y});
    const Floats outline = sides.x + sides.y + sides.z;
    return is_coherent(t) ? outline : 0.15f * outline + 0.85f * root_of(dot(sides, sides));
}

/// See appearance_lanes.hpp.
FARFIELD_INLINE Vector sheet_normal(const Tensors& t) {
    const auto& r = t.root;
    const Floats first = r[0] * r[0] + r[1] * r[1] + r[2] * r[2];
    const Floats second = r[3] * r[3] + r[4] * r[4], third = r[5] * r[5];
    const Floats most = 0.9f * (first + second + third), none{};
    const Mask is_first = first > most, is_second = second > most, is_third = third > most;
    const Floats y = is_second ? r[3] : none, z = is_second ? r[4] : is_third ? r[5] : none;
    return {is_first ? r[0] : none, is_first ? r[1] : y, is_first ? r[2] : z};
}

/// What absorbed() of geometry/area_law.hpp gives.
FARFIELD_INLINE Floats absorbed_part(const Floats& x) {
    const Floats y = x < 24.0f ? 0.125f * x : all_of(3.0f);
    Floats part = 12.0f * y / (12.0f + y * (6.0f + y));
    for (int i = 0; i < 3; ++i) part *= 2.0f - part;
    return part;
}

/// Area covered, each place once, and color, 0 to 255. An area that is not above 0 is not seen, whatever its color.
struct Seen {
    Floats area;
    Vector rgb;
};
FARFIELD_INLINE Seen seen_from(const Tensors& t, const Vector& w, bool closed_surfaces, bool counts_overlap) {
    Floats area = area_seen_from(t, w);
    Mask is_hidden = (area > 0.0f) == Mask{};
    Floats tone = greater(1.0f + dot(t.tone, w) / area, Floats{});
    if (closed_surfaces) {
        const Floats fronts = 1.0f + lesser(greater(dot(t.facing, w) / area, all_of(-1.0f)), all_of(1.0f));
        is_hidden = is_hidden | (fronts < 0.04f);
        tone = lesser(tone / fronts, all_of(2.0f));
        area *= 0.5f * fronts;
    }
    if (counts_overlap) {
        const Floats outline = outline_from(t, w), times = area / outline;
        const Mask mixed = is_mixed(t);
        const Floats half = absorbed_part(mixed ? 0.5f * times : times);
        const Floats lost = is_coherent(t) ? times : mixed ? half + half : half, left = 1.0f - lost;
        area = outline * (1.0f - (left > 0.0f ? left : Floats{}));
    }
    const Vector rgb = t.rgb * tone;
    const Floats most = all_of(255.0f);
    return {is_hidden ? Floats{} : area,
            {is_hidden ? t.rgb.x : lesser(rgb.x, most), is_hidden ? t.rgb.y : lesser(rgb.y, most),
             is_hidden ? t.rgb.z : lesser(rgb.z, most)}};
}

/// Width and height, in the picture, of the rectangle that is drawn about `center` and has room for this area.
struct Size {
    Floats x, y;
};
FARFIELD_INLINE Floats by_axis(const Mask& is_x, const Mask& is_y, const Vector& v) {
    return is_x ? v.x : is_y ? v.y : v.z;
}
FARFIELD_INLINE Size with_room(const Size& size, const Floats& area) {
    const Floats scale = root_of(greater(area / (size.x * size.y), all_of(1.0f)));
    return {size.x * scale, size.y * scale};
}
FARFIELD_INLINE Size rectangle(const Tensors& t, const Vector& center, const LocalView& view, const Floats& area) {
    Vector right = all_of(view.right), up = all_of(view.up);
    if (view.is_perspective) {  // points that lie deeper are nearer to the vanishing point
        const Vector d = center - all_of(view.eye), forward = all_of(view.forward);
        const Floats inverse = 1.0f / dot(d, forward);
        const Floats along_right = dot(d, right) * inverse, along_up = dot(d, up) * inverse;
        right = right - forward * along_right;
        up = up - forward * along_up;
    }
    const Vector wide = times(right, t.extent), high = times(up, t.extent);
    const Size strewn = with_room({root_of(dot(wide, wide)), root_of(dot(high, high))}, area);
    const Mask coherent = is_coherent(t);
    if (!any(coherent)) return strewn;
    // In a flat sheet the coordinate in which it is steepest follows from the others: it is not as large as its box.
    const Size box{dot(absolute(right), t.extent), dot(absolute(up), t.extent)};
    const Vector n = sheet_normal(t), steep = absolute(n);
    const Mask is_x = (steep.x >= steep.y) & (steep.x >= steep.z), is_y = steep.y >= steep.z;
    const Floats steepest = by_axis(is_x, is_y, n);
    const Mask is_flat = steepest != 0.0f;
    const Floats along_right = is_flat ? by_axis(is_x, is_y, right) / steepest : Floats{},
                 along_up = is_flat ? by_axis(is_x, is_y, up) / steepest : Floats{};
    right = right - n * along_right;
    up = up - n * along_up;
    const Floats least = all_of(0x1p-8f);  // edge-on
    Size sheet{greater(lesser(dot(absolute(right), t.extent), box.x), least),
               greater(lesser(dot(absolute(up), t.extent), box.y), least)};
    // What takes more room than one sheet has is several, strewn over their box.
    const Floats times = area / (sheet.x * sheet.y);
    const Mask has_no_room = times > 1.0f;
    const Floats more = lesser(4.0f * (times - 1.0f), all_of(1.0f));
    const Size larger = with_room(
        {sheet.x + greater(box.x - sheet.x, Floats{}) * more, sheet.y + greater(box.y - sheet.y, Floats{}) * more},
        area);
    sheet = {has_no_room ? larger.x : sheet.x, has_no_room ? larger.y : sheet.y};
    return {coherent ? sheet.x : strewn.x, coherent ? sheet.y : strewn.y};
}

#if FARFIELD_LANES != 1

/// Bits [at, at + count) of two words, the low one first.
template <unsigned at, unsigned count>
FARFIELD_INLINE Words bits_of(const Words& low, const Words& high) {
    constexpr std::uint32_t all = (1u << count) - 1;
    if constexpr (at >= 32) {
        return high >> (at - 32) & all;
    } else if constexpr (at + count <= 32) {
        return low >> at & all;
    } else {
        return (low >> at | high << (32 - at)) & all;
    }
}
template <unsigned at, unsigned count, int less = 0>
FARFIELD_INLINE Floats number_of(const Words& low, const Words& high) {
    return number_of(bits_of<at, count>(low, high), less);
}

/// The extent of a StoredTensor of that code: see StoredTensor::extents.
FARFIELD_INLINE Floats extent_of(const Words& code) {
    const Words octave = code >> 3;
    const Words step = (code & 7u) + (octave == 0u ? Words{} + 1u : Words{} + 9u);
    // The lowest two octaves are counted in 2^-6, each of the others in twice as much.
    const Words exponent = (octave == 0u ? Words{} + 1u : octave) + (127u - 7u);
    return number_of(step) * as_floats(exponent << 23);
}

/// What StoredTensor::unpacked() gives.
FARFIELD_INLINE void unpack(const Words w[PlacedTensor::words], Tensors& t) {
    const Floats scale = as_floats(w[PlacedTensor::scale]);
    const Floats root_step = scale * (1.0f / 31), step = scale * (1.0f / 15);
    t.root[0] = number_of<0, 6, 32>(w[0], w[1]) * root_step;
    t.root[1] = number_of<6, 6, 32>(w[0], w[1]) * root_step;
    t.root[2] = number_of<12, 6, 32>(w[0], w[1]) * root_step;
    t.root[3] = number_of<18, 6, 32>(w[0], w[1]) * root_step;
    t.root[4] = number_of<24, 6, 32>(w[0], w[1]) * root_step;
    t.root[5] = number_of<30, 6, 32>(w[0], w[1]) * root_step;
    t.center = Vector{number_of<36, 5>(w[0], w[1]), number_of<41, 5>(w[0], w[1]), number_of<46, 5>(w[0], w[1])} *
               all_of(1.0f / 32);
    t.extent = {extent_of(bits_of<51, 4>(w[0], w[1]) | bits_of<61, 1>(w[2], w[3]) << 4),
                extent_of(bits_of<55, 4>(w[0], w[1]) | bits_of<62, 1>(w[2], w[3]) << 4),
                extent_of(bits_of<59, 4>(w[0], w[1]) | bits_of<63, 1>(w[2], w[3]) << 4)};
    t.facing =
        Vector{number_of<0, 5, 16>(w[2], w[3]), number_of<5, 5, 16>(w[2], w[3]), number_of<10, 5, 16>(w[2], w[3])} *
        step;
    t.tone =
        Vector{number_of<15, 5, 16>(w[2], w[3]), number_of<20, 5, 16>(w[2], w[3]), number_of<25, 5, 16>(w[2], w[3])} *
        step;
    t.rgb = {number_of<30, 5>(w[2], w[3]) * (255.0f / 31), number_of<35, 6>(w[2], w[3]) * (255.0f / 63),
             number_of<41, 5>(w[2], w[3]) * (255.0f / 31)};
    t.law = w[3] >> 22 & 3u;
}

/// Fills `out` with the splats of `count` placed tensors, FARFIELD_LANES at most. False: a length needs more care than
/// is taken here, and nothing is filled.
inline bool splats_of(const std::uint32_t* placed, std::size_t count, const LocalView& view,
                      const TensorOptions& options, PlacedSplats& out) {
    Words w[PlacedTensor::words];
    for (std::size_t i = 0; i < PlacedTensor::words; ++i) w[i] = word_of(placed, i);
    Tensors t;
    unpack(w, t);
    const Floats unit = as_floats(w[PlacedTensor::unit]);
    const Vector center = vector_of(placed, PlacedTensor::x) + t.center * unit;
    Sight sight;
    if (!sight_of(center, count, view, sight)) return false;
    const Vector& d = sight.towards;
    const Vector towards{d.x / sight.distance, d.y / sight.distance, d.z / sight.distance};
    const Seen seen = seen_from(t, towards, options.closed_surfaces, options.counts_overlap);
    const Floats area = seen.area * sight.stretch;
    const Size size = rectangle(t, center, view, area);
    const Floats part = area / (size.x * size.y);
    const Vector& e = t.extent;
    const Floats second = greater(lesser(e.x, e.y), lesser(greater(e.x, e.y), e.z));
    const Mask gains = is_coherent(t) & (second * unit >= as_floats(w[PlacedTensor::reach]));
    const Floats opacity = lesser((gains ? all_of(options.sheet_gain) : all_of(1.0f)) * part, all_of(1.0f));
    fill(out, center, size.x * unit, size.y * unit, opacity, seen.rgb + all_of(glm::vec3(0.5f)), t.law,
         sight.is_seen & (seen.area > 0.0f));
    return true;
}

#endif
