// Gaussian splats of all tiles that are shown, drawn back to front as one: those of one tile lie among those of others.
//
// Kerbl, Kopanas, Leimkuehler, Drettakis: 3D Gaussian Splatting for Real-Time Radiance Field Rendering, 2023. Splats
// smaller than a pixel are widened to one and made fainter by as much: not so that one covers the same area, but so that
// many on top of each other do. The integral of -log(1 - a g) over the picture, g a Gaussian, is its area times the
// dilogarithm of a.
import {
    CustomBlending, DataTexture, FloatType, InstancedBufferAttribute, InstancedBufferGeometry, Float32BufferAttribute,
    Matrix4, Matrix3, Mesh, OneFactor, OneMinusSrcAlphaFactor, Quaternion, RGBAFormat, ShaderMaterial, Vector2, Vector3,
} from 'three';

const TEXELS = 4, WIDTH = 2048, ROW = WIDTH / TEXELS;  // splats in a row of the texture
const WHOLE = Math.PI * Math.PI / 6;                   // the dilogarithm of 1
const HARMONIC = 0.28209479177387814;

function dilogarithm(x) {
    if (x > 0.5) return WHOLE - (x < 1 ? Math.log(x) * Math.log(1 - x) : 0) - dilogarithm(1 - x);
    let sum = 0, power = 1;
    for (let n = 1; n <= 24; ++n) sum += (power *= x) / (n * n);
    return sum;
}

/** What a tile's splats are in the scene: 16 numbers each, as they lie in the texture. */
export function splatsOf(points) {
    const attribute = name => points.geometry.getAttribute(`khr_gaussian_splatting:${name}`);
    const scale = attribute('scale');
    if (!scale) return null;
    const position = points.geometry.getAttribute('position'), rotation = attribute('rotation');
    const opacity = attribute('opacity'), harmonic = attribute('sh_degree_0_coef_0');
    const data = new Float32Array(16 * position.count);
    const q = new Quaternion(), r = new Matrix4(), m = new Matrix3(), t = new Matrix3(), p = new Vector3();
    const linear = new Matrix3().setFromMatrix4(points.matrixWorld);
    for (let i = 0; i < position.count; ++i) {
        p.fromBufferAttribute(position, i).applyMatrix4(points.matrixWorld);
        q.fromBufferAttribute(rotation, i);
        // The rows of a root of the covariance: axes times standard deviations.
        m.setFromMatrix4(r.makeRotationFromQuaternion(q)).premultiply(linear);
        const s = [scale.getX(i), scale.getY(i), scale.getZ(i)];
        for (let k = 0; k < 9; ++k) m.elements[k] *= s[k / 3 | 0];
        t.copy(m).transpose();
        const c = m.multiply(t).elements;
        data.set([p.x, p.y, p.z, dilogarithm(Math.min(opacity.getX(i), 1)), c[0], c[1], c[2], c[4], c[5], c[8], 0, 0], 16 * i);
        for (let k = 0; k < 3; ++k) data[16 * i + 12 + k] = 0.5 + HARMONIC * harmonic.getComponent(i, k);
    }
    return data;
}

const vertexShader = `
    precision highp float;
    precision highp sampler2D;
    uniform sampler2D splats;
    uniform vec2 size;
    attribute float number;
    varying vec2 place;
    varying vec4 color;

    void main() {
        int n = int(number), x = (n % ${ROW}) * ${TEXELS}, y = n / ${ROW};
        vec4 a = texelFetch(splats, ivec2(x, y), 0), b = texelFetch(splats, ivec2(x + 1, y), 0);
        vec4 c = texelFetch(splats, ivec2(x + 2, y), 0), d = texelFetch(splats, ivec2(x + 3, y), 0);
        vec3 v = (viewMatrix * vec4(a.xyz, 1.0)).xyz;
        gl_Position = vec4(0.0, 0.0, 2.0, 1.0);
        if (v.z > -1e-6) return;
        mat3 world = mat3(b.x, b.y, b.z, b.y, b.w, c.x, b.z, c.x, c.y);
        vec2 focal = 0.5 * size * vec2(projectionMatrix[0][0], projectionMatrix[1][1]);
        // Beyond the picture's border the projection is not that of its tangent.
        vec2 most = 1.3 / vec2(projectionMatrix[0][0], projectionMatrix[1][1]);
        vec2 slope = clamp(v.xy / -v.z, -most, most);
        mat3 tangent = mat3(focal.x, 0.0, 0.0, 0.0, focal.y, 0.0, focal.x * slope.x, focal.y * slope.y, 0.0);
        mat3 to = tangent * mat3(viewMatrix) / -v.z;
        mat3 seen = to * world * transpose(to);
        vec3 s = vec3(seen[0][0], seen[0][1], seen[1][1]);
        float before = max(s.x * s.z - s.y * s.y, 0.0);
        s.xz += 0.3;
        float after = s.x * s.z - s.y * s.y;
        float depth = a.w * sqrt(before / after);
        // The inverse of the dilogarithm to 0.02.
        float opacity = 1.0 - pow(max(1.0 - depth / ${WHOLE}, 0.0), ${WHOLE});
        if (opacity < 1.0 / 512.0) return;
        float middle = 0.5 * (s.x + s.z), half_gap = length(vec2(0.5 * (s.x - s.z), s.y));
        vec2 variances = vec2(middle + half_gap, max(middle - half_gap, 0.1));
        vec2 axis = abs(s.y) > 1e-6 ? normalize(vec2(s.y, variances.x - s.x)) : s.x >= s.z ? vec2(1, 0) : vec2(0, 1);
        float reach = min(3.3, sqrt(2.0 * log(max(opacity * 512.0, 1.0))));
        place = position.xy * reach;
        vec2 away = place.x * sqrt(variances.x) * axis + place.y * sqrt(variances.y) * vec2(-axis.y, axis.x);
        color = vec4(d.rgb, opacity);
        vec4 center = projectionMatrix * vec4(v, 1.0);
        gl_Position = vec4(center.xy + 2.0 * away / size * center.w, center.zw);
    }`;
