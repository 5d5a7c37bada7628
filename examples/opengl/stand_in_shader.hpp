// The vertex shader of stand-ins: faces and splats as they came, and splats that it makes of opacity tensors (TENSORS)
// and of color cubes (CUBES), by the same steps as the library (approximation/opacity_tensor/appearance_lanes.inl,
// approximation/color_cube/cube_lanes.inl).
#pragma once

namespace farfield::opengl {

/// A vertex's number is four times a place in the lists, and a corner. A splat is an upright rectangle of the picture:
/// it is drawn as large as all lanes that it touches, and each gets its share by overlap.
inline constexpr const char* stand_in_inputs = R"(
layout(binding = 0) uniform usamplerBuffer records;
layout(binding = 1) uniform usamplerBuffer lists;
layout(location = 0) uniform vec2 size;          // of the picture, in lanes
layout(location = 1) uniform int is_coherent;    // which of the two losses is deposited
layout(location = 11) uniform int lanes;         // of a sample
out vec2 on_face;                                // of a face: where, 0 to 1
flat out vec4 rectangle;                         // left, top, right, bottom, in lanes
flat out vec4 deposit;                           // color, loss where a lane is covered whole

const vec4 nowhere = vec4(2, 2, 2, 1);

int first_texel() { return int(texelFetch(lists, gl_VertexID >> 2).x); }
uvec2 texel(int i) { return texelFetch(records, i).xy; }
float loss(float opacity, uint law) {
    float part = law == 1u ? 0.5 : (law == 2u) == (is_coherent != 0) ? 1.0 : 0.0;
    return opacity * part;
}
vec3 rgb(uint color) { return vec3(color & 255u, color >> 8 & 255u, color >> 16 & 255u); }

void deposit_splat(vec3 place, vec2 sides, float opacity, uint law, vec3 color) {
    int corner = gl_VertexID & 3;
    on_face = vec2(0.5);
    vec3 d = place - anchor.xyz;
    float depth = dot(forward.xyz, d);
    vec4 center = clip_of(d, depth);
    vec2 focal = vec2(length(across.xyz), length(upward.xyz)) * size;
    float inverse = 1 / center.w;
    vec2 middle = (0.5 + vec2(0.5, -0.5) * center.xy * inverse) * size;
    vec2 half_size = sides * focal * (0.25 * inverse);
    rectangle = vec4(middle - half_size, middle + half_size);
    // One triangle, twice as wide and high: half as much to set up as two for the rectangle.
    vec2 at = floor(rectangle.xy), end = ceil(rectangle.zw);
    if (corner == 1) at.x += 2 * (end.x - at.x);
    if (corner == 2) at.y += 2 * (end.y - at.y);
    gl_Position = vec4(vec2(2, -2) * at / size + vec2(-1, 1), center.z * inverse, 1);
    deposit = vec4(color, loss(opacity, law));
    // What is not a number is not seen either.
    if (!(depth > depths.z && deposit.w > 0)) gl_Position = nowhere;
#ifdef CLIPS
    clip(depth);
#endif
}
)";

/// How a point is seen that stands-ins lie about.
inline constexpr const char* sight = R"(
float largest(vec3 v) { return max(abs(v.x), max(abs(v.y), abs(v.z))); }
vec3 unit_of(vec3 v) { return normalize(v / largest(v)); }
vec3 towards;       // the viewer, a unit vector
float deep;         // the part of the distance that is depth
float stretch;      // as LocalView::stretch
void look_at(vec3 center) {
    vec3 d = forward.xyz;
    if (forward.w != 0) d = (center - anchor.xyz) + forward.xyz * anchor.w;
    towards = -unit_of(d);
    deep = -dot(towards, forward.xyz);
    stretch = forward.w != 0 ? 1 / deep : 1.0;
}
)";

inline constexpr const char* faces_and_splats_vertex = R"(
vec3 on_plane(vec3 lower, int axis, float along, float down) {
    lower[(axis + 1) % 3] += along;
    lower[(axis + 2) % 3] += down;
    return lower;
}
vec2 samples_from(vec3 p, vec4 from) {
    vec3 d = p - anchor.xyz;
    vec4 to = clip_of(d, dot(forward.xyz, d));
    return to.w > 0 && from.w > 0 ? (to.xy / to.w - from.xy / from.w) * (0.5 * size / float(lanes)) : vec2(1e6);
}

