#include "opengl/shaders.hpp"

#include <cstddef>
#include <iterator>
#include <string>

#include "opengl/program.hpp"
#include "opengl/stand_in_shader.hpp"

namespace farfield::opengl {
namespace {

/// Rows of view_row.hpp, one a draw.
constexpr const char* view_text = R"(
layout(location = 2) in vec4 anchor;
layout(location = 3) in vec4 across;
layout(location = 4) in vec4 upward;
layout(location = 5) in vec4 forward;
layout(location = 6) in vec4 depths;
layout(location = 7) in vec4 light;

vec4 clip_of(vec3 d, float depth) {
    float w = depth * forward.w + anchor.w;
    return vec4(dot(across.xyz, d) + w * across.w, dot(upward.xyz, d) + w * upward.w, depths.x + depths.y * depth, w);
}
#ifdef CLIPS
void clip(float depth) {
    gl_ClipDistance[0] = depth - depths.z;
    gl_ClipDistance[1] = depths.w - depth;
}
#endif
)";

/// All of a triangle for each of its vertices, and whether it is small: both of its sides below two samples, and not
/// cut by a plane. (raster/triangles/triangle_triage.inl is what the software renderers do.)
constexpr const char* whole_triangle_text = R"(
layout(binding = 0) uniform usamplerBuffer vertices;
layout(location = 4) uniform vec2 samples;  // of the picture
vec3 corner_place[3];
vec4 corner_color[3];
vec3 corner_at[3];  // in samples, and depth as in the depth buffer
float area;         // in samples
bool is_small(int triangle) {
    bool is_whole = true;
    for (int i = 0; i < 3; ++i) {
        uvec4 v = texelFetch(vertices, 3 * triangle + i);
        corner_place[i] = uintBitsToFloat(v.xyz);
        corner_color[i] = unpackUnorm4x8(v.w);
        vec3 d = corner_place[i] - anchor.xyz;
        float depth = dot(forward.xyz, d);
        vec4 c = clip_of(d, depth);
        if (!(depth > depths.z && depth <= depths.w)) is_whole = false;
        float inverse = 1 / c.w;
        corner_at[i] = vec3((0.5 + vec2(0.5, -0.5) * c.xy * inverse) * samples, c.z * inverse);
    }
    vec2 a = corner_at[0].xy, b = corner_at[1].xy, c = corner_at[2].xy;
    area = 0.5 * abs((b.x - a.x) * (c.y - a.y) - (c.x - a.x) * (b.y - a.y));
    vec2 sides = max(max(a, b), c) - min(min(a, b), c);
    return is_whole && all(lessThan(sides, vec2(2))) && area > 0;
}
)";

constexpr const char* triangles_vertex = R"(
#ifdef LEAVES_SMALL
layout(location = 5) uniform int draws_behind;
#else
layout(location = 0) in vec3 position;
layout(location = 1) in vec4 color;
#endif
out vec4 seen;
#ifdef LIT
out vec3 place;
flat out vec4 forward_in, light_in;
flat out float behind;
#endif
#ifdef TRANSLUCENT
flat out uint hash;
#endif
void main() {
#ifdef LEAVES_SMALL
    bool small = is_small(gl_VertexID / 3);
    vec3 position = corner_place[gl_VertexID % 3];
    vec4 color = corner_color[gl_VertexID % 3];
#endif
    vec3 d = position - anchor.xyz;
    float depth = dot(forward.xyz, d);
    gl_Position = clip_of(d, depth);
    seen = color;
#ifdef CLIPS
    clip(depth);
#endif
#ifdef LEAVES_SMALL
    if (small) {
        // Squares do not tile a surface as its triangles do: so that nothing shows through, these are drawn as well,
        // as far away as their farthest corners.
        gl_Position.z = min(min(corner_at[0].z, corner_at[1].z), corner_at[2].z) * gl_Position.w;
        if (draws_behind == 0) gl_Position = vec4(2, 2, 2, 1);
    }
#endif
#ifdef LIT
    place = d;
    forward_in = forward;
    light_in = light;
    behind = anchor.w;
#endif
#ifdef TRANSLUCENT
    uvec3 bits = floatBitsToUint(position);
    uint h = bits.x * 0x9e3779b1u;
    h = (h ^ h >> 15 ^ bits.y) * 0x85ebca77u;
    hash = (h ^ h >> 13 ^ bits.z) * 0xc2b2ae3du + floatBitsToUint(light.w);
#endif
}
)";

