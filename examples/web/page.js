// Shows a tileset that farfield_export wrote. In the address: ?tileset=FOLDER&view=NAME&error=PIXELS; views are those
// of FOLDER/views.json, and without one the camera looks at all of it. The tests of check.mjs talk to window.farfield.
import { Color, PerspectiveCamera, Scene, Sphere, Vector2, Vector3, WebGLRenderer, NoToneMapping } from 'three';
import { OrbitControls } from 'three/addons/controls/OrbitControls.js';
import { TilesRenderer } from '3d-tiles-renderer';
import { Splats, splatsOf } from './splats.js';
import { prepareFaces, sortFaces } from './faces.js';

const query = new URLSearchParams(location.search);
const folder = query.get('tileset') ?? 'opacity-tensor';
const views = await fetch(`${folder}/views.json`).then(r => r.ok ? r.json() : []).catch(() => []);
const view = views.find(v => v.name === query.get('view'));
// A scene that lies far from zero, as its root's transform says, is shown around zero: GPUs count in single precision.
const { root } = await fetch(`${folder}/tileset.json`).then(r => r.json());
const [x, y, z] = root.transform?.slice(12, 15) ?? [0, 0, 0];
const origin = new Vector3(x, z, -y);

const renderer = new WebGLRenderer({ antialias: true, preserveDrawingBuffer: true });
renderer.toneMapping = NoToneMapping;
// Pictures to compare have as many samples as ours, 16: a browser takes 4, of each of four.
renderer.setPixelRatio(view ? 2 : devicePixelRatio);
document.body.append(renderer.domElement);
const scene = new Scene();
scene.background = new Color(1, 1, 1);
const camera = new PerspectiveCamera(45, 1, 0.01, 1000);
const controls = new OrbitControls(camera, renderer.domElement);
const splats = new Splats();
scene.add(splats);

const tiles = new TilesRenderer(`${folder}/tileset.json`);
tiles.errorTarget = Number(query.get('error') ?? 1);
tiles.group.rotation.x = -Math.PI / 2;  // up is z in tiles and y in farfield's scenes
tiles.group.position.copy(origin).negate();
tiles.setCamera(camera);
scene.add(tiles.group);
tiles.group.updateMatrixWorld(true);

// ---- what is shown

const shown = new Set(), size = new Vector2();
let changed = true, firstPicture = null, quietFrames = 0;
const failures = [];
/** Takes splats and faces with opacities out of a tile's model. */
function prepare(model) {
    if (model.userData.splats) return;
    const parent = model.parent;
    model.parent = tiles.group;
    model.updateMatrixWorld(true);
    model.userData.splats = [];
    model.userData.faces = [];
    model.traverse(object => {
        if (object.isPoints) {
            const data = splatsOf(object);
            if (!data) { model.userData.points = object; return; }
            object.visible = false;
            model.userData.splats.push(data);
        } else if (object.isMesh && object.material.transparent) {
            prepareFaces(object);
            model.userData.faces.push(object);
        }
    });
    model.parent = parent;
}
tiles.addEventListener('load-model', ({ scene: model }) => prepare(model));
tiles.addEventListener('tile-visibility-change', ({ scene: model, visible }) => {
    if (!model) return;
    prepare(model);
    visible ? shown.add(model) : shown.delete(model);
    changed = true;
});
tiles.addEventListener('load-error', ({ error, url }) => failures.push(`${url}: ${error}`));

function resize() {
    const width = view?.width ?? innerWidth, height = view?.height ?? innerHeight;
    renderer.setSize(width, height);
    camera.aspect = width / height;
    camera.updateProjectionMatrix();
    // Errors are told in pixels of the picture.
    if (view) tiles.setResolution(camera, width, height);
    else tiles.setResolutionFromRenderer(camera, renderer);
    renderer.getDrawingBufferSize(size);
}
addEventListener('resize', resize);

