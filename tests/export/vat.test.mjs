// Tests of vertex animation textures in three.js in a browser: decoded in the vertex shader, they give the vertices and the
// picture of the OBJ frames. scripts/test-tools writes the runs to the folder RUNS, and starts these tests. PICTURES is a
// folder for what they draw.

import assert from 'node:assert/strict';
import { readFileSync, writeFileSync } from 'node:fs';
import { dirname, join } from 'node:path';
import { after, before, test } from 'node:test';
import { fileURLToPath } from 'node:url';
import { inflateSync } from 'node:zlib';

import { launch, vertices } from './support.mjs';

const tools = dirname(fileURLToPath(import.meta.url));
const ORIGIN = 'http://supple.test/';
const FRAMES = [0, 1, 17, 40];
const SIZE = 512;

// Returns the numbers of a PNG file of 16 bits, from the top down. A browser would give 8 bits of each.
function decodePng(bytes) {
  let at = 8;
  const data = [];
  const header = bytes.subarray(16, 29);
  const [width, height, depth, kind] = [header.readUInt32BE(0), header.readUInt32BE(4), header[8], header[9]];
  assert.deepEqual([depth, kind], [16, 6]);
  while (at < bytes.length) {
    const length = bytes.readUInt32BE(at);
    if (bytes.toString('latin1', at + 4, at + 8) === 'IDAT') data.push(bytes.subarray(at + 8, at + 8 + length));
    at += length + 12;
  }
  const lines = inflateSync(Buffer.concat(data)),
    stride = 8 * width;
  const pixels = Buffer.alloc(stride * height);
  for (let y = 0; y < height; y++) {
    const filter = lines[y * (stride + 1)];
    for (let x = 0; x < stride; x++) {
      const left = x < 8 ? 0 : pixels[y * stride + x - 8],
        up = y === 0 ? 0 : pixels[(y - 1) * stride + x],
        corner = x < 8 || y === 0 ? 0 : pixels[(y - 1) * stride + x - 8];
      const [a, b, c] = [left, up, corner].map((other) => Math.abs(left + up - corner - other));
      const paeth = a <= b && a <= c ? left : b <= c ? up : corner;
      const predicted = [0, left, up, (left + up) >> 1, paeth][filter];
      pixels[y * stride + x] = lines[y * (stride + 1) + 1 + x] + predicted;
    }
  }
  const numbers = Float32Array.from({ length: 4 * width * height }, (_, i) => pixels.readUInt16BE(2 * i) / 65535);
  return { width, height, bytes: Buffer.from(numbers.buffer) };
}