constexpr const char* triangles_fragment = R"(
in vec4 seen;
layout(location = 0) out vec4 color;
#ifdef LIT
in vec3 place;
flat in vec4 forward_in, light_in;
flat in float behind;
layout(location = 1) uniform vec2 brightness;  // ambient, diffuse
#endif
#ifdef TRANSLUCENT
flat in uint hash;
layout(location = 2) uniform ivec2 first_sample;
#endif
#ifdef SLICED
layout(location = 3) uniform vec2 slice;
#endif
void main() {
#ifdef SLICED
    if (gl_FragCoord.z < slice.x || gl_FragCoord.z > slice.y) discard;
#endif
    color = vec4(seen.rgb, 1);
#ifdef TRANSLUCENT
    // After Wyman and McGuire 2017, "Hashed alpha testing": a hash of sample and triangle decides.
    uint alpha = uint(seen.a * 255 + 0.5);
    uvec2 at = uvec2(ivec2(gl_FragCoord.xy) + first_sample);
    uint h = at.x * 0x9e3779b1u ^ at.y * 0x85ebca77u ^ hash;
    h = (h ^ h >> 15) * 0x2c1b3c6du;
    h = (h ^ h >> 12) * 0x297a2d39u;
    if (alpha < 255u && (h >> 24) >= alpha) discard;
#endif
#ifdef LIT
    vec3 normal = cross(dFdx(place), dFdy(place));
    vec3 towards = forward_in.w != 0 ? -(place + forward_in.xyz * behind) : -forward_in.xyz;
    if (dot(normal, towards) < 0) normal = -normal;
    float squares = dot(normal, normal) * dot(light_in.xyz, light_in.xyz);
    float cosine = squares > 0 ? dot(normal, light_in.xyz) * inversesqrt(squares) : 0;
    color.rgb = min(color.rgb * (brightness.x + brightness.y * max(cosine, 0)), 1);
#endif
}
)";

/// A small triangle as a deposit: a square of its area about its middle.
constexpr const char* small_vertex = R"(
layout(location = 0) uniform vec2 size;       // of the picture, in lanes
layout(location = 1) uniform int is_coherent;
layout(location = 5) uniform int law;
layout(location = 6) uniform vec2 brightness;  // ambient, diffuse
layout(location = 7) uniform int is_lit;
layout(location = 8) uniform int culled;       // 1: clockwise ones, -1: counter-clockwise ones
out vec2 on_face;
flat out vec4 rectangle;
flat out vec4 deposit;
void main() {
    on_face = vec2(0.5);
    int corner = gl_VertexID % 3;
    bool small = is_small(gl_VertexID / 3);
    vec2 u = corner_at[1].xy - corner_at[0].xy, v = corner_at[2].xy - corner_at[0].xy;
    float turn = v.x * u.y - u.x * v.y;  // rows run downwards
    if (culled * turn < 0) small = false;
    vec3 middle = (corner_at[0] + corner_at[1] + corner_at[2]) / 3;
    float side = size.x / samples.x;  // of a sample, in lanes
    vec2 half_size = vec2(0.5 * sqrt(area) * side);
    rectangle = vec4(middle.xy * side - half_size, middle.xy * side + half_size);
    vec2 at = floor(rectangle.xy), end = ceil(rectangle.zw);
    if (corner == 1) at.x += 2 * (end.x - at.x);
    if (corner == 2) at.y += 2 * (end.y - at.y);
    gl_Position = small ? vec4(vec2(2, -2) * at / size + vec2(-1, 1), middle.z, 1) : vec4(2, 2, 2, 1);
    vec4 color = (corner_color[0] + corner_color[1] + corner_color[2]) / 3;
    if (is_lit != 0) {
        vec3 normal = cross(corner_place[1] - corner_place[0], corner_place[2] - corner_place[0]);
        vec3 to_eye = forward.w != 0 ? anchor.xyz - forward.xyz * anchor.w - corner_place[0] : -forward.xyz;
        if (dot(normal, to_eye) < 0) normal = -normal;
        float squares = dot(normal, normal) * dot(light.xyz, light.xyz);
        float cosine = squares > 0 ? dot(normal, light.xyz) * inversesqrt(squares) : 0;
        color.rgb = min(color.rgb * (brightness.x + brightness.y * max(cosine, 0)), 1);
    }
#ifdef CLIPS
    gl_ClipDistance[0] = gl_ClipDistance[1] = 1;
#endif
    // Of something opaque (area_law.hpp, loss_of_opacity).
    float part = law == 1 ? 0.5 : (law == 2) == (is_coherent != 0) ? 1.0 : 0.0;
    deposit = vec4(color.rgb, color.a * part);
}
)";