let isPlaced = false;
function placeCamera() {
    const sphere = new Sphere();
    if (isPlaced || !tiles.getBoundingSphere(sphere)) return;
    isPlaced = true;
    sphere.center.applyMatrix4(tiles.group.matrixWorld);
    const eye = view ? new Vector3(...view.eye).sub(origin) : sphere.center.clone().add(new Vector3(0.55, 0.35, 0.76).normalize().multiplyScalar(1.6 * sphere.radius));
    const target = view ? new Vector3(...view.target).sub(origin) : sphere.center;
    if (view) camera.fov = view.fov * 180 / Math.PI;
    const distance = eye.distanceTo(sphere.center);
    camera.near = Math.max(distance - 2 * sphere.radius, 0.001 * sphere.radius);
    camera.far = distance + 2 * sphere.radius;
    camera.position.copy(eye);
    controls.target.copy(target);
    if (view) controls.enabled = false;
    camera.lookAt(target);
    resize();
}

function draw() {
    placeCamera();
    if (!view) controls.update();
    camera.updateMatrixWorld();
    tiles.update();
    if (changed) {
        // Points stand for what children's triangles show.
        for (const { userData: { points, tile } } of shown) {
            if (points) points.visible = !tile.children.some(child => tiles.visibleTiles.has(child));
        }
        splats.show([...shown].flatMap(m => m.userData.splats));
        changed = false;
    }
    splats.sort(camera, size);
    sortFaces([...shown].flatMap(m => m.userData.faces), camera);
    renderer.render(scene, camera);
    if (shown.size > 0 && firstPicture === null) firstPicture = performance.now();
    const { queued, downloading, parsing } = tiles.stats;
    quietFrames = shown.size > 0 && queued + downloading + parsing === 0 ? quietFrames + 1 : 0;
}

// ---- for people, and for check.mjs

const panel = id => document.getElementById(id);
if (view) panel('panel').remove();
else {
    const folders = await fetch('tilesets.json').then(r => r.ok ? r.json() : [folder]).catch(() => [folder]);
    for (const name of folders) panel('tileset').add(new Option(name, name, false, name === folder));
    panel('tileset').onchange = e => { location.search = `?tileset=${e.target.value}`; };
    panel('error').value = Math.log2(tiles.errorTarget);
    panel('error').oninput = e => { tiles.errorTarget = 2 ** e.target.value; };
    setInterval(() => {
        panel('target').textContent = tiles.errorTarget.toFixed(2);
        panel('state').textContent = `${shown.size} tiles, ${renderer.info.render.triangles} triangles drawn, ${splats.count} splats`;
    }, 200);
}

/** Both over black and over white: what differs shows through. Colors premultiplied, RGBA, first row topmost. */
function capture() {
    const gl = renderer.getContext(), { x: w, y: h } = size;
    const [black, white] = [0, 1].map(gray => {
        scene.background = new Color(gray, gray, gray);
        draw();
        const pixels = new Uint8Array(4 * w * h);
        gl.readPixels(0, 0, w, h, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
        return pixels;
    });
    const ratio = renderer.getPixelRatio(), width = w / ratio, height = h / ratio;
    const out = new Uint8Array(4 * width * height);
    const mean = (pixels, x, row, k) => {
        let sum = 0;
        for (let dy = 0; dy < ratio; ++dy) {
            for (let dx = 0; dx < ratio; ++dx) sum += pixels[4 * (w * (h - 1 - ratio * row - dy) + ratio * x + dx) + k];
        }
        return sum / ratio ** 2;
    };
    for (let row = 0; row < height; ++row) {
        for (let x = 0; x < width; ++x) {
            const to = 4 * (width * row + x);
            let through = 0;
            for (let k = 0; k < 3; ++k) {
                const color = mean(black, x, row, k);
                out[to + k] = Math.round(color);
                through += mean(white, x, row, k) - color;
            }
            out[to + 3] = Math.max(out[to], out[to + 1], out[to + 2], Math.round(255 - through / 3));
        }
    }
    let text = '';
    for (let i = 0; i < out.length; i += 32768) text += String.fromCharCode(...out.subarray(i, i + 32768));
    return { width, height, rgba: btoa(text) };
}
window.farfield = {
    capture,
    state: () => ({
        visible: shown.size, splats: splats.count, failures, firstPicture,
        triangles: renderer.info.render.triangles, points: renderer.info.render.points,
        quietFrames,
    }),
};
resize();
renderer.setAnimationLoop(draw);
