// Opens what was exported in a headless browser and compares: its picture with ours (FLIP, by farfield_compare), what it
// loads with what there is, and every GLB with glTF's rules (gltf-validator).
//
//     node check.mjs ROOT COMPARE CHROMIUM [VIEW...]     ROOT: the folder that is served, with page.js and FOLDER/tileset.json
//
// Prints a table; ends with 1 if something is not as it must be.
import { execFileSync } from 'node:child_process';
import { createServer } from 'node:http';
import { existsSync, mkdtempSync, readdirSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { extname, join, normalize } from 'node:path';
import { createRequire } from 'node:module';

const [root, compare, executablePath, ...asked] = process.argv.slice(2);
const require = createRequire(join(root, 'node_modules/'));
const { chromium } = require('playwright-core');
const validator = require('gltf-validator');

const wrong = [];
const must = (holds, what) => { if (!holds) { wrong.push(what); console.log(`  WRONG: ${what}`); } };

// ---- files

/** The validator is older than KHR_gaussian_splatting and takes the names of its attributes for misspelt ones. */
const isOfSplats = m => m.code === 'MESH_PRIMITIVE_INVALID_ATTRIBUTE' && m.pointer.includes('/attributes/KHR_gaussian_splatting:');

async function validate(folder) {
    const files = readdirSync(join(root, folder)).filter(f => f.endsWith('.glb'));
    let errors = 0, warnings = 0;
    for (const file of files) {
        const { issues } = await validator.validateBytes(new Uint8Array(readFileSync(join(root, folder, file))), { maxIssues: 0 });
        const found = issues.messages.filter(m => m.severity < 2 && !isOfSplats(m));
        errors += found.filter(m => m.severity === 0).length;
        warnings += found.filter(m => m.severity === 1).length;
        for (const m of found.slice(0, 2)) console.log(`  ${file}: ${m.code} ${m.pointer} ${m.message}`);
    }
    console.log(`${folder}: ${files.length} GLB, ${errors} errors, ${warnings} warnings of gltf-validator`);
    must(errors === 0, `${folder}: gltf-validator finds ${errors} errors`);
    return files.length;
}

// ---- a server and a browser

const types = { '.html': 'text/html', '.js': 'text/javascript', '.json': 'application/json', '.glb': 'model/gltf-binary' };
const server = createServer((request, response) => {
    const path = join(root, normalize(decodeURIComponent(new URL(request.url, 'http://localhost').pathname)));
    if (!existsSync(path)) { response.writeHead(404).end(); return; }
    response.writeHead(200, { 'Content-Type': types[extname(path)] ?? 'application/octet-stream' }).end(readFileSync(path));
});
await new Promise(done => server.listen(0, '127.0.0.1', done));
const address = `http://127.0.0.1:${server.address().port}`;
const profile = mkdtempSync(join(tmpdir(), 'farfield-web-'));
const browser = await chromium.launchPersistentContext(profile, {
    executablePath, headless: true, viewport: { width: 640, height: 480 },
    args: ['--no-sandbox', '--disable-gpu', '--disable-quic', '--no-first-run', '--disable-background-networking',
        '--disable-component-update', '--disable-sync', '--use-gl=angle', '--use-angle=swiftshader', '--enable-unsafe-swiftshader'],
});

/** A picture of a view, once nothing is missing. */
async function look(folder, view, error, out) {
    const page = await browser.newPage(), loaded = new Set(), messages = [];
    page.on('request', r => { if (r.url().endsWith('.glb')) loaded.add(r.url()); });
    page.on('console', m => { if (m.type() === 'error') messages.push(m.text()); });
    page.on('pageerror', e => messages.push(String(e)));
    await page.goto(`${address}/index.html?tileset=${folder}&view=${view}&error=${error}`);
    // Nothing has been missing for some frames.
    let state = {};
    for (let i = 0; i < 600 && !(state.quietFrames > 4); ++i) {
        await page.waitForTimeout(100);
        state = await page.evaluate(() => window.farfield?.state() ?? {});
    }
    must(state.quietFrames > 4, `${folder}, ${view}: it does not come to rest: ${JSON.stringify(state)} ${messages.join('; ')}`);
    must((state.failures ?? []).length === 0, `${folder}, ${view}: ${state.failures}`);
    const { width, height, rgba } = await page.evaluate(() => window.farfield.capture());
    const head = `P7\nWIDTH ${width}\nHEIGHT ${height}\nDEPTH 4\nMAXVAL 255\nTUPLTYPE RGB_ALPHA\nENDHDR\n`;
    writeFileSync(out, Buffer.concat([Buffer.from(head), Buffer.from(rgba, 'base64')]));
    await page.screenshot({ path: out.replace(/pam$/, 'png') });
    await page.close();
    return { ...state, loaded: loaded.size };
}
const compared = (a, b) => JSON.parse(execFileSync(compare, [a, b]).toString());

const folders = JSON.parse(readFileSync(join(root, 'tilesets.json')));
console.log('tileset, view: first picture; tiles loaded of all; splats, triangles drawn; FLIP against ours within a pixel, against all triangles at 64 samples (over the scene alone); coverage, both');
for (const folder of folders) {
    const tiles = await validate(folder);
    if (!existsSync(join(root, folder, 'views.json'))) continue;
    for (const view of asked.length > 0 ? asked : ['far', 'whole', 'near']) {
        const at = name => join(root, folder, `${view}_${name}.pam`);
        const state = await look(folder, view, 1, at('web'));
        const own = compared(at('web'), at('own')), exact = compared(at('web'), at('exact'));
        console.log(`${folder}, ${view}: ${(state.firstPicture / 1000).toFixed(2)} s; ${state.loaded} of ${tiles}; ` +
            `${state.splats}, ${state.triangles}; ${own.flip_of_whole_picture.toFixed(4)}, ${exact.flip_of_whole_picture.toFixed(4)} (${own.flip.toFixed(3)}, ${exact.flip.toFixed(3)}); ` +
            `${own.coverage.toFixed(3)}, ${exact.coverage.toFixed(3)}`);
        must(state.firstPicture <= 3000, `${folder}, ${view}: the first picture takes ${state.firstPicture} ms`);
        must(own.flip_of_whole_picture <= 0.05, `${folder}, ${view}: FLIP ${own.flip_of_whole_picture}`);
        if (view !== 'far') continue;
        must(state.loaded <= 0.1 * tiles, `${folder}: ${state.loaded} of ${tiles} tiles are loaded from afar`);
        if (state.splats === 0) continue;
        // Of the browser's own triangles: all that there are.
        await look(folder, view, 1e-6, at('triangles'));
        const { coverage } = compared(at('web'), at('triangles'));
        console.log(`${folder}, ${view}: splats cover ${coverage.toFixed(3)} of what triangles do in the browser`);
        must(Math.abs(coverage - 1) <= 0.05, `${folder}: splats cover ${coverage} of what triangles do`);
    }
}
await browser.close();
server.close();
rmSync(profile, { recursive: true, force: true });
console.log(wrong.length === 0 ? 'all is as it must be' : `${wrong.length} things are not as they must be`);
process.exit(wrong.length === 0 ? 0 : 1);