constexpr const char* far_fragment = R"(
in vec2 on_face;
layout(location = 11) uniform int lanes;
flat in vec4 rectangle;
flat in vec4 deposit;
layout(location = 1) uniform int is_coherent;
layout(location = 0) out vec4 color;
#ifdef KEEPS_DEPTHS
layout(location = 1) out float nearest;
#endif
#ifdef SLICED
layout(location = 3) uniform vec2 slice;
#endif
void main() {
    vec2 to_sample = (floor(gl_FragCoord.xy / float(lanes)) + 0.5) * float(lanes) - gl_FragCoord.xy;
    vec2 sampled = on_face + dFdx(on_face) * to_sample.x + dFdy(on_face) * to_sample.y;
#ifdef SLICED
    if (gl_FragCoord.z < slice.x || gl_FragCoord.z > slice.y) discard;
#endif
    if (lanes > 1 && (any(lessThan(sampled, vec2(0))) || any(greaterThanEqual(sampled, vec2(1))))) discard;
    vec2 overlap = min(rectangle.zw, gl_FragCoord.xy + 0.5) - max(rectangle.xy, gl_FragCoord.xy - 0.5);
    overlap = max(overlap, 0);
    float loss = deposit.w * overlap.x * overlap.y;
    color = vec4(is_coherent != 0 ? deposit.rgb : deposit.rgb * loss, loss);
#ifdef KEEPS_DEPTHS
    if (loss == 0) discard;
    nearest = gl_FragCoord.z;
#endif
}
)";

constexpr const char* quad_vertex = R"(
layout(location = 4) uniform vec3 corner;
layout(location = 5) uniform vec3 across_quad;
layout(location = 6) uniform vec3 down_quad;
layout(location = 7) uniform vec2 texels;
out vec2 at;
void main() {
    vec2 part = vec2(gl_VertexID & 1, gl_VertexID >> 1);
    vec3 d = corner + across_quad * part.x + down_quad * part.y - anchor.xyz;
    float depth = dot(forward.xyz, d);
    gl_Position = clip_of(d, depth);
    at = part * texels;
#ifdef CLIPS
    clip(depth);
#endif
}
)";

/// A texel's depth is told relative to the rectangle's (G. Schaufler, "Nailboards", 1997).
constexpr const char* quad_fragment = R"(
in vec2 at;
layout(binding = 0) uniform sampler2D colors;
layout(binding = 1) uniform sampler2D relative_depths;
layout(location = 8) uniform ivec2 size;
layout(location = 9) uniform int mode;           // 0: solid, 1: what is opaque, 2: what is partly covered
layout(location = 10) uniform ivec4 part;        // first and end of 64; samples beside the picture and above it
layout(location = 11) uniform int lanes;         // a sample's side in lanes
layout(location = 12) uniform vec2 depth_rule;   // bias, 1 in perspective
#ifdef SLICED
layout(location = 3) uniform vec2 slice;
#endif
layout(location = 0) out vec4 color;
#ifdef KEEPS_DEPTHS
layout(location = 1) out float nearest;
#endif
const float none = -1e30;

