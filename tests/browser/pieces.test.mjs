// Tests of the page of a body that breaks, in Chromium. scripts/test-tools writes the runs to the folder RUNS, and
// starts these tests.

import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { join } from 'node:path';
import { after, before, test } from 'node:test';

import { drawn, launch, open, pixels, state, vertices } from './support.mjs';

const folder = process.env.RUNS;
const notch = join(folder, 'notch', 'supple.html'),
  joined = join(folder, 'joined_pieces.html');
const LAST = 40;

let browser;
before(async () => {
  browser = await launch();
});
after(() => browser.close());

// Opens a page, and closes it after the test.
async function opened(t, path) {
  const session = await open(browser, path);
  t.after(() => session.context.close());
  return session;
}

async function show(page, frame) {
  await page.fill('#frame', String(frame));
  await drawn(page);
  assert.equal((await state(page)).frame, frame);
}

const frameFile = (frame) => join(folder, 'notch', `bar_${String(frame).padStart(4, '0')}.obj`);

// Returns the faces of an OBJ file and, apart from them, the caps: corners from the lowest one on, as text, in order.
function facesOf(path) {
  const faces = { faces: [], caps: [] };
  let kind = 'faces';
  for (const line of readFileSync(path, 'utf8').split('\n')) {
    const [word, ...rest] = line.trim().split(/\s+/);
    if (word === 'usemtl') kind = rest[0] === 'bar_cap' ? 'caps' : 'faces';
    if (word === 'f') faces[kind].push(rest.map((corner) => parseInt(corner) - 1));
  }
  return { faces: sorted(faces.faces), caps: sorted(faces.caps) };
}

// The first frame of the broken body, and frames before and after it, in the order in which the tests show them: forwards,
// backwards, and over several frames.
const FIRST = Array.from({ length: LAST + 1 }, (_, frame) => frame).find(
  (frame) => facesOf(frameFile(frame)).caps.length > 0,
);
const SHOWN = [0, FIRST + 1, FIRST + 3, FIRST + 2, LAST, FIRST - 5, FIRST, LAST];

function sorted(faces) {
  return faces.map(turned).sort();
}

function turned(corners) {
  const first = corners.indexOf(Math.min(...corners));
  return [...corners.slice(first), ...corners.slice(0, first)].join(' ');
}

test('the browser has the faces and positions of every frame', async (t) => {
  const { page, messages } = await opened(t, notch);
  const shapes = new Set(),
    written = new Set();
  for (let frame = 0; frame <= LAST; frame++) {
    const read = await page.evaluate((frame) => {
      const body = player.runs[0].bodies[0],
        index = body.shapeOf[frame],
        { surface } = body.shapes[index],
        out = new Float64Array(3 * surface.vertices),
        faces = [];
      body.mesh.positions(frame, out);
      let first = 0;
      for (const size of surface.sizes) {
        faces.push(Array.from(surface.corners.subarray(first, first + size)));
        first += size;
      }
      const uncut = surface.sources?.length ?? faces.length;
      return { index, positions: Array.from(out), step: body.mesh.grid(frame)[1], faces, uncut };
    }, frame);
    shapes.add(read.index);
    const expected = vertices(frameFile(frame)).flat();
    assert.equal(read.positions.length, expected.length);
    // OBJ frames have the shortest digits of an f32, so that reading them as f64 adds less than an f32 rounding.
    const worst = Math.max(
      ...read.positions.map(
        (x, i) => Math.abs(x - expected[i]) - read.step[i % 3] / 2 - 2 ** -24 * Math.abs(expected[i]),
      ),
    );
    assert.ok(worst <= 0, `frame ${frame}: ${worst}`);
    const { faces, caps } = facesOf(frameFile(frame));
    written.add([...faces, '', ...caps].join('\n'));
    assert.deepEqual(sorted(read.faces.slice(0, read.uncut)), faces, `frame ${frame}`);
    assert.deepEqual(sorted(read.faces.slice(read.uncut)), caps, `frame ${frame}`);
  }
  assert.ok(shapes.size > 2, `${shapes.size} shapes`);
  assert.equal(shapes.size, written.size);
  assert.deepEqual(messages, []);
});