void main() {
    int first = first_texel(), corner = gl_VertexID & 3;
    uvec2 a = texel(first), b = texel(first + 1), c = texel(first + 2);
    vec3 place = vec3(uintBitsToFloat(a), uintBitsToFloat(b.x));
    uint u = b.y, v = c.x, color = c.y, signs = u >> 31 | v >> 31 << 1;
    bool to_the_right = corner == 1 || corner == 2, below = corner >= 2;
    if ((u & 1u) != 0u) {
        int axis = int(signs);
        float width = uintBitsToFloat(u & 0x7ffffffeu), height = uintBitsToFloat(v & 0x7fffffffu);
        on_face = vec2(to_the_right, below);
        vec3 d = on_plane(place, axis, on_face.x * width, on_face.y * height) - anchor.xyz;
        float depth = dot(forward.xyz, d);
        gl_Position = clip_of(d, depth);
        if (lanes > 1) {
            // A sample's lanes are covered as the sample is: the face is drawn larger by a sample, and cut off there.
            vec2 other = 1 - on_face;
            vec2 lengths = vec2(
                length(samples_from(on_plane(place, axis, other.x * width, on_face.y * height), gl_Position)),
                length(samples_from(on_plane(place, axis, on_face.x * width, other.y * height), gl_Position)));
            on_face += (2 * on_face - 1) * min(1 / max(lengths, 1e-6), 8);
            d = on_plane(place, axis, on_face.x * width, on_face.y * height) - anchor.xyz;
            depth = dot(forward.xyz, d);
            gl_Position = clip_of(d, depth);
        }
#ifdef CLIPS
        clip(depth);
#endif
        uint alpha = color >> 24;
        rectangle = vec4(-1e6, -1e6, 1e6, 1e6);
        deposit = vec4(rgb(color) / float(alpha),
                       loss(float(alpha) / 255, alpha >= 192u ? 2u : alpha >= 96u ? 1u : 0u));
    } else {
        vec2 sides = uintBitsToFloat(uvec2(u & 0x7ffffe00u, v & 0x7fffff00u));
        uint opacity = color >> 24 << 16 | (v & 255u) << 8 | (u >> 1 & 255u);
        deposit_splat(place, sides, float(opacity) / 16777215.0, signs, rgb(color) / 255);
    }
}
)";

inline constexpr const char* tensors_vertex = R"(
layout(location = 12) uniform vec3 options;  // closed surfaces, counts overlap: 0 or 1; gain of sheets

uint field(uvec2 bits, int at, int count) {
    uint all = (1u << count) - 1u;
    if (at >= 32) return bits.y >> (at - 32) & all;
    if (at + count <= 32) return bits.x >> at & all;
    return (bits.x >> at | bits.y << (32 - at)) & all;
}
float number(uvec2 bits, int at, int count, int less) { return float(int(field(bits, at, count)) - less); }
float extent_of(uint code) {
    uint octave = code >> 3, step = (code & 7u) + (octave == 0u ? 1u : 9u);
    return float(step) * uintBitsToFloat((max(octave, 1u) + 120u) << 23);
}
// geometry/area_law.hpp
float absorbed(float x) {
    float y = min(0.125 * x, 3);
    float part = 12 * y / (12 + y * (6 + y));
    part *= 2 - part;
    part *= 2 - part;
    return part * (2 - part);
}
vec2 with_room(vec2 sides, float area) { return sides * sqrt(max(area / (sides.x * sides.y), 1)); }

// Width and height of the rectangle that has room for this area.
vec2 rectangle_of(vec3 extent, bool is_surface, vec3 normal, float area) {
    vec3 right = unit_of(across.xyz), up = unit_of(upward.xyz);
    if (forward.w != 0) {
        right += forward.xyz * (dot(towards, right) / deep);
        up += forward.xyz * (dot(towards, up) / deep);
    }
    if (!is_surface) return with_room(vec2(length(right * extent), length(up * extent)), area);
    vec2 box = vec2(dot(abs(right), extent), dot(abs(up), extent));
    vec3 steep = abs(normal);
    int axis = steep.x >= steep.y && steep.x >= steep.z ? 0 : steep.y >= steep.z ? 1 : 2;
    if (normal[axis] != 0) {
        right -= normal * (right[axis] / normal[axis]);
        up -= normal * (up[axis] / normal[axis]);
    }
    vec2 sheet = max(min(vec2(dot(abs(right), extent), dot(abs(up), extent)), box), 1.0 / 256);
    float times = area / (sheet.x * sheet.y);
    if (times > 1) sheet = with_room(sheet + max(box - sheet, 0) * min(4 * (times - 1), 1), area);
    return sheet;
}