bool is_inside(ivec2 t) { return all(greaterThanEqual(t, ivec2(0))) && all(lessThan(t, size)); }
int fade_order(ivec2 p) {
    int order = 0;
    for (int bit = 0; bit < 3; ++bit)
        order |= ((((p.x ^ p.y) >> bit & 1) << 1) | (p.y >> bit & 1)) << (2 * (2 - bit));
    return order;
}
void main() {
    // Lanes see what their sample sees.
    vec2 to_sample = (floor(gl_FragCoord.xy / float(lanes)) + 0.5) * float(lanes) - gl_FragCoord.xy;
    vec2 t = at + dFdx(at) * to_sample.x + dFdy(at) * to_sample.y - 0.5;
    float z = gl_FragCoord.z + dFdx(gl_FragCoord.z) * to_sample.x + dFdy(gl_FragCoord.z) * to_sample.y;
    if (part.y - part.x < 64) {
        int order = fade_order(ivec2(gl_FragCoord.xy) / lanes + part.zw);
        if (order < part.x || order >= part.y) discard;
    }
    ivec2 first = ivec2(floor(t));
    vec2 f = t - vec2(first);
    vec4 sum = vec4(0);
    float relative = none, best = -1;
    for (int i = 0; i < 4; ++i) {
        ivec2 texel = first + ivec2(i & 1, i >> 1);
        if (!is_inside(texel)) continue;
        float share = ((i & 1) != 0 ? f.x : 1 - f.x) * (i >= 2 ? f.y : 1 - f.y);
        sum += share * texelFetch(colors, texel, 0);
        float d = texelFetch(relative_depths, texel, 0).r;
        if (d != none && share > best) {
            relative = d;
            best = share;
        }
    }
    if (mode == 0) {
        if (sum.a < 0.5) discard;
        sum = min(sum / sum.a, 1);
    } else if ((sum.a > 254.5 / 255) != (mode == 1) || sum.a == 0) {
        discard;
    } else if (mode == 1) {
        sum.a = 1;
    }
    if (relative != none) z = depth_rule.y != 0 ? (z + depth_rule.x) * relative - depth_rule.x : z + relative;
#ifdef SLICED
    if (z < slice.x || z > slice.y) discard;
#endif
    gl_FragDepth = z;
    color = sum;
#ifdef KEEPS_DEPTHS
    nearest = z;
#endif
}
)";

constexpr const char* whole_vertex = R"(
void main() { gl_Position = vec4(4 * (gl_VertexID & 1) - 1, 4 * (gl_VertexID >> 1) - 1, 0.5, 1); }
)";

constexpr const char* copied_depth_fragment = R"(
layout(binding = 2) uniform sampler2D depths;
layout(location = 11) uniform int lanes;
void main() { gl_FragDepth = texelFetch(depths, ivec2(gl_FragCoord.xy) / lanes, 0).r; }
)";

