// Tests of the page to play with, in Chromium. scripts/test-tools builds the page in the folder WEB, writes the
// positions of a drag that is computed without a browser to RUNS/drag.bin, and starts these tests.

import assert from 'node:assert/strict';
import { createReadStream, existsSync, readFileSync } from 'node:fs';
import { createServer } from 'node:http';
import { extname, join } from 'node:path';
import { after, before, test } from 'node:test';

import { launch } from './support.mjs';

const folder = process.env.WEB;
const TYPES = { '.html': 'text/html', '.js': 'text/javascript', '.css': 'text/css', '.wasm': 'application/wasm' };

let browser, server, address;
before(async () => {
  browser = await launch();
  server = createServer((request, response) => {
    const path = join(folder, request.url === '/' ? 'index.html' : new URL(request.url, 'http://localhost').pathname);
    response.writeHead(existsSync(path) ? 200 : 404, { 'content-type': TYPES[extname(path)] ?? 'text/plain' });
    if (existsSync(path)) createReadStream(path).pipe(response);
    else response.end();
  });
  await new Promise((resolve) => server.listen(0, '127.0.0.1', resolve));
  address = `http://127.0.0.1:${server.address().port}/`;
});
after(async () => {
  await browser.close();
  server.close();
});

// Opens the page, and waits until it shows a body. The page is closed after the test.
async function opened(t, options = {}) {
  const context = await browser.newContext({ viewport: { width: 700, height: 480 }, ...options });
  t.after(() => context.close());
  const page = await context.newPage();
  const messages = [],
    requests = [];
  page.on('console', (message) => messages.push(`${message.type()}: ${message.text()}`));
  page.on('pageerror', (error) => messages.push(`uncaught: ${error.message}`));
  page.on('request', (request) => requests.push(request.url()));
  await page.goto(address);
  await page.waitForFunction(() => document.documentElement.dataset.state, null, { timeout: 120_000 });
  assert.equal(await page.evaluate(() => document.documentElement.dataset.state), 'ready');
  return { page, messages, requests };
}

// Waits until the simulation has advanced by some pictures.
function pictures(page, count) {
  return page.evaluate(async (count) => {
    const { page } = globalThis;
    for (let k = 0; k < count; k++) {
      const { buffer } = page.picture.body;
      const limit = performance.now() + 2000;
      while (page.picture.body.buffer === buffer && performance.now() < limit) {
        await new Promise((resolve) => setTimeout(resolve, 5));
      }
    }
  }, count);
}

// Returns the highest vertex: its number, its position, and its place in the page.
function top(page, number = -1) {
  return page.evaluate((number) => {
    const { picture } = globalThis.page,
      { positions } = picture.body;
    let vertex = Math.max(number, 0);
    for (let v = 0; number < 0 && v < positions.length / 3; v++) {
      if (positions[3 * v + 1] > positions[3 * vertex + 1]) vertex = v;
    }
    const position = [...positions.slice(3 * vertex, 3 * vertex + 3)];
    picture.views.camera.updateMatrixWorld();
    const projected = new THREE.Vector3(...position).project(picture.views.camera),
      box = picture.canvas.getBoundingClientRect();
    return {
      vertex,
      position,
      x: box.left + ((projected.x + 1) / 2) * box.width,
      y: box.top + ((1 - projected.y) / 2) * box.height,
    };
  }, number);
}

// Returns for each pointer the vertex nearest to the point that it has grabbed.
function grabbedVertices(page) {
  return page.evaluate(() => {
    const { positions } = globalThis.page.picture.body,
      vertices = Array.from({ length: positions.length / 3 }, (_, v) => v);
    return [...globalThis.page.drags.held.values()].map(({ from }) => {
      const off = (v) =>
        Math.hypot(positions[3 * v] - from.x, positions[3 * v + 1] - from.y, positions[3 * v + 2] - from.z);
      return vertices.reduce((a, b) => (off(b) < off(a) ? b : a));
    });
  });
}

