// Depths and colors of several samples of a row; included by kernels, once for each width of vectors: simd.hpp. There
// is no include guard; FARFIELD_LANES must be 1, 4 or 8, and the including namespace is for one kernel alone.

typedef float Floats __attribute__((vector_size(4 * FARFIELD_LANES)));
typedef std::int32_t Ints __attribute__((vector_size(4 * FARFIELD_LANES)));
typedef std::uint32_t Words __attribute__((vector_size(4 * FARFIELD_LANES)));

inline bool any(Ints where) {
#if FARFIELD_LANES == 8 && defined(__x86_64__)
    return __builtin_ia32_movmskps256(reinterpret_cast<Floats>(where)) != 0;
#elif FARFIELD_LANES == 4 && defined(__x86_64__)
    return __builtin_ia32_movmskps(reinterpret_cast<Floats>(where)) != 0;
#else
    std::int32_t bits = 0;
    for (int lane = 0; lane < FARFIELD_LANES; ++lane) bits |= where[lane];
    return bits != 0;
#endif
}

inline Ints numbered_from(int first) {
#if FARFIELD_LANES == 8
    return Ints{0, 1, 2, 3, 4, 5, 6, 7} + first;
#elif FARFIELD_LANES == 4
    return Ints{0, 1, 2, 3} + first;
#else
    return Ints{} + first;
#endif
}

template <class V, class T>
inline V load(const T* from) {
    V v;
    __builtin_memcpy(&v, from, sizeof v);
    return v;
}
template <class V, class T>
inline void store(T* to, V v) {
    __builtin_memcpy(static_cast<void*>(to), &v, sizeof v);
}

inline Words byte_of(Floats v) {
    const Floats zero{}, one = zero + 1.0f;
    const Floats lit = v * 255.0f + 0.5f, byte = v < one ? lit : zero + 255.0f;
    return reinterpret_cast<Words>(__builtin_convertvector(v > zero ? byte : zero, Ints));
}

/// Returns false if one of the wanted colors is not opaque.
inline bool colors_at(Floats x, const ColorsOfRow& colors, Ints wanted, Words& out) {
    const Floats px = x * 256.0f + 128.0f;
    Floats w[3];
    for (int i = 0; i < 3; ++i) {
        const ColorsOfRow::Weight& of = colors.weights[i];
        w[i] = (of.across - of.down * (px - of.x)) * colors.inverse_area * of.weight;
    }
    const Floats inverse = 1.0f / (w[0] + w[1] + w[2]);
    out = Words{};
    for (unsigned channel = 0; channel < 4; ++channel) {
        const glm::vec3& corners = colors.channels[channel];
        const Words byte = byte_of((corners.x * w[0] + corners.y * w[1] + corners.z * w[2]) * inverse);
        out |= byte << (8 * channel);
    }
    return !any(reinterpret_cast<Ints>(reinterpret_cast<Words>(wanted) & reinterpret_cast<Words>(out < 0xff000000u)));
}
