// Tests of pages in Chromium. scripts/test-tools writes the runs to the folder RUNS, and starts these tests.

import assert from 'node:assert/strict';
import { readFileSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { after, before, test } from 'node:test';

import { bounds, drawn, launch, open, pixels, projectedBounds, state, vertices } from './support.mjs';

const folder = process.env.RUNS;
const kept = join(folder, 'kept', 'supple.html'),
  joined = join(folder, 'joined.html'),
  colliders = join(folder, 'colliders', 'supple.html');
const LAST = 40;

let browser;
before(async () => {
  browser = await launch();
});
after(() => browser.close());

// Opens a page, and closes it after the test. Messages in the console fail the test.
async function opened(t, path, options) {
  const session = await open(browser, path, options);
  t.after(() => session.context.close());
  return session;
}

test('a page opens from the disk without messages and without a network', async (t) => {
  for (const path of [kept, joined, colliders]) {
    const { page, messages, requests } = await opened(t, path);
    assert.equal((await state(page)).state, 'ready');
    await page.screenshot({ path: `${path}.png` });
    assert.deepEqual(messages, []);
    assert.deepEqual(
      requests.filter((url) => !/^(file|data|blob):/.test(url)),
      [],
    );
  }
});

test('the picture is not blank', async (t) => {
  for (const colorScheme of ['light', 'dark']) {
    const { page } = await opened(t, kept, { colorScheme });
    const { data } = await pixels(page);
    const colors = new Set();
    for (let i = 0; i < data.length; i += 4) colors.add((data[i] << 16) | (data[i + 1] << 8) | data[i + 2]);
    // A background of one gradient has at most a few hundred colors.
    assert.ok(colors.size > 1000, `${colors.size} colors`);
    const [red, green, blue] = await page.evaluate(() =>
      getComputedStyle(document.body).backgroundColor.match(/\d+/g).map(Number),
    );
    assert.equal(red + green + blue > 384, colorScheme === 'light');
  }
});

test('the first and the last frame are at the projected bounds of the meshes', async (t) => {
  const { page } = await opened(t, kept);
  await page.addStyleTag({
    content: '#views, header, footer { background: #000 !important; border-color: #000 !important }',
  });
  await page.keyboard.press('g');
  await page.keyboard.press('v');
  for (const [key, frame] of [
    ['Home', 0],
    ['End', LAST],
  ]) {
    await page.keyboard.press(key);
    await drawn(page);
    assert.equal((await state(page)).frame, frame);
    const number = String(frame).padStart(4, '0');
    const expected = await projectedBounds(page, vertices(join(folder, 'kept', `bust_${number}.obj`)));
    const found = bounds(await pixels(page));
    // A pixel is lit if the surface covers a part of it; the softened edge covers at most one more.
    expected.forEach((edge, k) =>
      assert.ok(Math.abs(found[k] - edge) <= 2, `frame ${frame}: ${found} instead of ${expected}`),
    );
    assert.ok(expected[3] - expected[1] > 200, 'the body fills a large part of the picture');
  }
});

test('the browser reads every position to half a grid step', async (t) => {
  const { page } = await opened(t, kept);
  for (let frame = 0; frame <= LAST; frame++) {
    const read = await page.evaluate((frame) => {
      const { mesh } = player.runs[0].bodies[0],
        out = new Float64Array(3 * mesh.points);
      mesh.positions(frame, out);
      return { positions: Array.from(out), step: mesh.grid(frame)[1] };
    }, frame);
    const expected = vertices(join(folder, 'kept', `bust_${String(frame).padStart(4, '0')}.obj`)).flat();
    assert.equal(read.positions.length, expected.length);
    // OBJ frames have the shortest digits of an f32, so that reading them as f64 adds less than an f32 rounding.
    const worst = Math.max(
      ...read.positions.map(
        (x, i) => Math.abs(x - expected[i]) - read.step[i % 3] / 2 - 2 ** -24 * Math.abs(expected[i]),
      ),
    );
    assert.ok(worst <= 0, `frame ${frame}: ${worst}`);
  }
});

test('keys play, step, and switch the display', async (t) => {
  const { page } = await opened(t, kept);
  const press = async (key) => {
    await page.keyboard.press(key);
    await drawn(page);
    return state(page);
  };
  assert.equal((await state(page)).play, 'Play', 'with reduced motion the page does not start by itself');
  assert.equal((await press('ArrowRight')).frame, 1);
  assert.equal((await press('Shift+ArrowRight')).frame, 11);
  assert.equal((await press('ArrowLeft')).frame, 10);
  assert.equal((await press('Shift+ArrowLeft')).frame, 0);
  assert.equal((await press('ArrowLeft')).frame, 0);
  assert.match((await press('End')).time, new RegExp(`^Frame ${LAST} of ${LAST} · 1\\.33 s$`));
  assert.equal((await press('Home')).frame, 0);
  assert.equal((await press('Space')).play, 'Pause');
  await page.waitForFunction(() => Number(document.getElementById('frame').value) > 2);
  assert.equal((await press('Space')).play, 'Play');
  await press('Home');
  let before = (await pixels(page)).data;
  for (const [key, id] of [
    ['w', 'wireframe'],
    ['l', 'lattice'],
    ['g', 'ground'],
  ]) {
    const pressed = () => page.getAttribute(`#${id}`, 'aria-pressed');
    const was = await pressed();
    await press(key);
    assert.notEqual(await pressed(), was);
    const now = (await pixels(page)).data;
    const changed = now.filter((value, i) => Math.abs(value - before[i]) > 8).length;
    assert.ok(changed > 1000, `${key} changes the picture: ${changed}`);
    before = now;
  }
  const camera = () => page.evaluate(() => player.views.camera.position.toArray());
  const rest = await camera();
  for (const key of ['a', 'ArrowUp', '+']) {
    const was = await camera();
    await press(key);
    assert.notDeepEqual(await camera(), was, key);
  }
  await press('r');
  (await camera()).forEach((x, i) => assert.ok(Math.abs(x - rest[i]) < 1e-9));
  await press('>');
  assert.equal(await page.inputValue('#speed'), '2');
  await press('v');
  assert.ok(await page.isHidden('#plots'));
  await press('?');
  assert.ok(await page.isVisible('#keys'));
  const listed = await page.locator('#keys kbd').allTextContents();
  for (const key of ['Space', '←', '→', 'Home', 'End', 'W', 'L']) assert.ok(listed.includes(key), key);
  await press('Escape');
  assert.ok(await page.isHidden('#keys'));
});

test('everything can be reached with the tab key, has a name, and shows the focus', async (t) => {
  const { page } = await opened(t, colliders);
  const reached = [];
  for (let k = 0; k < 30; k++) {
    await page.keyboard.press('Tab');
    const element = await page.evaluate(() => {
      const { activeElement: at } = document;
      const name = at.getAttribute('aria-label') ?? at.labels?.[0]?.textContent ?? at.textContent;
      return {
        id: at === document.body ? '' : at.id || at.className,
        name: name.trim(),
        outline: getComputedStyle(at).outlineStyle,
      };
    });
    if (element.id === '' || element.id === reached[0]?.id) break;
    assert.notEqual(element.name, '', element.id);
    reached.push(element);
  }
  const ids = reached.map((element) => element.id);
  for (const id of [
    'wireframe',
    'lattice',
    'colliders',
    'reset',
    'theme',
    'help',
    'canvas',
    'first',
    'play',
    'last',
    'frame',
    'speed',
  ]) {
    assert.ok(
      ids.some((found) => found.split(' ').includes(id)),
      `${id} in ${ids}`,
    );
  }
  for (const { id, outline } of reached) assert.equal(outline, 'solid', id);
  // Space on a focused button presses the button, and nothing else.
  await page.focus('#wireframe');
  await page.keyboard.press('Space');
  assert.equal(await page.getAttribute('#wireframe', 'aria-pressed'), 'true');
  assert.equal((await state(page)).play, 'Play');
});

test('the slider, the plot and the mouse show frames and turn the camera', async (t) => {
  const { page } = await opened(t, kept);
  await page.fill('#frame', '17');
  assert.equal((await state(page)).frame, 17);
  const box = await page.locator('.plot canvas').boundingBox();
  await page.mouse.click(box.x + box.width - 14, box.y + box.height / 2);
  await drawn(page);
  assert.equal((await state(page)).frame, LAST);
  // The table has the volumes of the statistics.
  const cells = await page.locator('.plot tbody td').allTextContents();
  assert.match(cells[0], /^\+\d+\.\d\d %$/);
  assert.equal(cells[1], '0.00 %');
  const before = await page.evaluate(() => player.views.camera.position.toArray());
  await page.mouse.move(400, 300);
  await page.mouse.down();
  await page.mouse.move(480, 320, { steps: 4 });
  await page.mouse.up();
  assert.notDeepEqual(await page.evaluate(() => player.views.camera.position.toArray()), before);
});

test('joined runs have a view and a plot each, and one time line', async (t) => {
  const { page } = await opened(t, joined);
  assert.deepEqual(await page.locator('.label').allTextContents(), ['kept', 'plain']);
  assert.equal(await page.locator('.plot').count(), 2);
  await page.keyboard.press('End');
  await drawn(page);
  // The second run has half as many frames, and stays at its last one.
  assert.match((await state(page)).time, new RegExp(`Frame ${LAST} of ${LAST}`));
  const shown = await page.evaluate(() => Array.from(player.views.views[1].bodies[0].geometry.positions.slice(0, 3)));
  const last = vertices(join(folder, 'plain', 'bust_0020.obj'))[0];
  const step = await page.evaluate(() => player.runs[1].bodies[0].mesh.grid(20)[1]);
  shown.forEach((x, axis) => assert.ok(Math.abs(x - last[axis]) <= step[axis], `${shown} instead of ${last}`));
});

test('colliders are drawn, and can be hidden', async (t) => {
  const { page } = await opened(t, colliders);
  const shapes = await page.evaluate(() => player.runs[0].colliders.map((collider) => collider.shape));
  assert.deepEqual([...new Set(shapes)].sort(), ['box', 'capsule', 'mesh', 'plane', 'sphere']);
  const shown = (await pixels(page)).data;
  await page.keyboard.press('c');
  const hidden = (await pixels(page)).data;
  const changed = hidden.filter((value, i) => Math.abs(value - shown[i]) > 8).length;
  assert.ok(changed > 1000, `${changed} values differ`);
});

test('colliders are drawn in the frames in which they are enabled', async (t) => {
  const { page } = await opened(t, colliders);
  const visible = async (key) => {
    await page.keyboard.press(key);
    await drawn(page);
    return page.evaluate(() => player.views.views[0].colliders.map((collider) => collider.content.visible));
  };
  assert.deepEqual(await visible('Home'), [true, true, true, true, true]);
  assert.deepEqual(await visible('End'), [true, true, false, true, true]);
});

test('the ground is as large as the bodies and their shadows need', async (t) => {
  const { page } = await opened(t, kept);
  const scenes = [
    [3, 1, 2],
    [1, 20, 1],
    [1e-4, 2e-4, 1e-4],
    [3e4, 1e3, 3e4],
  ];
  const found = await page.evaluate((scenes) => {
    const up = new THREE.Vector3(0, 1, 0),
      { key } = player.views.views[0].lights,
      light = key.position.clone().sub(key.target.position);
    const tilt = Math.hypot(light.x, light.z) / light.y;
    return scenes.map(([x, y, z]) => {
      const box = new THREE.Box3(new THREE.Vector3(-x, 0, -z), new THREE.Vector3(x, y, z));
      return [planeRadius(box, up, false), Math.hypot(x, z) + tilt * y];
    });
  }, scenes);
  // At the edge of the ground nothing is seen, at its half a quarter.
  for (const [radius, needed] of found) assert.ok(radius > needed && radius <= 2 * needed, `${radius}, ${needed}`);
});

test('a page runs in the frame of a notebook', async (t) => {
  const text = readFileSync(kept, 'utf8').replaceAll('&', '&amp;').replaceAll('"', '&quot;'),
    notebook = join(folder, 'notebook.html');
  writeFileSync(
    notebook,
    `<!doctype html><html lang="en" data-state="ready"><meta charset="utf-8"><title>Notebook</title>
<iframe srcdoc="${text}" sandbox="allow-scripts" width="900" height="560" title="Animation"></iframe></html>`,
  );
  const { page, messages } = await opened(t, notebook);
  const frame = page.frames()[1];
  await frame.waitForFunction(() => document.documentElement.dataset.state, null, { timeout: 120_000 });
  assert.equal((await state(frame)).state, 'ready');
  // The frame is a process of its own, which may handle a click after the click returns.
  await frame.click('#last');
  await frame.waitForFunction((last) => Number(document.getElementById('frame').value) === last, LAST);
  await frame.click('#help');
  await frame.waitForSelector('#keys', { state: 'visible' });
  assert.deepEqual(messages, []);
});

test('without scripts the page says what it contains', async (t) => {
  const { page } = await opened(t, kept, { javaScriptEnabled: false });
  const text = await page.innerText('#summary');
  for (const words of [
    'needs JavaScript',
    '1 body, 41 frames at 30 frames per second',
    'bust: volume from 100.00 % to 100.00 %',
  ]) {
    assert.ok(text.includes(words), `${words} in ${text}`);
  }
  assert.ok((await page.isVisible('#summary')) && (await page.isHidden('#player')));
});

test('a page that cannot work says what to do', async (t) => {
  const failure = async (path, before, words) => {
    const { page } = await opened(t, path, { before });
    const { state: reached, message } = await state(page);
    assert.equal(reached, 'failed');
    for (const word of words) assert.ok(message.includes(word), message);
    assert.ok(await page.isVisible('#message'));
  };
  await failure(kept, 'delete globalThis.DecompressionStream', ['unpack', 'Firefox 113']);
  await failure(kept, 'HTMLCanvasElement.prototype.getContext = () => null', ['WebGL 2', 'hardware acceleration']);
  const damaged = join(folder, 'damaged.html'),
    whole = readFileSync(kept, 'utf8');
  const start = whole.indexOf('data-run="0">') + 2000;
  writeFileSync(damaged, whole.slice(0, start) + whole.slice(start + 4000));
  await failure(damaged, '', ['incomplete', 'copy it again']);
});

test('a page with motion starts to play by itself, and returns to its first frame', async (t) => {
  const { page } = await opened(t, kept, { reducedMotion: 'no-preference' });
  assert.equal((await state(page)).play, 'Pause');
  await page.evaluate(() => {
    player.clock.speed = 10;
  });
  await page.waitForFunction((last) => Number(document.getElementById('frame').value) === last, LAST);
  await page.waitForFunction((last) => Number(document.getElementById('frame').value) < last, LAST);
});
