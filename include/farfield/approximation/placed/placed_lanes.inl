// Vectors of numbers for what stand-ins look like: of one, four or eight at once. Included once for each width and kind
// of stand-in, in a namespace of its own: see placed_splats.hpp. There are no include guards; FARFIELD_LANES must be 1,
// 4 or 8. All widths compute the same bits.

#if FARFIELD_LANES == 1
using Floats = float;
using Words = std::uint32_t;
using Mask = bool;
using Vector = glm::vec3;
inline bool any(bool mask) {
    return mask;
}
inline float absolute(float v) {
    return std::abs(v);
}
inline float root_of(float v) {
    return std::sqrt(v);
}
#else
typedef float Floats __attribute__((vector_size(4 * FARFIELD_LANES)));
typedef std::uint32_t Words __attribute__((vector_size(4 * FARFIELD_LANES)));
typedef std::int32_t Mask __attribute__((vector_size(4 * FARFIELD_LANES)));
struct Vector {
    Floats x, y, z;

    FARFIELD_INLINE friend Vector operator+(const Vector& a, const Vector& b) {
        return {a.x + b.x, a.y + b.y, a.z + b.z};
    }
    FARFIELD_INLINE friend Vector operator-(const Vector& a, const Vector& b) {
        return {a.x - b.x, a.y - b.y, a.z - b.z};
    }
    FARFIELD_INLINE friend Vector operator*(const Vector& a, const Floats& b) { return {a.x * b, a.y * b, a.z * b}; }
};
FARFIELD_INLINE bool any(const Mask& mask) {
#if FARFIELD_LANES == 8
    return _mm256_movemask_ps(reinterpret_cast<__m256>(mask)) != 0;
#else
    std::uint64_t half[2];
    __builtin_memcpy(half, &mask, sizeof half);
    return (half[0] | half[1]) != 0;
#endif
}
FARFIELD_INLINE Floats absolute(const Floats& v) {
    return reinterpret_cast<Floats>(reinterpret_cast<Words>(v) & 0x7fffffffu);
}
FARFIELD_INLINE Floats root_of(const Floats& v) {
#if FARFIELD_LANES == 8
    return reinterpret_cast<Floats>(_mm256_sqrt_ps(reinterpret_cast<__m256>(v)));
#elif defined(__SSE2__)
    return reinterpret_cast<Floats>(_mm_sqrt_ps(reinterpret_cast<__m128>(v)));
#else
    Floats root;
    for (int i = 0; i < FARFIELD_LANES; ++i) root[i] = std::sqrt(v[i]);
    return root;
#endif
}
#endif

FARFIELD_INLINE Floats all_of(float v) {
    return Floats{} + v;
}
FARFIELD_INLINE Vector all_of(const glm::vec3& v) {
    return {all_of(v.x), all_of(v.y), all_of(v.z)};
}
/// The lesser and the greater; the first, if one is not a number.
FARFIELD_INLINE Floats lesser(const Floats& a, const Floats& b) {
    return b < a ? b : a;
}
FARFIELD_INLINE Floats greater(const Floats& a, const Floats& b) {
    return a < b ? b : a;
}
FARFIELD_INLINE Floats dot(const Vector& a, const Vector& b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
FARFIELD_INLINE Vector absolute(const Vector& v) {
    return {absolute(v.x), absolute(v.y), absolute(v.z)};
}
FARFIELD_INLINE Vector times(const Vector& a, const Vector& b) {
    return {a.x * b.x, a.y * b.y, a.z * b.z};
}

#if FARFIELD_LANES != 1

FARFIELD_INLINE Floats as_floats(const Words& bits) {
    return reinterpret_cast<Floats>(bits);
}
FARFIELD_INLINE Floats number_of(const Words& count, int less = 0) {
    return __builtin_convertvector(reinterpret_cast<Mask>(count) - less, Floats);
}
FARFIELD_INLINE Words word_of(const std::uint32_t* placed, std::size_t i) {
    Words word;
    __builtin_memcpy(&word, placed + i * placed_stride, sizeof word);
    return word;
}
/// Words i to i + 2.
FARFIELD_INLINE Vector vector_of(const std::uint32_t* placed, std::size_t i) {
    return {as_floats(word_of(placed, i)), as_floats(word_of(placed, i + 1)), as_floats(word_of(placed, i + 2))};
}

/// How points are seen that lie before the viewer, if they are there.
struct Sight {
    Vector towards;            ///< as LocalView::towards_viewer
    Floats distance, stretch;  ///< the length of that; as LocalView::stretch
    Mask is_there, is_seen;
};
/// False: a length needs more care than is taken here.
FARFIELD_INLINE bool sight_of(const Vector& center, std::size_t count, const LocalView& view, Sight& out) {
    Words lane;
    for (unsigned i = 0; i < FARFIELD_LANES; ++i) lane[i] = i;
    out.is_there = out.is_seen = lane < std::uint32_t(count);
    if (view.is_perspective) {
        const Vector from_eye = center - all_of(view.eye);
        const Floats square = dot(from_eye, from_eye), depth = dot(from_eye, all_of(view.forward));
        // What length_of() of geometry/length.hpp scales.
        if (any(out.is_there & ((square < 0x1p-60f) | (square > 0x1p120f)))) return false;
        out.towards = all_of(view.eye) - center;
        out.distance = root_of(square);
        out.stretch = out.distance / depth;
        out.is_seen &= depth > 0.0f;
    } else {
        out.towards = all_of(-view.forward);
        out.distance = all_of(length_of(-view.forward));
        out.stretch = all_of(1.0f);
    }
    return true;
}

FARFIELD_INLINE void store(float* to, const Floats& v) {
    __builtin_memcpy(to, &v, sizeof v);
}
FARFIELD_INLINE Words bytes_of(const Floats& v) {
    return reinterpret_cast<Words>(__builtin_convertvector(v, Mask));
}
/// `law` is an AreaLaw.
FARFIELD_INLINE void fill(PlacedSplats& out, const Vector& center, const Floats& width, const Floats& height,
                          const Floats& opacity, const Vector& rgb, const Words& law, const Mask& is_drawn) {
    const Words color = bytes_of(rgb.x) | bytes_of(rgb.y) << 8 | bytes_of(rgb.z) << 16 | law << 24;
    store(out.x, center.x);
    store(out.y, center.y);
    store(out.z, center.z);
    store(out.width, width);
    store(out.height, height);
    store(out.opacity, opacity);
    __builtin_memcpy(out.rgb, &color, sizeof color);
    __builtin_memcpy(out.is_drawn, &is_drawn, sizeof is_drawn);
}

#endif