test('faces, edges and lattice are those of the frame, in any order of the frames', async (t) => {
  const { page, messages } = await opened(t, notch);
  await page.keyboard.press('w');
  await page.keyboard.press('l');
  for (const frame of SHOWN) {
    await show(page, frame);
    const found = await page.evaluate((frame) => {
      const { body, faces, edges, lattice } = player.views.views[0].bodies[0],
        { surface, links } = body.shapes[body.shapeOf[frame]];
      const largest = (geometry) => geometry.index.array.reduce((a, b) => Math.max(a, b), 0);
      const place = lattice.geometry.attributes.position.array,
        at = lattice.geometry.index.array;
      let longest = 0;
      for (let i = 0; i < at.length; i += 2) {
        const [a, b] = [3 * at[i], 3 * at[i + 1]];
        longest = Math.max(longest, Math.hypot(...[0, 1, 2].map((axis) => place[a + axis] - place[b + axis])));
      }
      return {
        triangles: faces.geometry.index.count / 3,
        expected: surface.sizes.reduce((sum, size) => sum + size - 2, 0),
        drawn: faces.geometry.groups.map((group) => group.count / 3),
        points: [largest(edges.geometry) + 1, surface.vertices],
        links: [at.length, links.length],
        latticePoints: [largest(lattice.geometry) + 1, lattice.geometry.attributes.position.count],
        finite: faces.geometry.attributes.normal.array.every(Number.isFinite),
        longest,
      };
    }, frame);
    assert.equal(found.triangles, found.expected, `frame ${frame}`);
    assert.equal(found.drawn[0] + found.drawn[1], found.triangles);
    assert.equal(found.drawn[1] > 0, frame >= FIRST, `frame ${frame} has caps`);
    for (const [last, count] of [found.points, found.links, found.latticePoints]) assert.equal(last, count);
    assert.ok(found.finite);
    // Cells of 0.1 break before they are twice as long; the gap is wider at the end.
    assert.ok(found.longest < 0.2, `frame ${frame}: a link of ${found.longest}`);
  }
  assert.deepEqual(messages, []);
});

test('a frame looks the same whichever frame was shown before', async (t) => {
  const { page } = await opened(t, notch);
  for (const keys of ['', 'w', 'l']) {
    for (const key of keys) await page.keyboard.press(key);
    const seen = new Map();
    for (const frame of SHOWN) {
      await show(page, frame);
      const { data } = await pixels(page);
      assert.ok(!seen.has(frame) || seen.get(frame).equals(data), `frame ${frame} with ${keys}`);
      for (const [other, before] of seen) assert.ok(other === frame || !before.equals(data), `${other} and ${frame}`);
      seen.set(frame, data);
    }
  }
});

test('the surfaces of cracks have a color of their own', async (t) => {
  const { page } = await opened(t, notch);
  await show(page, LAST);
  await page.screenshot({ path: `${notch}.png` });
  const before = (await pixels(page)).data;
  await page.evaluate(() => {
    const { bodies, caps } = player.materials;
    caps[0].color.copy(bodies[0].color);
    player.invalidate();
  });
  const now = (await pixels(page)).data;
  let changed = 0;
  for (let i = 0; i < now.length; i += 4) {
    if (Math.hypot(...[0, 1, 2].map((k) => now[i + k] - before[i + k])) > 30) changed++;
  }
  // The right end of the left piece is seen at an angle.
  assert.ok(changed > 500, `${changed} pixels`);
});

test('a page shows runs with and without pieces side by side', async (t) => {
  const { page, messages } = await opened(t, joined);
  assert.deepEqual(await page.locator('.label').allTextContents(), ['notch', 'colliders']);
  for (const frame of [LAST, 0]) await show(page, frame);
  const versions = await page.evaluate(() => player.runs.map((run) => run.version));
  assert.deepEqual(versions, [2, 1]);
  assert.deepEqual(messages, []);
});