function volumeError(page) {
  return page.evaluate(() => globalThis.page.picture.volumeError());
}

const distance = (a, b) => Math.hypot(...a.map((x, axis) => x - b[axis]));
const text = (page, id) => page.textContent(`#${id}`);

test('the page opens without messages, from its own folder alone, and shows figures', async (t) => {
  const { page, messages, requests } = await opened(t);
  await page.waitForFunction(() => /ms$/.test(document.getElementById('step-time').textContent), null, {
    timeout: 60_000,
  });
  for (const id of ['step-time', 'surface-time', 'draw-time']) assert.match(await text(page, id), /^\d+\.\d ms$/);
  assert.match(await text(page, 'lattice-vertices'), /^1,0\d\d$/);
  assert.equal(await text(page, 'mesh-vertices'), '4,717');
  assert.ok(Math.abs(await volumeError(page)) < 1e-6);
  assert.deepEqual(messages, []);
  assert.deepEqual(
    requests.filter((url) => !url.startsWith(address) && !url.startsWith('data:')),
    [],
  );
});

test('a drag with the mouse pulls the body, and the volume stays until its correction is switched off', async (t) => {
  const { page, messages } = await opened(t);
  await pictures(page, 20);
  const before = await top(page);
  // Just below the top, where the surface faces the camera.
  const [x, y] = [before.x, before.y + 6];
  await page.mouse.move(x, y);
  await page.mouse.down();
  const [grabbed] = await grabbedVertices(page);
  const start = await top(page, grabbed);
  await page.mouse.move(x + 20, y - 30, { steps: 5 });
  await page.mouse.move(x + 40, y - 60, { steps: 5 });
  await pictures(page, 60);
  const end = await top(page, grabbed);
  assert.ok(distance(end.position, start.position) > 0.1, `${end.position} and ${start.position}`);
  // The vertex follows the pointer, up to the few pixels by which it is beside the grabbed point.
  assert.ok(Math.hypot(end.x - start.x - 40, end.y - start.y + 60) < 6, `${end.x - start.x}, ${end.y - start.y}`);
  assert.ok(Math.abs(await volumeError(page)) < 1e-6, `${await volumeError(page)}`);
  await page.keyboard.press('v');
  assert.equal(await page.getAttribute('#volume', 'aria-pressed'), 'false');
  await page.waitForFunction(() => Math.abs(globalThis.page.picture.volumeError()) > 0.01, null, { timeout: 30_000 });
  await page.keyboard.press('v');
  await page.waitForFunction(() => Math.abs(globalThis.page.picture.volumeError()) < 1e-6, null, { timeout: 30_000 });
  await page.mouse.up();
  assert.equal(await page.evaluate(() => globalThis.page.drags.held.size), 0);
  await page.keyboard.press('r');
  await page.keyboard.press('Space');
  assert.ok(Math.abs(await volumeError(page)) < 1e-6);
  assert.deepEqual(messages, []);
});

test('a drag beside the body turns the camera', async (t) => {
  const { page } = await opened(t);
  const camera = () => page.evaluate(() => globalThis.page.picture.views.camera.position.toArray());
  const before = await camera(),
    box = await page.locator('#canvas').boundingBox();
  await page.mouse.move(box.x + 10, box.y + 10);
  await page.mouse.down();
  await page.mouse.move(box.x + 60, box.y + 20, { steps: 3 });
  await page.mouse.up();
  assert.ok(distance(await camera(), before) > 0.1);
});

// Drops a file on the page.
async function drop(page, name, content) {
  await page.evaluate(
    ([name, content]) => {
      const data = new DataTransfer();
      data.items.add(new File([content], name));
      for (const kind of ['dragover', 'drop']) {
        document
          .getElementById('canvas')
          .dispatchEvent(new DragEvent(kind, { dataTransfer: data, bubbles: true, cancelable: true }));
      }
    },
    [name, content],
  );
}

// A cube of edge 1 as OBJ.
const CUBE = [0, 1, 2, 3, 4, 5, 6, 7]
  .map((k) => `v ${k & 1} ${(k >> 1) & 1} ${(k >> 2) & 1}\n`)
  .concat('f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n')
  .join('');