const fragmentShader = `
    precision highp float;
    varying vec2 place;
    varying vec4 color;
    void main() {
        float a = color.a * exp(-0.5 * dot(place, place));
        if (a < 1.0 / 1024.0) discard;
        gl_FragColor = vec4(clamp(color.rgb, 0.0, 1.0) * a, a);
    }`;

export class Splats extends Mesh {
    constructor() {
        const geometry = new InstancedBufferGeometry();
        geometry.setAttribute('position', new Float32BufferAttribute([-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0], 3));
        geometry.setIndex([0, 1, 2, 0, 2, 3]);
        const material = new ShaderMaterial({
            uniforms: { splats: { value: null }, size: { value: new Vector2() } },
            vertexShader, fragmentShader,
            transparent: true, depthWrite: false, blending: CustomBlending,
            blendSrc: OneFactor, blendDst: OneMinusSrcAlphaFactor,
            blendSrcAlpha: OneFactor, blendDstAlpha: OneMinusSrcAlphaFactor,
        });
        super(geometry, material);
        this.frustumCulled = false;
        this.visible = false;
        this.renderOrder = 1;
        this.count = 0;
        this.sortedFrom = null;
    }

    /** Takes what splatsOf() gave of each tile that is shown. */
    show(arrays) {
        this.count = arrays.reduce((n, a) => n + a.length / 16, 0);
        this.visible = this.count > 0;
        this.sortedFrom = null;
        if (!this.visible) return;
        const rows = Math.ceil(this.count / ROW), all = new Float32Array(rows * WIDTH * 4);
        let at = 0;
        for (const a of arrays) { all.set(a, at); at += a.length; }
        this.material.uniforms.splats.value?.dispose();
        const texture = new DataTexture(all, WIDTH, rows, RGBAFormat, FloatType);
        texture.needsUpdate = true;
        this.material.uniforms.splats.value = texture;
        this.data = all;
        this.geometry.dispose();
        this.geometry.setAttribute('number', new InstancedBufferAttribute(new Float32Array(this.count), 1));
        this.geometry.instanceCount = this.count;
    }

    /** Back to front by depth, if the camera has moved. */
    sort(camera, size) {
        this.material.uniforms.size.value.copy(size);
        if (!this.visible) return;
        const key = camera.matrixWorldInverse.elements.join();
        if (key === this.sortedFrom) return;
        this.sortedFrom = key;
        const e = camera.matrixWorldInverse.elements, depths = new Float32Array(this.count);
        let least = Infinity, most = -Infinity;
        for (let i = 0; i < this.count; ++i) {
            const at = 16 * i, z = e[2] * this.data[at] + e[6] * this.data[at + 1] + e[10] * this.data[at + 2];
            depths[i] = z;
            if (z < least) least = z;
            if (z > most) most = z;
        }
        const BINS = 65536, scale = (BINS - 1) / Math.max(most - least, 1e-30), begins = new Uint32Array(BINS + 1);
        const bin = i => (depths[i] - least) * scale | 0;
        for (let i = 0; i < this.count; ++i) ++begins[bin(i) + 1];
        for (let b = 0; b < BINS; ++b) begins[b + 1] += begins[b];
        const numbers = this.geometry.getAttribute('number');
        for (let i = 0; i < this.count; ++i) numbers.array[begins[bin(i)]++] = i;
        numbers.needsUpdate = true;
    }
}