/// A pixel's mean: what was deposited, over what is left of the geometry behind it.
constexpr const char* composite_fragment = R"(
layout(binding = 0) uniform sampler2D geometry;
layout(binding = 1) uniform sampler2D far_field;
layout(location = 1) uniform int side;     // of a pixel, in samples
layout(location = 11) uniform int lanes;   // of a sample
layout(location = 2) uniform ivec4 far_part;  // left, top, right, bottom, in pixels
layout(location = 0) out vec4 color;
#ifdef KEEPS_DEPTHS
layout(binding = 2) uniform sampler2D depths;
layout(binding = 3) uniform sampler2D nearest;
layout(location = 3) uniform vec3 rule;    // the rectangle's depth as in the depth buffer, bias, 1 in perspective
layout(location = 1) out float relative;
#endif
void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy), first = pixel * side;
    bool has_far = all(greaterThanEqual(pixel, far_part.xy)) && all(lessThan(pixel, far_part.zw));
    vec4 sum = vec4(0);
    float share = 1 / float(lanes * lanes);
    float depth = 0, covered = 0;
    for (int y = 0; y < side; ++y) {
        for (int x = 0; x < side; ++x) {
            ivec2 at = first + ivec2(x, y);
            vec4 behind = texelFetch(geometry, at, 0);
            vec4 before = vec4(0);
            float z = -1;
#ifdef KEEPS_DEPTHS
            if (behind.a > 0) z = texelFetch(depths, at, 0).r;
#endif
            if (has_far) {
                for (int i = 0; i < lanes * lanes; ++i) {
                    ivec2 lane = at * lanes + ivec2(i % lanes, i / lanes);
                    before += texelFetch(far_field, lane, 0);
#ifdef KEEPS_DEPTHS
                    z = max(z, texelFetch(nearest, lane, 0).r);
#endif
                }
                before *= share;
            }
            sum += before + (1 - before.a) * behind;
            if (z >= 0) {
                depth += z;
                covered += 1;
            }
        }
    }
    color = sum / float(side * side);
#ifdef KEEPS_DEPTHS
    depth /= max(covered, 1);
    relative = covered == 0 ? -1e30 : rule.z != 0 ? (depth + rule.y) / (rule.x + rule.y) : depth - rule.x;
#endif
}
)";

constexpr const char* bounds_vertex = R"(
layout(location = 1) uniform vec3 center;
layout(location = 2) uniform vec3 half_size;
void main() {
    // A box as a strip of 14 corners.
    int bit = 1 << gl_VertexID;
    vec3 corner = vec3((0x287a & bit) != 0, (0x02af & bit) != 0, (0x31e3 & bit) != 0) * 2 - 1;
    vec3 d = center + half_size * corner - anchor.xyz;
    gl_Position = clip_of(d, dot(forward.xyz, d));
}
)";

constexpr const char* bounds_fragment = "void main() {}\n";

struct Texts {
    const char* vertex;
    const char* fragment;
    bool has_view;
    bool has_whole_triangles = false;
};
constexpr Texts texts[shaders] = {
    {triangles_vertex, triangles_fragment, true}, {"", far_fragment, true},
    {small_vertex, far_fragment, true, true},     {quad_vertex, quad_fragment, true},
    {whole_vertex, copied_depth_fragment, false}, {whole_vertex, composite_fragment, false},
    {bounds_vertex, bounds_fragment, true},
};
constexpr const char* names[] = {"CLIPS",        "LIT",          "TRANSLUCENT", "SLICED",
                                 "KEEPS_DEPTHS", "LEAVES_SMALL", "TENSORS",     "CUBES"};

}  // namespace

GLuint Programs::get(Shader shader, unsigned features) {
    Program& program = programs_[std::size_t(shader)][features];
    if (program.name() != 0) return program.name();
    std::string head = "#version 450 core\n";
    for (std::size_t i = 0; i < std::size(names); ++i) {
        if ((features >> i & 1u) != 0) head += "#define " + std::string(names[i]) + "\n";
    }
    const Texts& t = texts[std::size_t(shader)];
    std::string vertex = t.vertex;
    if (shader == Shader::far_field) {
        vertex = stand_in_inputs;
        if ((features & (TENSORS | CUBES)) != 0) vertex += sight;
        vertex += (features & TENSORS) != 0 ? tensors_vertex
                  : (features & CUBES) != 0 ? cubes_vertex
                                            : faces_and_splats_vertex;
    }
    const bool has_whole = t.has_whole_triangles || (features & LEAVES_SMALL) != 0;
    program = make_program(head + (t.has_view ? view_text : "") + (has_whole ? whole_triangle_text : "") + vertex,
                           head + t.fragment);
    return program.name();
}

}  // namespace farfield::opengl