// A tetrahedron as STL.
const corner = (k) => `vertex ${k & 1} ${(k >> 1) & 1} ${(k >> 2) & 1}\n`;
const facet = (corners) => `facet normal 0 0 0\nouter loop\n${corners.map(corner).join('')}endloop\nendfacet\n`;
const TETRAHEDRON = `solid a\n${[[0, 2, 1], [0, 1, 4], [1, 2, 4], [2, 0, 4]].map(facet).join('')}endsolid a\n`;

test('a model that is dropped is shown, and a broken one gives the message with the line', async (t) => {
  const { page, messages } = await opened(t);
  await drop(page, 'cube.obj', CUBE);
  await page.waitForFunction(() => document.getElementById('mesh-vertices').textContent === '8');
  assert.equal(await page.locator('#shape option:checked').textContent(), 'cube.obj');
  await drop(page, 'broken.obj', CUBE.replace('v 1 1 0', 'v 1 one 0'));
  await page.waitForSelector('#message button');
  assert.match(
    await text(page, 'message'),
    /^broken\.obj:4: `one` in `v` is not a number; write numbers like 1\.5 or 2e-3/,
  );
  // The body before is still there, and moves.
  assert.equal(await text(page, 'mesh-vertices'), '8');
  await page.click('#message button');
  assert.ok(await page.isHidden('#message'));
  await drop(page, 'photo.png', '\u0089PNG\u0000');
  await page.waitForSelector('#message button');
  assert.match(await text(page, 'message'), /^photo\.png: files with the extension \.png are not read; give a model: OBJ/);
  await drop(page, 'tetrahedron.stl', TETRAHEDRON);
  await page.waitForFunction(() => document.getElementById('mesh-vertices').textContent === '4');
  await drop(page, 'open.obj', CUBE.replace('f 3 7 8 4\n', ''));
  await page.waitForFunction(() => document.getElementById('volume-name').textContent.includes('open'));
  assert.deepEqual(messages, []);
});

test('a closed sheet without thickness is shown, and files that cannot be read give a message', async (t) => {
  const { page, messages } = await opened(t);
  await drop(page, 'sheet.obj', 'v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\nf 4 3 2 1\n');
  await page.waitForFunction(() => document.getElementById('mesh-vertices').textContent === '4');
  await pictures(page, 5);
  assert.equal(await text(page, 'volume-name'), 'Volume error');
  assert.doesNotMatch(await text(page, 'volume-error'), /NaN|Infinity/);
  // As a folder that is dropped.
  await page.evaluate(() => {
    const folder = new File([], 'folder');
    folder.arrayBuffer = () => Promise.reject(new DOMException('', 'NotFoundError'));
    return globalThis.page.loadFile(folder);
  });
  assert.match(await text(page, 'message'), /^folder cannot be read; drop an OBJ, GLB, glTF, STL or PLY file/);
  await page.route('**/ring.obj', (route) => route.abort());
  await page.selectOption('#shape', 'Ring');
  await page.waitForFunction(() => /ring\.obj cannot be read/.test(document.getElementById('message').textContent));
  assert.equal(await page.evaluate(() => document.documentElement.dataset.state), 'ready');
  assert.equal(await text(page, 'mesh-vertices'), '4');
  // The browser itself reports the file that is not there.
  assert.deepEqual(
    messages.filter((message) => !message.includes('net::ERR_FAILED')),
    [],
  );
});

