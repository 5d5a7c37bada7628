// Paints a row of samples; compiled once for each width of vectors, see sample_rows.hpp. There is no include guard;
// FARFIELD_LANES must be 4 or 8, and the including namespace is for this file alone.

#include "farfield/raster/triangles/row_lanes.inl"

inline bool paint_several_colors(Rgba8* color, int& begin, int end, const ColorsOfRow& colors) {
    Ints x = numbered_from(begin);
    for (; begin < end; begin += FARFIELD_LANES, x += FARFIELD_LANES) {
        const Ints wanted = x < end;
        Words c;
        if (!colors_at(__builtin_convertvector(x, Floats), colors, wanted, c)) return false;
        const Words replaced = reinterpret_cast<Words>(wanted);
        store(color + begin, (replaced & c) | (~replaced & load<Words>(color + begin)));
    }
    return true;
}