// What runs in the browser: loads the folder of a body, and decodes it.
const SCRIPT = `
import * as THREE from 'three';
import { GLTFLoader } from 'three/addons/loaders/GLTFLoader.js';
import { EXRLoader } from 'three/addons/loaders/EXRLoader.js';

const read = async (path) => (await fetch(path)).arrayBuffer();
const asText = (numbers) => {
  const bytes = new Uint8Array(numbers.buffer);
  let text = '';
  for (let i = 0; i < bytes.length; i += 4096) text += String.fromCharCode(...bytes.subarray(i, i + 4096));
  return btoa(text);
};

async function texture(path) {
  if (path.endsWith('.exr')) {
    const found = await new EXRLoader().setDataType(THREE.FloatType).loadAsync(path);
    found.minFilter = found.magFilter = THREE.NearestFilter;
    return found;
  }
  const { width, height } = await (await fetch(path + '?size')).json();
  return make(new Float32Array(await read(path)), width, height);
}

function make(numbers, width, height) {
  const texture = new THREE.DataTexture(numbers, width, height, THREE.RGBAFormat, THREE.FloatType);
  texture.minFilter = texture.magFilter = THREE.NearestFilter;
  texture.needsUpdate = true;
  return texture;
}

// The first row of the loader of OpenEXR is the lowest one of the image.
const decodeOf = (encoding) => \`
uniform sampler2D vat, vnrm;
uniform vec3 Min, Max;
uniform float frame, height;
in vec2 uv1;
void decode(inout vec3 point, inout vec3 direction) {
  vec2 at = \${encoding === 'exr' ? 'vec2(uv1.x, 1.0 - uv1.y - frame / height)' : 'uv1 + vec2(0.0, frame / height)'};
  vec3 o = mix(Min, Max, texture(vat, at).xyz);
  vec3 n = 2.0 * texture(vnrm, at).xyz - 1.0;
  point += vec3(o.x, o.z, -o.y);
  direction = vec3(n.x, n.z, -n.y);
}
\`;

window.start = async (folder, encoding, size) => {
  const DECODE = decodeOf(encoding);
  const canvas = document.createElement('canvas');
  document.body.append(canvas);
  const renderer = new THREE.WebGLRenderer({ canvas, preserveDrawingBuffer: true });
  renderer.setSize(size, size, false);
  const gltf = await new GLTFLoader().parseAsync(await read(folder + 'bust.glb'), '');
  const meshes = [];
  gltf.scene.traverse((object) => object.isMesh && meshes.push(object));
  const geometry = meshes[0].geometry, count = geometry.attributes.position.count;
  const info = JSON.parse(new TextDecoder().decode(await read(folder + 'bust-remap_info.json')))['os-remap'];
  const [vat, vnrm] = [await texture(folder + 'bust_vat.' + encoding), await texture(folder + 'bust_vnrm.' + encoding)];
  const uniforms = {
    vat: { value: vat }, vnrm: { value: vnrm }, frame: { value: 0 }, height: { value: vat.image.height },
    Min: { value: new THREE.Vector3(...info.Min) }, Max: { value: new THREE.Vector3(...info.Max) },
  };
  const shaded = \`
    in vec3 lit;
    out vec4 color;
    void main() { vec3 n = normalize(lit); color = vec4(0.55 + 0.4 * n, 1.0); }
  \`;
  const material = (decode) => new THREE.ShaderMaterial({
    glslVersion: THREE.GLSL3, uniforms, side: THREE.DoubleSide, fragmentShader: shaded,
    vertexShader: DECODE + \`
      out vec3 lit;
      void main() {
        vec3 point = position, direction = normal;
        \${decode ? 'decode(point, direction);' : ''}
        lit = direction;
        gl_Position = projectionMatrix * modelViewMatrix * vec4(point, 1.0);
      }\`,
  });
  const first = new Float32Array(geometry.attributes.position.array);

  // Draws each vertex to a pixel of numbers, and reads them.
  const width = 256, height = Math.ceil(count / width);
  const target = new THREE.WebGLRenderTarget(width, height, { type: THREE.FloatType, depthBuffer: false });
  const numbers = (frame, which) => {
    uniforms.frame.value = frame;
    const points = new THREE.Points(geometry, new THREE.ShaderMaterial({
      glslVersion: THREE.GLSL3, uniforms,
      vertexShader: DECODE + \`
        out vec3 number;
        void main() {
          vec3 point = position, direction = normal;
          decode(point, direction);
          number = \${which};
          vec2 at = vec2(gl_VertexID % \${width}, gl_VertexID / \${width}) + 0.5;
          gl_Position = vec4(2.0 * at / vec2(\${width}, \${height}) - 1.0, 0.0, 1.0);
          gl_PointSize = 1.0;
        }\`,
      fragmentShader: 'in vec3 number; out vec4 color; void main() { color = vec4(number, 1.0); }',
      depthTest: false,
    }));
    // All vertices, not the corners of the triangles.
    points.geometry = geometry.clone().setIndex(null);
    points.frustumCulled = false;
    const scene = new THREE.Scene().add(points), found = new Float32Array(4 * width * height);
    renderer.setRenderTarget(target);
    renderer.render(scene, new THREE.Camera());
    renderer.readRenderTargetPixels(target, 0, 0, width, height, found);
    renderer.setRenderTarget(null);
    return asText(found.slice(0, 4 * count));
  };

  // Draws a frame of the textures, or points with normals, and returns the pixels and a PNG file.
  const camera = new THREE.PerspectiveCamera(40, 1, 0.1, 100);
  const draw = (frame, points) => {
    uniforms.frame.value = frame;
    const shown = geometry.clone();
    if (points) {
      shown.setAttribute('position', new THREE.BufferAttribute(new Float32Array(points), 3));
      shown.computeVertexNormals();
    }
    const mesh = new THREE.Mesh(shown, material(!points));
    mesh.frustumCulled = false;
    const box = new THREE.Box3().setFromBufferAttribute(geometry.attributes.position);
    const center = box.getCenter(new THREE.Vector3()), extent = box.getSize(new THREE.Vector3()).length();
    camera.position.copy(center).add(new THREE.Vector3(0.5, 0.3, 1.4).multiplyScalar(extent));
    camera.lookAt(center);
    const scene = new THREE.Scene().add(mesh);
    renderer.render(scene, camera);
    const gl = renderer.getContext(), pixels = new Uint8Array(4 * size * size);
    gl.readPixels(0, 0, size, size, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
    return { pixels: asText(pixels), png: canvas.toDataURL('image/png') };
  };
  window.player = { numbers, draw };
  return { ...info, points: asText(first), has: meshes.length };
};
window.ready = true;
`;

const PAGE = `<!doctype html><script type="importmap">{"imports": {
  "three": "/node_modules/three/build/three.module.js",
  "three/addons/": "/node_modules/three/examples/jsm/"
}}</script><script type="module" src="/script.mjs"></script>`;

let browser;
before(async () => (browser = await launch()));
after(() => browser?.close());

// Opens a page that reads the files of a run.
async function open(run) {
  const page = await browser.newPage();
  page.on('pageerror', (error) => console.error(error.message));
  page.on('console', (message) => message.type() === 'error' && console.error(message.text()));
  await page.route(`${ORIGIN}**`, (route) => {
    const { pathname, search } = new URL(route.request().url());
    if (pathname === '/') return route.fulfill({ body: PAGE, contentType: 'text/html' });
    if (pathname === '/script.mjs') return route.fulfill({ body: SCRIPT, contentType: 'text/javascript' });
    if (pathname.startsWith('/node_modules/')) return route.fulfill({ path: join(tools, pathname) });
    const bytes = readFileSync(join(process.env.RUNS, run, pathname));
    if (!pathname.endsWith('.png')) return route.fulfill({ body: bytes });
    const { width, height, bytes: numbers } = decodePng(bytes);
    return route.fulfill({ body: search ? JSON.stringify({ width, height }) : numbers });
  });
  await page.goto(ORIGIN);
  await page.waitForFunction(() => window.ready);
  return page;
}