test('without WebGL 2 the page says so, and without its first shape it waits for another', async (t) => {
  const context = await browser.newContext();
  t.after(() => context.close());
  const page = await context.newPage(),
    errors = [];
  page.on('pageerror', (error) => errors.push(error.message));
  await page.route('**/bust.obj', (route) => route.fulfill({ status: 404 }));
  await page.goto(address);
  await page.waitForSelector('#message button');
  assert.match(await text(page, 'message'), /bust\.obj cannot be read: 404/);
  await page.click('#reset');
  await page.selectOption('#gravity', '0');
  await drop(page, 'cube.obj', CUBE);
  await page.waitForFunction(() => document.getElementById('mesh-vertices').textContent === '8');
  assert.deepEqual(errors, []);
  await page.addInitScript(() => {
    HTMLCanvasElement.prototype.getContext = () => null;
  });
  await page.reload();
  await page.waitForLoadState('networkidle');
  assert.match(await text(page, 'message'), /WebGL 2/);
  assert.equal(await page.evaluate(() => document.documentElement.dataset.state), 'failed');
});

test('reset, material, resolution, gravity, floor, base and pause', async (t) => {
  const { page, messages } = await opened(t);
  const number = async (id) => Number((await text(page, id)).replace(',', ''));
  const positions = () => page.evaluate(() => [...globalThis.page.picture.body.positions.slice(0, 3000)]);
  const start = await page.evaluate(() => [...globalThis.page.picture.body.start.slice(0, 3000)]);
  await pictures(page, 5);
  assert.notDeepEqual(await positions(), start);
  await page.click('#pause');
  await page.click('#reset');
  await page.waitForFunction((x) => globalThis.page.picture.body.positions[1] === x, start[1]);
  assert.deepEqual(await positions(), start);
  const soft = await number('steps');
  await page.selectOption('#material', 'firm');
  await page.selectOption('#resolution', '250');
  await page.waitForFunction(() => Number(document.getElementById('lattice-vertices').textContent) < 300);
  await page.selectOption('#resolution', '1000');
  await page.waitForFunction(() => document.getElementById('lattice-vertices').textContent.startsWith('1,0'));
  assert.ok((await number('steps')) > soft);
  // A number that is refused: the control goes back.
  await page.evaluate(() => document.getElementById('resolution').append(new Option('0')));
  await page.selectOption('#resolution', '0');
  await page.waitForSelector('#message button');
  assert.equal(await page.inputValue('#resolution'), '1000');
  await page.click('#message button');
  // Without base, floor and gravity the body stays where it is; with gravity it falls.
  for (const id of ['base', 'floor']) await page.click(`#${id}`);
  await page.selectOption('#gravity', '0');
  await page.evaluate(() => globalThis.page.reset());
  await page.click('#pause');
  const height = async () => (await top(page)).position[1];
  const before = await height();
  await pictures(page, 5);
  assert.ok(Math.abs((await height()) - before) < 1e-3);
  await page.selectOption('#gravity', '9.81');
  await page.waitForFunction((before) => globalThis.page.picture.body.positions[1] < before - 1, before, {
    timeout: 60_000,
  });
  assert.deepEqual(messages, []);
});

// Moves a slider to a number, as a pointer does.
function slide(page, id, number) {
  return page.locator(`#${id}`).fill(String(number));
}

test("Poisson's ratio begins as that of the material, and can be another", async (t) => {
  const { page, messages } = await opened(t);
  const shown = async () => [await page.inputValue('#poisson'), await text(page, 'poisson + output')];
  assert.deepEqual(await shown(), ['0.45', '0.45']);
  for (const [material, ratio] of [
    ['rubber', '0.4'],
    ['firm', '0.3'],
    ['jelly', '0.45'],
  ]) {
    await page.selectOption('#material', material);
    await page.waitForFunction((ratio) => document.getElementById('poisson').value === ratio, ratio);
  }
  const steps = async () => Number(await text(page, 'steps'));
  await pictures(page, 5);
  const many = await steps();
  await slide(page, 'poisson', 0.1);
  await page.waitForFunction((many) => Number(document.getElementById('steps').textContent) < many, many);
  // It is kept by another lattice, and is that of the material again after another choice.
  await page.selectOption('#resolution', '250');
  await page.waitForFunction(() => Number(document.getElementById('lattice-vertices').textContent) < 300);
  assert.deepEqual(await shown(), ['0.1', '0.10']);
  await page.selectOption('#material', 'firm');
  await page.waitForFunction(() => document.getElementById('poisson').value === '0.3');
  assert.deepEqual(messages, []);
});