void main() {
    int first = first_texel();
    uvec2 a = texel(first), b = texel(first + 1), c = texel(first + 2), d = texel(first + 3);
    float unit = uintBitsToFloat(d.y);
    vec3 center = vec3(number(a, 36, 5, 0), number(a, 41, 5, 0), number(a, 46, 5, 0)) / 32;
    center = vec3(uintBitsToFloat(c), uintBitsToFloat(d.x)) + center * unit;
    vec3 extent = vec3(extent_of(field(a, 51, 4) | field(b, 61, 1) << 4), extent_of(field(a, 55, 4) | field(b, 62, 1) << 4),
                       extent_of(field(a, 59, 4) | field(b, 63, 1) << 4));
    float scale = exp2(float(field(b, 46, 8) << 1 | field(a, 63, 1)) / 16 - 22);
    uint law = field(b, 54, 2);
    vec3 r0 = vec3(number(a, 0, 6, 32), number(a, 6, 6, 32), number(a, 12, 6, 32)) / 31;
    vec2 r1 = vec2(number(a, 18, 6, 32), number(a, 24, 6, 32)) / 31;
    float r2 = number(a, 30, 6, 32) / 31;
    vec3 facing = vec3(number(b, 0, 5, 16), number(b, 5, 5, 16), number(b, 10, 5, 16)) / 15;
    vec3 tone_of = vec3(number(b, 15, 5, 16), number(b, 20, 5, 16), number(b, 25, 5, 16)) / 15;
    vec3 color = vec3(number(b, 30, 5, 0) / 31, number(b, 35, 6, 0) / 63, number(b, 41, 5, 0) / 31);

    look_at(center);
    // All that is seen, in units of the scale, before what hides what.
    float seen = length(vec3(dot(r0, towards), dot(r1, towards.yz), r2 * towards.z));
    float tone = max(1 + dot(tone_of, towards) / seen, 0);
    float area = seen * scale;
    bool is_hidden = !(seen > 0);
    if (options.x != 0) {
        float fronts = 1 + clamp(dot(facing, towards) / seen, -1, 1);
        is_hidden = is_hidden || fronts < 0.04;
        tone = min(tone / fronts, 2);
        area *= 0.5 * fronts;
    }
    bool is_surface = law == 2u;
    if (options.y != 0) {
        vec3 sides = abs(towards) * extent.yzx * extent.zxy;
        float outline = sides.x + sides.y + sides.z;
        if (!is_surface) outline = 0.15 * outline + 0.85 * length(sides);
        float times = area / outline;
        float part = absorbed(law == 1u ? 0.5 * times : times);
        float lost = is_surface ? times : law == 1u ? 2 * part : part;
        area = outline * min(lost, 1);
    }
    area *= stretch;
    float first_square = dot(r0, r0), second_square = dot(r1, r1), third_square = r2 * r2;
    float most = 0.9 * (first_square + second_square + third_square);
    vec3 normal = first_square > most    ? r0
                  : second_square > most ? vec3(0, r1)
                  : third_square > most  ? vec3(0, 0, r2)
                                         : vec3(0);
    vec2 sides = rectangle_of(extent, is_surface, normal, area);
    float opacity = min((field(b, 56, 1) != 0u ? options.z : 1.0) * area / (sides.x * sides.y), 1);
    deposit_splat(center, sides * unit, is_hidden || !(deep > 0) ? 0.0 : opacity, law, min(color * tone, 1));
}
)";

inline constexpr const char* cubes_vertex = R"(
float footprint;
vec4 sum;
void add(float area, float along, float toward, float reach, uint lower, uint upper) {
    float wide = abs(along);
    float projected = wide > reach ? area * abs(toward) : 0.0;
    uint color = along > 0 ? upper : lower;
    footprint += projected;
    sum += vec4(rgb(color), color >> 24) * projected;
}
void main() {
    int first = first_texel();
    uvec2 a = texel(first), b = texel(first + 1), c = texel(first + 2);
    vec3 center = vec3(uintBitsToFloat(a), uintBitsToFloat(b.x)), half_sides = vec3(uintBitsToFloat(b.y), uintBitsToFloat(c));
    look_at(center);
    float unit = 2 * largest(half_sides);
    vec3 h = half_sides / unit, reach = forward.w != 0 ? half_sides : vec3(0);
    vec3 along = forward.w != 0 ? (anchor.xyz - center) - forward.xyz * anchor.w : -forward.xyz;
    footprint = 0;
    sum = vec4(0);
    uvec2 x = texel(first + 3), y = texel(first + 4), z = texel(first + 5);
    add(4 * h.y * h.z, along.x, towards.x, reach.x, x.x, x.y);
    add(4 * h.z * h.x, along.y, towards.y, reach.y, y.x, y.y);
    add(4 * h.x * h.y, along.z, towards.z, reach.z, z.x, z.y);
    float alpha = min(sum.a / (255 * footprint), 1);
    uint law = alpha >= 0.75 ? 2u : alpha >= 0.375 ? 1u : 0u;
    float side = unit * sqrt(footprint * stretch);
    deposit_splat(center, vec2(side), deep > 0 ? alpha : 0.0, law, min(sum.rgb / sum.a, 1));
}
)";

}  // namespace farfield::opengl