const floats = (text) => {
  const bytes = Buffer.from(text, 'base64');
  return new Float32Array(bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.byteLength));
};

// Half a step of 16 bits; numbers with a floating point of 24 bits are rounded as those of the shader, see below.
for (const [run, encoding, step] of [
  ['export', 'png', 0.5 / 65535],
  ['export_exr', 'exr', 0],
]) {
  test(`three.js decodes textures in ${encoding} to the vertices and the picture of the frames`, async () => {
    const page = await open(run);
    const { Min, Max, Frames, points, has } = await page.evaluate(
      ([encoding, size]) => window.start('/bust_vat/', encoding, size),
      [encoding, SIZE],
    );
    assert.deepEqual([Frames, has], [41, 1]);
    const frame = (number) =>
      vertices(join(process.env.RUNS, run, `bust_${String(number).padStart(4, '0')}.obj`));
    // The vertices of the mesh file are those of the first frame, some of them several times.
    const first = floats(points),
      count = first.length / 3;
    const key = (point) => Array.from(point, (number) => Math.fround(number) + 0).join();
    const places = new Map();
    frame(0).forEach((point, index) => places.set(key(point), [...(places.get(key(point)) ?? []), index]));
    const indices = Array.from({ length: count }, (_, vertex) => {
      const found = places.get(key(first.subarray(3 * vertex, 3 * vertex + 3)));
      assert.equal(found?.length, 1, `vertex ${vertex}`);
      return found[0];
    });
    assert.equal(new Set(indices).size, frame(0).length);
    // From Blender's axes.
    const low = [Min[0], Min[2], -Max[1]],
      high = [Max[0], Max[2], -Min[1]];
    for (const number of FRAMES) {
      const [found, normals] = await page.evaluate(
        (number) => [window.player.numbers(number, 'point'), window.player.numbers(number, 'direction')],
        number,
      );
      const [decoded, directions, expected] = [floats(found), floats(normals), frame(number)];
      for (let vertex = 0; vertex < count; vertex++) {
        for (let axis = 0; axis < 3; axis++) {
          const place = expected[indices[vertex]][axis];
          const error = Math.abs(decoded[4 * vertex + axis] - place);
          // About eight numbers of 24 bits are rounded on the way, none of them larger than this sum.
          const sizes = Math.abs(low[axis]) + Math.abs(high[axis]) + Math.abs(place) + high[axis] - low[axis];
          const largest = step * (high[axis] - low[axis]) + 8 * 2 ** -24 * sizes;
          assert.ok(error <= largest, `frame ${number}, vertex ${vertex}: ${error} > ${largest}`);
        }
        const length = Math.hypot(...directions.subarray(4 * vertex, 4 * vertex + 3));
        // Each number has twice the error of its texel.
        assert.ok(Math.abs(length - 1) <= 2 * Math.sqrt(3) * step + 1e-6, `frame ${number}: ${length}`);
      }

      const flat = indices.flatMap((index) => expected[index]);
      const [vat, mesh] = await page.evaluate(
        ([number, flat]) => [window.player.draw(number), window.player.draw(number, flat)],
        [number, flat],
      );
      if (process.env.PICTURES) {
        for (const [name, { png }] of Object.entries({ vat, mesh }))
          writeFileSync(
            join(process.env.PICTURES, `${encoding}_${name}_${number}.png`),
            Buffer.from(png.split(',')[1], 'base64'),
          );
      }
      const [ours, theirs] = [vat, mesh].map(({ pixels }) => Buffer.from(pixels, 'base64'));
      let covered = 0,
        different = 0,
        shade = 0;
      for (let at = 0; at < ours.length; at += 4) {
        const [inOurs, inTheirs] = [ours, theirs].map((pixels) => pixels[at] + pixels[at + 1] + pixels[at + 2] > 0);
        different += inOurs !== inTheirs;
        if (!inOurs || !inTheirs) continue;
        covered++;
        for (const channel of [0, 1, 2]) shade += Math.abs(ours[at + channel] - theirs[at + channel]) / 3;
      }
      assert.ok(covered > 0.05 * SIZE ** 2, `${covered} pixels`);
      // A border passes a pixel's center at most where it is nearer than the error, a ten-thousandth of a pixel.
      assert.ok(different <= 4, `frame ${number}: ${different} pixels of the outline differ`);
      // The normals of the mesh are those of its triangles: the same but for their weights. A turned axis gives 40.
      assert.ok(shade / covered < 4, `frame ${number}: the shade differs by ${shade / covered} of 255`);
    }
    // Another frame has another picture.
    const [early, late] = await page.evaluate(() => [0, 40].map((number) => window.player.draw(number).pixels));
    assert.notEqual(early, late);
    await page.close();
  });
}
