// Faces with opacities, as color cubes have them: those of a tile are drawn back to front, and tiles by their middles.
import { Vector3 } from 'three';

const QUAD = 6;  // vertices that the exporter writes for a face

/** Prepares a mesh whose material blends. */
export function prepareFaces(mesh) {
    const position = mesh.geometry.getAttribute('position'), quads = position.count / QUAD;
    const middles = new Float32Array(3 * quads), p = new Vector3();
    for (let i = 0; i < quads; ++i) {
        // Of a face's diagonal.
        for (const k of [0, 2]) {
            p.fromBufferAttribute(position, QUAD * i + k).applyMatrix4(mesh.matrixWorld).multiplyScalar(0.5);
            middles[3 * i] += p.x; middles[3 * i + 1] += p.y; middles[3 * i + 2] += p.z;
        }
    }
    mesh.geometry.setIndex(Array.from({ length: position.count }, (_, i) => i));
    mesh.geometry.computeBoundingSphere();
    mesh.userData.faces = { middles, middle: mesh.geometry.boundingSphere.center.clone().applyMatrix4(mesh.matrixWorld) };
}

/** Of meshes that are shown. */
export function sortFaces(meshes, camera) {
    const e = camera.matrixWorldInverse.elements, key = e.join();
    const depth = (x, y, z) => e[2] * x + e[6] * y + e[10] * z;
    const order = meshes.map(mesh => ({ mesh, z: depth(...mesh.userData.faces.middle.toArray()) })).sort((a, b) => a.z - b.z);
    order.forEach(({ mesh }, rank) => { mesh.renderOrder = 2 + rank; });
    for (const mesh of meshes) {
        const { middles, sortedFrom } = mesh.userData.faces;
        if (sortedFrom === key) continue;
        mesh.userData.faces.sortedFrom = key;
        const quads = middles.length / 3, depths = new Float32Array(quads);
        for (let i = 0; i < quads; ++i) depths[i] = depth(middles[3 * i], middles[3 * i + 1], middles[3 * i + 2]);
        const numbers = Uint32Array.from({ length: quads }, (_, i) => i).sort((a, b) => depths[a] - depths[b]);
        const index = mesh.geometry.getIndex();
        numbers.forEach((n, at) => { for (let k = 0; k < QUAD; ++k) index.array[QUAD * at + k] = QUAD * n + k; });
        index.needsUpdate = true;
    }
}