test('a body at rest is inflated while the slider moves, and keeps its new volume', async (t) => {
  const { page, messages } = await opened(t);
  await page.selectOption('#shape', 'Ball');
  await page.selectOption('#resolution', '250');
  await page.waitForFunction(() => Number(document.getElementById('lattice-vertices').textContent) < 300);
  const rests = () => page.waitForFunction(() => globalThis.page.isAtRest, null, { timeout: 60_000 });
  await rests();
  const height = async () => (await top(page)).position[1];
  const before = await height();
  await slide(page, 'inflate', 2);
  await page.waitForFunction(() => globalThis.page.picture.body.volumeRatio > 1.999);
  await rests();
  // The held base keeps its width.
  assert.ok((await height()) > 1.15 * before, `${await height()} and ${before}`);
  assert.ok(Math.abs(await volumeError(page)) < 1e-6, `${await volumeError(page)}`);
  // Arrows move the slider, and neither the camera nor the body.
  const camera = () => page.evaluate(() => globalThis.page.picture.views.camera.position.toArray());
  const place = await camera();
  await page.focus('#inflate');
  await page.keyboard.press('ArrowLeft');
  assert.equal(await text(page, 'inflate + output'), '1.99');
  assert.deepEqual(await camera(), place);
  await slide(page, 'inflate', 1);
  await page.waitForFunction(() => Math.abs(globalThis.page.picture.body.volumeRatio - 1) < 1e-6);
  await rests();
  assert.ok(Math.abs((await height()) - before) < 0.02, `${await height()} and ${before}`);
  assert.deepEqual(messages, []);
});

test('wind moves a body at rest, and a weak grip lags behind the pointer', async (t) => {
  const { page, messages } = await opened(t);
  await page.selectOption('#resolution', '250');
  await page.waitForFunction(() => Number(document.getElementById('lattice-vertices').textContent) < 300);
  const before = await top(page);
  await slide(page, 'wind', 15);
  await page.waitForFunction(
    ([vertex, x]) => globalThis.page.picture.body.positions[3 * vertex] > x + 0.005,
    [before.vertex, before.position[0]],
    { timeout: 60_000 },
  );
  assert.equal(await text(page, 'wind + output'), '15.00');
  await slide(page, 'wind', 0);
  await slide(page, 'grip', 0.1);
  assert.equal(await text(page, 'grip + output'), '0.10');
  assert.deepEqual(messages, []);
});

test('the keyboard reaches every control, and pulls the body', async (t) => {
  const { page } = await opened(t);
  const reached = [];
  for (let k = 0; k < 30; k++) {
    await page.keyboard.press('Tab');
    const id = await page.evaluate(() => document.activeElement.id);
    if (id === '' || id === reached[0]) break;
    reached.push(id);
  }
  for (const id of [
    'canvas',
    'shape',
    'open',
    'up',
    'material',
    'poisson',
    'inflate',
    'wind',
    'grip',
    'resolution',
    'gravity',
    'volume',
    'base',
    'floor',
    'pause',
    'reset',
  ])
    assert.ok(reached.includes(id), `${id} in ${reached}`);
  await page.focus('#canvas');
  await pictures(page, 10);
  const before = await top(page);
  await page.keyboard.press('Enter');
  for (let k = 0; k < 6; k++) await page.keyboard.press('ArrowUp');
  await pictures(page, 40);
  assert.ok((await top(page, before.vertex)).position[1] > before.position[1] + 0.1);
  await page.keyboard.press('Enter');
  assert.equal(await page.evaluate(() => globalThis.page.drags.held.size), 0);
  // A key that is held down acts once.
  await page.keyboard.down('Space');
  await page.keyboard.down('Space');
  assert.equal(await page.getAttribute('#pause', 'aria-pressed'), 'true');
  await page.keyboard.up('Space');
});

