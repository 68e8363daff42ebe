// Helpers for the tests of pages in a browser.

import { readFileSync } from 'node:fs';
import { pathToFileURL } from 'node:url';
import { chromium } from 'playwright-core';

// Starts Chromium, which renders in software.
export function launch() {
  const args = ['--use-gl=angle', '--use-angle=swiftshader', '--enable-unsafe-swiftshader'];
  // Chromium refuses to run as root with its sandbox, for example in a container.
  if (process.getuid?.() === 0) args.push('--no-sandbox');
  return chromium.launch({ executablePath: process.env.CHROMIUM, args });
}

// Opens a page from the disk without a network, at rest. Returns it with the messages and requests that it caused.
export async function open(browser, path, { before, ...options } = {}) {
  const viewport = { width: 1000, height: 700 };
  const context = await browser.newContext({ viewport, offline: true, reducedMotion: 'reduce', ...options });
  const page = await context.newPage();
  const messages = [],
    requests = [];
  page.on('console', (message) => messages.push(`${message.type()}: ${message.text()}`));
  page.on('pageerror', (error) => messages.push(`uncaught: ${error.message}`));
  page.on('request', (request) => requests.push(request.url()));
  if (before) await page.addInitScript(before);
  await page.goto(pathToFileURL(path).href);
  if (options.javaScriptEnabled !== false) {
    await page.waitForFunction(() => document.documentElement.dataset.state, null, { timeout: 120_000 });
  }
  return { page, context, messages, requests };
}

// Returns what a page shows of its state.
export function state(page) {
  return page.evaluate(() => ({
    state: document.documentElement.dataset.state,
    message: document.getElementById('message').textContent,
    frame: Number(document.getElementById('frame').value),
    time: document.getElementById('time').textContent,
    play: document.getElementById('play').getAttribute('aria-label'),
  }));
}

// Waits until the page has drawn its state.
export function drawn(page) {
  return page.evaluate(() => new Promise((resolve) => requestAnimationFrame(() => requestAnimationFrame(resolve))));
}

// Returns the pixels of the animation: width, height, and red, green, blue and alpha of each pixel.
export async function pixels(page) {
  await drawn(page);
  const png = await page.locator('#canvas').screenshot();
  // As text, because a list of as many numbers takes many seconds.
  const { width, height, text } = await page.evaluate(async (text) => {
    const bytes = Uint8Array.from(atob(text), (character) => character.charCodeAt(0));
    const image = await createImageBitmap(new Blob([bytes], { type: 'image/png' }));
    const canvas = new OffscreenCanvas(image.width, image.height),
      context = canvas.getContext('2d');
    context.drawImage(image, 0, 0);
    const { data } = context.getImageData(0, 0, image.width, image.height);
    let bytesAsText = '';
    for (let i = 0; i < data.length; i += 4096) bytesAsText += String.fromCharCode(...data.subarray(i, i + 4096));
    return { width: image.width, height: image.height, text: btoa(bytesAsText) };
  }, png.toString('base64'));
  return { width, height, data: Buffer.from(text, 'base64') };
}

// Returns the bounds of the pixels whose color differs from black: smallest and largest x and y.
export function bounds({ width, data }) {
  const box = [Infinity, Infinity, -Infinity, -Infinity];
  for (let i = 0; i < data.length; i += 4) {
    if (data[i] + data[i + 1] + data[i + 2] <= 24) continue;
    const x = (i / 4) % width,
      y = Math.floor(i / 4 / width);
    box[0] = Math.min(box[0], x);
    box[1] = Math.min(box[1], y);
    box[2] = Math.max(box[2], x + 1);
    box[3] = Math.max(box[3], y + 1);
  }
  return box;
}

// Returns the vertices of an OBJ file.
export function vertices(path) {
  const lines = readFileSync(path, 'utf8')
    .split('\n')
    .filter((line) => line.startsWith('v '));
  return lines.map((line) => line.trim().split(/\s+/).slice(1, 4).map(Number));
}

// Returns the bounds of points in the picture of the page, in pixels.
export async function projectedBounds(page, points) {
  const { view, projection, width, height } = await page.evaluate(() => {
    const { camera } = player.views,
      { clientWidth, clientHeight } = document.getElementById('canvas');
    camera.updateMatrixWorld();
    return {
      view: camera.matrixWorldInverse.elements,
      projection: camera.projectionMatrix.elements,
      width: clientWidth,
      height: clientHeight,
    };
  });
  // Matrices are stored by columns.
  const times = (matrix, vector) =>
    [0, 1, 2, 3].map((row) => vector.reduce((sum, x, column) => sum + matrix[4 * column + row] * x, 0));
  const box = [Infinity, Infinity, -Infinity, -Infinity];
  for (const point of points) {
    const [x, y, , w] = times(projection, times(view, [...point, 1]));
    const across = ((x / w + 1) / 2) * width,
      down = ((1 - y / w) / 2) * height;
    box[0] = Math.min(box[0], across);
    box[1] = Math.min(box[1], down);
    box[2] = Math.max(box[2], across);
    box[3] = Math.max(box[3], down);
  }
  return box;
}