test('two fingers pull at two places', async (t) => {
  const { page } = await opened(t, { hasTouch: true });
  await pictures(page, 5);
  const { x, y } = await top(page),
    client = await page.context().newCDPSession(page);
  const touch = (type, ...points) =>
    client.send('Input.dispatchTouchEvent', { type, touchPoints: points.map(([x, y], id) => ({ x, y, id })) });
  await touch('touchStart', [x - 4, y + 12], [x + 4, y + 40]);
  assert.equal(await page.evaluate(() => globalThis.page.drags.held.size), 2);
  const vertices = await grabbedVertices(page);
  // The ways of the two places to the right, as the camera sees it, in m.
  const places = () =>
    page.evaluate((vertices) => {
      const { picture } = globalThis.page,
        { positions } = picture.body;
      return vertices.map((v) => new THREE.Vector3().fromArray(positions, 3 * v).dot(picture.across(1, 0)));
    }, vertices);
  const before = await places();
  await touch('touchMove', [x - 60, y], [x + 60, y + 40]);
  await pictures(page, 20);
  const [left, right] = (await places()).map((place, k) => place - before[k]);
  assert.ok(left < -0.05 && right > 0.05, `${left} and ${right}`);
  assert.ok(Math.abs(await volumeError(page)) < 1e-6);
  await touch('touchEnd');
  assert.equal(await page.evaluate(() => globalThis.page.drags.held.size), 0);
});

test('on a phone the page has no horizontal scroll bar, and the picture stays in view', async (t) => {
  const { page } = await opened(t, { viewport: { width: 360, height: 740 }, isMobile: true, hasTouch: true });
  assert.ok((await page.evaluate(() => document.documentElement.scrollWidth)) <= 360);
  await page.evaluate(() => scrollTo(0, document.body.scrollHeight));
  const box = await page.locator('#canvas').boundingBox();
  assert.ok(box.y > -1 && box.height > 250, JSON.stringify(box));
});

test('a simulation that fails is started again with the body that was shown', async (t) => {
  const { page } = await opened(t);
  await drop(page, 'cube.obj', CUBE);
  await page.waitForFunction(() => document.getElementById('mesh-vertices').textContent === '8');
  await page.evaluate(() => {
    const { page } = globalThis;
    const failed = page.ask('frame', { elapsed: 0, drags: [], buffer: null });
    page.simulation.end(new Error('out of memory'));
    return failed;
  });
  await page.waitForSelector('#message button');
  assert.match(await text(page, 'message'), /was started again: out of memory/);
  assert.equal(await text(page, 'mesh-vertices'), '8');
  await pictures(page, 3);
  assert.ok(Math.abs(await volumeError(page)) < 1e-6);
});

test('the browser computes the positions of the library outside it', async (t) => {
  const { page } = await opened(t);
  const computed = await page.evaluate(async () => {
    const { initSync, Playground, Settings } = await import('./supple_web.js');
    const [wasm, model] = await Promise.all(
      ['supple_web_bg.wasm', 'shapes/bust.obj'].map(async (path) => (await fetch(path)).arrayBuffer()),
    );
    const { memory } = initSync({ module: wasm });
    const playground = Playground.new('model.obj', new Uint8Array(model), Settings.new());
    const all = [];
    // As in crates/web/examples/drag.rs.
    playground.grab(1, 0, 0.7, 0);
    for (let frame = 0; frame < 180; frame++) {
      if (frame < 120) playground.drag(1, 0.0025 * frame, 0.00125 * frame, 0);
      else playground.release(1);
      playground.advance(1);
      if (frame % 60 !== 59) continue;
      playground.evaluate();
      all.push(...new Float32Array(memory.buffer, playground.positions(), 3 * playground.mesh_vertices()));
    }
    return all;
  });
  const bytes = readFileSync(join(process.env.RUNS, 'drag.bin')),
    expected = new Float32Array(bytes.buffer, bytes.byteOffset, bytes.byteLength / 4);
  assert.equal(computed.length, expected.length);
  assert.ok(computed.every((x, i) => x === expected[i]), 'the bits of the library');
});
